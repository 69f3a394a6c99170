//! The triangle mesh that lichen grows on: cleaned, welded, immutable after loading.
//!
//! A file becomes a [`Soup`]; a soup is welded by position, loses degenerate and duplicate
//! triangles, and gets adjacency, charts to walk in and a bounding volume hierarchy. What was done
//! and what is left is in the [`SubstrateReport`].
//!
//! Triangles are stored in an order that suits walks: connected pieces from the largest area down,
//! and along a curve that fills space inside each. Results name a triangle by its
//! [canonical number](Substrate::canonical_triangle), which does not depend on where in the file
//! unrelated pieces stand; [`Substrate::source_triangle`] gives back the file's own.

mod adjacency;
mod bvh;
mod caps;
mod coarse;
mod division;
mod geometry;
mod inside;
mod junctions;
mod known_places;
mod load;
mod lying;
mod mask;
mod neighbour;
mod openings;
mod order;
mod pairing;
mod parts;
mod pieces;
mod report;
mod seams;
mod search;
mod simplify;
mod smooth;
mod soup;
mod spread;
mod surface_point;
mod texturing;
mod units;
mod up;
mod weld;
mod winding;

use std::ops::Range;
use std::path::Path;
use std::sync::OnceLock;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

pub use crate::image::Wrap;
pub use adjacency::{HalfEdge, Twin};
pub(crate) use coarse::{Copies, Errors};
pub use division::{Division, NAMELESS};
pub(crate) use geometry::Unscaled;
pub use geometry::{Chart, Crossing, Facet, Frame};
pub(crate) use geometry::{nearest_weights, segment_distance_sq, way_from_segment};
pub(crate) use known_places::Found;
pub use load::{
    Format, LoadError, LoadFault, Loaded, load_soup, load_textured, parse_soup, parse_textured,
    udim_mark,
};
pub use mask::{Mask, MaskError};
pub(crate) use order::along_curve;
pub use parts::{Part, Selection, SelectionError};
pub(crate) use pieces::Pieces;
pub use report::{PieceReport, SubstrateReport};
use smooth::slope_normals;
pub(crate) use smooth::{corner_normals, weighted_normal};
pub use soup::Soup;
pub use surface_point::SurfacePoint;
pub(crate) use texturing::passed_over;
pub use texturing::{Alpha, Material, Texture, Texturing};
pub use units::Units;
pub use up::UpAxis;
pub(crate) use winding::Winding;

use adjacency::{Adjacency, VertexCorners};
use bvh::Bvh;
use known_places::KnownPlaces;

use crate::ahead::fetch;

/// The radius of elements that `auto` chooses is the bounding box's diagonal over this.
pub const AUTO_RADII_PER_DIAGONAL: f64 = 2000.0;

/// A mesh of fewer triangles is walked over as fast without a coarser copy.
const FINE: usize = 20_000;

/// Why a mesh could not become a substrate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SubstrateError {
    /// The file could not be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// There is no triangle at all.
    #[error("no triangles to grow on; export the mesh with its faces")]
    NoTriangles,
    /// Cleaning left nothing.
    #[error(
        "{} degenerate (no area): there is nothing to grow on; \
         check the mesh's scale and export it again",
        all(*.degenerate)
    )]
    OnlyDegenerate {
        /// How many there were.
        degenerate: usize,
    },
    /// A triangle has a corner that is not there.
    #[error(
        "triangle {triangle} has vertex {vertex}, and there are {vertices}, numbered from 0: give \
         every vertex that triangles name"
    )]
    NoSuchVertex {
        /// The triangle's number in the soup.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A corner's position is not a number, infinite or beyond f32.
    #[error(
        "vertex {vertex}, a corner of triangle {triangle}, is at {position:?}: coordinates must be \
         finite and not beyond {:e}",
        f32::MAX
    )]
    NowhereVertex {
        /// The first triangle in the soup that uses it.
        triangle: usize,
        /// The vertex's number in the soup.
        vertex: u32,
        /// Where it is said to be.
        position: [f64; 3],
    },
    /// More triangles than half-edge numbers.
    #[error("{triangles} triangles are too many: the most is {most}; simplify the mesh", most = MOST_TRIANGLES)]
    TooLarge {
        /// How many there were.
        triangles: usize,
    },
}

