//! Where lichen is that is in no map.

use std::path::Path;

use thallus::run::shell_path;
use thallus::substrate::{Part, Substrate, Texturing};

/// What triangles of a mesh are part of, by the names that a mask takes.
pub(super) struct Where {
    kind: &'static str,
    /// Each once.
    names: Vec<String>,
}

/// Names that are told; of more only that there are.
const MOST: usize = 4;

impl Where {
    /// Of some triangles of a substrate: their objects, or where these have no names, their materials.
    pub(super) fn of(
        (substrate, texturing): (&Substrate, &Texturing),
        triangles: impl Iterator<Item = u32>,
    ) -> Self {
        let mut of = vec![false; texturing.parts.len()];
        for triangle in triangles {
            let source = substrate.source_triangle(triangle) as usize;
            let part = texturing.part_of.get(source).copied().flatten();
            part.into_iter().for_each(|part| of[part as usize] = true);
        }
        let parts = || texturing.parts.iter().zip(&of).filter(|(_, is)| **is);
        let object = |(part, _): (&Part, _)| part.objects.first().cloned();
        let material = |(part, _): (&Part, _)| part.material.clone();
        let objects = distinct(parts().filter_map(object));
        match objects.is_empty() {
            false => Self {
                kind: "object",
                names: objects,
            },
            true => Self {
                kind: "material",
                names: distinct(parts().filter_map(material)),
            },
        }
    }

    /// Where that is, and how to keep lichen off there.
    pub(super) fn told(&self) -> String {
        let Self { kind, names } = self;
        if names.is_empty() {
            return "it is on triangles without names".to_owned();
        }
        let some = names[..names.len().min(MOST)].join(",");
        let mask = shell_path(Path::new(&format!("{kind}:!{some}")));
        let plural = if names.len() == 1 { "" } else { "s" };
        let names = listed(names);
        format!(
            "it is on the {kind}{plural} {names} (grow it anew with --mask {mask} to keep it off there)"
        )
    }
}

/// Some names, and how many more there are.
pub(super) fn listed(names: &[String]) -> String {
    let some = names[..names.len().min(MOST)].join("', '");
    match names.len().saturating_sub(MOST) {
        0 => format!("'{some}'"),
        more => format!("'{some}' and {more} more"),
    }
}

fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}
