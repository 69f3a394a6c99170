//! Charts of their own, whatever the file says.

use super::layouts::{plain, square, squares};
use super::materials::{image, texture};
use super::*;

fn unwrapped(size: u32, samples: u32) -> Settings {
    Settings {
        unwrap: true,
        ..settings(size, samples)
    }
}

#[test]
fn both_sides_of_its_seams_show_the_same() {
    check_seams(&unwrapped(1024, 4));
}

#[test]
fn it_is_the_same_on_any_number_of_threads() {
    check_threads(&unwrapped(256, 1));
}

fn doubled_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// A mesh without coordinates, with a small lichen.
fn bare((substrate, _): (Substrate, Texturing)) -> Made {
    let growth = grow(
        &substrate,
        &recipe(0.02, 20),
        &Execution::default(),
        &mut (),
    )
    .unwrap();
    Made {
        cluster: growth.cluster,
        substrate,
        texturing: Texturing::default(),
    }
}

/// An open tube of eight sides, sixty times as long as it is wide.
fn twig() -> (Substrate, Texturing) {
    let mut text = String::new();
    for i in 0..=120 {
        for k in 0..8 {
            let (sin, cos) = (f64::from(k) * TAU / 8.0).sin_cos();
            let y = 0.5 * f64::from(i);
            writeln!(text, "v {} {y} {}", 0.5 * cos, 0.5 * sin).unwrap();
        }
    }
    for i in 0..120 {
        for k in 0..8 {
            let [a, b] = [8 * i + k + 1, 8 * i + (k + 1) % 8 + 1];
            writeln!(text, "f {a} {} {} {b}", a + 8, b + 8).unwrap();
        }
    }
    written(&text, "twig.obj")
}

#[test]
fn every_place_has_texels_of_its_own() {
    let file = |mesh| (mesh, load(Path::new(mesh)));
    let files = ["meshes/rock.obj", "meshes/branch.glb"].map(file);
    for (mesh, loaded) in files.into_iter().chain([("a twig", twig())]) {
        let made = bare(loaded);
        let baker = baker(&made, &unwrapped(512, 1));
        assert_eq!(baker.check(None), Ok(()));
        let baked = baker.whole().unwrap();
        let report = baked.report();
        assert_eq!(report.overlaps, Default::default(), "{mesh}");
        assert_eq!(report.not_shown, 0, "{mesh}");
        assert!(2 * report.covered > report.texels, "{mesh}: {report:?}");
        let [(_, worn)] = &baked.meshes()[..] else {
            panic!("{mesh} is one object");
        };
        let all: f64 = made.substrate.components().iter().map(|c| c.area).sum();
        for (t, corners) in worn.shape.triangles.iter().enumerate() {
            let at = corners.map(|k| worn.uvs[k as usize]);
            assert!(at.as_flattened().iter().all(|x| (0.0..=1.0).contains(x)));
            // v counts from above: counter-clockwise from outside is not mirrored.
            let share = -0.5 * doubled_area(at.map(|[u, v]| DVec2::new(u.into(), v.into())));
            let even = made.substrate.area(t as u32) / all;
            let stretched = share / even * report.texels as f64 / report.covered as f64;
            assert!((0.2..5.0).contains(&stretched), "{mesh} {t}: {stretched}");
        }
    }
}

/// Three squares, on which an image and a normal map repeat, each turned its own way.
fn tiled() -> Made {
    let turned = |turn: usize| {
        let corner = |k: usize| square(0.0, 2.0)[(k + turn) % 4];
        std::array::from_fn(corner)
    };
    let (substrate, mut texturing) = written(&squares(&[0, 1, 3].map(turned)), "squares.obj");
    let tilt = image([[204, 128, 230, 255]; 4]);
    let colors = [
        [255, 0, 0, 255],
        [0, 255, 0, 255],
        [0, 0, 255, 255],
        [90, 90, 90, 255],
    ];
    texturing.images = vec![image(colors), tilt];
    texturing.materials = vec![Material {
        base_color_texture: texture(0, false),
        normal_texture: texture(1, false),
        ..plain()
    }];
    texturing.material_of = vec![Some(0); 6];
    let growth = grow(&substrate, &recipe(0.01, 3), &Execution::default(), &mut ()).unwrap();
    Made {
        cluster: growth.cluster,
        substrate,
        texturing,
    }
}

