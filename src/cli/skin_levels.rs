//! Skins of as many triangles as were asked for, level by level.

use std::path::Path;

use anyhow::Context;
use thallus::cluster::Cluster;
use thallus::export::TriMesh;
use thallus::skin::{self, Paint, Shape, decimate, lift};
use thallus::substrate::Substrate;

use super::failure::Failure;
use super::number::{count, short};
use super::skin_args::{FEWEST_TRIANGLES, Goal, SizeArgs};
use super::terminal::Voice;

/// As many times more triangles than were asked for are enough.
const ENOUGH: f64 = 1.1;

/// A skin that holds as many times more than the finest has lost its shape: it stands off from the mesh, as wide
/// triangles do that are lifted over bumps, or covers what lichen does not.
const BULGING: f64 = 1.5;

/// Where one bulges, this share of all triangles is next, or as many times that as it takes for more.
const STEP: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Resolution and falloff, in element radii, of coarser skins that may be decimated where a finer one cannot be: those
/// that keep the outline come first, and then those that close more and more of the lichen's holes, each of which needs
/// its triangles.
const COARSER: [[f64; 2]; 6] = [
    [4.0, 0.0],
    [8.0, 0.0],
    [10.0, 2.5],
    [10.0, 3.5],
    [10.0, 5.0],
    [10.0, 8.0],
];

/// All that a skin is made of.
pub(super) struct Grounds {
    pub(super) substrate: Substrate,
    pub(super) cluster: Cluster,
    pub(super) shape: Shape,
    pub(super) paint: Paint,
}

/// The least number above one in steps down from all: where one goal bulges, the next is that of all goals about it.
fn step_above(triangles: usize, all: usize) -> usize {
    let mut above = all;
    loop {
        let next = (STEP * above as f64) as usize;
        if next <= triangles {
            return above;
        }
        above = next;
    }
}

/// Makes one level after the other.
pub(super) struct Thinner {
    /// For coarser skins, if any could be needed.
    grounds: Option<Grounds>,
    level: Level,
    /// Triangles of the finest level.
    first: usize,
    /// What the finest skin holds when it is lifted; not known before a level is decimated.
    volume: Option<f64>,
    /// How many of [`COARSER`] have been tried.
    tried: usize,
    /// Whether it is known that the level cannot be decimated further.
    is_least: bool,
    voice: Voice,
}

/// A level that was made.
#[derive(Default)]
struct Level {
    /// What the next is made of.
    mesh: TriMesh,
    /// As it is to be seen, where that is not the same.
    lifted: Option<TriMesh>,
}

impl Thinner {
    pub(super) fn new(grounds: Grounds, mesh: TriMesh, size: &SizeArgs, voice: Voice) -> Self {
        let whole = mesh.triangles.len();
        let is_asked = size.decimate.is_some() || size.lod.is_some();
        Self {
            grounds: is_asked.then_some(grounds),
            first: size.decimate.map_or(whole, |goal: Goal| goal.of(whole)),
            volume: None,
            level: Level { mesh, lifted: None },
            tried: 0,
            is_least: false,
            voice,
        }
    }

    /// Comes down to the triangles of a level, or as near as can be.
    pub(super) fn thin(&mut self, level: usize, file: &Path) -> Result<(), Failure> {
        let goal = (self.first >> level).max(FEWEST_TRIANGLES);
        if goal >= self.triangles() {
            return Ok(());
        }
        let doing = format!("decimating to {} triangles", count(goal as u64));
        let spinner = self.voice.spinner(&doing);
        let thinned = self.decimate(goal);
        spinner.finish_and_clear();
        let coarser = thinned.with_context(|| file.display().to_string())?;
        self.tell(goal, coarser, file);
        Ok(())
    }

    /// The same, and the shape of the coarser skin that it took, if it did.
    fn decimate(&mut self, goal: usize) -> anyhow::Result<Option<Shape>> {
        let mut taken = None;
        if self.volume.is_none() {
            self.volume = Some(self.lifted(&self.level.mesh).volume());
        }
        if !self.is_least
            && let Some(level) = self.decimated(&self.level.mesh, goal)?
        {
            self.level = level;
        }
        while !self.is_enough(goal) {
            self.is_least = true;
            let Some(shape) = self.next_coarser() else {
                break;
            };
            if let Some(level) = self.coarser(&shape, goal)? {
                self.level = level;
                self.is_least = false;
                taken = Some(shape);
            }
        }
        Ok(taken)
    }

