//! Contacts and densities against brute force; sheets on thin plates; overlap after packing.

mod common;

use std::collections::HashMap;

use glam::DVec3;
use thallus::cluster::{Cluster, Element, ElementIndex, SparseIndex};
use thallus::growth::{GrowthModel, Join, Law, Parameters, SeedPlace, Surroundings, WalkerModel};
use thallus::rng::{Purpose, Stream};
use thallus::run::{Execution, Recipe, Stopped, grow};
use thallus::substrate::{Soup, Substrate, SurfacePoint};
use thallus::walk::{Ball, Connectivity, Place, trace};

fn random_point(substrate: &Substrate, stream: &mut Stream) -> SurfacePoint {
    let count = substrate.triangles().len() as f64;
    let (u, v) = (stream.uniform(), stream.uniform());
    let (u, v) = if u + v > 1.0 {
        (1.0 - u, 1.0 - v)
    } else {
        (u, v)
    };
    SurfacePoint {
        triangle: (stream.uniform() * count) as u32,
        u,
        v,
    }
}

/// Distance from a point to a segment, by ternary search: nothing shared with the code.
fn segment_distance(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..200 {
        let (m, n) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
        if p.distance(a.lerp(b, m)) < p.distance(a.lerp(b, n)) {
            high = n
        } else {
            low = m
        }
    }
    p.distance(a.lerp(b, 0.5 * (low + high)))
}

/// Distance from a point to a triangle: its plane where the foot is inside, else its edges.
fn triangle_distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let n = (b - a).cross(c - a).normalize();
    let foot = p - n * n.dot(p - a);
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(x, y)| (*y - *x).cross(foot - *x).dot(n) >= 0.0);
    let edges = [(a, b), (b, c), (c, a)].map(|(x, y)| segment_distance(p, x, y));
    if inside {
        p.distance(foot)
    } else {
        edges.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Meshes to try: ours, and the shared ones of a size that brute force can do.
fn meshes() -> Vec<(String, Substrate)> {
    let mut all = vec![
        ("plane".into(), common::plane(2.0)),
        ("sphere".into(), common::sphere(8)),
        ("rock".into(), common::rock(12)),
        ("coarse slab".into(), common::slab(1, 1.0, 0.01)),
        ("fine slab".into(), common::slab(20, 1.0, 0.01)),
    ];
    for path in common::shared_meshes() {
        let Ok(substrate) = Substrate::load(&path) else {
            continue;
        };
        if substrate.triangles().len() <= 3000 {
            all.push((path.display().to_string(), substrate));
        }
    }
    all
}

#[test]
fn nearby_triangles_equal_brute_force() {
    let mut stream = Stream::new(3, Purpose::Walker, 0);
    for (name, substrate) in meshes() {
        let size = substrate
            .vertices()
            .iter()
            .map(|v| v.length())
            .fold(0.0, f64::max);
        for _ in 0..6 {
            let at = random_point(&substrate, &mut stream);
            let centre = substrate.position(&at) + DVec3::splat(0.01 * size * stream.uniform());
            let radius = size * [0.003, 0.03, 0.3][(stream.uniform() * 3.0) as usize];
            let found = substrate.triangles_within(centre, radius);
            for t in 0..substrate.triangles().len() as u32 {
                let d = triangle_distance(centre, substrate.corners(t));
                let is_listed = found.binary_search(&t).is_ok();
                let sure = (d - radius).abs() > 1e-9 * size;
                assert!(
                    !sure || is_listed == (d < radius),
                    "{name}: triangle {t} at {d}, radius {radius}"
                );
            }
        }
    }
}

/// What a ball joins to a triangle, by adjacency made anew and distances by brute force.
fn joined_by_brute_force(
    substrate: &Substrate,
    from: u32,
    centre: DVec3,
    radius: f64,
) -> Vec<bool> {
    let triangles = substrate.triangles();
    let vertex = |v: u32| substrate.vertices()[v as usize];
    let mut by_vertex: HashMap<u32, Vec<u32>> = HashMap::new();
    for (t, corners) in triangles.iter().enumerate() {
        corners
            .iter()
            .for_each(|&v| by_vertex.entry(v).or_default().push(t as u32));
    }
    let mut reached = vec![false; triangles.len()];
    reached[from as usize] = true;
    let mut queue = vec![from];
    while let Some(t) = queue.pop() {
        let corners = triangles[t as usize];
        let mut next = Vec::new();
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if centre.distance(vertex(a)) <= radius {
                next.extend(&by_vertex[&a]);
            }
            let about: Vec<u32> = by_vertex[&a]
                .iter()
                .filter(|o| by_vertex[&b].contains(o))
                .copied()
                .collect();
            if about.len() == 2 && segment_distance(centre, vertex(a), vertex(b)) <= radius {
                next.extend(about);
            }
        }
        for o in next {
            if !std::mem::replace(&mut reached[o as usize], true) {
                queue.push(o);
            }
        }
    }
    reached
}

