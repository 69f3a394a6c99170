//! Elements to a closed, coloured triangle mesh (Sumner 2001, 8.1).
//!
//! The thesis puts a falloff about every element, fₙ = K·exp(d² ln ½ / C²), steeper along the
//! element's normal and at the outermost ring, and polygonizes an iso-surface of their sum in space.
//! Here the same field is read on the substrate itself, where the iso-surface is a height over each
//! place (see `field.rs`): the surface is cut finer where there is lichen, the lichen's outline is
//! cut out of it, and what is inside becomes an upper side, an underside just beneath the substrate
//! and a shared edge (`refine.rs`, `march.rs`).
//!
//! A grid in space was the alternative. It needs voxels several times finer than the lichen is
//! thick, and where a plate is thinner than two of them it joins the lichens of both faces. On the
//! surface, plates may be as thin as they like, the skin cannot sink or float, and the mesh is closed
//! and manifold because the surface is.
//!
//! Not guaranteed: that the upper side does not pass through itself in creases sharper than the
//! lichen is thick. Substrates of triangles much smaller than elements are not made coarser: the skin
//! has at least the substrate's triangles under lichen.

mod average;
mod base;
mod borders;
mod cortex;
mod cover;
mod decimate;
mod felt;
mod field;
mod frames;
mod grid;
mod history;
mod lichen;
mod lift;
mod manifold;
mod march;
mod outwards;
mod paint;
mod palette;
mod refine;
mod relief;
mod sheet;
mod sites;
mod slice;

use glam::DVec3;
use rayon::prelude::*;

pub use cortex::{Apothecia, Areoles, Cortex, Detail};
pub use cover::Cover;
pub use decimate::decimate;
pub(crate) use field::Sample;
pub use frames::{SkinFrames, expected_near};
pub use lift::lift;
pub use manifold::{Faults, faults};
pub use paint::{Colormap, ColormapError, Paint, Prothallus, UnknownColormap, parse_color};
pub use palette::{NamedColormap, PALETTE};
pub(crate) use relief::{Probe, Relief};

use base::Base;
use cortex::Dress;
use field::{Field, cutoff, overhang};
use grid::Nearness;
use lichen::Lichen;
use march::{Marched, march};
use refine::{NEVER, Tree};
use slice::Cuts;

use crate::cluster::Cluster;
use crate::export::{TriMesh, VertexAttribute};
use crate::substrate::Substrate;

/// The shape of a skin. Lengths are in element radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Height of closed lichen over the substrate. 0.05 to 20.
    pub thickness: f64,
    /// The share of the thickness that the outermost elements lose, 0 to 0.9.
    pub taper: f64,
    /// The thesis's C, the distance at which an element's influence is halved: small shows every
    /// element as a granule, large fuses them. 0.8 to 8.
    pub falloff: f64,
    /// The longest edge of a triangle of the upper side. 0.1 to 10.
    pub resolution: f64,
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            thickness: 1.5,
            taper: 0.4,
            falloff: 1.8,
            resolution: 2.0,
        }
    }
}

/// Why a skin cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinError {
    /// A number that is out of its range.
    #[error(
        "{name} is {}{unit}: it may be {low}{unit} to {high}{unit}{}",
        (value * 1e4).round() / 1e4,
        if unit.is_empty() { "" } else { "; a length without r is in mesh units" }
    )]
    Range {
        /// What it is called.
        name: &'static str,
        /// What was asked for.
        value: f64,
        /// The least that it may be.
        low: f64,
        /// The most.
        high: f64,
        /// What these are in: `r`, element radii, or nothing.
        unit: &'static str,
    },
    /// More triangles than can be counted.
    #[error(
        "a skin of about {triangles:.1e} triangles is too large, the most is {MOST_TRIANGLES:.1e}: \
         make the resolution coarser"
    )]
    TooFine {
        /// How many there would be.
        triangles: f64,
    },
    /// The resolution is too coarse to find any of the lichen.
    #[error("nothing of the lichen is as large as the resolution: make it finer, as 1r")]
    TooCoarse,
    /// There is nothing to cover.
    #[error("there are no elements to put a skin on")]
    Empty,
    /// A [`Presence`](crate::cluster::Presence) that is none.
    #[error(
        "moment {index} is at {time} with a window of {window} elements: both are finite, and windows 0 or more"
    )]
    Moment {
        /// Its place in the list, from 0.
        index: usize,
        /// When it is, in elements.
        time: f64,
        /// How long an element comes in.
        window: f64,
    },
}

