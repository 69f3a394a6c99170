//! A mesh in parts that have texture layouts of their own.

use std::collections::HashMap;

use super::parts::By;
use super::{SelectionError, Texturing};

/// The triangles of a file, each in one part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Division {
    names: Vec<String>,
    /// For each triangle of the file its place in `names`.
    part_of: Vec<usize>,
}

/// What parts of nameless triangles are called.
pub const NAMELESS: &str = "unnamed";

impl Division {
    /// By the first name of their objects. Nameless ones are a part called `unnamed`.
    ///
    /// # Errors
    /// [`SelectionError::NoNames`] when the file names no objects.
    pub fn by_object(texturing: &Texturing) -> Result<Self, SelectionError> {
        Self::by_name(texturing, By::Object)
    }

    /// By the names of their materials. Nameless ones are a part called `unnamed`.
    ///
    /// # Errors
    /// [`SelectionError::NoNames`] when the file names no materials.
    pub fn by_material(texturing: &Texturing) -> Result<Self, SelectionError> {
        Self::by_name(texturing, By::Material)
    }

    fn by_name(texturing: &Texturing, by: By) -> Result<Self, SelectionError> {
        if texturing.names_by(by).is_empty() {
            return Err(SelectionError::no_names(texturing, by));
        }
        let name = |part: &Option<u32>| {
            let part = part.map(|part| &texturing.parts[part as usize]);
            part.and_then(|part| by.names(part).first())
        };
        let mut all = Places::default();
        let names = texturing.part_of.iter().map(name);
        let part_of = names
            .map(|name| all.place(name.map_or(NAMELESS, |name| name)))
            .collect();
        Ok(Self {
            names: all.names,
            part_of,
        })
    }

    /// By the UDIM tile that the middle of their UVs lies in, in the order of these: 1001 is the image itself, 1002 the
    /// one to its right, and 1011 the one above it. Tiles without such a number are called by column and row, as
    /// `u-1_v0`. Triangles without UVs are in the first tile that there is; where there is none, no triangle is in a part.
    pub fn by_tile(texturing: &Texturing) -> Self {
        let tiles: Vec<Option<Tile>> = texturing
            .uvs
            .iter()
            .map(|uvs| uvs.as_ref().map(Tile::of))
            .collect();
        let mut sorted: Vec<Tile> = tiles.iter().flatten().copied().collect();
        sorted.sort_unstable();
        sorted.dedup();
        let place = |tile: &Tile| sorted.binary_search(tile).unwrap_or(0);
        let count = match sorted.is_empty() {
            true => 0,
            false => texturing.material_of.len().max(tiles.len()),
        };
        let of = |triangle: usize| tiles.get(triangle)?.as_ref().map(place);
        Self {
            names: sorted.iter().map(Tile::name).collect(),
            part_of: (0..count).map(|t| of(t).unwrap_or(0)).collect(),
        }
    }

    /// The parts of this that lie in each of another's, called after both: of two divisions of one file.
    pub fn and(&self, other: &Self) -> Self {
        let both = self.part_of.iter().zip(&other.part_of);
        let mut pairs: Vec<(usize, usize)> = both.map(|(&one, &two)| (one, two)).collect();
        let part_of = pairs.clone();
        pairs.sort_unstable();
        pairs.dedup();
        let place = |pair| pairs.binary_search(&pair).unwrap_or(0);
        let name =
            |&(one, two): &(usize, usize)| [&self.names[one][..], &other.names[two]].join(" ");
        Self {
            names: pairs.iter().map(name).collect(),
            part_of: part_of.into_iter().map(place).collect(),
        }
    }

    /// How many parts some triangles are in, or all of them.
    pub fn count_in(&self, chosen: Option<&[bool]>) -> usize {
        self.firsts(chosen).iter().flatten().count()
    }

    /// Of each part the first triangle of the file, among those that are chosen, or all.
    pub fn firsts(&self, chosen: Option<&[bool]>) -> Vec<Option<usize>> {
        let is_chosen = |t: usize| chosen.is_none_or(|chosen| chosen.get(t) == Some(&true));
        let mut firsts = vec![None; self.names.len()];
        for (triangle, &part) in self.part_of.iter().enumerate().rev() {
            if is_chosen(triangle) {
                firsts[part] = Some(triangle);
            }
        }
        firsts
    }

    /// The place among [`names`](Self::names) of the part of a triangle of the file, if there is one.
    pub fn place_of(&self, triangle: usize) -> Option<usize> {
        self.part_of.get(triangle).copied()
    }

    /// What the part of a triangle of the file is called, if there is one.
    pub fn name_of(&self, triangle: usize) -> Option<&str> {
        let part = self.place_of(triangle)?;
        self.names.get(part).map(String::as_str)
    }

    /// Triangles of the file that it divides: the first so many.
    pub fn triangles(&self) -> usize {
        self.part_of.len()
    }

    /// What the parts are called, each with a triangle at least.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// For each triangle of the file whether it is in a part, by its place in `names`.
    pub fn chosen(&self, part: usize) -> Vec<bool> {
        self.part_of.iter().map(|&of| of == part).collect()
    }
}

