//! Which flags give each place of a mesh texels of its own, and the second set of UVs.

use thallus::substrate::{Division, Texturing, load_textured};

use super::*;

/// What `check` says that maps of a mesh would be.
fn maps(desk: &Desk, mesh: &str) -> (Value, String) {
    let output = desk
        .call("check", &format!("{mesh} --json"))
        .output()
        .unwrap();
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let output = desk.call("check", mesh).output().unwrap();
    (
        answer["maps"].clone(),
        said(&output) + &String::from_utf8_lossy(&output.stdout),
    )
}

#[test]
fn check_says_which_flags_give_each_place_texels_of_its_own() {
    let desk = desk();
    let (found, told) = maps(&desk, "parts.obj");
    assert_eq!(found["flags"], "--each object");
    assert_eq!(
        (&found["images"], &found["overlapping"]),
        (&3.into(), &0.0.into())
    );
    assert!(
        found["overlapping_without"].as_f64().unwrap() > 0.5,
        "{found}"
    );
    assert!(
        told.contains("maps          bake with --each object: no place shares texels with another, where without that"),
        "{told}"
    );
    let (found, told) = maps(&desk, "rock.obj");
    assert!(found.is_null() && !told.contains("  maps "), "{told}");
    // What repeats its image has no maps; one of two sets of coordinates may be without overlaps.
    let floor = "v 0 0 0\nv 0 0 1\nv 1 0 1\nvt 0 0\nvt 0 7\nvt 7 7\nf 1/1 2/2 3/3\n";
    fs::write(desk.path("floor.obj"), floor).unwrap();
    let (found, told) = maps(&desk, "floor.obj");
    assert!(found.is_null(), "{found}");
    assert!(
        told.contains("maps          none: triangle 0 is 7.00 images wide"),
        "{told}"
    );
    let half = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nvt 0 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3\nf 1/1 3/1 4/1\n";
    fs::write(desk.path("half.obj"), half).unwrap();
    let (found, told) = maps(&desk, "half.obj");
    assert_eq!(found["triangles_not_shown"], 1);
    assert!(
        told.contains("; 1 triangle is in no map, and --unwrap has a place for it;"),
        "{told}"
    );
    // Of one material a part repeats its image; by objects none does.
    let square = |x: u32| {
        let right = x + 1;
        format!(
            "v {x} 0 0\nv {x} 0 1\nv {right} 0 1\nv {right} 0 0\nf -4/1 -3/2 -2/3\nf -4/1 -2/3 -1/4\n"
        )
    };
    let corners = "vt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n";
    let many: String = (0..40)
        .map(|k| format!("o leaf{k}\nusemtl Leaf\n{}", square(2 * k + 2)))
        .collect();
    let branch = format!("{corners}o bark\nusemtl Bark\n{}{many}", square(0));
    fs::write(desk.path("branch.obj"), branch).unwrap();
    let (found, told) = maps(&desk, "branch.obj");
    assert_eq!(
        (&found["flags"], &found["parts_unfit"]),
        (&"--each object".into(), &0.into())
    );
    assert!(!told.contains("can have none"), "{told}");
    put_two_sets(&desk, "two.gltf");
    let (found, _) = maps(&desk, "two.gltf");
    assert_eq!(
        (&found["flags"], &found["overlapping"]),
        (&"--uv-set 1".into(), &0.0.into())
    );
}

/// Two squares beside each other, which share the first set of coordinates, and not the second.
fn put_two_sets(desk: &Desk, name: &str) {
    let square = |x: f32| {
        [
            [x, 0.0, 0.0],
            [x, 0.0, 1.0],
            [x + 1.0, 0.0, 1.0],
            [x + 1.0, 0.0, 0.0],
        ]
    };
    let corners: Vec<[f32; 3]> = [square(0.0), square(2.0)].concat();
    let first = corners
        .iter()
        .map(|[x, _, z]| [(x % 2.0).min(1.0) * 0.9, z * 0.9]);
    let second = corners.iter().map(|[x, _, z]| [x / 3.0, *z]);
    let uvs: Vec<[f32; 2]> = first.chain(second).collect();
    let numbers = corners.as_flattened().iter().chain(uvs.as_flattened());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    let indices = [0u16, 4].map(|k| [k, k + 1, k + 2, k, k + 2, k + 3]);
    bytes.extend(indices.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    fs::write(desk.path("two.bin"), bytes).unwrap();
    let document = json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2}, "indices": 3,
        }]}],
        "accessors": [
            accessor(0, 5126, 8, "VEC3"), accessor(1, 5126, 8, "VEC2"), accessor(2, 5126, 8, "VEC2"),
            accessor(3, 5123, 12, "SCALAR"),
        ],
        "bufferViews": [view(0, 96), view(96, 64), view(160, 64), view(224, 24)],
        "buffers": [{"uri": "two.bin", "byteLength": 248}],
    });
    fs::write(desk.path(name), document.to_string()).unwrap();
}

