//! The field of Sumner 2001, 8.1, over the surface.
//!
//! F = Σ fₙ with fₙ = exp(d² ln ½ / C²), steeper along the element's normal. For a point at the
//! height h over a place of the surface, and elements with about the same normal, it is
//! F = F₀ · 2^(−s h²), with F₀ the sum over the distances from the place itself and s the steepness
//! along the normal. So the iso-surface lies at h = √(log₂(F₀ / iso) / s), and ends where F₀ falls
//! to the iso value: it can be had from the surface alone.
//!
//! In an animation an element's fₙ is multiplied by its influence at the moment (Sumner 2001, 8.2), so
//! that it swells from nothing.
//!
//! Elements near the rim are steeper along the normal (the thesis's taper), so s is their mean by
//! weight, and the height's direction is the mean of their normals.

use glam::{DVec3, Vec3};

use super::grid::Grid;
use super::lichen::{Granule, Lichen};
use super::sheet::Sheet;
use super::{Paint, Shape};
use crate::substrate::Substrate;

/// Where fₙ is taken for 0, in falloffs C: there it is 2^−8.
const CUTOFF: f64 = 2.828_427_2;

/// The iso value, of which a lone element has twice as much at its centre.
const ISO: f64 = 0.5;

/// Of log₂(F₀ / iso), where F₀ is nothing: less than the cut-off of one element leaves.
pub(super) const NOTHING: f32 = -8.0;

/// How wide the ring is over which the taper fades, in element radii.
pub(super) const RING: f32 = 8.0;

/// The field and what it is made of.
pub(super) struct Field<'a> {
    pub(super) lichen: &'a Lichen,
    pub(super) substrate: &'a Substrate,
    /// Elements by place.
    grid: &'a Grid,
    /// Square of the cut-off, local units.
    reach_sq: f64,
    /// 1/C², local units.
    falloff: f32,
    /// The steepness s inside, and the share of the thickness that the outermost elements lose.
    steepness: f32,
    taper: f32,
    /// With what places are coloured as they are read: what colours by age changes with the lichen.
    paint: Option<&'a Paint>,
}

/// What the field says about a place on the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// log₂(F₀ / iso): positive under lichen.
    pub(crate) level: f32,
    /// Height of the iso-surface over the place, local units; 0 where there is none.
    pub(crate) height: f32,
    /// The direction of the height.
    pub(crate) up: Vec3,
    /// The iso-surface's normal.
    pub(crate) normal: Vec3,
    pub(crate) attributes: Attributes,
}

impl Sample {
    /// Whether any element is felt at the place.
    pub(crate) fn is_near_lichen(&self) -> bool {
        self.level > NOTHING
    }
}

/// What is known about the lichen at a place: means over the elements, by weight.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Attributes {
    pub(crate) birth: f32,
    pub(crate) density: f32,
    pub(crate) rim: f32,
    pub(crate) outline: f32,
    /// Of the element with the greatest weight.
    pub(crate) colony: f32,
    /// Its birth index.
    pub(crate) strongest: u32,
    /// sRGB, where it was coloured already.
    pub(crate) color: Option<[u8; 3]>,
}

/// The value of F₀ on closed lichen, densely packed: falloff C in element radii.
fn packed(falloff: f64) -> f64 {
    std::f64::consts::PI * falloff * falloff / (2.0 * 3f64.sqrt() * std::f64::consts::LN_2)
}

/// How far elements of radius 1 are felt.
pub(super) fn cutoff(shape: &Shape) -> f64 {
    CUTOFF * shape.falloff
}

/// How far from its nearest element the iso-surface can be, for elements of radius 1: all that is
/// farther than y adds up to less than packed · 2^(−y²/C²).
pub(super) fn overhang(shape: &Shape) -> f64 {
    let most = libm::log2(2.0 * packed(shape.falloff) / ISO).max(1.0);
    cutoff(shape).min(shape.falloff * most.sqrt())
}

impl<'a> Field<'a> {
    pub(super) fn new(
        substrate: &'a Substrate,
        lichen: &'a Lichen,
        grid: &'a Grid,
        shape: &Shape,
    ) -> Self {
        let r = lichen.radius;
        let closed = libm::log2((packed(shape.falloff) / ISO).max(2.0));
        Self {
            lichen,
            substrate,
            grid,
            reach_sq: (cutoff(shape) * r).powi(2),
            falloff: (shape.falloff * r).powi(-2) as f32,
            steepness: (closed / (shape.thickness * r).powi(2)) as f32,
            taper: shape.taper as f32,
            paint: None,
        }
    }

    /// The same, colouring places as it reads them, as far as that does not depend on the moment.
    pub(super) fn painted(self, paint: &'a Paint) -> Self {
        Self {
            paint: (paint.age_darken == 0.0 && !paint.is_structured()).then_some(paint),
            ..self
        }
    }

    /// What there is at a place that lies on a triangle of the substrate; `facing` is its normal.
    pub(super) fn sample(&self, p: DVec3, home: u32, facing: Vec3, sheet: &mut Sheet) -> Sample {
        let runs = self.grid.around(p);
        let near = runs.flat_map(|run| &self.lichen.granules[run]);
        self.sample_among(near, p, home, facing, sheet)
    }

