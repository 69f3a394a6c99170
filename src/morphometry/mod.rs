//! What can be measured on a grown lichen: which way each element grew, how crowded it stands, how
//! far it is from the rim, and its rank among the branches.
//!
//! A [`Sample`] is the lichen as any table of elements has it, in any units; [`measure`] takes all
//! measures, and each has its own function too. Lengths come out in the sample's units. Nothing
//! here reads or writes a file.
//!
//! Neighbours are those within a distance: through space where normals are within 60° of each
//! other, laid out over the fold between them where they are farther apart, so that an edge of a
//! box is no edge of the lichen. The two faces of a thin plate, whose normals differ by more than
//! 154°, do not count for each other. That is a rule of thumb, where growth asks the surface itself:
//! inside a fold narrower than the distance, elements whose normals agree count although no short
//! way over the surface joins them; and at the edge of a plate thinner than half the distance, and
//! of a blade, elements on the other face are missed although one does.

mod density;
mod fold;
mod neighbours;
mod normals;
mod orientation;
mod rim;
#[cfg(test)]
mod test_lichen;
mod tree;

pub use density::density;
pub use neighbours::Neighbours;
pub use normals::smooth_normals;
pub use orientation::{growth_directions, orientations};
pub use rim::{exposed_angles, is_rim, rim_distance, rim_until};
pub(crate) use rim::{is_rim_where, rim_until_with};
pub use tree::Tree;

/// How far an element looks for neighbours where it is not the curvature radius that says so, in element radii
/// from centre to centre. So gaps of less than 4.4 radii between elements count as lichen.
///
/// Packed elements stand at 2, 3.46, 4, 5.29, 6, 6.93 … r from each other. Of those just at the bound round-off
/// would say whether they count, and all are as wrong as none: this lies between. Of a packing it says the
/// density as it is, 0.90.
pub const LOOK: f64 = 6.4;

/// What a distance in which one looks for elements is multiplied by first.
///
/// Packed elements stand at multiples of 2 r from each other, and so do distances in which one looks:
/// without this, round-off would decide about all that are on the bound. Files round places by up to a
/// hundredth of r; nothing piles up right beyond such a distance, but below.
pub const TIES: f64 = 1.004;

/// A lichen to be measured. The slices have one length; row i was born i-th.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Radius r of every element: half of how far those that touch are apart. What is counted within so many radii is
    /// without meaning where it is larger, and takes longer by its square.
    pub radius: f64,
    /// Centres.
    pub positions: &'a [[f64; 3]],
    /// Unit normals of the surface at the centres.
    pub normals: &'a [[f32; 3]],
    /// Birth index of the element that each one stuck to, which is born before it; −1 for a seed. Points that have none
    /// are as many colonies, which have no size to measure dimensions by: let each but the first have the one before
    /// it, and leave alone what goes by branches.
    pub parents: &'a [i32],
}

impl Sample<'_> {
    /// How many positions, normals and parents there are.
    pub(crate) fn columns(&self) -> [usize; 3] {
        [self.positions.len(), self.normals.len(), self.parents.len()]
    }

    fn assert_even(&self) {
        let columns = self.columns();
        assert!(
            columns.iter().all(|&n| n == columns[0]),
            "columns of {columns:?}"
        );
    }
}

/// All measures, one value an element.
#[derive(Clone, Debug, PartialEq)]
pub struct Morphometry {
    /// See [`orientations`].
    pub orientations: Vec<[f64; 4]>,
    /// See [`density()`].
    pub density: Vec<f64>,
    /// See [`rim_distance`].
    pub rim_distance: Vec<Option<f64>>,
    /// See [`Tree::strahler`].
    pub strahler: Vec<u32>,
    /// See [`Tree::depth`].
    pub depth: Vec<u32>,
    /// See [`Tree::streams`].
    pub streams: Vec<Vec<u32>>,
    /// See [`Tree::taper`].
    pub taper: Vec<f64>,
}

/// Takes every measure, with neighbours within the distance `within`, times [`TIES`], on all of rayon's
/// threads.
/// The result does not depend on their number.
///
/// # Panics
/// When the slices differ in length, `within` is not a positive finite number, or an element is not born after
/// its parent.
pub fn measure(sample: &Sample<'_>, within: f64) -> Morphometry {
    sample.assert_even();
    let tree = Tree::new(sample.parents);
    let neighbours = Neighbours::new(sample.positions, sample.normals, TIES * within);
    let rim = is_rim(&neighbours);
    Morphometry {
        orientations: orientations(sample),
        density: density(sample.radius, &neighbours),
        rim_distance: rim_distance(&rim, &neighbours),
        strahler: tree.strahler(),
        depth: tree.depth(),
        streams: tree.streams(),
        taper: tree.taper(),
    }
}
