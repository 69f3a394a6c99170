//! Pictures of a growth: numbered PNGs, a GIF, or a film by ffmpeg.

use std::cell::LazyCell;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::iter;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::spawn;

use anyhow::Context;
use thallus::appearance::Appearance;
use thallus::cluster::{Cluster, Presence};
use thallus::export::{TriMesh, write_file_atomically};
use thallus::picture::{
    Camera, Disc, Finish, GifPacker, GifPalette, GifWriter, Ground, Image, Painted, Scene,
    Settings, Stone, Structure, TimeLapse, World,
};
use thallus::skin::{Cover, Paint, Shape, SkinError, SkinFrames};

use super::animate_args::AnimateArgs;
use super::animate_growth::{Growth, bar, timing};
use super::animate_out::{Folder, Movie, Pictures, nearest_folder};
use super::dress::{self, made_up};
use super::failure::Failure;
use super::interrupt::{Hidden, Stop};
use super::memory::{self, Frames};
use super::preview::{bare, by_age, packed, staged, stone};
use super::render::{Cut, Skin, middle};
use super::render_args::What;
use super::render_camera::warn_unseen;
use super::skin_args::ColorArgs;
use super::skin_look::Measure;

pub(super) fn pictures(
    args: &AnimateArgs,
    target: &Pictures,
    lichen: &Growth,
    moments: Vec<Presence>,
    stop: &Stop,
) -> Result<(), Failure> {
    memory::check_sizes(sides(args))?;
    let shots = Shots::new(args, lichen)?;
    let mut lapse = shots.time_lapse();
    let moments = moments_of_all(args, target, lichen, moments)?;
    match args.picture.draw {
        What::Points => {
            let mut take = |frame: usize| lapse.take(&shots.granules(&moments, frame), &[]);
            let images = (0..moments[0].len()).map(|frame| Ok(take(frame)));
            write(args, (target, lichen), images, stop)
        }
        What::Skin => {
            let looks = looks(args, lichen)?;
            let mut skins = Skins::new(lichen, &looks, moments)?;
            let too_coarse = AtomicBool::new(false);
            let next = || match skins.next()? {
                true => Some(Ok(shots.of_skins(&mut lapse, &mut skins))),
                false => {
                    too_coarse.store(true, Ordering::Relaxed);
                    Some(Err(io::Error::other(SkinError::TooCoarse)))
                }
            };
            let made = write(args, (target, lichen), iter::from_fn(next), stop);
            match too_coarse.into_inner() {
                true => Err(Failure::Usage(SkinError::TooCoarse.into())),
                false => made,
            }
        }
    }
}

/// The moments of each lichen, of the first these.
fn moments_of_all(
    args: &AnimateArgs,
    target: &Pictures,
    lichen: &Growth,
    first: Vec<Presence>,
) -> Result<Vec<Vec<Presence>>, Failure> {
    let mut all = vec![first];
    for another in &lichen.others {
        let moments = timing(&args.time, &another.cluster).and_then(|timing| {
            let moments = timing.moments(&another.cluster);
            moments.map_err(|e| Failure::Usage(e.into()))
        });
        all.push(moments.map_err(|e| another.also.failed(e))?);
    }
    // A GIF's palette is chosen by the first picture and the last.
    for moments in all.iter_mut().filter(|_| is_gif(target)) {
        moments.splice(..0, moments.last().copied());
    }
    Ok(all)
}

/// What a lichen looks like.
type Looks = (Shape, Paint);

/// What each looks like; refuses such as do not fit.
fn looks(args: &AnimateArgs, lichen: &Growth) -> Result<Vec<Looks>, Failure> {
    let look = |(cluster, color): (&Cluster, &ColorArgs)| {
        let measure = Measure::of(&lichen.substrate, cluster);
        Ok((measure.shape(&args.shape)?, measure.paint(color)?))
    };
    let mut looks = vec![look((&lichen.cluster, &args.color))?];
    for another in &lichen.others {
        let own = look((&another.cluster, &another.also.color));
        looks.push(own.map_err(|e| another.also.failed(e))?);
    }
    let shapes = lichen.clusters().zip(looks.iter().map(|(shape, _)| shape));
    let pixels = sides(args).map(u64::from).iter().product();
    memory::check_frames(&lichen.substrate, shapes, Frames::Pictures(pixels))?;
    warn_of_covers(args, lichen, &looks)?;
    Ok(looks)
}

