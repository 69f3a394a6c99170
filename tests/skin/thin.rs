//! Skins of few triangles on the substrate.

use super::*;
use thallus::skin::lift;

/// How far the middle of a triangle of the upper side lies beneath a convex substrate at most, in the file's units.
fn deepest(mesh: &TriMesh, substrate: &Substrate) -> f64 {
    let units = substrate.units();
    let depth = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| DVec3::from(mesh.positions[v as usize]));
        let middle = units.to_local(((a + b + c) / 3.0).to_array());
        let (at, _) = substrate.nearest(middle);
        let out = substrate.normal(at.triangle);
        match (b - a).cross(c - a).dot(out) > 0.0 {
            true => (substrate.position(&at) - middle).dot(out),
            false => f64::NEG_INFINITY,
        }
    };
    let depths = mesh.triangles.iter().map(depth);
    units.length_to_file(depths.fold(f64::NEG_INFINITY, f64::max))
}

/// On a round stone the middles of wide triangles lay beneath it, and the stone showed.
#[test]
fn wide_triangles_of_a_decimated_skin_are_lifted_out_of_the_substrate() {
    let (surface, r) = (sphere(24), 0.01);
    let cluster = grown(&surface, r, 4000);
    let shape = Shape {
        thickness: 0.5,
        resolution: 4.0,
        falloff: 3.0,
        ..Shape::default()
    };
    let mesh = skinned(&surface, &cluster, &shape);
    let mut fewer = decimate(&mesh, mesh.triangles.len() / 20).unwrap();
    let before = fewer.clone();
    lift(&mut fewer, &surface, cluster.radius());
    let [sunk, lifted] = [&before, &fewer].map(|mesh| deepest(mesh, &surface) / r);
    assert!(sunk > 0.2, "{sunk}: there is nothing to lift");
    assert!(lifted < 0.0, "{sunk}, {lifted}");
    assert_eq!(fewer.triangles, before.triangles);
    fewer.check().expect("sound");
    let share = turned_away(&fewer);
    assert!(share <= 0.02, "{share} of the normals look away");
    let moved = |(a, b): (&[f64; 3], &[f64; 3])| DVec3::from(*a).distance(DVec3::from(*b)) / r;
    let farthest = fewer.positions.iter().zip(&before.positions).map(moved);
    let farthest = farthest.fold(0.0, f64::max);
    assert!(farthest < 10.0, "lifted by {farthest} radii");
}
