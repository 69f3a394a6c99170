//! What cannot be, handed to the library: an answer, an error or a panic that says so, and never something endless.

mod common;

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;
use thallus::analysis::{Analysis, AnalysisError, Centres, Metric, SurfaceMetric};
use thallus::cluster::Cluster;
use thallus::export::{
    Elements, FILM_FORMATS, Film, MESH_FORMATS, NotOnMesh, Placement, SCENE_FORMATS, Scene,
    TableError, TriMesh, What,
};
use thallus::growth::SeedPlace;
use thallus::morphometry::measure;
use thallus::picture::{ContactSheet, Image, Key, Tile, draw_legend};
use thallus::run::{Execution, Recipe, grow};
use thallus::substrate::{Mask, Substrate, SurfacePoint, UpAxis};

fn recipe(substrate: &Substrate) -> Recipe {
    Recipe {
        at: vec![SeedPlace::Center],
        ..common::recipe(substrate.auto_radius(), 20)
    }
}

fn lichen(substrate: &Substrate) -> Cluster {
    let execution = Execution::default();
    let growth = grow(substrate, &recipe(substrate), &execution, &mut ());
    growth.expect("grows").cluster
}

fn elements(substrate: &Substrate) -> Elements {
    Elements::of(substrate, &lichen(substrate))
}

fn scene(elements: Elements) -> Scene {
    let measured = measure(&elements.sample(), 6.4 * elements.radius);
    Scene::new(elements, measured, &Placement::unchanged(UpAxis::Y), 1.0)
}

fn skin() -> TriMesh {
    TriMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        colors: vec![[9; 3]; 3],
        triangles: vec![[0, 1, 2]],
        ..TriMesh::default()
    }
}

/// What a panic says.
fn panicked<T>(of: impl FnOnce() -> T) -> String {
    let said = catch_unwind(AssertUnwindSafe(of)).err().expect("a panic");
    let said = said.downcast::<String>().map(|said| *said);
    said.unwrap_or_else(|said| (*said.downcast::<&str>().expect("words")).to_owned())
}

fn kind<T>(result: io::Result<T>) -> Option<io::ErrorKind> {
    result.err().map(|e| e.kind())
}

const INVALID: Option<io::ErrorKind> = Some(io::ErrorKind::InvalidInput);
const UNSOUND: Option<io::ErrorKind> = Some(io::ErrorKind::InvalidData);

/// Room was made for each of them, and there was none.
#[test]
fn no_number_of_threads_is_too_many() {
    let plane = common::plane(1.0);
    let expected = lichen(&plane);
    for uses_all_threads in [false, true] {
        let execution = Execution {
            threads: usize::MAX,
            uses_all_threads,
            ..Execution::default()
        };
        let growth = grow(&plane, &recipe(&plane), &execution, &mut ()).expect("grows");
        assert_eq!(growth.cluster.elements(), expected.elements());
    }
}

/// Makes something unsound.
type Wrong<T> = fn(&mut T);

/// Scenes with one thing wrong.
fn unsound_scenes(sound: &Scene) -> Vec<Scene> {
    let wrongs: [Wrong<Scene>; 8] = [
        |scene| scene.streams[0].push(20),
        |scene| scene.orientations.truncate(19),
        |scene| scene.orientations[3][1] = f32::NAN,
        |scene| scene.branch_radii.truncate(3),
        |scene| scene.branch_radii[3] = f32::INFINITY,
        |scene| scene.elements.uv.truncate(2),
        |scene| scene.elements.parent[3] = 900,
        |scene| scene.fixed_origin = Some([0.0, f64::INFINITY, 0.0]),
    ];
    let with = |wrong: Wrong<Scene>| {
        let mut scene = sound.clone();
        wrong(&mut scene);
        scene
    };
    wrongs.map(with).into()
}

