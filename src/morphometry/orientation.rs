//! Which way an element faces, and which way it grew.

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::Sample;

/// For each element the unit vector in its tangent plane that it grew along: from its parent to
/// itself, projected.
///
/// A seed takes the mean direction to its children. Where the projection vanishes, as round a
/// sharp edge, an element takes its parent's direction, projected; and where that vanishes too,
/// some direction of the tangent plane.
///
/// # Panics
/// When the slices of the sample differ in length, or an element is not born after its parent.
pub fn growth_directions(sample: &Sample<'_>) -> Vec<DVec3> {
    sample.assert_even();
    let children = means_to_children(sample);
    let mut directions: Vec<DVec3> = Vec::with_capacity(children.len());
    for (i, &parent) in sample.parents.iter().enumerate() {
        let normal = normal(sample, i);
        let wanted = match usize::try_from(parent) {
            Ok(parent) => [
                position(sample, i) - position(sample, parent),
                directions[parent],
            ],
            Err(_) => [children[i], DVec3::ZERO],
        };
        let tangent = wanted.into_iter().find_map(|d| tangent(d, normal));
        directions.push(tangent.unwrap_or_else(|| normal.any_orthonormal_vector()));
    }
    directions
}

/// For each element the unit quaternion x, y, z, w, w ≥ 0, of the rotation that takes the third
/// axis to the surface's normal and the second to the [direction of growth](growth_directions): a
/// lobe that lies in the xy plane, its top up z and its tip along y, then lies on the surface and
/// points where the lichen grew. It is the frame that Houdini makes of `N` and `up`.
///
/// # Panics
/// When the slices of the sample differ in length, or an element is not born after its parent.
pub fn orientations(sample: &Sample<'_>) -> Vec<[f64; 4]> {
    let frame = |(i, y): (usize, DVec3)| {
        let z = normal(sample, i);
        let q = DQuat::from_mat3(&DMat3::from_cols(y.cross(z), y, z)).normalize();
        if q.w < 0.0 { -q } else { q }.to_array()
    };
    let directions = growth_directions(sample).into_iter();
    directions.enumerate().map(frame).collect()
}

fn position(sample: &Sample<'_>, i: usize) -> DVec3 {
    sample.positions[i].into()
}

fn normal(sample: &Sample<'_>, i: usize) -> DVec3 {
    let normal = Vec3::from(sample.normals[i]).as_dvec3();
    normal.normalize_or(DVec3::Z)
}

/// The part of `d` along the plane, unless it is a mere rounding error of it.
fn tangent(d: DVec3, normal: DVec3) -> Option<DVec3> {
    let along = d.try_normalize()?.reject_from_normalized(normal);
    let again = (along.length() > 1e-4).then(|| along.normalize())?;
    again.reject_from_normalized(normal).try_normalize()
}

/// For each element the sum of the unit vectors to its children.
fn means_to_children(sample: &Sample<'_>) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; sample.positions.len()];
    for (i, &parent) in sample.parents.iter().enumerate() {
        if let Ok(parent) = usize::try_from(parent) {
            let way = position(sample, i) - position(sample, parent);
            sums[parent] += way.normalize_or_zero();
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morphometry::test_lichen::blob;

    #[test]
    #[should_panic(expected = "columns of [9, 9, 5]")]
    fn columns_of_different_lengths_are_refused() {
        let mut lichen = blob(9, 1);
        lichen.parents.truncate(5);
        orientations(&lichen.sample());
    }

    #[test]
    fn axes_follow_the_surface_and_the_growth() {
        let blob = blob(500, 11);
        let sample = blob.sample();
        for (i, q) in orientations(&sample).into_iter().enumerate() {
            let q = DQuat::from_array(q);
            let normal = Vec3::from(blob.normals[i]).as_dvec3().normalize();
            assert!((q * DVec3::Z - normal).length() < 1e-12);
            assert!((q.length() - 1.0).abs() < 1e-12 && q.w >= 0.0);
            let Ok(parent) = usize::try_from(blob.parents[i]) else {
                continue;
            };
            let way = blob.position(i) - blob.position(parent);
            let (x, y) = (q * DVec3::X, q * DVec3::Y);
            let along = way.dot(y);
            assert!(along > 0.0 && way.dot(x).abs() < 1e-9 * along, "{i}");
        }
    }

    #[test]
    fn a_seed_points_to_its_children_and_a_lone_one_somewhere() {
        let normals = [[0.0, 0.0, 1.0]; 3];
        let sample = Sample {
            radius: 0.5,
            positions: &[[0.0; 3], [0.0, 1.0, 0.3], [1.0, 0.0, -0.3]],
            normals: &normals,
            parents: &[-1, 0, 0],
        };
        let seed = growth_directions(&sample)[0];
        assert!((seed - DVec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-12);
        let alone = Sample {
            positions: &sample.positions[..1],
            normals: &normals[..1],
            parents: &[-1],
            ..sample
        };
        let direction = growth_directions(&alone)[0];
        assert!((direction.length() - 1.0).abs() < 1e-12 && direction.z == 0.0);
    }

    /// Round a right-angled edge: the third has grown straight down its own normal.
    #[test]
    fn where_the_projection_vanishes_the_parents_direction_goes_on() {
        let sample = Sample {
            radius: 0.5,
            positions: &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, -1.0]],
            normals: &[[0.0, 0.0, 1.0], [0.8, 0.0, 0.6], [0.0, 0.0, 1.0]],
            parents: &[-1, 0, 1],
        };
        let directions = growth_directions(&sample);
        assert!((directions[1] - DVec3::new(0.6, 0.0, -0.8)).length() < 1e-6);
        assert!((directions[2] - DVec3::X).length() < 1e-12);
    }
}
