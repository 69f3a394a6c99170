//! Textures: against the skin, across seams, and against closed forms.

mod common;
#[path = "bake/layouts.rs"]
mod layouts;
#[path = "bake/materials.rs"]
mod materials;
#[path = "bake/unwrapped.rs"]
mod unwrapped;

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3, Mat3, Vec3};
use thallus::appearance::Appearance;
use thallus::bake::{
    BakeError, Baked, Baker, Base, Look, MAPS, Map, MapFile, MapFormat, Settings, judge,
};
use thallus::cluster::{Cluster, Element};
use thallus::export::{MapImages, SurfaceLook, TexturedScene};
use thallus::picture::{Finish, Ground};
use thallus::run::{Execution, Recipe, grow};
use thallus::skin::{PALETTE, Paint, Shape, SkinError, skin};
use thallus::substrate::{Material, Soup, Substrate, SurfacePoint, Texturing, load_textured};

use common::recipe;

/// A sphere from a cube, each of whose faces is a chart of its own, turned in its own way, in a
/// layout of three by two squares with gaps.
fn cube_sphere(n: u32) -> String {
    let mut text = String::new();
    let faces = [
        [DVec3::X, DVec3::Y, DVec3::Z],
        [DVec3::Y, DVec3::Z, DVec3::X],
        [DVec3::Z, DVec3::X, DVec3::Y],
    ];
    let faces = faces.into_iter().flat_map(|f| [f, [-f[0], f[2], f[1]]]);
    for (k, [out, right, up]) in faces.enumerate() {
        let middle = DVec2::new(
            (k % 3) as f64 / 3.0 + 1.0 / 6.0,
            (k / 3) as f64 / 2.0 + 0.25,
        );
        let turn = DVec2::from_angle(0.4 * k as f64);
        for i in 0..=n {
            for j in 0..=n {
                let [s, t] = [i, j].map(|i| 2.0 * f64::from(i) / f64::from(n) - 1.0);
                let p = (out + right * s + up * t).normalize();
                let uv = middle + 0.1 * turn.rotate(DVec2::new(s, t));
                writeln!(text, "v {} {} {}\nvt {} {}", p.x, p.y, p.z, uv.x, uv.y).unwrap();
            }
        }
        let at = |i: u32, j: u32| k as u32 * (n + 1) * (n + 1) + i * (n + 1) + j + 1;
        for i in 0..n {
            for j in 0..n {
                let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let [a, b, c, d] = corners;
                writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}").unwrap();
            }
        }
    }
    text
}

struct Made {
    substrate: Substrate,
    texturing: Texturing,
    cluster: Cluster,
}

fn load(path: &Path) -> (Substrate, Texturing) {
    let (loaded, texturing) = load_textured(path).unwrap();
    (Substrate::from_loaded(loaded).unwrap(), texturing)
}

fn written(text: &str, name: &str) -> (Substrate, Texturing) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    load(&path)
}

/// A lichen on the sphere that covers the top and reaches over several seams.
fn made() -> Made {
    let (substrate, texturing) = written(&cube_sphere(12), "sphere.obj");
    let growth = grow(
        &substrate,
        &recipe(0.05, 500),
        &Execution::default(),
        &mut (),
    );
    Made {
        cluster: growth.unwrap().cluster,
        substrate,
        texturing,
    }
}

fn baker<'a>(made: &'a Made, settings: &Settings) -> Baker<'a> {
    let look = Look {
        cluster: &made.cluster,
        shape: &Shape::default(),
        paint: &Paint::default(),
    };
    let base = Base::Mesh;
    Baker::new(&made.substrate, &made.texturing, &[look], &base, settings).unwrap()
}

fn settings(size: u32, samples: u32) -> Settings {
    Settings {
        size,
        gutter: 8,
        samples,
        unwrap: false,
    }
}

fn map(name: &str) -> &'static Map {
    Map::named(name).unwrap()
}

