//! The parts of a mesh that `thallus bake` makes maps of.

use std::collections::{HashMap, HashSet};

use thallus::bake::{BakeError, MAPS};
use thallus::substrate::{Division, Selection, Texturing};

use super::bake_args::{BakeArgs, Each};

/// The parts of a mesh that are asked for.
pub(crate) struct Parts {
    /// Nothing where all that is asked for is in the same maps.
    division: Option<Division>,
    /// Which triangles of the file; all where nothing is said.
    only: Option<Vec<bool>>,
    list: Vec<MapPart>,
}

/// Triangles that have maps of their own.
pub(crate) struct MapPart {
    /// Its place in the division.
    number: usize,
    /// What it is called; nothing where it is all that is asked for.
    pub(crate) name: Option<String>,
    /// What its material is called: nothing where what it was before has several names, or none.
    pub(crate) material: Option<String>,
    /// What names of its files begin with, and what stands before their extension: `brick_normal.png`, and of tiles
    /// `normal.1001.png`, as programs look for them.
    affixes: [String; 2],
}

/// Parts that have maps in one call.
pub(super) const MOST_PARTS: usize = 1000;

impl Parts {
    /// None of them without triangles.
    pub(crate) fn of(args: &BakeArgs, texturing: &Texturing) -> anyhow::Result<Self> {
        let only = chosen(&args.only, texturing)?;
        let named = named(&args.each, texturing)?;
        let tiles = args
            .each
            .contains(&Each::Tile)
            .then(|| Division::by_tile(texturing));
        let division = match (&named, &tiles) {
            (Some(named), Some(tiles)) => Some(named.and(tiles)),
            (named, tiles) => named.clone().or(tiles.clone()),
        };
        let list = match &division {
            None => vec![MapPart::whole(only_material(texturing, only.as_deref()))],
            Some(division) => listed(division, only.as_deref(), [named, tiles])?,
        };
        Ok(Self {
            division,
            only,
            list,
        })
    }

    pub(crate) fn list(&self) -> &[MapPart] {
        &self.list
    }

    /// What the file calls a part, if that is one name.
    pub(crate) fn own_name(&self, part: &MapPart) -> Option<&str> {
        self.division.as_ref()?.own_name(part.number)
    }

    /// The triangles of the file that are in a part; nothing where all are.
    pub(crate) fn chosen(&self, part: &MapPart) -> Option<Vec<bool>> {
        let Some(division) = &self.division else {
            return self.only.clone();
        };
        let mut chosen = division.chosen(part.number);
        if let Some(only) = &self.only {
            chosen
                .iter_mut()
                .zip(only)
                .for_each(|(chosen, only)| *chosen &= *only);
        }
        Some(chosen)
    }
}

/// The parts of a division among some triangles, by what they are called: by objects and materials, and by tiles.
fn listed(
    division: &Division,
    only: Option<&[bool]>,
    [named, tiles]: [Option<Division>; 2],
) -> anyhow::Result<Vec<MapPart>> {
    let firsts = division.firsts(only).into_iter().enumerate();
    let there: Vec<(usize, usize)> = firsts.filter_map(|(i, first)| Some((i, first?))).collect();
    match there.len() {
        0 => return Err(BakeError::NoUvs.into()),
        parts if parts > MOST_PARTS => anyhow::bail!(
            "the mesh has {parts} parts of that kind, and {MOST_PARTS} have maps at once: choose some with --only"
        ),
        _ => {}
    }
    let (mut taken, mut stems) = (HashSet::new(), HashMap::new());
    let part = |(number, first): (usize, usize)| {
        let name = &division.names()[number];
        let named = named.as_ref().and_then(|named| named.name_of(first));
        let stem = named.map(|named| {
            let stem = stems.entry(named.to_owned());
            format!("{}_", stem.or_insert_with(|| file_stem(named, &mut taken)))
        });
        let tile = tiles.as_ref().and_then(|tiles| tiles.name_of(first));
        MapPart {
            number,
            name: Some(name.clone()),
            material: Some(name.clone()),
            affixes: [
                stem.unwrap_or_default(),
                tile.map_or(String::new(), |tile| format!(".{tile}")),
            ],
        }
    };
    Ok(there.into_iter().map(part).collect())
}

