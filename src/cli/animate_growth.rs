//! What is animated, and when.

use std::path::{Path, PathBuf};

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use thallus::animate::{Clock, Curve, Timing};
use thallus::cluster::Cluster;
use thallus::input;
use thallus::picture::Ground;
use thallus::substrate::{Substrate, Texturing};

use super::also::{Also, tell_of_overlaps};
use super::animate_args::{AnimateArgs, TimeArgs, Window};
use super::dress::Dress;
use super::failure::Failure;
use super::grown::{Grown, Origin};
use super::render_args::What as Drawn;

/// A lichen on its mesh.
pub(super) struct Growth {
    pub(super) grown: Grown,
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
    pub(super) fn read(args: &AnimateArgs, is_pictured: bool) -> Result<Self, Failure> {
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
        files.extend(args.picture.shot.ground.as_ref().and_then(Dress::file));
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
