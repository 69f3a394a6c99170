//! Time lapses: pictures of which only what has changed is taken anew.

use thallus::picture::{
    Background, Camera, Disc, Ground, Image, Painted, Scene, Settings, Stage, Stone, Structure,
    TimeLapse, World,
};

const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// A step: a floor and a wall.
fn step() -> Stone {
    let corners = [
        [-2.0, 0.0, -1.0],
        [2.0, 0.0, -1.0],
        [2.0, 0.0, 2.0],
        [-2.0, 0.0, 2.0],
        [-2.0, 1.5, -1.0],
        [2.0, 1.5, -1.0],
    ];
    Stone::new(&corners, &[[0, 2, 1], [0, 3, 2], [0, 1, 5], [0, 5, 4]])
}

fn disc(x: f32, z: f32, radius: f32) -> Disc {
    Disc {
        center: [x, 0.0, z],
        normal: UP,
        radius,
        color: [90, 160, 60],
    }
}

/// Discs that come one after the other, swell, and stay.
fn grown(frame: usize) -> Vec<Disc> {
    let radius = |i: usize| 0.25 * (frame as f32 - i as f32).clamp(0.0, 1.0);
    let place = |i: usize| (-1.5 + 0.45 * i as f32, 0.3 * (i % 3) as f32);
    let disc = |i| disc(place(i).0, place(i).1, radius(i));
    (0..frame.min(7)).map(disc).collect()
}

fn settings(background: Background) -> Settings {
    Settings {
        width: 120,
        height: 90,
        samples: 8,
        background,
    }
}

fn scene<'a>(stone: &'a Stone, discs: &[Disc]) -> Scene<'a> {
    Scene {
        ground: Ground::Stone,
        stage: Some(Stage::of(stone, discs, UP)),
        ..Scene::bare(stone, UP)
    }
}

fn camera(stone: &Stone, discs: &[Disc]) -> Camera {
    let world = World::new(&Scene {
        discs,
        ..Scene::bare(stone, UP)
    });
    Camera::best_view(&world, 4.0 / 3.0)
}

fn fresh(scene: &Scene, camera: &Camera, settings: &Settings) -> Image {
    thallus::picture::render(&World::new(scene), camera, settings)
}

/// Pixels that differ.
fn differing(a: &Image, b: &Image) -> usize {
    let pixels = |image: &Image| image.rgb.chunks(3).map(<[u8]>::to_vec).collect::<Vec<_>>();
    let pairs = pixels(a).into_iter().zip(pixels(b));
    pairs.filter(|(a, b)| a != b).count()
}

#[test]
fn each_picture_is_what_it_is_by_itself() {
    let stone = step();
    for background in [Background::Studio, Background::Transparent] {
        let (all, settings) = (grown(9), settings(background));
        let (bare, camera) = (scene(&stone, &all), camera(&stone, &all));
        let mut lapse = TimeLapse::new(bare, camera, settings);
        // Forth and back, and from one to another that has nothing in common with it.
        for frame in [0, 1, 2, 3, 5, 8, 8, 7, 2, 0, 8] {
            let discs = &grown(frame);
            let whole = fresh(&Scene { discs, ..bare }, &camera, &settings);
            let taken = lapse.take(discs, &[]);
            assert!(
                taken == whole,
                "{frame}: {} pixels",
                differing(&taken, &whole)
            );
        }
    }
}

#[test]
fn what_has_not_changed_is_not_taken_anew() {
    let stone = step();
    let (all, settings) = (grown(9), settings(Background::Studio));
    let mut lapse = TimeLapse::new(scene(&stone, &all), camera(&stone, &all), settings);
    lapse.take(&all, &[]);
    let whole = lapse.taken();
    assert!(whole > 120 * 90);
    lapse.take(&all, &[]);
    assert_eq!(lapse.taken(), 0);
    let mut some = all.clone();
    some[3].color = [200, 30, 30];
    lapse.take(&some, &[]);
    assert!(
        (1..whole / 4).contains(&lapse.taken()),
        "{} of {whole}",
        lapse.taken()
    );
}

/// The grain of the stone stays where it is, though lichen beyond its box makes that of everything larger.
#[test]
fn stone_far_from_what_grows_stays_as_it_is() {
    let stone = step();
    let all = [disc(1.9, 1.9, 0.3)];
    let camera = camera(&stone, &all);
    let settings = settings(Background::Studio);
    let images = [&[][..], &all].map(|discs| {
        let bare = scene(&stone, &all);
        fresh(&Scene { discs, ..bare }, &camera, &settings)
    });
    let changed = differing(&images[0], &images[1]);
    assert!((1..120 * 90 / 5).contains(&changed), "{changed} pixels");
}

/// A triangle with a colour, and what makes it lighter.
struct Shade(f32);

impl Structure for Shade {
    fn at(&self, _: [f32; 3], _: [f32; 3]) -> thallus::picture::Detail {
        thallus::picture::Detail {
            shade: self.0,
            cover: [0.0; 3],
            slope: [0.0; 3],
        }
    }
}

#[test]
fn skins_are_taken_anew_where_a_corner_or_the_structure_has_changed() {
    let stone = step();
    let all = [disc(0.0, 0.5, 0.6)];
    let (bare, settings) = (scene(&stone, &all), settings(Background::Studio));
    let camera = camera(&stone, &all);
    let mut lapse = TimeLapse::new(bare, camera, settings);
    let positions = [[-0.5, 0.1, 0.2], [0.5, 0.1, 0.2], [0.0, 0.1, 1.0]];
    let tilted = [[0.6, 0.8, 0.0], UP, UP];
    let green = [[90, 160, 60]; 3];
    let pale = [[230, 230, 210], green[1], green[2]];
    let shades = [Shade(1.0), Shade(0.3)];
    for (normals, colors, shade) in [
        (&[UP; 3], &green, None),
        (&tilted, &green, None),
        (&tilted, &pale, None),
        (&tilted, &pale, Some(0)),
        (&tilted, &pale, Some(1)),
        (&[UP; 3], &green, None),
    ] {
        let skin = Painted {
            positions: &positions,
            normals,
            colors,
            triangles: &[[0, 1, 2]],
            grain: 0.05,
            structure: shade.map(|k: usize| &shades[k] as &dyn Structure),
        };
        let skins = &[skin];
        let whole = fresh(&Scene { skins, ..bare }, &camera, &settings);
        let taken = lapse.take(&[], skins);
        assert!(taken == whole, "{} pixels", differing(&taken, &whole));
    }
}

#[test]
fn a_time_lapse_is_the_same_on_any_number_of_threads() {
    let stone = step();
    let (all, settings) = (grown(9), settings(Background::Studio));
    let lapse = || {
        let mut lapse = TimeLapse::new(scene(&stone, &all), camera(&stone, &all), settings);
        [2, 4, 6].map(|frame| lapse.take(&grown(frame), &[]))
    };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(lapse)
    };
    let one = on(1);
    assert!([2, 5].iter().all(|&threads| on(threads) == one));
}
