//! A mesh in parts that have texture layouts of their own.

use std::collections::{HashMap, HashSet};

use super::parts::By;
use super::{Part, SelectionError, Texturing};

/// The triangles of a file, each in one part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Division {
    names: Vec<String>,
    /// What the file calls these, where that is one name.
    own_names: Vec<Option<String>>,
    /// For each triangle of the file its place in `names`.
    part_of: Vec<usize>,
}

/// What parts of nameless triangles are called.
pub const NAMELESS: &str = "unnamed";

/// The bits of an object's frame.
type Frame = [[u64; 3]; 4];

/// What tells objects or materials of a file from one another.
type Key<'a> = (Option<&'a String>, Option<Frame>, Option<u32>);

impl Division {
    /// By the first name of their objects; of those that have one name of their own by where they stand, too, as
    /// instances do. Nameless ones are called `unnamed`, and the second that would be called as another `Rock_2`.
    ///
    /// # Errors
    /// [`SelectionError::NoNames`] when the file names no objects.
    pub fn by_object(texturing: &Texturing) -> Result<Self, SelectionError> {
        Self::by_key(texturing, By::Object, |part, _| {
            let bits = |frame: [[f64; 3]; 4]| frame.map(|column| column.map(f64::to_bits));
            let name = part.and_then(|part| part.objects.first());
            let own = part.filter(|part| part.has_own_name);
            (name, own.and_then(|part| part.frame.map(bits)), None)
        })
    }

    /// By their materials, which in glTF may be several of one name. Nameless ones are called `unnamed`, and the second
    /// that would be called as another `Stone_2`.
    ///
    /// # Errors
    /// [`SelectionError::NoNames`] when the file names no materials.
    pub fn by_material(texturing: &Texturing) -> Result<Self, SelectionError> {
        Self::by_key(texturing, By::Material, |part, material| {
            let name = part.and_then(|part| part.material.as_ref());
            // An OBJ file, which has no frames, knows materials by their names: those of UDIM tiles are several by
            // their images only.
            let is_by_name = part.is_some_and(|part| part.frame.is_none());
            (name, None, material.filter(|_| !is_by_name))
        })
    }

    fn by_key<'a>(
        texturing: &'a Texturing,
        by: By,
        key: impl Fn(Option<&'a Part>, Option<u32>) -> Key<'a>,
    ) -> Result<Self, SelectionError> {
        if texturing.names_by(by).is_empty() {
            return Err(SelectionError::no_names(texturing, by));
        }
        let (mut keys, mut places) = (Vec::new(), HashMap::new());
        let mut place = |(triangle, part): (usize, &Option<u32>)| {
            let material = texturing.material_of.get(triangle).copied().flatten();
            let key = key(part.map(|part| &texturing.parts[part as usize]), material);
            *places.entry(key).or_insert_with(|| {
                keys.push(key.0);
                keys.len() - 1
            })
        };
        let part_of = texturing.part_of.iter().enumerate();
        let part_of = part_of.map(&mut place).collect();
        let named = keys.iter().map(|name| name.map_or(NAMELESS, |name| name));
        Ok(Self {
            names: distinct(named.map(str::to_owned).collect()),
            own_names: keys.into_iter().map(Option::<&String>::cloned).collect(),
            part_of,
        })
    }

    /// By the UDIM tile that the middle of their UVs lies in, in the order of these: 1001 is the image itself, 1002 the
    /// one to its right, and 1011 the one above it. Tiles without such a number are called by column and row, as
    /// `u-1_v0`. Triangles without UVs are in the first tile that there is; where there is none, no triangle is in a
    /// part.
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
            own_names: vec![None; sorted.len()],
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
            names: distinct(pairs.iter().map(name).collect()),
            own_names: vec![None; pairs.len()],
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

    /// What the file calls a part, by its place in [`names`](Self::names), if that is one name: of several parts, where
    /// objects or materials share it.
    pub fn own_name(&self, part: usize) -> Option<&str> {
        self.own_names.get(part)?.as_deref()
    }

    /// What the parts are called, each with a triangle at least, and no two of them the same.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// For each triangle of the file whether it is in a part, by its place in `names`.
    pub fn chosen(&self, part: usize) -> Vec<bool> {
        self.part_of.iter().map(|&of| of == part).collect()
    }
}

/// Names of which no two are the same: the first of several stays, others get numbers that are free.
fn distinct(mut names: Vec<String>) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut seen: HashMap<String, usize> = HashMap::new();
    for name in &mut names {
        let Some(number) = seen.get_mut(name) else {
            seen.insert(name.clone(), 1);
            continue;
        };
        let free = loop {
            *number += 1;
            let numbered = format!("{name}_{number}");
            if taken.insert(numbered.clone()) {
                break numbered;
            }
        };
        *name = free;
    }
    names
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
        has_one.then(|| (1001 + self.column + 10 * self.row) as u32)
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

    /// As glTF may have them: names are not unique there.
    #[test]
    fn parts_of_one_name_are_told_apart() {
        let at = |objects: &[&str], material: Option<&str>, x: f64| Part {
            frame: Some([
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [x, 0.0, 0.0],
            ]),
            has_own_name: true,
            ..named(objects, material)
        };
        let mut texturing = Texturing {
            parts: vec![
                at(&["Rock"], Some("Stone"), 0.0),
                at(&["Rock"], Some("Stone"), 5.0),
                at(&["Rock_2"], Some("Stone"), 0.0),
                at(&["Rock"], None, 0.0),
            ],
            part_of: vec![Some(0), Some(1), Some(2), Some(3), Some(0)],
            material_of: vec![Some(3), Some(1), Some(3), Some(0), Some(7)],
            ..Texturing::default()
        };
        let by_material = Division::by_material(&texturing).unwrap();
        let expected = [
            ("Stone", vec![0, 2]),
            ("Stone_2", vec![1]),
            ("unnamed", vec![3]),
            ("Stone_3", vec![4]),
        ];
        assert_eq!(parts(&by_material), expected);
        let own = [0, 1, 2, 3].map(|part| by_material.own_name(part));
        assert_eq!(own, [Some("Stone"), Some("Stone"), None, Some("Stone")]);
        let by_object = Division::by_object(&texturing).unwrap();
        let expected = [
            ("Rock", vec![0, 3, 4]),
            ("Rock_3", vec![1]),
            ("Rock_2", vec![2]),
        ];
        assert_eq!(parts(&by_object), expected);
        // OBJ has no frames, and knows both by their names.
        texturing
            .parts
            .iter_mut()
            .for_each(|part| part.frame = None);
        let by_material = Division::by_material(&texturing).unwrap();
        assert_eq!(by_material.names(), ["Stone", "unnamed"]);
        let by_object = Division::by_object(&texturing).unwrap();
        assert_eq!(by_object.names(), ["Rock", "Rock_2"]);
        let mut both = by_object.clone();
        both.names = ["a", "a b"].map(str::to_owned).to_vec();
        let mut other = by_material.clone();
        other.names = ["b c", "c"].map(str::to_owned).to_vec();
        other.part_of = vec![0, 0, 1, 0, 0];
        assert_eq!(both.and(&other).names(), ["a b c", "a b c_2"]);
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
        let far = Texturing {
            uvs: vec![at(1e30, -1e30)],
            material_of: vec![None],
            ..Texturing::default()
        };
        let far = Division::by_tile(&far);
        assert_eq!(far.names(), ["u9223372036854775807_v9223372036854775807"]);
    }
}