/// By objects, by materials, or by both.
fn named(each: &[Each], texturing: &Texturing) -> anyhow::Result<Option<Division>> {
    let objects = each
        .contains(&Each::Object)
        .then(|| Division::by_object(texturing));
    let materials = each
        .contains(&Each::Material)
        .then(|| Division::by_material(texturing));
    Ok(match (objects.transpose()?, materials.transpose()?) {
        (Some(objects), Some(materials)) => Some(objects.and(&materials)),
        (objects, materials) => objects.or(materials),
    })
}

/// The triangles that are in all of some selections; nothing where there is none of these.
fn chosen(all: &[Selection], texturing: &Texturing) -> anyhow::Result<Option<Vec<bool>>> {
    let chosen: Result<Vec<_>, _> = all.iter().map(|only| only.triangles(texturing)).collect();
    let both = |a: Vec<bool>, b: Vec<bool>| a.iter().zip(b).map(|(a, b)| *a && b).collect();
    let chosen = chosen?.into_iter().reduce(both);
    if chosen
        .as_ref()
        .is_some_and(|chosen| !chosen.contains(&true))
    {
        let names: Vec<String> = all.iter().map(Selection::to_string).collect();
        anyhow::bail!(
            "no triangle of the mesh is in all of '{}'",
            names.join("', '")
        );
    }
    Ok(chosen)
}

/// Bytes of a file's name that are taken from a part's: names end at 255 on most systems.
const MOST_BYTES: usize = 80;

/// What names of a part's files begin with: so that every file system takes them, and that none is another part's, in
/// whatever case.
fn file_stem(name: &str, taken: &mut HashSet<String>) -> String {
    let mut stem = plain(name);
    stem.truncate(stem.floor_char_boundary(MOST_BYTES));
    if stem.starts_with('.') || stem.is_empty() {
        stem.insert(0, '_');
    }
    let numbered = (2..).map(|n| format!("{stem}_{n}"));
    let files = |stem: &str| {
        let names = MAPS.iter().map(|map| format!("{stem}_{}", map.name));
        names.map(|name| name.to_lowercase()).collect::<Vec<_>>()
    };
    let is_free = |stem: &String| files(stem).iter().all(|name| !taken.contains(name));
    let mut names = std::iter::once(stem.clone()).chain(numbered);
    let found = names.find(is_free).unwrap_or(stem);
    taken.extend(files(&found));
    found
}

/// A name that programs and file systems take.
pub(super) fn plain(name: &str) -> String {
    let plain = |c: char| match c.is_alphanumeric() || "-._".contains(c) {
        true => c,
        false => '_',
    };
    name.chars().map(plain).collect()
}

/// The name of the material of some triangles, or of all, where all have one of that name.
fn only_material(texturing: &Texturing, chosen: Option<&[bool]>) -> Option<String> {
    let division = Division::by_material(texturing).ok()?;
    let firsts = division.firsts(chosen).into_iter().enumerate();
    let mut names = firsts.filter_map(|(part, first)| first.map(|_| division.own_name(part)));
    let first = names.next()??;
    names
        .all(|name| name == Some(first))
        .then(|| first.to_owned())
}

impl MapPart {
    /// All that is asked for, of a material.
    fn whole(material: Option<String>) -> Self {
        Self {
            number: 0,
            name: None,
            material,
            affixes: Default::default(),
        }
    }

    /// What names of its images begin and end with, in the file of a mesh of this name.
    pub(crate) fn image_affixes(&self, mesh: &str) -> [String; 2] {
        let [first, last] = &self.affixes;
        [format!("{}_{first}", plain(mesh)), last.clone()]
    }

    /// Of its file for a map.
    pub(crate) fn file_name(&self, map: &str, extension: &str) -> String {
        let [first, last] = &self.affixes;
        format!("{first}{map}{last}.{extension}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_plain_and_differ() {
        let mut taken = HashSet::new();
        let names = [
            "Brick wall",
            "brick/wall",
            "Stein-ä.001",
            "..",
            "",
            "BRICK:WALL",
        ];
        let stems = names.map(|name| file_stem(name, &mut taken));
        let expected = [
            "Brick_wall",
            "brick_wall_2",
            "Stein-ä.001",
            "_..",
            "_",
            "BRICK_WALL_3",
        ];
        assert_eq!(stems, expected);
        let long = file_stem(&"ü".repeat(1000), &mut taken);
        assert!((79..=80).contains(&long.len()), "{}", long.len());
        let mut taken = HashSet::new();
        let stems = ["Rock", "Rock base"].map(|name| file_stem(name, &mut taken));
        assert_eq!(
            stems,
            ["Rock", "Rock_base_2"],
            "both would have Rock_base_color.png"
        );
    }
}
