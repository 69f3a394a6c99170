//! What files say of the looks of their triangles: colours of vertices, and OBJ's material libraries.

use super::gltf_doc::*;
use super::*;
use serde_json::json;
use thallus::substrate::{Alpha, Material, Texturing, load_textured};

/// Files of these names in a folder; the first is the mesh.
pub(crate) fn textured(files: &[(&str, &[u8])]) -> (Texturing, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let read = load_textured(&folder.path().join(files[0].0));
    (read.unwrap().1, folder)
}

/// Linear light of an sRGB number (IEC 61966-2-1).
fn linear(x: f32) -> f32 {
    match x <= 0.040_45 {
        true => x / 12.92,
        false => ((x + 0.055) / 1.055).powf(2.4),
    }
}

/// The colours of the only triangle are these, sRGB.
fn assert_colors(texturing: &Texturing, srgb: [[f32; 3]; 3], what: &str) {
    let [Some(found)] = texturing.colors[..] else {
        panic!("{what}: {:?}", texturing.colors)
    };
    let pairs = found.as_flattened().iter().zip(srgb.as_flattened());
    for (&found, &expected) in pairs {
        let expected = linear(expected);
        assert!(
            (found - expected).abs() < 1e-6,
            "{what}: {found} {expected}"
        );
    }
}

/// Red 1, green 0.4, blue 0 and so on.
const COLORS: [[f32; 3]; 3] = [[1.0, 0.4, 0.0], [0.2, 0.0, 1.0], [0.0, 0.6, 0.8]];
const PLACES: [&str; 3] = ["0 0 0", "1 0 0", "0 1 0"];

/// Rows of vertices with colours that go up to `most`.
fn rows(before: &str, most: f32) -> String {
    let row = |k: usize| {
        let [r, g, b] = COLORS[k].map(|x| x * most);
        format!("{before}{} {r} {g} {b}\n", PLACES[k])
    };
    (0..3).map(row).collect()
}

#[test]
fn colours_of_vertices_are_read_from_ply_by_their_type() {
    for (kind, names, most) in [
        ("uchar", ["red", "green", "blue"], 255.0),
        (
            "ushort",
            ["diffuse_red", "diffuse_green", "diffuse_blue"],
            65_535.0,
        ),
        ("float", ["r", "g", "b"], 1.0),
        ("float", ["r", "g", "b"], 255.0),
        ("double", ["red", "green", "blue"], 1.0),
    ] {
        let [r, g, b] = names.map(|name| format!("property {kind} {name}\n"));
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{r}{g}{b}\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n",
            rows("", most)
        );
        let (texturing, _) = textured(&[("a.ply", text.as_bytes())]);
        assert_colors(&texturing, COLORS, kind);
        assert_eq!(texturing.uvs, [], "{kind}");
        // Without one of the three there is no colour; the mesh is the same.
        let text = text.replace(names[1], "other");
        let (texturing, _) = textured(&[("a.ply", text.as_bytes())]);
        assert_eq!(texturing.colors, [], "{kind}");
    }
    let odd = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float red\nproperty float green\nproperty float blue\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 nan 2 -1\n1 0 0 0 inf 1\n0 1 0 -inf 1 0\n3 0 1 2\n";
    let (texturing, _) = textured(&[("a.ply", odd.as_bytes())]);
    let clamped = [[0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]];
    assert_colors(&texturing, clamped, "not colours");
}

#[test]
fn colours_of_vertices_are_read_from_obj_whatever_they_go_to() {
    for most in [1.0, 255.0] {
        let text = format!("{}f 1 2 3\n", rows("v ", most));
        let (texturing, _) = textured(&[("a.obj", text.as_bytes())]);
        assert_colors(&texturing, COLORS, "obj");
    }
    // One that is a little brighter than white does not make all of them black.
    let text = format!(
        "{}f 1 2 3\n",
        rows("v ", 1.0).replacen(" 1 0.4", " 1.2 0.4", 1)
    );
    let (texturing, _) = textured(&[("a.obj", text.as_bytes())]);
    assert_colors(&texturing, COLORS, "bright");
    // A vertex with a weight has no colour, and a triangle with such a corner none.
    let text =
        "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 1 1 0 1\nf 4 3 2\nf 1 2 3\nf 2 4 3\n";
    let (texturing, _) = textured(&[("a.obj", text.as_bytes())]);
    let red = Some([[1.0, 0.0, 0.0]; 3]);
    assert_eq!(texturing.colors, [None, red]);
    assert_eq!(texturing.material_of, [None; 3]);
}