    /// The same where these elements, in the order of the list, are all that may be felt.
    pub(super) fn sample_among<'g>(
        &self,
        near: impl Iterator<Item = &'g Granule>,
        p: DVec3,
        home: u32,
        facing: Vec3,
        sheet: &mut Sheet,
    ) -> Sample {
        let mut sums = Sums::default();
        near.for_each(|granule| {
            let away = p - granule.position;
            let within = away.length_squared() < self.reach_sq;
            let felt = granule.influence > 0.0 && within;
            if felt && sheet.joins(p, facing, home, granule) {
                let away = away.as_vec3();
                self.add(&mut sums, away, self.falloff_at(away), granule);
            }
        });
        self.finish(sums, facing)
    }

    /// What an element has at a place at full influence; 0 where it is not felt.
    pub(super) fn felt(
        &self,
        p: DVec3,
        home: u32,
        facing: Vec3,
        granule: &Granule,
        sheet: &mut Sheet,
    ) -> f32 {
        let away = p - granule.position;
        let within = away.length_squared() < self.reach_sq;
        match within && sheet.joins(p, facing, home, granule) {
            true => self.falloff_at(away.as_vec3()),
            false => 0.0,
        }
    }

    /// The same as [`sample`](Self::sample) where it is known what is [`felt`](Self::felt) of which
    /// elements, ascending by their places in the list.
    pub(super) fn sample_of(
        &self,
        p: DVec3,
        facing: Vec3,
        felt: impl Iterator<Item = (u32, f32)>,
    ) -> Sample {
        let mut sums = Sums::default();
        for (granule, falloff) in felt {
            let granule = &self.lichen.granules[granule as usize];
            if granule.influence > 0.0 {
                self.add(
                    &mut sums,
                    (p - granule.position).as_vec3(),
                    falloff,
                    granule,
                );
            }
        }
        self.finish(sums, facing)
    }

    fn falloff_at(&self, away: Vec3) -> f32 {
        libm::exp2f(-away.length_squared() * self.falloff)
    }

    fn finish(&self, sums: Sums, facing: Vec3) -> Sample {
        let mut sample = sums.finish(self, facing);
        let of = &mut sample.attributes;
        // The outline lies where the level is about 0.
        if let Some(paint) = self.paint.filter(|_| sample.level > -1.0) {
            of.color = Some(paint.color(of.density, 0.0, of.outline));
        }
        sample
    }

    fn add(&self, sums: &mut Sums, away: Vec3, falloff: f32, granule: &Granule) {
        let weight = granule.influence * falloff;
        if weight > sums.most {
            sums.most = weight;
            sums.attributes.colony = granule.colony as f32;
            sums.attributes.strongest = granule.birth;
        }
        sums.total += weight;
        sums.towards -= away * weight;
        sums.normal += granule.normal * weight;
        sums.steepness += weight * self.steepness_of(granule);
        sums.attributes.birth += weight * granule.birth as f32;
        sums.attributes.density += weight * granule.density;
        sums.attributes.rim += weight * granule.rim;
        sums.attributes.outline += weight * granule.outline;
    }

    fn steepness_of(&self, granule: &Granule) -> f32 {
        let t = (granule.rim / RING).min(1.0);
        let thinner = 1.0 - self.taper * (1.0 - t * t * (3.0 - 2.0 * t));
        self.steepness / (thinner * thinner)
    }
}

/// A direction turned towards a place's own normal until it stands at least this much on it: past a sharp
/// edge, what is felt of an element on the other face would lie flat.
fn raised(up: Vec3, facing: Vec3) -> Vec3 {
    const LEAST_COS: f32 = 0.5;
    let sine = (1.0 - LEAST_COS * LEAST_COS).sqrt();
    if up.dot(facing) >= LEAST_COS {
        return up;
    }
    let flat = (up - facing * up.dot(facing)).normalize_or_zero();
    (facing * LEAST_COS + flat * sine).normalize_or(facing)
}

/// Sums over elements, by weight.
#[derive(Default)]
struct Sums {
    total: f32,
    most: f32,
    towards: Vec3,
    normal: Vec3,
    steepness: f32,
    attributes: Attributes,
}

impl Sample {
    /// Where no lichen is felt.
    pub(super) fn nothing(facing: Vec3) -> Self {
        Self {
            level: NOTHING,
            height: 0.0,
            up: facing,
            normal: facing,
            attributes: Attributes::default(),
        }
    }
}

impl Sums {
    fn finish(self, field: &Field, facing: Vec3) -> Sample {
        if self.total <= 0.0 {
            return Sample::nothing(facing);
        }
        let mean = 1.0 / self.total;
        let level = libm::log2f(self.total / ISO as f32).max(NOTHING);
        let steepness = self.steepness * mean;
        let height = (level.max(0.0) / steepness).sqrt();
        let up = self.normal.try_normalize().unwrap_or(facing);
        let up = raised(up, facing);
        // −½ ∇ log₂ F: along the surface, and along the height.
        let towards = self.towards * (mean * field.falloff);
        let along = up * towards.dot(up) - towards;
        let normal = along + up * (steepness * height);
        let Attributes {
            birth,
            density,
            rim,
            outline,
            colony,
            strongest,
            ..
        } = self.attributes;
        Sample {
            level,
            height,
            up,
            normal: normal.try_normalize().unwrap_or(up),
            attributes: Attributes {
                birth: birth * mean,
                density: density * mean,
                rim: rim * mean,
                outline: outline * mean,
                colony,
                strongest,
                color: None,
            },
        }
    }
}
