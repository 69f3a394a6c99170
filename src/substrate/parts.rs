//! What a mesh file calls its parts, objects and materials, and choices of triangles by these names.

use std::collections::HashMap;
use std::fmt;
use std::str::FromStr;

use super::Texturing;

/// What some triangles of a file are part of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// What their object is called: by a node and a mesh of glTF and the nodes above, by `o` and `g` of OBJ.
    pub objects: Vec<String>,
    /// Whether the first of these is the name of their object itself, or of its mesh, and not of a node above.
    pub has_own_name: bool,
    /// What their material is called.
    pub material: Option<String>,
    /// Where the x, y and z axis and the origin of their object are, in the units and axes of the file: the columns of
    /// the matrix of a node of glTF.
    pub frame: Option<[[f64; 3]; 4]>,
}

/// Which of its names a triangle is chosen by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum By {
    Object,
    Material,
}

/// Triangles of a file by the names of their objects or materials: `material:Bark` chooses those of one,
/// `object:Rock,Stone*` those of several, with `*` for whatever letters, and `material:!Leaves` all but those of one.
/// Text that is a name as it stands, commas, stars and spaces included, chooses that name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    by: By,
    /// What stands after the colon.
    text: String,
}

/// What a selection says of a file's names.
struct Chosen<'a> {
    is_others: bool,
    wanted: Wanted<'a>,
}

/// Which names are meant.
enum Wanted<'a> {
    One(&'a str),
    Like(Vec<&'a str>),
}

/// Why triangles cannot be chosen.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SelectionError {
    /// It is not written as one.
    #[error(
        "'{0}' chooses no triangles: write object:NAME or material:NAME, several names with commas between, * for whatever \
         letters, and ! before the first for all but these"
    )]
    Unreadable(String),
    /// Nothing to choose by.
    #[error("the mesh's file names no {kind}s, {}", instead(.kind, .others))]
    NoNames {
        /// Object or material.
        kind: &'static str,
        /// The other names that there are.
        others: String,
    },
    /// Nothing of that name.
    #[error("the mesh has no {kind} called '{name}': it has {there}")]
    NoSuch {
        /// Object or material.
        kind: &'static str,
        /// What was asked for.
        name: String,
        /// What there is.
        there: String,
    },
    /// All were left out.
    #[error("'{0}' leaves no triangle of the mesh")]
    Nothing(String),
}

impl By {
    const ALL: [Self; 2] = [Self::Object, Self::Material];

    fn other(self) -> Self {
        match self {
            Self::Object => Self::Material,
            Self::Material => Self::Object,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Material => "material",
        }
    }

    pub(super) fn names(self, part: &Part) -> &[String] {
        match self {
            Self::Object => &part.objects,
            Self::Material => part.material.as_slice(),
        }
    }
}

impl SelectionError {
    /// Of a file that names nothing of this kind.
    pub(super) fn no_names(texturing: &Texturing, by: By) -> Self {
        Self::NoNames {
            kind: by.word(),
            others: listed(&texturing.names_by(by.other())),
        }
    }
}

impl Selection {
    /// Whether a text is meant to be one, and not a file.
    pub fn is_meant(text: &str) -> bool {
        By::ALL.iter().any(|by| rest(text, *by).is_some())
    }

    /// For each triangle of the file whether it is chosen; those that the file says nothing of come last and are left
    /// out here.
    ///
    /// # Errors
    /// When the file has no such names at all, none that one of the patterns is for, or no triangle that is chosen.
    pub fn triangles(&self, texturing: &Texturing) -> Result<Vec<bool>, SelectionError> {
        let counts = texturing.names_by(self.by);
        if counts.is_empty() {
            return Err(SelectionError::no_names(texturing, self.by));
        }
        let names = || texturing.parts.iter().flat_map(|part| self.by.names(part));
        let chosen = self.chosen(|name| names().any(|there| there == name));
        let is_met = |pattern: &str| names().any(|name| fits(pattern, name));
        if let Some(name) = chosen.wanted.first_that_is_not(is_met) {
            return Err(SelectionError::NoSuch {
                kind: self.by.word(),
                name: name.to_owned(),
                there: listed(&counts) + &meant(name, names()),
            });
        }
        let parts = texturing.parts.iter();
        let has: Vec<bool> = parts.map(|part| chosen.has(self.by.names(part))).collect();
        let of = |part: &Option<u32>| part.map_or(chosen.is_others, |part| has[part as usize]);
        let chosen: Vec<bool> = texturing.part_of.iter().map(of).collect();
        match chosen.contains(&true) {
            true => Ok(chosen),
            false => Err(SelectionError::Nothing(self.to_string())),
        }
    }

    /// Its names, among those that there are.
    fn chosen(&self, is_there: impl Fn(&str) -> bool) -> Chosen<'_> {
        let others = self.text.strip_prefix('!');
        let as_it_stands = [Some(&self.text[..]), others].into_iter().flatten();
        let one = as_it_stands.into_iter().find(|name| is_there(name));
        Chosen {
            is_others: others.is_some() && one != Some(&self.text),
            wanted: match one {
                Some(name) => Wanted::One(name),
                None => Wanted::Like(patterns(&self.text).collect()),
            },
        }
    }
}