#[test]
fn colours_of_vertices_are_read_from_gltf_as_linear_light() {
    let color = |[r, g, b]: [f32; 3]| [r, g, b, 0.5].map(|x| (x * 255.0).round() as u8);
    let bytes = COLORS.map(color);
    for kind in ["float", "bytes"] {
        let mut doc = Doc::new();
        let positions = doc.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let colors = match kind {
            "float" => doc.positions(&COLORS),
            _ => {
                let at = doc.accessor(bytes.as_flattened(), U8, "VEC4", 3);
                doc.json["accessors"][at]["normalized"] = json!(true);
                at
            }
        };
        let attributes = json!({"POSITION": positions, "COLOR_0": colors});
        doc.show(json!({"attributes": attributes}), json!({}));
        let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
        assert_eq!(texturing.colors, [Some(COLORS)], "{kind}");
        // Too few of them, or another type, are none.
        doc.json["accessors"][colors]["count"] = json!(2);
        let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
        assert_eq!(texturing.colors, [], "{kind}");
        doc.json["accessors"][colors]["type"] = json!("MAT2");
        let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
        assert_eq!(texturing.colors, [], "{kind}");
    }
}

#[test]
fn factors_of_gltf_materials_stay_in_their_range() {
    let mut doc = Doc::new();
    let positions = doc.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let factors = json!({
        "baseColorFactor": [3.0, -1.0, 0.5, 1.0], "metallicFactor": 5.0, "roughnessFactor": -2.0
    });
    doc.json["materials"] = json!([{ "pbrMetallicRoughness": factors }]);
    let primitive = json!({"attributes": {"POSITION": positions}, "material": 0});
    doc.show(primitive, json!({}));
    let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
    let [material] = &texturing.materials[..] else {
        panic!("{:?}", texturing.materials)
    };
    let color = [1.0, 0.0, 0.5];
    assert_eq!([material.base_color, material.bare_color], [color; 2]);
    assert_eq!((material.metallic, material.roughness), (1.0, 0.0));
}

