//! A limb of wood as a signed field: a tapered tube along a cubic curve, furrowed bark around it, torn ends.
//!
//! The field is negative inside. It isn't a true distance, only close to one near the surface.

use glam::DVec3;

use crate::noise::{fbm, noise, ridged, smoothstep};

/// A straight piece of sampled axis serves to find the nearest point roughly.
const SAMPLES: u32 = 8;
/// Newton steps from there.
const STEPS: u32 = 4;

/// Farther away than this, in metres, a cheap bound stands in for the field. More than relief, tears and collars reach.
const MARGIN: f64 = 0.08;

/// How the bark is furrowed; lengths in metres.
pub(crate) struct Bark {
    /// From the floor of a furrow to the plates.
    pub(crate) depth: f64,
    /// Typical distance between furrows, around the limb.
    pub(crate) spacing: f64,
}

/// How an end was broken off; lengths in metres.
pub(crate) struct Tear {
    /// The break's slope: its plane leans towards this direction.
    pub(crate) lean: DVec3,
    /// Height of the tongue of wood left standing on the side that the break leans to.
    pub(crate) tongue: f64,
    /// Height of the splinters.
    pub(crate) splinters: f64,
}

/// A tube of wood from `axis[0]` to `axis[3]`.
pub(crate) struct Limb {
    pub(crate) axis: [DVec3; 4],
    /// Radii at the start and the end, bark included.
    pub(crate) radii: [f64; 2],
    pub(crate) bark: Bark,
    pub(crate) tears: [Tear; 2],
    pub(crate) seed: u32,
}

/// A point as seen from a limb's axis.
struct Place {
    /// Parameter of the nearest axis point, 0 to 1.
    t: f64,
    /// From the axis to the point, square to it.
    out: DVec3,
    /// Distances beyond the start and the end; negative between them.
    beyond: [f64; 2],
}

impl Limb {
    /// Signed field of the whole limb: bark where it is covered, bare wood at the ends. `roughness` scales furrows and
    /// splinters: 1 is the finished wood.
    pub(crate) fn field(&self, p: DVec3, roughness: f64) -> f64 {
        let clearance = self.clearance(p);
        if clearance > MARGIN {
            return clearance;
        }
        let place = self.place(p);
        let distance = place.out.length();
        let tube = distance - self.radius(place.t);
        let relief = if tube.abs() < MARGIN {
            roughness * self.relief(&place, distance)
        } else {
            0.0
        };
        let ends = [0, 1].map(|end| {
            let beyond = place.beyond[end];
            if beyond < -MARGIN {
                beyond
            } else {
                beyond - roughness * self.tear_height(end, &place)
            }
        });
        soft_max(tube + relief, ends[0].max(ends[1]), 0.006)
    }

    /// A lower bound on the distance to the tube without its relief: that to the box around its axis.
    fn clearance(&self, p: DVec3) -> f64 {
        let [a, b, c, d] = self.axis;
        let (low, high) = (a.min(b).min(c).min(d), a.max(b).max(c).max(d));
        (p - p.clamp(low, high)).length() - self.radii[0].max(self.radii[1])
    }

    fn point(&self, t: f64) -> DVec3 {
        let [a, b, c, d] = self.axis;
        let s = 1.0 - t;
        a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
    }

    fn velocity(&self, t: f64) -> DVec3 {
        let [a, b, c, d] = self.axis;
        let s = 1.0 - t;
        3.0 * ((b - a) * (s * s) + (c - b) * (2.0 * s * t) + (d - c) * (t * t))
    }

    fn acceleration(&self, t: f64) -> DVec3 {
        let [a, b, c, d] = self.axis;
        6.0 * ((c - 2.0 * b + a) * (1.0 - t) + (d - 2.0 * c + b) * t)
    }

    fn radius(&self, t: f64) -> f64 {
        self.radii[0] + (self.radii[1] - self.radii[0]) * t
    }

    fn nearest(&self, p: DVec3) -> f64 {
        let sample = |i: u32| f64::from(i) / f64::from(SAMPLES);
        let away = |i: &u32| self.point(sample(*i)).distance_squared(p);
        let best = (0..=SAMPLES)
            .min_by(|i, j| away(i).total_cmp(&away(j)))
            .unwrap_or(0);
        (0..STEPS).fold(sample(best), |t, _| {
            let (offset, v) = (self.point(t) - p, self.velocity(t));
            let bend = (v.dot(v) + offset.dot(self.acceleration(t))).max(0.3 * v.dot(v));
            (t - offset.dot(v) / bend).clamp(0.0, 1.0)
        })
    }

    fn place(&self, p: DVec3) -> Place {
        let t = self.nearest(p);
        let along = self.velocity(t).normalize();
        let offset = p - self.point(t);
        Place {
            t,
            out: offset - along * offset.dot(along),
            beyond: [
                (self.axis[0] - p).dot(self.velocity(0.0).normalize()),
                (p - self.axis[3]).dot(self.velocity(1.0).normalize()),
            ],
        }
    }