#[test]
fn sheets_equal_brute_force() {
    let mut stream = Stream::new(4, Purpose::Walker, 0);
    let mut scratch = Connectivity::new();
    let mut asked = 0;
    for (name, substrate) in meshes() {
        if substrate.report().non_manifold_edges > 0 {
            continue; // walls there have no other side
        }
        let size = substrate
            .vertices()
            .iter()
            .map(|v| v.length())
            .fold(0.0, f64::max);
        for _ in 0..8 {
            let at = random_point(&substrate, &mut stream);
            let radius = size * [0.01, 0.05, 0.2][(stream.uniform() * 3.0) as usize];
            let centre = substrate.position(&at);
            let expected = joined_by_brute_force(&substrate, at.triangle, centre, radius);
            scratch.reach(&substrate, at.triangle, &Ball { centre, radius });
            let mut most = scratch.reached().to_vec();
            most.sort_unstable();
            let truth: Vec<u32> = (0..expected.len() as u32)
                .filter(|&t| expected[t as usize])
                .collect();
            assert_eq!(most, truth, "{name}");
            asked += truth.len();
        }
    }
    assert!(asked > 100);
}

/// Places in a ball, on whatever sheet.
fn places_in(substrate: &Substrate, ball: &Ball, stream: &mut Stream) -> Vec<Place> {
    let near = substrate.triangles_within(ball.centre, ball.radius);
    let one = |_| {
        let triangle = near[(stream.uniform() * near.len() as f64) as usize];
        let at = SurfacePoint {
            triangle,
            ..random_point(substrate, stream)
        };
        (triangle, substrate.position(&at))
    };
    let places = (0..60).map(one);
    let is_inside = |place: &Place| place.1.distance(ball.centre) < ball.radius;
    places.filter(is_inside).collect()
}

#[test]
fn lines_between_places_answer_as_a_search_of_the_ball() {
    let mut stream = Stream::new(6, Purpose::Walker, 0);
    let [mut one, mut two, mut all] = [(); 3].map(|()| Connectivity::new());
    let mut fine = meshes();
    fine.push(("fine rock".into(), common::rock(60)));
    fine.push(("rough rock".into(), common::noisy_rock(60, 0.02)));
    fine.push(("jagged rock".into(), common::noisy_rock(60, 0.1)));
    fine.push(("finer slab".into(), common::slab(60, 1.0, 0.01)));
    fine.push(("thinner slab".into(), common::slab(60, 1.0, 0.003)));
    fine.push(("thicker slab".into(), common::slab(60, 1.0, 0.03)));
    let (mut joined, mut apart) = (0, 0);
    let (mut looked, mut looked_likely, mut held) = (0, 0, 0);
    for (name, substrate) in fine {
        let size = substrate.units().local_diagonal();
        for _ in 0..30 {
            let at = random_point(&substrate, &mut stream);
            let ball = Ball {
                centre: substrate.position(&at),
                radius: size * [0.02, 0.05, 0.15][(stream.uniform() * 3.0) as usize],
            };
            let from = (at.triangle, ball.centre);
            let mut others = places_in(&substrate, &ball, &mut stream);
            all.reach(&substrate, at.triangle, &ball);
            let n = others.iter().filter(|o| all.has_reached(o.0)).count();
            let counted = one.count_joined(&substrate, (from, &mut others), &ball);
            assert_eq!(counted, n, "{name}: {ball:?}");
            for &other in &others {
                let expected = all.has_reached(other.0);
                let found = one.joined(&substrate, [from, other], &ball);
                assert_eq!(found, expected, "{name}: {ball:?}, {other:?}");
                let likely = two.likely_joined(&substrate, [from, other], &ball);
                assert_eq!(likely, expected, "{name}: {ball:?}, {other:?}");
                if expected {
                    looked_likely += two.reached().len();
                    looked += one.reached().len();
                    held += all.reached().len();
                }
            }
            (joined, apart) = (joined + n, apart + others.len() - n);
        }
    }
    assert!(joined > 5_000 && apart > 1_000, "{joined} and {apart}");
    assert!(4 * looked < held, "{looked} of {held} triangles");
    assert!(
        5 * looked_likely < 4 * looked,
        "{looked_likely} instead of {looked}"
    );
}

