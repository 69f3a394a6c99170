//! Goodness of fit for samplers: Pearson's chi-square with its p-value.
//!
//! Include with `#[path = "common/stats.rs"] mod common_stats;`.
#![allow(
    dead_code,
    reason = "each test crate that includes this module uses another part of it"
)]

/// Outcome of a chi-square test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChiSquare {
    /// Σ (observed − expected)² / expected.
    pub(crate) statistic: f64,
    /// Degrees of freedom: bins − 1.
    pub(crate) freedom: usize,
    /// Probability of a statistic at least this large if the expectation is right.
    pub(crate) p: f64,
}

/// Tests counts against weights (any scale: they are normalised to the number of observations).
///
/// # Panics
/// If the lengths differ, there are fewer than two bins, a weight is not positive, or a bin expects fewer than five:
/// the chi-square law needs them.
pub(crate) fn chi_square(observed: &[u64], weights: &[f64]) -> ChiSquare {
    assert_eq!(observed.len(), weights.len(), "one weight a bin");
    assert!(observed.len() > 1, "one bin tests nothing");
    assert!(weights.iter().all(|w| *w > 0.0), "weights are positive");
    let scale = observed.iter().sum::<u64>() as f64 / weights.iter().sum::<f64>();
    let term = |(&count, &weight): (&u64, &f64)| {
        let expected = weight * scale;
        assert!(
            expected >= 5.0,
            "a bin expects {expected} observations: merge bins"
        );
        (count as f64 - expected).powi(2) / expected
    };
    let statistic = observed.iter().zip(weights).map(term).sum();
    let freedom = observed.len() - 1;
    ChiSquare {
        statistic,
        freedom,
        p: gamma_q(freedom as f64 / 2.0, statistic / 2.0),
    }
}

/// Regularized upper incomplete gamma function Q(a, x) = Γ(a, x) / Γ(a), for a > 0 and x ≥ 0.
pub(crate) fn gamma_q(a: f64, x: f64) -> f64 {
    assert!(a > 0.0 && x >= 0.0, "Q({a}, {x}) is not defined here");
    if x == 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        1.0 - front * lower_series(a, x)
    } else {
        front * upper_fraction(a, x)
    }
}

/// Σ xⁿ / (a (a+1) … (a+n)).
fn lower_series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
    while term > sum * f64::EPSILON {
        n += 1.0;
        term *= x / n;
        sum += term;
    }
    sum
}

/// 1/(x+1−a− 1(1−a)/(x+3−a− 2(2−a)/(x+5−a− …))), by Lentz's method.
fn upper_fraction(a: f64, x: f64) -> f64 {
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::INFINITY, 1.0 / b);
    let mut value = d;
    for n in 1..100_000 {
        let numerator = f64::from(n) * (a - f64::from(n));
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        value *= c * d;
        if (c * d - 1.0).abs() < 2.0 * f64::EPSILON {
            break;
        }
    }
    value
}

/// Smallest p that passes when `tests` independent tests may together fail by chance once in ten thousand runs.
pub(crate) fn threshold(tests: usize) -> f64 {
    1e-4 / tests as f64
}
