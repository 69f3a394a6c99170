//! Where lichen is that is in no map.

use std::path::Path;

use thallus::run::shell_path;
use thallus::substrate::{Part, Substrate, Texturing};

/// What triangles of a mesh are part of, by the names that a mask takes.
pub(super) struct Where {
    kind: &'static str,
    /// Each once.
    names: Vec<String>,
    /// Whether there are others.
    leaves_some: bool,
}

/// Names that are told; of more only that there are.
const MOST: usize = 4;

impl Where {
    /// Of some triangles of a substrate: their objects, or if these are all there are, their materials.
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
        let object = |part: &Part| part.objects.first().cloned();
        let material = |part: &Part| part.material.clone();
        let with = |kind, name: &dyn Fn(&Part) -> Option<String>| {
            let all = texturing.parts.iter().zip(&of);
            let names = |on: bool| {
                let parts = all.clone().filter(move |(_, is)| **is == on);
                distinct(parts.filter_map(|(part, _)| name(part)))
            };
            let (names, others) = (names(true), names(false));
            let leaves_some = others.iter().any(|other| !names.contains(other));
            Self {
                kind,
                names,
                leaves_some,
            }
        };
        let of_objects = with("object", &object);
        match of_objects.leaves_some {
            true => of_objects,
            false => Some(with("material", &material))
                .filter(|of_materials| of_materials.leaves_some)
                .unwrap_or(of_objects),
        }
    }

    /// Where that is, and how to keep lichen off there.
    pub(super) fn told(&self) -> String {
        let Self {
            kind,
            names,
            leaves_some,
        } = self;
        if names.is_empty() {
            return "it is on triangles without names".to_owned();
        }
        let plural = if names.len() == 1 { "" } else { "s" };
        let told = format!("it is on the {kind}{plural} {}", listed(names));
        if !leaves_some || names.len() > MOST || names.iter().any(|name| name.contains(',')) {
            return told;
        }
        let mask = format!("{kind}:!{}", names.join(","));
        let mask = shell_path(Path::new(&mask));
        format!("{told} (grow it anew with --mask {mask} to keep it off there)")
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