fn all(triangles: usize) -> String {
    match triangles {
        1 => "its only triangle is".to_owned(),
        n => format!("all {n} triangles are"),
    }
}

/// Half-edges are numbered in 31 bits.
const MOST_TRIANGLES: usize = (1 << 31) / 3;

/// Triangles that a walker can reach one another on: a connected component.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The component's triangles, numbered consecutively.
    pub triangles: Range<u32>,
    /// Area in local units squared.
    pub area: f64,
    /// Lower and upper corner of the bounding box, local units.
    pub bounds: [DVec3; 2],
}

/// A surface to grow on. Positions are in local units: see [`Units`].
pub struct Substrate {
    units: Units,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Three a triangle.
    crossings: Vec<Crossing>,
    corners: VertexCorners,
    /// The triangles' places in the file.
    source: Vec<u32>,
    /// What is there part of another.
    parts: caps::Parts,
    numbers: Vec<u32>,
    components: Vec<Component>,
    bvh: Bvh,
    report: SubstrateReport,
    hash: String,
    up: UpAxis,
    /// That of the file's format.
    usual_up: UpAxis,
    coarser: coarse::Kept,
    known_places: KnownPlaces,
    /// Whether some neighbours are wound differently.
    winds_differently: bool,
    winding: OnceLock<Winding>,
    /// Those of the smooth surface at the corners, once somebody asks for them.
    slope_normals: OnceLock<Vec<[Vec3; 3]>>,
    /// None where there is but one piece.
    piece_tree: OnceLock<Option<Pieces>>,
    mask: Option<Mask>,
}

impl std::fmt::Debug for Substrate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Substrate")
            .field("triangles", &self.triangles.len())
            .field("vertices", &self.vertices.len())
            .field("units", &self.units)
            .field("hash", &self.hash)
            .field("up", &self.up)
            .finish_non_exhaustive()
    }
}

impl Substrate {
    /// Loads, cleans and prepares a mesh file (OBJ, glTF, GLB, STL or PLY).
    ///
    /// # Errors
    /// When the file cannot be read or holds no triangle with an area.
    pub fn load(path: &Path) -> Result<Self, SubstrateError> {
        Self::from_loaded(load_soup(path)?)
    }

    /// Cleans and prepares what a mesh file held: [`load`](Self::load) in two steps, to be timed
    /// apart, or of bytes that are in memory ([`parse_soup`]).
    ///
    /// # Errors
    /// As [`from_soup`](Self::from_soup), but for corners, which loaders have asked about.
    ///
    /// # Panics
    /// When a corner is not among the positions, which no loader lets through.
    pub fn from_loaded(loaded: Loaded) -> Result<Self, SubstrateError> {
        let Loaded {
            soup, hash, format, ..
        } = loaded;
        let substrate = Self::cleaned(soup)?;
        Ok(Self {
            hash,
            up: format.up(),
            usual_up: format.up(),
            ..substrate
        })
    }

    /// This substrate with this axis up, for a file that does not keep to its format's convention; with none, as the
    /// format has it. Nothing is turned, but other places are above.
    #[must_use]
    pub fn with_up(self, up: Option<UpAxis>) -> Self {
        let up = up.unwrap_or(self.usual_up);
        Self { up, ..self }
    }

    /// This substrate where lichen may only grow as a mask has it, or without one everywhere. Who needs the mesh with
    /// several masks at a time prepares it once for each.
    ///
    /// # Panics
    /// When the mask was made for another mesh, which is one with another [hash](Self::mesh_hash).
    #[must_use]
    pub fn with_mask(self, mask: Option<Mask>) -> Self {
        let is_for_it = mask.as_ref().is_none_or(|mask| mask.is_for(&self));
        assert!(is_for_it, "another mesh's mask");
        Self { mask, ..self }
    }

    /// What has been found where lichen may grow.
    pub(crate) fn known_places(&self) -> &KnownPlaces {
        &self.known_places
    }

    /// Where lichen may grow, if not everywhere.
    pub fn mask(&self) -> Option<&Mask> {
        self.mask.as_ref()
    }