#[test]
fn textures_of_gltf_may_be_in_the_second_set_where_there_is_one() {
    let mut doc = Doc::new();
    let positions = doc.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let places: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.25, 1.0]];
    let bytes: Vec<u8> = places
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let uvs = doc.accessor(&bytes, FLOAT, "VEC2", 3);
    let png = base64(PNG);
    doc.json["images"] = json!([{"uri": format!("data:image/png;base64,{png}")}]);
    doc.json["textures"] = json!([{"source": 0}]);
    let texture = json!({"index": 0, "texCoord": 1});
    let leaf = json!({
        "pbrMetallicRoughness": {"baseColorTexture": texture},
        "alphaMode": "MASK", "alphaCutoff": -1, "doubleSided": true,
    });
    doc.json["materials"] = json!([leaf, {"name": "Odd", "alphaCutoff": "x"}]);
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs, "TEXCOORD_1": uvs});
    doc.show(json!({"attributes": attributes, "material": 0}), json!({}));
    let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
    let places = Some(places.map(|uv| uv.map(f64::from)));
    assert_eq!(
        (&texturing.uvs, &texturing.second_uvs),
        (&vec![places], &vec![places])
    );
    let [leaf, odd] = &texturing.materials[..] else {
        panic!("{:?}", texturing.materials)
    };
    assert!(
        leaf.base_color_texture
            .is_some_and(|texture| texture.is_in_second)
    );
    assert_eq!(
        (leaf.alpha, leaf.is_double_sided),
        (Alpha::Mask { cutoff: 0.0 }, true)
    );
    assert_eq!(*odd, Material::default());
    let [note] = &texturing.notes[..] else {
        panic!("{:?}", texturing.notes)
    };
    assert!(note.starts_with("material Odd cannot be read"), "{note}");
    // A set that is too short is none.
    doc.json["accessors"][uvs]["count"] = json!(2);
    let attributes = json!({"POSITION": positions, "TEXCOORD_1": uvs});
    doc.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
    assert_eq!(texturing.materials[0].base_color_texture, None);
    let told = texturing.notes.concat();
    assert!(
        told.contains("base colour texture is in TEXCOORD_1, which no mesh has"),
        "{told}"
    );
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
const FACES: &str =
    "usemtl Rock 1\nf 1/1 2/2 3/3\nusemtl plain\nf 1/1 3/3 4/4\nusemtl unknown\nf 1 2 4\n";
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Each fault once, and no other's cure.
#[test]
fn images_of_gltf_that_are_not_there_are_told_once() {
    let of = |images: serde_json::Value, texture: serde_json::Value| {
        let mut doc = Doc::new();
        let positions = doc.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        doc.json["materials"] = json!([{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 0},
        }]);
        doc.json["textures"] = json!([texture]);
        doc.json["images"] = images;
        let primitive = json!({"attributes": {"POSITION": positions}, "material": 0});
        doc.show(primitive, json!({}));
        let (texturing, _) = textured(&[("a.glb", &doc.glb()), ("a.webp", b"RIFF....WEBP")]);
        texturing.notes
    };
    let source = json!({"source": 0});
    let notes = of(json!([{"uri": "gone.png"}]), source.clone());
    let [note] = &notes[..] else {
        panic!("{notes:?}")
    };
    assert!(
        note.starts_with("image 0 is passed over: ") && note.contains("gone.png"),
        "{note}"
    );
    assert!(!note.contains("WebP"), "{note}");
    let notes = of(json!([{"uri": "a.webp"}]), source);
    let [note] = &notes[..] else {
        panic!("{notes:?}")
    };
    assert!(
        note.contains("neither PNG nor JPEG") && note.ends_with("save it as one of those"),
        "{note}"
    );
    let notes = of(
        json!([]),
        json!({"extensions": {"EXT_texture_webp": {"source": 0}}}),
    );
    assert_eq!(notes.len(), 2);
    assert!(
        notes.iter().all(|note| note.contains("WebP and KTX2")),
        "{notes:?}"
    );
}

