//! Surfaces that are awkward: pinched, long, of one side, of many sheets.

use super::*;

/// A closed cylinder or, with a top of radius 0, a cone, of so many sides about the y axis: a fan at each end.
fn pillar(sides: usize, height: f64, radii: [f64; 2]) -> Substrate {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let rim = |i: usize, end: usize| {
        let (sin, cos) = (std::f64::consts::TAU * (i % sides) as f64 / sides as f64).sin_cos();
        [radii[end] * cos, height * end as f64, radii[end] * sin]
    };
    for i in 0..sides {
        let n = positions.len() as u32;
        positions.extend([rim(i, 0), rim(i + 1, 0), rim(i, 1), rim(i + 1, 1)]);
        positions.extend([[0.0; 3], [0.0, height, 0.0]]);
        triangles.push([n, n + 4, n + 1]);
        triangles.push([n, n + 2, n + 1]);
        if radii[1] > 0.0 {
            triangles.extend([[n + 1, n + 2, n + 3], [n + 2, n + 5, n + 3]]);
        }
    }
    substrate(positions, triangles)
}

/// Two sheets of long triangles, a wide one and a narrow one, that share an edge and go round into one another at both
/// its ends: of the edge's four triangles two pairs belong together.
fn pinched(wide_is_above: bool, first: usize) -> Substrate {
    let up = if wide_is_above { 1.0 } else { -1.0 };
    let positions = [
        [0.0, 0.0, 0.0],
        [10.0, 0.0, 0.0],
        [9.9, 0.01 * up, 0.5],
        [9.9, 0.01 * up, -0.5],
        [9.9, -0.08 * up, 0.1],
        [9.9, -0.08 * up, -0.1],
    ];
    let mut triangles = vec![
        [0, 1, 2],
        [1, 0, 3],
        [1, 0, 4],
        [0, 1, 5],
        [0, 2, 4],
        [0, 5, 3],
        [1, 4, 2],
        [1, 3, 5],
    ];
    triangles.rotate_left(first);
    substrate(positions.to_vec(), triangles)
}

#[test]
fn sheets_that_share_a_long_edge_are_cut_each_by_itself() {
    let all = [true, false].map(|above| [0, 1, 2, 3].map(|first| pinched(above, first)));
    for surface in all.iter().flatten() {
        let radius = 0.05;
        let places: Vec<DVec3> = (1..190)
            .map(|i| DVec3::new(0.05 * f64::from(i), 0.0, 0.0))
            .collect();
        let mesh = skinned(
            surface,
            &placed(surface, radius, &places),
            &Shape::default(),
        );
        let longest = mesh
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|ends| {
                let [p, q] = ends.map(|v| DVec3::from(mesh.positions[v as usize]));
                p.distance(q)
            });
        let longest = longest.fold(0.0, f64::max);
        // The wide sheet is cut into pieces of two thirds, and the underside no finer where it need not be.
        assert!(longest < 0.8, "{longest}");
    }
}

/// What is long and thin is cut across, not into slivers: a lichen has about as many triangles there as on a plane, and
/// they are as wide as elsewhere.
#[test]
fn long_triangles_are_cut_across() {
    let on = |surface: &Substrate, radius: f64| {
        let recipe = Recipe {
            at: vec![SeedPlace::Random],
            ..recipe(radius, 1500)
        };
        let growth = grow(surface, &recipe, &Execution::default(), &mut ()).expect("grows");
        let mesh = skinned(surface, &growth.cluster, &Shape::default());
        mesh.triangles.len() as f64 / growth.cluster.len() as f64
    };
    let usual = on(&plane(2.0), 0.005);
    assert!(usual < 12.0, "{usual} on a plane");
    for (name, sides, height, radii) in [
        ("a cylinder", 32, 2.0, [1.0, 1.0]),
        ("a pole", 64, 10.0, [0.5, 0.5]),
        ("a fine pole", 256, 10.0, [0.5, 0.5]),
        ("a cone", 32, 2.0, [1.0, 0.0]),
        ("a wire", 5, 40.0, [0.05, 0.05]),
    ] {
        let surface = pillar(sides, height, radii);
        let each = on(&surface, 0.005);
        assert!(each < 2.2 * usual, "{name}: {each}, {usual} on a plane");
    }
}

