//! Everything that changes the result, and nothing else.

use serde::{Deserialize, Serialize};

use crate::growth::{Boundary, Join, Law, SeedPlace, Steps};
use crate::substrate::UpAxis;

/// Which mesh a recipe was made for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshId {
    /// The mesh file's path as the user gave it.
    pub file: String,
    /// BLAKE3 hash of the file (and of the buffers that it refers to), hexadecimal.
    pub hash: String,
}

/// When growth is done, besides running out of surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopRule {
    /// At this many elements.
    Elements(u64),
    /// When the effective radius reaches this length (file units).
    Reach(f64),
    /// When the elements' discs cover this share of the lichen's component, by area.
    Cover(f64),
}

/// A complete, resolved recipe. Lengths are in the mesh file's units.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Version of the program that resolved it.
    pub version: String,
    /// The mesh.
    pub mesh: MeshId,
    /// Which axis of the mesh is up, where that is not the one of its format's convention: it decides where
    /// `top` and `highest` are.
    pub mesh_up: Option<UpAxis>,
    /// Element radius r.
    pub radius: f64,
    /// Curvature radius L.
    pub curvature_radius: f64,
    /// Sticking bias B.
    pub bias: f64,
    /// Curvature gain A.
    pub gain: f64,
    /// Lowest sticking probability.
    pub min_stick: f64,
    /// Seed of every random stream.
    pub seed: u64,
    /// Where the seed element goes.
    pub at: SeedPlace,
    /// Launch radius over the effective radius.
    pub launch: f64,
    /// Kill radius over the effective radius.
    pub kill: f64,
    /// How walkers are joined.
    pub join: Join,
    /// What a walker's way is.
    pub law: Law,
    /// How long steps may be.
    pub steps: Steps,
    /// What open edges do to a walker.
    pub boundary: Boundary,
    /// When growth is done.
    pub stop: StopRule,
}
