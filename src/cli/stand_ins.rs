//! Objects that stand for others: hulls to collide with, and lower levels of detail.

use std::path::Path;

use thallus::run::shell_path;
use thallus::substrate::Texturing;

use super::bake_where::listed;

/// Says so where a mesh has such objects beside others: they lie over what they stand for, and lichen grows on both.
pub(super) fn warning(texturing: &Texturing) -> Option<String> {
    let mut names: Vec<String> = Vec::new();
    let mut others = false;
    for part in &texturing.parts {
        match part.objects.iter().find(|name| stands_in(name)) {
            Some(name) if !names.contains(name) => names.push(name.clone()),
            Some(_) => {}
            None => others = true,
        }
    }
    (others && !names.is_empty()).then(|| told(&names))
}

fn told(names: &[String]) -> String {
    let mask = format!("object:!{}", names.join(","));
    let mask = match names.iter().any(|name| name.contains(',')) {
        true => "object:!NAME".to_owned(),
        false => shell_path(Path::new(&mask)),
    };
    let are = if names.len() == 1 { "is" } else { "are" };
    format!(
        "{} {are} called as hulls to collide with or lower levels of detail are, and lichen grows on them too: keep it \
         off with --mask {}",
        listed(names),
        mask
    )
}

/// By the names that Unreal (`UCX_Rock`), Godot (`Rock-colonly`) and Unity (`Rock_LOD1`) go by.
fn stands_in(name: &str) -> bool {
    const HULLS: [&str; 4] = ["UCX_", "UBX_", "USP_", "UCP_"];
    const ENDS: [&str; 2] = ["-colonly", "-convcolonly"];
    let is_lower = |(_, level): (&str, &str)| level.parse().is_ok_and(|level: u8| level > 0);
    HULLS.iter().any(|hull| name.starts_with(hull))
        || ENDS.iter().any(|end| name.ends_with(end))
        || name
            .to_uppercase()
            .rsplit_once("_LOD")
            .is_some_and(is_lower)
}

#[cfg(test)]
mod tests {
    use thallus::substrate::Part;

    use super::*;

    fn of(names: &[&str]) -> Option<String> {
        let part = |name: &&str| Part {
            objects: vec![(*name).to_owned()],
            ..Part::default()
        };
        warning(&Texturing {
            parts: names.iter().map(part).collect(),
            ..Texturing::default()
        })
    }

    #[test]
    fn objects_that_stand_for_others_are_named() {
        let said = of(&["Rock_LOD0", "Rock_LOD1", "UCX_Rock", "Rock_LOD1"]).unwrap();
        assert!(
            said.starts_with("'Rock_LOD1', 'UCX_Rock' are called"),
            "{said}"
        );
        let others = shell_path(Path::new("object:!Rock_LOD1,UCX_Rock"));
        assert!(said.ends_with(&format!("--mask {others}")), "{said}");
        let said = of(&["Rock", "rock_lod2"]).unwrap();
        assert!(said.starts_with("'rock_lod2' is called"), "{said}");
        assert!(of(&["Wall", "Wall-colonly"]).is_some());
        assert_eq!(
            of(&["Rock_LOD0", "Moss", "LOD", "Rock_LOD", "Wall-col"]),
            None
        );
        assert_eq!(
            of(&["Rock_LOD1", "UCX_Rock"]),
            None,
            "there is nothing else"
        );
    }
}