/// A strip of quads about the y axis that may close with a half turn, windings at random.
fn band(twisted: bool) -> Substrate {
    let (columns, rows) = (48, 6);
    let at = |i: usize, j: usize| {
        let (i, j) = match (i == columns, twisted) {
            (true, true) => (0, rows - j),
            (true, false) => (0, j),
            _ => (i, j),
        };
        let turn = std::f64::consts::TAU * i as f64 / columns as f64;
        let across = 0.6 * (j as f64 / rows as f64 - 0.5);
        let lean = if twisted { 0.5 * turn } else { 0.0 };
        let out = 1.0 + across * lean.cos();
        [out * turn.cos(), across * lean.sin(), out * turn.sin()]
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..columns {
        for j in 0..rows {
            let first = positions.len() as u32;
            positions.extend([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            let half = [[0, 1, 2], [0, 2, 3]];
            let turned = [[0, 2, 1], [0, 2, 3]];
            let both = if (i * 7 + j * 3) % 5 < 2 {
                turned
            } else {
                half
            };
            triangles.extend(both.map(|t: [u32; 3]| t.map(|k| first + k)));
        }
    }
    substrate(positions, triangles)
}

/// Sheets that share an edge, as the pages of an open book.
fn book() -> Substrate {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for page in 0..5u32 {
        let (sin, cos) = (1.3 * f64::from(page)).sin_cos();
        let first = positions.len() as u32;
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        positions.extend(corners.map(|[x, y]| [cos * x, y, sin * x]));
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    substrate(positions, triangles)
}

#[test]
fn awkward_surfaces_have_sound_skins() {
    // Two cones that touch in their tips: a vertex of two fans.
    let cone = |up: f64| {
        let rim = move |i: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i % 8) / 8.0).sin_cos();
            [cos, up, sin]
        };
        (0..8).flat_map(move |i| [[0.0; 3], rim(i + 1), rim(i)])
    };
    let corners: Vec<[f64; 3]> = cone(0.7).chain(cone(-0.7)).collect();
    let faces = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let cones = substrate(corners, faces.collect());
    let surfaces = [
        ("band", band(false)),
        ("twisted band", band(true)),
        ("book", book()),
        ("cones", cones),
    ];
    for (name, surface) in &surfaces {
        let points = packed(0.02, 2.0, 0.0);
        let spread: Vec<DVec3> = points
            .iter()
            .flat_map(|p| {
                [
                    *p,
                    DVec3::new(p.x, p.z, 0.3 * p.x),
                    DVec3::new(0.0, p.x, p.z),
                ]
            })
            .collect();
        let mesh = skinned(surface, &placed(surface, 0.02, &spread), &Shape::default());
        assert!(mesh.triangles.len() > 1000, "{name}");
    }
}

/// Six sheets that meet in an edge whose lower half only they have in common: two edges of the surface have the same
/// ends.
#[test]
fn where_two_edges_share_their_ends_the_outline_crosses_both() {
    let positions = vec![
        [0.0, 0.0, 0.0],
        [1.0, 1.5, 0.0],
        [0.8855, 0.5, -0.4647],
        [0.0, 0.5, 0.0],
        [-0.9709, 1.0, 0.2393],
        [0.0, 0.25, 0.0],
        [0.25, 0.375, 0.0],
        [0.25, 0.125, 0.0],
        [0.75, 1.625, 0.0],
        [0.75, 1.375, 0.0],
        [0.1507, 0.875, 1.2409],
        [-0.1871, 0.375, 0.1658],
        [-0.1871, 0.125, 0.1658],
        [-0.2427, 0.375, 0.0598],
        [-0.7282, 1.125, 0.1795],
        [-0.7282, 0.875, 0.1795],
        [-0.2427, 0.375, -0.0598],
        [-0.2427, 0.125, -0.0598],
        [0.6641, 0.625, -0.3485],
        [0.6641, 0.375, -0.3485],
    ];
    let triangles = vec![
        [0, 5, 7],
        [5, 3, 6],
        [5, 6, 7],
        [9, 8, 1],
        [0, 5, 12],
        [5, 3, 11],
        [5, 11, 12],
        [0, 5, 10],
        [5, 3, 13],
        [14, 4, 15],
        [0, 5, 17],
        [5, 3, 16],
        [19, 18, 2],
    ];
    let surface = substrate(positions, triangles);
    let cluster = placed(&surface, 0.1094, &[DVec3::new(-0.12, 0.2269, 0.1063)]);
    for resolution in [0.6, 0.7, 0.8, 0.9, 1.0] {
        let shape = Shape {
            resolution,
            ..Shape::default()
        };
        let mesh = skin(&surface, &cluster, &shape, &Paint::default()).expect("a skin");
        mesh.check().expect("sound");
    }
}

/// Pages of a book, at these angles beside each third of the spine, in degrees: two of the pages go on into one another
/// there, and not everywhere the same two.
fn bent_book(angles: &[[f64; 3]]) -> Substrate {
    let mut positions: Vec<[f64; 3]> = (0..4).map(|y| [0.0, f64::from(y), 0.0]).collect();
    let mut triangles = Vec::new();
    for page in angles {
        let outer = positions.len() as u32;
        positions.extend(std::iter::zip(0..3, page).map(|(i, degrees)| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [cos, f64::from(i) + 0.5, sin]
        }));
        for i in 0..3 {
            triangles.push([i, i + 1, outer + i]);
        }
        for i in 1..3 {
            triangles.push([i, outer + i, outer + i - 1]);
        }
    }
    substrate(positions, triangles)
}