/// Says so where one lies over another: both are drawn, and it is by chance which is seen.
fn warn_of_covers(args: &AnimateArgs, lichen: &Growth, looks: &[Looks]) -> Result<(), Failure> {
    /// Of those beside which another grew some are at its rim.
    const MOST_HIDDEN: f64 = 0.1;
    let clusters: Vec<&Cluster> = lichen.clusters().collect();
    for (k, another) in lichen.others.iter().enumerate() {
        let cover = Cover::new(&lichen.substrate, &another.cluster, &looks[k + 1].0);
        let cover = cover.map_err(|e| Failure::Usage(e.into()))?;
        let is_over = |under: &&Cluster| {
            let hidden = cover.hides(&lichen.substrate, under);
            let count = hidden.iter().filter(|hidden| **hidden).count();
            count as f64 > MOST_HIDDEN * hidden.len() as f64
        };
        if clusters[..=k].iter().any(is_over) {
            args.run.voice().warn(&format!(
                "--also {}: it lies over another, and animations show both where they overlap: grow it beside that one \
                 (thallus grow --mask)",
                args.picture.also[k]
            ));
        }
    }
    Ok(())
}

/// The skins of all lichens, moment by moment.
struct Skins<'a> {
    frames: Vec<SkinFrames<'a>>,
    /// Those of the present moment.
    meshes: Vec<TriMesh>,
    /// Which have had a surface.
    shown: Vec<bool>,
}

impl<'a> Skins<'a> {
    fn new(
        lichen: &'a Growth,
        looks: &'a [Looks],
        moments: Vec<Vec<Presence>>,
    ) -> Result<Self, Failure> {
        let each = lichen.clusters().zip(looks).zip(moments);
        let frames = each.map(|((cluster, (shape, paint)), moments)| {
            let frames = SkinFrames::new(&lichen.substrate, cluster, shape, paint, moments);
            Ok(frames.map_err(|e| Failure::Usage(e.into()))?.in_parts())
        });
        let frames: Vec<_> = frames.collect::<Result<_, Failure>>()?;
        Ok(Self {
            meshes: Vec::new(),
            shown: vec![false; frames.len()],
            frames,
        })
    }

    /// Goes on to the next moment, if there is one; false where the last is over and one has had no surface, as only
    /// the first frames may.
    fn next(&mut self) -> Option<bool> {
        let meshes: Option<Vec<TriMesh>> = self.frames.iter_mut().map(Iterator::next).collect();
        self.meshes = meshes?;
        for (shown, mesh) in self.shown.iter_mut().zip(&self.meshes) {
            *shown |= !mesh.triangles.is_empty();
        }
        let is_last = self.frames[0].len() == 0;
        Some(!is_last || self.shown.iter().all(|shown| *shown))
    }
}

