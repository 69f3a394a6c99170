//! Tangent frames at the corners of triangles, by MikkTSpace (M. S. Mikkelsen, *Simulation of
//! Wrinkled Surfaces Revisited*, 2008), in which glTF, Blender, Unreal and Unity read normal maps.

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::{Mat3, Vec3, Vec4};

use super::shown::Shown;
use crate::morphometry::smooth_normals;
use crate::substrate::SurfacePoint;

/// Frames of one triangle's corners, in the order of the substrate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Unit vectors, outwards.
    pub(super) normals: [Vec3; 3],
    /// A unit vector towards the image's right, and the sign of the one towards its top.
    pub(super) tangents: [Vec4; 3],
}

impl Frame {
    /// Of a triangle that is not shown.
    const NONE: Self = Self {
        normals: [Vec3::Y; 3],
        tangents: [Vec4::X; 3],
    };

    /// A direction in the axes of the normal map, as MikkTSpace prescribes: frames are interpolated
    /// by weight and not normalized.
    pub(super) fn to_tangent_space(self, weights: [f64; 3], direction: Vec3) -> Vec3 {
        let axes = self.axes(weights);
        let invertible = axes.determinant().abs() > 1e-6;
        let local = invertible.then(|| axes.inverse() * direction);
        let local = local.and_then(Vec3::try_normalize);
        // A normal map has no directions from beneath.
        local.map_or(Vec3::Z, |n| n.with_z(n.z.max(0.0)).normalize_or(Vec3::Z))
    }

    /// Tangent, bitangent and normal by weight.
    pub(super) fn axes(self, weights: [f64; 3]) -> Mat3 {
        let [a, b, c] = weights.map(|w| w as f32);
        let [n0, n1, n2] = self.normals;
        let [t0, t1, t2] = self.tangents.map(|t| t.truncate());
        let (normal, tangent) = (n0 * a + n1 * b + n2 * c, t0 * a + t1 * b + t2 * c);
        let bitangent = normal.cross(tangent) * self.tangents[0].w;
        Mat3::from_cols(tangent, bitangent, normal)
    }
}

/// The order of a triangle's corners that is counter-clockwise from outside, by whether its file has
/// it the other way.
pub(super) fn order(turned: bool) -> [usize; 3] {
    match turned {
        true => [0, 2, 1],
        false => [0, 1, 2],
    }
}

/// Those of every triangle that is shown; of the others [`Frame::NONE`].
pub(super) fn frames(shown: &Shown) -> Vec<Frame> {
    let mut faces = Faces {
        shown,
        numbers: shown.triangles().collect(),
        frames: unturned(shown),
    };
    // It fails only for faces of other than three or four corners.
    let _ = generate_tangents(&mut faces);
    faces.frames
}

/// With some tangent for each normal. Normals are the file's, for its mesh is what the maps will be put on; those that
/// it lacks are of the smooth surface.
pub(super) fn unturned(shown: &Shown) -> Vec<Frame> {
    const CORNERS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let corners = |t: u32| CORNERS.map(|w| SurfacePoint::from_weights(t, w));
    let places: Vec<SurfacePoint> = shown.triangles().flat_map(corners).collect();
    let normals = smooth_normals(shown.substrate, &places);
    let mut frames = vec![Frame::NONE; shown.substrate.triangles().len()];
    for (t, smooth) in shown.triangles().zip(normals.as_chunks().0) {
        let normals = shown.texturing.normals_of(shown.substrate, t);
        let normals = normals.unwrap_or(*smooth);
        let normals = normals.map(|n| n.as_vec3().normalize_or(Vec3::Y));
        frames[t as usize] = Frame {
            normals,
            tangents: normals.map(|n| n.any_orthonormal_vector().extend(1.0)),
        };
    }
    frames
}

struct Faces<'a> {
    shown: &'a Shown<'a>,
    /// Of the triangles.
    numbers: Vec<u32>,
    /// Of all triangles.
    frames: Vec<Frame>,
}

impl Faces<'_> {
    /// A triangle and its corner.
    fn corner(&self, face: usize, vertex: usize) -> (u32, usize) {
        let triangle = self.numbers[face];
        let turned = self.shown.substrate.winding().side(triangle) < 0.0;
        (triangle, order(turned)[vertex])
    }
}

/// The same on every machine.
struct Portable;

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

impl Geometry<Portable> for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.numbers.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vertex: usize) -> [f32; 3] {
        let (triangle, corner) = self.corner(face, vertex);
        let place = self.shown.substrate.corners(triangle)[corner];
        place.as_vec3().to_array()
    }

    fn normal(&self, face: usize, vertex: usize) -> [f32; 3] {
        let (triangle, corner) = self.corner(face, vertex);
        self.frames[triangle as usize].normals[corner].to_array()
    }

    /// With rows counted from below, so that the second axis points to the image's top, as glTF and
    /// OpenGL have it.
    fn tex_coord(&self, face: usize, vertex: usize) -> [f32; 2] {
        let (triangle, corner) = self.corner(face, vertex);
        let uvs = self.shown.uvs_of(triangle);
        let [u, v] = uvs.map_or([0.0; 2], |uvs| uvs[corner]);
        [u as f32, (1.0 - v) as f32]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vertex: usize) {
        let (triangle, corner) = self.corner(face, vertex);
        let Some(space) = space.filter(|_| self.shown.uvs_of(triangle).is_some()) else {
            return;
        };
        let [x, y, z, sign] = space.tangent_encoded();
        if let Some(tangent) = Vec3::new(x, y, z).try_normalize() {
            self.frames[triangle as usize].tangents[corner] = tangent.extend(sign);
        }
    }
}
