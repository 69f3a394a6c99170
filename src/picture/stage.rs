//! Where the things of a picture stand: what pictures of a growing lichen have in common.

use glam::Vec3A;

use super::shape::Dome;
use super::trace::union;
use super::{Disc, Stone};

/// The part of the size by which the floor lies lower than all things.
const UNDER: f32 = 2e-3;

/// The floor, and to what the grain of the stone is fixed.
///
/// By itself each [`Scene`](super::Scene) has its own. Lichen that grows moves that of one picture
/// against that of the next, and the grain would crawl over the stone: so a growth has one for all.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stage {
    pub(super) middle: Vec3A,
    /// The diagonal of the box about everything; 1 where there is nothing.
    pub(super) size: f32,
    /// Height of the floor along `up`.
    pub(super) floor: f32,
}

impl Stage {
    /// The stage for a substrate with granules on it, and for what is no larger than these.
    pub fn of(stone: &Stone, discs: &[Disc], up: [f32; 3]) -> Self {
        let up = upward(up);
        let domes = || discs.iter().filter_map(Dome::new);
        let boxes = domes().map(|dome| dome.bounds()).map(|b| [b.min, b.max]);
        let heights = domes().map(|dome| dome.lowest(up));
        let (bounds, _) = measured(union(boxes.chain([stone.boxed()])));
        Self::new(bounds, heights.fold(stone.lowest(up), f32::min))
    }

    /// For what is in a box and no lower than this.
    pub(super) fn new(bounds: [Vec3A; 2], lowest: f32) -> Self {
        let (bounds, size) = measured(bounds);
        Self {
            middle: 0.5 * (bounds[0] + bounds[1]),
            size,
            floor: lowest - UNDER * size,
        }
    }
}

/// The corners of a box, which is a point where it is turned inside out, and its diagonal, which is 1
/// where there is none.
pub(super) fn measured(bounds: [Vec3A; 2]) -> ([Vec3A; 2], f32) {
    let is_empty = bounds[0].x > bounds[1].x;
    let bounds = if is_empty { [Vec3A::ZERO; 2] } else { bounds };
    let size = bounds[0].distance(bounds[1]);
    (bounds, if size > 0.0 { size } else { 1.0 })
}

/// A direction away from the floor, of length 1.
pub(super) fn upward(up: [f32; 3]) -> Vec3A {
    Vec3A::from_array(up).try_normalize().unwrap_or(Vec3A::Y)
}
