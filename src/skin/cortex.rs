//! The fine structure of a lichen's upper side: areoles and apothecia.
//!
//! Crusts that dry crack into areoles. Here they are the Voronoi cells of [sites](super::sites) on the
//! lichen, as far as a place sees them: the distance to the crack is that to the plane halfway to the
//! next site (Worley, *A cellular texture basis function*, 1996; Quilez, *Voronoi borders*, 2012), with
//! a smooth minimum over the planes, so that corners are round. Apothecia are cups about other sites.
//!
//! Both are functions of place, so that the skin reads them at its vertices, maps at their texels and
//! pictures at every sample, each as finely as it can show them: `blur` widens what is narrower, and
//! thins it out by as much.

use glam::{DVec3, Vec3};

use super::field::{Attributes, Sample};
use super::lichen::Lichen;
use super::sites::{Site, Sites};
use super::{Paint, SkinError, as_meant, in_range};
use crate::color::{to_byte, to_linear};

/// A crust cracked into small plates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Areoles {
    /// About how wide an areole is, in element radii, 3 to 1000: a square as large as the mean areole
    /// had a side of 0.87 to 0.98 of it on grown lichens, for widths from 18 down to 6.
    pub width: f32,
    /// sRGB of the cracks.
    pub color: [u8; 3],
}

/// Fruiting bodies: discs that sit on the old part of the lichen, away from its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apothecia {
    /// Diameter of the largest, in element radii. 3 to 1000.
    pub width: f32,
    /// The least distance between the middles of two, in element radii. 3 to 10,000. Where two overlap,
    /// the one whose rim is farther covers the other.
    pub spacing: f32,
    /// Distance from the rim at which they begin, in element radii, 1 to 10,000; they are full grown at
    /// twice that.
    pub from: f32,
    /// sRGB of the disc.
    pub color: [u8; 3],
    /// The share of the radius that a raised margin of the thallus' own colour takes, 0 to 0.6. At 0
    /// there is none, and the disc hardly rises.
    pub margin: f32,
}

impl Areoles {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`SkinError::Range`] for one that is not.
    pub fn check(&self) -> Result<(), SkinError> {
        let width = as_meant(self.width);
        in_range(("the width of areoles", width, 3.0, 1000.0, "r"))
    }
}

/// Distances from the rim at which apothecia begin and are full grown, over `from`.
const GROWING: [f32; 2] = [1.0, 2.0];

/// Ages at which they begin and are full grown, by birth: 0 the youngest element, 1 the oldest. On a
/// round lichen that leaves the outer seventh free.
const RIPENING: [f32; 2] = [0.25, 0.65];

impl Apothecia {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// [`SkinError::Range`] for the first that is not.
    pub fn check(&self) -> Result<(), SkinError> {
        let ranges = [
            ("the width of apothecia", self.width, 3.0, 1000.0, "r"),
            ("the spacing of apothecia", self.spacing, 3.0, 10_000.0, "r"),
            ("where apothecia begin", self.from, 1.0, 10_000.0, "r"),
            ("the margin of apothecia", self.margin, 0.0, 0.6, ""),
        ];
        let wide = |(name, value, low, high, unit)| (name, as_meant(value), low, high, unit);
        ranges.map(wide).into_iter().try_for_each(in_range)
    }

    /// Distance from the rim from which on they are full grown, in element radii.
    pub(super) fn full_grown(&self) -> f32 {
        GROWING[1] * self.from
    }
}

/// Width of an areole over the least distance between two sites.
const WIDTH: f64 = 1.22;

/// In widths of an areole: half the width of a crack, how far the smooth minimum feels, from where an
/// areole is level, and how deep the crack is.
const CRACK: f32 = 0.042;
const ROUND: f32 = 0.03;
const LEVEL: f32 = 0.3;
const DEPTH: f32 = 0.12;

/// The share of the lichen's thickness that a crack leaves at least.
const LEFT: f32 = 0.2;

/// How much lighter or darker an areole may be.
const TONES: f32 = 0.16;

/// Of an apothecium's radius: the height of its margin, and how far its shade reaches beyond.
const CUP: f32 = 0.34;
const SHADE: f32 = 0.3;

/// How much smaller than the largest full-grown apothecia may be.
const SMALLER: f32 = 0.7;

/// The least radius of an apothecium, in element radii.
const SMALLEST: f32 = 0.75;

/// How high lichen can be, over its thickness: where elements crowd at a crease.
const HIGHEST: f64 = 1.5;

/// Purposes of a site's numbers.
const TONE: u32 = 0;
const SIZE: u32 = 1;

