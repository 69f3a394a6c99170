//! The skin: closed and manifold on every surface, on the substrate and on one face of it, the same
//! on any number of threads.

#[path = "skin/awkward.rs"]
mod awkward;
mod common;
#[path = "skin/thin.rs"]
mod thin;

use common::{plane, recipe, rock, slab, sphere, substrate};
use glam::DVec3;
use thallus::cluster::{Cluster, Element, NO_PARENT};
use thallus::export::TriMesh;
use thallus::growth::SeedPlace;
use thallus::run::{Execution, Recipe, grow};
use thallus::skin::{
    Cover, PALETTE, Paint, Shape, SkinError, decimate, expected_near, expected_triangles, faults,
    skin, skin_in_parts,
};
use thallus::substrate::Substrate;

/// A lichen of this many elements, grown.
fn grown(substrate: &Substrate, radius: f64, elements: u64) -> Cluster {
    let recipe = recipe(radius, elements);
    let growth = grow(substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
    assert_eq!(growth.cluster.len() as u64, elements);
    growth.cluster
}

/// Elements at the places of the surface nearest to points in the file's units.
fn placed(substrate: &Substrate, radius: f64, points: &[DVec3]) -> Cluster {
    let units = substrate.units();
    let mut cluster = Cluster::new(units.length_to_local(radius));
    for (i, point) in points.iter().enumerate() {
        let (at, _) = substrate.nearest(units.to_local(point.to_array()));
        cluster.push(Element {
            at,
            position: substrate.position(&at),
            parent: NO_PARENT,
            colony: i as u32 % 7,
            probability: 1.0,
        });
    }
    cluster
}

/// Places in densest packing, 2r apart, in a square of the plane y = `height`.
fn packed(radius: f64, side: f64, height: f64) -> Vec<DVec3> {
    let rows = (side / (3f64.sqrt() * radius)) as i32;
    let columns = (side / (2.0 * radius)) as i32;
    let place = |i: i32, j: i32| {
        let x = radius * (f64::from(2 * i) + f64::from(j % 2)) - 0.5 * side;
        DVec3::new(x, height, 3f64.sqrt() * radius * f64::from(j) - 0.5 * side)
    };
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    cells.map(|(i, j)| place(i, j)).collect()
}

fn skinned(substrate: &Substrate, cluster: &Cluster, shape: &Shape) -> TriMesh {
    let mesh = skin(substrate, cluster, shape, &Paint::default()).expect("a skin");
    mesh.check().expect("sound");
    let found = faults(mesh.positions.len(), &mesh.triangles);
    assert!(found.is_empty(), "{found:?}");
    for normal in &mesh.normals {
        let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 1e-3, "{normal:?}");
    }
    mesh
}

fn volume(mesh: &TriMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
    let volumes = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(corner);
        a.dot(b.cross(c)) / 6.0
    });
    volumes.sum()
}

#[test]
fn skins_are_closed_and_manifold_on_every_surface() {
    let surfaces = [
        ("plane", plane(2.0), 0.01),
        ("sphere", sphere(16), 0.01),
        ("rock", rock(24), 0.01),
        ("slab", slab(16, 1.0, 0.004), 0.007),
        ("fine rock", rock(120), 0.02),
    ];
    for (name, surface, radius) in &surfaces {
        let cluster = grown(surface, *radius, 1500);
        for (resolution, falloff) in [(1.0, 1.8), (0.6, 1.0), (2.5, 3.0)] {
            let shape = Shape {
                resolution,
                falloff,
                ..Shape::default()
            };
            let mesh = skinned(surface, &cluster, &shape);
            assert!(volume(&mesh) > 0.0, "{name}: inside out");
        }
    }
}

