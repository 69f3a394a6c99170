//! The skins of a growing lichen, one after the other (Sumner 2001, 8.2).
//!
//! Each is what [`skin`](super::skin()) makes of the elements by their influence at the moment. What does
//! not change is shared: how the surface is cut (see `refine.rs`), who stands near whom, when each
//! element left the rim. And what has not changed since the frame before is kept: the field is read
//! anew only at places that feel an element whose influence, density or distance from the rim has
//! changed.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::base::Winding;
use super::field::{Field, RING, Sample, cutoff};
use super::grid::{Grid, Nearness};
use super::history::{History, RimDistances};
use super::lichen::{Granule, Lichen, far};
use super::march::{Outline, Samples, close};
use super::refine::{NEVER, Tree};
use super::sheet::Sheet;
use super::{Paint, Shape, SkinError, UNDERSIDE, finish, refine};
use crate::cluster::{Cluster, Presence};
use crate::export::TriMesh;
use crate::substrate::Substrate;

/// Lichens whose distances from the rim are found at the same time, at most.
const KEYS_AT_ONCE: usize = 8;

/// Makes the skins of a list of moments, in order; the same on any number of threads.
///
/// A moment before there is any surface has a mesh of no triangles. Vertices have the attributes
/// `birth`, `density` and `colony` of a [`skin`](super::skin()). With a window of 0, a frame has the
/// triangles of the skin of the first elements, to the bit, in another order.
pub struct SkinFrames<'a> {
    cluster: &'a Cluster,
    substrate: &'a Substrate,
    shape: &'a Shape,
    paint: &'a Paint,
    winding: Winding,
    tree: Tree,
    lichen: Lichen,
    grid: Grid,
    history: History,
    moments: Vec<Presence>,
    next: usize,
    rims: BTreeMap<usize, RimDistances>,
    places: Places,
    samples: Vec<Sample>,
    outline: Outline,
}

/// The vertices of the tree by place.
struct Places {
    grid: Grid,
    /// In the grid's order.
    positions: Vec<DVec3>,
    vertices: Vec<u32>,
    changed: Vec<AtomicBool>,
    reach_sq: f64,
}

impl<'a> SkinFrames<'a> {
    /// Of a lichen on its substrate, at these moments.
    ///
    /// # Errors
    /// Those of [`skin`](super::skin()), but for resolutions that are too coarse.
    pub fn new(
        substrate: &'a Substrate,
        cluster: &'a Cluster,
        shape: &'a Shape,
        paint: &'a Paint,
        moments: Vec<Presence>,
    ) -> Result<Self, SkinError> {
        shape.check()?;
        shape.check_size(cluster.len())?;
        let winding = Winding::of(substrate);
        let since = |nearness: &Nearness, p, distance| {
            let first = nearness.first_within(p, distance);
            first.map_or(NEVER, |birth| birth + 1)
        };
        let farthest = farthest(substrate, cluster, shape, paint);
        let ((mut lichen, history), tree) = rayon::join(
            || {
                let lichen = Lichen::unmeasured(substrate, &winding, cluster);
                let history = History::new(&lichen, farthest);
                (lichen, history)
            },
            || refine(substrate, &winding, cluster, shape, since),
        );
        lichen.granules.iter_mut().for_each(|g| g.influence = 0.0);
        let radius = cluster.radius();
        let grid = lichen.sort(cutoff(shape) * radius);
        // As far as an element is felt, and what is between the ends of a side.
        let places = Places::new(&tree, (cutoff(shape) + 0.5 * shape.resolution) * radius);
        let nothing = |&home: &u32| Sample::nothing(winding.normal(substrate, home).as_vec3());
        let samples = tree.homes.par_iter().map(nothing).collect();
        Ok(Self {
            cluster,
            substrate,
            shape,
            paint,
            winding,
            tree,
            lichen,
            grid,
            history,
            moments,
            next: 0,
            rims: BTreeMap::new(),
            places,
            samples,
            outline: Outline::default(),
        })
    }

    /// Brings the elements to a moment, and gives the places of those that it changes.
    fn move_elements(&mut self, presence: &Presence) -> Vec<DVec3> {
        let keys = self.history.keys(presence);
        self.find_rims();
        let rims = keys.counts.map(|count| &self.rims[&count]);
        let history = &self.history;
        let moved = |granule: &mut Granule| {
            let birth = granule.birth as usize;
            let influence = presence.influence(birth);
            let was = (granule.influence, granule.density, granule.rim);
            if influence > 0.0 {
                granule.density = history.density(birth, presence);
                granule.rim = keys.distance(birth, rims);
            }
            granule.influence = influence;
            let is = (granule.influence, granule.density, granule.rim);
            (is != was).then_some(granule.position)
        };
        self.lichen
            .granules
            .par_iter_mut()
            .filter_map(moved)
            .collect()
    }

