//! Squares in layouts: what lies beyond them, colours, pictures, and what cannot be baked.

use thallus::substrate::{Division, Part};

use super::*;

/// A square of two triangles for each list of UVs.
pub(super) fn squares(uvs: &[[[f64; 2]; 4]]) -> String {
    let mut text = String::new();
    for (i, uv) in uvs.iter().enumerate() {
        for (k, [u, v]) in uv.iter().enumerate() {
            let [x, z] = [[0, 0], [0, 1], [1, 1], [1, 0]][k];
            writeln!(text, "v {} 0 {}\nvt {u} {v}", 3 * i + x, z).unwrap();
        }
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| 4 * i + k);
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}").unwrap();
    }
    text
}

pub(super) fn square(low: f64, high: f64) -> [[f64; 2]; 4] {
    [[low, low], [low, high], [high, high], [high, low]]
}

#[test]
fn beyond_the_gutter_is_the_mean_of_the_stone() {
    let (substrate, texturing) = written(&squares(&[square(0.2, 0.8)]), "square.obj");
    let growth = grow(&substrate, &recipe(0.01, 2), &Execution::default(), &mut ()).unwrap();
    let look = Look {
        cluster: &growth.cluster,
        shape: &Shape::default(),
        paint: &Paint::default(),
    };
    for base in [Base::Mesh, Base::Ground(Ground::Bark)] {
        let baker = Baker::new(&substrate, &texturing, &[look], &base, &settings(256, 1));
        let baker = baker.unwrap();
        let baked = baker.whole().unwrap();
        let color = |x, y| Vec3::from_array(baked.value(map("base_color"), x, y));
        let on_it = (0..128 * 128).map(|i| (64 + i % 128, 64 + i / 128));
        let bare = on_it.filter(|&(x, y)| baked.value(map("mask"), x, y)[0] == 0.0);
        let bare: Vec<Vec3> = bare.map(|(x, y)| color(x, y)).collect();
        let mean = bare.iter().sum::<Vec3>() / bare.len() as f32;
        assert!(bare.len() > 10_000);
        assert!(color(0, 0).distance(mean) < 0.02, "{} {mean}", color(0, 0));
        assert_eq!(color(0, 0), color(255, 3));
    }
}

#[test]
#[should_panic(expected = "column 64 of 64")]
fn there_is_no_texel_beyond_the_last_column() {
    let made = made();
    let baker = baker(&made, &settings(64, 1));
    baker.whole().unwrap().value(map("mask"), 64, 3);
}

/// Colours of vertices show between them, times the material's, and their mean beyond all triangles.
#[test]
fn colours_of_vertices_are_baked() {
    let uvs = [square(0.2, 0.8)];
    // Red rises along x.
    let painted = squares(&uvs).lines().fold(String::new(), |text, line| {
        let red = line
            .strip_prefix("v ")
            .map(|at| f32::from(at.starts_with('1')));
        let color = red.map_or(String::new(), |red| format!(" {red} 1 0.5"));
        text + line + &color + "\n"
    });
    let half = 0.214_041_14; // Linear light of sRGB 0.5.
    let (substrate, mut texturing) = written(&painted, "square.obj");
    let growth = grow(&substrate, &recipe(0.01, 2), &Execution::default(), &mut ()).unwrap();
    let look = Look {
        cluster: &growth.cluster,
        shape: &Shape::default(),
        paint: &Paint::default(),
    };
    // An image that is cut off leaves the colour that is said for that.
    let cut_off = thallus::substrate::Texture {
        image: 0,
        is_in_second: false,
        strength: 1.0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        wrap: Default::default(),
    };
    texturing.images = vec![b"\x89PNG\r\n\x1a\n".to_vec()];
    for (factor, texture) in [
        (None, None),
        (Some([0.5, 0.25, 1.0]), None),
        (Some([0.75, 0.5, 0.25]), Some(cut_off)),
    ] {
        if let Some(color) = factor {
            texturing.materials = vec![Material {
                base_color: texture.map_or(color, |_| [1.0; 3]),
                bare_color: color,
                base_color_texture: texture,
                ..plain()
            }];
            texturing.material_of = vec![Some(0); 2];
        }
        let [red, green, blue] = factor.unwrap_or([1.0; 3]);
        let baker = Baker::new(
            &substrate,
            &texturing,
            &[look],
            &Base::Mesh,
            &settings(256, 1),
        )
        .unwrap();
        let baked = baker.whole().unwrap();
        let color = |x, y| Vec3::from_array(baked.value(map("base_color"), x, y));
        let is_bare = |x, y| baked.value(map("mask"), x, y)[0] == 0.0;
        let mut seen = 0;
        for (x, y) in (60..196).flat_map(|x| [60, 100, 190].map(|y| (x, y))) {
            // The first corner is at the lower left, and z rises along v: x along u.
            let along = ((x as f32 + 0.5) / 256.0 - 0.2) / 0.6;
            let expected = Vec3::new(red * along, green, blue * half);
            if is_bare(x, y) {
                assert!(
                    color(x, y).distance(expected) < 1e-3,
                    "{x} {y}: {} {expected}",
                    color(x, y)
                );
                seen += 1;
            }
        }
        assert!(seen > 300, "{seen}");
        let mean = Vec3::new(red * 0.5, green, blue * half);
        assert!(color(0, 0).distance(mean) < 1e-2, "{} {mean}", color(0, 0));
    }
}