#[test]
fn closed_lichen_on_a_plane_is_as_thick_as_asked_and_lies_on_it() {
    let surface = plane(4.0);
    let r = 0.02;
    for (thickness, falloff) in [(1.5, 1.5), (0.7, 2.0), (3.0, 1.5)] {
        let shape = Shape {
            thickness,
            falloff,
            ..Shape::default()
        };
        let mesh = skinned(&surface, &placed(&surface, r, &packed(r, 2.0, 0.0)), &shape);
        let heights: Vec<f64> = mesh.positions.iter().map(|p| p[1] / r).collect();
        let most = heights.iter().copied().fold(0.0, f64::max);
        let least = heights.iter().copied().fold(0.0, f64::min);
        assert!(most < 1.1 * thickness, "{most} of {thickness}");
        assert!((-0.051..0.0).contains(&least), "{least}");
        for (p, normal) in mesh.positions.iter().zip(&mesh.normals) {
            let inside = p[0].abs() < 0.6 && p[2].abs() < 0.6;
            if inside && p[1] > 0.0 {
                assert!(p[1] / r > 0.85 * thickness, "{p:?}");
                assert!(normal[1] > 0.9, "{normal:?}");
            }
        }
    }
}

#[test]
fn a_lone_element_is_the_dome_of_its_field() {
    let surface = plane(4.0);
    let (r, shape) = (
        0.1,
        Shape {
            resolution: 0.1,
            taper: 0.0,
            ..Shape::default()
        },
    );
    let mesh = skinned(&surface, &placed(&surface, r, &[DVec3::ZERO]), &shape);
    // F = 2^(−d²/C² − s h²) = ½: an ellipsoid of radius C along the surface, and of height √(1/s),
    // s being what makes closed lichen as thick as asked.
    let c = shape.falloff * r;
    let closed = std::f64::consts::PI * shape.falloff * shape.falloff
        / (2.0 * 3f64.sqrt() * std::f64::consts::LN_2);
    let high = shape.thickness * r / (closed / 0.5).log2().sqrt();
    for (p, n) in mesh
        .positions
        .iter()
        .zip(&mesh.normals)
        .filter(|(p, _)| p[1] >= 0.0)
    {
        let (along, up) = ((p[0] * p[0] + p[2] * p[2]).sqrt() / c, p[1] / high);
        assert!((along * along + up * up - 1.0).abs() < 0.02, "{p:?}");
        let exact = DVec3::new(p[0] / (c * c), p[1] / (high * high), p[2] / (c * c)).normalize();
        let normal = DVec3::from(n.map(f64::from));
        assert!(normal.dot(exact) > 0.999, "{p:?} {normal} {exact}");
    }
}

#[test]
fn a_lone_element_at_a_sharp_edge_stands_on_both_faces() {
    // Its centre is 0.3 r from the edge of two faces at a right angle.
    let (surface, radius) = (slab(16, 1.0, 0.4), 0.05);
    let at = DVec3::new(0.5 - 0.3 * radius, 0.2, 0.01);
    let shape = Shape::default();
    let mesh = skinned(&surface, &placed(&surface, radius, &[at]), &shape);
    let height = |axis: usize, face: f64| {
        let heights = mesh.positions.iter().map(|p| p[axis] - face);
        heights.fold(0.0, f64::max) / (shape.thickness * radius)
    };
    let heights = [height(1, 0.2), height(0, 0.5)];
    assert!(heights[0] > 0.25 && heights[1] > 0.1, "{heights:?}");
}

#[test]
fn the_outline_is_the_fields_however_coarse_the_mesh() {
    let surface = plane(4.0);
    let (r, shape) = (0.1, Shape::default());
    let mesh = skinned(&surface, &placed(&surface, r, &[DVec3::ZERO]), &shape);
    let outline = mesh.positions.iter().filter(|p| p[1].abs() < 1e-6 * r);
    let distances: Vec<f64> = outline
        .map(|p| (p[0] * p[0] + p[2] * p[2]).sqrt() / (shape.falloff * r))
        .collect();
    assert!(distances.len() >= 6, "{distances:?}");
    assert!(
        distances.iter().all(|d| (d - 1.0).abs() < 0.05),
        "{distances:?}"
    );
}