/// Triangles of the largest skin: they are numbered by their corners in 32 bits while being made.
const MOST_TRIANGLES: f64 = 4e8;

/// Triangles of an upper side for each element, at a resolution of one radius.
const TRIANGLES_PER_ELEMENT: f64 = 25.0;

/// Area of a triangle of the upper side, in squares of the resolution: of triangles halved at their longest
/// sides until none is longer.
const LEAF_AREA: f64 = 0.17;

/// The mean of 3^u for u between 0 and 1.
const HALVED_AGAIN: f64 = 1.82;

/// The resolution at which the area of a skin is estimated, in element radii.
const ROUGH: f64 = 4.0;

/// Depth of the underside beneath the substrate, in element radii: hidden in it, and less than half
/// of any plate that two faces of lichen could share.
const UNDERSIDE: f64 = 0.05;

/// How far a triangle's points can be from the middle of its longest side, in lengths of that: √3/2
/// and a little.
const FARTHEST_FROM_MIDDLE: f64 = 0.87;

impl Shape {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`SkinError::Range`] for the first that is not.
    pub fn check(&self) -> Result<(), SkinError> {
        let ranges = [
            ("thickness", self.thickness, 0.05, 20.0, "r"),
            ("taper", self.taper, 0.0, 0.9, ""),
            ("falloff", self.falloff, 0.8, 8.0, "r"),
            ("resolution", self.resolution, 0.1, 10.0, "r"),
        ];
        ranges.into_iter().try_for_each(in_range)
    }

    fn check_size(&self, elements: usize) -> Result<(), SkinError> {
        let finer = self.resolution.min(1.0).powi(-2);
        let triangles = TRIANGLES_PER_ELEMENT * elements as f64 * finer;
        match elements {
            0 => Err(SkinError::Empty),
            _ if triangles > MOST_TRIANGLES => Err(SkinError::TooFine { triangles }),
            _ => Ok(()),
        }
    }
}

/// What a number is called, what it is, the least and the most that it may be, and what these are in.
type Ranged = (&'static str, f64, f64, f64, &'static str);

/// As it was meant: 0.6 and not what is nearest to that in 32 bits.
fn as_meant(number: f32) -> f64 {
    (f64::from(number) * 1e6).round() / 1e6
}

fn in_range((name, value, low, high, unit): Ranged) -> Result<(), SkinError> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(SkinError::Range {
            name,
            value,
            low,
            high,
            unit,
        }),
    }
}

/// The colours that [`skin`] would give where each element is alone, in birth order: for pictures of
/// the elements themselves.
///
/// # Errors
/// When a number of `paint` is out of its range.
///
/// # Panics
/// Those of [`skin`].
pub fn element_colors(
    substrate: &Substrate,
    cluster: &Cluster,
    paint: &Paint,
) -> Result<Vec<[u8; 3]>, SkinError> {
    paint.check()?;
    Ok(Lichen::new(substrate, cluster, paint).colors(paint))
}

/// The skin of a lichen: closed, manifold, and the same on any number of threads.
///
/// Its vertices have the attributes `birth` (mean birth index of the elements about them, by
/// influence), `density` and `rim_distance` (means of the elements' [density] and [distance from the
/// rim](crate::morphometry::rim_distance), within [`LOOK`](crate::morphometry::LOOK) radii, the latter in the file's
/// units; the mesh's diagonal where no rim can be reached) and `colony` (of the strongest element).
///
/// [density]: crate::morphometry::density()
///
/// # Errors
/// When a number of `shape` or `paint` is out of its range, when there are no elements, or when the resolution
/// makes more triangles than can be counted, or none.
///
/// # Panics
/// When an element is in a triangle that the substrate does not have. The cluster must have grown on this
/// substrate; on another a skin may also come out without meaning.
pub fn skin(
    substrate: &Substrate,
    cluster: &Cluster,
    shape: &Shape,
    paint: &Paint,
) -> Result<TriMesh, SkinError> {
    made(substrate, cluster, shape, paint, Structure::InMesh).map(|parts| parts.mesh)
}

