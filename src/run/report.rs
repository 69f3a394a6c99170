//! `report.json`: what a run took and came to.
//!
//! Its timings are different every time, and builds that grow the same bytes name themselves in it, so it is the one
//! file of a run that is not promised to be the same bytes again.

use serde::Serialize;

use super::{Execution, Growth, Recipe, StopRule, Stopped};
use crate::cluster::{Element, NO_PARENT};
use crate::growth::{Counts, Parallel};
use crate::substrate::Substrate;

/// What a run took and came to. Lengths and areas are in the mesh file's units.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RunReport {
    /// What the reader must know.
    pub note: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// The git commit that the program was built from, with `-dirty` where its sources had been changed since; none
    /// where the build could not tell.
    pub build: Option<&'static str>,
    /// The mesh.
    pub mesh: MeshSummary,
    /// Elements born, the seeds included.
    pub elements: usize,
    /// Colonies that these are of.
    pub colonies: usize,
    /// Effective radius R_e, about the centroid of all elements.
    pub effective_radius: f64,
    /// What `reach` is compared with: R_e, or of several colonies how far elements are from their colonies' seeds at
    /// most.
    pub reach: f64,
    /// Area of the elements' discs.
    pub covered_area: f64,
    /// Area of the elements' discs as a share of the pieces that the lichen is on, as far as it may grow there.
    pub covered_share: f64,
    /// The share of the area of these pieces on which it may grow, by mask and slope, as far as 20,000 places tell.
    pub habitat_share: f64,
    /// Why it ended: `elements`, `reach`, `cover`, `full`, `starved`, `hemmed`, `cancelled` or
    /// `observer`.
    pub stopped: &'static str,
    /// Why it ended, in words.
    pub stopped_because: String,
    /// What growth took.
    pub counts: Counts,
    /// Steps, for each walker launched.
    pub steps_per_walker: f64,
    /// Contacts, for each walker launched.
    pub contacts_per_walker: f64,
    /// Walkers launched, for each element that was born of one.
    pub walkers_per_element: f64,
    /// Seconds of each phase.
    pub seconds: Timings,
    /// Threads that there were to walk.
    pub threads: usize,
    /// How the threads shared the work.
    pub parallel: Parallel,
    /// The share of the growing in which only one thread had work to do; 1 on one thread.
    pub serial_share: f64,
}

/// Which mesh it was, in short.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshSummary {
    /// The file as the user gave it.
    pub file: String,
    /// Hash of its content.
    pub hash: String,
    /// Triangles kept.
    pub triangles: usize,
    /// Vertices after welding.
    pub vertices: usize,
    /// Connected pieces.
    pub components: usize,
    /// Area.
    pub area: f64,
    /// Lower and upper corner of the bounding box.
    pub bounding_box: [[f64; 3]; 2],
}

/// Wall-clock seconds of the phases of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Timings {
    /// Reading the file.
    pub load: f64,
    /// Welding, adjacency and everything else that is prepared once a mesh.
    pub precompute: f64,
    /// Growing.
    pub grow: f64,
    /// Writing every other file.
    pub write: f64,
}

const NOTE: &str = "Timings, how threads shared the work, and the build differ from run to run: of a run's files \
                    this one alone is not promised to be the same bytes again. Lengths and areas are in mesh units.";

fn serial_share(parallel: f64, all: f64) -> f64 {
    if all > 0.0 {
        (1.0 - parallel / all).max(0.0)
    } else {
        1.0
    }
}

impl RunReport {
    /// The report of a finished run.
    ///
    /// # Panics
    /// When it grew on another substrate, as far as that has no such triangles.
    pub fn new(
        substrate: &Substrate,
        recipe: &Recipe,
        growth: &Growth,
        seconds: Timings,
        execution: &Execution,
    ) -> Self {
        let cluster = &growth.cluster;
        let units = substrate.units();
        let counts = &growth.counts;
        let (habitat_share, habitat_area) =
            recipe.habitat(substrate).share_and_area(pieces(growth));
        Self {
            note: NOTE,
            version: env!("CARGO_PKG_VERSION"),
            build: option_env!("THALLUS_BUILD"),
            mesh: MeshSummary::new(substrate, recipe),
            elements: cluster.len(),
            colonies: seeds(growth).count(),
            effective_radius: units.length_to_file(cluster.extent().effective_radius()),
            reach: units.length_to_file(reach(growth)),
            covered_area: units.area_to_file(cluster.covered_area()),
            covered_share: covered_share(growth, habitat_area),
            habitat_share,
            stopped: growth.stopped.name(),
            stopped_because: growth.stopped.words(recipe),
            counts: counts.clone(),
            steps_per_walker: per(counts.steps, counts.walkers),
            contacts_per_walker: per(counts.contacts, counts.walkers),
            walkers_per_element: per(
                counts.walkers,
                cluster.len().saturating_sub(recipe.at.len()) as u64,
            ),
            seconds,
            threads: execution.threads.max(1),
            parallel: growth.parallel,
            serial_share: serial_share(growth.parallel.seconds, seconds.grow),
        }
    }

