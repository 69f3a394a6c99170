//! What is measured on a cluster, and how two samples of such measurements are compared.

/// Mean of the centres.
pub(crate) fn centroid(positions: &[[f64; 3]]) -> [f64; 3] {
    let n = positions.len() as f64;
    [0, 1, 2].map(|axis| positions.iter().map(|p| p[axis]).sum::<f64>() / n)
}

fn distance_squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

/// Root mean square distance of the centres from their centroid.
pub(crate) fn radius_of_gyration(positions: &[[f64; 3]]) -> f64 {
    let centre = centroid(positions);
    let sum: f64 = positions.iter().map(|&p| distance_squared(p, centre)).sum();
    (sum / positions.len() as f64).sqrt()
}

/// R_e: distance from the centroid to the farthest centre.
pub(crate) fn effective_radius(positions: &[[f64; 3]]) -> f64 {
    let centre = centroid(positions);
    let far = positions.iter().map(|&p| distance_squared(p, centre));
    far.fold(0.0, f64::max).sqrt()
}

/// Number of centres within each of `radii` of the seed (the first centre), itself included; through space.
pub(crate) fn mass_radius(positions: &[[f64; 3]], radii: &[f64]) -> Vec<f64> {
    let squares: Vec<f64> = positions
        .iter()
        .map(|&p| distance_squared(p, positions[0]))
        .collect();
    let mass = |radius: &f64| squares.iter().filter(|&&s| s <= radius * radius).count() as f64;
    radii.iter().map(mass).collect()
}

/// Mean number of elements that an element touches: centres at most 2r(1 + `tolerance`) apart. O(n²).
pub(crate) fn mean_contacts(positions: &[[f64; 3]], radius: f64, tolerance: f64) -> f64 {
    let limit = (2.0 * radius * (1.0 + tolerance)).powi(2);
    let touching = |(i, &p): (usize, &[f64; 3])| {
        positions[..i]
            .iter()
            .filter(|&&q| distance_squared(p, q) <= limit)
            .count()
    };
    let pairs: usize = positions.iter().enumerate().map(touching).sum();
    2.0 * pairs as f64 / positions.len() as f64
}

/// Smallest distance between two centres. O(n²).
pub(crate) fn smallest_distance(positions: &[[f64; 3]]) -> f64 {
    let nearest = |(i, &p): (usize, &[f64; 3])| {
        let squares = positions[..i].iter().map(|&q| distance_squared(p, q));
        squares.fold(f64::INFINITY, f64::min)
    };
    let squares = positions.iter().enumerate().map(nearest);
    squares.fold(f64::INFINITY, f64::min).sqrt()
}

/// Radius-of-gyration dimension of one cluster.
///
/// Rule: prefixes of N/32, N/32·2^(1/4), … N elements; least squares of ln R_g on ln N over them, all of equal weight;
/// D is the inverse of the slope (R_g ∝ N^(1/D), and it is R_g that fluctuates).
pub(crate) fn gyration_dimension(positions: &[[f64; 3]]) -> f64 {
    let total = positions.len() as f64;
    let points = (0..=20).map(|k| {
        let count = (total / 32.0 * 2.0_f64.powf(f64::from(k) / 4.0)).round() as usize;
        let prefix = &positions[..count.min(positions.len())];
        ((prefix.len() as f64).ln(), radius_of_gyration(prefix).ln())
    });
    1.0 / slope(&points.collect::<Vec<_>>())
}

/// Slope of the least-squares line through (x, y).
pub(crate) fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let x = points.iter().map(|p| p.0).sum::<f64>() / n;
    let y = points.iter().map(|p| p.1).sum::<f64>() / n;
    let product: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let square: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    product / square
}

/// Sample mean and unbiased variance.
pub(crate) fn mean_variance(sample: &[f64]) -> (f64, f64) {
    let n = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / n;
    let square: f64 = sample.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, square / (n - 1.0))
}

/// Welch's comparison: (mean a − mean b) / mean b and its standard error, both relative to the mean of `b`.
///
/// Divide the first by the second for Welch's t.
pub(crate) fn compare(a: &[f64], b: &[f64]) -> (f64, f64) {
    let ((mean_a, var_a), (mean_b, var_b)) = (mean_variance(a), mean_variance(b));
    let error = (var_a / a.len() as f64 + var_b / b.len() as f64).sqrt();
    ((mean_a - mean_b) / mean_b, error / mean_b.abs())
}