    /// One of about so many triangles, or of as many more as it takes to keep its shape, if that is fewer than the
    /// level has.
    fn decimated(&self, mesh: &TriMesh, goal: usize) -> anyhow::Result<Option<Level>> {
        let all = mesh.triangles.len();
        let mut triangles = goal;
        while triangles < all {
            let fewer = decimate(mesh, triangles)?;
            triangles = step_above(triangles.max(fewer.triangles.len()), all);
            if let Some(level) = self.sound(fewer) {
                return Ok(Some(level).filter(|level| self.is_less(level)));
            }
        }
        let whole = (all < self.triangles()).then(|| mesh.clone());
        Ok(whole.and_then(|whole| self.sound(whole)))
    }

    fn is_less(&self, level: &Level) -> bool {
        level.mesh.triangles.len() < self.triangles()
    }

    /// A mesh as a level, unless it bulges.
    fn sound(&self, mesh: TriMesh) -> Option<Level> {
        let lifted = self.lifted(&mesh);
        let most = self.volume.map_or(f64::INFINITY, |whole| BULGING * whole);
        (lifted.volume() <= most).then_some(Level {
            mesh,
            lifted: Some(lifted),
        })
    }

    fn lifted(&self, mesh: &TriMesh) -> TriMesh {
        let mut lifted = mesh.clone();
        if let Some(of) = &self.grounds {
            lift(&mut lifted, &of.substrate, of.cluster.radius());
        }
        lifted
    }

    fn triangles(&self) -> usize {
        self.level.mesh.triangles.len()
    }

    fn is_enough(&self, goal: usize) -> bool {
        self.triangles() as f64 <= ENOUGH * goal as f64
    }

    /// The shape of the next coarser skin.
    fn next_coarser(&mut self) -> Option<Shape> {
        let shape = self.grounds.as_ref()?.shape;
        let coarser = |[resolution, falloff]: &[f64; 2]| Shape {
            resolution: shape.resolution.max(*resolution),
            falloff: shape.falloff.max(*falloff),
            ..shape
        };
        let all = COARSER.iter().map(coarser);
        let mut rest = all.enumerate().skip(self.tried);
        let (place, next) = rest.find(|(_, next)| *next != shape)?;
        self.tried = place + 1;
        Some(next)
    }

    /// A coarser skin, decimated, if it has fewer triangles.
    fn coarser(&self, shape: &Shape, goal: usize) -> anyhow::Result<Option<Level>> {
        let Some(of) = &self.grounds else {
            return Ok(None);
        };
        // Lichen may be too small to be seen so coarsely.
        let Ok(mesh) = skin::skin(&of.substrate, &of.cluster, shape, &of.paint) else {
            return Ok(None);
        };
        self.decimated(&mesh, goal)
    }

    fn tell(&self, goal: usize, coarser: Option<Shape>, file: &Path) {
        let shown = file.display();
        let flags = |shape: &Shape| {
            let [resolution, falloff] = [shape.resolution, shape.falloff].map(short);
            format!("--resolution {resolution}r --falloff {falloff}r")
        };
        let [made, asked] = [self.triangles(), goal].map(|n| count(n as u64));
        if !self.is_enough(goal) {
            self.voice.warn(&format!(
                "{shown}: {made} triangles are left where {asked} were asked for: with fewer it would tear or lose its \
                 shape, and so would the coarsest skin: ask for more"
            ));
        } else if let Some(shape) = coarser {
            self.voice.note(&format!(
                "{shown}: {made} triangles of a coarser skin ({}), as the finer one would tear or lose its shape",
                flags(&shape)
            ));
        }
    }

    /// The level as it is to be seen.
    pub(super) fn shown(&self) -> TriMesh {
        let Level { mesh, lifted } = &self.level;
        lifted.as_ref().unwrap_or(mesh).clone()
    }

    /// The same of the last level.
    pub(super) fn last_shown(&mut self) -> TriMesh {
        let Level { mesh, lifted } = std::mem::take(&mut self.level);
        lifted.unwrap_or(mesh)
    }
}