    /// Cleans and prepares triangles from anywhere. Up is +Y, unless [told](Self::with_up) otherwise.
    ///
    /// # Errors
    /// When there is no triangle with an area, or more than 2³¹/3; when a triangle's corner is not among the
    /// positions, or its position is not finite or beyond f32. Vertices that no triangle uses may be
    /// anywhere.
    pub fn from_soup(soup: Soup) -> Result<Self, SubstrateError> {
        soup.check()?;
        let hash = soup.hash();
        let substrate = Self::cleaned(soup)?;
        Ok(Self { hash, ..substrate })
    }

    fn cleaned(mut soup: Soup) -> Result<Self, SubstrateError> {
        let read = soup.triangles.len();
        match read {
            0 => return Err(SubstrateError::NoTriangles),
            n if n > MOST_TRIANGLES => return Err(SubstrateError::TooLarge { triangles: n }),
            _ => {}
        }
        let notes = std::mem::take(&mut soup.notes);
        let mut welded = weld::weld(soup);
        if welded.triangles.is_empty() {
            return Err(SubstrateError::OnlyDegenerate {
                degenerate: welded.degenerate,
            });
        }
        let ordered = seams::order_closed(&mut welded);
        Ok(Self::prepared(welded, ordered, read, notes))
    }

    /// A substrate of cleaned triangles.
    fn from_welded(mut welded: weld::Welded) -> Self {
        let read = welded.triangles.len();
        let ordered = order::order(&mut welded);
        Self::prepared(welded, ordered, read, Vec::new())
    }

    fn prepared(
        welded: weld::Welded,
        (adjacency, components): (Adjacency, Vec<Component>),
        read: usize,
        notes: Vec<String>,
    ) -> Self {
        let bvh = || Bvh::new(&welded.vertices, &welded.triangles);
        let geometry = || crossings(&welded, &adjacency);
        let report = || report::report(read, notes, &welded, &adjacency);
        let numbers = || order::canonical_numbers(&welded.source, &components);
        // Each has parts that one thread does alone: others go on meanwhile.
        let ((bvh, crossings), (report, numbers)) = rayon::join(
            || rayon::join(bvh, geometry),
            || rayon::join(report, numbers),
        );
        Self {
            units: welded.units,
            vertices: welded.vertices,
            triangles: welded.triangles,
            crossings,
            corners: adjacency.corners,
            source: welded.source,
            parts: welded.parts,
            numbers,
            components,
            bvh,
            report,
            hash: String::new(),
            up: UpAxis::Y,
            usual_up: UpAxis::Y,
            coarser: coarse::Kept::default(),
            known_places: KnownPlaces::default(),
            winds_differently: adjacency.winds_differently,
            winding: OnceLock::new(),
            slope_normals: OnceLock::new(),
            piece_tree: OnceLock::new(),
            mask: None,
        }
    }

    /// The map between local units and the file's.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The element radius that `auto` chooses, file units: the bounding box's diagonal over
    /// [`AUTO_RADII_PER_DIAGONAL`].
    pub fn auto_radius(&self) -> f64 {
        self.units.diagonal() / AUTO_RADII_PER_DIAGONAL
    }

    /// What loading found and did.
    pub fn report(&self) -> &SubstrateReport {
        &self.report
    }

    /// Which way is up: +Y in OBJ and glTF, +Z in STL and PLY, or as [told](Self::with_up).
    pub fn up(&self) -> DVec3 {
        self.up.direction()
    }

    /// The axis of that.
    pub fn up_axis(&self) -> UpAxis {
        self.up
    }

    /// Whether this axis is up, or without one that of the file's format.
    pub fn has_up(&self, up: Option<UpAxis>) -> bool {
        self.up == up.unwrap_or(self.usual_up)
    }

    /// The up axis where it is not that of the file's format.
    pub fn unusual_up(&self) -> Option<UpAxis> {
        (self.up != self.usual_up).then_some(self.up)
    }

    /// BLAKE3 hash of the file and the buffers that it refers to, hexadecimal; for a soup from
    /// elsewhere, of its positions and triangles, so that recipes and logs of one are not taken for those of
    /// another.
    pub fn mesh_hash(&self) -> &str {
        &self.hash
    }

    /// Welded vertices, local units.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Corner numbers of every triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Whether there are so many triangles that walks take longer, unless they go over coarser copies.
    pub fn is_fine(&self) -> bool {
        self.triangles.len() >= FINE
    }