    /// How far the bark lies below the tube: 0 on the plates, `depth` and more in the furrows. The noise is read on a
    /// straight cylinder, the limb unrolled, so that furrows follow the axis.
    fn relief(&self, place: &Place, distance: f64) -> f64 {
        let outward = place.out / distance.max(1e-9);
        let ring = outward * self.radius(place.t).max(0.6 * self.radii[0]);
        let length = self.axis[0].distance(self.axis[3]);
        let along = self.velocity(place.t).normalize();
        let unrolled = |stretch: f64| ring + along * ((place.t - 0.5) * length / stretch);
        let bark = &self.bark;
        let wander =
            0.35 * bark.spacing * fbm(unrolled(2.0) * (0.7 / bark.spacing), 2, self.seed + 7);
        let q = (unrolled(5.0) + outward.cross(along) * wander) * (0.62 / bark.spacing);
        let furrow = 1.0 - smoothstep(0.0, 0.30, noise(q, self.seed).abs());
        let fine = 1.0 - smoothstep(0.0, 0.35, noise(q * 2.3, self.seed + 1).abs());
        let steps = unrolled(0.8) * (0.55 / bark.spacing);
        let checks =
            (1.0 - smoothstep(0.0, 0.16, noise(steps, self.seed + 2).abs())) * (1.0 - furrow);
        let lumps = fbm(unrolled(1.5) * (0.22 / bark.spacing), 2, self.seed + 3);
        let grain = fbm(unrolled(2.5) * (3.0 / bark.spacing), 2, self.seed + 4);
        bark.depth * (furrow + 0.35 * fine + 0.35 * checks - 0.12 * grain)
            - 0.10 * self.radius(place.t) * lumps
    }

    /// How far wood stands beyond the end's plane at this distance from the axis: a leaning break with splinters
    /// along the grain.
    fn tear_height(&self, end: usize, place: &Place) -> f64 {
        let tear = &self.tears[end];
        let across = place.out / self.radii[end];
        let toward = across.dot(tear.lean.normalize_or_zero());
        let q = across + DVec3::splat(self.seed as f64 + 5.0 * end as f64);
        let ragged = toward + 0.45 * noise(q * 1.6, self.seed + 11);
        let splinters = ridged(q * 1.5, 2, self.seed + 12) - 0.6;
        let fibres = fbm(q * 4.5, 2, self.seed + 13);
        tear.tongue * smoothstep(-0.2, 0.7, ragged) + tear.splinters * (splinters + 0.3 * fibres)
    }
}

/// The larger of two, rounded off where they differ by less than `k`.
fn soft_max(a: f64, b: f64, k: f64) -> f64 {
    -soft_min(-a, -b, k)
}

/// The smaller of two, with a fillet where they differ by less than `k`.
pub(crate) fn soft_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight() -> Limb {
        let blunt = || Tear {
            lean: DVec3::ZERO,
            tongue: 0.0,
            splinters: 0.0,
        };
        Limb {
            axis: [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0)),
            radii: [0.2, 0.2],
            bark: Bark {
                depth: 1e-9,
                spacing: 0.05,
            },
            tears: [blunt(), blunt()],
            seed: 3,
        }
    }

    #[test]
    fn a_straight_limb_is_a_lumpy_cylinder_cut_square() {
        let limb = straight();
        for (p, inside) in [
            ([1.5, 0.15, 0.0], true),
            ([1.5, 0.0, 0.25], false),
            ([0.05, 0.0, 0.0], true),
        ] {
            assert_eq!(limb.field(DVec3::from_array(p), 1.0) < 0.0, inside, "{p:?}");
        }
        assert!(limb.field(DVec3::new(3.02, 0.0, 0.0), 1.0) > 0.0);
        assert!(limb.field(DVec3::new(-0.02, 0.1, 0.0), 1.0) > 0.0);
    }

    #[test]
    fn the_nearest_axis_point_is_square_to_the_axis() {
        let mut limb = straight();
        limb.axis[1].y = 0.4;
        limb.axis[2].z = -0.3;
        for i in 1..20 {
            let foot = limb.point(f64::from(i) / 20.0);
            let along = limb.velocity(f64::from(i) / 20.0).normalize();
            let t = limb.nearest(foot + along.any_orthonormal_vector() * 0.1);
            assert!((t - f64::from(i) / 20.0).abs() < 1e-6);
        }
    }

    #[test]
    fn soft_minimum_is_below_both_and_exact_far_away() {
        assert_eq!(soft_min(0.0, 1.0, 0.1), 0.0);
        assert!(soft_min(0.5, 0.5, 0.1) < 0.5);
        assert!(soft_max(0.5, 0.5, 0.1) > 0.5);
    }
}
