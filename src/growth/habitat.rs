//! Where lichen may grow: by a mask on the substrate, which other lichens and pieces are part of, and by how steep that
//! is.
//!
//! The thesis has lichen grow everywhere. Here a walker in contact sticks with P_s times a factor from 0 to 1 at its
//! place, and where it then comes to rest that may not be 0. So no element has its centre where nothing may grow, and
//! where something may the law is that of the thesis, but for a mask that is grey.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use glam::DVec2;
use libm::cos;

use super::launch::AreaSampler;
use crate::rng::{Purpose, Stream};
use crate::substrate::{Component, Found, Mask, Substrate, SurfacePoint};
use crate::walk::trace;

/// Places looked at to measure how much of a surface is habitat.
const PLACES: usize = 20_000;

/// Suited ones that tell its area, to some 2 %: where fewer are, more places are looked at.
const ENOUGH: usize = 2_000;

/// Places looked at then, at most.
const MOST_MEASURED: usize = 1 << 19;

/// The same where none is suited.
pub(super) const MOST_PLACES: usize = 1 << 20;

/// As many where each is looked for in other pieces of the mesh, which takes some ten microseconds.
const MOST_EXPOSED: usize = 1 << 15;

/// What rounding may do to the cosine of a slope: normals are kept in 32 bits.
const ROUNDED: f64 = 1e-6;

/// So many of the first, and then every second, every third and so on of as many as follow.
fn sparser<T>(items: impl Iterator<Item = T>, all: usize) -> impl Iterator<Item = T> {
    let is_taken = move |at: usize| at.is_multiple_of(1 + at / all);
    items
        .enumerate()
        .filter_map(move |(at, item)| is_taken(at).then_some(item))
}

/// What a place is to be near to.
pub(super) enum Goal {
    /// A place, on its own piece of the mesh if that has habitat.
    Near(SurfacePoint),
    /// What is highest on the mesh.
    Summit,
}

impl Goal {
    /// The triangles on which a place is looked for, and those where there is none.
    fn among(&self, substrate: &Substrate) -> Vec<Range<u32>> {
        let all = 0..substrate.triangles().len() as u32;
        match self {
            Self::Near(goal) => vec![substrate.component_of(goal.triangle).triangles.clone(), all],
            Self::Summit => vec![all],
        }
    }

    /// The less, the better a place is.
    fn distance(&self, substrate: &Substrate, at: &SurfacePoint) -> f64 {
        let place = substrate.position(at);
        match self {
            Self::Near(goal) => place.distance_squared(substrate.position(goal)),
            Self::Summit => -place.dot(substrate.up()),
        }
    }
}

/// How steep the surface may be that lichen grows on: angles between its smooth normal and up, in degrees. 0 is level,
/// 90 upright, 180 the underside of something level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    least: f64,
    most: f64,
}

impl Slope {
    /// From the one angle to the other, with both; none unless 0 ≤ least < most ≤ 180.
    pub fn new(least: f64, most: f64) -> Option<Self> {
        let is_sound = least >= 0.0 && least < most && most <= 180.0;
        is_sound.then_some(Self { least, most })
    }

    /// The two angles.
    pub fn angles(self) -> [f64; 2] {
        [self.least, self.most]
    }

    /// Cosines of the steepest and the least steep.
    fn cosines(self) -> [f64; 2] {
        let cosine = |angle: f64| cos(angle.to_radians());
        [cosine(self.most) - ROUNDED, cosine(self.least) + ROUNDED]
    }
}

/// Where on a substrate lichen may grow.
#[derive(Clone, Copy, Debug)]
pub struct Habitat<'a> {
    pub(super) substrate: &'a Substrate,
    /// Cosines of the angles, if it goes by slope.
    cosines: Option<[f64; 2]>,
    /// Of an element.
    radius: f64,
    /// Whether only what is not buried in other pieces of the mesh is part of it.
    is_exposed: bool,
}

