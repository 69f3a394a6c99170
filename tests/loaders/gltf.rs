//! glTF: scenes, transforms, primitives, accessors and buffers.

use super::gltf_doc::*;
use super::*;
use glam::DVec3;
use serde_json::json;
use thallus::substrate::load_textured;

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6)
}

/// Normals are at right angles to the surface however that is stretched and mirrored; a file with too few has none.
#[test]
fn normals_go_with_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let slope = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, -1.0, 0.0]];
    for (count, scale) in [
        (3, [1.0, 1.0, 1.0]),
        (3, [-2.0, 1.0, 5.0]),
        (2, [1.0, 1.0, 1.0]),
    ] {
        let mut doc = Doc::new();
        let positions = doc.positions(&slope);
        let normals = doc.positions(&[[1.0, 1.0, 0.0]; 3][..count]);
        let attributes = json!({"POSITION": positions, "NORMAL": normals});
        doc.show(json!({"attributes": attributes}), json!({"scale": scale}));
        fs::write(&path, doc.glb()).unwrap();
        let (loaded, texturing) = load_textured(&path).unwrap();
        let [a, b, c] =
            loaded.soup.triangles[0].map(|v| DVec3::from(loaded.soup.positions[v as usize]));
        let across = (b - a).cross(c - a).normalize();
        match texturing.normals[..] {
            [Some(corners)] => assert!(
                count == 3
                    && corners
                        .iter()
                        .all(|n| n.as_dvec3().dot(across) > 1.0 - 1e-6),
                "{corners:?} at {across}"
            ),
            ref others => assert!(count == 2 && others.is_empty(), "{others:?}"),
        }
    }
}

#[test]
fn transforms_compose_down_the_hierarchy() {
    let mut doc = tetrahedron(json!({"translation": [1, 2, 3]}));
    // A quarter turn about z, and twice the size, above it.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    doc.push(
        "nodes",
        json!({"children": [0], "rotation": [0, 0, half, half], "scale": [2, 2, 2]}),
    );
    let soup = doc.load();
    assert!(
        close(soup.positions[0], [-4.0, 2.0, 6.0]),
        "{:?}",
        soup.positions
    );
    assert!(
        close(soup.positions[1], [-4.0, 4.0, 6.0]),
        "{:?}",
        soup.positions
    );
    assert!((volume(&soup) - 8.0).abs() < 1e-5);
}

#[test]
fn mirrored_and_uneven_transforms_keep_the_outside_outside() {
    let mirror = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    let nodes = [
        json!({"scale": [-2, 1, 3]}),
        json!({"scale": [-1, -1, -1]}),
        json!({"matrix": mirror}),
        json!({"scale": [-1, -2, 1]}),
        json!({}),
    ];
    for (node, expected) in nodes.into_iter().zip([6.0, 1.0, 1.0, 2.0, 1.0]) {
        let found = volume(&tetrahedron(node.clone()).load());
        assert!((found - expected).abs() < 1e-9, "{node}: {found}");
    }
}

#[test]
fn a_mesh_that_two_nodes_show_is_there_twice() {
    let mut doc = tetrahedron(json!({}));
    doc.push("nodes", json!({"mesh": 0, "translation": [10, 0, 0]}));
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 8);
    assert_eq!(soup.positions[5], [11.0, 0.0, 0.0]);
}

#[test]
fn vertices_that_no_triangle_uses_need_no_position() {
    let placed = |unused: u16| {
        let mut corners = CORNERS.to_vec();
        corners.insert(usize::from(unused), [f32::NAN, 0.0, f32::INFINITY]);
        let solid = SOLID.map(|i| i + u16::from(i >= unused));
        let mut doc = tetrahedron(json!({}));
        let (position, indices) = (doc.positions(&corners), doc.indices(&solid));
        let primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        doc.show(primitive, json!({"translation": [5, 0, 0]}));
        doc
    };
    let soup = placed(2).load();
    let note = "1 unused vertex without a finite position ignored";
    assert_eq!(
        (soup.triangles.len(), &soup.notes[..]),
        (8, &[note.to_owned()][..])
    );
    assert_eq!(soup.positions[4 + 2], [0.0; 3]);

    let mut used = placed(2);
    let indices = used.indices(&[0, 1, 2]);
    used.json["meshes"][1]["primitives"][0]["indices"] = json!(indices);
    let said = used.refused();
    assert_says(
        &said,
        &[
            "node 1",
            "accessor 2, vertex 2",
            "(NaN, NaN, NaN) is not finite",
        ],
    );
}

