//! Pearson's chi-square test.
#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements, for whoever asks to see them
#![allow(dead_code, reason = "each test crate uses its own part of this")]

/// Chance of a false alarm in each test. Seeds are fixed, so a test that passes always passes;
/// this is the chance that a right program was refused when the seed was chosen.
pub(crate) const FALSE_ALARM: f64 = 1e-3;

/// Regularised upper incomplete gamma function Q(a, x): by its series, or by its continued
/// fraction (modified Lentz) where that converges faster (Press et al., *Numerical Recipes*, 6.2).
pub(crate) fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let scale = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - scale * sum;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..10_000 {
        let n = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (n * d + b);
        c = b + n / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    scale * h
}

/// Chance of counts at least this far from shares in proportion to `weights`; bins that expect
/// fewer than 5 are put together.
pub(crate) fn p_value(counts: &[u64], weights: &[f64]) -> f64 {
    assert_eq!(counts.len(), weights.len());
    let total = counts.iter().sum::<u64>() as f64;
    let sum: f64 = weights.iter().sum();
    let (mut statistic, mut bins, mut rest) = (0.0, 0, (0.0, 0.0));
    let mut add = |(count, expected): (f64, f64)| {
        statistic += (count - expected) * (count - expected) / expected;
        bins += 1;
    };
    for (&count, weight) in counts.iter().zip(weights) {
        let bin = (count as f64, total * weight / sum);
        if bin.1 >= 5.0 {
            add(bin);
        } else {
            rest = (rest.0 + bin.0, rest.1 + bin.1);
        }
    }
    if rest.1 > 0.0 {
        add(rest);
    } else if rest.0 > 0.0 {
        return 0.0;
    }
    gamma_q(0.5 * f64::from(bins - 1), 0.5 * statistic)
}

/// # Panics
/// When the counts do not fit.
pub(crate) fn assert_fits(what: &str, counts: &[u64], weights: &[f64]) {
    let p = p_value(counts, weights);
    println!("{what}: p = {p:.4}");
    assert!(
        p > FALSE_ALARM,
        "{what}: p = {p:e}\n{counts:?}\n{weights:?}"
    );
}

/// Which of n equal bins a share in [0, 1] falls in.
pub(crate) fn bin(share: f64, n: usize) -> usize {
    ((share * n as f64) as usize).min(n - 1)
}

/// Chance of two tables of counts that differ this much, where both follow one law.
pub(crate) fn homogeneity(a: &[u64], b: &[u64]) -> f64 {
    let (sum, free) = apart(a, b);
    gamma_q(0.5 * free, 0.5 * sum)
}

/// How far two tables of counts are from each other as chi-square, and its degrees of freedom; cells with fewer
/// than 20 in both are left out.
pub(crate) fn apart(a: &[u64], b: &[u64]) -> (f64, f64) {
    let [na, nb] = [a, b].map(|t| t.iter().sum::<u64>() as f64);
    let (mut sum, mut cells) = (0.0, 0);
    for (&a, &b) in a.iter().zip(b).filter(|&(a, b)| a + b >= 20) {
        let d = a as f64 * (nb / na).sqrt() - b as f64 * (na / nb).sqrt();
        sum += d * d / (a + b) as f64;
        cells += 1;
    }
    assert!(cells > 1, "{cells} cells");
    (sum, f64::from(cells - 1))
}
