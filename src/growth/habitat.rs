//! Where lichen may grow: by a mask on the substrate, and by how steep that is.
//!
//! The thesis has lichen grow everywhere. Here a walker in contact sticks with P_s times a factor from 0 to 1 at its
//! place, and where it then comes to rest that may not be 0. So no element has its centre where nothing may grow, and
//! where something may the law is that of the thesis, but for a mask that is grey.

use libm::cos;

use super::launch::AreaSampler;
use crate::rng::{Purpose, Stream};
use crate::substrate::{Substrate, SurfacePoint};

/// Places looked at to measure how much of a surface is habitat.
const PLACES: usize = 20_000;

/// The same where none of these is.
pub(super) const MOST_PLACES: usize = 1 << 20;

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

    /// Cosines of the steepest and the least steep; beyond those that there are where everything is meant.
    fn cosines(self) -> [f64; 2] {
        let least = match self.most < 180.0 {
            true => cos(self.most.to_radians()),
            false => f64::NEG_INFINITY,
        };
        let most = match self.least > 0.0 {
            true => cos(self.least.to_radians()),
            false => f64::INFINITY,
        };
        [least, most]
    }
}

/// Where on a substrate lichen may grow.
#[derive(Clone, Copy, Debug)]
pub struct Habitat<'a> {
    pub(super) substrate: &'a Substrate,
    /// Cosines of the angles, if it goes by slope.
    cosines: Option<[f64; 2]>,
}

impl<'a> Habitat<'a> {
    /// By the substrate's [mask](Substrate::mask), if it has one, and a slope.
    pub fn new(substrate: &'a Substrate, slope: Option<Slope>) -> Self {
        Self {
            substrate,
            cosines: slope.map(Slope::cosines),
        }
    }

    /// Whether nothing keeps lichen from growing anywhere.
    #[inline(always)]
    pub fn is_everywhere(&self) -> bool {
        self.cosines.is_none() && self.substrate.mask().is_none()
    }

    /// The factor on the chance to stick at a place: 0 where nothing may grow, at most 1.
    pub fn at(&self, at: &SurfacePoint) -> f64 {
        if let Some([least, most]) = self.cosines {
            let rise = { self.substrate.smooth_normal(at) }.dot(self.substrate.up());
            if !(least..=most).contains(&rise) {
                return 0.0;
            }
        }
        self.substrate.mask().map_or(1.0, |mask| mask.at(at))
    }

    /// Share of the area of the pieces that some triangles are in on which lichen may grow, as far as 20,000 places
    /// tell; 0 only where it may on none of a million.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn share(&self, triangles: impl Iterator<Item = u32>) -> f64 {
        if self.is_everywhere() {
            return 1.0;
        }
        let mut pieces: Vec<u32> = { triangles.map(|t| self.substrate.component_of(t)) }
            .map(|piece| piece.triangles.start)
            .collect();
        pieces.sort_unstable();
        pieces.dedup();
        let of_piece = |&t: &u32| self.substrate.component_of(t).triangles.clone();
        let suited = self.suited_places(pieces.iter().flat_map(of_piece), PLACES);
        match suited.len() {
            0 => 0.0,
            n if n == PLACES => 1.0,
            n => n as f64 / PLACES as f64,
        }
    }

    /// The area of that share of these pieces, local units.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn area(&self, triangles: impl Iterator<Item = u32> + Clone) -> f64 {
        self.share(triangles.clone()) * self.substrate.area_of_pieces(triangles)
    }

    /// The place nearest to one, through space, of those looked at on which lichen may grow: on its own piece, or else
    /// on another. None where it may on none of a million.
    pub fn nearest(&self, to: &SurfacePoint) -> Option<SurfacePoint> {
        let all = 0..self.substrate.triangles().len() as u32;
        let piece = self.substrate.component_of(to.triangle).triangles.clone();
        let goal = self.substrate.position(to);
        let distance = |at: &SurfacePoint| self.substrate.position(at).distance_squared(goal);
        [piece, all].into_iter().find_map(|among| {
            let places = self.suited_places(among, PLACES).into_iter();
            places.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
    }

    /// Those of some places, uniform by area on triangles, on which lichen may grow; one of a million if there is none
    /// among them.
    fn suited_places(&self, among: impl Iterator<Item = u32>, places: usize) -> Vec<SurfacePoint> {
        let area = AreaSampler::new(self.substrate, among);
        let mut stream = Stream::new(0, Purpose::Habitat, 0);
        let mut place = || area.sample(&mut stream);
        let is_suited = |at: &SurfacePoint| self.at(at) > 0.0;
        let suited: Vec<_> = { (0..places).map(|_| place()) }.filter(is_suited).collect();
        match suited.is_empty() {
            false => suited,
            true => { (places..MOST_PLACES).map(|_| place()) }
                .find(is_suited)
                .into_iter()
                .collect(),
        }
    }
}