/// Writes pictures as they are made.
fn write(
    args: &AnimateArgs,
    (target, lichen): (&Pictures, &Growth),
    images: impl Iterator<Item = io::Result<Image>> + Send,
    stop: &Stop,
) -> Result<(), Failure> {
    let bar = bar(args);
    let ahead = u64::from(is_gif(target));
    let images = (1..).zip(images).map(|(made, image): (u64, _)| {
        bar.set_position(made - ahead);
        stop.check().and(image)
    });
    match target {
        Pictures::Movie(Movie::Gif) => gif(args, images)?,
        Pictures::Movie(kind) => movie(args, *kind, images)?,
        Pictures::Folder => {
            let mut folder = Folder::create(args, "png", lichen)?;
            for png in packed(images, |image| image.to_png()) {
                let png = png.map_err(|e| stop.reason(anyhow::Error::new(e)))?;
                folder.write(|out| out.write_all(&png))?;
            }
            folder.finish()?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

fn is_gif(target: &Pictures) -> bool {
    matches!(target, Pictures::Movie(Movie::Gif))
}

/// The sides of a picture.
fn sides(args: &AnimateArgs) -> [u32; 2] {
    [args.picture.width, args.picture.width * 3 / 4]
}

/// What stays the same from picture to picture: the grown lichen is in view from the start.
struct Shots<'a> {
    lichen: &'a Growth,
    ground: Ground,
    own: Option<Appearance<'a>>,
    stone: Stone,
    /// Of each lichen.
    discs: Vec<Vec<Disc>>,
    camera: Camera,
    settings: Settings,
}

impl<'a> Shots<'a> {
    fn new(args: &AnimateArgs, lichen: &'a Growth) -> Result<Self, Failure> {
        let [width, height] = sides(args);
        let stone = stone(&lichen.substrate)?;
        let discs = lichen
            .clusters()
            .map(|cluster| by_age(&lichen.substrate, cluster));
        let discs: Vec<Vec<Disc>> = discs.collect();
        let all = discs.concat();
        let grown = LazyCell::new(|| {
            World::new(&Scene {
                discs: &all,
                ..bare(&lichen.substrate, &stone)
            })
        });
        let view = &args.picture.shot;
        let dress = view.ground.as_ref();
        let looks = (&lichen.substrate, &lichen.texturing);
        let aspect = width as f32 / height as f32;
        let camera = view.camera.camera(&lichen.substrate, &grown, aspect)?;
        let camera = view.zoomed(&camera, &grown, (middle(&discs[0]), aspect));
        warn_unseen(&camera, &grown, aspect, args.run.voice());
        drop(grown);
        Ok(Self {
            camera,
            lichen,
            ground: made_up(dress),
            own: dress::appearance(dress, looks, &lichen.mesh, args.run.voice())?,
            stone,
            discs,
            settings: Settings {
                width,
                height,
                samples: view.samples,
                background: view.background,
            },
        })
    }

    fn time_lapse(&self) -> TimeLapse<'_> {
        let all = self.discs.concat();
        let bare = staged(&self.lichen.substrate, &self.stone, self.ground, &all);
        let bare = Scene {
            finish: self.own.as_ref().map(|own| own as &dyn Finish),
            ..bare
        };
        TimeLapse::new(bare, self.camera, self.settings)
    }

    /// Elements swell with their influence.
    fn granules(&self, moments: &[Vec<Presence>], frame: usize) -> Vec<Disc> {
        let of_one = |(discs, moments): (&Vec<Disc>, &Vec<Presence>)| {
            let moment = moments[frame];
            let born = discs.iter().take(moment.born(discs.len())).enumerate();
            let swollen = born.map(|(birth, disc)| Disc {
                radius: disc.radius * moment.influence(birth),
                ..*disc
            });
            swollen.collect::<Vec<_>>()
        };
        self.discs.iter().zip(moments).flat_map(of_one).collect()
    }

    fn of_skins(&self, lapse: &mut TimeLapse, skins: &mut Skins) -> Image {
        let substrate = &self.lichen.substrate;
        let meshes = std::mem::take(&mut skins.meshes);
        let drawn: Vec<Skin> = self
            .lichen
            .clusters()
            .zip(meshes)
            .map(|(cluster, mesh)| Skin::new(substrate, mesh, cluster.radius() as f32))
            .collect();
        let cuts: Vec<_> = skins
            .frames
            .iter()
            .zip(&drawn)
            .map(|(frames, skin)| {
                let cortex = frames.cortex()?;
                Some(Cut::new(cortex, substrate, skin))
            })
            .collect();
        let painted = drawn.iter().zip(&cuts).map(|(skin, cut)| Painted {
            structure: cut.as_ref().map(|cut| cut as &dyn Structure),
            ..skin.painted()
        });
        lapse.take(&[], &painted.collect::<Vec<_>>())
    }
}

/// Of the last picture, and then all of them.
fn gif(
    args: &AnimateArgs,
    mut images: impl Iterator<Item = io::Result<Image>> + Send,
) -> Result<(), Failure> {
    write_file_atomically(&args.output, args.force, |out| {
        let mut next = || {
            images
                .next()
                .unwrap_or_else(|| Err(io::ErrorKind::UnexpectedEof.into()))
        };
        let (last, first) = (next()?, next()?);
        let palette = GifPalette::new(&first, &last);
        let mut gif = GifWriter::new(out, sides(args), args.time.fps, &palette)?;
        let mut packer = GifPacker::new(&palette);
        let images = iter::once(Ok(first)).chain(images);
        for picture in packed(images, |image| packer.pack(image)) {
            gif.add(picture?)?;
        }
        Ok(())
    })?;
    Ok(())
}

/// A film by ffmpeg, which writes a file of its own: its bytes are taken when it is done.
fn movie(
    args: &AnimateArgs,
    kind: Movie,
    images: impl Iterator<Item = io::Result<Image>>,
) -> Result<(), Failure> {
    let folder = Hidden::make_in(&nearest_folder(&args.output));
    let folder = folder.with_context(|| format!("{}: making a folder", args.output.display()))?;
    let made = folder.path().join("movie");
    let mut ffmpeg = start(args, kind, &made)?;
    // It stops to take pictures while nobody reads what it says.
    let listener = ffmpeg.stderr.take().map(|says| spawn(|| last_line(says)));
    let fed = feed(&mut ffmpeg, images);
    let done = ffmpeg.wait().context("waiting for ffmpeg")?;
    let said = listener.and_then(|listener| listener.join().ok().flatten());
    if let Err(Fed::Image(error)) = fed {
        return Err(Failure::Failed(error.into()));
    }
    if !done.success() || fed.is_err() {
        let said = said.unwrap_or_else(|| "it said nothing".to_owned());
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

/// Frames a second as ffmpeg takes them: those of television, which are written with decimals, as what they mean.
fn rate(fps: f64) -> String {
    let is_meant = |whole: &i32| (fps - f64::from(*whole) / 1.001).abs() < 1e-3;
    match [24, 30, 60, 120].into_iter().find(is_meant) {
        Some(whole) => format!("{whole}000/1001"),
        None => fps.to_string(),
    }
}

fn start(args: &AnimateArgs, kind: Movie, made: &Path) -> Result<Child, Failure> {
    let (codec, container) = match kind {
        Movie::Webm => (["libvpx-vp9", "-crf", "24", "-b:v", "0"].as_slice(), "webm"),
        _ => (
            ["libx264", "-crf", "18", "-movflags", "+faststart"].as_slice(),
            "mp4",
        ),
    };
    let [width, height] = sides(args);
    let pixels = format!("{width}x{height}");
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
        .args([&pixels, "-r", &rate(args.time.fps), "-i", "-"])
        // These codecs halve the colours' resolution, and want even sides. Players take what is not told by its
        // size, which is not how ffmpeg encodes it.
        .args([
            "-vf",
            concat!(
                "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p,",
                "setparams=color_primaries=bt709:color_trc=iec61966-2-1:colorspace=bt709"
            ),
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

/// Why not all pictures went to ffmpeg.
enum Fed {
    /// One of them could not be made.
    Image(io::Error),
    /// It takes no more.
    Closed,
}

fn feed(
    ffmpeg: &mut Child,
    mut images: impl Iterator<Item = io::Result<Image>>,
) -> Result<(), Fed> {
    let mut input = ffmpeg.stdin.take().ok_or(Fed::Closed)?;
    images.try_for_each(|image| {
        let image = image.map_err(Fed::Image)?;
        input.write_all(&image.rgb).map_err(|_| Fed::Closed)
    })
}

/// Of all that is said, the last.
fn last_line(says: impl Read) -> Option<String> {
    let lines = BufReader::new(says).split(b'\n');
    let last = lines.map_while(Result::ok).last()?;
    Some(String::from_utf8_lossy(&last).into_owned())
}

#[cfg(test)]
mod tests {
    use super::rate;

    #[test]
    fn rates_of_television_are_fractions() {
        assert_eq!(rate(23.976), "24000/1001");
        assert_eq!(rate(29.97), "30000/1001");
        assert_eq!(rate(59.94), "60000/1001");
        assert_eq!(
            ["24", "29.9", "60"],
            [24.0, 29.9, 60.0].map(rate).as_slice()
        );
    }
}
