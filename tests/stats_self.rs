//! The statistics that other tests rely on, against known values.

#[path = "common/stats.rs"]
mod common_stats;
#[path = "reference/stats.rs"]
#[allow(dead_code, reason = "the cluster measures are used by other tests")]
mod stats;

use common_stats::{chi_square, gamma_q};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use stats::{compare, gyration_dimension, mass_radius, mean_contacts, radius_of_gyration, slope};

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1e-3), "{a} is not {b}");
}

#[test]
fn incomplete_gamma_has_its_closed_forms() {
    for x in [1e-9_f64, 0.1, 0.9, 1.0, 2.5, 10.0, 80.0] {
        close(gamma_q(1.0, x), (-x).exp());
        close(gamma_q(3.0, x), (-x).exp() * (1.0 + x + x * x / 2.0));
        close(gamma_q(0.5, x), libm::erfc(x.sqrt()));
    }
    assert_eq!(gamma_q(2.5, 0.0), 1.0);
}

#[test]
fn chi_square_quantiles_are_the_tables() {
    let tables = [
        (1.0, 3.841_458_820_694_124, 0.05),
        (10.0, 18.307_038_053_275_146, 0.05),
        (5.0, 15.086_272_469_388_99, 0.01),
        (100.0, 124.342_113_404_004_1, 0.05),
    ];
    for (freedom, quantile, p) in tables {
        assert!((gamma_q(freedom / 2.0, quantile / 2.0) - p).abs() < 1e-9);
    }
}

#[test]
fn chi_square_of_counts() {
    // Mendel's peas: 315, 108, 101, 32 against 9 : 3 : 3 : 1.
    let peas = chi_square(&[315, 108, 101, 32], &[9.0, 3.0, 3.0, 1.0]);
    assert!((peas.statistic - 0.470_024).abs() < 1e-6);
    assert_eq!(peas.freedom, 3);
    assert!((peas.p - 0.925_426).abs() < 1e-6);
    assert!(chi_square(&[600, 400], &[1.0, 1.0]).p < 1e-9);
}

#[test]
fn p_values_of_a_fair_sampler_are_uniform() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut tenths = [0; 10];
    for _ in 0..2000 {
        let mut bins = [0; 8];
        (0..800).for_each(|_| bins[rng.random_range(0..8)] += 1);
        let p = chi_square(&bins, &[1.0; 8]).p;
        tenths[(p * 10.0).min(9.0) as usize] += 1;
    }
    let fit = chi_square(&tenths, &[1.0; 10]);
    assert!(fit.p > 1e-4, "{tenths:?} {fit:?}");
}

#[test]
#[should_panic(expected = "merge bins")]
fn thin_bins_are_refused() {
    chi_square(&[1, 3], &[1.0, 1.0]);
}

#[test]
fn welch_by_hand() {
    // Means 2 and 4, variances 1 and 4 of three each: difference −1/2, error √(1/3 + 4/3)/4.
    let (difference, error) = compare(&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0]);
    close(difference, -0.5);
    close(error, (5.0_f64 / 3.0).sqrt() / 4.0);
}

#[test]
fn lines_have_their_slope() {
    let points: Vec<(f64, f64)> = (0..9)
        .map(|x| (f64::from(x), 3.0 - 0.25 * f64::from(x)))
        .collect();
    close(slope(&points), -0.25);
}

#[test]
fn lines_and_discs_have_their_dimension() {
    let line: Vec<[f64; 3]> = (0..20_000).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    assert!((gyration_dimension(&line) - 1.0).abs() < 1e-3);
    // Sunflower: the i-th point at radius √i is uniform on a disc in every prefix.
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let point = |i: i32| {
        let (radius, angle) = (f64::from(i).sqrt(), golden * f64::from(i));
        [radius * angle.cos(), radius * angle.sin(), 7.0]
    };
    let disc: Vec<[f64; 3]> = (0..20_000).map(point).collect();
    assert!((gyration_dimension(&disc) - 2.0).abs() < 1e-2);
    assert!((radius_of_gyration(&disc) - 100.0).abs() < 0.1);
    assert!((stats::effective_radius(&disc) - 20_000.0_f64.sqrt()).abs() < 0.5);
}

#[test]
fn masses_and_contacts_of_a_row() {
    let row: Vec<[f64; 3]> = (0..10).map(|i| [2.0 * f64::from(i), 0.0, 0.0]).collect();
    assert_eq!(
        mass_radius(&row, &[0.0, 1.9, 2.0, 100.0]),
        [1.0, 1.0, 2.0, 10.0]
    );
    close(mean_contacts(&row, 1.0, 1e-9), 1.8);
    close(stats::smallest_distance(&row), 2.0);
}
