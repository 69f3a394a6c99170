//! The picture of a run, on scenes whose look is known beforehand.

use thallus::picture::{
    Background, Camera, Disc, Image, Scene, Settings, Stone, World, age_color, render,
};

const UP: [f32; 3] = [0.0, 1.0, 0.0];

const SMALL: Settings = Settings {
    width: 64,
    height: 48,
    samples: 4,
    background: Background::Studio,
};

const RED: [u8; 3] = [210, 30, 20];

/// The square of side 2 at this height, facing up.
fn square(y: f32) -> Vec<[f32; 3]> {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, z]| [x, y, z])
        .to_vec()
}

const SQUARE: [[u32; 3]; 2] = [[0, 2, 1], [0, 3, 2]];

fn disc(center: [f32; 3], normal: [f32; 3], radius: f32) -> Disc {
    Disc {
        center,
        normal,
        radius,
        color: RED,
    }
}

fn world<'a>(stone: &'a Stone, discs: &'a [Disc]) -> World<'a> {
    World::new(&Scene {
        discs,
        ..Scene::bare(stone, UP)
    })
}

fn from_above() -> Camera {
    Camera::look_at([0.0, 5.0, 3.0], [0.0; 3], UP, 0.3)
}

fn at(image: &Image, place: [f32; 2]) -> [u8; 3] {
    let x = (place[0] * image.width as f32) as usize;
    let y = (place[1] * image.height as f32) as usize;
    let i = 3 * (y * image.width as usize + x);
    [image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]]
}

fn is_red([r, g, b]: [u8; 3]) -> bool {
    i32::from(r) > 2 * i32::from(g.max(b)) && r > 60
}

fn reds(image: &Image) -> usize {
    let is = |p: &&[u8]| is_red([p[0], p[1], p[2]]);
    image.rgb.chunks_exact(3).filter(is).count()
}

#[test]
fn the_png_decodes_to_the_picture() {
    let vertices = square(0.0);
    let image = render(
        &world(&Stone::new(&vertices, &SQUARE), &[]),
        &from_above(),
        &SMALL,
    );
    let bytes = image.to_png();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
        .read_info()
        .expect("a header");
    let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut rgb).expect("a frame");
    assert_eq!((info.width, info.height), (64, 48));
    assert_eq!(rgb, image.rgb);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let vertices = square(0.0);
    let place = |i: u32| {
        let (a, r) = (i as f32 * 2.4, (i as f32 / 500.0).sqrt());
        disc([r * a.cos(), 0.0, r * a.sin()], UP, 0.03)
    };
    let discs: Vec<Disc> = (0..500).map(place).collect();
    let take = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let stone = Stone::new(&vertices, &SQUARE);
            let world = world(&stone, &discs);
            let camera = Camera::best_view(&world, 4.0 / 3.0);
            render(&world, &camera, &SMALL)
        })
    };
    let one = take(1);
    assert!(reds(&one) > 100);
    assert!(one == take(2));
}

#[test]
fn a_disc_shows_at_its_place_and_nowhere_else() {
    let stone = Stone::new(&square(0.0), &SQUARE);
    for center in [[0.5, 0.0, 0.3], [-0.6, 0.0, -0.4], [0.0, 0.0, 0.7]] {
        let discs = [disc(center, UP, 0.12)];
        let camera = from_above();
        let image = render(&world(&stone, &discs), &camera, &SMALL);
        let place = camera.project(center, 4.0 / 3.0).expect("in front");
        assert!(is_red(at(&image, place)), "{:?}", at(&image, place));
        let [x, y] = place;
        assert!(!is_red(at(&image, [x, y - 0.15])));
        assert!(!is_red(at(&image, [x - 0.15, y])));
    }
}

#[test]
fn stone_is_lit_from_both_sides_of_a_sheet_of_either_winding() {
    let vertices = square(0.0);
    let flipped = SQUARE.map(|[a, b, c]| [a, c, b]);
    let look = |triangles: &[[u32; 3]]| {
        let stone = Stone::new(&vertices, triangles);
        render(&world(&stone, &[]), &from_above(), &SMALL)
    };
    let [a, b] = [look(&SQUARE), look(&flipped)].map(|i| at(&i, [0.5, 0.5]));
    assert_eq!(a, b);
    assert!(a.iter().all(|&c| c > 70 && c < 220), "{a:?}");
}

#[test]
fn the_far_side_of_a_thin_plate_does_not_show() {
    let vertices = [square(0.0), square(-0.002)].concat();
    let triangles = [SQUARE, SQUARE.map(|t| t.map(|i| i + 4))].concat();
    let below = [disc([0.0, -0.002, 0.0], [0.0, -1.0, 0.0], 0.2)];
    let above = [disc([0.0, 0.0, 0.0], UP, 0.2)];
    let look = |discs: &[Disc], triangles: &[[u32; 3]]| {
        let stone = Stone::new(&vertices, triangles);
        reds(&render(&world(&stone, discs), &from_above(), &SMALL))
    };
    assert_eq!(look(&below, &triangles), 0);
    assert!(look(&above, &triangles) > 20);
    let sheet = [disc([0.0, 0.0, 0.0], [0.0, -1.0, 0.0], 0.2)];
    assert_eq!(look(&sheet, &SQUARE), 0);
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let mut vertices = square(0.0);
    vertices.push([f32::NAN, 0.0, 0.0]);
    let triangles = [[0, 0, 1], [0, 1, 4], [0, 1, 99], [0, 2, 1]];
    let discs = [
        disc([0.0; 3], [0.0; 3], 0.1),
        disc([0.0; 3], UP, 0.0),
        disc([f32::INFINITY, 0.0, 0.0], UP, 0.1),
        disc([0.0; 3], UP, f32::NAN),
    ];
    for (v, t, d) in [
        (&vertices[..], &triangles[..], &discs[..]),
        (&vertices[..], &triangles[..], &[]),
        (&vertices[..], &[], &[]),
        (&[], &[], &[]),
        (&[], &[], &[disc([0.0; 3], UP, 1.0)]),
    ] {
        for up in [UP, [0.0; 3], [f32::NAN; 3]] {
            let stone = Stone::new(v, t);
            let world = World::new(&Scene {
                discs: d,
                ..Scene::bare(&stone, up)
            });
            let camera = Camera::best_view(&world, 4.0 / 3.0);
            assert!(camera.eye().iter().all(|x| x.is_finite()), "{camera:?}");
            assert_eq!(render(&world, &camera, &SMALL).rgb.len(), 3 * 64 * 48);
        }
    }
}