fn assert_closed_along(surface: &Substrate, places: &[DVec3], case: &str) {
    let cluster = placed(surface, 0.05, places);
    let mesh = skin(surface, &cluster, &Shape::default(), &Paint::default()).expect("a skin");
    let faults = faults(mesh.positions.len(), &mesh.triangles);
    assert!(faults.is_empty(), "{case}: {faults:?}");
}

/// They change partners along the spine, and none of their sides is open there.
#[test]
fn skins_are_closed_where_four_sheets_meet() {
    let angles: [[f64; 3]; 4] = [
        [0.0; 3],
        [178.0, 174.0, 178.0],
        [184.0, 182.0, 184.0],
        [350.0; 3],
    ];
    let places: Vec<DVec3> = (1..30)
        .map(|i| DVec3::new(0.0, 0.1 * f64::from(i), 0.0))
        .collect();
    assert_closed_along(&bent_book(&angles), &places, "four pages");
}

#[test]
fn skins_are_closed_where_three_sheets_meet() {
    let spine = |i: u32| DVec3::new(0.0, 0.1 * f64::from(i), 0.0);
    let places: Vec<DVec3> = (1..30).map(spine).collect();
    for bits in 0..512u32 {
        let is_bent = |page: usize, i: usize| bits >> (3 * page + i) & 1 == 1;
        let angle = |page: usize, i: usize| 120.0 * page as f64 + 5.0 * f64::from(is_bent(page, i));
        let surface = bent_book(&[0, 1, 2].map(|page| [0, 1, 2].map(|i| angle(page, i))));
        assert_closed_along(&surface, &places, &bits.to_string());
    }
}

/// A plane of side 1 with a sliver along its middle, as wide as this, its third corner so far along, and elements of
/// 0.001 all along it.
fn with_sliver(width: f64, along: f64) -> (Substrate, Cluster) {
    let positions = vec![
        [-0.5, 0.0, -0.5],
        [0.5, 0.0, -0.5],
        [0.5, 0.0, 0.5],
        [-0.5, 0.0, 0.5],
        [-0.5, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [along, 0.0, width],
    ];
    let triangles = vec![
        [0, 5, 1],
        [0, 4, 5],
        [4, 6, 5],
        [4, 3, 6],
        [6, 2, 5],
        [6, 3, 2],
    ];
    with_row(substrate(positions, triangles))
}

/// Elements along the x axis.
fn with_row(surface: Substrate) -> (Substrate, Cluster) {
    let places: Vec<DVec3> = (-225..225)
        .map(|i| DVec3::new(0.002 * f64::from(i), 0.0, 0.0))
        .collect();
    let cluster = placed(&surface, 0.001, &places);
    (surface, cluster)
}

/// Cut into triangles alike, the sliver takes 150,000 of them with its third corner by the middle of its longest side,
/// and 2.4 million farther along.
#[test]
fn an_obtuse_sliver_takes_few_triangles() {
    let made = |(surface, cluster): (Substrate, Cluster)| {
        skinned(&surface, &cluster, &Shape::default())
            .triangles
            .len()
    };
    let whole = made(with_row(plane(1.0)));
    for along in [0.0, 0.2] {
        let cut = made(with_sliver(1e-5, along));
        assert!(cut < 5 * whole, "{along}: {cut}, and {whole} without it");
    }
}

#[test]
fn the_number_of_triangles_along_a_sliver_is_foreseen() {
    for (width, along) in [(1e-2, 0.0), (1e-4, 0.1), (1e-4, 0.5), (1e-6, 0.3)] {
        let (surface, cluster) = with_sliver(width, along);
        let shape = Shape::default();
        let made = skinned(&surface, &cluster, &shape).triangles.len();
        let ratio = expected_triangles(&surface, &cluster, &shape) / made as f64;
        assert!((0.5..2.0).contains(&ratio), "{width}, {along}: {ratio}");
    }
}
