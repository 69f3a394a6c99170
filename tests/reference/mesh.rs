//! The triangle mesh: a 2-D frame in every triangle and the neighbour across every edge.

use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// A place on the surface: a triangle and a point in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) triangle: usize,
    pub(crate) at: DVec2,
}

/// Edge of a triangle in the triangle's frame, run from the vertex with the smaller number, so that both triangles of
/// an edge measure along it in the same direction whatever their windings are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) base: DVec2,
    pub(crate) along: DVec2,
    /// Unit normal towards the inside of the triangle.
    pub(crate) inward: DVec2,
    pub(crate) length: f64,
    /// Triangle on the other side and which of its edges this is; none at a boundary.
    pub(crate) across: Option<(usize, usize)>,
}

impl Edge {
    /// Signed distance from the edge's line, positive inside.
    pub(crate) fn height(&self, at: DVec2) -> f64 {
        (at - self.base).dot(self.inward)
    }

    /// Whether the triangle lies on the left of the edge in its own frame.
    pub(crate) fn on_left(&self) -> bool {
        self.along.perp().dot(self.inward) > 0.0
    }
}

/// A triangle with its frame: origin at its first corner, x along its first edge, y towards its third corner.
#[derive(Clone, Debug)]
pub(crate) struct Triangle {
    pub(crate) ids: [usize; 3],
    pub(crate) corners: [DVec3; 3],
    pub(crate) flat: [DVec2; 3],
    pub(crate) x: DVec3,
    pub(crate) y: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) edges: [Edge; 3],
}

impl Triangle {
    fn new(ids: [usize; 3], corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let x = (b - a).normalize();
        let normal = (b - a).cross(c - a).normalize();
        let y = normal.cross(x);
        let flat = corners.map(|p| DVec2::new((p - a).dot(x), (p - a).dot(y)));
        let edges = [0, 1, 2].map(|k| flat_edge(ids, flat, k));
        Self {
            ids,
            corners,
            flat,
            x,
            y,
            normal,
            edges,
        }
    }

    /// The point of space at `at`.
    pub(crate) fn lift(&self, at: DVec2) -> DVec3 {
        self.corners[0] + self.x * at.x + self.y * at.y
    }

    /// The direction in space of a direction in the frame.
    pub(crate) fn lift_direction(&self, direction: DVec2) -> DVec3 {
        self.x * direction.x + self.y * direction.y
    }

    /// Foot of the perpendicular from `p` on the triangle's plane, and the signed height of `p` above it.
    pub(crate) fn project(&self, p: DVec3) -> (DVec2, f64) {
        let offset = p - self.corners[0];
        let foot = DVec2::new(offset.dot(self.x), offset.dot(self.y));
        (foot, offset.dot(self.normal))
    }

    /// Whether a point of the plane is in the triangle, its edges included.
    pub(crate) fn contains(&self, at: DVec2) -> bool {
        self.edges.iter().all(|edge| edge.height(at) >= 0.0)
    }

    pub(crate) fn area(&self) -> f64 {
        0.5 * self.flat[1].x * self.flat[2].y
    }

    pub(crate) fn centre(&self) -> DVec3 {
        (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0
    }

    /// Distance q from the centre to the farthest corner.
    pub(crate) fn reach(&self) -> f64 {
        let centre = self.centre();
        self.corners
            .iter()
            .map(|p| p.distance(centre))
            .fold(0.0, f64::max)
    }

    /// The point of the triangle nearest to `p`, in the frame.
    pub(crate) fn nearest(&self, p: DVec3) -> DVec2 {
        let (foot, _) = self.project(p);
        if self.contains(foot) {
            return foot;
        }
        let on_edge = |edge: &Edge| {
            let s = (foot - edge.base).dot(edge.along).clamp(0.0, edge.length);
            edge.base + edge.along * s
        };
        let candidates = self.edges.each_ref().map(on_edge);
        let nearer = |a: &DVec2, b: &DVec2| {
            a.distance_squared(foot)
                .total_cmp(&b.distance_squared(foot))
        };
        candidates.into_iter().min_by(nearer).unwrap_or(foot)
    }

    /// Distance in space from `p` to the triangle.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        self.lift(self.nearest(p)).distance(p)
    }
}

fn flat_edge(ids: [usize; 3], flat: [DVec2; 3], k: usize) -> Edge {
    let (mut from, mut to) = (k, (k + 1) % 3);
    if ids[from] > ids[to] {
        std::mem::swap(&mut from, &mut to);
    }
    let (base, third) = (flat[from], flat[(k + 2) % 3]);
    let along = (flat[to] - base).normalize();
    let side = along.perp();
    let inward = if (third - base).dot(side) > 0.0 {
        side
    } else {
        -side
    };
    let length = flat[to].distance(base);
    Edge {
        base,
        along,
        inward,
        length,
        across: None,
    }
}

/// A welded manifold mesh, with or without boundary.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) triangles: Vec<Triangle>,
    /// Triangles around each vertex.
    pub(crate) around: Vec<Vec<usize>>,
}

impl Mesh {
    /// Builds frames and adjacency by undirected edge.
    ///
    /// # Panics
    /// If an edge has more than two triangles: the reference takes manifold input only.
    pub(crate) fn new(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let build = |t: &[u32; 3]| {
            let ids = t.map(|v| v as usize);
            Triangle::new(ids, ids.map(|v| DVec3::from_array(vertices[v])))
        };
        let mut triangles: Vec<Triangle> = triangles.iter().map(build).collect();
        connect(&mut triangles);
        let mut around = vec![Vec::new(); vertices.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            triangle.ids.iter().for_each(|&v| around[v].push(t));
        }
        Self { triangles, around }
    }

    /// The point of space at a place.
    pub(crate) fn lift(&self, place: Place) -> DVec3 {
        self.triangles[place.triangle].lift(place.at)
    }

    /// The surface point nearest to `p`, by trying every triangle.
    pub(crate) fn nearest(&self, p: DVec3) -> Place {
        let distances = self.triangles.iter().map(|t| t.distance(p)).enumerate();
        let best = distances.min_by(|a, b| a.1.total_cmp(&b.1));
        let triangle = best.expect("a mesh has triangles").0;
        let at = self.triangles[triangle].nearest(p);
        Place { triangle, at }
    }

    /// Triangles that can be walked to from `start`, over edges.
    pub(crate) fn component(&self, start: usize) -> Vec<usize> {
        let mut seen = vec![false; self.triangles.len()];
        seen[start] = true;
        let mut found = vec![start];
        let mut next = 0;
        while next < found.len() {
            let edges = &self.triangles[found[next]].edges;
            for (t, _) in edges.iter().filter_map(|e| e.across) {
                if !std::mem::replace(&mut seen[t], true) {
                    found.push(t);
                }
            }
            next += 1;
        }
        found.sort_unstable();
        found
    }
}

fn connect(triangles: &mut [Triangle]) {
    let mut sides: HashMap<[usize; 2], Vec<(usize, usize)>> = HashMap::new();
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let mut key = [triangle.ids[k], triangle.ids[(k + 1) % 3]];
            key.sort_unstable();
            sides.entry(key).or_default().push((t, k));
        }
    }
    for side in sides.values() {
        assert!(side.len() <= 2, "an edge with {} triangles", side.len());
        if let [a, b] = side[..] {
            triangles[a.0].edges[a.1].across = Some(b);
            triangles[b.0].edges[b.1].across = Some(a);
        }
    }
}
