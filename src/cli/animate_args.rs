//! The arguments of `thallus animate` as they are typed.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::TypedValueParser;
use thallus::animate::Timing;
use thallus::cluster::Ease;
use thallus::export::{FILM_FORMATS, FilmFormat};

use super::axes::AxesArgs;
use super::choice::choice;
use super::given::Given;
use super::mesh_args::MeshArgs;
use super::render_args::{ShotArgs, What, what};
use super::run_args::{RUN, RunArgs};
use super::skin_args::{ColorArgs, ShapeArgs};

#[derive(Debug, Args)]
pub(crate) struct AnimateArgs {
    /// The folder of a run, or its elements.ply
    #[arg(value_name = "DIR|elements.ply")]
    pub(crate) from: PathBuf,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    #[arg(short, long, value_name = "OUT", help = output_help())]
    pub(crate) output: PathBuf,
    /// What to show: a coloured mesh; one point per element; the branches; or pictures of the lichen on the mesh
    /// [default: what the output is for]
    #[arg(long, value_parser = subject(), hide_possible_values = true, value_name = "skin|points|curves|picture")]
    pub(crate) what: Option<Subject>,
    /// Format of numbered files: any that 'thallus skin' or 'thallus export' writes, such as ply, glb, obj or usda; png
    /// for pictures [default: ply, or png]
    #[arg(long, value_name = "EXTENSION")]
    pub(crate) format: Option<String>,
    #[command(flatten)]
    pub(crate) time: TimeArgs,
    #[command(flatten)]
    pub(crate) picture: Given<PictureArgs>,
    #[command(flatten)]
    pub(crate) shape: Given<ShapeArgs>,
    #[command(flatten)]
    pub(crate) color: Given<ColorArgs>,
    #[command(flatten)]
    pub(crate) axes: Given<AxesArgs>,
    /// Overwrite the file, or the frames of an earlier animation in the folder
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArgs {
    /// Width of pictures in pixels, 16 to 16384; they are three quarters as high
    #[arg(long, value_name = "PIXELS", default_value_t = 960, value_parser = clap::value_parser!(u32).range(16..=16384))]
    pub(crate) width: u32,
    /// Another lichen on the same mesh, with its own colour map, that grows in the same time: out/b or out/b,xanthoria.
    /// May be repeated
    #[arg(long, value_name = "DIR[,COLORMAP]")]
    pub(crate) also: Vec<String>,
    /// The lichen as a skin in its own colours, or each element as a granule, coloured by age
    #[arg(long, value_parser = what(), hide_possible_values = true, value_name = "skin|points", default_value = "skin")]
    pub(crate) draw: What,
    #[command(flatten)]
    pub(crate) shot: ShotArgs,
}

/// The number of the first frame, where none is asked for.
pub(crate) const FIRST: u32 = 1;

#[derive(Debug, Args)]
#[command(next_help_heading = "Time")]
pub(crate) struct TimeArgs {
    /// How many frames, up to 100000; the last shows the whole lichen, or what the curve of --clock ends at
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000), allow_negative_numbers = true)]
    pub(crate) frames: u32,
    /// Number of the first frame, up to 1000000: in the names of numbered files and of nodes in GLB, and as its time in USD
    #[arg(long, value_name = "N", default_value_t = FIRST, value_parser = clap::value_parser!(u32).range(0..=1_000_000), allow_negative_numbers = true)]
    pub(crate) start: u32,
    /// Frames a second, 0.1 to 1000
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = fps, allow_negative_numbers = true)]
    pub(crate) fps: f64,
    /// How many elements fade in at a time, or what share of all: many for a rim that swells softly, 0 for elements
    /// that are either there or not [default: four frames' worth, at most 10%]
    #[arg(long, value_name = "ELEMENTS|PERCENT%", allow_negative_numbers = true)]
    pub(crate) window: Option<Window>,
    /// How they fade in: evenly, or softer at the beginning and end
    #[arg(long, value_parser = ease(), hide_possible_values = true, value_name = "linear|smooth|smoother", default_value = "linear")]
    pub(crate) ease: Ease,
    /// What grows evenly: 'birth', the number of elements; 'radius', the width, as in real lichens; or a curve of times
    /// and numbers of elements (or shares), such as 0:0,1:5%,4:100%, or a file of lines 'time,elements'
    #[arg(
        long,
        value_name = "birth|radius|CURVE|FILE.csv",
        default_value = "birth"
    )]
    pub(crate) clock: String,
}

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    Skin,
    Points,
    Curves,
    Picture,
}