/// A map at a place, by bilinear sampling as a renderer does it.
fn bilinear(baked: &Baked, map: &Map, uv: [f64; 2]) -> Vec3 {
    let size = baked.size() as f64;
    let p = DVec2::from(uv) * size - 0.5;
    let (low, share) = (p.floor(), (p - p.floor()).as_vec2());
    let at = |dx: i64, dy: i64| {
        let wrap = |x: f64, d: i64| (x as i64 + d).rem_euclid(size as i64) as usize;
        Vec3::from_array(baked.value(map, wrap(low.x, dx), wrap(low.y, dy)))
    };
    let upper = at(0, 0).lerp(at(1, 0), share.x);
    upper.lerp(at(0, 1).lerp(at(1, 1), share.x), share.y)
}

/// Places on seams: the half-edges and UVs of both sides, and the share of the way along the first.
fn seam_places(made: &Made, baked: &Baked) -> Vec<[(u32, f64, [f64; 2]); 2]> {
    let seams: HashMap<u32, [[f64; 2]; 2]> = baked.seams().into_iter().collect();
    let mut places = Vec::new();
    for (&h, ends) in &seams {
        let twin = made.substrate.twin(h).half_edge();
        assert!(twin != h && !made.substrate.twin(h).is_flipped());
        let others = seams[&twin];
        for share in [0.15, 0.5, 0.85] {
            let at = |[a, b]: [[f64; 2]; 2], s: f64| [0, 1].map(|k| a[k] + s * (b[k] - a[k]));
            let there = 1.0 - share;
            places.push([
                (h, share, at(*ends, share)),
                (twin, there, at(others, there)),
            ]);
        }
    }
    places
}

/// The world's direction of the normal map at a place on a half-edge.
fn world_normal(baked: &Baked, (h, share, uv): (u32, f64, [f64; 2])) -> Vec3 {
    let mut weights = [0.0; 3];
    weights[h as usize % 3] = 1.0 - share;
    weights[(h as usize + 1) % 3] = share;
    let axes = Mat3::from_cols_array_2d(&baked.tangent_frame(h / 3, weights));
    (axes * (2.0 * bilinear(baked, map("normal"), uv) - 1.0)).normalize()
}

/// Mean and greatest of some differences.
fn spread(differences: &[f32]) -> [f32; 2] {
    let mean = differences.iter().sum::<f32>() / differences.len() as f32;
    [mean, differences.iter().fold(0.0, |m, &d| m.max(d))]
}

#[test]
fn both_sides_of_a_seam_show_the_same() {
    check_seams(&settings(1024, 4));
}

fn check_seams(settings: &Settings) {
    let made = made();
    let baker = baker(&made, settings);
    let baked = baker.whole().unwrap();
    let under = |place: &(u32, f64, [f64; 2])| bilinear(&baked, map("mask"), place.2).x > 0.0;
    let places: Vec<_> = seam_places(&made, &baked)
        .into_iter()
        .filter(|[a, b]| under(a) || under(b))
        .collect();
    assert!(places.len() > 100, "only {} places", places.len());
    // Mean and greatest difference; a texel is a sixth of an element's radius. The mask counts
    // samples: where the rim crosses a seam, each side may be off by one of sixteen; where it lies along a row of
    // four and takes or leaves that, by two, but at no more than a place in a hundred.
    let bounds = [
        ("mask", 0.002, 0.25),
        ("height", 0.001, 0.05),
        ("birth", 0.0002, 0.001),
        ("color", 0.001, 0.005),
        ("occlusion", 0.001, 0.03),
        ("base_color", 0.001, 0.06), // crystals of the stone are smaller than a texel
        ("orm", 0.001, 0.03),
    ];
    for (name, mean, most) in bounds {
        let difference = |[a, b]: &[(u32, f64, [f64; 2]); 2]| {
            let [a, b] = [a.2, b.2].map(|uv| bilinear(&baked, map(name), uv));
            (a - b).abs().max_element()
        };
        let differences: Vec<f32> = places.iter().map(difference).collect();
        let found = spread(&differences);
        assert!(found[0] < mean && found[1] < most, "{name}: {found:?}");
        let usual = differences.iter().filter(|d| **d < 0.125).count();
        assert!(
            usual + places.len() / 100 >= places.len(),
            "{name}: {usual} of {}",
            places.len()
        );
    }
    let turned = |[a, b]: &[(u32, f64, [f64; 2]); 2]| {
        world_normal(&baked, *a).distance(world_normal(&baked, *b))
    };
    let found = spread(&places.iter().map(turned).collect::<Vec<_>>());
    assert!(found[0] < 0.005 && found[1] < 0.25, "normal: {found:?}");
}

