//! How wide branches are.

use serde::Serialize;

use crate::morphometry::{Neighbours, rim_distance};

/// What the distance from the rim must gain on the way for the way to lead towards the middle.
const SLOPE: f64 = 0.5;

/// For each element the width of the branch that it lies in: twice the distance from the rim at the
/// branch's ridge, and one element more. None where there is no rim.
///
/// The ridge is found by the steepest ascent of the distance from the rim, over neighbours, as long
/// as it gains at least half of the way. On an ideal branch it gains all of it, and along a ridge
/// nothing, or the sine of half the angle at which the branch widens; so the middle of a disc, and
/// of a branch that widens by less than 60°, counts. Width by the greatest disc within (T. Hildebrand
/// and P. Rüegsegger, *A new method for the model-independent assessment of thickness*, 1997) agrees
/// on strips and discs. Right to about one element.
pub(super) fn branch_widths(
    radius: f64,
    rim: &[bool],
    neighbours: &Neighbours,
) -> Vec<Option<f64>> {
    let rim_distance = rim_distance(rim, neighbours);
    let known: Vec<f64> = rim_distance.iter().map(|d| d.unwrap_or(0.0)).collect();
    let depths = neighbours.by_slot(&known);
    let next = neighbours.map(|i| {
        let depth = known[i];
        let mut best = (0.0, i as u32);
        let is_deeper = |slot: usize| depths[slot] > depth;
        neighbours.visit_slots(neighbours.slot(i), is_deeper, |slot, _, way| {
            let (j, gain) = (neighbours.number(slot), depths[slot] - depth - SLOPE * way);
            if gain > best.0 || (gain == best.0 && gain > 0.0 && j < best.1) {
                best = (gain, j);
            }
        });
        best.1
    });
    let width = |i: usize| {
        let mut at = i;
        while next[at] as usize != at {
            at = next[at] as usize;
        }
        rim_distance[i].map(|_| 2.0 * (known[at] + radius))
    };
    (0..rim_distance.len()).map(width).collect()
}

/// How values are spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distribution {
    /// How many.
    pub count: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation, of the values themselves.
    pub deviation: f64,
    /// Values that 5, 25, 50, 75 and 95 percent are no greater than.
    pub percentiles: [f64; 5],
}

impl Distribution {
    /// None of no values.
    pub(super) fn of(mut values: Vec<f64>) -> Option<Self> {
        let count = values.len();
        let n = count as f64;
        values.sort_unstable_by(f64::total_cmp);
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let at = |percent: usize| values[(count * percent).div_ceil(100) - 1];
        (count > 0).then(|| Self {
            count,
            mean,
            deviation: (squares / n).sqrt(),
            percentiles: [5, 25, 50, 75, 95].map(at),
        })
    }

    /// The deviation; none of a single value, which says nothing of how others are spread.
    pub(super) fn spread(&self) -> Option<f64> {
        (self.count > 1).then_some(self.deviation)
    }
}

/// How many values fall into bins of one width, the first of which starts at 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Width of a bin.
    pub bin: f64,
    /// Values in each, a value on a bound being in the upper one.
    pub counts: Vec<u64>,
}

impl Histogram {
    pub(super) fn of(values: &[f64], bin: f64) -> Self {
        /// A value is on a bound if no more than this share of a bin below it: many widths are whole diameters.
        const ON_BOUND: f64 = 0.01;
        let mut counts = Vec::new();
        for value in values {
            let k = (value / bin + ON_BOUND) as usize;
            counts.resize(counts.len().max(k + 1), 0);
            counts[k] += 1;
        }
        Self { bin, counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distribution_is_told_by_its_ranks() {
        let d = Distribution::of((1..=100).rev().map(f64::from).collect()).unwrap();
        assert_eq!((d.count, d.mean), (100, 50.5));
        assert_eq!(d.percentiles, [5.0, 25.0, 50.0, 75.0, 95.0]);
        assert!((d.deviation - (9999f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(Distribution::of(Vec::new()), None);
        let one = Distribution::of(vec![3.0]).unwrap();
        assert_eq!((one.percentiles, one.spread()), ([3.0; 5], None));
        assert_eq!(d.spread(), Some(d.deviation));
    }

    #[test]
    fn every_value_is_in_its_bin() {
        let histogram = Histogram::of(&[0.0, 0.9, 2.0, 7.9, 2.1], 2.0);
        assert_eq!(histogram.counts, [2, 2, 0, 1]);
        assert!(Histogram::of(&[], 2.0).counts.is_empty());
    }
}