#[test]
fn a_lichen_without_a_rim_has_no_margin() {
    let surface = sphere(24);
    let n = 2000;
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let place = |i: i32| {
        let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let out = (1.0 - y * y).sqrt();
        DVec3::new(out * cos, y, out * sin)
    };
    let places: Vec<DVec3> = (0..n).map(place).collect();
    let cluster = placed(&surface, 0.05, &places);
    let map = PALETTE.iter().find(|map| map.name == "rhizocarpon");
    let paint = Paint {
        areoles: None,
        apothecia: None,
        ..Paint::of(map.expect("a map"))
    };
    let margin = paint.prothallus.expect("a dark margin").color;
    let mesh = skin(&surface, &cluster, &Shape::default(), &paint).expect("a skin");
    let dark = |color: &&[u8; 3]| (0..3).all(|k| color[k] < margin[k] + 40);
    assert_eq!(mesh.colors.iter().filter(dark).count(), 0);
    // Where the sphere is cut in half, there is one.
    let half: Vec<DVec3> = places.into_iter().filter(|p| p.y > 0.0).collect();
    let cluster = placed(&surface, 0.05, &half);
    let mesh = skin(&surface, &cluster, &Shape::default(), &paint).expect("a skin");
    assert!(mesh.colors.iter().filter(dark).count() > 100);
}

#[test]
fn a_sphere_is_followed() {
    let surface = sphere(24);
    let r = 0.02;
    let cluster = grown(&surface, r, 4000);
    let mesh = skinned(&surface, &cluster, &Shape::default());
    let units = surface.units();
    for p in &mesh.positions {
        let (_, distance) = surface.nearest(units.to_local(*p));
        let outside = DVec3::from(*p).length();
        let height = units.length_to_file(distance) / r;
        assert!(height < 1.9, "{height} over the surface");
        // The surface's triangles sag below the sphere by up to 1e-3.
        assert!(outside > 1.0 - 2e-3 - 0.051 * r, "sunk to {outside}");
    }
}

/// Areoles and apothecia change where vertices are by little, and nothing else of the mesh; cracks
/// never reach the substrate.
#[test]
fn structure_lies_on_the_skin() {
    let surface = rock(24);
    let r = 0.01;
    let cluster = grown(&surface, r, 3000);
    let shape = Shape {
        resolution: 0.7,
        ..Shape::default()
    };
    for map in PALETTE.iter().filter(|map| map.areoles.is_some()) {
        let paint = Paint::of(map);
        let parts = skin_in_parts(&surface, &cluster, &shape, &paint, &[]).expect("a skin");
        let mesh = skin(&surface, &cluster, &shape, &paint).expect("a skin");
        assert!(faults(mesh.positions.len(), &mesh.triangles).is_empty());
        assert!(parts.cortex.is_some());
        assert_eq!(parts.mesh.triangles.len(), mesh.triangles.len());
        let (mut sunk, mut recoloured) = (0, 0);
        let pairs = mesh.positions.iter().zip(&parts.mesh.positions).enumerate();
        for (v, (p, bare)) in pairs {
            let moved = (DVec3::from(*p) - DVec3::from(*bare)).length();
            assert!(moved < 2.0 * r, "{}: {moved}", map.name);
            let height = |p: [f64; 3]| surface.nearest(surface.units().to_local(p)).1;
            sunk += usize::from(moved > 0.0 && height(*p) < 0.15 * height(*bare));
            recoloured += usize::from(mesh.colors[v] != parts.mesh.colors[v]);
        }
        assert!(sunk * 1000 <= mesh.positions.len(), "{}: {sunk}", map.name);
        assert!(recoloured * 10 > mesh.positions.len(), "{}", map.name);
    }
}

