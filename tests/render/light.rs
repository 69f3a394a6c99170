//! Light, grounds and cameras of the library.

use super::*;

const UP: [f32; 3] = [0.0, 1.0, 0.0];

fn flat(width: u32, height: u32, samples: u32) -> Settings {
    Settings {
        width,
        height,
        samples,
        background: Background::Color([0; 3]),
    }
}

/// A plain white square of side 20 at the height 0, and a wall of this height along x = 0 that
/// faces +x.
struct Corner {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[u8; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Corner {
    fn new(wall: f32) -> Self {
        let floor = [
            [-10.0, 0.0, -10.0],
            [10.0, 0.0, -10.0],
            [10.0, 0.0, 10.0],
            [-10.0, 0.0, 10.0],
        ];
        let upright = [
            [0.0, 0.0, -10.0],
            [0.0, 0.0, 10.0],
            [0.0, wall, 10.0],
            [0.0, wall, -10.0],
        ];
        let mut corner = Self {
            positions: floor.to_vec(),
            normals: vec![UP; 4],
            colors: vec![[160; 3]; 4],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
        };
        if wall > 0.0 {
            corner.positions.extend(upright);
            corner.normals.extend([[1.0, 0.0, 0.0]; 4]);
            corner.colors.extend([[0; 3]; 4]);
            corner.triangles.extend([[4, 5, 6], [4, 6, 7]]);
        }
        corner
    }

    fn painted(&self) -> Painted<'_> {
        Painted {
            positions: &self.positions,
            normals: &self.normals,
            colors: &self.colors,
            triangles: &self.triangles,
            grain: 0.0,
            structure: None,
        }
    }
}

/// Painted meshes alone.
fn picture_of(skins: &[Painted], camera: &Camera, settings: &Settings) -> Image {
    let stone = Stone::new(&[], &[]);
    let bare = Scene::bare(&stone, UP);
    render(&World::new(&Scene { skins, ..bare }), camera, settings)
}

/// The mean byte of a picture.
fn mean(image: &Image) -> f64 {
    image.rgb.iter().map(|&b| f64::from(b)).sum::<f64>() / image.rgb.len() as f64
}

/// How bright the floor is at x, seen from straight above through a narrow lens, the key light being
/// to the left of a camera whose right is `side` × x.
fn floor_at(corner: &Corner, x: f32, side: f32) -> f64 {
    let up = [0.0, 0.0, -side];
    let camera = Camera::look_at([x, 30.0, 0.0], [x, 0.0, 0.0], up, 2e-4);
    let skins = [corner.painted()];
    mean(&picture_of(&skins, &camera, &flat(24, 24, 64)))
}

#[test]
fn hollows_are_darker_the_more_of_the_sky_a_wall_hides() {
    // The key comes from +x, over the open floor, so that the wall at x = 0 hides only sky.
    let open = floor_at(&Corner::new(0.0), 0.5, -1.0);
    let mut before = 0.0;
    for x in [0.02, 0.3, 1.0, 3.0, 8.0] {
        let at = floor_at(&Corner::new(2.0), x, -1.0);
        assert!(at > before, "at {x}: {at}, nearer {before}");
        before = at;
    }
    assert!(
        before < open + 1.0 && before > 0.97 * open,
        "{before} {open}"
    );
    // A black wall without end hides half of the sky at its foot, and what is left lights no more.
    let foot = floor_at(&Corner::new(500.0), 0.01, -1.0);
    let tall = floor_at(&Corner::new(50.0), 0.01, -1.0);
    assert!((foot - tall).abs() < 2.0, "{foot} {tall}");
    assert!(foot < 0.97 * open, "{foot} {open}");
}

/// The same everywhere.
struct Everywhere(Detail);

impl Structure for Everywhere {
    fn at(&self, _: [f32; 3], _: [f32; 3]) -> Detail {
        self.0
    }
}

#[test]
fn a_structure_colours_and_tilts_what_it_is_on() {
    let plain = Detail {
        shade: 1.0,
        cover: [0.0; 3],
        slope: [0.0; 3],
    };
    let corner = Corner::new(0.0);
    // The key comes from +x.
    let camera = Camera::look_at([0.5, 30.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], 2e-4);
    let pictured = |structure: Option<&dyn Structure>| {
        let skins = [Painted {
            structure,
            ..corner.painted()
        }];
        picture_of(&skins, &camera, &flat(24, 24, 16))
    };
    let with = |detail: Detail| pictured(Some(&Everywhere(detail)));
    assert!(with(plain) == pictured(None));
    let dark = Detail {
        shade: 0.0,
        ..plain
    };
    assert!(mean(&with(dark)) < 1.0);
    let red = with(Detail {
        cover: [0.4, 0.0, 0.0],
        ..dark
    });
    assert!(
        red.rgb
            .chunks(3)
            .all(|p| p[0] > 100 && p[1] < 60 && p[2] < 60)
    );
    let [towards, away] = [-0.5, 0.5].map(|x| {
        mean(&with(Detail {
            slope: [x, 0.0, 0.0],
            ..plain
        }))
    });
    let level = mean(&pictured(None));
    assert!(towards > level && level > away, "{towards} {level} {away}");
}

/// A floor of these sides from straight above, as a ground.
fn ground_of(sides: [f32; 2], ground: Ground) -> Image {
    let [x, z] = sides.map(|side| 0.5 * side);
    let vertices = [[-x, 0.0, -z], [x, 0.0, -z], [x, 0.0, z], [-x, 0.0, z]];
    let stone = Stone::new(&vertices, &[[0, 2, 1], [0, 3, 2]]);
    let world = World::new(&Scene {
        ground,
        ..Scene::bare(&stone, UP)
    });
    let camera = Camera::look_at([0.0, 30.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], 0.2);
    render(&world, &camera, &flat(96, 96, 16))
}

#[test]
fn ground_of_one_colour_is_painted_like_a_mesh_of_it() {
    let corner = Corner::new(0.0);
    let skins = [corner.painted()];
    let camera = Camera::look_at([0.0, 30.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], 0.2);
    let painted = picture_of(&skins, &camera, &flat(96, 96, 16));
    let ground = ground_of([20.0; 2], Ground::Color([160; 3]));
    let differ = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    assert!(painted.rgb.iter().zip(&ground.rgb).map(differ).max() <= Some(1));
}

/// A finish of one triangle, by its number.
struct Only(u32, Coat);

impl Finish for Only {
    fn at(&self, triangle: u32, weights: [f32; 3], _: [f32; 3]) -> Option<Coat> {
        assert!(
            (weights.iter().sum::<f32>() - 1.0).abs() < 1e-5,
            "{weights:?}"
        );
        (triangle == self.0).then_some(self.1)
    }
}

/// Triangles that cannot be drawn are left out, which changes no number.
#[test]
fn a_finish_colours_and_tilts_the_triangle_that_it_is_asked_for() {
    let vertices = [
        [-10.0, 0.0, -10.0],
        [10.0, 0.0, -10.0],
        [10.0, 0.0, 10.0],
        [-10.0, 0.0, 10.0],
    ];
    let stone = Stone::new(&vertices, &[[0, 0, 1], [0, 2, 1], [1, 1, 1], [0, 3, 2]]);
    // The key comes from +x.
    let camera = Camera::look_at([0.0, 30.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], 0.2);
    // How bright a channel is on the side of +x and on that of −x.
    let halves = |finish: Option<&dyn Finish>, channel: usize| {
        let bare = Scene::bare(&stone, UP);
        let ground = Ground::Color([0, 0, 160]);
        let world = World::new(&Scene {
            ground,
            finish,
            ..bare
        });
        let image = render(&world, &camera, &flat(64, 64, 8));
        let row = &image.rgb[3 * 64 * 32..][..3 * 64];
        let mean = |pixels: &[u8]| {
            let all = pixels.chunks(3).map(|p| f64::from(p[channel]));
            all.sum::<f64>() / (pixels.len() / 3) as f64
        };
        [mean(&row[3 * 34..]), mean(&row[..3 * 30])]
    };
    let red = |x: f32| Coat {
        albedo: [0.4, 0.0, 0.0],
        normal: [x, (1.0 - x * x).sqrt(), 0.0],
    };
    let [bare, other] = halves(None, 0);
    assert!(bare < 30.0 && other < 30.0, "{bare} {other}");
    let [first, rest] = [1, 3].map(|number| halves(Some(&Only(number, red(0.0))), 0));
    let (lit, dark) = (first[0].max(first[1]), first[0].min(first[1]));
    assert!(lit > 100.0 && dark < 30.0, "{first:?}");
    assert!(
        (first[0] > first[1]) != (rest[0] > rest[1]),
        "{first:?} {rest:?}"
    );
    let most = |x: f32| {
        let [a, b] = halves(Some(&Only(1, red(x))), 0);
        a.max(b)
    };
    assert!(
        most(0.5) > lit && lit > most(-0.5),
        "{} {lit} {}",
        most(0.5),
        most(-0.5)
    );
}

#[test]
fn bark_is_drawn_along_the_longest_side() {
    // How much a picture changes from column to column, over the same from row to row.
    let across = |image: &Image| {
        let change = |lag: usize| {
            let ends = image.rgb.iter().zip(&image.rgb[3 * lag..]);
            ends.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>()
        };
        change(4) / change(4 * 96)
    };
    let [long, wide, stone] = [
        ground_of([18.0, 40.0], Ground::Bark),
        ground_of([40.0, 18.0], Ground::Bark),
        ground_of([18.0, 40.0], Ground::Stone),
    ];
    assert!(across(&long) > 1.3, "{}", across(&long));
    assert!(across(&wide) < 1.0 / 1.3, "{}", across(&wide));
    assert!((0.9..1.1).contains(&across(&stone)), "{}", across(&stone));
}

#[test]
fn a_soft_light_casts_a_shadow_that_fades_in_order() {
    // The key comes from −x, behind the wall: shadow at its foot, half shade, light.
    let wall = Corner::new(1.0);
    let bright: Vec<f64> = (0..14)
        .map(|i| floor_at(&wall, 0.1 + 0.15 * i as f32, 1.0))
        .collect();
    let (dark, light) = (bright[0], bright[13]);
    assert!(light > 1.25 * dark, "{bright:?}");
    assert!(
        bright.windows(2).all(|pair| pair[1] > pair[0] - 1.5),
        "{bright:?}"
    );
    let between = |b: &&f64| **b > dark + 0.2 * (light - dark) && **b < dark + 0.8 * (light - dark);
    assert!(bright.iter().filter(between).count() >= 1, "{bright:?}");
}

#[test]
fn a_coarse_sphere_shows_no_shadows_of_its_own_triangles() {
    let (vertices, triangles) = sphere(14);
    let stone = Stone::new(&vertices, &triangles);
    let world = World::new(&Scene::bare(&stone, UP));
    let camera = Camera::look_at([0.0, 0.3, 8.0], [0.0; 3], UP, 0.15);
    let image = render(&world, &camera, &flat(96, 96, 64));
    // From the lit upper left to the dark lower right, light falls without steps back; stone has
    // grain, so runs of pixels are compared.
    let run = |k: usize| {
        let (x, y) = (30 + k, 30 + k);
        let near = (0..25).map(|i| (y + i / 5 - 2) * 96 + x + i % 5 - 2);
        near.map(|i| f64::from(image.rgb[3 * i + 1])).sum::<f64>() / 25.0
    };
    let along: Vec<f64> = (0..36).step_by(6).map(run).collect();
    assert!(
        along.windows(2).all(|pair| pair[1] < pair[0] + 14.0),
        "{along:?}"
    );
    assert!(along[5] < 0.8 * along[0], "{along:?}");
}

fn sphere(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let turn = std::f32::consts::PI / n as f32;
    let place = |i: u32| {
        let (theta, phi) = (turn * (i / (2 * n)) as f32, turn * (i % (2 * n)) as f32);
        [
            theta.sin() * phi.cos(),
            theta.cos(),
            theta.sin() * phi.sin(),
        ]
    };
    let vertices = (0..(n + 1) * 2 * n).map(place).collect();
    let cells = (0..n).flat_map(|row| (0..2 * n).map(move |column| (row, column)));
    let triangles = cells.flat_map(|(row, column)| {
        let at = |r: u32, c: u32| r * 2 * n + c % (2 * n);
        let [a, b] = [at(row, column), at(row, column + 1)];
        let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
        [[a, b, c], [b, d, c]]
    });
    (vertices, triangles.collect())
}

#[test]
fn backgrounds_are_what_they_say() {
    let disc = [Disc {
        center: [0.0; 3],
        normal: UP,
        radius: 0.5,
        color: [200, 40, 30],
    }];
    let stone = Stone::new(&[], &[]);
    let world = World::new(&Scene {
        discs: &disc,
        ..Scene::bare(&stone, UP)
    });
    let camera = Camera::look_at([0.0, 6.0, 0.1], [0.0; 3], UP, 0.2);
    let take = |background| {
        let settings = Settings {
            background,
            ..flat(64, 64, 16)
        };
        render(&world, &camera, &settings)
    };
    let clear = take(Background::Transparent);
    let alpha = clear.alpha.as_ref().expect("an alpha channel");
    assert_eq!((alpha[0], alpha[32 * 64 + 32]), (0, 255));
    // A disc of radius ½ in a picture 2 · 6 · 0.2 across.
    let covered = alpha.iter().map(|&a| f64::from(a) / 255.0).sum::<f64>() / 4096.0;
    let expected = std::f64::consts::PI * 0.25 / 5.76;
    assert!(
        (covered - expected).abs() < 0.1 * expected,
        "{covered} {expected}"
    );
    let blue = take(Background::Color([10, 20, 240]));
    assert_eq!(&blue.rgb[..3], [10, 20, 240]);
    assert!(blue.alpha.is_none());
    let middle = 3 * (32 * 64 + 32);
    assert_eq!(blue.rgb[middle..middle + 3], clear.rgb[middle..middle + 3]);
    let studio = take(Background::Studio);
    assert!(studio.rgb[..3].iter().all(|&b| b > 100) && studio.alpha.is_none());
}

#[test]
fn azimuth_and_elevation_are_those_of_the_documentation() {
    let (vertices, triangles) = sphere(8);
    let stone = Stone::new(&vertices, &triangles);
    let along = |up: [f32; 3], azimuth, elevation| {
        let world = World::new(&Scene::bare(&stone, up));
        Camera::from_side(&world, 1.5, azimuth, elevation)
    };
    let is_near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5);
    let z_up = [0.0, 0.0, 1.0];
    for (up, azimuth, elevation, forward) in [
        (UP, 0.0, 0.0, [0.0, 0.0, -1.0]),
        (UP, 90.0, 0.0, [-1.0, 0.0, 0.0]),
        (UP, 180.0, 0.0, [0.0, 0.0, 1.0]),
        (UP, -90.0, 0.0, [1.0, 0.0, 0.0]),
        (UP, 30.0, 90.0, [0.0, -1.0, 0.0]),
        (UP, 0.0, -90.0, [0.0, 1.0, 0.0]),
        (z_up, 0.0, 0.0, [0.0, 1.0, 0.0]),
        (z_up, 90.0, 0.0, [-1.0, 0.0, 0.0]),
        (z_up, 0.0, 90.0, [0.0, 0.0, -1.0]),
    ] {
        let camera = along(up, azimuth, elevation);
        assert!(
            is_near(camera.forward(), forward),
            "{azimuth} {elevation}: {camera:?}"
        );
        let middle = camera.project([0.0; 3], 1.5).expect("in front");
        assert!(
            (middle[0] - 0.5).abs() < 0.02 && (middle[1] - 0.5).abs() < 0.02,
            "{middle:?}"
        );
    }
    // From above, the front is at the bottom of the picture.
    let above = along(UP, 0.0, 90.0);
    let [_, y] = above.project([0.0, 0.0, 1.0], 1.5).expect("in front");
    assert!(y > 0.6, "{y}");
    let half = libm::tanf(20f32.to_radians());
    let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], UP, half);
    assert!((camera.opening() - 40.0).abs() < 1e-3);
    assert!((camera.zoomed(5.0, 2.0).depth([0.0; 3]) - 2.5).abs() < 1e-5);
    assert!((camera.width_at(5.0, 2.0) - 20.0 * half).abs() < 1e-4);
    let aside = [2.0, -0.1, 0.0];
    let centred = camera.centred(aside, 1.5, 0.4);
    let [x, y] = centred.project(aside, 1.5).expect("in front");
    let [_, before] = camera.project(aside, 1.5).expect("in front");
    assert!(
        (x - 0.7).abs() < 1e-5 && (y - before).abs() < 1e-5,
        "{x} {y}"
    );
}