    /// Has the distances from the rim that this frame needs, and no longer those of frames before:
    /// when some are missing, those of the next frames are found at the same time.
    fn find_rims(&mut self) {
        let needed = |presence: &Presence| self.history.keys(presence).counts;
        let now = needed(&self.moments[self.next]);
        self.rims.retain(|count, _| *count >= now[0].min(now[1]));
        if now.iter().all(|count| self.rims.contains_key(count)) {
            return;
        }
        let mut missing: Vec<usize> = Vec::new();
        for count in self.moments[self.next..].iter().flat_map(needed) {
            let known = self.rims.contains_key(&count) || missing.contains(&count);
            if !known && missing.len() < KEYS_AT_ONCE {
                missing.push(count);
            }
        }
        let found = missing.into_par_iter();
        let found = found.map(|count| (count, self.history.rim_distances(count)));
        let found: Vec<_> = found.collect();
        self.rims.extend(found);
    }

    /// Reads the field anew where it has changed.
    fn sample(&mut self) {
        let field = Field::new(self.substrate, &self.lichen, &self.grid, self.shape);
        let field = field.painted(self.paint);
        let (tree, winding) = (&self.tree, &self.winding);
        let sheet = || Sheet::new(field.substrate, field.lichen.radius);
        let read = |sheet: &mut Sheet, vertex: u32| {
            let p = tree.positions[vertex as usize];
            let home = tree.homes[vertex as usize];
            let facing = winding.normal(field.substrate, home).as_vec3();
            (vertex, field.sample(p, home, facing, sheet))
        };
        let changed = self.places.changed_vertices();
        let read = changed.into_par_iter().map_init(sheet, read);
        let read: Vec<(u32, Sample)> = read.collect();
        for (vertex, sample) in read {
            self.samples[vertex as usize] = sample;
        }
    }

    fn frame(&mut self, presence: &Presence) -> TriMesh {
        let moved = self.move_elements(presence);
        self.places.mark(&moved);
        self.sample();
        let born = presence.born(self.cluster.len());
        let field = Field::new(self.substrate, &self.lichen, &self.grid, self.shape);
        let field = field.painted(self.paint);
        let leaves = self.tree.leaves(born as u32);
        let samples = Samples::at_corners(&self.samples, &leaves);
        let changed = self.places.changed_by_vertex();
        let longest = self.shape.resolution * self.cluster.radius();
        let positions = &self.tree.positions;
        let crossing_changed = |a: u32, b: u32| {
            let [a, b] = [a as usize, b as usize];
            changed[a] || changed[b] || positions[a].distance(positions[b]) > longest
        };
        let outline = &self.outline;
        let cross = |sides| {
            outline.moved(
                &field,
                &self.winding,
                &self.tree,
                &samples,
                sides,
                &crossing_changed,
            )
        };
        let underside = UNDERSIDE * self.cluster.radius();
        let (marched, outline) = close(&self.tree, born as u32, leaves, &samples, underside, cross);
        self.outline = outline;
        let mut mesh = finish(
            self.substrate,
            self.cluster.radius(),
            born,
            marched,
            self.paint,
        );
        mesh.attributes.retain(|a| !a.is_length);
        mesh
    }
}

impl Iterator for SkinFrames<'_> {
    type Item = TriMesh;

    fn next(&mut self) -> Option<TriMesh> {
        let presence = *self.moments.get(self.next)?;
        let mesh = self.frame(&presence);
        self.next += 1;
        Some(mesh)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.moments.len() - self.next;
        (left, Some(left))
    }
}

impl ExactSizeIterator for SkinFrames<'_> {}

/// The distance from the rim, in element radii, beyond which nothing of shape or colour changes: not
/// even where an element as far away as two can be that a place feels is nearer to the rim.
fn farthest(substrate: &Substrate, cluster: &Cluster, shape: &Shape, paint: &Paint) -> f32 {
    let margin = |p: super::Prothallus| p.width + 2.0 * cutoff(shape) as f32;
    let margin = paint.prothallus.map_or(0.0, margin);
    let far = far(substrate) / cluster.radius();
    RING.max(margin).min(far as f32)
}

impl Places {
    fn new(tree: &Tree, reach: f64) -> Self {
        let (grid, vertices) = Grid::new(&tree.positions, reach);
        let positions = vertices.iter().map(|&v| tree.positions[v as usize]);
        Self {
            grid,
            positions: positions.collect(),
            changed: vertices.iter().map(|_| AtomicBool::new(false)).collect(),
            vertices,
            reach_sq: reach * reach,
        }
    }

    /// Marks the vertices that feel something at these places, and no others.
    fn mark(&mut self, moved: &[DVec3]) {
        let marks = self.changed.par_iter_mut();
        marks.for_each(|mark| *mark.get_mut() = false);
        moved.par_iter().for_each(|place| {
            for i in self.grid.around(*place).flatten() {
                if (self.positions[i] - place).length_squared() <= self.reach_sq {
                    self.changed[i].store(true, Relaxed);
                }
            }
        });
    }

    fn changed_vertices(&self) -> Vec<u32> {
        let both = self.vertices.par_iter().zip(&self.changed);
        let changed = both.filter(|(_, mark)| mark.load(Relaxed));
        changed.map(|(vertex, _)| *vertex).collect()
    }

    fn changed_by_vertex(&self) -> Vec<bool> {
        let mut changed = vec![false; self.vertices.len()];
        for vertex in self.changed_vertices() {
            changed[vertex as usize] = true;
        }
        changed
    }
}