#[test]
fn a_mask_may_be_laid_out_in_the_second_set_of_uvs() {
    let desk = desk();
    put_two_sets(&desk, "two.gltf");
    // In the second set the first square has u up to a third, and in the first both squares have it up to 0.9.
    fs::write(
        desk.path("left.png"),
        image(|u, _| f64::from(u8::from(u < 0.34))),
    )
    .unwrap();
    let words = "two.gltf --radius 0.01 --elements 300 --at random --colonies 8";
    let farthest = |folder: &str| {
        let elements = read_elements(&desk.path(folder).join("elements.ply")).unwrap();
        let along = elements.positions.iter().map(|p| p[0]);
        along.fold(0.0, f64::max)
    };
    let told = desk.done(&format!("{words} --mask left.png -o first"));
    assert!(told.contains("uv1:left.png is one in the second"), "{told}");
    assert!(farthest("first") > 2.0);
    let told = desk.done(&format!("{words} --mask uv1:left.png -o second"));
    assert!(!told.contains("two sets"), "{told}");
    assert!(farthest("second") < 1.01);
    desk.done("--recipe second -o again");
    desk.assert_same("again", "second");
    desk.done_on(
        2,
        &format!("{words} --elements 120 --mask uv1:left.png -o part")
            .replace("--elements 300 ", ""),
    );
    desk.done("--resume part --elements 300");
    desk.assert_same_elements("part", "second");
    // The same image in the other set is another mask.
    desk.fails(
        "--resume part --elements 310 --mask left.png",
        1,
        &["left.png", "is not the mask"],
    );
    desk.fails(
        "rock.obj --mask uv1:left.png -o none",
        1,
        &["uv1:left.png", "this mesh has none"],
    );
    desk.fails(
        "rock.obj --mask uv1:gone.png -o none",
        1,
        &["gone.png", "reading the mask failed"],
    );
}

#[test]
fn bake_proposes_flags_that_serve() {
    let desk = desk();
    put_two_sets(&desk, "two.gltf");
    desk.done("two.gltf --radius 0.01 --elements 100 --at random -o two");
    let bake = |words: &str| said(&desk.call("bake", words).output().unwrap());
    let told = bake("two -o first --size 64");
    assert!(
        told.contains("with --uv-set 1 no place of it shares texels"),
        "{told}"
    );
    let told = bake("two -o second --size 64 --uv-set 1");
    assert!(!told.contains("overlap"), "{told}");
    // One image for all tiles is repeated, and they are none of UDIM's.
    fs::write(desk.path("plaster.png"), image(|u, _| u)).unwrap();
    fs::write(
        desk.path("tiled.mtl"),
        "newmtl Plaster\nmap_Kd plaster.png\n",
    )
    .unwrap();
    let square = |x: u32| {
        let line = |[s, t]: [u32; 2]| format!("v {} 0 {t}\nvt {} {t}\n", x + s, x + s);
        let corners: String = [[0, 0], [0, 1], [1, 1], [1, 0]].map(line).concat();
        corners + "f -4/-4 -3/-3 -2/-2\nf -4/-4 -2/-2 -1/-1\n"
    };
    let squares: String = (0..3).map(square).collect();
    fs::write(
        desk.path("tiled.obj"),
        format!("mtllib tiled.mtl\nusemtl Plaster\n{squares}"),
    )
    .unwrap();
    desk.done("tiled.obj --radius 0.01 --elements 100 --at random -o tiled");
    let told = bake("tiled -o none --size 64");
    assert!(
        told.contains("a second set of UVs") && !told.contains("--each tile"),
        "{told}"
    );
}

