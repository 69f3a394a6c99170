//! How many elements lie within a distance of a centre.

use rayon::prelude::*;

/// Distances from one element to all.
pub trait Metric: Sync {
    /// The distance from an element to every element. Those beyond `limit` may be told as infinite.
    ///
    /// # Panics
    /// When there is no such element.
    fn distances(&self, from: usize, limit: f64) -> Vec<f64>;

    /// How many elements are no farther from an element than each of these radii, which ascend.
    ///
    /// # Panics
    /// When there is no such element; when radii do not ascend, or the first is negative or no number.
    fn within(&self, from: usize, radii: &[f64]) -> Vec<u64> {
        let mut rings = Rings::new(radii);
        let limit = radii.last().copied().unwrap_or(0.0);
        for distance in self.distances(from, limit) {
            rings.add(distance, distance, 1);
        }
        rings.within()
    }

    /// Area of the ground in each of so many rings of this width about an element, the first a disc, in
    /// the square of the unit of distances. None where no ground is known, or too little to tell such rings apart.
    ///
    /// # Panics
    /// When there is no such element, or the width is not a positive finite number.
    fn ring_areas(&self, _from: usize, _width: f64, _rings: usize) -> Option<Vec<f64>> {
        None
    }
}

/// Lengths from the first in steps of √2, the first beyond `until` being the last; where that is infinite, the
/// last that is a number. From 0 no step leads on.
pub(super) fn ladder(first: f64, until: f64) -> Vec<f64> {
    let step = |&rung: &f64| {
        let next = rung * std::f64::consts::SQRT_2;
        (rung > 0.0 && rung <= until && next.is_finite()).then_some(next)
    };
    std::iter::successors(Some(first), step).collect()
}

/// Distances to count elements within: from 2.1 element radii on, see [`ladder`].
///
/// Packed elements stand at 2, 3.46, 4, 5.29, 6 … r from each other. Whether those just there count
/// would be a matter of round-off, and all of them is as wrong as none: these distances lie between.
pub(super) fn distances(radius: f64, until: f64) -> Vec<f64> {
    ladder(2.1 * radius, until)
}

/// The mean over centres of the number of elements within each radius, the centre among them.
/// Radii ascend.
pub(super) fn mean_mass(metric: &dyn Metric, centres: &[usize], radii: &[f64]) -> Vec<f64> {
    let none = || vec![0u64; radii.len()];
    let add = |a: Vec<u64>, b: Vec<u64>| std::iter::zip(a, b).map(|(a, b)| a + b).collect();
    let within = |&centre: &usize| metric.within(centre, radii);
    let within = centres.par_iter().map(within).reduce(none, add);
    let mean = |n: u64| n as f64 / centres.len().max(1) as f64;
    within.into_iter().map(mean).collect()
}

/// How many elements are beyond each radius but the last, and no farther than the next.
pub(super) struct Rings<'a> {
    finder: RingFinder<'a>,
    counts: Vec<u64>,
}

impl<'a> Rings<'a> {
    pub(super) fn new(radii: &'a [f64]) -> Self {
        Self {
            finder: RingFinder::new(radii),
            counts: vec![0; radii.len()],
        }
    }

    /// Counts so many elements, none of them nearer or farther than this; false, and none is
    /// counted, where that does not tell in which ring they are.
    pub(super) fn add(&mut self, nearest: f64, farthest: f64, elements: u64) -> bool {
        let ring = self.finder.ring_of(nearest);
        if farthest > nearest && self.finder.ring_of(farthest) != ring {
            return false;
        }
        if let Some(count) = self.counts.get_mut(ring) {
            *count += elements;
        }
        true
    }

    /// How many are no farther than each radius.
    pub(super) fn within(mut self) -> Vec<u64> {
        let mut within = 0;
        for count in &mut self.counts {
            within += *count;
            *count = within;
        }
        self.counts
    }
}

/// Finds the least of ascending radii that a distance is no greater than, starting from a table by
/// the distance's exponent and the highest bit of its mantissa: two to the octave, as the radii.
struct RingFinder<'a> {
    radii: &'a [f64],
    /// The key of the first row.
    base: u64,
    /// The ring of the least distance with each key.
    rows: Vec<usize>,
}