/// Where on the surface the middle of a texel is, by trying every triangle.
fn place_of(made: &Made, uv: DVec2) -> Option<DVec3> {
    (0..made.substrate.triangles().len() as u32).find_map(|t| {
        let source = made.substrate.source_triangle(t) as usize;
        let [a, b, c] = made.texturing.uvs[source]?.map(|p| DVec2::from(p) - uv);
        let w = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let sum: f64 = w.iter().sum();
        let corners = made.substrate.corners(t);
        let inside = w.iter().all(|w| w / sum >= 0.0);
        inside.then(|| (0..3).map(|k| corners[k] * (w[k] / sum)).sum())
    })
}

#[test]
fn heights_are_those_of_the_skin() {
    let made = made();
    let fine = Shape {
        resolution: 0.5,
        ..Shape::default()
    };
    let mesh = skin(&made.substrate, &made.cluster, &fine, &Paint::default()).unwrap();
    let soup = Soup {
        positions: mesh.positions,
        triangles: mesh.triangles,
        notes: Vec::new(),
    };
    let skin = Substrate::from_soup(soup).unwrap();
    let baker = baker(&made, &settings(512, 1));
    let baked = baker.whole().unwrap();
    let (units, radius) = (made.substrate.units(), made.cluster.radius());
    let mut looked_at = [0, 0];
    for (x, y) in (0..512 * 512).step_by(37).map(|i| (i % 512, i / 512)) {
        let uv = (DVec2::new(x as f64, y as f64) + 0.5) / 512.0;
        let Some(place) = place_of(&made, uv) else {
            continue;
        };
        let height = f64::from(baked.value(map("height"), x, y)[0]) * baked.highest();
        let covered = baked.value(map("mask"), x, y)[0] > 0.0;
        looked_at[usize::from(covered)] += 1;
        assert_eq!(covered, height > 0.0);
        let in_file = units.to_file(place);
        // The sphere is about the origin, and heights are along the elements' mean normal.
        let top = in_file + in_file.normalize() * height;
        let (_, distance) = skin.nearest(skin.units().to_local(top.to_array()));
        let distance = skin.units().length_to_file(distance);
        let radius = units.length_to_file(radius);
        match covered {
            true => assert!(distance < 0.1 * radius, "{} radii", distance / radius),
            false => assert!(distance > 0.0),
        }
    }
    assert!(looked_at[0] > 500 && looked_at[1] > 100, "{looked_at:?}");
}

#[test]
fn the_frame_points_to_the_right_and_the_top_of_the_image() {
    let made = made();
    let baker = baker(&made, &settings(64, 1));
    let baked = baker.whole().unwrap();
    for t in 0..made.substrate.triangles().len() as u32 {
        let source = made.substrate.source_triangle(t) as usize;
        let [a, b, c] = made.texturing.uvs[source].unwrap().map(DVec2::from);
        let [p, q, r] = made.substrate.corners(t);
        // Solve for the change of place along u and v.
        let (e, f) = (b - a, c - a);
        let along = |w: DVec2| {
            let [x, y] = [w.perp_dot(f), e.perp_dot(w)].map(|x| x / e.perp_dot(f));
            ((q - p) * x + (r - p) * y).as_vec3().normalize()
        };
        let third = 1.0 / 3.0;
        let [tangent, bitangent, normal] = baked.tangent_frame(t, [third; 3]).map(Vec3::from_array);
        assert!(tangent.dot(along(DVec2::X)) > 0.9);
        // Near the cube's corners charts are skewed by 30 degrees.
        assert!(
            bitangent.dot(along(-DVec2::Y)) > 0.8,
            "up in the image is −v"
        );
        assert!(normal.dot(made.substrate.normal(t).as_vec3()) > 0.99);
    }
}