#[test]
fn shared_points_of_instances_stay_equal_and_far_offsets_cost_nothing() {
    let mut doc = tetrahedron(json!({"translation": [0.1, 0.2, 0.3], "scale": [0.3, 0.3, 0.3]}));
    doc.push(
        "nodes",
        json!({"mesh": 0, "translation": [0.4, 0.2, 0.3], "scale": [0.3, 0.3, 0.3]}),
    );
    let soup = doc.load();
    assert_eq!(soup.positions[1], soup.positions[4]);
    // Geocentric: single precision would be half a metre here.
    let far =
        tetrahedron(json!({"translation": [4_510_731.123, -2_703_000.5, 5_000_000.25]})).load();
    let edge: Vec<f64> = (0..3)
        .map(|k| far.positions[1][k] - far.positions[0][k])
        .collect();
    assert!(
        (edge[0] - 1.0).abs() < 1e-6 && edge[1].abs() < 1e-6,
        "{edge:?}"
    );
    assert!((far.positions[0][0] - 4_510_731.123).abs() < 1e-6);
}

#[test]
fn only_the_default_scene_is_read() {
    let mut doc = tetrahedron(json!({}));
    doc.push("nodes", json!({"mesh": 0}));
    assert_eq!(doc.load().triangles.len(), 8);
    doc.json["scenes"] = json!([{"nodes": [0, 1]}, {"nodes": [1]}]);
    assert_eq!(doc.load().triangles.len(), 8);
    doc.json["scene"] = json!(1);
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 4);
    assert_eq!(soup.notes, ["one of 2 scenes read"]);
}

#[test]
fn lists_strips_and_fans_wind_as_the_specification_says() {
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let cases = [
        (4, vec![0, 1, 2, 1, 3, 2, 0], vec![[0, 1, 2], [1, 3, 2]]),
        (5, vec![0, 1, 2, 3], vec![[0, 1, 2], [1, 3, 2]]),
        (6, vec![0, 1, 3, 2], vec![[0, 1, 3], [0, 3, 2]]),
    ];
    for (mode, order, expected) in cases {
        let mut doc = Doc::new();
        let (position, indices) = (doc.positions(&square), doc.indices(&order));
        doc.show(
            json!({"attributes": {"POSITION": position}, "indices": indices, "mode": mode}),
            json!({}),
        );
        let soup = doc.load();
        assert_eq!(soup.triangles, expected);
        assert!(soup.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| soup.positions[i as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
        }));
        assert_eq!(soup.notes.len(), usize::from(mode == 4), "{:?}", soup.notes);
    }
}

#[test]
fn primitives_may_lack_indices_and_points_and_lines_are_noted() {
    let mut doc = Doc::new();
    let position = doc.positions(&CORNERS[..3]);
    doc.show(json!({"attributes": {"POSITION": position}}), json!({}));
    for mode in [0, 1, 2, 3] {
        doc.show(
            json!({"attributes": {"POSITION": position}, "mode": mode}),
            json!({}),
        );
    }
    doc.show(
        json!({"attributes": {"NORMAL": position}}),
        json!({"skin": 7}),
    );
    let soup = doc.load();
    assert_eq!(soup.triangles, [[0, 1, 2]]);
    let expected = [
        "1 point primitive ignored",
        "3 line primitives ignored",
        "1 primitive without positions ignored",
        "1 skinned mesh read at rest",
    ];
    assert_eq!(soup.notes, expected);
}

#[test]
fn indices_of_every_width() {
    type Write = fn(u16) -> Vec<u8>;
    let widths: [(u32, Write); 3] = [
        (U8, |i| vec![i as u8]),
        (U16, |i| i.to_le_bytes().to_vec()),
        (U32, |i| u32::from(i).to_le_bytes().to_vec()),
    ];
    for (component, write) in widths {
        let mut doc = Doc::new();
        let position = doc.positions(&CORNERS);
        let bytes: Vec<u8> = SOLID.iter().flat_map(|&i| write(i)).collect();
        let indices = doc.accessor(&bytes, component, "SCALAR", SOLID.len());
        doc.show(
            json!({"attributes": {"POSITION": position}, "indices": indices}),
            json!({}),
        );
        assert_eq!(volume(&doc.load()), 1.0);
    }
}