/// For each vertex the lowest number of its connected part.
fn parts(mesh: &TriMesh) -> Vec<usize> {
    let mut part: Vec<usize> = (0..mesh.positions.len()).collect();
    fn root(part: &mut [usize], mut v: usize) -> usize {
        while part[v] != v {
            part[v] = part[part[v]];
            v = part[v];
        }
        v
    }
    for [a, b, c] in &mesh.triangles {
        for (x, y) in [(a, b), (b, c)] {
            let (x, y) = (root(&mut part, *x as usize), root(&mut part, *y as usize));
            part[x.max(y)] = x.min(y);
        }
    }
    (0..part.len()).map(|v| root(&mut part, v)).collect()
}

#[test]
fn the_faces_of_a_thin_plate_have_skins_of_their_own() {
    let (r, thick) = (0.01, 0.004);
    let surface = slab(16, 1.0, thick);
    let front = packed(r, 0.7, 0.5 * thick);
    let back: Vec<DVec3> = front.iter().map(|p| DVec3::new(p.x, -p.y, p.z)).collect();
    let alone = skinned(&surface, &placed(&surface, r, &front), &Shape::default());
    let lowest = alone.positions.iter().map(|p| p[1]).fold(1.0, f64::min);
    assert!(
        lowest > 0.0,
        "front lichen reaches below the middle: {lowest}"
    );
    let both: Vec<DVec3> = front.iter().chain(&back).copied().collect();
    let mesh = skinned(&surface, &placed(&surface, r, &both), &Shape::default());
    assert_eq!(mesh.triangles.len(), 2 * alone.triangles.len());
    let mut sides = std::collections::HashMap::new();
    for (part, p) in parts(&mesh).into_iter().zip(&mesh.positions) {
        let side = *sides.entry(part).or_insert(p[1] > 0.0);
        assert_eq!(side, p[1] > 0.0, "a part has vertices on both faces: {p:?}");
    }
    assert_eq!(sides.len(), 2);
}

#[test]
fn lichen_goes_round_the_rim_of_a_plate() {
    let (r, thick) = (0.01, 0.004);
    let surface = slab(16, 1.0, thick);
    let row = |y: f64| (0..20).map(move |i| DVec3::new(0.5, y, 0.02 * f64::from(i) - 0.2));
    let mesh = skinned(
        &surface,
        &placed(&surface, r, &row(0.0).collect::<Vec<_>>()),
        &Shape::default(),
    );
    let (front, back): (Vec<&[f64; 3]>, Vec<_>) = mesh.positions.iter().partition(|p| p[1] > 0.0);
    assert!(
        front.len() > 50 && back.len() > 50,
        "{} {}",
        front.len(),
        back.len()
    );
}

