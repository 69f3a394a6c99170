//! Triangles of a decimated skin that cut beneath the substrate, lifted: else the substrate shows through the lichen in
//! shards.
//!
//! The corners of the upper side lie on the lichen, but where the substrate is convex the middle of a wide triangle
//! lies below it. Such triangles are moved out as far as the deepest of some of their points lies, three times over,
//! because corners are moved along the mean of several triangles.

use glam::DVec3;
use rayon::prelude::*;

use super::outwards::face_outwards;
use crate::export::TriMesh;
use crate::substrate::Substrate;

/// Times that triangles are lifted.
const ROUNDS: usize = 3;

/// Height over the substrate of what is not beneath it, in element radii: triangles that lie in its faces flicker.
const CLEARANCE: f64 = 0.2;

/// How far a corner may be lifted in all, over the longest side of its triangles: beyond a right angle's edge, across
/// which a triangle is half as deep as it is wide, lichen would float.
const FARTHEST: f64 = 0.25;

/// Points in a triangle that are looked at, by the parts into which its sides are divided.
const PARTS: u32 = 4;

/// Lifts the triangles of the upper side of a decimated skin that cut beneath the substrate, by a quarter of the
/// longest side about a corner at most. The mesh is in the units and axes of the substrate's file, the radius of an
/// element in local units. What is not beneath stays to the bit, and so does the topology; the same on any number of
/// threads.
///
/// # Panics
/// When the mesh is not sound: see [`TriMesh::check`].
pub fn lift(mesh: &mut TriMesh, substrate: &Substrate, radius: f64) {
    let mut skin = Skin::new(mesh, substrate, CLEARANCE * radius);
    for _ in 0..ROUNDS {
        if !skin.lift() {
            break;
        }
    }
    for (v, &lifted) in skin.lifted.iter().enumerate() {
        if lifted > 0.0 {
            mesh.positions[v] = substrate.units().to_file(skin.places[v]).to_array();
        }
    }
    face_outwards(mesh);
}

/// The upper side of a skin, in local units.
struct Skin<'a> {
    substrate: &'a Substrate,
    clearance: f64,
    places: Vec<DVec3>,
    upper: Vec<[u32; 3]>,
    /// How far each vertex is lifted, and how far it may be.
    lifted: Vec<f64>,
    most: Vec<f64>,
    /// How far each triangle of `upper` is beneath, and which vertices have been lifted since that was found.
    depths: Vec<f64>,
    has_moved: Vec<bool>,
}

impl<'a> Skin<'a> {
    fn new(mesh: &TriMesh, substrate: &'a Substrate, clearance: f64) -> Self {
        let units = substrate.units();
        let places: Vec<DVec3> = mesh
            .positions
            .par_iter()
            .map(|&p| units.to_local(p))
            .collect();
        let facing: Vec<DVec3> = places.par_iter().map(|&p| facing(substrate, p)).collect();
        let is_upper = |t: &&[u32; 3]| {
            let out: DVec3 = t.iter().map(|&v| facing[v as usize]).sum();
            across(&places, t).dot(out) > 0.0
        };
        let upper: Vec<[u32; 3]> = mesh.triangles.iter().filter(is_upper).copied().collect();
        let mut most = vec![0.0f64; places.len()];
        for triangle in &upper {
            let farthest = FARTHEST * longest(&places, triangle);
            triangle
                .iter()
                .for_each(|&v| most[v as usize] = most[v as usize].max(farthest));
        }
        Self {
            substrate,
            clearance,
            lifted: vec![0.0; places.len()],
            depths: vec![0.0; upper.len()],
            has_moved: vec![true; places.len()],
            places,
            upper,
            most,
        }
    }

    /// Lifts once, and says whether anything was beneath.
    fn lift(&mut self) -> bool {
        let both = self.upper.par_iter().zip(&self.depths);
        let depth = |(t, &known): (&[u32; 3], &f64)| {
            let is_new = t.iter().any(|&v| self.has_moved[v as usize]);
            if is_new { self.depth(t) } else { known }
        };
        let depths: Vec<f64> = both.map(depth).collect();
        let mut out = vec![(DVec3::ZERO, 0.0f64); self.places.len()];
        for (triangle, &depth) in self.upper.iter().zip(&depths) {
            let across = across(&self.places, triangle);
            for &v in triangle {
                let (sum, deepest) = &mut out[v as usize];
                *sum += across;
                *deepest = deepest.max(depth);
            }
        }
        for (v, (sum, deepest)) in out.into_iter().enumerate() {
            let by = deepest.min(self.most[v] - self.lifted[v]);
            self.places[v] += sum.normalize_or_zero() * by;
            self.lifted[v] += by;
            self.has_moved[v] = by > 0.0;
        }
        self.depths = depths;
        self.depths.iter().any(|&depth| depth > 0.0)
    }

    /// How far the deepest of some points of a triangle lies beneath the side of the substrate that looks its way.
    fn depth(&self, triangle: &[u32; 3]) -> f64 {
        let out = across(&self.places, triangle).normalize_or_zero();
        // What bulges through it is no farther than it is wide.
        let within = longest(&self.places, triangle) + self.clearance;
        let [a, b, c] = triangle.map(|v| self.places[v as usize]);
        let point = |(i, j): (u32, u32)| {
            let share = |i: u32| f64::from(i) / f64::from(PARTS);
            a + (b - a) * share(i) + (c - a) * share(j)
        };
        let all = (0..=PARTS).flat_map(|i| (0..=PARTS - i).map(move |j| (i, j)));
        let inner = all.filter(|&(i, j)| i.max(j).max(PARTS - i - j) < PARTS);
        inner
            .map(|at| self.beneath(point(at), out, within))
            .fold(0.0, f64::max)
    }

    /// How far a place lies beneath where lichen may lie over the side of the substrate that looks along a direction,
    /// if that is within a distance.
    fn beneath(&self, place: DVec3, out: DVec3, within: f64) -> f64 {
        let Some(nearest) = self.substrate.nearest_facing(place, out, within) else {
            return 0.0;
        };
        let above = place - self.substrate.position(&nearest);
        let height = above.dot(self.substrate.normal(nearest.triangle));
        (self.clearance - height).max(0.0)
    }
}

/// Where the substrate nearest to a place looks.
fn facing(substrate: &Substrate, place: DVec3) -> DVec3 {
    substrate.normal(substrate.nearest(place).0.triangle)
}

/// Along the normal of a triangle, twice as long as its area.
fn across(places: &[DVec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| places[v as usize]);
    (b - a).cross(c - a)
}

fn longest(places: &[DVec3], triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| places[v as usize]);
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}
