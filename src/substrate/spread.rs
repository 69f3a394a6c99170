//! Places spread evenly over a surface.

use super::{Substrate, SurfacePoint};

impl Substrate {
    /// So many places, give or take one, spread evenly over the surface: as many on a part of it as it has of the area.
    pub fn spread(&self, places: usize) -> Vec<SurfacePoint> {
        self.spread_over(|| 0..self.triangles().len() as u32, places)
    }

    /// The same over these triangles.
    pub(crate) fn spread_over<I: Iterator<Item = u32>>(
        &self,
        triangles: impl Fn() -> I,
        places: usize,
    ) -> Vec<SurfacePoint> {
        let all: f64 = triangles().map(|t| self.area(t)).sum();
        let apart = all / places as f64;
        if !(apart > 0.0 && apart.is_finite()) {
            return Vec::new();
        }
        let (mut spread, mut left) = (Vec::with_capacity(places + 1), 0.5 * apart);
        for t in triangles() {
            left += self.area(t);
            while left >= apart {
                left -= apart;
                let [u, v] = evenly_spread(spread.len());
                let weights = [1.0 - u, u * (1.0 - v), u * v];
                spread.push(SurfacePoint::from_weights(t, weights));
            }
        }
        spread
    }
}

/// The n-th place of a triangle in a sequence that fills it evenly: the share of the way from a corner and the share of
/// the way across there (R2, M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018).
fn evenly_spread(n: usize) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let n = n as f64 + 0.5;
    let [s, t] = [n / PLASTIC, n / (PLASTIC * PLASTIC)].map(f64::fract);
    [s.sqrt(), t]
}

#[cfg(test)]
mod tests {
    use super::super::Soup;
    use super::*;

    /// A square of side 1 and one of side 3 beside it, each of two triangles.
    fn squares() -> Substrate {
        let corners = |x: f64, side: f64| {
            [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[a, b]| [x + a, b, 0.0])
        };
        let triangles = [0, 4].map(|k| [[k, k + 1, k + 2], [k, k + 2, k + 3]]);
        let soup = Soup {
            positions: [corners(0.0, 1.0), corners(2.0, 3.0)].concat(),
            triangles: triangles.concat(),
            notes: Vec::new(),
        };
        Substrate::from_soup(soup).unwrap()
    }

    #[test]
    fn each_part_has_its_share_of_the_places() {
        let substrate = squares();
        let places = substrate.spread(2000);
        assert!(places.len().abs_diff(2000) <= 1);
        // In which of four by four equal parts of the large square.
        let mut parts = [0; 16];
        let mut in_small = 0;
        for at in &places {
            let p = substrate.units().to_file(substrate.position(at));
            match p[0] < 1.5 {
                true => in_small += 1,
                false => {
                    let part = |x: f64| ((x / 0.75) as usize).min(3);
                    parts[4 * part(p[0] - 2.0) + part(p[1])] += 1;
                }
            }
        }
        assert!((199..=201).contains(&in_small), "{in_small}");
        assert!(parts.iter().all(|n| (100..=125).contains(n)), "{parts:?}");
    }
}
