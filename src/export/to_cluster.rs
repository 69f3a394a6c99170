//! A table back to a cluster on its mesh.

use super::Elements;
use crate::cluster::{Cluster, Element, NO_PARENT};
use crate::substrate::{Substrate, SurfacePoint};

/// The table is of a lichen on another mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("element {element} is not on this mesh: {problem}; name the mesh that the lichen grew on")]
pub struct OtherMeshError {
    /// Birth index of the first that does not fit.
    pub element: usize,
    problem: &'static str,
}

/// How far an element may lie from where its triangle and weights put it, in radii, besides what
/// float32 rounds.
const SLACK: f64 = 0.1;

impl Elements {
    /// The cluster that this is the table of, on the mesh that it grew on.
    ///
    /// Elements are where triangle and weights say, which files hold with 24 bits.
    ///
    /// # Errors
    /// When an element's triangle is not there, or is not where the element is.
    ///
    /// # Panics
    /// When columns differ in length: see [`Elements::check`].
    pub fn to_cluster(&self, substrate: &Substrate) -> Result<Cluster, OtherMeshError> {
        let stored = stored_triangles(substrate);
        let units = substrate.units();
        let radius = units.length_to_local(self.radius);
        let rounding =
            units.length_to_local(units.offset()) + units.length_to_local(units.diagonal());
        let slack = SLACK * radius + rounding / f64::from(1 << 22);
        let mut cluster = Cluster::new(radius);
        for i in 0..self.len() {
            let stray = |problem| OtherMeshError {
                element: i,
                problem,
            };
            let triangle = stored.get(self.triangle[i] as usize).copied();
            let triangle = triangle.ok_or_else(|| stray("it has no such triangle"))?;
            let [u, v] = self.uv[i].map(f64::from);
            let at = SurfacePoint { triangle, u, v };
            let position = substrate.position(&at);
            if (position - units.to_local(self.positions[i])).length() > slack {
                return Err(stray("its triangle lies elsewhere"));
            }
            cluster.push(Element {
                at,
                position,
                parent: u32::try_from(self.parent[i]).unwrap_or(NO_PARENT),
                colony: self.colony[i],
                probability: f64::from(self.probability[i]),
            });
        }
        Ok(cluster)
    }
}

/// For each canonical number the triangle as the substrate stores it.
fn stored_triangles(substrate: &Substrate) -> Vec<u32> {
    let count = substrate.triangles().len();
    let mut stored = vec![0; count];
    for t in 0..count as u32 {
        stored[substrate.canonical_triangle(t) as usize] = t;
    }
    stored
}
