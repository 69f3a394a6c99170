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

/// Makes one level after the other.
pub(super) struct Thinner {
    /// For coarser skins, if any could be needed.
    grounds: Option<Grounds>,
    /// The level that was made last, before it was lifted.
    mesh: TriMesh,
    /// Triangles of the finest level.
    first: usize,
    /// How many of [`COARSER`] have been tried.
    tried: usize,
    is_decimated: bool,
    voice: Voice,
}

impl Thinner {
    pub(super) fn new(grounds: Grounds, mesh: TriMesh, size: &SizeArgs, voice: Voice) -> Self {
        let whole = mesh.triangles.len();
        let is_asked = size.decimate.is_some() || size.lod.is_some();
        Self {
            grounds: is_asked.then_some(grounds),
            first: size.decimate.map_or(whole, |goal: Goal| goal.of(whole)),
            mesh,
            tried: 0,
            is_decimated: false,
            voice,
        }
    }

    /// Comes down to the triangles of a level, or as near as can be.
    pub(super) fn thin(&mut self, level: usize, file: &Path) -> Result<(), Failure> {
        let goal = (self.first >> level).max(FEWEST_TRIANGLES);
        if goal >= self.mesh.triangles.len() {
            return Ok(());
        }
        let doing = format!("decimating to {} triangles", count(goal as u64));
        let spinner = self.voice.spinner(&doing);
        let thinned = self.decimate(goal);
        spinner.finish_and_clear();
        let coarser = thinned.with_context(|| file.display().to_string())?;
        self.is_decimated = true;
        self.tell(goal, coarser, file);
        Ok(())
    }

    /// The same, and the shape of the coarser skin that it took, if it did.
    fn decimate(&mut self, goal: usize) -> anyhow::Result<Option<Shape>> {
        let mut taken = None;
        self.mesh = decimate(&self.mesh, goal)?;
        while !self.is_enough(goal) {
            let Some(shape) = self.next_coarser() else {
                break;
            };
            if let Some(mesh) = self.coarser(&shape, goal)? {
                self.mesh = mesh;
                taken = Some(shape);
            }
        }
        Ok(taken)
    }

    fn is_enough(&self, goal: usize) -> bool {
        self.mesh.triangles.len() as f64 <= ENOUGH * goal as f64
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
        let rest = all.enumerate().skip(self.tried);
        let (place, next) = { rest }.find(|(_, next)| *next != shape)?;
        self.tried = place + 1;
        Some(next)
    }

    /// A coarser skin, decimated, if it has fewer triangles.
    fn coarser(&self, shape: &Shape, goal: usize) -> anyhow::Result<Option<TriMesh>> {
        let Some(of) = &self.grounds else {
            return Ok(None);
        };
        // Lichen may be too small to be seen so coarsely.
        let Ok(mesh) = skin::skin(&of.substrate, &of.cluster, shape, &of.paint) else {
            return Ok(None);
        };
        let mesh = decimate(&mesh, goal)?;
        Ok((mesh.triangles.len() < self.mesh.triangles.len()).then_some(mesh))
    }

    fn tell(&self, goal: usize, coarser: Option<Shape>, file: &Path) {
        let shown = file.display();
        let flags = |shape: &Shape| {
            let [resolution, falloff] = [shape.resolution, shape.falloff].map(short);
            format!("--resolution {resolution}r --falloff {falloff}r")
        };
        let [made, asked] = [self.mesh.triangles.len(), goal].map(|n| count(n as u64));
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
        self.lifted(self.mesh.clone())
    }

    /// The same of the last level.
    pub(super) fn last_shown(&mut self) -> TriMesh {
        let mesh = std::mem::take(&mut self.mesh);
        self.lifted(mesh)
    }

    fn lifted(&self, mut mesh: TriMesh) -> TriMesh {
        if let (Some(of), true) = (&self.grounds, self.is_decimated) {
            lift(&mut mesh, &of.substrate, of.cluster.radius());
        }
        mesh
    }
}