#[test]
fn interleaved_positions_are_found_by_their_stride() {
    let mut doc = tetrahedron(json!({}));
    let mut bytes = vec![0xFF; 8];
    for (i, corner) in CORNERS.iter().enumerate() {
        bytes.extend(floats(&[*corner]));
        // The last element has nothing behind it.
        if i < 3 {
            bytes.extend([0xEE; 8]);
        }
    }
    let view = doc.view(&bytes);
    doc.json["bufferViews"][view]["byteStride"] = json!(20);
    doc.json["accessors"][0]["bufferView"] = json!(view);
    doc.json["accessors"][0]["byteOffset"] = json!(8);
    assert_eq!(volume(&doc.load()), 1.0);
}

#[test]
fn sparse_accessors_replace_elements_with_and_without_a_base() {
    let mut doc = tetrahedron(json!({}));
    let (at, values) = (
        doc.view(&[1, 3]),
        doc.view(&floats(&[[2.0, 0.0, 0.0], [0.0, 0.0, 5.0]])),
    );
    let sparse = json!({"count": 2, "values": {"bufferView": values},
                        "indices": {"bufferView": at, "componentType": U8}});
    doc.json["accessors"][0]["sparse"] = sparse;
    assert_eq!(volume(&doc.load()), 10.0);
    doc.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    let soup = doc.load();
    assert_eq!(
        soup.positions,
        [[0.0; 3], [2.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 5.0]]
    );
    let at = doc.view(&[1, 4]);
    doc.json["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(at);
    assert_says(
        &doc.refused(),
        &["accessor 0", "sparse index 4, but 4 elements"],
    );
}

#[test]
fn quantized_positions_are_dequantized_as_the_specification_says() {
    let cases: [(u32, bool, &[u8], f64); 8] = [
        (I8, false, &[0x80], -128.0),
        (I8, true, &[0x80], -1.0),
        (I8, true, &[127], 1.0),
        (U8, true, &[51], 0.2),
        (I16, false, &[0, 0x80], -32768.0),
        (I16, true, &[0, 0x80], -1.0),
        (U16, false, &[0xFF, 0xFF], 65535.0),
        (U16, true, &[0xFF, 0xFF], 1.0),
    ];
    for (component, normalized, value, expected) in cases {
        let mut doc = Doc::new();
        let zero = vec![0; value.len()];
        let vertices: Vec<u8> = [
            [value, &zero, &zero],
            [&zero, value, &zero],
            [&zero, &zero, value],
        ]
        .iter()
        .flat_map(|v| [v.concat(), vec![0; value.len()]].concat())
        .collect();
        let position = doc.accessor(&vertices, component, "VEC3", 3);
        doc.json["bufferViews"][0]["byteStride"] = json!(4 * value.len());
        doc.json["accessors"][0]["normalized"] = json!(normalized);
        doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        doc.show(json!({"attributes": {"POSITION": position}}), json!({}));
        let soup = doc.load();
        let expected = f64::from(expected as f32);
        assert_eq!(soup.positions[0], [expected, 0.0, 0.0]);
        assert_eq!(soup.positions[2], [0.0, 0.0, expected]);
        assert_eq!(soup.notes, Vec::<String>::new());
    }
}

#[test]
fn gpu_instances_are_all_there() {
    let mut doc = tetrahedron(json!({"scale": [2, 2, 2]}));
    let translation = doc.positions(&[[0.0; 3], [5.0, 0.0, 0.0]]);
    let scale = doc.positions(&[[1.0; 3], [1.0, -1.0, 1.0]]);
    // Normalized shorts; unnormalized length is forgiven.
    let turns: Vec<u8> = [[0_i16, 0, 0, 32767], [0, 0, 16384, 16384]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let rotation = doc.accessor(&turns, I16, "VEC4", 2);
    doc.json["accessors"][rotation]["normalized"] = json!(true);
    let attributes = json!({"TRANSLATION": translation, "SCALE": scale, "ROTATION": rotation});
    doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] =
        json!({"attributes": attributes});
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 8);
    assert!((volume(&soup) - 16.0).abs() < 1e-5, "{}", volume(&soup));
    assert!(
        close(soup.positions[5], [10.0, 2.0, 0.0]),
        "{:?}",
        soup.positions
    );
    doc.json["accessors"][scale]["count"] = json!(1);
    assert_says(
        &doc.refused(),
        &["node 0", "EXT_mesh_gpu_instancing", "differ in count"],
    );
}

