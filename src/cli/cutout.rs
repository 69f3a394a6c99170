//! A mesh that is cut out of images, or transparent, in places, where lichen would hang in the air.

use thallus::picture::{Coat, Finish};
use thallus::run::OPAQUE;
use thallus::substrate::{Mask, MaskError, Substrate, SurfacePoint, Texturing};

use super::number::percent;

/// What its materials do not leave open: that is seen of it in pictures that do not show its materials.
pub(crate) struct Cutout(Mask);

/// Places that are looked at.
const PLACES: usize = 8192;

/// A share of these is told of from here on.
const MANY: f64 = 0.005;

impl Cutout {
    /// None where all is seen.
    ///
    /// # Errors
    /// What there is to say where what is open cannot be told.
    pub(super) fn of(substrate: &Substrate, texturing: &Texturing) -> Result<Option<Self>, String> {
        let opaque = Mask::opaque(substrate, texturing).map_err(|e| {
            let problem = match e {
                MaskError::Image(problem) => problem,
                other => other.to_string(),
            };
            format!("it cannot be told where it is cut out of images: {problem}")
        })?;
        Ok((!opaque.is_white()).then_some(Self(opaque)))
    }

    /// Of what says where it is open.
    pub(super) fn hash(&self) -> String {
        self.0.hashes().join(" ")
    }

    /// Says how much of what is called so, where lichen `grows`, is open, and what to do.
    pub(super) fn warning(
        &self,
        substrate: &Substrate,
        (what, grows): (&str, impl Fn(&SurfacePoint) -> bool),
    ) -> Option<String> {
        let mut places = substrate.spread(PLACES);
        places.retain(grows);
        let open = places.iter().filter(|at| self.0.at(at) == 0.0).count();
        let share = open as f64 / places.len().max(1) as f64;
        (share >= MANY).then(|| {
            format!(
                "{} of {what} is cut out of images or transparent, and lichen grows there too: --mask {OPAQUE} keeps \
                 it off",
                percent((100.0 * share).round().max(1.0) / 100.0)
            )
        })
    }
}

impl Finish for Cutout {
    fn at(&self, _: u32, _: [f32; 3], _: [f32; 3]) -> Option<Coat> {
        None
    }

    fn has_openings(&self) -> bool {
        true
    }

    fn is_open(&self, triangle: u32, weights: [f32; 3], _: f32) -> bool {
        let at = SurfacePoint::from_weights(triangle, weights.map(f64::from));
        self.0.at(&at) == 0.0
    }
}

/// As a scene takes it.
pub(super) fn finish(cutout: Option<&Cutout>) -> Option<&dyn Finish> {
    cutout.map(|cutout| cutout as &dyn Finish)
}
