//! What is inside other pieces of a mesh is kept out by a mask.

use thallus::cluster::Element;
use thallus::substrate::Part;

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
        let hash = mask
            .iter()
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

/// Two cubes, of which the second stands where a seed on the first would go.
#[test]
fn a_seed_that_is_named_goes_where_it_is_seen() {
    // The first one's top is inside the second.
    let middles = [DVec3::ZERO, DVec3::new(0.0, 0.5, 0.0)];
    let substrate = cubes(&middles);
    let seed = |place: SeedPlace| {
        let recipe = Recipe {
            at: vec![place],
            ..common::recipe(0.002, 10)
        };
        let at = recipe.seeds(&substrate).expect("a place")[0];
        substrate.units().to_file(substrate.position(&at))
    };
    let is_inside = |p: DVec3| middles.iter().any(|m| depth(p, *m) > 1e-6);
    let as_named = SeedPlace::Top.locate(&substrate, 1, 0).expect("a place");
    let as_named = substrate.units().to_file(substrate.position(&as_named));
    assert!(is_inside(as_named), "{as_named}");
    let top = seed(SeedPlace::Top);
    assert!(!is_inside(top) && top.distance(as_named) < 0.75, "{top}");
    // What is asked for by its place is left there.
    let inside = seed(SeedPlace::Point(as_named.to_array()));
    assert!(inside.distance(as_named) < 1e-9, "{inside}");
}

/// A mask that leaves only one piece of several has lichen start on top of that one.
#[test]
fn the_top_and_what_is_highest_are_those_of_the_habitat() {
    let middles = [
        DVec3::ZERO,
        DVec3::new(3.0, 0.0, 0.0),
        DVec3::new(6.0, 0.4, 0.0),
    ];
    let substrate = cubes(&middles);
    let texturing = Texturing {
        parts: [0, 1, 2]
            .map(|k| Part {
                objects: vec![format!("cube{k}")],
                ..Part::default()
            })
            .to_vec(),
        part_of: (0..36).map(|t| Some(t / 12)).collect(),
        ..Texturing::default()
    };
    let only = |name: &str| {
        let selection = format!("object:{name}").parse().expect("a selection");
        let mask = Mask::from_selection(&substrate, &texturing, &selection).expect("a mask");
        let id = MaskId {
            layers: vec![name.to_owned()],
            hashes: mask.hashes().into_iter().map(str::to_owned).collect(),
        };
        (mask, id)
    };
    for (name, middle) in [("cube1", middles[1]), ("cube2", middles[2])] {
        let (mask, id) = only(name);
        let substrate = cubes(&middles).with_mask(Some(mask));
        let seed = |place: SeedPlace| {
            let recipe = Recipe {
                at: vec![place],
                mask: Some(id.clone()),
                ..common::recipe(0.002, 10)
            };
            let at = recipe.seeds(&substrate).expect("a place")[0];
            substrate.units().to_file(substrate.position(&at)) - middle
        };
        let top = seed(SeedPlace::Top);
        assert!(
            top.distance(DVec3::new(0.0, 0.5, 0.0)) < 1e-6,
            "{name}: {top}"
        );
        let highest = seed(SeedPlace::Highest);
        assert!(highest.y > 0.499, "{name}: {highest}");
    }
}