#[test]
fn threads_change_no_byte() {
    let surface = rock(24);
    let cluster = grown(&surface, 0.01, 4000);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let mesh = skinned(&surface, &cluster, &Shape::default());
            let fewer = decimate(&mesh, mesh.triangles.len() / 4).unwrap();
            let mut bytes = Vec::new();
            for format in thallus::export::MESH_FORMATS {
                format.write(&mesh, 1.0, &mut bytes).expect("written");
                format.write(&fewer, 1.0, &mut bytes).expect("written");
            }
            bytes
        })
    };
    let one = with(1);
    assert!([2, 3, 8].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn attributes_tell_of_the_elements() {
    let surface = plane(4.0);
    let r = 0.02;
    let points = packed(r, 2.0, 0.0);
    let mesh = skinned(&surface, &placed(&surface, r, &points), &Shape::default());
    let column = |name| {
        &mesh
            .attributes
            .iter()
            .find(|a| a.name == name)
            .expect(name)
            .values
    };
    let [birth, density, rim] = ["birth", "density", "rim_distance"].map(column);
    let colony = column("colony");
    let low = points.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
    for (v, p) in mesh.positions.iter().enumerate() {
        assert!((0.0..points.len() as f32).contains(&birth[v]));
        assert!(colony[v].fract() == 0.0 && (0.0..7.0).contains(&colony[v]));
        // How far in a vertex is from the square's sides.
        let from = |k: usize| (p[k] - low[k]).min(high[k] - p[k]);
        let inwards = from(0).min(from(2));
        if inwards > 0.3 {
            assert!((density[v] - 0.907).abs() < 0.1, "{}", density[v]);
        }
        if inwards > 0.1 {
            let ratio = f64::from(rim[v]) / inwards;
            assert!((0.85..1.35).contains(&ratio), "{p:?} {ratio}");
        }
        if inwards < 0.02 {
            assert!(rim[v] < 0.1, "{p:?} {}", rim[v]);
        }
    }
}

#[test]
fn decimating_keeps_to_the_count_and_the_surface() {
    let surface = sphere(24);
    let r = 0.02;
    let cluster = grown(&surface, r, 3000);
    let mesh = skinned(&surface, &cluster, &Shape::default());
    for share in [0.5, 0.2] {
        let goal = (mesh.triangles.len() as f64 * share) as usize;
        let fewer = decimate(&mesh, goal).unwrap();
        assert!(fewer.triangles.len() <= goal + goal / 10);
        assert_whole(&fewer, &mesh, 0.1);
    }
}

/// The share of the corners of triangles whose normal looks to the other side of their triangle.
fn turned_away(mesh: &TriMesh) -> f64 {
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
    let normal = |v: u32| DVec3::from(mesh.normals[v as usize].map(f64::from));
    let away = |&[a, b, c]: &[u32; 3]| {
        let outward = (corner(b) - corner(a)).cross(corner(c) - corner(a));
        let looks_away = |v: &&u32| normal(**v).dot(outward) < 0.0;
        [a, b, c].iter().filter(looks_away).count()
    };
    let turned: usize = mesh.triangles.iter().map(away).sum();
    turned as f64 / (3 * mesh.triangles.len()) as f64
}

/// Normals that look away from their triangles are dark in every renderer: about the holes of an open lichen 1 % to 6 %
/// of them did.
#[test]
fn normals_of_a_decimated_skin_look_outwards() {
    let surface = sphere(24);
    let mesh = skinned(&surface, &grown(&surface, 0.01, 4000), &Shape::default());
    for (parts, most) in [(2, 1e-4), (5, 1e-3), (20, 0.01)] {
        let fewer = decimate(&mesh, mesh.triangles.len() / parts).unwrap();
        let share = turned_away(&fewer);
        assert!(share <= most, "1 of {parts}: {share}");
    }
}

/// So they were on the rims of thin plates, and of stones that come to an edge.
#[test]
fn normals_of_a_skin_look_outwards() {
    let surface = slab(16, 1.0, 0.004);
    let mesh = skinned(&surface, &grown(&surface, 0.007, 3000), &Shape::default());
    let share = turned_away(&mesh);
    assert!(share <= 5e-4, "{share}: it was 0.0013");
}

fn assert_whole(fewer: &TriMesh, mesh: &TriMesh, loss: f64) {
    let count = fewer.triangles.len();
    let faults = faults(fewer.positions.len(), &fewer.triangles);
    assert!(faults.is_empty(), "{count}: {faults:?}");
    fewer.check().expect("sound");
    let ratio = volume(fewer) / volume(mesh);
    assert!((ratio - 1.0).abs() <= loss, "{count}: volume {ratio}");
}

/// What cannot be is not tried at any price: the mesh stays whole, with as few triangles as that takes.
#[test]
fn a_skin_is_decimated_no_farther_than_it_keeps_its_shape() {
    let surface = sphere(24);
    let mesh = skinned(&surface, &grown(&surface, 0.02, 1500), &Shape::default());
    let counts = [10, 300, 1000, 3000].map(|goal| {
        let fewer = decimate(&mesh, goal).unwrap();
        assert_whole(&fewer, &mesh, 0.15);
        fewer.triangles.len()
    });
    assert!(counts[0] < mesh.triangles.len() / 4, "{counts:?}");
    assert!(counts[3] <= 3300, "{counts:?}");
}

#[test]
fn what_cannot_be_is_refused() {
    let surface = plane(2.0);
    let cluster = placed(&surface, 0.01, &[DVec3::ZERO]);
    let with = |shape: Shape| skin(&surface, &cluster, &shape, &Paint::default());
    let base = Shape::default();
    for shape in [
        Shape {
            thickness: 0.0,
            ..base
        },
        Shape {
            thickness: f64::NAN,
            ..base
        },
        Shape { taper: 1.0, ..base },
        Shape {
            falloff: 0.1,
            ..base
        },
        Shape {
            resolution: f64::INFINITY,
            ..base
        },
    ] {
        assert!(
            matches!(with(shape), Err(SkinError::Range { .. })),
            "{shape:?}"
        );
    }
    // Vertices of the two triangles, cut no finer, miss a lone element.
    let aside = placed(&surface, 0.01, &[DVec3::new(0.313, 0.0, 0.177)]);
    let coarse = Shape {
        resolution: 10.0,
        falloff: 0.8,
        ..base
    };
    let missed = skin(&surface, &aside, &coarse, &Paint::default());
    assert_eq!(missed, Err(SkinError::TooCoarse));
    let none = skin(&surface, &Cluster::new(0.01), &base, &Paint::default());
    assert_eq!(none, Err(SkinError::Empty));
}

/// The memory that a skin takes goes by this number: docs/skin.md has the measurements.
#[test]
fn the_number_of_triangles_is_foreseen() {
    let surface = rock(24);
    let cluster = grown(&surface, 0.01, 600);
    for (thickness, falloff, resolution) in [
        (1.5, 1.8, 2.0),
        (1.5, 1.8, 0.5),
        (20.0, 8.0, 0.5),
        (0.1, 0.8, 0.3),
    ] {
        let shape = Shape {
            thickness,
            falloff,
            resolution,
            ..Shape::default()
        };
        let made = skin(&surface, &cluster, &shape, &Paint::default()).unwrap();
        let ratio = expected_triangles(&surface, &cluster, &shape) / made.triangles.len() as f64;
        assert!((0.5..2.0).contains(&ratio), "{shape:?}: {ratio}");
    }
}

/// Of two side by side and one far off, as many as are within the reach; the memory of frames goes by it.
#[test]
fn the_elements_near_a_vertex_are_foreseen() {
    let surface = plane(4.0);
    let places = [[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [1.0, 0.0, 0.0]].map(DVec3::from);
    let cluster = placed(&surface, 0.01, &places);
    let near = expected_near(&cluster, &Shape::default());
    assert!((near - 5.0 / 3.0).abs() < 1e-12, "{near}");
    assert_eq!(expected_near(&Cluster::new(0.01), &Shape::default()), 0.0);
}

/// Whether a mesh is over a place, or under it.
fn is_over(mesh: &TriMesh, [x, z]: [f64; 2]) -> bool {
    mesh.triangles.iter().any(|t| {
        let corners = t.map(|v| mesh.positions[v as usize]);
        let side = |k: usize| {
            let ([ax, _, az], [bx, _, bz]) = (corners[k], corners[(k + 1) % 3]);
            (bx - ax) * (z - az) - (bz - az) * (x - ax)
        };
        let sides = [side(0), side(1), side(2)];
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    })
}

#[test]
fn a_skin_ends_where_another_lies_over_it() {
    let surface = plane(40.0);
    let cluster = grown(&surface, 0.1, 700);
    let moved = Recipe {
        at: vec![SeedPlace::Point([3.0, 0.0, 1.0])],
        ..recipe(0.1, 500)
    };
    let other = grow(&surface, &moved, &Execution::default(), &mut ());
    let other = other.expect("grows").cluster;
    let (shape, paint) = (Shape::default(), Paint::default());
    let cover = Cover::new(&surface, &other, &shape).expect("a cover");
    let over = skin(&surface, &other, &shape, &paint).expect("a skin");
    let cut = |above: &[Cover]| {
        let parts = skin_in_parts(&surface, &cluster, &shape, &paint, above);
        parts.expect("a skin").mesh
    };
    let (whole, hidden) = (cut(&[]), cover.hides(&surface, &cluster));
    let cut = cut(std::slice::from_ref(&cover));
    assert!(faults(cut.positions.len(), &cut.triangles).is_empty());
    // The outline is where the level is 0 but for what a triangle cannot show.
    let about = [
        [0.0, 0.0],
        [0.02, 0.0],
        [-0.02, 0.0],
        [0.0, 0.02],
        [0.0, -0.02],
    ];
    let is_under = |[x, y, z]: &&[f64; 3]| {
        let is_under = |[dx, dz]: &[f64; 2]| is_over(&over, [x + dx, z + dz]);
        // Not of the underside.
        *y > -1e-6 && about.iter().all(is_under)
    };
    let under = [&whole, &cut].map(|mesh| mesh.positions.iter().filter(is_under).count());
    assert!(under[0] > 200 && under[1] == 0, "{under:?}");
    let hidden = hidden.iter().filter(|hidden| **hidden).count();
    assert!((20..600).contains(&hidden), "{hidden}");
    let own = Cover::new(&surface, &cluster, &shape).expect("a cover");
    let none = skin_in_parts(&surface, &cluster, &shape, &paint, &[own]).expect("a skin");
    assert!(none.mesh.triangles.is_empty());
}

/// Walkers cannot cross a gap, so neither does the skin, whatever it is wide.
#[test]
fn a_skin_ends_with_the_piece_that_it_is_on() {
    let corners = |from: f64, to: f64| {
        let at = |x: f64, z: f64| [x, 0.0, z];
        [at(from, -1.0), at(to, -1.0), at(to, 1.0), at(from, 1.0)]
    };
    let positions = [corners(-1.0, 0.0), corners(1e-3, 1.0)].concat();
    let triangles = vec![[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]];
    let surface = substrate(positions, triangles);
    let here = Recipe {
        at: vec![SeedPlace::Point([-0.01, 0.0, 0.0])],
        ..recipe(0.02, 150)
    };
    let cluster = grow(&surface, &here, &Execution::default(), &mut ());
    let cluster = cluster.expect("grows").cluster;
    let made = skin(&surface, &cluster, &Shape::default(), &Paint::default()).expect("a skin");
    let farthest = made.positions.iter().map(|p| p[0]).fold(f64::MIN, f64::max);
    assert!(farthest.abs() < 5e-4, "{farthest}");
}

/// A library written in C++ is given the columns of a mesh: those that are shorter than it says would be read beyond.
#[test]
fn meshes_that_no_file_could_hold_are_not_decimated() {
    let surface = rock(24);
    let mesh = skinned(&surface, &grown(&surface, 0.02, 200), &Shape::default());
    let goal = mesh.triangles.len() / 2;
    type Spoil = fn(&mut TriMesh);
    let spoilt: [Spoil; 5] = [
        |mesh| mesh.normals.clear(),
        |mesh| mesh.colors.truncate(3),
        |mesh| {
            mesh.normals.pop();
        },
        |mesh| mesh.triangles[0][0] = mesh.positions.len() as u32,
        |mesh| mesh.attributes[0].values.truncate(1),
    ];
    for (i, spoil) in spoilt.into_iter().enumerate() {
        let mut mesh = mesh.clone();
        spoil(&mut mesh);
        assert!(decimate(&mesh, goal).is_err(), "{i}");
    }
    assert_eq!(decimate(&TriMesh::default(), goal), Ok(TriMesh::default()));
    assert!(decimate(&mesh, goal).is_ok());
}