/// With the place, or its opposite, as the normal of each vertex.
fn with_normals(sphere: &str, sign: f64) -> String {
    let line = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        ["v", x, y, z] => {
            let [a, b, c] = [x, y, z].map(|x| 3.0 * sign * x.parse::<f64>().unwrap());
            format!("{line}\nvn {a} {b} {c}\n")
        }
        ["f", a, b, c, d] => {
            let corner = |corner: &str| format!("{corner}/{}", corner.split('/').next().unwrap());
            let [a, b, c, d] = [a, b, c, d].map(corner);
            format!("f {a} {b} {c} {d}\n")
        }
        _ => format!("{line}\n"),
    };
    sphere.lines().map(line).collect()
}

/// Maps go onto the mesh of the file, which is shaded by its own normals: here over edges that turn by 45°.
#[test]
fn the_frame_stands_on_the_normals_of_the_file() {
    for sign in [1.0, -1.0] {
        let text = with_normals(&cube_sphere(2), sign);
        let (substrate, texturing) = written(&text, "sphere.obj");
        let mut made = Made {
            cluster: Cluster::new(0.05),
            substrate,
            texturing,
        };
        made.cluster
            .push(Element::seed(&made.substrate, SurfacePoint::centroid(0)));
        let baker = baker(&made, &settings(64, 1));
        let baked = baker.whole().unwrap();
        for t in 0..made.substrate.triangles().len() as u32 {
            let corners = made.substrate.corners(t).into_iter();
            for (place, weights) in corners.zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
            {
                let [.., normal] = baked.tangent_frame(t, weights).map(Vec3::from_array);
                let radial = made.substrate.units().to_file(place).as_vec3();
                assert!(
                    normal.distance(radial.normalize()) < 1e-5,
                    "{normal} at {radial}"
                );
            }
        }
    }
}

/// Every map as PNG and EXR.
fn files(baked: &Baked) -> Vec<Vec<u8>> {
    let file = |map: &Map| {
        [MapFile::Png, MapFile::Exr].map(|file| {
            let (mut bytes, format) = (Vec::new(), MapFormat::default());
            let format = MapFormat { file, ..format };
            baked.write_map(map, &format, &mut bytes).unwrap();
            bytes
        })
    };
    MAPS.iter().flat_map(file).collect()
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    check_threads(&settings(256, 2));
}

fn check_threads(settings: &Settings) {
    let made = made();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| files(&baker(&made, settings).whole().unwrap()))
    };
    let one = on(1);
    assert_eq!(one.len(), 2 * MAPS.len());
    for threads in [2, 5] {
        assert!(on(threads) == one, "{threads} threads");
    }
}