/// As thin as a fin: places across from each other are near, and the edge between them may be far.
#[test]
fn both_sides_of_a_sharp_fold_are_joined_where_the_ball_reaches_its_edge() {
    let wide = |x: f64| [x, 1.0, 0.5];
    let corners = vec![[0.0; 3], [0.0, 0.0, 1.0], wide(0.1), wide(-0.1)];
    let fold = common::substrate(corners, vec![[0, 1, 2], [1, 0, 3]]);
    let [one, other] = [0, 1].map(|t| fold.triangles()[t]);
    let edge: Vec<u32> = one.into_iter().filter(|v| other.contains(v)).collect();
    let [a, b] = [edge[0], edge[1]].map(|v| fold.vertices()[v as usize]);
    let radius = 0.15 * a.distance(b);
    let (mut stream, mut scratch) = (Stream::new(7, Purpose::Walker, 0), Connectivity::new());
    let mut found = [0, 0];
    while found.iter().sum::<usize>() < 2000 {
        let places = [0, 1].map(|triangle| {
            let at = SurfacePoint {
                triangle,
                ..random_point(&fold, &mut stream)
            };
            (triangle, fold.position(&at))
        });
        let centre = places[0].1.midpoint(places[1].1);
        if centre.distance(places[0].1) < radius {
            let expected = segment_distance(centre, a, b) < radius;
            let joined = scratch.joined(&fold, places, &Ball { centre, radius });
            assert_eq!(joined, expected, "{places:?}");
            found[usize::from(joined)] += 1;
        }
    }
    assert!(found.iter().all(|&n| n > 200), "{found:?}");
}

fn parameters(radius: f64) -> Parameters {
    let recipe = common::recipe(radius, 1);
    Parameters {
        slope: None,
        radius,
        curvature_radius: recipe.curvature_radius,
        bias: recipe.bias,
        gain: recipe.gain,
        min_stick: recipe.min_stick,
        launch: recipe.launch,
        kill: recipe.kill,
        join: recipe.join,
        law: recipe.law,
        steps: recipe.steps,
        boundary: recipe.boundary,
        seed: recipe.seed,
    }
}

/// A cluster of scattered elements, with an index of them.
fn scattered(
    substrate: &Substrate,
    radius: f64,
    points: &[SurfacePoint],
) -> (Cluster, SparseIndex) {
    let mut cluster = Cluster::new(radius);
    let mut index = SparseIndex::new(radius, Some(10.0 * radius), substrate.bounds());
    for &at in points {
        cluster.push(Element::seed(substrate, at));
        index.add(&(&cluster).into());
    }
    (cluster, index)
}

#[test]
fn contacts_and_counts_equal_brute_force() {
    let mut stream = Stream::new(5, Purpose::Walker, 0);
    let mut scratch = Connectivity::new();
    for (name, substrate) in meshes() {
        if substrate.report().non_manifold_edges > 0 {
            continue;
        }
        let parameters = parameters(0.02);
        let points: Vec<SurfacePoint> = (0..300)
            .map(|_| random_point(&substrate, &mut stream))
            .collect();
        let (cluster, index) = scattered(&substrate, parameters.radius, &points);
        let around = Surroundings {
            substrate: &substrate,
            parameters: &parameters,
            elements: (&cluster).into(),
            index: &index,
        };
        for _ in 0..12 {
            let near = &points[(stream.uniform() * 300.0) as usize];
            let at = trace(&substrate, near, stream.in_unit_disc() * 0.06, false).point;
            let p = substrate.position(&at);
            let nearest = nearest_in_contact(&substrate, cluster.elements(), &at, 0.02);
            let found = around.touching(&mut scratch, (at.triangle, p), 0.04);
            assert_eq!(found, nearest, "{name}: contact");
            let reached = joined_by_brute_force(&substrate, at.triangle, p, 0.22);
            let counts =
                |e: &&Element| p.distance(e.position) < 0.2 && reached[e.at.triangle as usize];
            let n = cluster.elements().iter().filter(counts).count();
            assert_eq!(
                around.count(&mut scratch, (at.triangle, p)),
                n,
                "{name}: density"
            );
        }
    }
}