/// The structure of one lichen. Lengths are local units.
pub struct Cortex {
    radius: f32,
    areoles: Option<(Areoles, Sites)>,
    apothecia: Option<(Apothecia, Sites)>,
    /// Sites of elements born later are not there yet.
    elements: u32,
}

impl std::fmt::Debug for Cortex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cortex").finish_non_exhaustive()
    }
}

/// What the structure does to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// The share of the lichen's own light that comes back.
    pub shade: f32,
    /// What covers the lichen's own colour: its share, and linear light times that.
    pub share: f32,
    /// See [`share`](Self::share).
    pub cover: [f32; 3],
    /// How much higher the place is, local units.
    pub lift: f32,
    /// The gradient of the lift along the surface.
    pub slope: [f32; 3],
}

impl Detail {
    const NONE: Self = Self {
        shade: 1.0,
        share: 0.0,
        cover: [0.0; 3],
        lift: 0.0,
        slope: [0.0; 3],
    };

    /// Linear light of a lichen of this colour.
    pub fn over(&self, light: [f32; 3]) -> [f32; 3] {
        let own = self.shade * (1.0 - self.share);
        [0, 1, 2].map(|k| own * light[k] + self.cover[k])
    }

    fn covered(self, light: [f32; 3], share: f32) -> Self {
        let left = 1.0 - share;
        Self {
            share: 1.0 - left * (1.0 - self.share),
            cover: [0, 1, 2].map(|k| left * self.cover[k] + share * light[k]),
            ..self
        }
    }

    /// Scaled in height.
    fn flattened(self, by: f32) -> Self {
        Self {
            lift: self.lift * by,
            slope: self.slope.map(|x| x * by),
            ..self
        }
    }
}

impl Cortex {
    /// What this paint asks for on a lichen in birth order, so thick in element radii; none where it
    /// asks for nothing.
    pub(super) fn new(lichen: &Lichen, paint: &Paint, thickness: f64) -> Option<Self> {
        let r = lichen.radius;
        // Places of the upper side are asked for, and sites lie beneath it.
        let over = |along: f64| {
            let height = HIGHEST * thickness;
            (along * along + height * height).sqrt()
        };
        let found = |spacing: f64, reach: f64| Sites::new(&lichen.granules, spacing * r, reach * r);
        let areoles = paint.areoles.map(|areoles| {
            let width = f64::from(areoles.width);
            (areoles, found(width / WIDTH, over(1.5 * width + 2.0)))
        });
        let apothecia = paint.apothecia.map(|apothecia| {
            let reach = 0.5 * f64::from(apothecia.width * (1.0 + SHADE));
            (apothecia, found(apothecia.spacing.into(), over(reach)))
        });
        let some = areoles.is_some() || apothecia.is_some();
        some.then_some(Self {
            radius: r as f32,
            areoles,
            apothecia,
            elements: lichen.granules.len() as u32,
        })
    }

    /// Goes to a moment at which there are so many elements, at these distances from the rim.
    pub(super) fn move_to(&mut self, elements: u32, rim: impl Fn(u32) -> f32) {
        self.elements = elements;
        if let Some((_, sites)) = &mut self.apothecia {
            sites.set_rims(|birth| if birth < elements { rim(birth) } else { 0.0 });
        }
    }

    /// The structure over a place of the substrate, where the lichen's upper side has this unit normal; what is
    /// narrower than `blur` cannot be shown there. Lengths are local units.
    pub fn at(&self, place: [f64; 3], normal: [f32; 3], blur: f32) -> Detail {
        self.on(place.into(), normal.into(), blur, f32::INFINITY)
    }

    /// The same where the lichen is so thick.
    fn on(&self, p: DVec3, normal: Vec3, blur: f32, thickness: f32) -> Detail {
        let areole = self.areole(p, normal, blur, (1.0 - LEFT) * thickness);
        let mut detail = areole.unwrap_or(Detail::NONE);
        if let Some((apothecia, sites)) = &self.apothecia {
            let cup = self.cup(apothecia, sites, p, normal);
            detail = cup.map_or(detail, |cup| cup.on(apothecia, detail, blur));
        }
        detail
    }

    fn is_born(&self, site: &Site) -> bool {
        site.birth < self.elements
    }

