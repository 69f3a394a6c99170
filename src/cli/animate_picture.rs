//! Pictures of a growth: numbered PNGs, a GIF, or a film by ffmpeg.

use std::io::{self, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use anyhow::Context;
use thallus::cluster::Presence;
use thallus::export::write_file_atomically;
use thallus::picture::{Camera, Disc, GifWriter, Image, Scene, Settings, render};

use super::animate::{Growth, bar};
use super::animate_args::AnimateArgs;
use super::animate_out::{Folder, Movie, Target, nearest_folder};
use super::failure::Failure;
use super::preview::{bare, by_age, local_vertices};

pub(super) fn pictures(
    args: &AnimateArgs,
    target: &Target,
    lichen: &Growth,
    moments: &[Presence],
) -> Result<(), Failure> {
    let bar = bar(args);
    let shots = Shots::new(args, lichen);
    let images = moments.iter().map(|moment| {
        bar.inc(1);
        shots.take(moment)
    });
    match target {
        Target::Movie { kind: Movie::Gif } => gif(args, &shots.settings, images)?,
        Target::Movie { kind } => movie(args, *kind, &shots.settings, images)?,
        _ => {
            let mut folder = Folder::create(args, "png")?;
            for image in images {
                folder.write(|out| out.write_all(&image.to_png()))?;
            }
            folder.finish()?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

/// What stays the same from picture to picture: the grown lichen is in view from the start.
struct Shots<'a> {
    lichen: &'a Growth,
    vertices: Vec<[f32; 3]>,
    discs: Vec<Disc>,
    camera: Camera,
    settings: Settings,
}

impl<'a> Shots<'a> {
    fn new(args: &AnimateArgs, lichen: &'a Growth) -> Self {
        let settings = Settings {
            width: args.width,
            height: args.width * 3 / 4,
            ..Settings::default()
        };
        let vertices = local_vertices(&lichen.substrate);
        let discs = by_age(&lichen.substrate, &lichen.cluster);
        let aspect = settings.width as f32 / settings.height as f32;
        let camera = Camera::best_view(&scene(lichen, &vertices, &discs), aspect);
        Self {
            lichen,
            vertices,
            discs,
            camera,
            settings,
        }
    }

    /// Elements swell with their influence.
    fn take(&self, moment: &Presence) -> Image {
        let born = moment.born(self.discs.len());
        let disc = |(birth, disc): (usize, &Disc)| Disc {
            radius: disc.radius * moment.influence(birth),
            ..*disc
        };
        let discs: Vec<Disc> = self.discs[..born].iter().enumerate().map(disc).collect();
        let scene = scene(self.lichen, &self.vertices, &discs);
        render(&scene, &self.camera, &self.settings)
    }
}

fn scene<'a>(lichen: &'a Growth, vertices: &'a [[f32; 3]], discs: &'a [Disc]) -> Scene<'a> {
    Scene {
        discs,
        ..bare(&lichen.substrate, vertices)
    }
}

fn gif(
    args: &AnimateArgs,
    size: &Settings,
    images: impl Iterator<Item = Image>,
) -> Result<(), Failure> {
    write_file_atomically(&args.output, args.force, |out| {
        let mut gif = GifWriter::new(out, size.width, size.height, args.time.fps)?;
        for image in images {
            gif.add(&image)?;
        }
        Ok(())
    })?;
    Ok(())
}

/// A film by ffmpeg, which writes a file of its own: its bytes are taken when it is done.
fn movie(
    args: &AnimateArgs,
    kind: Movie,
    size: &Settings,
    images: impl Iterator<Item = Image>,
) -> Result<(), Failure> {
    let folder = tempfile::tempdir_in(nearest_folder(&args.output));
    let folder = folder.with_context(|| format!("{}: making a folder", args.output.display()))?;
    let made = folder.path().join("movie");
    let mut ffmpeg = start(args, kind, size, &made)?;
    let fed = feed(&mut ffmpeg, images);
    let done = ffmpeg.wait_with_output().context("waiting for ffmpeg")?;
    if !done.status.success() || fed.is_err() {
        let said = String::from_utf8_lossy(&done.stderr);
        let said = said.lines().last().unwrap_or("it said nothing").to_owned();
        let shown = args.output.display();
        return Err(Failure::Failed(anyhow::anyhow!(
            "{shown}: ffmpeg failed: {said}; write a .gif or a folder of pictures instead"
        )));
    }
    write_file_atomically(&args.output, args.force, |out| {
        io::copy(&mut std::fs::File::open(&made)?, out).map(drop)
    })?;
    Ok(())
}

fn start(args: &AnimateArgs, kind: Movie, size: &Settings, made: &Path) -> Result<Child, Failure> {
    let (codec, container) = match kind {
        Movie::Webm => (["libvpx-vp9", "-crf", "24", "-b:v", "0"].as_slice(), "webm"),
        _ => (
            ["libx264", "-crf", "18", "-movflags", "+faststart"].as_slice(),
            "mp4",
        ),
    };
    let pixels = format!("{}x{}", size.width, size.height);
    let mut command = Command::new("ffmpeg");
    command
        .args([
            "-y",
            "-loglevel",
            "error",
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "-s",
        ])
        .args([&pixels, "-r", &args.time.fps.to_string(), "-i", "-"])
        // These codecs halve the colours' resolution, and want even sides.
        .args([
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2",
            "-pix_fmt",
            "yuv420p",
            "-c:v",
        ])
        .args(codec)
        .args(["-f", container])
        .arg(made)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command.spawn().map_err(|e| match e.kind() {
        io::ErrorKind::NotFound => Failure::Failed(anyhow::anyhow!(
            "{}: there is no ffmpeg to make it with: install ffmpeg, or write a .gif or a folder of \
             pictures (--what picture)",
            args.output.display()
        )),
        _ => Failure::Failed(anyhow::Error::new(e).context("starting ffmpeg")),
    })
}

fn feed(ffmpeg: &mut Child, mut images: impl Iterator<Item = Image>) -> io::Result<()> {
    let mut input = ffmpeg.stdin.take().ok_or(io::ErrorKind::BrokenPipe)?;
    images.try_for_each(|image| input.write_all(&image.rgb))
}
