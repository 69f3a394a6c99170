//! `thallus animate`: the growth of a run's lichen, a frame after the other.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use thallus::animate::{Clock, Curve, Timing};
use thallus::cluster::{Cluster, Element, Presence};
use thallus::export::{
    Film, FilmFormat, MeshFormat, Placement, Scene, SceneFormat, TriMesh, UpAxis, What,
    write_file_atomically,
};
use thallus::input;
use thallus::morphometry::measure;
use thallus::picture::{Ground, age_color};
use thallus::skin::{SkinError, SkinFrames};
use thallus::substrate::{Substrate, Texturing};

use super::also::{Also, tell_of_overlaps};
use super::animate_args::{AnimateArgs, Subject, TimeArgs, Window};
use super::animate_out::{Folder, Shapes, Target, nearest_folder};
use super::animate_picture;
use super::axes::Convention;
use super::dress::Dress;
use super::export::smooth_on;
use super::failure::Failure;
use super::grown::{Grown, Origin};
use super::interrupt::Stop;
use super::memory::{self, Frames};
use super::number::{duration, plural};
use super::render_args::What as Drawn;
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

/// A lichen on its mesh.
pub(super) struct Growth {
    grown: Grown,
    pub(super) mesh: PathBuf,
    pub(super) substrate: Substrate,
    /// Where pictures are made.
    pub(super) texturing: Texturing,
    pub(super) cluster: Cluster,
    /// Beside it, in pictures.
    pub(super) others: Vec<Another>,
}

/// Another lichen on the same mesh.
pub(super) struct Another {
    pub(super) also: Also,
    origin: Origin,
    /// Files that it was read from.
    read: Vec<PathBuf>,
    pub(super) cluster: Cluster,
}

impl Another {
    fn read(text: &str, args: &AnimateArgs, substrate: &Substrate) -> Result<Self, Failure> {
        let also = Also::parse(text, &args.color);
        let found = Self::of(&also, args, substrate);
        let (grown, cluster) = found.map_err(|e| also.failed(e))?;
        Ok(Self {
            also,
            origin: grown.origin(),
            read: grown.files(&args.mesh),
            cluster,
        })
    }

    fn of(
        also: &Also,
        args: &AnimateArgs,
        substrate: &Substrate,
    ) -> Result<(Grown, Cluster), Failure> {
        if also.names_colors && args.picture.draw == Drawn::Points {
            return Err(Failure::usage(
                "granules are coloured by age: leave the colour map away, or draw skins",
            ));
        }
        let (grown, cluster) = also.read(substrate, args.run.voice())?;
        grown.spare(&args.output, &args.mesh)?;
        Ok((grown, cluster))
    }
}

impl Growth {
    fn read(args: &AnimateArgs, is_pictured: bool) -> Result<Self, Failure> {
        let voice = args.run.voice();
        let grown = Grown::read(&args.from, voice)?;
        grown.spare(&args.output, &args.mesh)?;
        let mesh = grown.file_of(&args.mesh)?;
        // Where nothing is drawn, nothing is asked of its looks.
        let bare = Dress::Drawn(Ground::default());
        let dress = match is_pictured {
            true => args.picture.shot.ground.as_ref(),
            false => Some(&bare),
        };
        let (substrate, cluster, texturing) = grown.on_dressed(&mesh, &args.mesh, dress)?;
        let texts = args.picture.also.iter();
        let others = texts.map(|text| Another::read(text, args, &substrate));
        let others = others.collect::<Result<Vec<_>, _>>()?;
        let origin = grown.origin();
        let first = std::iter::once((&origin, &cluster));
        let all = first.chain(others.iter().map(|a| (&a.origin, &a.cluster)));
        tell_of_overlaps(&substrate, all, voice);
        Ok(Self {
            grown,
            mesh,
            substrate,
            texturing,
            cluster,
            others,
        })
    }

    /// Files that all this was read from.
    pub(super) fn files(&self, args: &AnimateArgs) -> Vec<PathBuf> {
        let mut files = self.grown.files(&args.mesh);
        files.extend(self.texturing.image_files.iter().cloned());
        files.extend(self.others.iter().flat_map(|another| another.read.clone()));
        files.extend({ args.picture.shot.ground.as_ref() }.and_then(Dress::file));
        files
    }

    /// The first, and those beside it.
    pub(super) fn clusters(&self) -> impl Iterator<Item = &Cluster> {
        std::iter::once(&self.cluster).chain(self.others.iter().map(|a| &a.cluster))
    }
}

pub(super) fn timing(args: &TimeArgs, cluster: &Cluster) -> Result<Timing, Failure> {
    let (clock, all) = (clock(&args.clock)?, cluster.len());
    let window = Window::elements(args.window, all, clock.end(all), args.frames);
    Ok(Timing {
        frames: args.frames,
        window: window.map_err(Failure::usage)?,
        ease: args.ease,
        clock,
    })
}

fn clock(text: &str) -> Result<Clock, Failure> {
    let wrong = |of: &str, e| Failure::Usage(anyhow::Error::new(e).context(of.to_owned()));
    match text {
        "birth" => Ok(Clock::Birth),
        "radius" => Ok(Clock::Radius),
        curve if curve.contains(':') && !Path::new(curve).exists() => {
            let curve: Result<Curve, _> = curve.parse();
            Ok(Clock::Curve(curve.map_err(|e| wrong("--clock", e))?))
        }
        file if Path::new(file).exists() => {
            let text = input::text(Path::new(file));
            let text = text.with_context(|| format!("{file}: reading the curve failed"))?;
            let curve = Curve::from_csv(&text).map_err(|e| wrong(file, e))?;
            Ok(Clock::Curve(curve))
        }
        other => Err(Failure::usage(format!(
            "--clock: '{other}' is neither birth, radius, a curve as 0:0,1:5%,4:100% nor a file"
        ))),
    }
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
            each(frames, |mut mesh| {
                stop.go_on()?;
                mesh.place(&placement);
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
    found.with_context(|| mesh.display().to_string())?;
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
    Film::new(format, args.time.fps, &nearest_folder(&args.output))
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

/// How many frames are done, on a terminal.
pub(super) fn bar(args: &AnimateArgs) -> ProgressBar {
    if args.run.quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(u64::from(args.time.frames));
    let style = ProgressStyle::with_template("{spinner} {bar:16} frame {pos} of {len}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