    /// The report as indented JSON with a line end.
    pub fn to_json(&self) -> String {
        let json = serde_json::to_string_pretty(self);
        json.unwrap_or_else(|e| format!("{{\"error\": {:?}}}", e.to_string())) + "\n"
    }
}

impl MeshSummary {
    fn new(substrate: &Substrate, recipe: &Recipe) -> Self {
        let report = substrate.report();
        Self {
            file: recipe.mesh.file.clone(),
            hash: recipe.mesh.hash.clone(),
            triangles: report.triangles,
            vertices: report.vertices,
            components: report.components.len(),
            area: report.area,
            bounding_box: report.bounding_box,
        }
    }
}

impl Stopped {
    /// One word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elements => "elements",
            Self::Reach => "reach",
            Self::Cover => "cover",
            Self::Full => "full",
            Self::Starved => "starved",
            Self::Hemmed => "hemmed",
            Self::Cancelled => "cancelled",
            Self::Observer => "observer",
        }
    }

    /// Why the run ended, as the end of a sentence.
    pub fn words(self, recipe: &Recipe) -> String {
        let is_alone = recipe.at.len() == 1;
        match (self, recipe.stop) {
            (Self::Elements, StopRule::Elements(1)) => "it has the element asked for".to_owned(),
            (Self::Elements, StopRule::Elements(_)) => {
                "it has as many elements as were asked for".to_owned()
            }
            (Self::Reach, StopRule::Reach(length)) if !is_alone => {
                format!("a colony extends as far from its seed as was asked for, {length:?}")
            }
            (Self::Reach, StopRule::Reach(length)) => {
                format!("its effective radius reached the {length:?} asked for")
            }
            (Self::Cover, StopRule::Cover(share)) => {
                format!("it covers the share of {share:?} asked for")
            }
            (Self::Elements | Self::Reach | Self::Cover, _) => {
                "it has the size asked for".to_owned()
            }
            (Self::Full, _) if recipe.mask.is_some() || recipe.slope.is_some() => {
                "no free surface is left where it may grow and can get to; other habitat is reached by colonies, or from \
                 elsewhere (at)"
                    .to_owned()
            }
            (Self::Full, _) if is_alone => "no free surface is left on its piece of the mesh".to_owned(),
            (Self::Full, _) => "no free surface is left on the pieces of the mesh that it is on".to_owned(),
            (Self::Starved, _) => {
                "open edges took ten million walkers since the last birth; a boundary that reflects loses none"
                    .to_owned()
            }
            (Self::Hemmed, _) => {
                "mask or slope hem it in: many walkers since the last birth found no place; other habitat is reached by \
                 colonies, or from elsewhere (at)"
                    .to_owned()
            }
            (Self::Cancelled, _) => "it was interrupted".to_owned(),
            (Self::Observer, _) => "its observer ended it".to_owned(),
        }
    }
}

/// The elements that colonies began with.
fn seeds(growth: &Growth) -> impl Iterator<Item = &Element> + Clone {
    let elements = growth.cluster.elements().iter();
    elements.take_while(|element| element.parent == NO_PARENT)
}

/// R_e, or of several colonies the farthest that an element is from its seed; local units.
fn reach(growth: &Growth) -> f64 {
    let seeds: Vec<&Element> = seeds(growth).collect();
    if seeds.len() < 2 {
        return growth.cluster.extent().effective_radius();
    }
    let from_seed = |e: &Element| e.position.distance(seeds[e.colony as usize].position);
    let elements = growth.cluster.elements().iter();
    elements.map(from_seed).fold(0.0, f64::max)
}

/// A triangle of each piece that the lichen is on, or several.
fn pieces(growth: &Growth) -> impl Iterator<Item = u32> + Clone {
    seeds(growth).map(|seed| seed.at.triangle)
}

/// Share of the area on which it may grow that its discs cover.
fn covered_share(growth: &Growth, area: f64) -> f64 {
    match growth.cluster.is_empty() {
        true => 0.0,
        false => (growth.cluster.covered_area() / area).min(1.0),
    }
}

fn per(count: u64, of: u64) -> f64 {
    count as f64 / of.max(1) as f64
}