#[test]
fn textures_are_drawn_anew() {
    let made = tiled();
    let as_it_is = baker(&made, &settings(256, 1));
    let tiles = 2.0;
    assert!(matches!(as_it_is.whole(), Err(BakeError::Repeats { tiles: t, .. }) if t == tiles));
    let baker = baker(&made, &unwrapped(256, 1));
    let baked = baker.whole().unwrap();
    let looks = Appearance::new(&made.substrate, &made.texturing);
    let [(_, worn)] = &baked.meshes()[..] else {
        panic!("one object");
    };
    let mut seen = 0;
    for (t, corners) in worn.shape.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|k| DVec2::from(worn.uvs[k as usize].map(f64::from)));
        for weights in [
            [0.2, 0.3, 0.5],
            [0.6, 0.3, 0.1],
            [0.1, 0.1, 0.8],
            [0.4, 0.5, 0.1],
        ] {
            let at = (a * weights[0] + b * weights[1] + c * weights[2]) * 256.0;
            let [x, y] = [at.x as usize, at.y as usize];
            if baked.value(map("mask"), x, y)[0] > 0.0 {
                continue;
            }
            // The middle of that texel.
            let middle = (DVec2::new(x as f64, y as f64) + 0.5) / 256.0;
            let [p, q, r] = [a, b, c].map(|corner| corner - middle);
            let areas = [q.perp_dot(r), r.perp_dot(p), p.perp_dot(q)];
            let weights = areas.map(|area| (area / areas.iter().sum::<f64>()) as f32);
            let up = made.substrate.normal(t as u32).as_vec3();
            let coat = looks.at(t as u32, weights, up.to_array()).unwrap();
            let color = Vec3::from_array(baked.value(map("base_color"), x, y));
            assert!(
                color.distance(coat.albedo.into()) < 0.01,
                "{t}: {color} {:?}",
                coat.albedo
            );
            let local = Vec3::from_array(baked.value(map("normal"), x, y)) * 2.0 - 1.0;
            let axes =
                Mat3::from_cols_array_2d(&baked.tangent_frame(t as u32, weights.map(f64::from)));
            let normal = (axes * local).normalize();
            assert!(
                normal.distance(coat.normal.into()) < 0.02,
                "{t}: {normal} {:?}",
                coat.normal
            );
            seen += 1;
        }
    }
    assert!(seen > 15, "{seen}");
}

#[test]
fn a_part_has_the_image_to_itself() {
    let made = tiled();
    let baker = baker(&made, &unwrapped(256, 1));
    let part = [false, false, true, true, false, false];
    let baked = baker.part(&part).unwrap();
    let report = baked.report();
    assert_eq!((report.triangles, report.not_shown), (2, 0));
    assert!(5 * report.covered > 4 * report.texels, "{report:?}");
}

#[test]
fn charts_come_closer_where_they_are_many_until_they_do_not_fit() {
    let many = squares(&vec![square(0.0, 1.0); 400]);
    let (substrate, texturing) = written(&many, "squares.obj");
    let growth = grow(&substrate, &recipe(0.1, 3), &Execution::default(), &mut ()).unwrap();
    let made = Made {
        cluster: growth.cluster,
        substrate,
        texturing,
    };
    let whole = |size| {
        let baker = baker(&made, &unwrapped(size, 1));
        baker.whole().map(|baked| baked.report().covered)
    };
    assert_eq!(whole(32), Err(BakeError::Crowded));
    // With as much between charts as usual they would fill a twelfth.
    let covered = whole(128).unwrap();
    assert!(4 * covered > 128 * 128, "{covered}");
}