fn nearest_in_contact(
    substrate: &Substrate,
    elements: &[Element],
    at: &SurfacePoint,
    r: f64,
) -> Option<u32> {
    let p = substrate.position(at);
    let same_sheet = |e: &Element| {
        let middle = (p + e.position) * 0.5;
        joined_by_brute_force(substrate, at.triangle, middle, 1.5 * r)[e.at.triangle as usize]
    };
    let touching = |e: &&Element| p.distance(e.position) < 2.0 * r && same_sheet(e);
    let nearer =
        |a: &&Element, b: &&Element| p.distance(a.position).total_cmp(&p.distance(b.position));
    let nearest = elements.iter().filter(touching).min_by(nearer)?;
    elements.iter().position(|e| e == nearest).map(|i| i as u32)
}

/// A plate of side 1 and thickness 0.004 in x and z, with its middle plane at y = 0.
const THICK: f64 = 0.004;
const R: f64 = 0.01;

fn on_slab(substrate: &Substrate, x: f64, y: f64) -> SurfacePoint {
    let units = substrate.units();
    substrate.nearest(units.to_local([x, y, 0.0])).0
}

#[test]
fn faces_of_a_slab_never_touch_but_its_rim_is_crossed() {
    for cells in [1, 2, 40] {
        let slab = common::slab(cells, 1.0, THICK);
        let scale = slab.units().length_to_local(1.0);
        let parameters = parameters(R * scale);
        let mut scratch = Connectivity::new();
        for depth in [0.0, 0.002, 0.005, 0.009, 0.02, 0.1, 0.5] {
            let [front, back] = [THICK, -THICK].map(|y| on_slab(&slab, 0.5 - depth, y));
            let (cluster, index) = scattered(&slab, R * scale, &[back]);
            let around = Surroundings {
                substrate: &slab,
                parameters: &parameters,
                elements: (&cluster).into(),
                index: &index,
            };
            let touches = around.in_contact(&mut scratch, (front.triangle, slab.position(&front)));
            // Round the rim from face to face is 2·depth + thickness; the rule allows 3r.
            assert_eq!(
                touches,
                2.0 * depth < 3.0 * R,
                "{cells} cells a side, {depth} from the rim"
            );
        }
    }
}

#[test]
fn lichen_on_a_slab_comes_round_the_rim() {
    let slab = common::slab(12, 1.0, THICK);
    let mut recipe = common::recipe(R, 3000);
    recipe.at = vec![SeedPlace::Point([0.45, 1.0, 0.0])];
    let growth = grow(&slab, &recipe, &Execution::default(), &mut ()).expect("grows");
    let elements = growth.cluster.elements();
    let file = |e: &Element| slab.units().to_file(e.position);
    let (front, back): (Vec<_>, Vec<_>) = elements.iter().map(file).partition(|p| p.y > 0.0);
    assert!(
        front.len() > 100 && back.len() > 100,
        "{} and {}",
        front.len(),
        back.len()
    );
    let under = |p: &DVec3| back.iter().any(|q| (p.x - q.x).hypot(p.z - q.z) < R);
    assert!(
        front.iter().any(under),
        "no element has one under it: the faces felt one another"
    );
    for e in elements.iter().skip(1) {
        let (p, q) = (file(e), file(&elements[e.parent as usize]));
        let from_rim = 0.5 - p.x.abs().max(p.z.abs()).min(0.5);
        assert!(
            p.y * q.y > 0.0 || from_rim < 3.0 * R,
            "joined through the plate at {p} to {q}, probability {}",
            e.probability
        );
    }
}

/// The way between two places of a plate, half its width from the middle to its rims, over one of them.
fn over_rim([p, q]: [DVec3; 2], thick: f64) -> f64 {
    let over = |axis: usize, side: f64| {
        let (a, b) = (0.5 - side * p[axis], 0.5 - side * q[axis]);
        (a + thick + b).hypot(p[2 - axis] - q[2 - axis])
    };
    let rims = [over(0, 1.0), over(0, -1.0), over(2, 1.0), over(2, -1.0)];
    rims.into_iter().fold(f64::INFINITY, f64::min)
}