/// Two squares with the same place in an image, a red one and a blue one, of one object, and both of `Stone`.
fn put_two_stones(desk: &Desk, name: &str) {
    put_two_sets(desk, name);
    let mut document: Value = serde_json::from_slice(&desk.read(name)).unwrap();
    document["nodes"][0]["name"] = "Both".into();
    document["materials"] = [[1, 0, 0, 1], [0, 0, 1, 1]]
        .map(|color| json!({"name": "Stone", "pbrMetallicRoughness": {"baseColorFactor": color}}))
        .to_vec()
        .into();
    let mut indices = accessor(3, 5123, 6, "SCALAR");
    document["accessors"][3] = indices.clone();
    indices["byteOffset"] = 12.into();
    document["accessors"][2] = indices;
    let primitive = |indices: u8, material: u8| {
        let attributes = json!({"POSITION": 0, "TEXCOORD_0": 1});
        json!({"attributes": attributes, "indices": indices, "material": material})
    };
    document["meshes"][0]["primitives"] = json!([primitive(3, 0), primitive(2, 1)]);
    fs::write(desk.path(name), document.to_string()).unwrap();
}

/// As glTF may have them: names are not unique there.
#[test]
fn materials_of_one_name_have_maps_of_their_own() {
    let desk = desk();
    put_two_stones(&desk, "stones.gltf");
    let (found, told) = maps(&desk, "stones.gltf");
    assert_eq!(
        (&found["flags"], &found["images"]),
        (&"--each material".into(), &2.into()),
        "{told}"
    );
    desk.done("stones.gltf --radius 0.01 --elements 200 --at random --colonies 8 -o out");
    let words = "out -o maps --size 64 --each material --format exr";
    let done = desk.call("bake", words).output().unwrap();
    assert!(
        done.status.success() && !said(&done).contains("overlap"),
        "{}",
        said(&done)
    );
    assert!(desk.path("maps/Stone_mask.exr").exists());
    assert!(desk.path("maps/Stone_2_mask.exr").exists());
    let (loaded, made) = load_textured(&desk.path("maps/lichened.glb")).unwrap();
    let stones = Division::by_material(&made).unwrap();
    assert_eq!(stones.names(), ["Stone", "Stone_2"]);
    // Each as it was: red or blue, in the corner, where there is no triangle.
    let first_texel = |stone: usize| {
        let image = made.materials[stone].base_color_texture.unwrap().image;
        let decoder = ::png::Decoder::new(std::io::Cursor::new(&made.images[image]));
        let mut reader = decoder.read_info().unwrap();
        let mut texels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut texels).unwrap();
        [texels[0], texels[1], texels[2]]
    };
    assert_eq!([0, 1].map(first_texel), [[255, 0, 0], [0, 0, 255]]);
    assert_eq!(loaded.soup.triangles.len(), 4);
    // What is proposed is a name of the file, unless nothing were left then.
    let mut bytes = desk.read("two.bin");
    for corner in [6, 7] {
        bytes.splice(96 + 8 * corner..100 + 8 * corner, 7f32.to_le_bytes());
    }
    let whole = desk.read("two.bin");
    fs::write(desk.path("two.bin"), bytes).unwrap();
    let bake = |words: &str| {
        let words = format!("out -o none --size 64 --each material {words}");
        said(&desk.call("bake", &words).output().unwrap())
    };
    let told = bake("");
    assert!(
        told.contains("material 'Stone_2'") && !told.contains("--only"),
        "{told}"
    );
    let text = String::from_utf8(desk.read("stones.gltf")).unwrap();
    let one = text.replacen(r#""Stone""#, r#""Moss""#, 1);
    fs::write(desk.path("one.gltf"), one).unwrap();
    let told = bake("--mesh one.gltf");
    assert!(
        told.contains("material 'Stone' (to do without it: --only 'material:!Stone')"),
        "{told}"
    );
    fs::write(desk.path("two.bin"), whole).unwrap();
    // Both are meant by the one name.
    let words = "out -o none --size 64 --each object --only material:Stone";
    let both = desk.call("bake", words).output().unwrap();
    assert!(
        both.status.success() && said(&both).contains("'Both': 4 triangles overlap"),
        "{}",
        said(&both)
    );
}