/// Names in the order in which they come.
#[derive(Default)]
struct Places {
    names: Vec<String>,
    places: HashMap<String, usize>,
}

impl Places {
    fn place(&mut self, name: &str) -> usize {
        if let Some(&place) = self.places.get(name) {
            return place;
        }
        let place = self.names.len();
        self.names.push(name.to_owned());
        self.places.insert(name.to_owned(), place);
        place
    }
}

/// A square of the plane of UVs: its row from below and its column.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Tile {
    row: i64,
    column: i64,
}

impl Tile {
    pub(super) fn of(uvs: &[[f64; 2]; 3]) -> Self {
        let middle = |axis: usize| uvs.iter().map(|uv| uv[axis]).sum::<f64>() / 3.0;
        Self {
            row: (1.0 - middle(1)).floor() as i64,
            column: middle(0).floor() as i64,
        }
    }

    /// Column and row.
    pub(super) fn place(self) -> [i64; 2] {
        [self.column, self.row]
    }

    /// UDIM's, if it has one.
    pub(super) fn number(self) -> Option<u32> {
        let has_one = (0..10).contains(&self.column) && (0..900).contains(&self.row);
        has_one.then_some((1001 + self.column + 10 * self.row) as u32)
    }

    fn name(&self) -> String {
        let Self { row, column } = self;
        match self.number() {
            Some(number) => number.to_string(),
            None => format!("u{column}_v{row}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Part;
    use super::*;

    fn named(objects: &[&str], material: Option<&str>) -> Part {
        Part {
            objects: objects.iter().map(|&name| name.to_owned()).collect(),
            material: material.map(str::to_owned),
            ..Part::default()
        }
    }

    fn parts(division: &Division) -> Vec<(&str, Vec<usize>)> {
        let of = |part: usize| {
            let chosen = division.chosen(part);
            (0..chosen.len()).filter(|&t| chosen[t]).collect()
        };
        let numbered = division.names().iter().enumerate();
        numbered.map(|(part, name)| (&name[..], of(part))).collect()
    }

    #[test]
    fn names_divide_and_what_has_none_is_a_part_too() {
        let texturing = Texturing {
            parts: vec![
                named(&["Trunk", "TrunkMesh"], Some("Bark")),
                named(&["Leaf"], Some("Leaves")),
                named(&["Twig"], Some("Bark")),
            ],
            part_of: vec![Some(0), Some(1), None, Some(2), Some(1)],
            material_of: vec![None; 5],
            ..Texturing::default()
        };
        let by_object = Division::by_object(&texturing).unwrap();
        let expected = [
            ("Trunk", vec![0]),
            ("Leaf", vec![1, 4]),
            ("unnamed", vec![2]),
            ("Twig", vec![3]),
        ];
        assert_eq!(parts(&by_object), expected);
        let by_material = Division::by_material(&texturing).unwrap();
        let expected = [
            ("Bark", vec![0, 3]),
            ("Leaves", vec![1, 4]),
            ("unnamed", vec![2]),
        ];
        assert_eq!(parts(&by_material), expected);
        let both = by_material.and(&by_object);
        let expected = [
            ("Bark Trunk", vec![0]),
            ("Bark Twig", vec![3]),
            ("Leaves Leaf", vec![1, 4]),
            ("unnamed unnamed", vec![2]),
        ];
        assert_eq!(parts(&both), expected);
        assert_eq!(by_object.firsts(None), [Some(0), Some(1), Some(2), Some(3)]);
        assert_eq!(by_object.name_of(4), Some("Leaf"));
        assert_eq!(by_object.count_in(None), 4);
        let some = [true, false, false, true];
        assert_eq!(by_object.count_in(Some(&some)), 2);
        assert_eq!(by_material.count_in(Some(&some)), 1);
        let bare = Division::by_material(&Texturing::default()).unwrap_err();
        assert!(matches!(bare, SelectionError::NoNames { .. }), "{bare}");
    }

    #[test]
    fn tiles_are_numbered_from_below() {
        // v counts from above: the image itself has 0 to 1, the one above it −1 to 0.
        let at = |u: f64, v: f64| Some([[u, v], [u + 0.5, v], [u, v + 0.5]]);
        let texturing = Texturing {
            uvs: vec![
                at(1.2, 0.2),
                at(0.2, -0.8),
                None,
                at(0.3, 0.3),
                at(-0.9, 0.1),
                at(9.4, -8.9),
                at(10.2, 0.2),
            ],
            material_of: vec![None; 8],
            ..Texturing::default()
        };
        let expected = [
            ("u-1_v0", vec![2, 4, 7]),
            ("1001", vec![3]),
            ("1002", vec![0]),
            ("u10_v0", vec![6]),
            ("1011", vec![1]),
            ("1100", vec![5]),
        ];
        assert_eq!(parts(&Division::by_tile(&texturing)), expected);
        let bare = Division::by_tile(&Texturing {
            material_of: vec![None; 3],
            ..Texturing::default()
        });
        assert_eq!((bare.names().len(), bare.count_in(None)), (0, 0));
        assert_eq!(bare.and(&bare), bare);
    }
}