impl<'a> Habitat<'a> {
    /// The habitat by the substrate's [mask](Substrate::mask), if it has one, and a slope, for elements of this radius,
    /// local units: other lichens must leave room for them.
    pub fn new(substrate: &'a Substrate, slope: Option<Slope>, radius: f64) -> Self {
        if slope.is_some() {
            substrate.find_slope_normals();
        }
        let is_exposed = substrate.mask().is_some_and(Mask::asks_for_exposed);
        if is_exposed {
            substrate.piece_tree();
        }
        Self {
            substrate,
            cosines: slope.map(Slope::cosines),
            radius,
            is_exposed,
        }
    }

    /// Whether nothing keeps lichen from growing anywhere.
    #[inline(always)]
    pub fn is_everywhere(&self) -> bool {
        self.cosines.is_none() && self.substrate.mask().is_none_or(Mask::is_white)
    }

    /// The factor on the chance to stick at a place: 0 where nothing may grow, at most 1.
    pub fn at(&self, at: &SurfacePoint) -> f64 {
        if let Some([least, most]) = self.cosines {
            let rise = self.substrate.slope_normal(at).dot(self.substrate.up());
            if !(least..=most).contains(&rise) {
                return 0.0;
            }
        }
        self.substrate.mask().map_or(1.0, |mask| {
            let painted = mask.at(at);
            let has_room = || mask.leaves_room(self.substrate.position(at), self.radius);
            let is_buried = || self.is_exposed && self.substrate.is_buried(at, self.radius);
            if painted > 0.0 && has_room() && !is_buried() {
                painted
            } else {
                0.0
            }
        })
    }

    /// Share of the area of the pieces that some triangles are in on which lichen may grow, as far as 20,000 places
    /// tell, and as many more, up to half a million, as it takes for 2,000 of them to be suited; 0 only where none of a
    /// million is, or of 32,768 if it has to be [exposed](Mask::exposed).
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn share(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        self.mean(triangles, |_| 1.0)
    }

    /// How likely chance lets something grow at a random place on these pieces, as far as as many places tell.
    pub(super) fn chance(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        self.mean(triangles, |at| self.at(at))
    }

    /// The mean over random places on these pieces of what one counts where lichen may grow: 1 where it may everywhere.
    fn mean(
        &self,
        triangles: impl Iterator<Item = u32>,
        counted: impl Fn(&SurfacePoint) -> f64,
    ) -> f64 {
        if self.is_everywhere() {
            return 1.0;
        }
        let pieces = self.substrate.pieces_of(triangles);
        let among: Vec<_> = pieces.iter().map(|piece| piece.triangles.clone()).collect();
        let (suited, tried) = &*self.suited_places(&among);
        suited.iter().map(counted).sum::<f64>() / *tried as f64
    }