/// Two materials, each with the whole second set of coordinates, in which an image lies that they share.
#[test]
fn a_second_set_of_uvs_may_be_of_each_material() {
    let desk = desk();
    put_two_stones(&desk, "stones.gltf");
    let mut document: Value = serde_json::from_slice(&desk.read("stones.gltf")).unwrap();
    // In the first set both squares are folded onto a line of the image, and in the second each has all of it.
    let mut bytes = desk.read("two.bin");
    bytes.splice(160..224, bytes[96..160].to_vec());
    for corner in 0..8 {
        let [u, repeated] = [
            bytes[160 + 8 * corner..164 + 8 * corner].to_vec(),
            7f32.to_le_bytes().to_vec(),
        ];
        let folded = if u == [0; 4] { u } else { repeated };
        bytes.splice(96 + 8 * corner..100 + 8 * corner, folded);
    }
    fs::write(desk.path("two.bin"), bytes).unwrap();
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.push(accessor(2, 5126, 8, "VEC2"));
    for primitive in document["meshes"][0]["primitives"].as_array_mut().unwrap() {
        primitive["attributes"]["TEXCOORD_1"] = 4.into();
    }
    fs::write(desk.path("stones.gltf"), document.to_string()).unwrap();
    let (found, told) = maps(&desk, "stones.gltf");
    assert_eq!(
        (&found["flags"], &found["overlapping"]),
        (&"--uv-set 1 --each material".into(), &0.0.into()),
        "{told}"
    );
    desk.done("stones.gltf --radius 0.01 --elements 200 --at random --colonies 8 -o out");
    let bake = |words: &str| said(&desk.call("bake", words).output().unwrap());
    let told = bake("out -o second --size 64 --uv-set 1");
    assert!(told.contains("with --each material no place"), "{told}");
    let told = bake("out -o each --size 64 --uv-set 1 --each material");
    assert!(
        !told.contains("overlap") && !told.contains("error"),
        "{told}"
    );
}

/// Pieces that each repeat an image, about tiles of their own, as a tree's do that is coloured by one strip of texels.
#[test]
fn flags_that_leave_most_parts_without_maps_are_no_advice() {
    let desk = desk();
    let square = |x: u32| {
        let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
        let line =
            |[s, t]: [u32; 2]| format!("v {} 0 {t}\nvt {} {}\n", 2 * x + s, x + 7 * s, 7 * t);
        corners.map(line).concat() + "f -4/-4 -3/-3 -2/-2\nf -4/-4 -2/-2 -1/-1\n"
    };
    let small = "v 0 1 0\nv 0 1 1\nv 1 1 1\nvt 0 0\nvt 0 0.5\nvt 0.5 0.5\nf -3/-3 -2/-2 -1/-1\n";
    let squares: String = (1..8).map(square).collect();
    fs::write(desk.path("tree.obj"), squares + small).unwrap();
    let (found, told) = maps(&desk, "tree.obj");
    assert!(found.is_null(), "{found}");
    assert!(
        told.contains(" is 7.00 images wide") && !told.contains("--each tile"),
        "{told}"
    );
    assert!(
        told.contains("; none of its layouts serves: bake with --unwrap"),
        "{told}"
    );
}

/// As lightmaps have it; what moves is left out.
#[test]
fn the_second_set_of_uvs_and_the_pose_are_in_the_glb() {
    let desk = desk();
    put_two_sets(&desk, "two.gltf");
    desk.done("two.gltf --radius 0.01 --elements 100 --at random -o two");
    let told = said(&desk.call("bake", "two -o maps --size 64").output().unwrap());
    assert!(!told.contains("skeletons"), "{told}");
    let sorted = |texturing: &Texturing, second: bool| {
        let sets = [&texturing.uvs, &texturing.second_uvs];
        let mut uvs: Vec<String> = sets[usize::from(second)]
            .iter()
            .map(|uvs| format!("{uvs:?}"))
            .collect();
        uvs.sort();
        uvs
    };
    let (_, before) = load_textured(&desk.path("two.gltf")).unwrap();
    let (_, made) = load_textured(&desk.path("maps/lichened.glb")).unwrap();
    assert_eq!(sorted(&made, false), sorted(&before, false));
    assert_eq!(sorted(&made, true), sorted(&before, true));
    assert_eq!(made.second_uvs.len(), 4);
    let mut document: Value = serde_json::from_slice(&desk.read("two.gltf")).unwrap();
    document["animations"] = json!([{"channels": [], "samplers": []}]);
    fs::write(desk.path("two.gltf"), document.to_string()).unwrap();
    let told = said(
        &desk
            .call("bake", "two -o maps --size 64 --force")
            .output()
            .unwrap(),
    );
    let note = "skeletons and animations are left out";
    assert_eq!(told.matches(note).count(), 1, "{told}");
}