#[test]
fn materials_of_obj_come_from_its_libraries() {
    let library = "\u{feff}# of a scanner\n\tnewmtl Rock 1  \r\n Kd 0 0 0\r\nillum spectral\nmap_Kd -clamp on C:\\scan\\the rock.png\n\
        norm -bm 0.5 n.png\nKd 0.1 0.1 0.1\nnewmtl plain # grey\nKd 0.25\nPr 0.5\nPm 2\nnewmtl plain\nKd 1 1 1\n";
    let obj = format!("mtllib my scan.mtl # all of it\n{QUAD}{FACES}")
        .replace("plain", "plain # no texture");
    let files: [(&str, &[u8]); 4] = [
        ("a.obj", obj.as_bytes()),
        ("my scan.mtl", library.as_bytes()),
        ("the rock.png", PNG),
        ("n.png", PNG),
    ];
    let (texturing, _) = textured(&files);
    assert_eq!(texturing.notes, [""; 0]);
    assert_eq!(texturing.material_of, [Some(0), Some(1), None]);
    let [rock, plain] = &texturing.materials[..] else {
        panic!("{:?}", texturing.materials)
    };
    let [base, normal] = [&rock.base_color_texture, &rock.normal_texture].map(|t| t.unwrap());
    assert_eq!((base.image, base.strength), (0, 1.0));
    assert_eq!((normal.image, normal.strength), (1, 0.5));
    assert_eq!((rock.base_color, texturing.images.len()), ([1.0; 3], 2));
    assert_eq!(rock.bare_color, [0.1; 3]);
    assert_eq!([plain.base_color, plain.bare_color], [[0.25; 3]; 2]);
    assert_eq!((plain.roughness, plain.metallic), (0.5, 1.0));

    let beyond = library.replace("-bm 0.5", "-bm 1e39");
    let (texturing, _) = textured(&[
        ("a.obj", obj.as_bytes()),
        ("my scan.mtl", beyond.as_bytes()),
        ("n.png", PNG),
    ]);
    let normal = texturing.materials[0].normal_texture;
    assert_eq!(normal.map(|n| n.strength), Some(1.0));

    // Two libraries in a line, an image that is none, one that is not there, and a library that is not.
    let obj = format!("mtllib one.mtl two.mtl\nmtllib three.mtl\n{QUAD}{FACES}");
    let (texturing, _) = textured(&[
        ("a.obj", obj.as_bytes()),
        ("one.mtl", b"newmtl Rock 1\nmap_Kd gone.png\nmap_Kd a.obj"),
        ("two.mtl", b"newmtl plain\nKd nan 1 1\nKd 2 0.5 -1\nmap_Kd"),
    ]);
    assert_eq!(texturing.material_of, [Some(0), Some(1), None]);
    assert_eq!(texturing.materials[1].base_color, [1.0, 0.5, 0.0]);
    let notes = texturing.notes.join("; ");
    assert_says(
        &notes,
        &[
            "gone.png",
            "a.obj is passed over: it is neither PNG nor JPEG",
            "three.mtl",
        ],
    );
    assert_eq!(texturing.images.len(), 0);
    // Of many faults a few are told.
    let many: String = (0..2000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    let (texturing, _) = textured(&[("a.obj", format!("{many}{QUAD}{FACES}").as_bytes())]);
    assert_eq!(texturing.notes.len(), 13);
    // In memory there is no library, and that is no fault.
    assert_eq!(parsed(&obj, Format::Obj).triangles.len(), 3);
}

/// Texture coordinates of all triangles, rows counted from above.
fn uvs(files: &[(&str, &[u8])]) -> Vec<Option<[[f64; 2]; 3]>> {
    textured(files).0.uvs
}

#[test]
fn a_texture_coordinate_of_obj_may_have_one_number() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let expected = [[0.25, 1.0], [1.0, 1.0], [0.0, 0.0]];
    assert_eq!(uvs(&[("a.obj", text.as_bytes())]), [Some(expected)]);
}

#[test]
fn corners_of_ply_have_their_own_texture_coordinates_or_none() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    let expected = [[0.25, 1.0], [1.0, 1.0], [0.0, 0.0]];
    for list in ["6 0.25 0 1 0 0 1", "9 0.25 0 7 1 0 7 0 1 7"] {
        let text = format!("{header}3 0 1 2 {list}\n3 0 1 2\n");
        let found = uvs(&[("a.ply", text.as_bytes())]);
        assert_eq!(found, [Some(expected)], "{list}");
    }
}

#[test]
fn libraries_of_a_mesh_in_memory_need_a_folder() {
    let notes = |text: &str| {
        let (_, texturing) = parse_textured(text.as_bytes(), Format::Obj, None).unwrap();
        assert_eq!(texturing.materials, []);
        texturing.notes
    };
    let note = "material libraries not read: there is no folder to look for them in";
    assert_eq!(notes(&format!("mtllib a.mtl\n{QUAD}{FACES}")), [note]);
    assert_eq!(notes(&format!("{QUAD}f 1 2 3\n")), [""; 0]);
}