/// Nothing below a hidden node is seen, whatever it says itself.
#[test]
fn hidden_nodes_are_passed_over() {
    let mut doc = tetrahedron(json!({}));
    let hidden = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
    let mesh = doc.json["nodes"][0]["mesh"].clone();
    let child = doc.push("nodes", json!({"mesh": mesh, "extensions": hidden(true)}));
    let folder = json!({"children": [child], "extensions": hidden(false)});
    let folder = doc.push("nodes", folder);
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 4);
    assert_says(&soup.notes.join("; "), &["1 mesh of a hidden node"]);
    doc.json["nodes"][folder]["extensions"] = json!({"KHR_node_visibility": {}});
    assert_eq!(doc.load().triangles.len(), 8);
    doc.json["nodes"][folder]["extensions"] = hidden(false);
    doc.json["nodes"][0]["extensions"] = hidden(false);
    assert_says(&doc.refused(), &["2 meshes of hidden nodes"]);
}

#[test]
fn buffers_come_from_the_chunk_from_data_uris_and_from_files() {
    let doc = tetrahedron(json!({}));
    let expected = doc.load();
    let uri = format!("data:application/octet-stream;base64,{}", base64(&doc.bin));
    assert_eq!(
        parse_soup(&doc.with_uri(&uri), Format::Gltf, None)
            .unwrap()
            .soup,
        expected
    );

    let escaped: String = doc.bin.iter().map(|b| format!("%{b:02x}")).collect();
    let base64 = base64(&doc.bin);
    for uri in [
        format!("data:application/octet-stream,{escaped}"),
        format!("data:,{escaped}"),
        format!("data:application/octet-stream;base64;x=1,{base64}"),
    ] {
        let found = parse_soup(&doc.with_uri(&uri), Format::Gltf, None);
        assert_eq!(found.unwrap().soup, expected, "{uri}");
    }

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b%é.bin"), &doc.bin).unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, doc.with_uri("a%20b%25%C3%A9.bin")).unwrap();
    let loaded = load_soup(&path).unwrap();
    assert_eq!(loaded.soup, expected);
    let mut hasher = blake3::Hasher::new();
    hasher
        .update(&std::fs::read(&path).unwrap())
        .update(&doc.bin);
    assert_eq!(loaded.hash, hasher.finalize().to_hex().to_string());
}

/// As the specification allows, and for members with one name asks.
#[test]
fn whole_numbers_may_have_a_point_or_an_exponent_and_the_last_of_equal_names_counts() {
    let doc = tetrahedron(json!({"translation": [0.5, 0, 0]}));
    let uri = format!("data:application/octet-stream;BASE64,{}", base64(&doc.bin));
    let plain = String::from_utf8(doc.with_uri(&uri)).unwrap();
    let expected = parse_soup(plain.as_bytes(), Format::Gltf, None)
        .unwrap()
        .soup;
    let count = plain.find("\"count\":").unwrap() + 8;
    let digits = plain[count..].find(|c: char| !c.is_ascii_digit()).unwrap();
    let number: u32 = plain[count..count + digits].parse().unwrap();
    for form in [
        format!("{number}.0"),
        format!("{}e0", f64::from(number)),
        format!("{number},\"count\":{number}"),
        format!("99,\"count\":{number}"),
    ] {
        let text = format!("{}{form}{}", &plain[..count], &plain[count + digits..]);
        let found = parse_soup(text.as_bytes(), Format::Gltf, None);
        assert_eq!(found.unwrap().soup, expected, "{form}");
    }
    let text = format!("{}{number}.5{}", &plain[..count], &plain[count + digits..]);
    assert_says(
        &refused(text, Format::Gltf),
        &["JSON line 1", "floating point"],
    );
}

#[test]
fn matrices_may_have_round_off_in_their_last_row() {
    let expected = tetrahedron(json!({"translation": [1, 2, 3]})).load();
    for (skew, w) in [
        (0.0, 1.0),
        (1e-17, 1.0),
        (0.0, 0.999_999_999_999_999_9),
        (-1e-9, 1.0),
    ] {
        let matrix = [
            1.0, 0.0, 0.0, skew, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 3.0, w,
        ];
        let soup = tetrahedron(json!({"matrix": matrix})).load();
        for (a, b) in soup.positions.iter().zip(&expected.positions) {
            assert!(close(*a, *b), "{skew} {w}: {a:?} for {b:?}");
        }
    }
}

