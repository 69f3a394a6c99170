//! Materials under the lichen: images in the second set of UVs, and what is seen through.

use thallus::bake::MapKind;
use thallus::export::TexturedScene;
use thallus::substrate::{Alpha, Part, Texture};

use super::layouts::{plain, squares};
use super::*;

/// Two by two texels, each with its alpha.
pub(super) fn image(texels: [[u8; 4]; 4]) -> Vec<u8> {
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(texels.as_flattened()).unwrap();
    drop(writer);
    image
}

pub(super) fn texture(image: usize, is_in_second: bool) -> Option<Texture> {
    Some(Texture {
        image,
        is_in_second,
        strength: 1.0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        wrap: Default::default(),
    })
}

/// So many squares, each on a row of its own, a lichen on the first, and a material for each.
fn made_of(materials: &[Material]) -> Made {
    let count = materials.len();
    let strip = |k: usize| {
        let at = |x: f64| (k as f64 + x) / count as f64;
        let [low, high] = [at(0.1), at(0.9)];
        [[0.1, low], [0.1, high], [0.9, high], [0.9, low]]
    };
    let uvs: Vec<_> = (0..count).map(strip).collect();
    let (substrate, mut texturing) = written(&squares(&uvs), "squares.obj");
    texturing.materials = materials.to_vec();
    texturing.material_of = (0..2 * count).map(|t| Some(t as u32 / 2)).collect();
    let growth = grow(&substrate, &recipe(0.01, 3), &Execution::default(), &mut ());
    Made {
        cluster: growth.unwrap().cluster,
        substrate,
        texturing,
    }
}

const GREEN: [u8; 4] = [0, 255, 0, 255];
const GLASS: [u8; 4] = [0, 255, 0, 51];

#[test]
fn images_in_the_second_set_of_uvs_are_read_there() {
    const COLORS: [[u8; 4]; 4] = [
        [255, 0, 0, 255],
        GREEN,
        [0, 0, 255, 255],
        [255, 255, 255, 255],
    ];
    // To the right, by (0.6, 0, 0.8).
    let tilted = image([[204, 128, 230, 255]; 4]);
    let material = |is_in_second| Material {
        base_color_texture: texture(0, is_in_second),
        normal_texture: texture(1, is_in_second),
        ..plain()
    };
    for (is_in_second, right) in [(false, [0.6, 0.0]), (true, [0.0, -0.6])] {
        let mut made = made_of(&[material(is_in_second)]);
        made.texturing.images = vec![image(COLORS), tilted.clone()];
        // A quarter of a turn: what is to the right in the second is below in the first.
        let turned = |[u, v]: [f64; 2]| [v, 1.0 - u];
        let uvs = made.texturing.uvs.iter();
        made.texturing.second_uvs = uvs.map(|uvs| uvs.map(|uvs| uvs.map(turned))).collect();
        let check = |made: &Made, right: [f32; 2], place: &dyn Fn([f64; 2]) -> [f64; 2]| {
            let baker = baker(made, &settings(64, 1));
            let baked = baker.whole().unwrap();
            let mut seen = 0;
            for (x, y) in (0..64 * 64).map(|i| (i % 64, i / 64)) {
                let uv = [x, y].map(|k| (k as f64 + 0.5) / 64.0);
                let [u, v] = place(uv);
                let is_bare = baked.value(map("mask"), x, y)[0] == 0.0;
                // The middles of texels are at a quarter and three quarters.
                let is_clear = [u, v].iter().all(|x| ((x - 0.5).abs() - 0.25).abs() < 0.03);
                if !is_bare || !is_clear {
                    continue;
                }
                let number = usize::from(u > 0.5) + 2 * usize::from(v > 0.5);
                let [red, green, blue, _] = COLORS[number].map(|x| f32::from(x / 255));
                let found = Vec3::from_array(baked.value(map("base_color"), x, y));
                let expected = Vec3::new(red, green, blue);
                assert!(
                    found.distance(expected) < 0.2,
                    "{x} {y}: {found} {expected}"
                );
                let normal = Vec3::from_array(baked.value(map("normal"), x, y)) * 2.0 - 1.0;
                let expected = Vec3::new(right[0], right[1], 0.8);
                assert!(normal.distance(expected) < 0.02, "{x} {y}: {normal}");
                seen += 1;
            }
            assert!(seen > 20, "{seen}");
        };
        let in_second = |uv: [f64; 2]| if is_in_second { turned(uv) } else { uv };
        check(&made, right, &in_second);
        // Laid out in the other set, whose coordinates in the first are turned back.
        made.texturing.swap_uv_sets();
        let back = |[s, t]: [f64; 2]| if is_in_second { [s, t] } else { [1.0 - t, s] };
        let right = if is_in_second { [0.6, 0.0] } else { [0.0, 0.6] };
        check(&made, right, &back);
    }
}