#[test]
fn the_glb_is_the_mesh_with_its_uvs_and_a_material() {
    let made = made();
    let baker = baker(&made, &settings(128, 1));
    let baked = baker.whole().unwrap();
    let material = baked.material("stone", &[]).unwrap();
    let SurfaceLook::Maps(MapImages {
        base_color,
        normal,
        orm,
        ..
    }) = material.look.clone()
    else {
        panic!("{material:?}")
    };
    let mut scene = TexturedScene::new("lichened");
    scene.add(material, baked.meshes());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lichened.glb");
    let mut file = fs::File::create(&path).unwrap();
    scene.write_glb(&mut file).unwrap();
    let (again, texturing) = load(&path);
    assert_eq!(again.triangles().len(), made.substrate.triangles().len());
    assert_eq!(texturing.notes, [""; 0]);
    let material = texturing.materials[0].clone();
    let found =
        |texture: Option<thallus::substrate::Texture>| &texturing.images[texture.unwrap().image];
    assert_eq!(*found(material.base_color_texture), base_color);
    assert_eq!(*found(material.normal_texture), normal);
    assert_eq!(*found(material.metallic_roughness_texture), orm);
    assert_eq!(*found(material.occlusion_texture), orm);
    for t in 0..again.triangles().len() {
        // The mesh is written in the substrate's order.
        let source = made.substrate.source_triangle(t as u32) as usize;
        let (was, is) = (
            made.texturing.uvs[source].unwrap(),
            texturing.uvs[t].unwrap(),
        );
        for k in 0..3 {
            assert!((DVec2::from(was[k]) - DVec2::from(is[k])).length() < 1e-6);
        }
    }
    // Baked once more, the material shows through where there is no lichen.
    let look = Look {
        cluster: &made.cluster,
        shape: &Shape::default(),
        paint: &Paint::default(),
    };
    let growth = grow(&again, &recipe(0.05, 1), &Execution::default(), &mut ()).unwrap();
    let look = Look {
        cluster: &growth.cluster,
        ..look
    };
    let base = Base::Mesh;
    let twice = Baker::new(&again, &texturing, &[look], &base, &settings(128, 1)).unwrap();
    let twice = twice.whole().unwrap();
    let bare = (0..128 * 128)
        .map(|i| (i % 128, i / 128))
        .filter(|&(x, y)| twice.value(map("mask"), x, y)[0] == 0.0);
    for (x, y) in bare {
        let [was, is] =
            [&baked, &twice].map(|b| Vec3::from_array(b.value(map("base_color"), x, y)));
        assert!(
            (was - is).abs().max_element() < 0.006,
            "{x} {y}: {was} {is}"
        );
    }
}

/// Another lichen on the same mesh, of larger elements, which meets the first.
fn another(made: &Made) -> Cluster {
    let recipe = Recipe {
        seed: 2,
        ..recipe(0.08, 200)
    };
    let growth = grow(&made.substrate, &recipe, &Execution::default(), &mut ());
    growth.unwrap().cluster
}

#[test]
fn of_two_lichens_the_later_lies_over_the_first() {
    let made = made();
    let larger = another(&made);
    let (shape, base) = (Shape::default(), Base::Mesh);
    let paints = ["rhizocarpon", "xanthoria"].map(|name| {
        let found = PALETTE.iter().find(|map| map.name == name);
        Paint::of(found.unwrap())
    });
    let look = |i: usize| Look {
        cluster: [&made.cluster, &larger][i],
        shape: &shape,
        paint: &paints[i],
    };
    let of = |looks: &[Look]| {
        let settings = settings(192, 1);
        Baker::new(&made.substrate, &made.texturing, looks, &base, &settings).unwrap()
    };
    let bakers = [&[look(0)][..], &[look(1)], &[look(0), look(1)]].map(of);
    let [one, other, both] = bakers.each_ref().map(|baker| baker.whole().unwrap());
    let mask = map("mask");
    let own = ["color", "birth", "base_color", "normal", "height"].map(map);
    let value = |b: &Baked, map: &Map, x, y| {
        let scale = if map.name == "height" {
            b.highest() as f32
        } else {
            1.0
        };
        Vec3::from_array(b.value(map, x, y)) * scale
    };
    let mut seen = [0; 4];
    for (x, y) in (0..192 * 192).map(|i| (i % 192, i / 192)) {
        let covers = [&one, &other, &both].map(|m| m.value(mask, x, y)[0] > 0.0);
        seen[usize::from(covers[0]) + 2 * usize::from(covers[1])] += 1;
        assert_eq!(covers[2], covers[0] || covers[1], "{x} {y}");
        let upper = if covers[1] { &other } else { &one };
        for map in own.iter().filter(|_| covers[2]) {
            let [found, expected] = [&both, upper].map(|b| value(b, map, x, y));
            assert!(found.distance(expected) < 1e-5, "{x} {y}: {}", map.name);
        }
    }
    assert!(seen.iter().all(|n| *n > 50), "{seen:?}");
    let none = Baker::new(
        &made.substrate,
        &made.texturing,
        &[],
        &base,
        &settings(64, 1),
    );
    assert_eq!(none.unwrap_err(), BakeError::Skin(SkinError::Empty));
}
