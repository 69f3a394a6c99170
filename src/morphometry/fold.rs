//! Ways over a fold of the surface.

use glam::{DVec3, Vec3};

/// Cosine of the angle between normals up to which a surface counts as flat, 60°: ways are those
/// through space. Where its radius of curvature is greater than the distance in which one looks, all
/// normals are.
const FLAT: f32 = 0.5;

/// Cosine of the angle beyond which two faces are those of a plate and not of a fold: 154°.
const BACK: f32 = -0.9;

/// How far one end may lie on the wrong side of the other's plane, in the distance in which one
/// looks: faces are not quite flat.
const SLACK: f64 = 0.1;

/// The way between two places with these unit normals as if the surface between them were flat; none
/// when it is longer than `within`, or when they do not belong together.
///
/// Two places with normals far apart stand on the two sides of a fold when each is behind the
/// other's tangent plane, or each before it. The way between them leads over the line in which the
/// planes meet. It is laid out by turning the far plane about that line into the near one. The faces
/// of a plate do not meet, those of a slim wedge do so far away, and the way over there is long.
#[inline(always)]
pub(super) fn laid_out(
    through_space: DVec3,
    [normal, other]: [Vec3; 2],
    within: f64,
) -> Option<DVec3> {
    let cosine = normal.dot(other);
    match () {
        () if cosine > FLAT => Some(through_space),
        () if cosine < BACK => None,
        () => over_fold(through_space, [normal, other].map(Vec3::as_dvec3), within),
    }
}

#[inline(never)]
fn over_fold(through_space: DVec3, [normal, other]: [DVec3; 2], within: f64) -> Option<DVec3> {
    let axis = normal.cross(other);
    let sine = axis.length();
    let mut heights = [through_space.dot(other), -through_space.dot(normal)];
    let is_valley = heights[0] + heights[1] < 0.0;
    if is_valley {
        heights = heights.map(|h| -h);
    }
    if heights[0].min(heights[1]) < -SLACK * within {
        return None;
    }
    let across = (heights[0].max(0.0) + heights[1].max(0.0)) / sine;
    let axis = axis / sine;
    let along = through_space.dot(axis);
    let ahead = axis.cross(normal) * if is_valley { -across } else { across };
    (along * along + across * across <= within * within).then(|| axis * along + ahead)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::morphometry::test_lichen::{Lichen, are_near, blob, folded, plate};
    use crate::morphometry::{Morphometry, Neighbours, exposed_angles, measure};

    const LOOK: f64 = 10.0;

    fn measured(lichen: &Lichen) -> Morphometry {
        let sample = crate::morphometry::Sample {
            radius: 1.0,
            ..lichen.sample()
        };
        measure(&sample, LOOK)
    }

    /// Elements whose discs of this radius do not reach the lichen's end.
    fn inner(lichen: &Lichen, extent: f64) -> Vec<usize> {
        let all = 0..lichen.positions.len();
        all.filter(|&i| lichen.position(i).length() < extent)
            .collect()
    }

    #[test]
    fn a_closed_lichen_has_no_rim_at_a_fold() {
        let flat = measured(&folded(0.0, 60.0));
        for degrees in [30.0, 45.0, 75.0, 90.0, 120.0, 150.0, -45.0, -90.0, -150.0] {
            let lichen = folded(PI * degrees / 180.0, 60.0);
            let folded = measured(&lichen);
            for i in inner(&lichen, 45.0) {
                let [share, on_flat] = [&folded, &flat].map(|m| m.density[i]);
                // Between 30° and 60° ways cut across the fold.
                assert!(
                    (share / on_flat - 1.0).abs() < 0.1,
                    "{degrees}: {share} {on_flat}"
                );
                // So does every hop on the way to the rim, once.
                let [far, on_flat] = [&folded, &flat].map(|m| m.rim_distance[i].unwrap());
                assert!(
                    far > 0.0 && far > on_flat - LOOK,
                    "{degrees}: {far} {on_flat}"
                );
            }
        }
    }

    /// The end of a lichen is as long over a fold as on the flat.
    #[test]
    fn a_fold_adds_nothing_to_the_outline() {
        let outline = |degrees: f64| {
            let lichen = folded(PI * degrees / 180.0, 60.0);
            let neighbours = Neighbours::new(&lichen.positions, &lichen.normals, LOOK);
            exposed_angles(&neighbours).iter().sum::<f64>()
        };
        let flat = outline(0.0);
        for degrees in [90.0, 150.0, -90.0] {
            assert!((outline(degrees) / flat - 1.0).abs() < 0.03, "{degrees}");
        }
    }

    #[test]
    fn the_faces_of_a_plate_do_not_feel_each_other() {
        let flat = measured(&folded(0.0, 40.0));
        let both = measured(&plate(0.5, 40.0));
        let n = flat.density.len();
        for face in [0..n, n..2 * n] {
            assert_eq!(both.density[face.clone()], flat.density);
            assert_eq!(both.rim_distance[face], flat.rim_distance);
        }
    }

    #[test]
    fn a_way_laid_out_is_in_the_tangent_plane_and_no_shorter() {
        let lichen = blob(300, 2);
        let mut folds = 0;
        for i in 0..300 {
            for j in (0..300).filter(|&j| j != i) {
                assert_eq!(
                    are_near(&lichen, [i, j], 0.5),
                    are_near(&lichen, [j, i], 0.5)
                );
                let normals = [i, j].map(|k| Vec3::from(lichen.normals[k]));
                let through_space = lichen.position(j) - lichen.position(i);
                let way = laid_out(through_space, normals, 0.5);
                let Some(way) = way.filter(|_| normals[0].dot(normals[1]) < FLAT) else {
                    continue;
                };
                folds += 1;
                assert!(way.dot(normals[0].as_dvec3()).abs() < 1e-6);
                // But for the slack, over the least sine.
                assert!(way.length() > through_space.length() - 0.12);
            }
        }
        assert!(folds > 100, "{folds}");
    }
}
