//! What a growth law is told, in the substrate's local units.

use serde::{Deserialize, Serialize};

use super::Slope;

/// How a walker that sticks is joined to the lichen (Sumner 2001, 6.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Join {
    /// Rotated about the element that it touched until it touches a second one.
    Pack,
    /// Left where it first touches, as plain diffusion-limited aggregation does.
    Touch,
}

/// How a walker moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Law {
    /// Steps, each tested for contact only where it ends (Sumner 2001, 6.3).
    Thesis,
    /// Brownian motion, which touches where a continuous path first would.
    Brownian,
}

/// Whether walkers may take steps longer than an element's radius (Sumner 2001, 6.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Steps {
    /// As long as no element can be missed; those far from all elements over coarser copies of
    /// a fine mesh.
    Large,
    /// As long as no element can be missed, all over the mesh itself.
    Exact,
    /// Never longer than an element's radius: slow, for checking.
    Small,
}

/// What an edge with a triangle on one side only does to a walker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Boundary {
    /// The walk continues as if mirrored at the edge.
    Reflect,
    /// The walker is lost and a new one is launched.
    Absorb,
}

/// Everything that decides growth but the mesh and the seed element's place.
///
/// Lengths are in the substrate's local units.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Radius r of an element.
    pub radius: f64,
    /// Radius L of the disc over which the front's curvature is measured.
    pub curvature_radius: f64,
    /// Sticking probability B at a flat front.
    pub bias: f64,
    /// Gain A on the curvature.
    pub gain: f64,
    /// Lowest sticking probability, in (0, 1].
    pub min_stick: f64,
    /// Launch radius over the effective radius.
    pub launch: f64,
    /// Kill radius over the effective radius.
    pub kill: f64,
    /// How walkers are joined.
    pub join: Join,
    /// How a walker moves.
    pub law: Law,
    /// How long steps may be.
    pub steps: Steps,
    /// What open edges do.
    pub boundary: Boundary,
    /// How steep the surface may be where lichen grows; of any steepness without one.
    pub slope: Option<Slope>,
    /// Seed of every random stream.
    pub seed: u64,
}

impl Parameters {
    /// Whether growth by them can end: lengths, shares and factors are finite and positive, bias and gain finite,
    /// and walkers are launched before they are killed.
    pub fn are_sound(&self) -> bool {
        let is_positive = |x: &f64| x.is_finite() && *x > 0.0;
        let positive = [
            self.radius,
            self.curvature_radius,
            self.min_stick,
            self.launch,
            self.kill,
        ];
        positive.iter().all(is_positive)
            && self.bias.is_finite()
            && self.gain.is_finite()
            && self.min_stick <= 1.0
            && self.launch < self.kill
    }
}

#[cfg(test)]
mod tests {
    use super::super::stick::tests::parameters;
    use super::*;

    #[test]
    fn what_growth_could_not_end_with_is_unsound() {
        let sound = parameters(0.5);
        assert!(sound.are_sound());
        let with = |change: fn(&mut Parameters)| {
            let mut changed = sound.clone();
            change(&mut changed);
            changed.are_sound()
        };
        assert!(!with(|p| p.radius = f64::NAN));
        assert!(!with(|p| p.curvature_radius = f64::INFINITY));
        assert!(!with(|p| p.bias = f64::NAN));
        assert!(!with(|p| p.gain = f64::INFINITY));
        assert!(!with(|p| p.min_stick = 0.0));
        assert!(!with(|p| p.min_stick = 1.5));
        assert!(!with(|p| p.kill = p.launch));
    }
}