/// What may have been meant by a name that none of these is.
fn meant<'a>(name: &str, mut names: impl Iterator<Item = &'a String>) -> String {
    match names.find(|there| there.eq_ignore_ascii_case(name)) {
        Some(there) => format!("; did you mean '{there}'?"),
        None if name.starts_with('!') => {
            "; a ! goes before the first name, for all but these".to_owned()
        }
        None => String::new(),
    }
}

/// What stands between the commas of a selection.
fn patterns(text: &str) -> impl Iterator<Item = &str> {
    let names = text.strip_prefix('!').unwrap_or(text);
    names.split(',').map(str::trim)
}

impl Chosen<'_> {
    fn has(&self, names: &[String]) -> bool {
        let is_wanted = |name: &String| self.wanted.has(name);
        names.iter().any(is_wanted) != self.is_others
    }
}

impl<'a> Wanted<'a> {
    fn has(&self, name: &str) -> bool {
        match self {
            Self::One(one) => *one == name,
            Self::Like(patterns) => patterns.iter().any(|pattern| fits(pattern, name)),
        }
    }

    fn first_that_is_not(&self, met: impl Fn(&str) -> bool) -> Option<&'a str> {
        match self {
            Self::One(_) => None,
            Self::Like(patterns) => patterns.iter().copied().find(|pattern| !met(pattern)),
        }
    }
}

impl FromStr for Selection {
    type Err = SelectionError;

    fn from_str(text: &str) -> Result<Self, SelectionError> {
        let unreadable = || SelectionError::Unreadable(text.to_owned());
        let said = By::ALL
            .into_iter()
            .find_map(|by| Some((by, rest(text, by)?)));
        let (by, names) = said.ok_or_else(unreadable)?;
        match patterns(names).any(str::is_empty) {
            true => Err(unreadable()),
            false => Ok(Self {
                by,
                text: names.to_owned(),
            }),
        }
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}:{}", self.by.word(), self.text)
    }
}

impl Texturing {
    /// The names of the file's objects, the first of each, in their order, and how many triangles have them.
    pub fn objects(&self) -> Vec<(&str, usize)> {
        self.names_by(By::Object)
    }

    /// The names of its materials that triangles have, in the order of these, and how many do.
    pub fn named_materials(&self) -> Vec<(&str, usize)> {
        self.names_by(By::Material)
    }

    pub(super) fn names_by(&self, by: By) -> Vec<(&str, usize)> {
        let mut of_parts = vec![0; self.parts.len()];
        for part in self.part_of.iter().flatten() {
            if let Some(count) = of_parts.get_mut(*part as usize) {
                *count += 1;
            }
        }
        let mut found: Vec<(&str, usize)> = Vec::new();
        let mut places = HashMap::new();
        for (part, count) in self.parts.iter().zip(of_parts) {
            if let Some(name) = by.names(part).first().filter(|_| count > 0) {
                let place = *places.entry(name).or_insert(found.len());
                if place == found.len() {
                    found.push((name, 0));
                }
                found[place].1 += count;
            }
        }
        found
    }
}

/// What stands after the word and its colon.
fn rest(text: &str, by: By) -> Option<&str> {
    text.strip_prefix(by.word())?.strip_prefix(':')
}

/// What to choose by where there are no such names.
fn instead(kind: &str, others: &str) -> String {
    match others {
        "" => {
            "nor anything else that one could choose by: export it as glTF or OBJ, with its names"
                .to_owned()
        }
        others if kind == By::Object.word() => format!("but materials: {others}"),
        others => format!("but objects: {others}"),
    }
}

/// Some names, and how many more there are.
fn listed(counts: &[(&str, usize)]) -> String {
    const MOST: usize = 12;
    let quoted = |name: &str| match name.contains(',') || name.trim() != name {
        true => format!("'{name}'"),
        false => name.to_owned(),
    };
    let first = counts.iter().take(MOST);
    let names: Vec<String> = first.map(|(name, _)| quoted(name)).collect();
    let names = names.join(", ");
    match counts.len().saturating_sub(MOST) {
        0 => names,
        more => format!("{names} and {more} more"),
    }
}