/// A ball of radius 1 with granules all over it: what is nearest to the eye is at 1, and to go to the middle of them
/// all would be to go inside.
#[test]
fn to_go_nearer_is_to_go_to_what_is_seen_and_not_inside() {
    let (vertices, triangles) = sphere(24);
    let stone = Stone::new(&vertices, &triangles);
    let disc = |center: &[f32; 3]| Disc {
        center: *center,
        normal: *center,
        radius: 0.004,
        color: [200; 3],
    };
    let all: Vec<Disc> = vertices.iter().map(disc).collect();
    let dense = |disc: &&Disc| disc.center[0] > 0.0 && disc.center[1].abs() < 0.3;
    let side: Vec<Disc> = all.iter().filter(dense).copied().collect();
    for (discs, factors) in [(&all, [1.5, 4.0, 40.0]), (&side, [1.5, 4.0, 40.0])] {
        let world = World::new(&Scene {
            discs,
            ..Scene::bare(&stone, UP)
        });
        let camera = Camera::from_side(&world, 1.5, 40.0, 20.0);
        for factor in factors {
            let nearer = camera
                .nearer(&world, 1.5, factor)
                .expect("granules in sight");
            let eye = glam::Vec3::from(nearer.eye());
            assert!(eye.length() > 1.0, "{factor}: {eye}");
            assert_eq!(nearer.sight(&world, 1.5), Sight::Seen, "{factor}");
            let apart = |camera: &Camera| {
                let eye = glam::Vec3::from(camera.eye());
                let each = discs.iter().map(|disc| eye.distance(disc.center.into()));
                each.fold(f32::INFINITY, f32::min)
            };
            let as_near = apart(&camera) / apart(&nearer) / factor;
            assert!((0.4..2.5).contains(&as_near), "{factor}: {as_near}");
        }
    }
    // Skins are up to so thick.
    let world = World::new(&Scene {
        discs: &all,
        ..Scene::bare(&stone, UP)
    });
    let camera = Camera::from_side(&world, 1.5, 40.0, 20.0);
    let nearest = camera.nearer(&world, 1.5, 1e4).expect("granules in sight");
    let eye = glam::Vec3::from(nearest.eye());
    assert!(eye.length() > 1.0 + 9.0 * 0.004, "{eye}");
    let none = World::new(&Scene::bare(&stone, UP));
    let camera = Camera::from_side(&none, 1.5, 40.0, 20.0);
    assert!(camera.nearer(&none, 1.5, 2.0).is_none());
}