/// A skin that is to be drawn by something that reads its structure more finely than its triangles are.
pub struct Parts {
    /// The skin without areoles and apothecia.
    pub mesh: TriMesh,
    /// The birth index of the strongest element at each vertex, to look up what else is known about it.
    pub strongest: Vec<u32>,
    /// Areoles and apothecia, if it has any.
    pub cortex: Option<Cortex>,
}

impl std::fmt::Debug for Parts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Parts")
            .field("triangles", &self.mesh.triangles.len())
            .finish_non_exhaustive()
    }
}

/// The skin of a lichen as [`skin`] makes it, but in parts, and cut off where others lie over it: there it comes down
/// to the substrate, as at its outline. What of them is narrower than its own edges is not seen. The mesh is empty
/// where they hide all of it.
///
/// # Errors
/// Those of [`skin`].
///
/// # Panics
/// Those of [`skin`], for the others too.
pub fn skin_in_parts(
    substrate: &Substrate,
    cluster: &Cluster,
    shape: &Shape,
    paint: &Paint,
    above: &[Cover],
) -> Result<Parts, SkinError> {
    made(substrate, cluster, shape, paint, Structure::Beside(above))
}

/// Where a skin has its structure.
enum Structure<'a> {
    /// As triangles of the mesh.
    InMesh,
    /// Apart from the mesh, for whoever draws it; and what lies over the mesh.
    Beside(&'a [Cover]),
}

fn made(
    substrate: &Substrate,
    cluster: &Cluster,
    shape: &Shape,
    paint: &Paint,
    structure: Structure,
) -> Result<Parts, SkinError> {
    shape.check()?;
    paint.check()?;
    shape.check_size(cluster.len())?;
    // The distance from the rim is found by one thread, and needs nothing of the tree.
    let (mut lichen, tree) = rayon::join(
        || Lichen::new(substrate, cluster, paint),
        || refine(substrate, cluster, shape, always_near),
    );
    let cortex = Cortex::new(&lichen, paint, shape.thickness);
    let (radius, last) = (cluster.radius(), last(cluster.len()));
    let grid = lichen.sort(cutoff(shape) * radius);
    let field = Field::new(substrate, &lichen, &grid, shape);
    let dress = |cortex| Dress {
        cortex,
        paint,
        last,
        blur: blur(shape, radius),
    };
    let (dress, above) = match structure {
        Structure::InMesh => (cortex.as_ref().map(dress), &[][..]),
        Structure::Beside(above) => (None, above),
    };
    let under = |above| march(&field, &tree, UNDERSIDE * radius, dress, above);
    let marched = under(above);
    let shows_nothing = marched.triangles.is_empty();
    if shows_nothing && (above.is_empty() || under(&[]).triangles.is_empty()) {
        return Err(SkinError::TooCoarse);
    }
    drop(tree);
    let strongest = marched.attributes.par_iter().map(|a| a.strongest).collect();
    let mesh = finish(substrate, radius, cluster.len(), marched, paint);
    Ok(Parts {
        mesh,
        strongest,
        cortex,
    })
}

/// Birth index of the last of so many elements, by which ages are told.
fn last(elements: usize) -> f32 {
    elements.saturating_sub(1).max(1) as f32
}

/// What a skin of elements of this radius cannot show, local units: half of its longest edge.
fn blur(shape: &Shape, radius: f64) -> f32 {
    (0.5 * shape.resolution * radius) as f32
}

/// From the first element on where any is near, as in a lichen that does not change.
fn always_near(nearness: &Nearness, p: DVec3, distance: f64) -> u32 {
    match nearness.within(p, distance) {
        true => 0,
        false => NEVER,
    }
}

/// The part of the substrate that may carry lichen, cut finer where it does: from as many elements
/// on as `near` says of a place and a distance.
fn refine(
    substrate: &Substrate,
    cluster: &Cluster,
    shape: &Shape,
    near: impl Fn(&Nearness, DVec3, f64) -> u32 + Sync,
) -> Tree {
    let radius = cluster.radius();
    let nearness = Nearness::new(cluster.elements().iter().map(|e| e.position));
    let felt = cutoff(shape) * radius;
    let all = 0..substrate.triangles().len() as u32;
    let carries = |&t: &u32| may_carry(substrate, &nearness, t, felt);
    let carrying: Vec<u32> = all.into_par_iter().filter(carries).collect();
    let longest = shape.resolution * radius;
    let cuts = Cuts::new(substrate, longest);
    let base = Base::new(substrate, &carrying).sliced(substrate, &cuts);
    let reach = overhang(shape) * radius;
    Tree::grow(base, longest, |middle, length| {
        near(&nearness, middle, FARTHEST_FROM_MIDDLE * length + reach)
    })
}