    /// A triangle laid flat, and where that lies in space.
    ///
    /// Worked out from its corners: kept, it would take 96 bytes a triangle, and walkers would wait for these.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[inline(always)]
    pub fn facet(&self, triangle: u32) -> Facet {
        self.unscaled(triangle).scaled()
    }

    /// The same in lengths of its first edge.
    #[inline(always)]
    pub(crate) fn unscaled(&self, triangle: u32) -> Unscaled {
        let [first, second, third] = &self.crossings.as_chunks().0[triangle as usize];
        let apex = DVec2::new(first.along, first.height);
        // By their crossings and not by the list of corners, which walks then do not need.
        let corners = [second, third, first].map(|beside| self.vertices[beside.apex as usize]);
        Unscaled::new(triangle, corners, apex)
    }

    /// Asks for where a vertex is.
    #[inline(always)]
    pub(crate) fn fetch_vertex(&self, vertex: u32) {
        fetch(self.vertices.get(vertex as usize));
    }

    /// How walks cross every half-edge.
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings
    }

    /// What lies across a half-edge.
    ///
    /// # Panics
    /// When there is no such half-edge.
    pub fn twin(&self, half_edge: HalfEdge) -> Twin {
        let (first, k) = (half_edge / 3 * 3, half_edge % 3);
        self.crossings[(first + (k + 2) % 3) as usize].exits[0]
    }

    /// Lower and upper corner of the bounding box, local units.
    pub fn bounds(&self) -> [DVec3; 2] {
        let boxes = || self.components.iter().map(|c| c.bounds);
        let low = boxes().fold(DVec3::INFINITY, |m, [low, _]| m.min(low));
        let high = boxes().fold(DVec3::NEG_INFINITY, |m, [_, high]| m.max(high));
        [low, high]
    }

    /// Connected components, largest area first.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// The component that a triangle belongs to.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn component_of(&self, triangle: u32) -> &Component {
        let i = self
            .components
            .partition_point(|c| c.triangles.end <= triangle);
        &self.components[i]
    }

    /// Area of all components that some triangles are in, each of them once.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn area_of_pieces(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        self.pieces_of(triangles)
            .iter()
            .map(|piece| piece.area)
            .sum()
    }

    /// The components that some triangles are in, each of them once, in the order of their triangles.
    pub(crate) fn pieces_of(&self, triangles: impl Iterator<Item = u32>) -> Vec<&Component> {
        let mut pieces: Vec<&Component> = triangles.map(|t| self.component_of(t)).collect();
        pieces.sort_by_key(|piece| piece.triangles.start);
        pieces.dedup_by_key(|piece| piece.triangles.start);
        pieces
    }

    /// The number that results name a triangle by: pieces from the largest area down, in the file's
    /// order inside each. In a clean file of one piece it is the file's own number. It is not the number that
    /// a [`SurfacePoint`] has: [`triangle_of_canonical`](Self::triangle_of_canonical) gives that.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn canonical_triangle(&self, triangle: u32) -> u32 {
        self.numbers[triangle as usize]
    }

    /// The triangle of this [canonical number](Self::canonical_triangle), unless there is none. It looks
    /// through a component; [`Elements::places_on`](crate::export::Elements::places_on) is for whole tables.
    pub fn triangle_of_canonical(&self, number: u32) -> Option<u32> {
        let there = (number as usize) < self.triangles.len();
        let mut piece = there.then(|| self.component_of(number).triangles.clone())?;
        piece.find(|&t| self.canonical_triangle(t) == number)
    }

    /// The number that a triangle had in the file, polygons being counted as their triangles. Two have the same
    /// where a corner of others lies on the edge of one.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn source_triangle(&self, triangle: u32) -> u32 {
        let place = self.source[triangle as usize];
        self.parts.get(&place).map_or(place, |part| part.of)
    }

    /// Whether a triangle is part of one of the file.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn is_part(&self, triangle: u32) -> bool {
        self.parts.contains_key(&self.source[triangle as usize])
    }

    /// Weights of a triangle's corners in that one: its own, unless it is a part.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn source_weights(&self, triangle: u32) -> [[f64; 3]; 3] {
        let part = self.parts.get(&self.source[triangle as usize]);
        part.map_or(caps::WHOLE, |part| part.weights)
    }

    /// The number in the file of the triangle that a point is in, and its weights in that one.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn source_of_place(&self, at: &SurfacePoint) -> (u32, [f64; 3]) {
        let corners = self.source_weights(at.triangle).map(DVec3::from);
        let all = corners.into_iter().zip(at.weights());
        let place: DVec3 = all.map(|(corner, weight)| corner * weight).sum();
        (self.source_triangle(at.triangle), place.to_array())
    }

    /// The point with these weights in the triangle of this number in the file, unless that was dropped or never
    /// was.
    pub fn place_of_source(&self, source: u32, weights: [f64; 3]) -> Option<SurfacePoint> {
        let triangles = 0..self.triangles.len() as u32;
        let here = triangles.filter(|&t| self.source_triangle(t) == source);
        let least = |w: [f64; 3]| w.into_iter().fold(f64::INFINITY, f64::min);
        let places = here.map(|t| (t, caps::weights_within(self.source_weights(t), weights)));
        let best = places.max_by(|(_, a), (_, b)| least(*a).total_cmp(&least(*b)));
        best.map(|(t, weights)| SurfacePoint::from_weights(t, weights))
    }

    /// Corners of a triangle, local units.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[triangle as usize];
        let vertex = |i: u32| self.vertices[i as usize];
        [vertex(a), vertex(b), vertex(c)]
    }

    /// Asks for where the half-edges at a vertex are.
    pub(crate) fn fetch_half_edges_at(&self, vertex: u32) {
        self.corners.fetch(vertex);
    }

    /// Half-edges that leave a vertex, one for each triangle there.
    ///
    /// # Panics
    /// When there is no such vertex.
    pub fn half_edges_at(&self, vertex: u32) -> &[HalfEdge] {
        self.corners.of(vertex)
    }

    /// A point's position in space, local units.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn position(&self, p: &SurfacePoint) -> DVec3 {
        let [a, b, c] = self.corners(p.triangle);
        a + (b - a) * p.u + (c - a) * p.v
    }

    /// A triangle's unit normal. It is that of the file's winding, unless some of its component's triangles are wound
    /// against others: then all normals of that component are on one side, outwards where it is closed, else on
    /// that of most of it, by area.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn normal(&self, triangle: u32) -> DVec3 {
        self.area_vector(triangle).normalize_or(DVec3::Y)
    }

    /// A triangle's [normal](Self::normal) times its area, local units squared.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn area_vector(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * self.winding().side(triangle) * (b - a).cross(c - a)
    }

    /// The unit normal of the surface as it is on the whole, on the side of [`normal`](Self::normal): for the slope.
    ///
    /// As [`smooth_normals`](crate::morphometry::smooth_normals), but what is finer than about 1 % of the diagonal of
    /// the bounding box, as the noise of a scan or the steps of a terrain, is taken out before, as far as the mean of
    /// some hundred triangles does that. Larger triangles keep their normals. The first call finds it for all corners,
    /// which takes 36 bytes a triangle.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn slope_normal(&self, at: &SurfacePoint) -> DVec3 {
        let all = self.find_slope_normals();
        let corners = all[at.triangle as usize].map(|normal| normal.as_dvec3());
        weighted_normal(self, at, corners)
    }

    /// Finds them. Not while others wait: a thread that does may take up work that asks for them too.
    pub(crate) fn find_slope_normals(&self) -> &[[Vec3; 3]] {
        if let Some(found) = self.slope_normals.get() {
            return found;
        }
        let found = slope_normals(self);
        self.slope_normals.get_or_init(|| found)
    }

    /// Which triangles are turned for that, found at the first call.
    pub(crate) fn winding(&self) -> &Winding {
        self.winding.get_or_init(|| Winding::of(self))
    }

    /// A triangle's area, local units squared.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn area(&self, triangle: u32) -> f64 {
        area(self.corners(triangle))
    }
}

fn crossings(welded: &weld::Welded, adjacency: &Adjacency) -> Vec<Crossing> {
    let of_triangle = |(corners, twins): (&[u32; 3], &[Twin; 3])| {
        let places = corners.map(|i| welded.vertices[i as usize]);
        geometry::crossings(places, *corners, *twins)
    };
    let triangles = welded.triangles.par_iter();
    let twins = adjacency.twins.as_chunks().0.par_iter();
    let all: Vec<[Crossing; 3]> = triangles.zip(twins).map(of_triangle).collect();
    all.into_flattened()
}

/// Area of a triangle.
pub(crate) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}
