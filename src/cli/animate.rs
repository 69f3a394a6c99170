//! `thallus animate`: the growth of a run's lichen, a frame after the other.

use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use thallus::cluster::{Element, Presence};
use thallus::export::{
    Film, FilmFormat, MeshFormat, Placement, Scene, SceneFormat, TriMesh, UpAxis, What,
    write_file_atomically,
};
use thallus::morphometry::measure;
use thallus::picture::age_color;
use thallus::skin::{SkinError, SkinFrames};

use super::animate_args::{AnimateArgs, Subject};
use super::animate_growth::{Growth, bar, timing};
use super::animate_out::{Folder, Shapes, Target, nearest_folder};
use super::animate_picture;
use super::axes::Convention;
use super::export::{number_on, smooth_on};
use super::failure::Failure;
use super::interrupt::Stop;
use super::memory::{self, Frames};
use super::number::{duration, plural};
use super::run_args::start_threads;
use super::skin_look::Measure;
use super::terminal;

pub(crate) fn animate(args: &AnimateArgs) -> Result<(), Failure> {
    let target = Target::of(args)?;
    start_threads(args.run.threads)?;
    let started = Instant::now();
    let lichen = Growth::read(args, target.subject() == Subject::Picture)?;
    let moments = timing(&args.time, &lichen.cluster)?.moments(&lichen.cluster);
    let moments = moments.map_err(|e| Failure::Usage(e.into()))?;
    let stop = Stop::listen();
    let made = match &target {
        Target::Skin(to) => skins(args, to, &lichen, moments, &stop),
        Target::Scene(what, to) => scenes(args, to, lichen, (&moments, *what), &stop),
        Target::Picture(to) => animate_picture::pictures(args, to, &lichen, moments, &stop),
    };
    // Whatever it failed with then comes of that.
    made.map_err(|e| {
        if stop.is_told() {
            Failure::Interrupted
        } else {
            e
        }
    })?;
    if !args.run.quiet {
        let frames = plural(args.time.frames as usize, "frame", "frames");
        let seconds = duration(started.elapsed().as_secs_f64());
        terminal::say(&format!("{}: {frames} in {seconds}", args.output.display()))?;
    }
    Ok(())
}

