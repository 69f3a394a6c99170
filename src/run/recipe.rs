//! Everything that changes the result, and nothing else.

use serde::{Deserialize, Serialize};

use super::{MaskId, Settings, SettingsError};
use crate::growth::{
    Boundary, Habitat, Join, Law, Parameters, PlaceError, SeedPlace, Slope, Steps,
};
use crate::substrate::{Substrate, SurfacePoint, UpAxis};

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
    /// When the effective radius reaches this length (file units); of several colonies, when one extends as far from
    /// its seed.
    Reach(f64),
    /// When the elements' discs cover this share of the pieces of the mesh that they are on, by area, as far as lichen
    /// may grow there.
    Cover(f64),
}

/// A complete, resolved recipe. Lengths are in the mesh file's units.
///
/// [`Settings::resolve`] makes one. Its fields may be altered: [`Run::new`](super::Run::new) and
/// [`grow`](super::grow()) check them again. Neither asks whether [`mesh`](Self::mesh) is the mesh that it is
/// given: [`Settings::check_mesh`] and [`Log::check`](crate::log::Log::check) do.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Version of the program that resolved it.
    pub version: String,
    /// The mesh.
    pub mesh: MeshId,
    /// Which axis of the mesh is up, where that is not the one of its format's convention: it decides where
    /// `top` and `highest` are.
    pub mesh_up: Option<UpAxis>,
    /// Where lichen may grow, unless everywhere.
    pub mask: Option<MaskId>,
    /// How steep the surface may be where it grows.
    pub slope: Option<Slope>,
    /// Element radius r: a millionth to half of the bounding box's diagonal; see [`RADIUS`](super::RADIUS).
    pub radius: f64,
    /// Curvature radius L: 2 r to 1000 r; see [`CURVATURE_RADIUS`](super::CURVATURE_RADIUS).
    pub curvature_radius: f64,
    /// Sticking bias B: -1 to 2; see [`BIAS`](super::BIAS).
    pub bias: f64,
    /// Curvature gain A: 0 to 100; see [`GAIN`](super::GAIN).
    pub gain: f64,
    /// Lowest sticking probability: 1e-6 to 1; see [`MIN_STICK`](super::MIN_STICK).
    pub min_stick: f64,
    /// Seed of every random stream.
    pub seed: u64,
    /// Where the seed elements go, one a colony.
    pub at: Vec<SeedPlace>,
    /// Launch radius over the effective radius: 1.1 to 100; see [`LAUNCH`](super::LAUNCH).
    pub launch: f64,
    /// Kill radius over the effective radius: above `launch`, up to 10,000; see [`KILL`](super::KILL).
    pub kill: f64,
    /// How walkers are joined.
    pub join: Join,
    /// How a walker moves.
    pub law: Law,
    /// How long steps may be.
    pub steps: Steps,
    /// What open edges do to a walker.
    pub boundary: Boundary,
    /// When growth is done.
    pub stop: StopRule,
}

impl Recipe {
    /// Its numbers as a growth model takes them, in the substrate's local units.
    pub fn parameters(&self, substrate: &Substrate) -> Parameters {
        let units = substrate.units();
        Parameters {
            radius: units.length_to_local(self.radius),
            curvature_radius: units.length_to_local(self.curvature_radius),
            bias: self.bias,
            gain: self.gain,
            min_stick: self.min_stick,
            launch: self.launch,
            kill: self.kill,
            join: self.join,
            law: self.law,
            steps: self.steps,
            boundary: self.boundary,
            slope: self.slope,
            seed: self.seed,
        }
    }

    /// The seed elements' places, one a colony.
    ///
    /// # Errors
    /// As [`SeedPlace::locate_all`].
    pub fn seeds(&self, substrate: &Substrate) -> Result<Vec<SurfacePoint>, PlaceError> {
        SeedPlace::locate_all(
            &self.at,
            &self.habitat(substrate),
            self.seed,
            self.radius_on(substrate),
        )
    }