#[test]
fn scenes_that_are_not_sound_are_refused() {
    let sound = scene(elements(&common::plane(1.0)));
    assert_eq!(sound.check(), Ok(()));
    let folder = tempfile::tempdir().unwrap();
    for scene in unsound_scenes(&sound) {
        let problem = scene.check().expect_err("not sound");
        for format in SCENE_FORMATS {
            for what in [What::Points, What::Instances, What::Curves] {
                let written = format.write(what, &scene, &|_| [0; 3], &mut Vec::new());
                assert_eq!(
                    kind(written),
                    UNSOUND,
                    "{} {what:?}: {problem}",
                    format.extension
                );
            }
        }
        for format in FILM_FORMATS {
            let mut film = Film::new(format, 24.0, folder.path());
            for what in [What::Points, What::Curves] {
                let added = film.add_scene(what, &scene, &|_| [0; 3]);
                assert_eq!(kind(added), UNSOUND, "{problem}");
            }
        }
    }
}

#[test]
fn films_are_of_one_thing() {
    let scene = scene(elements(&common::plane(1.0)));
    let folder = tempfile::tempdir().unwrap();
    let add = |film: &mut Film, frame: Option<What>| {
        kind(match frame {
            None => film.add_skin(&skin()),
            Some(what) => film.add_scene(what, &scene, &|_| [0; 3]),
        })
    };
    let frames = [None, Some(What::Points), Some(What::Curves)];
    for format in FILM_FORMATS {
        for first in frames {
            let mut film = Film::new(format, 24.0, folder.path());
            assert_eq!(add(&mut film, first), None);
            for next in frames {
                let expected = if next == first { None } else { INVALID };
                assert_eq!(add(&mut film, next), expected, "{first:?} {next:?}");
            }
            assert!(film.write(1.0, &mut Vec::new()).is_ok());
        }
    }
}

#[test]
fn units_have_a_length() {
    let sound = scene(elements(&common::plane(1.0)));
    let folder = tempfile::tempdir().unwrap();
    for (meters, expected) in [
        (1e-3, None),
        (0.0, INVALID),
        (-1.0, INVALID),
        (f64::NAN, INVALID),
        (f64::INFINITY, INVALID),
    ] {
        for format in MESH_FORMATS {
            assert_eq!(
                kind(format.write(&skin(), meters, &mut Vec::new())),
                expected
            );
        }
        for format in FILM_FORMATS {
            let mut film = Film::new(format, 24.0, folder.path());
            film.add_skin(&skin()).expect("a frame");
            assert_eq!(
                kind(film.write(meters, &mut Vec::new())),
                expected,
                "{meters}"
            );
        }
        let scene = Scene {
            meters_per_unit: meters,
            ..sound.clone()
        };
        for format in SCENE_FORMATS {
            let written = format.write(What::Points, &scene, &|_| [0; 3], &mut Vec::new());
            assert_eq!(kind(written), expected, "{} {meters}", format.extension);
        }
    }
}

#[test]
fn tables_that_are_not_sound_are_on_no_mesh() {
    let plane = common::plane(1.0);
    let sound = elements(&plane);
    let wrongs: [(Wrong<Elements>, &str); 5] = [
        (|table| table.uv.clear(), "column 'uv' has 0 rows"),
        (|table| table.normals.truncate(3), "column 'normal'"),
        (|table| table.parent[3] = 1000, "element 3: parent"),
        (
            |table| table.positions[3][0] = 1e155,
            "element 3: position is beyond",
        ),
        (|table| table.radius = 1e-310, "the radius"),
    ];
    assert!(sound.to_cluster(&plane).is_ok());
    for (wrong, problem) in wrongs {
        let mut table = sound.clone();
        wrong(&mut table);
        let refused = [
            table.places_on(&plane).err(),
            table.to_cluster(&plane).err(),
            table.to_cluster_on_turned(&plane).err(),
            table.of_colony(0).err().map(NotOnMesh::Table),
        ];
        for refused in refused {
            let said = refused
                .as_ref()
                .map(ToString::to_string)
                .unwrap_or_default();
            assert!(matches!(refused, Some(NotOnMesh::Table(_))) && said.contains(problem));
        }
    }
    let empty = Elements::default();
    assert_eq!(empty.places_on(&plane).map(|places| places.len()), Ok(0));
    let refused = [
        empty.to_cluster(&plane).err(),
        empty.to_cluster_on_turned(&plane).err(),
    ];
    assert_eq!(refused, [0; 2].map(|_| Some(TableError::Radius.into())));
    let of_a_size = Elements {
        radius: sound.radius,
        ..empty
    };
    assert_eq!(of_a_size.to_cluster(&plane).map(|c| c.len()), Ok(0));
    let other = common::rock(12);
    let refused = sound.places_on(&other);
    assert!(
        matches!(refused, Err(NotOnMesh::Element { .. })),
        "{refused:?}"
    );
    let mut ragged = sound;
    ragged.colony.pop();
    assert!(matches!(
        ragged.check(),
        Err(TableError::Ragged {
            column: "colony",
            ..
        })
    ));
}