#[test]
fn what_is_cut_out_stays_cut_out() {
    let leaf = |alpha| Material {
        base_color_texture: texture(0, false),
        alpha,
        ..plain()
    };
    let of = |materials: &[Material]| {
        let mut made = made_of(materials);
        made.texturing.images = vec![image([GREEN, GLASS, GREEN, GLASS])];
        made
    };
    let opacities = |made: &Made| {
        let baker = baker(made, &settings(64, 1));
        let baked = baker.whole().unwrap();
        let rows = (0..made.texturing.materials.len()).rev();
        let middle = |row: usize| 64 * (2 * row + 1) / (2 * made.texturing.materials.len());
        let at = |row: usize| [16, 48].map(|x| 100.0 * baked.opacity(x, middle(row)));
        (baked.alpha(), rows.map(at).collect::<Vec<_>>())
    };
    let (mask, blend) = (Alpha::Mask { cutoff: 0.4 }, Alpha::Blend);
    type Case<'a> = (&'a [Material], Alpha, Vec<[f32; 2]>);
    let cases: [Case; 5] = [
        (&[leaf(Alpha::Opaque)], Alpha::Opaque, vec![[100.0, 100.0]]),
        (&[leaf(mask)], mask, vec![[100.0, 20.0]]),
        (
            &[leaf(mask), plain()],
            mask,
            vec![[100.0, 20.0], [100.0, 100.0]],
        ),
        (
            &[leaf(mask), leaf(blend)],
            blend,
            vec![[100.0, 0.0], [100.0, 20.0]],
        ),
        (
            &[leaf(mask), leaf(Alpha::Mask { cutoff: 0.1 })],
            Alpha::Mask { cutoff: 0.5 },
            vec![[100.0, 25.0], [100.0, 100.0]],
        ),
    ];
    for (materials, alpha, expected) in cases {
        let (found_alpha, found) = opacities(&of(materials));
        assert_eq!(found_alpha, alpha, "{materials:?}");
        let pairs = found.as_flattened().iter().zip(expected.as_flattened());
        let differ = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(
            found.len() == expected.len() && differ < 2.0,
            "{found:?} {expected:?}"
        );
    }
}

/// Pictures and skins show it so; but nothing closes holes.
#[test]
fn lichen_on_glass_is_opaque() {
    const NONE: [u8; 4] = [0, 255, 0, 0];
    let (mask, blend) = (Alpha::Mask { cutoff: 0.1 }, Alpha::Blend);
    let cases = [
        (blend, GLASS, Some(0.2)),
        (blend, NONE, None),
        (mask, GLASS, None),
    ];
    for (alpha, texel, glass) in cases {
        let mut made = made_of(&[Material {
            base_color_texture: texture(0, false),
            alpha,
            ..plain()
        }]);
        made.texturing.images = vec![image([texel; 4])];
        let baker = baker(&made, &settings(64, 4));
        let baked = baker.whole().unwrap();
        let own = f32::from(texel[3]) / 255.0;
        let mut most = 0.0f32;
        for (x, y) in (0..64 * 64).map(|i| (i % 64, i / 64)) {
            let [lichen, ..] = baked.value(map("mask"), x, y);
            most = most.max(lichen);
            let expected = glass.map_or(own, |glass| glass + (1.0 - glass) * lichen);
            let found = baked.opacity(x, y);
            assert!(
                (found - expected).abs() < 1e-3,
                "{alpha:?}: {found} {expected}"
            );
        }
        assert!(most > 0.5, "{most}");
    }
}