/// There an element of the other face becomes one of this all at once.
#[test]
fn elements_do_not_overlap_round_the_rim_of_a_thin_plate() {
    const THIN: f64 = 0.001;
    const WIDE: f64 = 0.0141;
    let plate = common::slab(1, 1.0, THIN);
    let mut round = 0;
    for (law, join) in [
        (Law::Brownian, Join::Pack),
        (Law::Brownian, Join::Touch),
        (Law::Thesis, Join::Pack),
    ] {
        for seed in 1..60 {
            let mut recipe = common::recipe(WIDE, 60);
            (recipe.law, recipe.join, recipe.seed) = (law, join, seed);
            recipe.at = vec![SeedPlace::Point([0.0, 1.0, 0.485])];
            let places = places_of(&plate, &recipe);
            for (i, p) in places.iter().enumerate() {
                for q in places[..i].iter().filter(|q| q.y * p.y < 0.0) {
                    let way = over_rim([*p, *q], THIN);
                    round += usize::from(way < 8.0 * WIDE);
                    assert!(
                        way >= 2.0 * WIDE * (1.0 - 1e-6),
                        "{law:?} {join:?} seed {seed}: {p} and {q}, {} r",
                        way / WIDE
                    );
                }
            }
        }
    }
    assert!(round > 1000, "{round} pairs near each other round a rim");
}

/// Where elements of a lichen are, in the file's units. Each but the first is at contact distance from its parent,
/// through space, on whatever face that is.
fn places_of(substrate: &Substrate, recipe: &Recipe) -> Vec<DVec3> {
    let growth = grow(substrate, recipe, &Execution::default(), &mut ()).expect("grows");
    let (elements, contact) = (growth.cluster.elements(), 2.0 * growth.cluster.radius());
    for e in &elements[1..] {
        let parent = &elements[e.parent as usize];
        let apart = e.position.distance(parent.position) / contact;
        assert!((apart - 1.0).abs() < 1e-6, "{recipe:?}: {apart} of contact");
    }
    let file = |e: &Element| substrate.units().to_file(e.position);
    elements.iter().map(file).collect()
}

/// Two squares that meet at this angle in a ridge along z, through the origin.
fn ridge(angle: f64) -> Substrate {
    let (x, y) = (0.5 * angle).sin_cos();
    let at = |x: f64, z: f64| [x, if x == 0.0 { 0.0 } else { -y }, z];
    let ends = [-1.0, 1.0].map(|z| [at(0.0, z), at(x, z), at(-x, z)]);
    let soup = Soup {
        positions: ends.concat(),
        triangles: vec![[0, 1, 4], [0, 4, 3], [0, 3, 5], [0, 5, 2]],
        notes: Vec::new(),
    };
    Substrate::from_soup(soup).expect("a ridge")
}

/// There an element of the other face, nearer than contact, becomes one of this while a walker touches another.
#[test]
fn elements_do_not_overlap_over_a_ridge() {
    const RADIUS: f64 = 0.015;
    let mut over = 0;
    for (angle, seed) in [50.0f64, 60.0, 65.0]
        .map(|a| (1..9).map(move |seed| (a, seed)))
        .into_iter()
        .flatten()
    {
        let ridge = ridge(angle.to_radians());
        for join in [Join::Pack, Join::Touch] {
            let mut recipe = common::recipe(RADIUS, 2000);
            (recipe.join, recipe.seed) = (join, seed);
            recipe.at = vec![SeedPlace::Point([0.0, 0.0, 0.0])];
            let places = places_of(&ridge, &recipe);
            for (i, p) in places.iter().enumerate() {
                for q in places[..i].iter().filter(|q| q.distance(*p) < 3.0 * RADIUS) {
                    let middle = p.midpoint(*q);
                    let is_over = p.x * q.x < 0.0;
                    over += usize::from(is_over);
                    // On one sheet: joined within 1.5 r about the middle between them.
                    let is_joined = middle.x.hypot(middle.y) < 1.5 * RADIUS * (1.0 - 1e-6);
                    let apart = p.distance(*q) / RADIUS;
                    assert!(
                        apart >= 2.0 * (1.0 - 1e-6) || is_over && !is_joined,
                        "{angle} degrees, {join:?}, seed {seed}: {p} and {q}, {apart} r"
                    );
                }
            }
        }
    }
    assert!(over > 1000, "{over} pairs near each other over a ridge");
}

