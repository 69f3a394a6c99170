//! Skinned glTF meshes, in the pose that the joints of the file have (glTF 2.0, section 3.7.3.3).
//!
//! A vertex is where its joints take it from the pose that the mesh was bound in. The transform of the node that
//! shows the mesh does not count: exporters put that node anywhere, often below the joints.

use glam::{DAffine3, DMat3, DVec3};

use super::error::{LoadFault, Parsed};
use super::gltf::affine;
use super::gltf_accessor::Accessors;
use super::gltf_buffers::EXPORT_AGAIN;
use super::gltf_schema::{Primitive, Skin};

/// What each joint of a skin does to a vertex.
pub(super) struct Pose {
    joints: Vec<DAffine3>,
    /// Whether any of them turns things inside out.
    mirrors: bool,
}

/// Where joints take a vertex, and how far that turns it inside out: 1 not at all, −1 wholly.
struct Blend {
    transform: DAffine3,
    sense: f64,
}

/// Up to four joints of each vertex, by their numbers in the skin, and their weights.
type Influences = (Vec<[f64; 4]>, Vec<[f64; 4]>);

impl Pose {
    /// By the transforms of all nodes; none where a joint is no node of the scene, or there are no joints.
    pub(super) fn new(
        skin: &Skin,
        worlds: &[Option<DAffine3>],
        accessors: &Accessors,
        place: &str,
    ) -> Parsed<Option<Self>> {
        let world = |&joint: &usize| worlds.get(joint).copied().flatten();
        let worlds: Option<Vec<DAffine3>> = skin.joints.iter().map(world).collect();
        let Some(mut joints) = worlds.filter(|all| !all.is_empty()) else {
            return Ok(None);
        };
        if let Some(accessor) = skin.inverse_bind_matrices {
            let matrices = accessors.vectors::<16>(accessor, place)?;
            if matrices.len() < joints.len() {
                let problem = format!("{} matrices for {} joints", matrices.len(), joints.len());
                return Err(fault(accessors, place, problem));
            }
            for (number, (joint, matrix)) in joints.iter_mut().zip(&matrices).enumerate() {
                let bound = affine(matrix).filter(DAffine3::is_finite).ok_or_else(|| {
                    let problem = format!("the bind matrix of joint {number} is not affine");
                    fault(accessors, place, problem)
                })?;
                *joint *= bound;
            }
        }
        let mirrors = joints.iter().any(|joint| sense(joint) < 0.0);
        Ok(Some(Self { joints, mirrors }))
    }

    /// Whether the joints move a primitive's vertices.
    pub(super) fn moves(primitive: &Primitive) -> bool {
        accessors_of(primitive, 0).is_some()
    }

    /// Moves the vertices of a primitive. The sense of each, where any joint turns things inside out: it is not that
    /// of the blended matrix, which is flat and of either sense where joints are half a turn apart.
    pub(super) fn apply(
        &self,
        primitive: &Primitive,
        accessors: &Accessors,
        place: &str,
        positions: &mut [[f64; 3]],
    ) -> Parsed<Vec<f64>> {
        let sets = all_accessors_of(primitive).into_iter();
        let sets = sets.map(|set| influences(accessors, set, place, positions.len()));
        let sets = sets.collect::<Parsed<Vec<Influences>>>()?;
        let mut senses = Vec::new();
        for (vertex, position) in positions.iter_mut().enumerate() {
            let all = sets
                .iter()
                .flat_map(|(joints, weights)| joints[vertex].into_iter().zip(weights[vertex]));
            let blend = self.blend(all).map_err(|joint| {
                let problem = format!(
                    "vertex {vertex} hangs on joint {joint}, the skin has {}",
                    self.joints.len()
                );
                fault(accessors, place, problem)
            })?;
            let moved = blend
                .transform
                .transform_point3(DVec3::from_array(*position));
            *position = moved.to_array();
            senses.extend(self.mirrors.then_some(blend.sense));
        }
        Ok(senses)
    }

    /// The mean of the joints' transforms by their weights; that of the first where all weights are zero. An
    /// error is a joint that is not there.
    fn blend(&self, influences: impl Iterator<Item = (f64, f64)>) -> Result<Blend, f64> {
        let mut sum = (DMat3::ZERO, DVec3::ZERO, 0.0);
        let mut turned = 0.0;
        let mut first = None;
        for (joint, weight) in influences {
            let transform = self.joints.get(joint as usize);
            first = first.or(transform.copied());
            if weight == 0.0 {
                continue;
            }
            let transform = transform.ok_or(joint)?;
            sum.0 += transform.matrix3 * weight;
            sum.1 += transform.translation * weight;
            sum.2 += weight;
            turned += sense(transform) * weight;
        }
        if sum.2 == 0.0 {
            let transform = first.unwrap_or(self.joints[0]);
            let sense = sense(&transform);
            return Ok(Blend { transform, sense });
        }
        let transform = DAffine3 {
            matrix3: sum.0 * (1.0 / sum.2),
            translation: sum.1 / sum.2,
        };
        let sense = turned / sum.2;
        Ok(Blend { transform, sense })
    }
}

/// −1 for what turns things inside out.
fn sense(transform: &DAffine3) -> f64 {
    match transform.matrix3.determinant() < 0.0 {
        true => -1.0,
        false => 1.0,
    }
}

/// The accessors of a primitive's joints and weights, set by set: there may be several sets of four.
pub(super) fn all_accessors_of(primitive: &Primitive) -> Vec<[usize; 2]> {
    (0..)
        .map_while(|set| accessors_of(primitive, set))
        .collect()
}

fn accessors_of(primitive: &Primitive, set: usize) -> Option<[usize; 2]> {
    let accessor = |name: &str| primitive.attributes.get(format!("{name}_{set}").as_str());
    Some([*accessor("JOINTS")?, *accessor("WEIGHTS")?])
}

fn influences(
    accessors: &Accessors,
    set: [usize; 2],
    place: &str,
    vertices: usize,
) -> Parsed<Influences> {
    let [joints, weights] = set.map(|accessor| {
        let values = accessors.vectors::<4>(accessor, place)?;
        if values.len() < vertices {
            let problem = format!(
                "joints or weights of {} vertices, of {vertices}",
                values.len()
            );
            return Err(fault(accessors, place, problem));
        }
        Ok(values)
    });
    Ok((joints?, weights?))
}

fn fault(accessors: &Accessors, place: &str, problem: String) -> LoadFault {
    LoadFault::malformed(accessors.format, place, problem, EXPORT_AGAIN)
}