#[test]
fn the_glb_is_cut_out_and_shows_from_behind_as_its_material() {
    let leaf = Material {
        base_color_texture: texture(0, false),
        alpha: Alpha::Mask { cutoff: 0.25 },
        opacity: 0.8,
        is_double_sided: true,
        ..plain()
    };
    let mut made = made_of(&[leaf]);
    made.texturing.images = vec![image([GREEN, GLASS, GREEN, GLASS])];
    let baker = baker(&made, &settings(64, 1));
    let baked = baker.whole().unwrap();
    let mut scene = TexturedScene::new("leaf");
    scene.add(baked.material("Leaf", &[]).unwrap(), baked.meshes());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaf.glb");
    scene
        .write_glb(&mut fs::File::create(&path).unwrap())
        .unwrap();
    let (again, texturing) = load(&path);
    let [material] = &texturing.materials[..] else {
        panic!("{:?}", texturing.materials);
    };
    assert_eq!(material.alpha, Alpha::Mask { cutoff: 0.25 });
    assert!(material.is_double_sided);
    let twice = Made {
        cluster: grow(&again, &recipe(0.01, 3), &Execution::default(), &mut ())
            .unwrap()
            .cluster,
        substrate: again,
        texturing,
    };
    let baker = super::baker(&twice, &settings(64, 1));
    let twice = baker.whole().unwrap();
    for [x, y] in [[10, 20], [16, 40], [40, 31], [50, 10]] {
        let [was, is] = [&baked, &twice].map(|b| b.opacity(x, y));
        assert!((was - is).abs() < 0.005, "{x} {y}: {was} {is}");
    }
    assert!((baked.opacity(16, 32) - 0.8).abs() < 0.01);
    let mut exr = Vec::new();
    let base_color = MAPS
        .iter()
        .find(|map| map.kind == MapKind::BaseColor)
        .unwrap();
    let format = MapFormat {
        file: MapFile::Exr,
        ..MapFormat::default()
    };
    baked.write_map(base_color, &format, &mut exr).unwrap();
    assert!(exr[..200].windows(4).any(|bytes| bytes == [b'A', 0, 1, 0]));
}

/// Two halves of the sphere as objects, one of them turned, scaled and moved by its node.
#[test]
fn objects_stand_as_their_nodes_do() {
    let mut made = made();
    let turn = glam::DMat3::from_rotation_z(0.5) * 0.25;
    let [x, y, z] = turn.to_cols_array_2d();
    let part = |name: &str, frame| Part {
        objects: vec![name.to_owned()],
        material: None,
        frame,
        ..Part::default()
    };
    let moved = [x, y, z, [0.0, 0.0, 9.0]];
    made.texturing.parts = vec![part("Left", Some(moved)), part("Right", None)];
    let count = made.texturing.material_of.len() as u32;
    made.texturing.part_of = (0..count).map(|t| Some(2 * t / count)).collect();
    let baker = baker(&made, &settings(64, 1));
    let baked = baker.whole().unwrap();
    let mut scene = TexturedScene::new("ball");
    scene.add(baked.material("Both", &[]).unwrap(), baked.meshes());
    let mut glb = Vec::new();
    scene.write_glb(&mut glb).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let said: serde_json::Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let nodes = said["nodes"].as_array().unwrap();
    assert_eq!([&nodes[1]["name"], &nodes[2]["name"]], ["Left", "Right"]);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!((number(&nodes[1]["scale"][1]) - 0.25).abs() < 1e-12);
    assert!((number(&nodes[1]["rotation"][2]) - 0.25_f64.sin()).abs() < 1e-12);
    assert_eq!(number(&nodes[1]["translation"][2]), 9.0);
    assert!(nodes[2].get("rotation").is_none());

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.glb");
    fs::write(&path, &glb).unwrap();
    let (again, texturing) = load(&path);
    let corners = |substrate: &Substrate| {
        let all = 0..substrate.triangles().len() as u32;
        let at = |p| substrate.units().to_file(p);
        let mut middles: Vec<_> = all
            .map(|t| substrate.corners(t).map(at).iter().sum::<DVec3>() / 3.0)
            .collect();
        let key = |p: &DVec3| (*p * 1e4).round().as_i64vec3().to_array();
        middles.sort_by_key(key);
        middles
    };
    let [was, is] = [corners(&made.substrate), corners(&again)];
    assert_eq!(was.len(), is.len());
    let apart = was.iter().zip(&is).map(|(a, b)| a.distance(*b));
    assert!(apart.fold(0.0, f64::max) < 2e-4);
    // Normals come back turned by the node.
    for t in 0..again.triangles().len() as u32 {
        let normals = texturing.normals_of(&again, t).unwrap();
        let places = again.corners(t).map(|p| again.units().to_file(p));
        let along = places
            .iter()
            .zip(normals)
            .map(|(p, n)| p.normalize().dot(n));
        assert!(along.fold(1.0, f64::min) > 0.999, "{t}");
    }
}