#[test]
fn the_best_view_is_on_the_side_of_the_lichen() {
    let (vertices, triangles) = cube();
    let stone = Stone::new(&vertices, &triangles);
    for normal in [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        UP,
    ] {
        let discs = [disc(normal, normal, 0.05)];
        let world = world(&stone, &discs);
        let camera = Camera::best_view(&world, 4.0 / 3.0);
        let [x, y, z] = camera.forward();
        let towards = x * normal[0] + y * normal[1] + z * normal[2];
        assert!(towards < -0.5, "{normal:?}: {camera:?}");
        assert!(reds(&render(&world, &camera, &SMALL)) > 3, "{normal:?}");
    }
}

/// The cube from -1 to 1.
fn cube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let sign = |i: u32, k: u32| if i >> k & 1 == 0 { -1.0 } else { 1.0 };
    let vertices = (0..8).map(|i| [0, 1, 2].map(|k| sign(i, k))).collect();
    let faces = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    (vertices, faces.into_iter().flat_map(halves).collect())
}

#[test]
fn discs_below_a_pixel_read_as_a_tone() {
    let vertices = square(0.0);
    let discs: Vec<Disc> = (0..200 * 200)
        .map(|i| [i % 200, i / 200].map(|k| (k as f32 + 0.5) / 200.0 - 0.5))
        .map(|[x, z]| disc([x, 0.0, z], UP, 0.0025))
        .collect();
    let camera = from_above();
    let settings = Settings {
        samples: 32,
        ..SMALL
    };
    let stone = Stone::new(&vertices, &SQUARE);
    let image = render(&world(&stone, &discs), &camera, &settings);
    let middle = at(&image, [0.5, 0.5]);
    for place in [[0.45, 0.5], [0.55, 0.5], [0.5, 0.45], [0.5, 0.55]] {
        let other = at(&image, place);
        assert!(is_red(other), "{other:?}");
        let apart = (0..3).map(|k| other[k].abs_diff(middle[k])).max();
        assert!(apart < Some(30), "{middle:?} {other:?}");
    }
}

/// Where samples are saved is decided by what they saw: that must not make anything lighter or darker.
#[test]
fn few_samples_show_the_same_light_as_many() {
    let (vertices, triangles) = cube();
    let discs: Vec<Disc> = (0..30 * 30)
        .map(|i| [i % 30, i / 30].map(|k| (k as f32 + 0.5) / 30.0 - 0.5))
        .map(|[x, z]| disc([x, 1.0, z], UP, 0.02))
        .collect();
    let stone = Stone::new(&vertices, &triangles);
    let world = world(&stone, &discs);
    let camera = Camera::look_at([3.0, 4.0, 5.0], [0.0; 3], UP, 0.7);
    let taken = |samples: u32| {
        let settings = Settings {
            width: 160,
            height: 120,
            samples,
            ..SMALL
        };
        render(&world, &camera, &settings)
    };
    // The mean of each 16 x 16 pixels.
    let squares = |image: &Image| {
        let mut sums = [0u32; 80];
        for (i, p) in image.rgb.chunks(3).enumerate() {
            let light: u32 = p.iter().map(|&c| u32::from(c)).sum();
            sums[i / 160 / 16 * 10 + i % 160 / 16] += light;
        }
        sums.map(|sum| f64::from(sum) / (3.0 * 256.0))
    };
    let exact = squares(&taken(256));
    for samples in [4, 8, 16] {
        let few = squares(&taken(samples));
        let apart = few.iter().zip(exact).map(|(a, b)| a - b);
        let (sum, most) = apart.fold((0.0, 0.0f64), |(sum, most), d| (sum + d, most.max(d.abs())));
        let mean: f64 = sum / 80.0;
        assert!(mean.abs() < 0.1, "{samples} samples: {mean} lighter");
        let limit = 8.0 / f64::from(samples).sqrt();
        assert!(most < limit, "{samples} samples: {most} apart");
    }
}

#[test]
fn colours_grow_lighter_from_old_to_young() {
    let light = |t: f32| age_color(t).iter().map(|&c| u32::from(c)).sum::<u32>();
    for i in 0..20 {
        assert!(light(i as f32 / 20.0) < light((i + 1) as f32 / 20.0));
    }
    assert_eq!(age_color(-1.0), age_color(0.0));
    assert_eq!(age_color(2.0), age_color(1.0));
    assert_eq!(age_color(f32::NAN), age_color(0.0));
    for t in [0.0, 0.5, 1.0] {
        let [r, g, b] = age_color(t);
        assert!(g >= r && r > b || g > r && g > b, "{r} {g} {b}");
    }
}
