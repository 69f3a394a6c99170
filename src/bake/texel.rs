//! What lichen there is at each texel.

use std::collections::BTreeSet;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::frame::Frame;
use super::layout::{Corners, Layout, NONE};
use super::place::{Place, Placer, STRETCH};
use crate::color::to_linear;
use crate::skin::{Paint, Probe, Relief, Sample};
use crate::substrate::SurfacePoint;

/// Lichen at a texel: means over the samples in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texel {
    /// The share of the texel that lichen covers.
    pub(super) mask: f32,
    /// Over the substrate, local units; 0 where there is no lichen.
    pub(super) height: f32,
    /// 0 for the first born element of its lichen, 1 for the last.
    pub(super) birth: f32,
    /// Unit vector in tangent space.
    pub(super) normal: Vec3,
    /// Linear light.
    pub(super) color: Vec3,
    /// 1 where nothing is in the way of light.
    pub(super) occlusion: f32,
}

/// Texels at which lichen is felt; all others are bare.
pub(super) struct Texels {
    /// For each texel of the image its place in `near`, or [`NONE`].
    index: Vec<u32>,
    near: Vec<Texel>,
}

impl Texels {
    pub(super) fn get(&self, texel: usize) -> Option<&Texel> {
        self.near.get(self.index[texel] as usize)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Texel> {
        self.near.iter()
    }

    /// Fills in how much light comes to each texel.
    pub(super) fn occlude(&mut self, of: impl Fn(&Self, usize, &Texel) -> f32 + Sync) {
        let this = &*self;
        let numbered = this.index.par_iter().enumerate();
        let light = numbered.filter_map(|(i, &place)| {
            let texel = this.near.get(place as usize)?;
            Some(of(this, i, texel))
        });
        let light: Vec<f32> = light.collect();
        for (texel, light) in self.near.iter_mut().zip(light) {
            texel.occlusion = light;
        }
    }
}

/// One of the lichens that texels are sampled from.
pub(super) struct Layer<'a> {
    pub(super) relief: Relief<'a>,
    pub(super) paint: Paint,
    /// Birth index of the last element.
    pub(super) last: f32,
    /// The pieces of the mesh that it is on, by their first triangles.
    pub(super) pieces: BTreeSet<u32>,
}

/// What texels are sampled from.
pub(super) struct Sampler<'a> {
    pub(super) placer: &'a Placer<'a>,
    pub(super) layers: &'a [Layer<'a>],
    pub(super) frames: &'a [Frame],
    /// Samples along each side of a texel.
    pub(super) along: u32,
}

/// What asks a layer.
struct Asker<'a> {
    layer: &'a Layer<'a>,
    probe: Probe<'a>,
    /// Whether anything of it is felt in the texel in hand.
    is_near: bool,
}

impl Sampler<'_> {
    /// Every texel, rows in parallel.
    pub(super) fn sample(&self, gutter: usize) -> Texels {
        let layout = self.placer.layout;
        // A way beyond a chart's border may be this long.
        let margin = (gutter + 2) as f64 * STRETCH * self.placer.texel;
        let carries = |t: u32| self.layers.iter().any(|l| l.relief.may_carry(t, margin));
        let carrying: Vec<bool> = (0..layout.corners.len() as u32)
            .into_par_iter()
            .map(carries)
            .collect();
        let row = |askers: &mut Vec<Asker>, y: usize| self.row(y, &carrying, askers);
        let rows = (0..layout.size).into_par_iter();
        let rows: Vec<Vec<(u32, Texel)>> = rows.map_init(|| self.askers(), row).collect();
        gather(layout, &rows)
    }

    fn askers(&self) -> Vec<Asker<'_>> {
        let blur = (0.5 * self.placer.texel) as f32 / self.along as f32;
        let asker = |layer| Asker {
            layer,
            probe: layer.relief.probe(blur),
            is_near: false,
        };
        self.layers.iter().map(asker).collect()
    }

    fn row(&self, y: usize, carrying: &[bool], askers: &mut [Asker]) -> Vec<(u32, Texel)> {
        let layout = self.placer.layout;
        let one = |x: usize| {
            let owner = layout.owners[y * layout.size + x];
            let corners = layout.corners.get(owner as usize).copied().flatten()?;
            let texel = match carrying[owner as usize] {
                true => self.texel(owner, &corners, layout.middle(y * layout.size + x), askers)?,
                false => return None,
            };
            Some((x as u32, texel))
        };
        (0..layout.size).filter_map(one).collect()
    }

    fn texel(
        &self,
        owner: u32,
        corners: &Corners,
        middle: DVec2,
        askers: &mut [Asker],
    ) -> Option<Texel> {
        let at_middle = self.placer.place(owner, corners, middle);
        let place = self.placer.substrate.position(&at_middle.at);
        let margin = STRETCH * self.placer.texel;
        for asker in askers.iter_mut() {
            asker.is_near = asker.layer.relief.is_near(place, margin);
        }
        if askers.iter().all(|asker| !asker.is_near) {
            return None;
        }
        let mut sums = Sums::default();
        let n = self.along;
        let offset = |i: u32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        for i in 0..n * n {
            let p = middle + DVec2::new(offset(i % n), offset(i / n));
            let place = self.placer.place(owner, corners, p);
            if let Some((asker, sample)) = seen(askers, &place.at) {
                sums.add(asker.part(&place, &sample));
            }
        }
        let frame = self.frames[owner as usize];
        sums.finish((n * n) as f32, |normal| {
            frame.to_tangent_space(at_middle.weights, normal)
        })
    }
}

