//! Local units: a mesh is kept about its own centre and at a size of about one, so that neither
//! a UTM offset nor a scale of 1e-6 costs precision. Reports and files use the file's own units.

use glam::DVec3;
use rayon::prelude::*;

use super::weld::is_flat;

/// Triangles that one thread takes at a time.
const SHARE: usize = 1 << 14;

/// A box that nothing is in.
const EMPTY: [DVec3; 2] = [DVec3::INFINITY, DVec3::NEG_INFINITY];

/// The map between a mesh file's coordinates and local ones.
///
/// The local origin is the bounding box's centre. The scale is the power of two that brings the bounding box's
/// diagonal to at least 1 and below 2: lengths differ by that factor, which may well be 1 for one mesh and
/// 1/8192 for the next.
///
/// In local units are [`Substrate`](super::Substrate), [`Cluster`](crate::cluster::Cluster),
/// [`Element`](crate::cluster::Element) and [`Parameters`](crate::growth::Parameters). In the file's are
/// [`Recipe`](crate::run::Recipe), [`Settings`](crate::run::Settings), [`Progress`](crate::run::Progress),
/// [`Elements`](crate::export::Elements), [`Analysis`](crate::analysis::Analysis),
/// [`TriMesh`](crate::export::TriMesh) and the [`SubstrateReport`](super::SubstrateReport).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    min: DVec3,
    max: DVec3,
    /// Local units per file unit: a power of two, so scaling costs no bit.
    scale: f64,
}

impl Units {
    /// Units for the vertices that triangles with an area use. One without, far off, would decide them
    /// otherwise: a scan in geodetic coordinates may have one at the origin. Where that reaches out of the
    /// box of the others, its corners become one of theirs.
    pub(super) fn of(positions: &[[f64; 3]], triangles: &mut [[u32; 3]]) -> Self {
        let corners = |t: &[u32; 3]| t.map(|i| DVec3::from(positions[i as usize]));
        // A triangle without an area that decides where a side of the box is does so among some too.
        let of_some = |some: &[[u32; 3]]| {
            let mut decides = false;
            let shapes = some.iter().map(corners);
            let [min, max] = shapes.fold(EMPTY, |[min, max], shape| {
                let low = shape.iter().fold(min, |lo, p| lo.min(*p));
                let high = shape.iter().fold(max, |hi, p| hi.max(*p));
                decides |= [low, high] != [min, max] && is_flat(shape);
                [low, high]
            });
            (min, max, decides)
        };
        let parts: Vec<_> = triangles.par_chunks(SHARE).map(of_some).collect();
        let all = Self::from_points(parts.iter().flat_map(|part| [part.0, part.1]));
        if !parts.iter().any(|part| part.2) {
            return all;
        }
        let Some(sound) = triangles.iter().find(|t| !is_flat(corners(t))) else {
            return all;
        };
        let inside = sound[0];
        let shapes = triangles.iter().map(corners).filter(|t| !is_flat(*t));
        let units = Self::from_points(shapes.flatten());
        let reaches_out = |t: &[u32; 3]| corners(t).iter().any(|c| !units.holds(*c));
        let outside = triangles.iter_mut().filter(|t| reaches_out(t));
        outside.for_each(|t| *t = [inside; 3]);
        units
    }

    fn from_points(points: impl Iterator<Item = DVec3>) -> Self {
        let [min, max] = points.fold(EMPTY, |[lo, hi], p| [lo.min(p), hi.max(p)]);
        let [min, max] = if min.x <= max.x {
            [min, max]
        } else {
            [DVec3::ZERO; 2]
        };
        Self {
            min,
            max,
            scale: power_of_two_below_inverse((max - min).length()),
        }
    }

    /// Lower and upper corner of the bounding box, file units.
    pub fn bounding_box(&self) -> [DVec3; 2] {
        [self.min, self.max]
    }

    /// Whether a point of the file is in the bounding box.
    fn holds(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// Diagonal of the bounding box, file units. In local ones it is the [local diagonal](Self::local_diagonal).
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// Diagonal of the bounding box, local units.
    pub fn local_diagonal(&self) -> f64 {
        self.length_to_local(self.diagonal())
    }

    /// The local origin: the bounding box's centre, file units.
    pub fn origin(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Largest coordinate of the bounding box in absolute value, file units.
    pub fn offset(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// A point of the file in local units.
    pub fn to_local(&self, file: [f64; 3]) -> DVec3 {
        (DVec3::from(file) - self.origin()) * self.scale
    }

    /// A local point in the file's units and axes.
    pub fn to_file(&self, local: DVec3) -> DVec3 {
        local / self.scale + self.origin()
    }

    /// A length of the file in local units.
    pub fn length_to_local(&self, file: f64) -> f64 {
        file * self.scale
    }

    /// A local length in file units.
    pub fn length_to_file(&self, local: f64) -> f64 {
        local / self.scale
    }

    /// A local area in file units squared.
    pub fn area_to_file(&self, local: f64) -> f64 {
        local / self.scale / self.scale
    }
}

/// 2^−k with size · 2^−k in [1, 2); 1 for sizes that have no such power.
fn power_of_two_below_inverse(size: f64) -> f64 {
    if !(size.is_normal() && size > 1e-290 && size < 1e290) {
        return 1.0;
    }
    let exponent = ((size.to_bits() >> 52) & 0x7ff) as i64 - 1023;
    f64::from_bits(((1023 - exponent) as u64) << 52)
}
