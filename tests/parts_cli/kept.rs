//! Parts without lichen, which keep what they wear.

use thallus::substrate::{Material, Texture, Texturing, load_textured};

use super::*;

/// Two squares of two materials, each with its texture, moved and clamped, in the second of two sets of UVs, and
/// colours at the corners; lichen is on the first.
#[test]
fn a_part_without_lichen_keeps_what_it_wears() {
    let desk = Desk::new();
    put_two_looks(&desk, "two.gltf");
    desk.done("two.gltf --radius 0.01 --elements 60 --at 0.5,0,0.5 -o two");
    let bake = |words: &str| {
        let output = desk.call("bake", words).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        (output.stdout.clone(), said(&output))
    };
    let (_, told) = bake("two -o maps --size 64 --each material");
    assert!(
        told.contains("'Moss' has no maps: in lichened.glb it wears what the mesh's file says"),
        "{told}"
    );
    assert!(desk.path("maps/Stone_mask.png").exists() && !desk.path("maps/Moss_mask.png").exists());
    let (answer, _) = bake("two -o json --size 64 --each material --json");
    let answer: Value = serde_json::from_slice(&answer).unwrap();
    assert_eq!(answer["parts_without_maps"], json!(["Moss"]));
    let (loaded, made) = load_textured(&desk.path("maps/lichened.glb")).unwrap();
    let (_, before) = load_textured(&desk.path("two.gltf")).unwrap();
    assert_eq!(loaded.soup.triangles.len(), 4);
    let light = "material Moss gives light of its own, which pictures and maps do not show";
    assert_eq!(made.notes, [light]);
    let images = ["grey.png", "up.png"].map(|name| desk.path(name).canonicalize().unwrap());
    let read = before
        .image_files
        .iter()
        .map(|file| file.canonicalize().unwrap());
    assert_eq!(read.collect::<Vec<_>>(), images);
    assert!(made.image_files.is_empty());
    // Materials come in the order in which they are written: those with maps first.
    let [_, kept] = &made.materials[..] else {
        panic!("{:?}", made.materials)
    };
    let [_, own] = &before.materials[..] else {
        panic!("{:?}", before.materials)
    };
    let image = |texturing: &Texturing, texture: Option<Texture>| {
        texturing.images[texture.unwrap().image].clone()
    };
    let bare = |material: &Material| {
        let texture = |texture: Option<Texture>| texture.map(|t| Texture { image: 0, ..t });
        Material {
            base_color_texture: texture(material.base_color_texture),
            normal_texture: texture(material.normal_texture),
            emissive_texture: texture(material.emissive_texture),
            ..material.clone()
        }
    };
    let close = |a: [[f64; 3]; 2], b: [[f64; 3]; 2]| {
        let mut pairs = a.as_flattened().iter().zip(b.as_flattened());
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    };
    let (found, expected) = (bare(kept), bare(own));
    let moved = |material: &Material| material.base_color_texture.unwrap().transform;
    close(moved(&found), moved(&expected));
    let straight = |mut material: Material| {
        let texture = material.base_color_texture.as_mut();
        texture.unwrap().transform = [[0.0; 3]; 2];
        material
    };
    assert_eq!(straight(found), straight(expected));
    assert_eq!(
        image(&made, kept.base_color_texture),
        image(&before, own.base_color_texture)
    );
    assert_eq!(
        image(&made, kept.normal_texture),
        image(&before, own.normal_texture)
    );
    assert_eq!(
        image(&made, kept.emissive_texture),
        image(&before, own.emissive_texture)
    );
    let plain: Vec<_> = kept.extensions.keys().collect();
    assert_eq!(
        plain,
        ["KHR_materials_emissive_strength", "KHR_materials_unlit"]
    );
    let glb = fs::read(desk.path("maps/lichened.glb")).unwrap();
    let glb = String::from_utf8_lossy(&glb);
    let used = r#""extensionsUsed":["KHR_materials_emissive_strength","KHR_materials_unlit","KHR_texture_transform"]"#;
    assert!(glb.contains(used));
    // The second square's triangles are the last of both files, in whatever order.
    let corners = |texturing: &Texturing| {
        let of = |t: usize| {
            (
                texturing.uvs[t],
                texturing.second_uvs[t],
                texturing.colors[t],
            )
        };
        let mut all: Vec<String> = [2, 3].map(|t| format!("{:?}", of(t))).to_vec();
        all.sort();
        all
    };
    assert_eq!(corners(&made), corners(&before));
    // What is said to be in the file is in it: a part that lies where another does is not.
    let twice = std::fs::read_to_string(desk.path("two.gltf")).unwrap();
    let twice = twice.replace(r#""byteOffset":12"#, r#""byteOffset":0"#);
    fs::write(desk.path("twice.gltf"), twice).unwrap();
    desk.done("twice.gltf --radius 0.01 --elements 60 --at 0.5,0,0.5 -o twice");
    let (_, told) = bake("twice -o twice-maps --size 64 --each material");
    assert!(
        told.contains("'Moss' has no area, or lies where other parts do")
            && !told.contains("has no maps"),
        "{told}"
    );
    let none = desk
        .call("bake", "twice -o none --only material:Moss")
        .output()
        .unwrap();
    assert!(
        none.status.code() == Some(1) && said(&none).contains("or lies where other parts"),
        "{}",
        said(&none)
    );
    // With another base all parts have maps.
    bake("two -o stone --size 64 --each material --base stone");
    assert!(desk.path("stone/Moss_mask.png").exists());
}

fn put_two_looks(desk: &Desk, name: &str) {
    let square = |x: f32| {
        [
            [x, 0.0, 0.0],
            [x, 0.0, 1.0],
            [x + 1.0, 0.0, 1.0],
            [x + 1.0, 0.0, 0.0],
        ]
    };
    let corners: Vec<[f32; 3]> = [square(0.0), square(2.0)].concat();
    let first = corners.iter().map(|[x, _, z]| [x / 3.0, *z]);
    let second = corners
        .iter()
        .map(|[x, _, z]| [(x % 2.0).min(1.0), 1.0 - z]);
    let uvs: Vec<[f32; 2]> = first.chain(second).collect();
    let colors = corners.iter().map(|[x, _, z]| [x / 3.0, *z, 0.5]);
    let colors: Vec<[f32; 3]> = colors.collect();
    let numbers = corners.as_flattened().iter().chain(uvs.as_flattened());
    let numbers = numbers.chain(colors.as_flattened());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    let indices = [0u16, 4].map(|k| [k, k + 1, k + 2, k, k + 2, k + 3]);
    bytes.extend(indices.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    fs::write(desk.path("looks.bin"), &bytes).unwrap();
    fs::write(desk.path("grey.png"), image(|u, v| u * v)).unwrap();
    fs::write(desk.path("up.png"), image(|u, _| 0.5 + 0.1 * u)).unwrap();
    let primitive = |indices, material| {
        json!({
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2, "COLOR_0": 3},
            "indices": indices, "material": material,
        })
    };
    let mut halves = [
        accessor(4, 5123, 6, "SCALAR"),
        accessor(4, 5123, 6, "SCALAR"),
    ];
    halves[1]["byteOffset"] = 12.into();
    let [low, high] = halves;
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_texture_transform"],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [primitive(4, 0), primitive(5, 1)]}],
        "materials": [
            {"name": "Stone", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
            {
                "name": "Moss",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 0.75, 0.25, 0.5],
                    "metallicFactor": 0.25,
                    "roughnessFactor": 0.5,
                    "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {
                        "offset": [0.25, -0.5], "rotation": 0.7, "scale": [2.0, -3.0],
                    }}},
                },
                "normalTexture": {"index": 1, "scale": 0.5},
                "emissiveFactor": [0.5, 1.0, 0.0],
                "emissiveTexture": {"index": 1},
                "extensions": {
                    "KHR_materials_emissive_strength": {"emissiveStrength": 3.5},
                    "KHR_materials_unlit": {},
                    "KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatTexture": {"index": 0}},
                },
                "alphaMode": "MASK",
                "alphaCutoff": 0.25,
                "doubleSided": true,
            },
        ],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [{"uri": "grey.png"}, {"uri": "up.png"}],
        "accessors": [
            accessor(0, 5126, 8, "VEC3"), accessor(1, 5126, 8, "VEC2"), accessor(2, 5126, 8, "VEC2"),
            accessor(3, 5126, 8, "VEC3"), low, high,
        ],
        "bufferViews": [view(0, 96), view(96, 64), view(160, 64), view(224, 96), view(320, 24)],
        "buffers": [{"uri": "looks.bin", "byteLength": 344}],
    });
    fs::write(desk.path(name), document.to_string()).unwrap();
}