#[test]
fn a_buffer_may_be_named_as_its_file_is() {
    let doc = tetrahedron(json!({}));
    let expected = doc.load();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    let names = ["100%.bin", "l%20it.bin", "q?v=2.bin"];
    // Windows has no files with a question mark.
    for name in names
        .iter()
        .filter(|name| !cfg!(windows) || !name.contains('?'))
    {
        std::fs::write(folder.path().join(name), &doc.bin).unwrap();
        std::fs::write(&path, doc.with_uri(name)).unwrap();
        assert_eq!(load_soup(&path).unwrap().soup, expected, "{name}");
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    // As Windows has it.
    std::fs::create_dir(folder.path().join("my buffers")).unwrap();
    std::fs::write(folder.path().join("my buffers/b.bin"), &doc.bin).unwrap();
    for name in [
        "my buffers\\b.bin",
        "my%20buffers%5cb.bin",
        ".\\my buffers/b.bin",
    ] {
        std::fs::write(&path, doc.with_uri(name)).unwrap();
        assert_eq!(load_soup(&path).unwrap().soup, expected, "{name}");
    }
    let escaped: String = base64(&doc.bin)
        .replace('/', "%2F")
        .replace('+', "%2B")
        .replace('=', "%3D");
    let uri = format!("data:application/octet-stream;base64,{escaped}");
    assert_eq!(
        parse_soup(&doc.with_uri(&uri), Format::Gltf, None)
            .unwrap()
            .soup,
        expected
    );
}

#[test]
fn missing_and_short_buffers_are_named() {
    let doc = tetrahedron(json!({}));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, doc.with_uri("gone.bin")).unwrap();
    let error = load_soup(&path).unwrap_err();
    assert!(matches!(error.fault, LoadFault::Unreadable { .. }));
    assert_says(
        &error.to_string(),
        &["scene.gltf: buffer 0", "gone.bin", "beside the glTF file"],
    );

    std::fs::write(folder.path().join("gone.bin"), &doc.bin[1..]).unwrap();
    assert_says(
        &load_soup(&path).unwrap_err().to_string(),
        &["buffer 0", "cut short"],
    );

    let cases = [
        ("https://example.org/a.bin", "lies elsewhere"),
        ("data:;base64,????", "not valid base64"),
        ("data:,%zz", "percent sign in its data URI"),
        ("data:;base64", "data URI has no comma"),
        ("a.bin", "external file"),
        ("%zz.bin", "external file"),
    ];
    for (uri, problem) in cases {
        let error = parse_soup(&doc.with_uri(uri), Format::Gltf, None)
            .unwrap_err()
            .to_string();
        assert_says(&error, &["accessor 0", "buffer 0", problem]);
    }
}

#[test]
fn materials_and_unknown_extensions_do_not_stop_a_load() {
    let mut doc = tetrahedron(json!({}));
    doc.json["materials"] = json!([{"alphaMode": "STRANGE", "extensions": {"KHR_materials_x": 3}}]);
    doc.json["images"] = json!([{"uri": "gone.ktx2"}]);
    doc.json["extensionsRequired"] =
        json!(["KHR_materials_unlit", "KHR_texture_basisu", "ACME_warp"]);
    let soup = doc.load();
    assert_eq!(volume(&soup), 1.0);
    assert_eq!(
        soup.notes,
        ["the file requires the extension 'ACME_warp', which was not applied"]
    );
}

/// They may be anywhere, and would make the middle of the scene theirs.
#[test]
fn vertices_that_no_triangle_uses_cost_no_precision_far_from_the_origin() {
    let far = json!({"translation": [6_378_137.25, 10, 20]});
    let show = |stray: &[[f32; 3]]| {
        let mut doc = Doc::new();
        let corners = CORNERS.map(|corner| corner.map(|x| 0.3 * x));
        let position = doc.positions(&[&corners, stray].concat());
        let indices = doc.indices(&SOLID);
        let primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        doc.show(primitive, far.clone());
        doc.load()
    };
    let expected = corners(&show(&[]));
    for stray in [
        [-6_378_137.0, 0.0, 0.0],
        [f32::NAN; 3],
        [f32::MAX, -f32::MAX, f32::INFINITY],
    ] {
        let soup = show(&[stray]);
        assert_eq!(corners(&soup), expected, "{stray:?}");
        assert!(soup.positions.as_flattened().iter().all(|x| x.is_finite()));
    }
}