/// A PNG of one colour, opaque or not.
fn plain(texel: [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&texel.repeat(4)).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Blender writes normal maps as `map_Bump`, others heights.
#[test]
fn a_bump_map_that_is_a_normal_map_is_read_as_one() {
    let obj = format!("mtllib a.mtl\n{QUAD}{FACES}");
    let read = |library: &str| {
        let (upright, tilted) = (plain([128, 128, 255, 255]), plain([150, 110, 240, 255]));
        let height = plain([128, 128, 128, 255]);
        let files: [(&str, &[u8]); 5] = [
            ("a.obj", obj.as_bytes()),
            ("a.mtl", library.as_bytes()),
            ("up.png", &upright),
            ("tilted.png", &tilted),
            ("height.png", &height),
        ];
        let (texturing, _) = textured(&files);
        (texturing.materials[0].normal_texture, texturing.notes)
    };
    let (normal, notes) = read("newmtl Rock 1\nmap_Bump -bm 0.5 up.png\n");
    assert_eq!((normal.map(|t| t.strength), notes.len()), (Some(0.5), 0));
    for library in [
        "bump tilted.png\nnorm up.png",
        "norm up.png\nbump tilted.png",
    ] {
        let (normal, notes) = read(&format!("newmtl Rock 1\n{library}\n"));
        let first = usize::from(library.starts_with("bump"));
        assert_eq!(
            (normal.map(|t| t.image), notes.len()),
            (Some(first), 0),
            "{library}"
        );
    }
    let (normal, notes) =
        read("newmtl Rock 1\nmap_bump height.png\nnewmtl plain\nbump height.png\n");
    assert_eq!(normal, None);
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(
        notes[0].contains("map_Bump is passed over: it is a height"),
        "{notes:?}"
    );
}

#[test]
fn leaves_of_obj_are_cut_out_by_the_alpha_of_their_colour() {
    let obj = format!("mtllib a.mtl\n{QUAD}{FACES}");
    let read = |library: &str| {
        let leaf = plain([9, 90, 9, 0]);
        let files: [(&str, &[u8]); 4] = [
            ("a.obj", obj.as_bytes()),
            ("a.mtl", library.as_bytes()),
            ("leaf.png", &leaf),
            ("alpha.png", &leaf),
        ];
        let (texturing, _) = textured(&files);
        let material = &texturing.materials[0];
        (material.alpha, material.is_double_sided, texturing.notes)
    };
    let cut = (Alpha::Mask { cutoff: 0.5 }, true, Vec::new());
    assert_eq!(
        read("newmtl Rock 1\nmap_Kd leaf.png\nmap_d leaf.png\n"),
        cut
    );
    assert_eq!(
        read("newmtl Rock 1\nmap_d leaf.png\nmap_Kd leaf.png\n"),
        cut
    );
    let (alpha, _, notes) = read("newmtl Rock 1\nmap_Kd leaf.png\nmap_d alpha.png\n");
    assert_eq!((alpha, notes.len()), (Alpha::Opaque, 1));
    assert!(notes[0].contains("alpha.png is passed over"), "{notes:?}");
}

/// What is open is not known then, and not that nothing is.
#[test]
fn opacity_in_images_that_are_not_read_is_unread() {
    let obj = format!("mtllib a.mtl\n{QUAD}{FACES}");
    for (library, is_unread) in [
        ("map_Kd leaf.png\nmap_d leaf.png", false),
        ("map_Kd leaf.png\nmap_d alpha.png", true),
        ("map_Kd gone.png\nmap_d gone.png", true),
        ("map_Kd gone.png", false),
    ] {
        let (leaf, library) = (plain([9, 90, 9, 0]), format!("newmtl Rock 1\n{library}\n"));
        let files: [(&str, &[u8]); 3] = [
            ("a.obj", obj.as_bytes()),
            ("a.mtl", library.as_bytes()),
            ("leaf.png", &leaf),
        ];
        let (texturing, _) = textured(&files);
        let unread = texturing.materials[0].unread_opacity.is_some();
        assert_eq!(unread, is_unread, "{library}");
    }
    for (mode, is_unread) in [("MASK", true), ("BLEND", true), ("OPAQUE", false)] {
        let mut doc = Doc::new();
        let positions = doc.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        doc.json["materials"] = json!([{
            "name": "leaf", "alphaMode": mode, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        }]);
        doc.json["textures"] = json!([{"source": 0}]);
        doc.json["images"] = json!([{"uri": "gone.png"}]);
        let primitive = json!({"attributes": {"POSITION": positions}, "material": 0});
        doc.show(primitive, json!({}));
        let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
        let unread = texturing.materials[0].unread_opacity.as_deref();
        let expected = is_unread.then_some("the image of material leaf");
        assert_eq!(unread, expected, "{mode}");
    }
}

#[test]
fn what_gltf_names_and_does_not_have_is_told() {
    let mut doc = Doc::new();
    let positions = doc.positions(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    doc.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 7}}}]);
    let primitive =
        |material: u32| json!({"attributes": {"POSITION": positions}, "material": material});
    doc.json["meshes"] = json!([{"primitives": [primitive(0), primitive(9)]}]);
    doc.json["nodes"] = json!([{"mesh": 0}]);
    doc.json["scenes"] = json!([{"nodes": [0]}]);
    let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
    let expected = [
        "a part is made of material 9, and the file has 1",
        "the base colour texture is passed over: it is number 7, and the file has 0",
    ];
    assert_eq!(texturing.notes.len(), 2, "{:?}", texturing.notes);
    let mut pairs = texturing.notes.iter().zip(expected);
    assert!(
        pairs.all(|(note, start)| note.starts_with(start)),
        "{:?}",
        texturing.notes
    );
}