#[test]
fn rings_have_a_width() {
    let plane = common::plane(1.0);
    let places = [0, 1].map(SurfacePoint::centroid);
    let metric = SurfaceMetric::new(&plane, &places);
    for width in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let said = panicked(|| metric.ring_areas(0, width, 4));
        assert!(said.contains("a positive width"), "{said}");
    }
    assert_eq!(metric.ring_areas(0, 1e-300, 4), None);
    let narrow = metric.ring_areas(0, 1e-9, 4).expect("rings");
    let flat = std::f64::consts::PI * 1e-18;
    assert!((narrow[0] - flat).abs() < 0.02 * flat, "{narrow:?}");
    let said = panicked(|| metric.within(0, &[0.9, 0.1]));
    assert!(said.contains("do not ascend"), "{said}");
}

#[test]
fn nothing_cannot_be_measured() {
    let plane = common::plane(1.0);
    let measured = Analysis::of(&plane, &Cluster::new(0.1), Centres::default());
    assert_eq!(measured, Err(AnalysisError::Empty));
}

/// Lines of no end were drawn for ever, and sheets had no room for them.
#[test]
fn lengths_in_pictures_end_with_them() {
    let picture = |share: f32| {
        let mut image = Image {
            width: 300,
            height: 200,
            rgb: vec![0; 3 * 300 * 200],
            alpha: None,
        };
        let label = "1 mm";
        draw_legend(&mut image, &[Key::Length { label, share }]);
        image
    };
    for share in [1e7, f32::INFINITY] {
        assert!(picture(share) == picture(1.0), "{share}");
    }
    for share in [-1.0, f32::NEG_INFINITY, f32::NAN] {
        assert!(picture(share) == picture(0.0), "{share}");
    }
    let sheet = ContactSheet {
        columns: vec![String::new()],
        rows: vec![String::new()],
        tiles: vec![Tile::default()],
        side: [40, 40],
        scale: Some(("1 mm".to_owned(), f32::INFINITY)),
        ..ContactSheet::default()
    };
    assert!(sheet.draw().width < 400);
}

#[test]
fn masks_are_for_one_mesh() {
    let [plane, wider] = [1.0, 2.0].map(common::plane);
    let beside = |substrate: &Substrate| Mask::beside(substrate, &[DVec3::ZERO], 0.1);
    let mask = beside(&plane);
    assert!(
        common::plane(1.0)
            .with_mask(Some(mask.clone()))
            .mask()
            .is_some()
    );
    assert_eq!(mask.at(&SurfacePoint::centroid(1)), 1.0);
    panicked(|| mask.at(&SurfacePoint::centroid(2)));
    let said = panicked(|| wider.with_mask(Some(mask.clone())));
    assert_eq!(said, "another mesh's mask");
    let said = panicked(|| mask.and(beside(&common::plane(3.0))));
    assert_eq!(said, "masks of different meshes");
    for (place, radius) in [
        (0.0, f64::NAN),
        (0.0, -1.0),
        (0.0, f64::INFINITY),
        (f64::NAN, 0.1),
    ] {
        let said = panicked(|| Mask::beside(&plane, &[DVec3::splat(place)], radius));
        assert!(said.contains("nowhere"), "{said}");
    }
}

#[test]
fn nothing_is_within_a_negative_radius() {
    let plane = common::plane(1.0);
    let centre = plane.position(&SurfacePoint::centroid(0));
    let within = |radius: f64| plane.triangles_within(centre, radius).len();
    assert_eq!([1e-3, 1e3].map(within), [1, 2]);
    assert_eq!([-1e3, f64::NAN, -f64::INFINITY].map(within), [0; 3]);
}
