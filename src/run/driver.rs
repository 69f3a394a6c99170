//! The loop that grows: births, one after the other, until a rule says stop.

use super::{Execution, Observer, Progress, Recipe, StopRule};
use crate::cluster::{Cluster, Element, NO_PARENT};
use crate::growth::{Counts, GrowthModel, Halt, Parallel, Parameters, PlaceError, WalkerModel};
use crate::substrate::Substrate;

/// What a run made.
#[derive(Clone, Debug)]
pub struct Growth {
    /// The elements.
    pub cluster: Cluster,
    /// Why it ended.
    pub stopped: Stopped,
    /// What it took.
    pub counts: Counts,
    /// How the work was shared among threads.
    pub parallel: Parallel,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// It has the number of elements that was asked for.
    Elements,
    /// Its effective radius reached the length that was asked for.
    Reach,
    /// It covers the share that was asked for.
    Cover,
    /// No place is left free on its component.
    Full,
    /// It was told to stop.
    Cancelled,
    /// Its observer ended it.
    Observer,
}

/// Why a run could not start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GrowError {
    /// The seed element has no place.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// A length is not a positive finite number.
    #[error("{name} must be a positive length, not {value}")]
    Length {
        /// Which length.
        name: &'static str,
        /// What it was.
        value: f64,
    },
    /// The element is larger than the mesh.
    #[error(
        "the element radius {radius} is larger than the mesh (bounding-box diagonal {diagonal}); \
         choose a smaller --radius, such as {suggested} (auto)"
    )]
    RadiusTooLarge {
        /// Element radius, file units.
        radius: f64,
        /// Diagonal of the bounding box, file units.
        diagonal: f64,
        /// The radius that `auto` would choose.
        suggested: f64,
    },
    /// The element is too small beside the mesh for positions to resolve it.
    #[error(
        "the element radius {radius} is less than a 10-millionth of the mesh (bounding-box \
         diagonal {diagonal}); choose a larger --radius, such as {suggested} (auto)"
    )]
    RadiusTooSmall {
        /// Element radius, file units.
        radius: f64,
        /// Diagonal of the bounding box, file units.
        diagonal: f64,
        /// The radius that `auto` would choose.
        suggested: f64,
    },
}

/// Most elements: their ages are 32-bit numbers, and one is kept for 'none'.
const MOST_ELEMENTS: u64 = u32::MAX as u64 - 1;

/// Smallest radius over the diagonal.
const LEAST_RADIUS: f64 = 1e-7;

/// Grows a lichen by a recipe.
///
/// The result depends on the substrate and the recipe alone.
///
/// # Errors
/// When the radius does not fit the mesh, or the seed element has no place.
pub fn grow(
    substrate: &Substrate,
    recipe: &Recipe,
    execution: &Execution,
    observer: &mut dyn Observer,
) -> Result<Growth, GrowError> {
    check_lengths(substrate, recipe)?;
    let parameters = parameters(substrate, recipe);
    let place = recipe.at.locate(substrate, recipe.seed, 0)?;
    let seed = Element {
        at: place,
        position: substrate.position(&place),
        parent: NO_PARENT,
        colony: 0,
        probability: 1.0,
    };
    let cluster = Cluster::new(parameters.radius);
    let model: WalkerModel<'_> = WalkerModel::new(substrate, parameters);
    let mut model = model.on_threads(execution.threads);
    let run = Run {
        substrate,
        rule: recipe.stop,
        execution,
        observer,
        cluster,
    };
    let (cluster, stopped) = run.grow(&mut model, seed);
    Ok(Growth {
        cluster,
        stopped,
        counts: model.counts().clone(),
        parallel: *model.parallel(),
    })
}

struct Run<'a> {
    substrate: &'a Substrate,
    rule: StopRule,
    execution: &'a Execution,
    observer: &'a mut dyn Observer,
    cluster: Cluster,
}

impl Run<'_> {
    fn grow(mut self, model: &mut dyn GrowthModel, seed: Element) -> (Cluster, Stopped) {
        let mut next = seed;
        loop {
            self.cluster.push(next);
            model.born(&self.cluster);
            let progress = self.progress(model.counts());
            let flow = self.observer.born(&next, &progress);
            if let Some(stopped) = self.reached(&progress) {
                return (self.cluster, stopped);
            }
            if flow.is_break() {
                return (self.cluster, Stopped::Observer);
            }
            match model.next(&self.cluster, &|| self.execution.is_cancelled()) {
                Ok(element) if !self.execution.is_cancelled() => next = element,
                Err(Halt::NoFreeSurface) => return (self.cluster, Stopped::Full),
                Ok(_) | Err(Halt::Cancelled) => return (self.cluster, Stopped::Cancelled),
            }
        }
    }

    fn progress(&self, counts: &Counts) -> Progress {
        let seed = &self.cluster.elements()[0];
        let component = self.substrate.component_of(seed.at.triangle);
        let radius = self.cluster.extent().effective_radius();
        Progress {
            elements: self.cluster.len() as u64,
            effective_radius: self.substrate.units().length_to_file(radius),
            covered: (self.cluster.covered_area() / component.area).min(1.0),
            walkers: counts.walkers,
        }
    }

    fn reached(&self, progress: &Progress) -> Option<Stopped> {
        match self.rule {
            StopRule::Elements(n) => (progress.elements >= n).then_some(Stopped::Elements),
            StopRule::Reach(length) => {
                (progress.effective_radius >= length).then_some(Stopped::Reach)
            }
            StopRule::Cover(share) => (progress.covered >= share).then_some(Stopped::Cover),
        }
        .or((progress.elements >= MOST_ELEMENTS).then_some(Stopped::Full))
    }
}

fn check_lengths(substrate: &Substrate, recipe: &Recipe) -> Result<(), GrowError> {
    let (radius, diagonal) = (recipe.radius, substrate.units().diagonal());
    for (name, value) in [
        ("radius", radius),
        ("curvature radius", recipe.curvature_radius),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(GrowError::Length { name, value });
        }
    }
    let suggested = substrate.auto_radius();
    if radius > diagonal {
        return Err(GrowError::RadiusTooLarge {
            radius,
            diagonal,
            suggested,
        });
    }
    if radius < LEAST_RADIUS * diagonal {
        return Err(GrowError::RadiusTooSmall {
            radius,
            diagonal,
            suggested,
        });
    }
    Ok(())
}

/// A recipe's numbers in the substrate's local units.
fn parameters(substrate: &Substrate, recipe: &Recipe) -> Parameters {
    let units = substrate.units();
    Parameters {
        radius: units.length_to_local(recipe.radius),
        curvature_radius: units.length_to_local(recipe.curvature_radius),
        bias: recipe.bias,
        gain: recipe.gain,
        min_stick: recipe.min_stick,
        launch: recipe.launch,
        kill: recipe.kill,
        join: recipe.join,
        steps: recipe.steps,
        boundary: recipe.boundary,
        seed: recipe.seed,
    }
}
