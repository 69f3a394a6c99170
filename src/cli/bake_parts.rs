//! The parts of a mesh that `thallus bake` makes maps of.

use std::collections::HashSet;

use thallus::bake::{BakeError, Baked, Baker};
use thallus::substrate::{Division, Selection, Texturing};

use super::bake_args::{BakeArgs, Each};

/// Triangles that have maps of their own.
pub(crate) struct MapPart {
    /// What the part is called; nothing where all that is asked for is in the same maps.
    pub(crate) name: Option<String>,
    /// What its material is called.
    pub(crate) material: String,
    /// Which triangles of the file; all where nothing is said.
    pub(crate) chosen: Option<Vec<bool>>,
    /// What names of its files begin with, and what stands before their extension.
    affixes: [String; 2],
}

/// The parts that are asked for, none of them without triangles.
pub(crate) fn parts(args: &BakeArgs, texturing: &Texturing) -> anyhow::Result<Vec<MapPart>> {
    let only = chosen(&args.only, texturing)?;
    let Some(each) = args.each else {
        return Ok(vec![MapPart {
            name: None,
            material: "lichened".to_owned(),
            chosen: only,
            affixes: Default::default(),
        }]);
    };
    let division = match each {
        Each::Material => Division::by_material(texturing),
        Each::Object => Division::by_object(texturing),
        Each::Tile => Ok(Division::by_tile(texturing)),
    };
    let division = division?;
    let mut taken = HashSet::new();
    let part = |(part, name): (usize, &String)| {
        let mut chosen = division.chosen(part);
        if let Some(only) = &only {
            chosen
                .iter_mut()
                .zip(only)
                .for_each(|(chosen, only)| *chosen &= *only);
        }
        chosen.contains(&true).then(|| MapPart {
            name: Some(name.clone()),
            material: name.clone(),
            affixes: affixes(each, name, &mut taken),
            chosen: Some(chosen),
        })
    };
    let parts: Vec<MapPart> = { division.names().iter().enumerate() }
        .filter_map(part)
        .collect();
    match parts.is_empty() {
        true => Err(BakeError::NoUvs.into()),
        false => Ok(parts),
    }
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

/// As programs look for them: `brick_normal.png`, and of tiles `normal.1001.png`.
fn affixes(each: Each, name: &str, taken: &mut HashSet<String>) -> [String; 2] {
    match each {
        Each::Tile => [String::new(), format!(".{name}")],
        _ => [format!("{}_", file_stem(name, taken)), String::new()],
    }
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