    /// Where lichen may grow on a substrate that has the recipe's mask.
    pub fn habitat<'a>(&self, substrate: &'a Substrate) -> Habitat<'a> {
        Habitat::new(substrate, self.slope, self.radius_on(substrate))
    }

    /// An element's radius, local units.
    fn radius_on(&self, substrate: &Substrate) -> f64 {
        substrate.units().length_to_local(self.radius)
    }

    /// Checks it as settings are checked: NaN or a stop rule that cannot be met would have walkers walk for ever.
    pub(super) fn check(&self, substrate: &Substrate) -> Result<(), SettingsError> {
        let complete = Settings::from(self).complete()?;
        complete.measured(substrate.units().diagonal(), self.mesh.clone())?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Execution, GrowError, Length, grow};
    use crate::substrate::Soup;

    fn square() -> Substrate {
        let soup = Soup {
            positions: vec![
                [0.0; 3],
                [10.0, 0.0, 0.0],
                [10.0, 10.0, 0.0],
                [0.0, 10.0, 0.0],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            notes: Vec::new(),
        };
        Substrate::from_soup(soup).unwrap()
    }

    fn sound(substrate: &Substrate) -> Recipe {
        let settings = Settings {
            radius: Some(Length::Units(0.1)),
            ..Settings::default()
        };
        settings.resolve(substrate, "square").unwrap()
    }

    /// Cancelled before it starts, so that what is not refused ends too.
    fn refusal(substrate: &Substrate, recipe: &Recipe) -> Option<GrowError> {
        let execution = Execution::default();
        execution
            .cancel
            .store(true, std::sync::atomic::Ordering::Relaxed);
        grow(substrate, recipe, &execution, &mut ()).err()
    }

    #[test]
    fn what_was_altered_by_hand_is_checked_again() {
        type Alter = fn(&mut Recipe);
        let square = square();
        let sound = sound(&square);
        assert_eq!(refusal(&square, &sound), None);
        let altered: [(&str, Alter); 14] = [
            ("bias", |r| r.bias = f64::NAN),
            ("bias", |r| r.bias = 3.0),
            ("gain", |r| r.gain = f64::NAN),
            ("min-stick", |r| r.min_stick = f64::NAN),
            ("min-stick", |r| r.min_stick = 0.0),
            ("launch", |r| r.launch = f64::NAN),
            ("launch", |r| r.launch = -3.0),
            ("kill", |r| r.kill = 1.2),
            ("curvature-radius", |r| r.curvature_radius = 1e-9),
            ("elements", |r| r.stop = StopRule::Elements(0)),
            ("reach", |r| r.stop = StopRule::Reach(f64::NAN)),
            ("cover", |r| r.stop = StopRule::Cover(5.0)),
            ("radius", |r| r.radius = 9.0),
            ("radius", |r| (r.radius, r.curvature_radius) = (6.0, 60.0)),
        ];
        for (name, alter) in altered {
            let mut recipe = sound.clone();
            alter(&mut recipe);
            let message = match refusal(&square, &recipe) {
                Some(GrowError::Recipe(error)) => error.to_string(),
                other => panic!("{name}: {other:?}"),
            };
            assert!(message.starts_with(&format!("{name} ")), "{message}");
        }
    }

    #[test]
    fn seeds_outside_their_triangle_or_nowhere_are_refused() {
        let square = square();
        let triangle = |uv| SeedPlace::Triangle {
            triangle: 0,
            uv: Some(uv),
        };
        for place in [
            triangle([f64::NAN, 0.0]),
            triangle([3.0, -2.0]),
            triangle([0.5, 0.6]),
            SeedPlace::Point([f64::NAN, 0.0, 0.0]),
            SeedPlace::Point([0.0, f64::INFINITY, 0.0]),
        ] {
            let settings = Settings {
                at: Some(vec![place.clone()]),
                ..Settings::default()
            };
            let resolved = settings.resolve(&square, "square");
            assert!(
                matches!(resolved, Err(SettingsError::Place(_))),
                "{place:?}: {resolved:?}"
            );
            let recipe = Recipe {
                at: vec![place.clone()],
                ..sound(&square)
            };
            let refused = refusal(&square, &recipe);
            assert!(
                matches!(refused, Some(GrowError::Place(_))),
                "{place:?}: {refused:?}"
            );
        }
        assert!(triangle([1.0, 0.0]).locate(&square, 1, 0).is_ok());
    }
}
