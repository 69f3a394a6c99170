//! The skins of a growing lichen, one after the other (Sumner 2001, 8.2).
//!
//! Each is what [`skin`](super::skin()) makes of the elements by their influence at the moment. What does
//! not change is shared: how the surface is cut (see `refine.rs`), who is felt where (see `felt.rs`), who
//! stands near whom, when each element left the rim. And what has not changed since the frame before is
//! kept: the field is read anew only at places that feel an element whose influence, density or distance
//! from the rim has changed.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::base::Face;
use super::cortex::{Cortex, Dress};
use super::felt::{Felt, mean_near};
use super::field::{Field, NOTHING, RING, Sample, cutoff};
use super::grid::{Grid, Nearness};
use super::history::{Distances, History};
use super::lichen::{Granule, Lichen, far};
use super::march::{Outline, Samples, close, is_touched};
use super::refine::{NEVER, Tree};
use super::sheet::Sheet;
use super::{Paint, Shape, SkinError, UNDERSIDE, blur, finish, last, refine};
use crate::cluster::{Cluster, Presence};
use crate::export::TriMesh;
use crate::substrate::Substrate;

/// Lichens whose distances from the rim are found at the same time, at most.
const KEYS_AT_ONCE: usize = 8;

/// As far as an element is felt, and what is between the ends of a side; local units.
fn reach(shape: &Shape, radius: f64) -> f64 {
    (cutoff(shape) + 0.5 * shape.resolution) * radius
}

/// About how many elements are kept for each vertex of [`SkinFrames`], on which what they take depends,
/// besides the [triangles](super::expected_triangles).
pub fn expected_near(cluster: &Cluster, shape: &Shape) -> f64 {
    mean_near(cluster, reach(shape, cluster.radius()))
}

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
    tree: Tree,
    lichen: Lichen,
    grid: Grid,
    cortex: Option<Cortex>,
    in_parts: bool,
    history: History,
    moments: Vec<Presence>,
    next: usize,
    rims: BTreeMap<usize, Distances>,
    felt: Felt,
    /// All that are ever whole of the tree's triangles.
    leaves: Vec<Face>,
    /// What the field says at each vertex; its level once more, to be looked through quickly.
    samples: Vec<Sample>,
    levels: Vec<f32>,
    /// Whether the last moment changed an element, and how many were settled at it.
    moved: Vec<bool>,
    settled: usize,
    outline: Outline,
}

impl std::fmt::Debug for SkinFrames<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SkinFrames").finish_non_exhaustive()
    }
}

/// Refuses moments that are none.
fn check(moments: &[Presence]) -> Result<(), SkinError> {
    let is_one = |m: &Presence| m.time.is_finite() && (0.0..f64::INFINITY).contains(&m.window);
    match moments.iter().enumerate().find(|(_, m)| !is_one(m)) {
        None => Ok(()),
        Some((index, &Presence { time, window, .. })) => Err(SkinError::Moment {
            index,
            time,
            window,
        }),
    }
}

impl<'a> SkinFrames<'a> {
    /// The skins of a lichen on its substrate, at these moments.
    ///
    /// # Errors
    /// Those of [`skin`](super::skin()), but for resolutions that are too coarse; [`SkinError::Moment`].
    ///
    /// # Panics
    /// Those of [`skin`](super::skin()), here or when a frame is made.
    pub fn new(
        substrate: &'a Substrate,
        cluster: &'a Cluster,
        shape: &'a Shape,
        paint: &'a Paint,
        moments: Vec<Presence>,
    ) -> Result<Self, SkinError> {
        shape.check()?;
        paint.check()?;
        shape.check_size(cluster.len())?;
        check(&moments)?;
        let since = |nearness: &Nearness, p, distance| {
            let first = nearness.first_within(p, distance);
            first.map_or(NEVER, |birth| birth + 1)
        };
        let farthest = farthest(substrate, cluster, shape, paint);
        let ((mut lichen, cortex, history), tree) = rayon::join(
            || {
                let lichen = Lichen::unmeasured(substrate, cluster);
                let cortex = Cortex::new(&lichen, paint, shape.thickness);
                let borders = lichen.borders(substrate);
                let has_margin = paint.prothallus.is_some();
                let history = History::new(&lichen, farthest, has_margin, &borders);
                (lichen, cortex, history)
            },
            || refine(substrate, cluster, shape, since),
        );
        lichen.granules.iter_mut().for_each(|g| g.influence = 0.0);
        let radius = cluster.radius();
        let grid = lichen.sort(cutoff(shape) * radius);
        let field = Field::new(substrate, &lichen, &grid, shape);
        let felt = Felt::new(&field, &tree, reach(shape, radius));
        let nothing = |&home: &u32| Sample::nothing(substrate.normal(home).as_vec3());
        let samples = tree.homes.par_iter().map(nothing).collect();
        Ok(Self {
            cluster,
            substrate,
            shape,
            paint,
            grid,
            cortex,
            in_parts: false,
            history,
            moments,
            next: 0,
            rims: BTreeMap::new(),
            felt,
            leaves: tree.leaves(|_| true),
            samples,
            levels: vec![NOTHING; tree.positions.len()],
            moved: vec![false; lichen.granules.len()],
            settled: 0,
            tree,
            lichen,
            outline: Outline::default(),
        })
    }

    /// These skins without areoles and apothecia, for something that reads them more finely than the
    /// triangles are: see [`cortex`](Self::cortex).
    #[must_use]
    pub fn in_parts(self) -> Self {
        Self {
            in_parts: true,
            ..self
        }
    }