    /// The share of the pieces that these triangles are on where lichen may grow, and its area, or that of a
    /// millionth of them where the share is 0; local units.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn share_and_area(&self, triangles: impl Iterator<Item = u32> + Clone) -> (f64, f64) {
        let share = self.share(triangles.clone());
        let at_least = share.max(1.0 / MOST_PLACES as f64);
        (share, at_least * self.substrate.area_of_pieces(triangles))
    }

    /// The area of the pieces that these triangles are on, as far as lichen may grow there, or a millionth of it
    /// where it may grow nowhere; local units.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn area(&self, triangles: impl Iterator<Item = u32> + Clone) -> f64 {
        self.share_and_area(triangles).1
    }

    /// The place nearest to one, through space, of those looked at on which lichen may grow, and a room's length (local
    /// units) from them in eight directions too: with the first of these rooms for which there is one on its own piece,
    /// or else on another. None where there is none among as many places as for the [share](Self::share). It takes as
    /// long as rooms are: one as long as the mesh is wide is room enough.
    pub fn nearest(&self, to: &SurfacePoint, rooms: &[f64]) -> Option<SurfacePoint> {
        self.best(&Goal::Near(*to), rooms, |_| true)
    }

    /// The best place for a goal of those that are chosen, with rooms as for the [nearest](Self::nearest): on another
    /// piece only where its own has no habitat, for that may be a crumb. After some of the best that have room, ever
    /// fewer of those that follow are asked whether they are.
    pub(super) fn best(
        &self,
        goal: &Goal,
        rooms: &[f64],
        is_chosen: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<SurfacePoint> {
        let among = goal.among(self.substrate).into_iter();
        let mut places = among.map(|among| self.suited_places(&[among]).0.clone());
        let mut places = places.find(|places| !places.is_empty())?;
        let off = |at: &SurfacePoint| goal.distance(self.substrate, at);
        places.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let with = |room: f64| {
            let roomy = places.iter().filter(|at| self.has_room(at, room));
            sparser(roomy, self.most_asked()).find(|at| is_chosen(at))
        };
        rooms.iter().find_map(|&room| with(room)).copied()
    }

    /// Of places in order how many are asked one by one: fewer where it takes long to ask, as there are many pieces.
    fn most_asked(&self) -> usize {
        (100_000 / self.substrate.components().len()).clamp(4, 200)
    }

    /// The piece of the mesh with the most room for lichen, if there is any.
    pub(super) fn widest_piece(&self) -> Option<&'a Component> {
        let all = 0..self.substrate.triangles().len() as u32;
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for at in &self.suited_places(&[all]).0 {
            let piece = self.substrate.component_of(at.triangle);
            *counts.entry(piece.triangles.start).or_default() += 1;
        }
        let most = counts.into_iter().rev().max_by_key(|&(_, count)| count);
        most.map(|(first, _)| self.substrate.component_of(first))
    }

    /// Whether lichen may grow so far from a place in eight directions.
    pub(super) fn has_room(&self, at: &SurfacePoint, room: f64) -> bool {
        const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
        let across = [
            DVec2::X,
            DVec2::Y,
            DVec2::splat(DIAGONAL),
            DVec2::new(DIAGONAL, -DIAGONAL),
        ];
        let mut ways = across.iter().flat_map(|way| [room * way, -room * way]);
        self.is_everywhere()
            || room == 0.0
            || ways.all(|way| self.at(&trace(self.substrate, at, way, false).point) > 0.0)
    }

    /// Those of some places, uniform by area on triangles, on which lichen may grow, and how many were tried: more
    /// where few are suited.
    fn suited_places(&self, among: &[Range<u32>]) -> Found {
        let look = || self.look_for_places(among);
        self.substrate
            .known_places()
            .get_or(self.asked(among), look)
    }

    /// A number for all that the suited places among these triangles depend on.
    fn asked(&self, among: &[Range<u32>]) -> u64 {
        let mut asked = DefaultHasher::new();
        among.hash(&mut asked);
        let slope = self.cosines.map(|cosines| cosines.map(f64::to_bits));
        let up = self.substrate.up().to_array().map(f64::to_bits);
        (slope, up, self.radius.to_bits()).hash(&mut asked);
        self.substrate.mask().map(Mask::hashes).hash(&mut asked);
        asked.finish()
    }

    fn look_for_places(&self, among: &[Range<u32>]) -> (Vec<SurfacePoint>, usize) {
        let area = AreaSampler::new(self.substrate, among.iter().cloned().flatten());
        let mut stream = Stream::new(0, Purpose::Habitat, 0);
        let most = |suited: usize| match (self.is_exposed, suited) {
            (true, _) => MOST_EXPOSED,
            (false, 0) => MOST_PLACES,
            (false, _) => MOST_MEASURED,
        };
        let (mut suited, mut tried) = (Vec::new(), 0);
        while suited.len() < ENOUGH && tried < most(suited.len()) {
            // Whole lots, for to stop at a suited one would count too many.
            let lot = PLACES.min(most(suited.len()) - tried);
            let places = (0..lot).map(|_| area.sample(&mut stream));
            suited.extend(places.filter(|at| self.at(at) > 0.0));
            tried += lot;
        }
        (suited, tried)
    }
}