/// The last lichen that covers a place; where none does, that which is most felt.
fn seen<'b, 'a>(
    askers: &'b mut [Asker<'a>],
    at: &SurfacePoint,
) -> Option<(&'b mut Asker<'a>, Sample)> {
    let mut most: Option<(&mut Asker, Sample)> = None;
    for asker in askers.iter_mut().rev().filter(|asker| asker.is_near) {
        let sample = asker.probe.sample(at);
        let felt = most.as_ref().map_or(f32::NEG_INFINITY, |m| m.1.level);
        if sample.level > 0.0 || sample.level > felt {
            most = Some((asker, sample));
        }
        if sample.level > 0.0 {
            break;
        }
    }
    most.filter(|(_, sample)| sample.is_near_lichen())
}

impl Asker<'_> {
    /// What a sample of the layer says of its texel.
    fn part(&mut self, place: &Place, sample: &Sample) -> Part {
        let facing = match &place.border {
            Some(border) => self.probe.sample(border),
            None => *sample,
        };
        let at = sample.attributes;
        let age = at.birth / self.layer.last.max(1.0);
        let plain = || self.layer.paint.color(at.density, age, at.outline);
        let color = at.color.unwrap_or_else(plain).map(to_linear);
        Part {
            inside: sample.level > 0.0,
            height: sample.height,
            birth: age,
            normal: match facing.level > 0.0 {
                true => facing.normal,
                false => facing.up,
            },
            color: Vec3::from_array(color),
        }
    }
}

/// One sample at which lichen is felt.
struct Part {
    /// Whether it is there.
    inside: bool,
    height: f32,
    birth: f32,
    normal: Vec3,
    color: Vec3,
}

/// Sums over the samples of a texel.
#[derive(Default)]
struct Sums {
    inside: f32,
    weight: f32,
    height: f32,
    birth: f32,
    normal: Vec3,
    color: Vec3,
}

/// How much a sample beside the lichen counts for colour and birth: only where there is no other, so
/// that filtering at a margin reads the lichen's own.
const BESIDE: f32 = 1e-4;

impl Sums {
    fn add(&mut self, part: Part) {
        let weight = if part.inside { 1.0 } else { BESIDE };
        if part.inside {
            self.inside += 1.0;
            self.height += part.height;
            self.normal += part.normal;
        }
        self.weight += weight;
        self.birth += weight * part.birth;
        self.color += weight * part.color;
    }

    fn finish(self, samples: f32, to_tangent_space: impl Fn(Vec3) -> Vec3) -> Option<Texel> {
        (self.weight > 0.0).then(|| Texel {
            mask: self.inside / samples,
            height: self.height / samples,
            birth: (self.birth / self.weight).clamp(0.0, 1.0),
            normal: match self.inside > 0.0 {
                true => to_tangent_space(self.normal),
                false => Vec3::Z,
            },
            color: self.color / self.weight,
            occlusion: 1.0,
        })
    }
}

fn gather(layout: &Layout, rows: &[Vec<(u32, Texel)>]) -> Texels {
    let mut index = vec![NONE; layout.owners.len()];
    let mut near = Vec::with_capacity(rows.iter().map(Vec::len).sum());
    for (y, row) in rows.iter().enumerate() {
        for (x, texel) in row {
            index[y * layout.size + *x as usize] = near.len() as u32;
            near.push(*texel);
        }
    }
    Texels { index, near }
}
