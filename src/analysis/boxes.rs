//! Box counting.

use glam::DVec3;
use rayon::prelude::*;

use super::space::in_order;

/// Places of a grid of boxes that a count is the mean over.
const PLACES: u32 = 16;

/// The number of boxes of each size that hold a centre, the mean over 16 places of the grid, which
/// are those of the additive sequence of least discrepancy in three dimensions (M. Roberts, 2018,
/// after the root of x⁴ = x + 1).
pub(super) fn count_boxes(positions: &[[f64; 3]], sizes: &[f64]) -> Vec<f64> {
    let places = in_order(positions);
    let low = places.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
    let jobs: Vec<(f64, u32)> = sizes
        .iter()
        .flat_map(|&size| (0..PLACES).map(move |place| (size, place)))
        .collect();
    let counts: Vec<usize> = jobs
        .par_iter()
        .map(|&(size, place)| occupied(&places, low - size * shift(place), size))
        .collect();
    counts
        .chunks(PLACES as usize)
        .map(|places| places.iter().sum::<usize>() as f64 / f64::from(PLACES))
        .collect()
}

fn shift(place: u32) -> DVec3 {
    const STEP: DVec3 = DVec3::new(
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_3,
        0.549_700_477_901_970_2,
    );
    (STEP * f64::from(place) + 0.5).fract()
}

/// Places come in an order in which many in a row are in one box: only the first of these counts.
fn occupied(places: &[DVec3], corner: DVec3, size: f64) -> usize {
    let cell = |&p: &DVec3| {
        let cell = ((p - corner) / size).to_array().map(|c| c as u64);
        cell.into_iter()
            .fold(0u128, |cell, c| cell << 42 | u128::from(c))
    };
    let mut cells: Vec<_> = places.iter().map(cell).collect();
    cells.dedup();
    cells.sort_unstable();
    cells.dedup();
    cells.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A segment of length l meets l/ε + 1 boxes on the mean over all places of the grid.
    #[test]
    fn a_segment_meets_as_many_boxes_as_it_is_long() {
        let segment: Vec<_> = (0..100_001)
            .map(|i| [f64::from(i) * 1e-3, 0.3, 7.0])
            .collect();
        let sizes = [0.5, 1.0, 7.0, 50.0];
        for (size, count) in sizes.iter().zip(count_boxes(&segment, &sizes)) {
            assert!((count - 100.0 / size - 1.0).abs() < 0.1, "{size} {count}");
        }
    }
}