pub(super) fn plain() -> Material {
    Material {
        roughness: 1.0,
        ..Material::default()
    }
}

/// What a normal texture says is said in the axes of its image, however that lies on the surface.
#[test]
fn pictures_tilt_normals_as_the_image_lies() {
    // (0.6, 0, 0.8) to the right and (0, 0.6, 0.8) to the top.
    for (texel, [right, top]) in [([204, 128, 230], [0.6, 0.0]), ([128, 204, 230], [0.0, 0.6])] {
        let mut image = Vec::new();
        let mut encoder = png::Encoder::new(&mut image, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&texel).unwrap();
        drop(writer);
        for (turn, mirrored) in [(0, false), (1, false), (3, true), (2, true)] {
            let corner = |k: usize| square(0.1, 0.9)[(k + turn) % 4];
            let uvs: [[f64; 2]; 4] = std::array::from_fn(corner);
            let uvs = uvs.map(|[u, v]| if mirrored { [v, u] } else { [u, v] });
            let (substrate, mut texturing) = written(&squares(&[uvs]), "square.obj");
            let normal_texture = Some(thallus::substrate::Texture {
                image: 0,
                is_in_second: false,
                strength: 1.0,
                transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                wrap: Default::default(),
            });
            texturing.materials = vec![Material {
                normal_texture,
                ..plain()
            }];
            texturing.material_of = vec![Some(0); 2];
            texturing.images = vec![image.clone()];
            let looks = Appearance::new(&substrate, &texturing);
            // Along the edges from the first corner of the square: +z and +x.
            let [u0, v0] = uvs[0];
            let [[uz, vz], [ux, vx]] =
                [uvs[1], uvs[3]].map(|[u, v]| [(u - u0) / 0.8, (v - v0) / 0.8]);
            let expected = Vec3::new(
                right * ux as f32 + top * vx as f32,
                0.8,
                right * uz as f32 + top * vz as f32,
            );
            for triangle in [0, 1] {
                let coat = looks
                    .at(triangle, [0.2, 0.3, 0.5], [0.0, 1.0, 0.0])
                    .unwrap();
                let found = Vec3::from(coat.normal);
                assert!(
                    found.distance(expected) < 0.01,
                    "{turn} {mirrored}: {found} {expected}"
                );
                assert_eq!(coat.albedo, [1.0; 3]);
            }
        }
    }
}

fn bake_squares(text: &str) -> Result<(usize, [usize; 3]), BakeError> {
    let (substrate, texturing) = written(text, "squares.obj");
    let growth = grow(&substrate, &recipe(0.1, 3), &Execution::default(), &mut ()).unwrap();
    let look = Look {
        cluster: &growth.cluster,
        shape: &Shape::default(),
        paint: &Paint::default(),
    };
    let base = Base::Ground(Ground::Color([9, 9, 9]));
    let baker = Baker::new(&substrate, &texturing, &[look], &base, &settings(64, 1))?;
    let baked = baker.whole()?;
    let report = baked.report();
    let shared = report.overlaps;
    Ok((
        report.covered,
        [shared.texels, shared.triangles, report.not_shown],
    ))
}

#[test]
fn covered_and_shared_texels_are_counted() {
    let one = square(0.25, 0.75);
    assert_eq!(bake_squares(&squares(&[one])), Ok((32 * 32, [0, 0, 0])));
    let beyond = square(1.25, 1.75);
    assert_eq!(
        bake_squares(&squares(&[beyond])),
        Ok((32 * 32, [0, 0, 0])),
        "coordinates repeat"
    );
    // The middles on the diagonal are inside no triangle.
    let (_, [texels, triangles, _]) = bake_squares(&squares(&[one, one])).unwrap();
    assert_eq!((texels, triangles), (32 * 32 - 32, 4));
    let (covered, [texels, triangles, _]) =
        bake_squares(&squares(&[square(0.0, 0.5), square(0.375, 0.875)])).unwrap();
    assert_eq!(covered, 2 * 32 * 32 - 8 * 8);
    assert!(
        (49..=64).contains(&texels) && triangles >= 2,
        "{texels} {triangles}"
    );
    let flat = [[0.5, 0.5]; 4];
    assert_eq!(bake_squares(&squares(&[one, flat])).unwrap().1, [0, 0, 2]);
}

