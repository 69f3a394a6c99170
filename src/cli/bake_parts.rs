//! The parts of a mesh that `thallus bake` makes maps of.

use std::collections::HashSet;

use thallus::bake::{BakeError, Baked, Baker};
use thallus::substrate::{Division, Selection, Texturing};

use super::bake_args::{BakeArgs, Each};

/// Triangles that have maps of their own.
#[derive(Clone)]
pub(crate) struct MapPart {
    /// What the part is called; nothing where all that is asked for is in the same maps.
    pub(crate) name: Option<String>,
    /// What its material is called.
    pub(crate) material: String,
    /// Which triangles of the file; all where nothing is said.
    pub(crate) chosen: Option<Vec<bool>>,
    /// What names of its files begin with, and what stands before their extension: `brick_normal.png`, and of tiles
    /// `normal.1001.png`, as programs look for them.
    affixes: [String; 2],
}

/// The parts that are asked for, none of them without triangles.
pub(crate) fn parts(args: &BakeArgs, texturing: &Texturing) -> anyhow::Result<Vec<MapPart>> {
    let only = chosen(&args.only, texturing)?;
    let whole = || MapPart {
        name: None,
        material: "lichened".to_owned(),
        chosen: None,
        affixes: Default::default(),
    };
    if args.each.is_empty() {
        return Ok(vec![MapPart {
            chosen: only,
            ..whole()
        }]);
    }
    let named = named(&args.each, texturing)?;
    let tiles = { args.each.contains(&Each::Tile) }.then(|| Division::by_tile(texturing));
    let mut parts = divided(vec![whole()], named.as_ref(), |part, name, taken| {
        part.affixes[0] = format!("{}_", file_stem(name, taken));
    });
    parts = divided(parts, tiles.as_ref(), |part, name, _| {
        part.affixes[1] = format!(".{name}");
    });
    if let Some(only) = only {
        parts.iter_mut().for_each(|part| part.narrow(&only));
        parts.retain(|part| {
            part.chosen
                .as_ref()
                .is_some_and(|chosen| chosen.contains(&true))
        });
    }
    match parts.is_empty() {
        true => Err(BakeError::NoUvs.into()),
        false => Ok(parts),
    }
}

/// By objects, by materials, or by both.
fn named(each: &[Each], texturing: &Texturing) -> anyhow::Result<Option<Division>> {
    let objects = { each.contains(&Each::Object) }.then(|| Division::by_object(texturing));
    let materials = { each.contains(&Each::Material) }.then(|| Division::by_material(texturing));
    Ok(match (objects.transpose()?, materials.transpose()?) {
        (Some(objects), Some(materials)) => Some(objects.and(&materials)),
        (objects, materials) => objects.or(materials),
    })
}

/// The parts of parts, if these are divided further.
fn divided(
    parts: Vec<MapPart>,
    by: Option<&Division>,
    call: impl Fn(&mut MapPart, &str, &mut HashSet<String>),
) -> Vec<MapPart> {
    let Some(division) = by else {
        return parts;
    };
    let mut taken = HashSet::new();
    let mut divided = Vec::new();
    for whole in &parts {
        for (number, name) in division.names().iter().enumerate() {
            let mut part = whole.clone();
            part.narrow(&division.chosen(number));
            if part
                .chosen
                .as_ref()
                .is_some_and(|chosen| chosen.contains(&true))
            {
                let full = part
                    .name
                    .map_or(name.clone(), |first| format!("{first} {name}"));
                (part.material, part.name) = (full.clone(), Some(full));
                call(&mut part, name, &mut taken);
                divided.push(part);
            }
        }
    }
    divided
}

/// How to give each of a part's materials or objects maps of its own, where it has several and that is not asked for.
pub(crate) fn how_to_divide(
    part: &MapPart,
    each: &[Each],
    texturing: &Texturing,
) -> Option<String> {
    let kinds = [
        (Each::Material, "material", Division::by_material(texturing)),
        (Each::Object, "object", Division::by_object(texturing)),
    ];
    let mut missing = { kinds.into_iter() }.filter(|(kind, ..)| !each.contains(kind));
    missing.find_map(|(_, kind, division)| {
        let several = division.ok()?.count_in(part.chosen.as_deref());
        let too = if each.is_empty() { "" } else { " too" };
        (several > 1).then(|| {
            format!(
                "where each of its {several} {kind}s has a layout of its own, --each {kind}{too} gives each its maps, and \
                 --only {kind}:NAME makes those of one (thallus check names them)"
            )
        })
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

/// Letters of a file's name that are taken from a part's.
const MOST_LETTERS: usize = 80;

/// A name that every file system has room for, and that no other part has, in whatever case.
fn file_stem(name: &str, taken: &mut HashSet<String>) -> String {
    let plain = |c: char| match c.is_alphanumeric() || "-._".contains(c) {
        true => c,
        false => '_',
    };
    let stem: String = name.chars().take(MOST_LETTERS).map(plain).collect();
    let stem = match stem.starts_with('.') || stem.is_empty() {
        true => format!("_{stem}"),
        false => stem,
    };
    let numbered = (2..).map(|n| format!("{stem}_{n}"));
    let mut names = std::iter::once(stem.clone()).chain(numbered);
    names
        .find(|name| taken.insert(name.to_lowercase()))
        .unwrap_or(stem)
}

impl MapPart {
    /// To what is also among these.
    fn narrow(&mut self, to: &[bool]) {
        match &mut self.chosen {
            None => self.chosen = Some(to.to_vec()),
            Some(chosen) => { chosen.iter_mut().zip(to) }.for_each(|(chosen, to)| *chosen &= *to),
        }
    }

    /// Of its file for a map.
    pub(crate) fn file_name(&self, map: &str, extension: &str) -> String {
        let [first, last] = &self.affixes;
        format!("{first}{map}{last}.{extension}")
    }

    /// Bakes it.
    pub(crate) fn bake<'a>(&'a self, baker: &'a Baker) -> Result<Baked<'a>, BakeError> {
        match &self.chosen {
            None => baker.whole(),
            Some(chosen) => baker.part(chosen),
        }
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
        assert!(long.len() < 200, "{}", long.len());
    }
}