    /// Areoles and apothecia of the last frame, if the lichen has any.
    pub fn cortex(&self) -> Option<&Cortex> {
        self.cortex.as_ref()
    }

    /// Brings the elements to a moment.
    fn move_elements(&mut self, presence: &Presence) {
        let keys = self.history.keys(presence);
        self.find_rims();
        let rims = keys.counts.map(|count| &self.rims[&count]);
        let crowded = self.change_about(presence);
        let history = &self.history;
        if let Some(cortex) = &mut self.cortex {
            let born = presence.born(self.cluster.len()) as u32;
            cortex.move_to(born, |birth| keys.rim(birth as usize, rims));
        }
        let change = |(granule, moved): (&mut Granule, &mut bool)| {
            let birth = granule.birth as usize;
            let influence = presence.influence(birth);
            let state = |g: &Granule| (g.influence, g.density, g.rim, g.outline);
            let was = state(granule);
            if influence > 0.0 {
                if granule.influence <= 0.0 || crowded[birth].load(Relaxed) {
                    granule.density = history.density(birth, presence);
                }
                granule.rim = keys.rim(birth, rims);
                granule.outline = keys.outline(birth, rims);
            }
            granule.influence = influence;
            *moved = was != state(granule);
        };
        let granules = self.lichen.granules.par_iter_mut();
        granules.zip(&mut self.moved).for_each(change);
        self.settled = presence.settled(self.cluster.len());
    }

    /// By birth, whether a neighbour of an element changes for its density.
    fn change_about(&self, presence: &Presence) -> Vec<AtomicBool> {
        let all = self.cluster.len();
        let marks: Vec<AtomicBool> = (0..all).map(|_| false.into()).collect();
        let settled = [self.settled, presence.settled(all)];
        self.lichen.granules.par_iter().for_each(|granule| {
            let birth = granule.birth as usize;
            let settles = (birth < settled[0]) != (birth < settled[1]);
            if settles || presence.influence(birth) != granule.influence {
                let near = self.history.near(birth).iter();
                near.for_each(|&other| marks[other as usize].store(true, Relaxed));
            }
        });
        marks
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
            if missing.len() == KEYS_AT_ONCE {
                break;
            }
            if !self.rims.contains_key(&count) && !missing.contains(&count) {
                missing.push(count);
            }
        }
        let found = missing.into_par_iter();
        let found = found.map(|count| (count, self.history.distances(count)));
        let found: Vec<_> = found.collect();
        self.rims.extend(found);
    }

    fn field(&self) -> Field<'_> {
        let field = Field::new(self.substrate, &self.lichen, &self.grid, self.shape);
        field.painted(self.paint)
    }

    /// Reads the field anew where it has changed.
    fn sample(&mut self) {
        let field = Field::new(self.substrate, &self.lichen, &self.grid, self.shape);
        let field = field.painted(self.paint);
        let tree = &self.tree;
        let told = self.samples.par_iter_mut().zip(&mut self.levels);
        let changed = self.felt.changed_by(&self.lichen.granules, &self.moved);
        told.enumerate().for_each(|(v, (sample, level))| {
            if changed(v) {
                let (p, home) = (tree.positions[v], tree.homes[v]);
                let facing = field.substrate.normal(home).as_vec3();
                *sample = field.sample_of(p, facing, self.felt.at(v));
                *level = sample.level;
            }
        });
    }

    /// The outline, read anew where something has moved between the ends of a side.
    fn outline_across(&self, samples: &Samples, sides: Vec<u64>) -> Outline {
        let (field, tree) = (self.field(), &self.tree);
        let longest = self.shape.resolution * self.cluster.radius();
        let changed = |a: u32, b: u32| {
            let [p, q] = [a, b].map(|v| tree.positions[v as usize]);
            let moved = [a, b].iter().any(|&v| self.felt.has_moved(v, &self.moved));
            moved || p.distance(q) > longest
        };
        let read = |place: DVec3, [inner, nearer]: [u32; 2], sheet: &mut Sheet| {
            let home = tree.homes[inner as usize];
            let facing = self.substrate.normal(home).as_vec3();
            match place.distance(tree.positions[nearer as usize]) <= 0.5 * longest {
                true => {
                    let near = self.felt.near(nearer, &self.lichen.granules);
                    field.sample_among(near, place, home, facing, sheet)
                }
                false => field.sample(place, home, facing, sheet),
            }
        };
        self.outline
            .moved(&field, tree, samples, sides, &changed, &read)
    }

    fn frame(&mut self, presence: &Presence) -> TriMesh {
        self.move_elements(presence);
        self.sample();
        let born = presence.born(self.cluster.len());
        let elements = born as u32;
        let leaves = self.leaves.par_iter();
        let leaves = leaves.filter(|leaf| leaf.lives(elements) && is_touched(leaf, &self.levels));
        let leaves: Vec<&Face> = leaves.collect();
        let samples = Samples::new(&self.levels, &self.samples, &leaves);
        let cross = |sides| self.outline_across(&samples, sides);
        let radius = self.cluster.radius();
        let dress = |cortex| Dress {
            cortex,
            paint: self.paint,
            last: last(born),
            blur: blur(self.shape, radius),
        };
        let dress = self.cortex.as_ref().filter(|_| !self.in_parts).map(dress);
        let underside = UNDERSIDE * radius;
        let closed = close(
            &self.tree, elements, &leaves, &samples, underside, dress, cross,
        );
        let (marched, outline) = closed;
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
    let grown = paint.apothecia.map_or(0.0, |a| a.full_grown());
    let far = far(substrate) / cluster.radius();
    RING.max(margin).max(grown).min(far as f32)
}