/// Whether a name is what a pattern says, in which `*` stands for whatever letters.
fn fits(pattern: &str, name: &str) -> bool {
    let Some((first, others)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(mut left) = name.strip_prefix(first) else {
        return false;
    };
    let (between, last) = others.rsplit_once('*').unwrap_or(("", others));
    for piece in between.split('*') {
        match left.find(piece) {
            Some(at) => left = &left[at + piece.len()..],
            None => return false,
        }
    }
    left.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of three parts, and one of none.
    fn tree() -> Texturing {
        let part = |objects: &[&str], material: Option<&str>| Part {
            objects: objects.iter().map(|&name| name.to_owned()).collect(),
            material: material.map(str::to_owned),
            ..Part::default()
        };
        Texturing {
            parts: vec![
                part(&["Trunk", "TrunkMesh"], Some("Bark")),
                part(&["Leaf.001"], Some("Leaves")),
                part(&["Leaf.002"], None),
            ],
            part_of: vec![Some(0), Some(1), Some(1), None, Some(2)],
            ..Texturing::default()
        }
    }

    fn chosen(text: &str) -> Result<Vec<u8>, SelectionError> {
        let selection: Selection = text.parse()?;
        assert_eq!(selection.to_string(), text);
        let triangles = selection.triangles(&tree())?;
        Ok(triangles.into_iter().map(u8::from).collect())
    }

    #[test]
    fn triangles_are_chosen_by_name() {
        let cases = [
            ("material:Bark", [1, 0, 0, 0, 0]),
            ("material:!Leaves", [1, 0, 0, 1, 1]),
            ("object:Trunk", [1, 0, 0, 0, 0]),
            ("object:TrunkMesh", [1, 0, 0, 0, 0]),
            ("object:Leaf*", [0, 1, 1, 0, 1]),
            ("object:Trunk,Leaf.002", [1, 0, 0, 0, 1]),
            ("object:!*.001", [1, 0, 0, 1, 1]),
            ("object:*u*k", [1, 0, 0, 0, 0]),
        ];
        for (text, expected) in cases {
            assert_eq!(chosen(text), Ok(expected.to_vec()), "{text}");
        }
    }

    #[test]
    fn parts_that_are_not_there_have_no_name() {
        let mut tree = tree();
        tree.part_of[0] = Some(3);
        let expected = [("Leaf.001", 2), ("Leaf.002", 1)];
        assert_eq!(tree.objects(), expected);
    }

    #[test]
    fn a_name_as_it_stands_is_that_one() {
        let mut tree = tree();
        let names = ["  Rock ", "Rock, old", "Rock*"];
        for (part, name) in tree.parts.iter_mut().zip(names) {
            part.objects = vec![name.to_owned()];
        }
        tree.part_of = vec![Some(0), Some(1), Some(2)];
        let cases = [
            ("object:  Rock ", [true, false, false]),
            ("object:Rock, old", [false, true, false]),
            ("object:!Rock, old", [true, false, true]),
            ("object:Rock*", [false, false, true]),
            ("object:*Rock*", [true, true, true]),
        ];
        for (text, expected) in cases {
            let selection: Selection = text.parse().unwrap();
            assert_eq!(selection.triangles(&tree), Ok(expected.to_vec()), "{text}");
        }
        tree.parts[0].objects = vec!["!Rock, old".to_owned()];
        let selection: Selection = "object:!Rock, old".parse().unwrap();
        assert_eq!(selection.triangles(&tree), Ok(vec![true, false, false]));
    }

    #[test]
    fn what_is_not_there_is_told() {
        let text = |text: &str| chosen(text).unwrap_err().to_string();
        let brak = text("material:Bark,Brak");
        assert!(
            brak.ends_with("no material called 'Brak': it has Bark, Leaves"),
            "{brak}"
        );
        for (asked, hint) in [
            ("material:bark", "Leaves; did you mean 'Bark'?"),
            (
                "material:Leaves,!Bark",
                "a ! goes before the first name, for all but these",
            ),
        ] {
            assert!(text(asked).ends_with(hint), "{}", text(asked));
        }
        for unreadable in ["stone", "object:", "object:a,,b", "object:!", "Object:a"] {
            let told = text(unreadable);
            assert!(told.contains("chooses no triangles"), "{told}");
        }
        let nameless = "object:a".parse::<Selection>().unwrap();
        let error = nameless.triangles(&Texturing::default()).unwrap_err();
        assert!(
            error.to_string().contains("no objects, nor anything"),
            "{error}"
        );
        let mut bare = tree();
        bare.parts.iter_mut().for_each(|part| part.material = None);
        let by_material = "material:a".parse::<Selection>().unwrap();
        let error = by_material.triangles(&bare).unwrap_err().to_string();
        assert!(
            error.ends_with("no materials, but objects: Trunk, Leaf.001, Leaf.002"),
            "{error}"
        );
        let all = "object:!Trunk,Leaf*".parse::<Selection>().unwrap();
        let mut named = tree();
        named.part_of[3] = Some(0);
        assert!(matches!(
            all.triangles(&named),
            Err(SelectionError::Nothing(_))
        ));
    }

    #[test]
    fn names_are_counted() {
        let tree = tree();
        assert_eq!(
            tree.objects(),
            [("Trunk", 1), ("Leaf.001", 2), ("Leaf.002", 1)]
        );
        assert_eq!(tree.named_materials(), [("Bark", 1), ("Leaves", 2)]);
    }

    #[test]
    fn stars_stand_for_whatever_letters() {
        let yes = [
            ("*", ""),
            ("a*", "a"),
            ("a*a", "aa"),
            ("*b*", "abc"),
            ("a*b*c", "a-b-c"),
        ];
        let no = [("a*a", "a"), ("a*b*c", "acb"), ("", "a"), ("*b", "bc")];
        assert!(yes.iter().all(|(pattern, name)| fits(pattern, name)));
        assert!(!no.iter().any(|(pattern, name)| fits(pattern, name)));
    }
}