    /// None where there are no areoles; cracks are so deep at most.
    fn areole(&self, p: DVec3, normal: Vec3, blur: f32, deepest: f32) -> Option<Detail> {
        let (areoles, sites) = self.areoles.as_ref()?;
        let width = areoles.width * self.radius;
        let born = sites.near(p, normal).filter(|site| self.is_born(site));
        let near: Vec<&Site> = born.collect();
        let distance_sq = |site: &&&Site| (site.position - p).length_squared();
        let own = near
            .iter()
            .min_by(|a, b| distance_sq(a).total_cmp(&distance_sq(b)))?;
        let mut planes = Planes::default();
        for other in near.iter().filter(|site| site.birth != own.birth) {
            planes.add(p, own.position, other.position, ROUND * width);
        }
        let (distance, inwards) = planes.distance(ROUND * width);
        let inwards = inwards - normal * inwards.dot(normal);
        let half = widened(CRACK * width, blur);
        let crack = CRACK * width / half * (1.0 - smooth_step(0.5, 1.5, distance / half).0);
        let level = widened(LEVEL * width, blur);
        let away = (1.0 - distance / level).max(0.0);
        let depth = (DEPTH * width).min(deepest) * (LEVEL * width / level);
        let detail = Detail {
            shade: 1.0 + TONES * (own.chance(TONE) - 0.5),
            lift: -depth * away * away,
            slope: (inwards * (2.0 * depth * away / level)).to_array(),
            ..Detail::NONE
        };
        Some(detail.covered(areoles.color.map(to_linear), crack))
    }

    /// The apothecium at a place.
    fn cup(&self, apothecia: &Apothecia, sites: &Sites, p: DVec3, normal: Vec3) -> Option<Cup> {
        let grown = |site: &Site| {
            let [begun, full] = GROWING.map(|x| x * apothecia.from);
            let inside = smooth_step(begun, full, site.rim).0;
            let age = 1.0 - site.birth as f32 / self.elements as f32;
            let size = inside * smooth_step(RIPENING[0], RIPENING[1], age).0;
            0.5 * apothecia.width * size * (1.0 - SMALLER * site.chance(SIZE))
        };
        let cup = |site: &Site| {
            let radius = grown(site);
            // Through space, so that a disc over an edge is folded.
            let away = (p - site.position).as_vec3();
            let out = away.length() / (radius * self.radius);
            let away = away - normal * away.dot(normal);
            (radius > SMALLEST && out < 1.0 + SHADE).then(|| Cup {
                radius: radius * self.radius,
                out,
                outwards: away.normalize_or_zero(),
            })
        };
        let born = sites.near(p, normal).filter(|site| self.is_born(site));
        born.filter_map(cup).min_by(|a, b| a.out.total_cmp(&b.out))
    }
}

/// A structure on places that were read from the field.
#[derive(Clone, Copy)]
pub(super) struct Dress<'a> {
    pub(super) cortex: &'a Cortex,
    pub(super) paint: &'a Paint,
    /// Birth index of the last element, at least 1.
    pub(super) last: f32,
    /// Local units.
    pub(super) blur: f32,
}

impl Dress<'_> {
    /// What the field says about a place, with the structure.
    pub(super) fn sample(&self, place: DVec3, bare: &Sample) -> Sample {
        let Attributes {
            birth,
            density,
            outline,
            ..
        } = bare.attributes;
        let detail = self.cortex.on(place, bare.up, self.blur, bare.height);
        let light = self.paint.light(density, birth / self.last, outline);
        let slope = Vec3::from(detail.slope) * bare.normal.dot(bare.up).max(0.0);
        Sample {
            height: (bare.height + detail.lift).max(0.0),
            normal: (bare.normal - slope).normalize_or(bare.normal),
            attributes: Attributes {
                color: Some(detail.over(light).map(to_byte)),
                ..bare.attributes
            },
            ..*bare
        }
    }
}

/// Where the weight of a plane is below 1e-5, in lengths of the rounding.
const UNFELT: f32 = 12.0;

/// Planes halfway between a site and those about it.
#[derive(Default)]
struct Planes {
    sum: f32,
    inwards: Vec3,
}

impl Planes {
    fn add(&mut self, p: DVec3, own: DVec3, other: DVec3, round: f32) {
        let across = (other - own).as_vec3();
        let apart = across.length();
        let middle = (0.5 * (own + other) - p).as_vec3();
        let far = (middle.dot(across) / apart).max(0.0) / round;
        if far > UNFELT {
            return;
        }
        let weight = libm::expf(-far);
        self.sum += weight;
        self.inwards -= across * (weight / apart);
    }

    /// The smooth least distance to any of them, and its gradient.
    fn distance(&self, round: f32) -> (f32, Vec3) {
        match self.sum > 0.0 {
            true => {
                let distance = -round * libm::logf(self.sum);
                (distance.max(0.0), self.inwards / self.sum)
            }
            false => (f32::INFINITY, Vec3::ZERO),
        }
    }
}

/// A place about an apothecium.
struct Cup {
    radius: f32,
    /// Distance from its middle, in radii.
    out: f32,
    outwards: Vec3,
}

