//! Growth where triangles are hardly any: needles, slivers, and a fan of them about one vertex.

mod common;
#[path = "common/shapes.rs"]
mod shapes;

use std::f64::consts::TAU;

use thallus::run::{Execution, Stopped, grow};
use thallus::substrate::Substrate;

/// Grows until all the elements are there: the same ones on two threads, none nearer to another than contact
/// allows where both are on a sheet without folds.
fn check(name: &str, substrate: &Substrate, elements: u64, is_flat: bool) {
    let recipe = common::recipe(0.5 * substrate.auto_radius(), elements);
    let [one, two] = [1, 2].map(|threads| {
        let execution = Execution {
            threads,
            ..Execution::default()
        };
        grow(substrate, &recipe, &execution, &mut ()).expect("grows")
    });
    assert_eq!(one.stopped, Stopped::Elements, "{name}");
    assert_eq!(one.cluster.len() as u64, elements, "{name}");
    assert!(one.cluster.elements() == two.cluster.elements(), "{name}");
    let contact = 2.0 * one.cluster.radius() * (1.0 - 1e-6);
    let places = || one.cluster.elements().iter().map(|e| e.position);
    for (i, p) in places().enumerate().filter(|_| is_flat) {
        let mut before = places().take(i);
        assert!(before.all(|q| p.distance(q) >= contact), "{name}: {i}");
    }
}

#[test]
fn strips_a_millionth_as_wide_as_long_are_grown_over() {
    check("needles", &shapes::needles(), 2000, false);
}

#[test]
fn a_plane_in_slivers_is_grown_over_as_if_it_were_none() {
    let places = |n: i32| {
        let power = |i: i32| f64::from(i.signum()) * 2f64.powi(i.abs() - n);
        (-n..=n).map(power).collect::<Vec<f64>>()
    };
    let slivers = shapes::rectangle(&places(30), &places(8), None);
    check("slivers", &slivers, 2000, true);
}

/// A disc in so many triangles that a walker by its middle is on hundreds of them.
#[test]
fn a_fan_about_one_vertex_is_grown_over() {
    const SIDES: u32 = 5000;
    let rim = (0..SIDES).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
        [cos, sin, 0.0]
    });
    let positions = std::iter::once([0.0; 3]).chain(rim).collect();
    let triangles = (0..SIDES).map(|i| [0, 1 + i, 1 + (i + 1) % SIDES]);
    let fan = common::substrate(positions, triangles.collect());
    check("fan", &fan, 2000, true);
}