#[test]
fn layouts_a_little_wider_than_the_image_overlap_themselves() {
    let rounded = bake_squares(&squares(&[square(0.0, 1.00001)]));
    assert_eq!(rounded, Ok((64 * 64, [0, 0, 0])));
    let (covered, [texels, triangles, _]) = bake_squares(&squares(&[square(0.0, 1.018)])).unwrap();
    assert_eq!(covered, 64 * 64);
    // One texel along two sides.
    assert!((100..=260).contains(&texels), "{texels}");
    assert_eq!(triangles, 2);
    let error = bake_squares(&squares(&[square(0.0, 1.0501)])).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("1.06 images wide"), "{said}");
}

#[test]
fn layouts_that_cannot_be_baked_are_refused() {
    let without: String = squares(&[square(0.0, 1.0)]).replace("f 1/1 2/2 3/3 4/4", "f 1 2 3 4");
    assert_eq!(bake_squares(&without), Err(BakeError::NoUvs));
    let repeats = bake_squares(&squares(&[square(0.0, 5.0)]));
    assert!(matches!(repeats, Err(BakeError::Repeats { tiles, .. }) if tiles == 5.0));
    let stacked = bake_squares(&squares(&[square(0.0, 1.0); 33]));
    assert_eq!(stacked, Err(BakeError::Stacked { images: 33.0 }));
    for wrong in [
        Settings {
            size: 15,
            ..Settings::default()
        },
        Settings {
            size: 8193,
            ..Settings::default()
        },
        Settings {
            gutter: 1,
            ..Settings::default()
        },
        Settings {
            samples: 0,
            ..Settings::default()
        },
    ] {
        assert!(matches!(wrong.check(), Err(BakeError::Range { .. })));
    }
    assert_eq!(Settings::default().check(), Ok(()));
}

/// The same square with the same UVs in OBJ and, three ways, in PLY.
#[test]
fn uvs_are_read_from_every_format_that_has_them() {
    let uvs = [[0.125, 0.25], [0.125, 0.75], [0.5, 0.75], [0.5, 0.25]];
    let expected = |corners: [usize; 3]| Some(corners.map(|k| [uvs[k][0], 1.0 - uvs[k][1]]));
    let expected = [expected([0, 1, 2]), expected([0, 2, 3])];
    let obj = squares(&[uvs]);
    assert_eq!(written(&obj, "a.obj").1.uvs, expected);
    let negative = obj.replace("f 1/1 2/2 3/3 4/4", "f -4/-4 -3/-3 -2/-2 -1/-1");
    assert_eq!(written(&negative, "a.obj").1.uvs, expected);
    let half = obj.replace("f 1/1 2/2 3/3 4/4", "f 1/1 2/2 3/3\nf 1 3 4");
    assert_eq!(written(&half, "a.obj").1.uvs, [expected[0]]);
    let places = ["0 0 0", "0 0 1", "1 0 1", "1 0 0"];
    for [s, t] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let rows: String = (0..4)
            .map(|k| format!("{} {} {}\n", places[k], uvs[k][0], uvs[k][1]))
            .collect();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
             property float z\nproperty float {s}\nproperty float {t}\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n{rows}4 0 1 2 3\n"
        );
        assert_eq!(written(&text, "a.ply").1.uvs, expected, "{s} {t}");
    }
    let list: String = uvs.iter().map(|[u, v]| format!(" {u} {v}")).collect();
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
         property list uchar float texcoord\nend_header\n{}\n4 0 1 2 3 8{list}\n",
        places.join("\n")
    );
    assert_eq!(written(&text, "a.ply").1.uvs, expected);
}