/// Two faces of a disc that is as thin as a leaf and as wide as may be without a second element on one of them.
#[test]
fn a_face_on_which_nothing_can_touch_the_other_is_grown_on_all_the_same() {
    const RIM: u32 = 48;
    let on_rim = |i: u32| {
        let (z, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(RIM)).sin_cos();
        [x, 0.0, z]
    };
    let faces = [[0.0, 1e-3, 0.0], [0.0, -1e-3, 0.0]];
    let wedge = |i: u32| {
        let (here, next) = (2 + i, 2 + (i + 1) % RIM);
        [[0, next, here], [1, here, next]]
    };
    let soup = Soup {
        positions: faces.into_iter().chain((0..RIM).map(on_rim)).collect(),
        triangles: (0..RIM).flat_map(wedge).collect(),
        notes: Vec::new(),
    };
    let leaf = Substrate::from_soup(soup).expect("a leaf");
    for (law, join) in [(Law::Thesis, Join::Pack), (Law::Brownian, Join::Touch)] {
        let mut recipe = common::recipe(1.0 / 1.75, 20);
        (recipe.law, recipe.join) = (law, join);
        recipe.at = vec![SeedPlace::Point([0.0, 1.0, 0.0])];
        let growth = grow(&leaf, &recipe, &Execution::default(), &mut ()).expect("grows");
        assert_eq!(growth.stopped, Stopped::Full);
        let sides = growth.cluster.elements().iter().map(|e| e.position.y > 0.0);
        assert_eq!(sides.collect::<Vec<_>>(), [true, false], "{law:?}");
    }
}

#[test]
fn packing_leaves_no_overlap() {
    let meshes = [
        common::plane(2.0),
        common::sphere(24),
        common::rock(24),
        common::rock(60),
    ];
    let both = |law| meshes.iter().map(move |mesh| (law, mesh));
    let cases = both(Law::Thesis).chain(both(Law::Brownian));
    for (i, (law, substrate)) in cases.enumerate() {
        let mut recipe = common::recipe(substrate.units().diagonal() / 400.0, 4000);
        (recipe.bias, recipe.law) = (0.3, law);
        let growth = grow(substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
        let elements = growth.cluster.elements();
        let least = 2.0 * growth.cluster.radius() * (1.0 - 1e-6);
        for (j, a) in elements.iter().enumerate() {
            for b in &elements[..j] {
                assert!(
                    a.position.distance(b.position) >= least,
                    "mesh {i}: {a:?} {b:?}"
                );
            }
        }
        assert!(
            growth.counts.packed > 3800,
            "mesh {i}: only {} packed",
            growth.counts.packed
        );
        assert_touches_two(elements, growth.cluster.radius());
    }
}

/// All but a few packed elements are at contact distance from two others born before them.
fn assert_touches_two(elements: &[Element], r: f64) {
    let touches = |i: usize| {
        let near =
            |e: &&Element| e.position.distance(elements[i].position) < 2.0 * r * (1.0 + 1e-6);
        elements[..i].iter().filter(near).count()
    };
    let twice = (2..elements.len()).filter(|&i| touches(i) >= 2).count();
    assert!(
        twice + 200 > elements.len(),
        "{twice} of {}",
        elements.len()
    );
    assert!((1..elements.len()).all(|i| touches(i) >= 1));
}

#[test]
fn touching_elements_rest_at_contact_distance_from_their_parent() {
    let substrate = common::rock(24);
    let mut recipe = common::recipe(substrate.auto_radius(), 3000);
    recipe.join = Join::Touch;
    for law in [Law::Thesis, Law::Brownian] {
        recipe.law = law;
        let growth = grow(&substrate, &recipe, &Execution::default(), &mut ()).expect("grows");
        let elements = growth.cluster.elements();
        for e in &elements[1..] {
            let d = e.position.distance(elements[e.parent as usize].position);
            assert!(
                (d / growth.cluster.radius() - 2.0).abs() < 1e-9,
                "{law:?}: {d}"
            );
        }
    }
}

#[test]
fn a_model_told_of_the_same_births_goes_on_the_same() {
    let substrate = common::rock(24);
    let parameters = parameters(0.002);
    let grown = |stop: usize| {
        let mut model = WalkerModel::new(&substrate, parameters.clone());
        let mut cluster = Cluster::new(parameters.radius);
        let at = SurfacePoint::centroid(0);
        cluster.push(Element::seed(&substrate, at));
        model.born(&cluster);
        while cluster.len() < stop {
            let next = model.next(&cluster, &|| false).expect("free surface");
            cluster.push(next);
            model.born(&cluster);
        }
        cluster.elements().to_vec()
    };
    assert_eq!(grown(600)[..300], grown(300)[..]);
}
