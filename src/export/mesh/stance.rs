//! Where an object stands in its scene.

use glam::{DMat3, DQuat, DVec3, Vec3};
use serde_json::{Value, json};

use crate::export::Placement;

/// An object's own origin and axes, in the space of its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Its origin.
    pub(super) origin: [f64; 3],
    /// How its axes are turned: a unit quaternion x, y, z, w.
    pub(super) rotation: [f64; 4],
    /// Length of its unit.
    pub(super) scale: f64,
}

/// How far axes may be from upright on one another, and their lengths from each other, as shares.
const ROUND_OFF: f64 = 1e-5;

impl Stance {
    /// That of the scene.
    pub(super) const NONE: Self = Self {
        origin: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: 1.0,
    };

    /// The stance by the columns of an affine matrix: where the axes go, and the origin. Of axes that are skewed or
    /// mirrored only the origin is taken, and of axes of several lengths no length. Nothing where the origin is
    /// nowhere.
    pub fn from_columns([x, y, z, origin]: [[f64; 3]; 4]) -> Option<Self> {
        let at_origin = Self {
            origin,
            ..Self::NONE
        };
        let axes = DMat3::from_cols_array_2d(&[x, y, z]);
        let is_somewhere = origin.iter().all(|x| x.is_finite());
        is_somewhere.then(|| turned(&axes).map_or(at_origin, |s| Self { origin, ..s }))
    }

    /// What tells it from others.
    pub(super) fn bits(&self) -> [u64; 8] {
        let ([x, y, z], [a, b, c, d]) = (self.origin, self.rotation);
        [x, y, z, a, b, c, d, self.scale].map(f64::to_bits)
    }

    /// Turned and scaled with its scene.
    pub(super) fn place(&mut self, placement: &Placement) {
        self.origin = placement.point(self.origin);
        let back = placement.orientation([0.0, 0.0, 0.0, 1.0]);
        let turn = DQuat::from_array(back);
        let turned = turn * DQuat::from_array(self.rotation) * turn.inverse();
        self.rotation = turned.to_array();
    }

    /// A place of the scene in its own axes.
    pub(super) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let moved = DVec3::from(p) - DVec3::from(self.origin);
        (DQuat::from_array(self.rotation).inverse() * moved / self.scale).to_array()
    }

    /// A unit vector of the scene in its own axes.
    pub(super) fn direction(&self, v: [f32; 3]) -> [f32; 3] {
        if self.rotation == Self::NONE.rotation {
            return v;
        }
        let turned = DQuat::from_array(self.rotation).inverse() * Vec3::from(v).as_dvec3();
        turned.as_vec3().to_array()
    }

    /// As a node of glTF has it; what changes nothing is not said.
    pub(super) fn said_in(&self, node: &mut Value) {
        if self.origin != [0.0; 3] {
            node["translation"] = json!(self.origin);
        }
        if self.rotation != Self::NONE.rotation {
            node["rotation"] = json!(self.rotation);
        }
        if self.scale != 1.0 {
            node["scale"] = vec![self.scale; 3].into();
        }
    }
}

/// About the origin, where the axes are upright on one another and right-handed.
fn turned(axes: &DMat3) -> Option<Stance> {
    let lengths = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
    let [x, y, z] = lengths;
    let is_sound = lengths.iter().all(|length| length.is_normal()) && axes.determinant() > 0.0;
    let units =
        is_sound.then(|| DMat3::from_cols(axes.x_axis / x, axes.y_axis / y, axes.z_axis / z))?;
    let (u, v, w) = (units.x_axis, units.y_axis, units.z_axis);
    let is_upright = [u.dot(v), v.dot(w), w.dot(u)]
        .iter()
        .all(|dot| dot.abs() < ROUND_OFF);
    let is_even = lengths
        .iter()
        .all(|length| (length / x - 1.0).abs() < ROUND_OFF);
    let is_still = (units - DMat3::IDENTITY)
        .to_cols_array()
        .iter()
        .all(|x| x.abs() < 1e-12);
    is_upright.then(|| Stance {
        rotation: match is_still {
            true => Stance::NONE.rotation,
            false => DQuat::from_mat3(&units).normalize().to_array(),
        },
        scale: if is_even { x } else { 1.0 },
        ..Stance::NONE
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(axes: DMat3, origin: [f64; 3]) -> [[f64; 3]; 4] {
        let [x, y, z] = axes.to_cols_array_2d();
        [x, y, z, origin]
    }

    #[test]
    fn places_come_back_through_the_node() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let upright = DMat3::from_quat(turn);
        let skewed =
            upright * DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let cases = [
            (upright * 0.25, Some((turn, 0.25))),
            (
                upright * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)),
                Some((turn, 1.0)),
            ),
            (
                upright * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
                None,
            ),
            (skewed, None),
            (upright * 0.0, None),
            (DMat3::IDENTITY * f64::NAN, None),
        ];
        let placements = [
            Placement::unchanged(crate::export::UpAxis::Y),
            Placement {
                from: crate::export::UpAxis::Z,
                to: crate::export::UpAxis::Y,
                scale: 0.01,
            },
        ];
        for ((axes, expected), placement) in cases.iter().flat_map(|c| placements.map(|p| (c, p))) {
            let mut stance = Stance::from_columns(columns(*axes, [5.0, -6.0, 7.0])).unwrap();
            stance.place(&placement);
            let (rotation, scale) = expected.unwrap_or((DQuat::IDENTITY, 1.0));
            assert!((stance.scale - scale).abs() < 1e-12);
            assert_eq!(stance.origin, placement.point([5.0, -6.0, 7.0]));
            // What the node does to what is stored is what the placement does to the scene.
            let p = placement.point([1.0, 2.0, 3.0]);
            let node = DQuat::from_array(stance.rotation);
            let back =
                node * (DVec3::from(stance.point(p)) * stance.scale) + DVec3::from(stance.origin);
            assert!(back.distance(DVec3::from(p)) < 1e-9, "{back}");
            // The object's own axes are turned with it.
            let axis = placement.turn((rotation * DVec3::Y).to_array());
            let own = placement.turn([0.0, 1.0, 0.0]);
            assert!((node * DVec3::from(own)).distance(DVec3::from(axis)) < 1e-9);
            let along = stance.direction(axis.map(|x| x as f32)).map(f64::from);
            assert!(DVec3::from(along).distance(DVec3::from(own)) < 1e-6);
        }
        assert_eq!(Stance::from_columns([[f64::INFINITY; 3]; 4]), None);
    }
}