/// Smaller levels of a texture mix what lies beyond the charts into their rims.
#[test]
fn beyond_a_part_is_its_own_material() {
    let plain_of = |base_color, roughness| Material {
        base_color,
        roughness,
        ..plain()
    };
    let red = plain_of([1.0, 0.0, 0.0], 0.25);
    let blue = plain_of([0.0, 0.0, 1.0], 0.75);
    let made = made_of(&[red, blue]);
    let baker = baker(&made, &settings(256, 1));
    for (part, color, roughness) in [(0, Vec3::X, 0.25), (1, Vec3::Z, 0.75)] {
        let chosen: Vec<bool> = (0..4).map(|t| t / 2 == part).collect();
        let baked = baker.part(&chosen).unwrap();
        assert_eq!(baked.report().triangles, 2);
        let at = |name: &str| Vec3::from_array(baked.value(map(name), 0, 0));
        assert_eq!(at("base_color"), color);
        assert!((at("orm").y - roughness).abs() < 1e-6);
    }
}

/// Where there is no triangle: the mean of what is seen, or what the mesh's own image has there.
#[test]
fn beyond_textures_is_their_mean_or_the_image_itself() {
    const RED: [u8; 4] = [255, 0, 0, 255];
    // Red above, where the squares of the second set lie, and green below.
    let made = |materials: &[Material]| {
        let mut made = made_of(materials);
        made.texturing.images = vec![image([RED, RED, GREEN, GREEN]), image([GREEN; 4])];
        let above = |[u, v]: [f64; 2]| [u, 0.24 + 0.02 * v];
        let uvs = made.texturing.uvs.iter();
        made.texturing.second_uvs = uvs.map(|uvs| uvs.map(|uvs| uvs.map(above))).collect();
        made
    };
    let of = |number, is_in_second| Material {
        base_color_texture: texture(number, is_in_second),
        ..plain()
    };
    let beside = |made: &Made| {
        let baker = baker(made, &settings(256, 1));
        let baked = baker.whole().unwrap();
        Vec3::from_array(baked.value(map("base_color"), 0, 192))
    };
    let cases: [(&[Material], Vec3); 5] = [
        (&[of(0, true)], Vec3::X),
        (&[of(0, false)], Vec3::Y),
        (&[of(0, true), of(1, true)], Vec3::new(0.5, 0.5, 0.0)),
        // The first has nothing to say of the other's.
        (&[of(0, true), of(1, false)], Vec3::new(0.5, 0.5, 0.0)),
        (
            &[of(1, false), plain(), plain(), plain()],
            Vec3::new(0.75, 1.0, 0.75),
        ),
    ];
    for (materials, expected) in cases {
        let found = beside(&made(materials));
        assert!(found.distance(expected) < 0.05, "{found} {expected}");
    }
}