impl Cup {
    /// The cup on what else there is.
    fn on(&self, apothecia: &Apothecia, under: Detail, blur: f32) -> Detail {
        let soft = 0.06 + 0.5 * blur / self.radius;
        let (outside, fall) = smooth_step(1.0 - soft, 1.0 + soft, self.out);
        let inside = 1.0 - outside;
        let rim = 1.0 - apothecia.margin;
        let disc = 1.0 - smooth_step(rim - soft, rim + soft, self.out).0;
        let (height, slope) = profile(self.out, apothecia.margin, soft);
        let shade = 1.0 - 0.4 * (1.0 - smooth_step(1.0, 1.0 + SHADE, self.out).0);
        let filled = under.lift * fall / self.radius;
        let under = under.flattened(outside);
        let lifted = Detail {
            // The margin is not cracked, and a little paler than the thallus.
            shade: under.shade * shade * outside + 1.1 * inside,
            share: under.share * outside,
            cover: under.cover.map(|x| x * outside),
            lift: under.lift + CUP * self.radius * height,
            slope: (Vec3::from(under.slope) + self.outwards * (CUP * slope + filled)).to_array(),
        };
        lifted.covered(apothecia.color.map(to_linear), disc)
    }
}

/// Height of a cup over its margin's at a distance from its middle, in radii, and its slope.
fn profile(out: f32, margin: f32, soft: f32) -> (f32, f32) {
    let (wall, fall) = smooth_step(0.75 - soft, 1.0 + soft, out);
    let (inner, rise) = smooth_step(1.0 - 2.0 * margin - soft, 1.0 - 0.5 * margin, out);
    let hollow = if margin > 0.0 { 0.4 } else { 0.0 };
    let height = 1.0 - hollow + hollow * inner;
    let level = if margin > 0.0 { 1.0 } else { 0.4 };
    (
        level * (1.0 - wall) * height,
        level * ((1.0 - wall) * hollow * rise - fall * height),
    )
}

/// A width where what is narrower than `blur` cannot be shown.
fn widened(width: f32, blur: f32) -> f32 {
    (width * width + blur * blur).sqrt()
}

/// 0 up to `low`, 1 from `high` on, smooth between them; and its slope.
fn smooth_step(low: f32, high: f32, x: f32) -> (f32, f32) {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t) / (high - low))
}

#[cfg(test)]
mod tests {
    use super::super::lichen::Granule;
    use super::super::sites::tests::disc;
    use super::*;

    const CRACKED: Areoles = Areoles {
        width: 9.0,
        color: [0; 3],
    };

    const FRUITS: Apothecia = Apothecia {
        width: 10.0,
        spacing: 12.0,
        from: 20.0,
        color: [200, 80, 20],
        margin: 0.25,
    };

    fn cortex(areoles: Option<Areoles>, apothecia: Option<Apothecia>) -> Cortex {
        let lichen = Lichen {
            radius: 1.0,
            granules: disc(90.0),
        };
        let paint = Paint {
            areoles,
            apothecia,
            ..Paint::default()
        };
        Cortex::new(&lichen, &paint, 2.0).expect("a structure")
    }

    /// Places of a square about the middle, as far apart as is told.
    fn places(half: f64, apart: f64) -> impl Iterator<Item = [f64; 3]> {
        let n = (half / apart) as i32;
        let along = move |i: i32| f64::from(i) * apart;
        (-n..=n).flat_map(move |i| (-n..=n).map(move |j| [along(i), along(j), 0.0]))
    }

    fn at(cortex: &Cortex, place: [f64; 3], blur: f32) -> Detail {
        cortex.at(place, [0.0, 0.0, 1.0], blur)
    }

    fn mean(cortex: &Cortex, blur: f32, of: impl Fn(Detail) -> f32) -> f64 {
        let (mut sum, mut n) = (0.0, 0);
        for place in places(60.0, 0.37) {
            sum += f64::from(of(at(cortex, place, blur)));
            n += 1;
        }
        sum / f64::from(n)
    }

    /// An areole is somewhat smaller than a square of its width, on average: counted by their tones.
    /// Sites cannot be denser than 1.72 to the square.
    #[test]
    fn areoles_have_their_width() {
        for width in [8.0f32, 12.0, 16.0] {
            let cortex = cortex(Some(Areoles { width, ..CRACKED }), None);
            let mut tones: Vec<u32> = Vec::new();
            let half = 60.0;
            for place in places(half, 0.8) {
                tones.push(at(&cortex, place, 0.0).shade.to_bits());
            }
            tones.sort_unstable();
            tones.dedup();
            // Those that the square's border cuts count as well: about half of them too many.
            let across = 2.0 * half / f64::from(width);
            let expected = across * across + 2.0 * across;
            let share = tones.len() as f64 / expected;
            assert!((1.0..1.5).contains(&share), "{width}: {share}");
        }
    }