/// Judging agrees with baking, by as much as an image of 512 texels tells less than one of 64 misses.
#[test]
fn a_layout_is_judged_as_it_is_baked() {
    let (low, high) = (square(0.05, 0.45), square(0.55, 0.95));
    for (uvs, few) in [
        (vec![low, high], true),
        (vec![low, low], false),
        (vec![low, square(0.25, 0.65)], false),
        (vec![square(1.05, 1.45), high], true),
        (vec![square(1.05, 1.45), low], false),
    ] {
        let (substrate, texturing) = written(&squares(&uvs), "squares.obj");
        let judged = judge(&substrate, &texturing, (None, None)).unwrap();
        let growth = grow(&substrate, &recipe(0.01, 2), &Execution::default(), &mut ());
        let made = Made {
            cluster: growth.unwrap().cluster,
            substrate,
            texturing,
        };
        let baker = baker(&made, &settings(256, 1));
        let report = baker.whole().unwrap().report();
        let covered = report.covered as f64;
        let shared = report.overlaps.texels as f64 / covered;
        assert!(
            (judged.overlapping - shared).abs() < 0.02,
            "{judged:?} {shared}"
        );
        assert_eq!(judged.overlapping == 0.0, few, "{judged:?}");
        let used = covered / report.texels as f64;
        assert!((judged.used - used).abs() < 0.02, "{judged:?} {used}");
        assert!((judged.side / (256.0 * report.texel) - 1.0).abs() < 0.02);
        assert_eq!((judged.images, judged.not_shown), (1, 0));
    }
}

/// Neighbours share their edges, and no texel is lost between them.
#[test]
fn a_fine_grid_uses_what_it_fills() {
    let mut text = String::new();
    let cells = 150;
    for (i, j) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j))) {
        let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(cells));
        writeln!(text, "v {u} 0 {v}\nvt {u} {v}").unwrap();
    }
    let at = |i: u32, j: u32| i * (cells + 1) + j + 1;
    for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}").unwrap();
    }
    let (substrate, texturing) = written(&text, "grid.obj");
    let judged = judge(&substrate, &texturing, (None, None)).unwrap();
    assert!(
        judged.used > 0.995 && judged.overlapping == 0.0,
        "{judged:?}"
    );
}

#[test]
fn parts_of_a_division_are_judged_apart() {
    let low = square(0.1, 0.9);
    let flat = [[0.5, 0.5]; 4];
    let (substrate, mut texturing) = written(&squares(&[low, low, flat]), "squares.obj");
    texturing.parts = ["a", "b"]
        .map(|name| Part {
            material: Some(name.to_owned()),
            ..Part::default()
        })
        .to_vec();
    texturing.part_of = [0, 0, 1, 1, 1, 1].map(Some).to_vec();
    let by_material = Division::by_material(&texturing).unwrap();
    let judged = |division, chosen: Option<&[bool]>| {
        judge(&substrate, &texturing, (division, chosen)).unwrap()
    };
    assert!(judged(None, None).overlapping > 0.95);
    let apart = judged(Some(&by_material), None);
    assert_eq!(
        (apart.images, apart.overlapping, apart.not_shown),
        (2, 0.0, 2)
    );
    assert!((apart.used - 0.64).abs() < 0.01, "{apart:?}");
    let first = judged(None, Some(&[true, true]));
    assert_eq!(
        (first.images, first.overlapping, first.not_shown),
        (1, 0.0, 0)
    );
    // A part that repeats an image does not keep the others from having maps.
    let (substrate, mut texturing) = written(&squares(&[low, square(0.0, 7.0)]), "squares.obj");
    texturing.parts = ["a", "b"]
        .map(|name| Part {
            material: Some(name.to_owned()),
            ..Part::default()
        })
        .to_vec();
    texturing.part_of = [0, 0, 1, 1].map(Some).to_vec();
    let by_material = Division::by_material(&texturing).unwrap();
    let judged = judge(&substrate, &texturing, (Some(&by_material), None)).unwrap();
    assert_eq!(
        (judged.images, judged.unfit, judged.overlapping),
        (1, 1, 0.0)
    );
    assert!((judged.used - 0.64).abs() < 0.01, "{judged:?}");
    let (substrate, texturing) = written(&squares(&[flat]), "squares.obj");
    let flat = judge(&substrate, &texturing, (None, None));
    assert_eq!(flat, Err(BakeError::FlatUvs));
    let (substrate, texturing) = written(&squares(&[square(0.0, 2.0)]), "squares.obj");
    let wide = judge(&substrate, &texturing, (None, None));
    assert!(matches!(wide, Err(BakeError::Repeats { .. })), "{wide:?}");
    let (substrate, texturing) = written(&squares(&[square(0.0, 1.0); 40]), "squares.obj");
    let stacked = judge(&substrate, &texturing, (None, None));
    assert!(
        matches!(stacked, Err(BakeError::Stacked { .. })),
        "{stacked:?}"
    );
}