impl<'a> RingFinder<'a> {
    /// Bits of a distance below its key.
    const BELOW: u32 = f64::MANTISSA_DIGITS - 2;

    fn new(radii: &'a [f64]) -> Self {
        let is_length = radii.first().is_none_or(|&r| r >= 0.0);
        assert!(
            is_length && radii.is_sorted(),
            "radii that do not ascend from 0 on: {radii:?}"
        );
        let key = |radius: Option<&f64>| radius.map_or(0, |r| r.abs().to_bits() >> Self::BELOW);
        let (base, last) = (key(radii.first()), key(radii.last()));
        let least = |key: u64| f64::from_bits(key << Self::BELOW);
        let ring = |key: u64| radii.partition_point(|&r| r < least(key));
        Self {
            radii,
            base,
            rows: (base..=last).map(ring).collect(),
        }
    }

    /// The number of the radius; how many there are for a distance beyond all.
    fn ring_of(&self, distance: f64) -> usize {
        let key = (distance.to_bits() >> Self::BELOW).saturating_sub(self.base);
        let mut ring = self.rows[(key as usize).min(self.rows.len() - 1)];
        while self.radii.get(ring).is_some_and(|&r| r < distance) {
            ring += 1;
        }
        ring
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::space::Space;
    use super::*;

    #[test]
    fn rings_are_those_of_a_search_through_all() {
        let near = |r: f64| [r.next_down(), r, r.next_up(), 1.2 * r, 0.7 * r];
        for radii in [
            ladder(0.1, 40.0),
            ladder(2e-3, 1e-3),
            vec![0.3, 7.0, 7.1, 900.0],
            Vec::new(),
        ] {
            let finder = RingFinder::new(&radii);
            let others = [0.0, f64::MIN_POSITIVE, 1e9, f64::MAX, f64::INFINITY];
            for distance in radii.iter().flat_map(|&r| near(r)).chain(others) {
                let expected = radii.partition_point(|&r| r < distance);
                assert_eq!(
                    finder.ring_of(distance),
                    expected,
                    "{distance} in {radii:?}"
                );
            }
        }
    }

    #[test]
    fn radii_that_do_not_ascend_are_refused() {
        for radii in [
            &[0.5, 0.1][..],
            &[-1.0],
            &[f64::NAN],
            &[0.5, f64::NAN],
            &[0.1, f64::NAN, 0.2],
        ] {
            let refused = std::panic::catch_unwind(|| RingFinder::new(radii)).err();
            let said = refused.and_then(|said| said.downcast::<String>().ok());
            assert!(
                said.is_some_and(|said| said.contains("ascend")),
                "{radii:?}"
            );
        }
        for radii in [&[-0.0, 1.0][..], &[0.3, 0.3], &[1.0, f64::INFINITY]] {
            assert_eq!(RingFinder::new(radii).ring_of(0.0), 0);
        }
    }

    #[test]
    fn ladders_end() {
        assert_eq!(ladder(1.0, 2.5).len(), 4);
        let all = ladder(1.0, f64::INFINITY);
        assert!(all.len() == 2048 && all.iter().all(|rung| rung.is_finite()));
        for (first, until) in [
            (0.0, 1.0),
            (0.0, f64::INFINITY),
            (-1.0, 1.0),
            (1.0, f64::NAN),
        ] {
            assert_eq!(ladder(first, until), [first]);
        }
    }

    #[test]
    fn mean_mass_is_a_count_over_all() {
        let positions: Vec<_> = (0..200)
            .map(|i| {
                let t = f64::from(i);
                [(t * 0.7).sin(), (t * 1.3).cos(), (t * 0.37).sin()]
            })
            .collect();
        let (centres, radii) = ([3, 50, 111], distances(0.05, 1.0));
        let found = mean_mass(&Space::new(&positions), &centres, &radii);
        for (radius, found) in radii.iter().zip(found) {
            let near = |c: usize| {
                let centre = DVec3::from(positions[c]);
                let near = |&&p: &&[f64; 3]| DVec3::from(p).distance(centre) <= *radius;
                positions.iter().filter(near).count()
            };
            let expected = centres.iter().map(|&c| near(c)).sum::<usize>() as f64 / 3.0;
            assert_eq!(found, expected);
        }
        assert!((radii[0] - 0.105).abs() < 1e-12 && *radii.last().unwrap() > 1.0);
    }
}