    /// Cracks take one share of the surface however wide areoles are, and however finely it is shown.
    #[test]
    fn cracks_keep_their_share() {
        let share = |width: f32, blur: f32| {
            let cortex = cortex(Some(Areoles { width, ..CRACKED }), None);
            mean(&cortex, blur, |d| d.share)
        };
        let fine = share(9.0, 0.0);
        assert!((0.15..0.3).contains(&fine), "{fine}");
        for (width, blur) in [(18.0, 0.0), (9.0, 0.5), (9.0, 1.0)] {
            let other = share(width, blur);
            assert!(
                (other / fine - 1.0).abs() < 0.15,
                "{width} {blur}: {other} {fine}"
            );
        }
    }

    /// No jump in colour or height, and the slope is that of the height but where cracks and middles of
    /// cups have none.
    #[test]
    fn structure_is_continuous_and_slopes_are_its_gradient() {
        let cortex = cortex(Some(CRACKED), Some(FRUITS));
        let step = 1e-3;
        let (mut wrong, mut all) = (0, 0);
        for place in places(60.0, 0.91) {
            let here = at(&cortex, place, 0.3);
            for axis in 0..2 {
                let mut there = place;
                there[axis] += step;
                let there = at(&cortex, there, 0.3);
                let rise = (there.lift - here.lift) / step as f32;
                assert!(rise.abs() < 4.0, "{place:?}: {rise}");
                assert!(
                    (there.share - here.share).abs() < 6.0 * step as f32,
                    "{place:?}"
                );
                all += 1;
                wrong += i32::from((rise - here.slope[axis]).abs() > 0.05);
            }
        }
        assert!(wrong * 50 < all, "{wrong} of {all}");
    }

    #[test]
    fn apothecia_keep_away_from_the_rim_and_stand_out() {
        let cortex = cortex(None, Some(FRUITS));
        let mut seen = 0;
        for place in places(88.0, 0.8) {
            let detail = at(&cortex, place, 0.0);
            let rim = 90.0 - DVec3::from(place).length();
            assert!(detail.lift >= 0.0);
            if detail.share > 0.0 {
                assert!(rim > 15.0, "{place:?}");
                seen += 1;
            }
            if detail.share == 1.0 {
                assert_eq!(detail.over([1.0; 3]), FRUITS.color.map(to_linear));
            }
        }
        assert!(seen > 1000, "{seen}");
        let level = Apothecia {
            margin: 0.0,
            ..FRUITS
        };
        let flat = self::cortex(None, Some(level));
        let height = |cortex: &Cortex| mean(cortex, 0.0, |d| d.lift);
        assert!(height(&flat) < height(&cortex));
    }

    /// As a lichen grows, apothecia come where it is old enough, and sites that are not born count
    /// for nothing.
    #[test]
    fn moments_have_the_structure_of_their_elements() {
        let mut grown = cortex(Some(CRACKED), Some(FRUITS));
        let granules = disc(90.0);
        let young = granules.iter().filter(|g| g.position.length() < 50.0);
        let rim = |g: &Granule| Granule {
            rim: (50.0 - g.position.length()) as f32,
            ..*g
        };
        let young: Vec<Granule> = young.map(rim).collect();
        let alone = Lichen {
            radius: 1.0,
            granules: young.clone(),
        };
        let paint = Paint {
            areoles: Some(CRACKED),
            apothecia: Some(FRUITS),
            ..Paint::default()
        };
        let alone = Cortex::new(&alone, &paint, 2.0).expect("a structure");
        let whole = at(&grown, [30.0, 0.0, 0.0], 0.0);
        grown.move_to(young.len() as u32, |birth| young[birth as usize].rim);
        for place in places(35.0, 0.7) {
            assert_eq!(at(&grown, place, 0.0), at(&alone, place, 0.0), "{place:?}");
        }
        grown.move_to(granules.len() as u32, |birth| granules[birth as usize].rim);
        assert_eq!(at(&grown, [30.0, 0.0, 0.0], 0.0), whole);
    }

    #[test]
    fn the_other_face_has_a_structure_of_its_own() {
        let cortex = cortex(Some(CRACKED), Some(FRUITS));
        let below = cortex.at([3.0, 4.0, -0.1], [0.0, 0.0, -1.0], 0.0);
        assert_eq!(below, Detail::NONE);
    }
}