fn subject() -> impl TypedValueParser<Value = Subject> {
    choice([
        ("skin", Subject::Skin),
        ("points", Subject::Points),
        ("curves", Subject::Curves),
        ("picture", Subject::Picture),
    ])
}

fn ease() -> impl TypedValueParser<Value = Ease> {
    choice([
        ("linear", Ease::Linear),
        ("smooth", Ease::Smooth),
        ("smoother", Ease::Smoother),
    ])
}

fn fps(text: &str) -> Result<f64, &'static str> {
    let fps = text.parse().ok().filter(|fps| (0.1..=1000.0).contains(fps));
    fps.ok_or("give a number from 0.1 to 1000")
}

/// How many elements fade in at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Window {
    Elements(f64),
    /// Of all, 1 for all.
    Share(f64),
}

impl Window {
    /// In elements, of so many; the usual one where none was asked for, by the number in the last frame.
    pub(crate) fn elements(
        window: Option<Self>,
        all: usize,
        end: f64,
        frames: u32,
    ) -> Result<f64, String> {
        match window {
            None => Ok(Timing::usual_window(end, frames)),
            Some(Self::Share(share)) => Ok(share * all as f64),
            Some(Self::Elements(elements)) if elements > all as f64 => Err(format!(
                "--window {elements}: the lichen has {all} elements: give as many at most"
            )),
            Some(Self::Elements(elements)) => Ok(elements),
        }
    }
}

impl FromStr for Window {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str, most: f64| {
            let number = text.trim().parse().ok();
            number.filter(|n| (0.0..=most).contains(n))
        };
        let window = match text.strip_suffix('%') {
            Some(percent) => number(percent, 100.0).map(|n| Self::Share(n / 100.0)),
            None => number(text, f64::from(u32::MAX)).map(Self::Elements),
        };
        window.ok_or("write a number of elements from 0 (500), or a share of them up to 100% (2%)")
    }
}

fn output_help() -> String {
    let line = |f: &FilmFormat| format!("\n.{}: {}", f.extension, f.purpose);
    let films: String = FILM_FORMATS.iter().map(line).collect();
    format!(
        "A folder for numbered files frame_0001 and so on, or one file; its extension says the \
         format:{films}\n.gif: pictures that move\n.mp4: the same as H.264, by ffmpeg\n.webm: the \
         same as VP9, by ffmpeg"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_elements_or_shares() {
        assert_eq!("500".parse(), Ok(Window::Elements(500.0)));
        assert_eq!("0".parse(), Ok(Window::Elements(0.0)));
        assert_eq!("2.5%".parse(), Ok(Window::Share(0.025)));
        for wrong in ["-1", "101%", "nan", "inf", "", "%", "5r"] {
            assert!(wrong.parse::<Window>().is_err(), "{wrong}");
        }
        let of = |window, end, frames| Window::elements(window, 1000, end, frames);
        assert_eq!(of(Some(Window::Share(0.5)), 300.0, 10), Ok(500.0));
        assert_eq!(of(None, 1000.0, 100), Ok(40.0));
        assert_eq!(of(None, 1000.0, 10), Ok(100.0));
        assert_eq!(of(None, 50.0, 100), Ok(2.0));
        assert_eq!(of(Some(Window::Elements(1000.0)), 50.0, 100), Ok(1000.0));
        assert!(of(Some(Window::Elements(1001.0)), 1000.0, 100).is_err());
    }
}
