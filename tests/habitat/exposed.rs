//! What is inside other pieces of a mesh is kept out by a mask.

use thallus::cluster::Element;

use super::*;

/// Cubes about these places, of side 1.
fn cubes(middles: &[DVec3]) -> Substrate {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (middle, face) in middles
        .iter()
        .flat_map(|middle| (0..6).map(move |face| (middle, face)))
    {
        let first = positions.len() as u32;
        let height = if face < 3 { 0.5 } else { -0.5 };
        for (i, j) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            let mut p = [i, j, height];
            p.rotate_left(face % 3);
            positions.push((*middle + DVec3::from(p)).to_array());
        }
        let ways = if face < 3 {
            [[0, 1, 2], [0, 2, 3]]
        } else {
            [[0, 2, 1], [0, 3, 2]]
        };
        triangles.extend(ways.map(|triangle| triangle.map(|k| first + k)));
    }
    common::substrate(positions, triangles)
}

/// How deep a place is in a cube of side 1.
fn depth(place: DVec3, middle: DVec3) -> f64 {
    0.5 - (place - middle).abs().max_element()
}

#[test]
fn what_is_inside_other_pieces_is_not_exposed() {
    const RADIUS: f64 = 0.01;
    // Two that go through each other, and one that stands on the first.
    let middles = [
        DVec3::ZERO,
        DVec3::new(0.6, 0.1, 0.2),
        DVec3::new(-0.3, 1.0, -0.2),
    ];
    let buried = |mask: bool| {
        let substrate = cubes(&middles);
        let mask = mask.then(|| Mask::exposed(&substrate));
        let hash = { mask.iter() }
            .flat_map(|mask| mask.hashes())
            .map(str::to_owned)
            .collect();
        let id = mask.as_ref().map(|_| MaskId {
            layers: vec!["exposed".to_owned()],
            hashes: hash,
        });
        let substrate = substrate.with_mask(mask);
        let recipe = Recipe {
            at: vec![
                SeedPlace::Point([-0.1, 0.2, 0.5]),
                SeedPlace::Point([0.9, 0.2, 0.7]),
            ],
            mask: id,
            ..common::recipe(RADIUS, 6000)
        };
        let growth = grow(&substrate, &recipe, &Execution::default(), &mut ()).unwrap();
        let place = |e: &Element| {
            let up = RADIUS * substrate.normal(e.at.triangle);
            substrate
                .units()
                .to_file(e.position + substrate.units().length_to_local(1.0) * up)
        };
        let places = growth.cluster.elements().iter().map(place);
        // In another cube than that which it is on.
        let is_in = |p: &DVec3| middles.iter().any(|m| depth(*p, *m) > 1e-6);
        (growth.cluster.len(), places.filter(is_in).count())
    };
    let (all, hidden) = buried(false);
    assert!(hidden > all / 20, "{hidden} of {all}");
    let (all, hidden) = buried(true);
    assert!(all > 5000 && hidden == 0, "{hidden} of {all}");
}

#[test]
fn all_of_one_piece_is_exposed() {
    assert!(Mask::exposed(&cubes(&[DVec3::ZERO])).is_white());
    assert!(!Mask::exposed(&cubes(&[DVec3::ZERO, 3.0 * DVec3::X])).is_white());
}