#[test]
fn each_tile_of_udim_has_its_image() {
    // Two triangles in the first tile, one in the one to its right, and one in the one above that.
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 1.1 0.1\nvt 1.9 0.1\nvt 1.9 0.9\n\
                   vt 1.1 1.1\nvt 1.9 1.1\nvt 1.9 1.9\nvt 12.1 0.1\nvt 12.9 0.1\nvt 12.9 0.9\n";
    let faces = "usemtl Rock\nf 1/1 2/2 3/3\nf 1/3 3/2 4/1\nf 1/4 2/5 3/6\nf 1/7 2/8 3/9\nf 1/10 2/11 3/12\nusemtl Other\nf 1/1 2/2 3/3\n";
    let obj = format!("mtllib a.mtl\n{corners}{faces}");
    let library = "newmtl Rock\nKd 0.5 0.5 0.5\nmap_Kd rock.<UDIM>.png\nnorm -bm 2 n<udim>.png\nnewmtl Other\n";
    let [first, second, up] = [[200, 0, 0, 255], [0, 200, 0, 255], [128, 128, 255, 255]].map(plain);
    let files: [(&str, &[u8]); 5] = [
        ("a.obj", obj.as_bytes()),
        ("a.mtl", library.as_bytes()),
        ("rock.1001.png", &first),
        ("rock.1002.png", &second),
        ("n1012.png", &up),
    ];
    let (texturing, _) = textured(&files);
    let of =
        |triangle: usize| &texturing.materials[texturing.material_of[triangle].unwrap() as usize];
    let color = |triangle: usize| {
        let texture = of(triangle).base_color_texture?;
        Some((&texturing.images[texture.image][..], texture.transform))
    };
    let moved = |u: f64, v: f64| [[1.0, 0.0, u], [0.0, 1.0, v]];
    assert_eq!(color(0), Some((&first[..], moved(0.0, 0.0))));
    assert_eq!(color(1), color(0));
    assert_eq!(color(2), Some((&second[..], moved(-1.0, 0.0))));
    // What is not there leaves the colour that the library says.
    assert_eq!((color(3), of(3).base_color), (None, [0.5; 3]));
    let normal = of(3).normal_texture.unwrap();
    assert_eq!((normal.strength, normal.transform), (2.0, moved(-1.0, 1.0)));
    assert_eq!((color(4), color(5)), (None, None));
    let told = texturing.notes.join("\n");
    for note in [
        "rock.1012.png is passed over",
        "n1001.png is passed over",
        "1 triangle is in no tile",
    ] {
        assert!(told.contains(note), "{note}: {told}");
    }
}