fn skins(
    args: &AnimateArgs,
    to: &Shapes<MeshFormat>,
    lichen: &Growth,
    moments: Vec<Presence>,
    stop: &Stop,
) -> Result<(), Failure> {
    let measure = Measure::of(&lichen.substrate, &lichen.cluster);
    let shape = measure.shape(&args.shape)?;
    let paint = measure.paint(&args.color)?;
    memory::check_frames(
        &lichen.substrate,
        [(&lichen.cluster, &shape)],
        Frames::Meshes,
    )?;
    let up = Some(lichen.substrate.up_axis());
    let frames = SkinFrames::new(&lichen.substrate, &lichen.cluster, &shape, &paint, moments);
    let frames = frames.map_err(|e| Failure::Usage(e.into()))?;
    let bar = bar(args);
    match to {
        Shapes::Film(format) => {
            let convention = Convention::from(*format);
            let placement = args.axes.placement(&convention, up)?;
            let meters = args.axes.meters_per_unit(&convention);
            let film = new_film(args, format).about(&places(lichen, &placement));
            write_film(args, film, meters, |film| {
                each(frames, |mut mesh| {
                    stop.go_on()?;
                    mesh.place(&placement);
                    bar.inc(1);
                    film.add_skin(&mesh).map_err(spooling(&args.output))
                })
            })?;
        }
        Shapes::Folder(format) => {
            let convention = Convention::from(*format);
            let placement = args.axes.placement(&convention, up)?;
            let meters = args.axes.meters_per_unit(&convention);
            let mut folder = Folder::create(args, format.extension, lichen)?;
            let whole = places(lichen, &placement);
            each(frames, |mut mesh| {
                stop.go_on()?;
                mesh.place(&placement);
                mesh.lie_with(&whole);
                bar.inc(1);
                folder.write(|out| format.write(&mesh, meters, out))
            })?;
            folder.finish()?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

/// Takes each frame while the next is being made. The first ones may have no surface yet, but not all.
fn each(
    mut frames: SkinFrames<'_>,
    mut take: impl FnMut(TriMesh) -> Result<(), Failure> + Send,
) -> Result<(), Failure> {
    let mut ready = frames.next();
    let mut shown = false;
    while let Some(frame) = ready {
        shown |= !frame.triangles.is_empty();
        let (taken, next) = rayon::join(|| take(frame), || frames.next());
        taken?;
        ready = next;
    }
    match shown {
        true => Ok(()),
        false => Err(Failure::Usage(SkinError::TooCoarse.into())),
    }
}

fn scenes(
    args: &AnimateArgs,
    to: &Shapes<SceneFormat>,
    lichen: Growth,
    (moments, what): (&[Presence], What),
    stop: &Stop,
) -> Result<(), Failure> {
    let up = Some(lichen.substrate.up_axis());
    let bar = bar(args);
    match to {
        Shapes::Film(format) => {
            let convention = Convention::from(*format);
            let scene = scene(args, lichen, &convention, up)?;
            write_film(
                args,
                new_film(args, format),
                scene.meters_per_unit,
                |film| {
                    frames_of(&scene, what, moments, |frame, color| {
                        stop.go_on()?;
                        bar.inc(1);
                        film.add_scene(what, frame, color)
                            .map_err(spooling(&args.output))
                    })
                },
            )?;
        }
        Shapes::Folder(format) => {
            let mut folder = Folder::create(args, format.extension, &lichen)?;
            let scene = scene(args, lichen, &Convention::from(*format), up)?;
            frames_of(&scene, what, moments, |frame, color| {
                stop.go_on()?;
                bar.inc(1);
                folder.write(|out| format.write(what, frame, color, out))
            })?;
            folder.finish()?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

fn scene(
    args: &AnimateArgs,
    lichen: Growth,
    convention: &Convention,
    up: Option<UpAxis>,
) -> Result<Scene, Failure> {
    let placement = args.axes.placement(convention, up)?;
    let Growth {
        mut grown,
        mesh,
        substrate,
        ..
    } = lichen;
    let found = smooth_on(&mut grown.elements, &substrate);
    let (places, _) = found.with_context(|| mesh.display().to_string())?;
    number_on(&mut grown.elements, &substrate, &places);
    let measured = measure(&grown.elements.sample(), grown.curvature_radius());
    let meters = args.axes.meters_per_unit(convention);
    Ok(Scene::new(grown.elements, measured, &placement, meters))
}

/// Gives each moment of a scene, coloured by age as the grown lichen is.
fn frames_of(
    scene: &Scene,
    what: What,
    moments: &[Presence],
    mut take: impl FnMut(&Scene, &dyn Fn(f32) -> [u8; 3]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let all = scene.elements.len();
    // Files are not empty: a seed, or the first branch.
    let least = match what {
        What::Curves => scene
            .elements
            .parent
            .iter()
            .position(|p| *p >= 0)
            .map_or(all, |i| i + 1),
        _ => 1,
    };
    for moment in moments {
        let frame = scene.at(moment, least);
        let part =
            frame.elements.len().saturating_sub(1) as f32 / all.saturating_sub(1).max(1) as f32;
        take(&frame, &|age| age_color(age * part))?;
    }
    Ok(())
}

/// Where the elements lie in the file.
fn places(lichen: &Growth, placement: &Placement) -> TriMesh {
    // Those of the substrate: a program may have turned it since the elements were written.
    let (elements, units) = (lichen.cluster.elements(), lichen.substrate.units());
    let place = |e: &Element| units.to_file(e.position).to_array();
    let mut places = TriMesh {
        positions: elements.iter().map(place).collect(),
        ..TriMesh::default()
    };
    places.place(placement);
    places
}

fn new_film(args: &AnimateArgs, format: &FilmFormat) -> Film {
    let film = Film::new(format, args.time.fps, &nearest_folder(&args.output));
    film.starting_at(args.time.start)
}

/// Makes a film, and writes it complete or not at all.
fn write_film(
    args: &AnimateArgs,
    mut film: Film,
    meters: f64,
    fill: impl FnOnce(&mut Film) -> Result<(), Failure>,
) -> Result<(), Failure> {
    fill(&mut film)?;
    write_file_atomically(&args.output, args.force, |out| film.write(meters, out))?;
    Ok(())
}

fn spooling(film: &Path) -> impl Fn(std::io::Error) -> Failure {
    move |error| {
        let shown = film.display();
        Failure::Failed(anyhow::Error::new(error).context(format!(
            "{shown}: its frames are kept beside it until it is whole, and cannot be: choose a place with room, where \
             you may write"
        )))
    }
}
