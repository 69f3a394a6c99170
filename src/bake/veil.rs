//! What is seen through maps, as through leaves that are cut out of an image.

use super::ground::Ground;
use super::shown::Shown;
use crate::appearance::InImages;
use crate::substrate::{Alpha, Material};

/// How the materials of what is shown are seen through, in one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Veil {
    pub(super) alpha: Alpha,
    pub(super) is_double_sided: bool,
}

/// Where a single cutoff does not serve several materials.
const CUTOFF: f32 = 0.5;

/// Where a blended material is less opaque than this, it has a hole, as of leaves, and is no glass. Less than the half
/// of `--mask opaque`, which keeps lichen off glass too.
const HOLE: f32 = 0.05;

impl Veil {
    /// As much as any of the materials: blended if one is, cut out if one is.
    pub(super) fn new(shown: &Shown) -> Self {
        let mut veil = Self {
            alpha: Alpha::Opaque,
            is_double_sided: false,
        };
        for material in shown.materials() {
            veil.alpha = joined(veil.alpha, material.alpha);
            veil.is_double_sided |= material.is_double_sided;
        }
        veil
    }

    /// The opacity that a texel of a material is written with, where so much of it is lichen, which is opaque.
    pub(super) fn opacity(
        &self,
        ground: &Ground,
        material: Option<&Material>,
        (at, lichen): (&InImages, f32),
    ) -> f32 {
        let Some(material) = material.filter(|material| material.alpha != Alpha::Opaque) else {
            return 1.0;
        };
        let opacity = ground.opacity(material, at);
        match (self.alpha, material.alpha) {
            (Alpha::Mask { cutoff }, Alpha::Mask { cutoff: own }) if own > 0.0 => {
                (opacity * cutoff / own).min(1.0)
            }
            (_, Alpha::Mask { cutoff }) => f32::from(u8::from(opacity >= cutoff)),
            _ if material.is_open(opacity, HOLE) => opacity,
            _ => opacity + (1.0 - opacity) * lichen,
        }
    }
}

fn joined(a: Alpha, b: Alpha) -> Alpha {
    match (a, b) {
        (Alpha::Blend, _) | (_, Alpha::Blend) => Alpha::Blend,
        (a, b) if a == b => a,
        (Alpha::Opaque, other) | (other, Alpha::Opaque) => other,
        _ => Alpha::Mask { cutoff: CUTOFF },
    }
}