/// About how many triangles the surface is cut into for a skin, on which what it takes depends: counted on
/// a surface that is cut as coarsely as can be without losing sight of the lichen.
pub fn expected_triangles(substrate: &Substrate, cluster: &Cluster, shape: &Shape) -> f64 {
    if cluster.is_empty() {
        return 0.0;
    }
    let rough = Shape {
        resolution: shape.resolution.max(ROUGH),
        ..*shape
    };
    let tree = refine(substrate, cluster, &rough, always_near);
    let nearness = Nearness::new(cluster.elements().iter().map(|e| e.position));
    let radius = cluster.radius();
    let reach = overhang(shape) * radius;
    let longest = shape.resolution * radius;
    let pieces = |face: &base::Face| match face.corners.map(|v| tree.positions[v as usize]) {
        corners if nearness.within(corners.into_iter().sum::<DVec3>() / 3.0, reach) => {
            expected_pieces(corners, longest)
        }
        _ => 0.0,
    };
    tree.leaves(|_| true).iter().map(pieces).sum()
}

/// About how many triangles one is cut into, in sides of at most this length: by its area or, of a sliver, by its
/// length. Two sides of a sliver are halved, which makes three alike; sides end anywhere between half of this length
/// and all of it, so on average there are [`HALVED_AGAIN`] times as many.
fn expected_pieces([a, b, c]: [DVec3; 3], longest: f64) -> f64 {
    let by_area = 0.5 * (b - a).cross(c - a).length() / (LEAF_AREA * longest.powi(2));
    let mut sides = [b - a, c - b, a - c].map(|side| side.length() / longest);
    sides.sort_unstable_by(f64::total_cmp);
    if sides[2] <= 1.0 {
        return 1.0;
    }
    let by_length = HALVED_AGAIN * libm::pow(sides[1], libm::log2(3.0));
    by_area.max(by_length).max(1.0)
}

/// Whether anything of the lichen is within `felt` of a triangle; true also for some that it is not.
fn may_carry(substrate: &Substrate, nearness: &Nearness, triangle: u32, felt: f64) -> bool {
    let corners = substrate.corners(triangle);
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let size = corners.map(|c| (c - middle).length());
    nearness.within(middle, size.into_iter().fold(0.0, f64::max) + felt)
}

/// The skin of so many elements of this radius into the file's units, with colours.
fn finish(
    substrate: &Substrate,
    radius: f64,
    elements: usize,
    marched: Marched,
    paint: &Paint,
) -> TriMesh {
    let units = substrate.units();
    let radius = units.length_to_file(radius) as f32;
    let last = last(elements);
    let of = &marched.attributes;
    let colors = of
        .par_iter()
        .map(|a| {
            a.color
                .unwrap_or_else(|| paint.color(a.density, a.birth / last, a.outline))
        })
        .collect();
    let column = |name, value: &(dyn Fn(&field::Attributes) -> f32 + Sync)| VertexAttribute {
        name,
        values: of.par_iter().map(value).collect(),
        is_length: false,
    };
    let attributes = vec![
        column("birth", &|a| a.birth),
        column("density", &|a| a.density),
        VertexAttribute {
            is_length: true,
            ..column("rim_distance", &|a| a.rim * radius)
        },
        column("colony", &|a| a.colony),
    ];
    // As large as before, so they stay in their place.
    let positions = marched.positions.into_iter();
    let normals = marched.normals.into_iter();
    let mut mesh = TriMesh {
        name: None,
        positions: positions.map(|p| units.to_file(p).to_array()).collect(),
        normals: normals.map(|n| n.to_array()).collect(),
        colors,
        attributes,
        triangles: marched.triangles,
        up: substrate.up_axis(),
        fixed_origin: None,
    };
    outwards::face_outwards(&mut mesh);
    mesh
}
