//! Where the frames of `thallus animate` go.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::slice;

use thallus::export::{
    self, FilmFormat, MESH_FORMATS, MeshFormat, OutputDir, OutputError, SCENE_FORMATS, SceneFormat,
    UnknownFormat, mesh_format_of,
};
use thallus::picture::{Background, FASTEST_GIF};

use super::animate_args::{AnimateArgs, FIRST, Subject};
use super::animate_growth::Growth;
use super::failure::Failure;
use super::output::{check_free, ends_in_slash};
use super::render_args::What;

/// What is written.
pub(super) enum Target {
    Skin(Shapes<MeshFormat>),
    Scene(export::What, Shapes<SceneFormat>),
    Picture(Pictures),
}

/// Where frames with a shape go.
pub(super) enum Shapes<F: 'static> {
    /// A numbered file a frame.
    Folder(&'static F),
    /// One file.
    Film(&'static FilmFormat),
}

/// Where pictures go.
pub(super) enum Pictures {
    /// A numbered file a frame.
    Folder,
    /// One file.
    Movie(Movie),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Movie {
    Gif,
    Mp4,
    Webm,
}

impl Target {
    /// What the name of the output and the flags say.
    pub(super) fn of(args: &AnimateArgs) -> Result<Self, Failure> {
        let target = Self::named(args)?;
        let makes_pictures = target.subject() == Subject::Picture;
        match (args.picture.given.as_slice(), args.axes.given.as_slice()) {
            ([first, ..], _) if !makes_pictures => Err(Failure::usage(format!(
                "{first} is for pictures, and {} will hold none: leave it away, or name a .gif, a .mp4, \
                 a .webm, or a folder with --what picture",
                args.output.display()
            ))),
            (_, [first, ..]) if makes_pictures => Err(Failure::usage(format!(
                "{first} is for files with a shape in them, and {} will hold pictures, which are as the mesh \
                 is: leave it away",
                args.output.display()
            ))),
            _ => target.refuse_start(args)?.refuse_skin_flags(args),
        }
    }

    /// Moving pictures have times, and no numbers of frames.
    fn refuse_start(self, args: &AnimateArgs) -> Result<Self, Failure> {
        match self {
            Self::Picture(Pictures::Movie(_)) if args.time.start != FIRST => {
                Err(Failure::usage(format!(
                    "--start numbers frames, and those of {} have no numbers: leave it away, or write numbered files in \
                     a folder",
                    args.output.display()
                )))
            }
            _ => Ok(self),
        }
    }

    /// Flags of skins do nothing where there is none.
    fn refuse_skin_flags(self, args: &AnimateArgs) -> Result<Self, Failure> {
        let draws_skin = match self.subject() {
            Subject::Skin => true,
            Subject::Picture => args.picture.draw == What::Skin,
            Subject::Points | Subject::Curves => false,
        };
        let mut given = args.shape.given.iter().chain(&args.color.given);
        match given.next().filter(|_| !draws_skin) {
            None => Ok(self),
            Some(first) => Err(Failure::usage(format!(
                "{first} is for skins, and {} will hold none: leave it away, or ask for a skin",
                args.output.display()
            ))),
        }
    }

    fn named(args: &AnimateArgs) -> Result<Self, Failure> {
        if ends_in_slash(&args.output) {
            return Self::folder(args);
        }
        let extension = args.output.extension().and_then(|e| e.to_str());
        let extension = extension.unwrap_or_default().to_ascii_lowercase();
        let movie = match extension.as_str() {
            "gif" => Some(Movie::Gif),
            "mp4" => Some(Movie::Mp4),
            "webm" => Some(Movie::Webm),
            _ => None,
        };
        if let Some(kind) = movie {
            check_free(slice::from_ref(&args.output), args.force)?;
            return Self::movie(args, kind);
        }
        match FilmFormat::of(&args.output) {
            Ok(format) => {
                check_free(slice::from_ref(&args.output), args.force)?;
                Self::film(args, format)
            }
            Err(_) if names_folder(&args.output, &extension) => Self::folder(args),
            Err(unknown) => Err(no_film(&args.output, &extension, &unknown)),
        }
    }

    pub(super) fn subject(&self) -> Subject {
        match self {
            Self::Skin(_) => Subject::Skin,
            Self::Scene(export::What::Curves, _) => Subject::Curves,
            Self::Scene(_, _) => Subject::Points,
            Self::Picture(_) => Subject::Picture,
        }
    }

    fn movie(args: &AnimateArgs, kind: Movie) -> Result<Self, Failure> {
        refuse_format(args)?;
        if args.picture.shot.background == Background::Transparent {
            return Err(Failure::usage(
                "--background transparent is for PNG: name a folder and add --what picture",
            ));
        }
        if kind == Movie::Gif && args.time.fps > FASTEST_GIF {
            return Err(Failure::usage(format!(
                "a .gif shows at most {FASTEST_GIF} frames a second, and --fps is {}: give --fps \
                 {FASTEST_GIF} or less, or write a .mp4 or a .webm",
                args.time.fps
            )));
        }
        match args.what {
            None | Some(Subject::Picture) => Ok(Self::Picture(Pictures::Movie(kind))),
            Some(_) => Err(Failure::usage(format!(
                "{} holds pictures: leave --what away, or name a folder, a .glb or a .usda",
                args.output.display()
            ))),
        }
    }

    fn film(args: &AnimateArgs, format: &'static FilmFormat) -> Result<Self, Failure> {
        refuse_format(args)?;
        match args.what.unwrap_or(Subject::Skin) {
            Subject::Skin => Ok(Self::Skin(Shapes::Film(format))),
            Subject::Points => Ok(Self::Scene(export::What::Points, Shapes::Film(format))),
            Subject::Curves => Ok(Self::Scene(export::What::Curves, Shapes::Film(format))),
            Subject::Picture => Err(Failure::usage(format!(
                "{} holds no pictures: name a folder, a .gif, a .mp4 or a .webm",
                args.output.display()
            ))),
        }
    }

    fn folder(args: &AnimateArgs) -> Result<Self, Failure> {
        let format = args
            .format
            .as_deref()
            .map(|f| f.trim_start_matches('.').to_ascii_lowercase());
        if let Some(film @ ("gif" | "mp4" | "webm")) = format.as_deref() {
            return Err(Failure::usage(format!(
                "a .{film} is one file and no folder of frames: leave --format away, and name it, as in -o {}.{film}",
                args.output.display()
            )));
        }
        let png = format.as_deref() == Some("png");
        let subject = match (args.what, png) {
            (None, true) => Subject::Picture,
            (None, false) => Subject::Skin,
            (Some(subject), _) => subject,
        };
        match (subject, format) {
            (Subject::Picture, Some(extension)) if !png => Err(Failure::usage(format!(
                "--what picture is written as png: leave --format {extension} away, or --what picture"
            ))),
            (Subject::Picture, _) => Ok(Self::Picture(Pictures::Folder)),
            _ if png => Err(Failure::usage(
                "--format png is for pictures: leave --format away, or give --what picture",
            )),
            (_, format) => Self::shapes(subject, &format.unwrap_or_else(|| "ply".to_owned())),
        }
    }

    /// A folder of files with this extension.
    fn shapes(subject: Subject, extension: &str) -> Result<Self, Failure> {
        if !extension.bytes().all(|b| b.is_ascii_alphanumeric()) {
            return Err(Failure::usage(format!(
                "--format {extension}: give an extension alone, such as ply"
            )));
        }
        let name = format!("--format .{extension}");
        let scene = |what| {
            let format = SceneFormat::of(Path::new(&name), what);
            let format = format.map_err(|wrong| Failure::Usage(wrong.into()))?;
            Ok(Self::Scene(what, Shapes::Folder(format)))
        };
        match subject {
            Subject::Points => scene(export::What::Points),
            Subject::Curves => scene(export::What::Curves),
            _ => match mesh_format_of(Path::new(&name)) {
                Ok(format) => Ok(Self::Skin(Shapes::Folder(format))),
                Err(unknown) => Err(Failure::Usage(unknown.into())),
            },
        }
    }
}

/// Whether a name that is no film's is a folder's. Numbers behind a dot are no file format: folders
/// are called B_0.3.
fn names_folder(output: &Path, extension: &str) -> bool {
    output.is_dir() || extension.bytes().all(|b| b.is_ascii_digit())
}

/// Whether frames are written with this extension.
fn holds_a_frame(extension: &str) -> bool {
    let meshes = MESH_FORMATS.iter().map(|format| format.extension);
    let scenes = SCENE_FORMATS.iter().map(|format| format.extension);
    meshes.chain(scenes).chain(["png"]).any(|e| e == extension)
}

/// Why nothing that moves is written to a file of this name.
fn no_film(output: &Path, extension: &str, unknown: &UnknownFormat) -> Failure {
    let shown = output.display();
    Failure::usage(match holds_a_frame(extension) {
        true => format!(
            "{shown}: a .{extension} file holds one frame; name a folder, and give --format \
             {extension}"
        ),
        false => format!(
            "{unknown}, .gif, .mp4 or .webm, or a folder for numbered files, as {shown}/ with a slash"
        ),
    })
}

fn refuse_format(args: &AnimateArgs) -> Result<(), Failure> {
    match &args.format {
        None => Ok(()),
        Some(_) => Err(Failure::usage(format!(
            "--format is for numbered files in a folder, and {} says its format itself",
            args.output.display()
        ))),
    }
}

/// Numbered files, which appear together.
pub(super) struct Folder {
    dir: OutputDir,
    extension: &'static str,
    digits: usize,
    first: u32,
    written: u32,
}

impl Folder {
    /// One that replaces nothing that the lichen was read from.
    pub(super) fn create(
        args: &AnimateArgs,
        extension: &'static str,
        lichen: &Growth,
    ) -> Result<Self, Failure> {
        let (first, frames) = (args.time.start, args.time.frames);
        let digits = (first + frames - 1).to_string().len().max(DIGITS);
        let mut dir = OutputDir::create(&args.output, args.force).map_err(of_frames)?;
        dir.spare(&lichen.files(args));
        Ok(Self {
            dir,
            extension,
            digits,
            first,
            written: 0,
        })
    }

    /// The next frame.
    pub(super) fn write(
        &mut self,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let number = self.first + self.written;
        self.written += 1;
        let (digits, extension) = (self.digits, self.extension);
        let name = format!("frame_{number:0digits$}.{extension}");
        Ok(self.dir.write(&name, fill)?)
    }

    /// Puts all of them in place, and takes away what an earlier animation left.
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        for name in self.left_over() {
            self.dir.outdate(&name);
        }
        self.dir.commit().map_err(of_frames)
    }

    /// Frames of this format that are there and were not written now. Those of another may be another program's.
    fn left_over(&self) -> Vec<String> {
        let entries = fs::read_dir(self.dir.path())
            .into_iter()
            .flatten()
            .flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let written = self.first..self.first + self.written;
        let old = |name: &String| {
            frame_of(name, self.extension).is_some_and(|number| {
                let new = number.len() == self.digits
                    && number.parse().is_ok_and(|n: u32| written.contains(&n));
                !new
            })
        };
        names.filter(old).collect()
    }
}

/// Digits of the frames' numbers, at least.
const DIGITS: usize = 4;

/// The number of a file that is a frame with this extension by its name.
fn frame_of<'n>(name: &'n str, extension: &str) -> Option<&'n str> {
    let (number, found) = name.strip_prefix("frame_")?.split_once('.')?;
    let counts = number.len() >= DIGITS && number.bytes().all(|b| b.is_ascii_digit());
    (counts && found == extension).then_some(number)
}

/// A full folder, as an animation finds it.
fn of_frames(error: OutputError) -> Failure {
    match error {
        OutputError::FolderExists(folder) => Failure::Failed(anyhow::anyhow!(
            "{} exists already and is not empty: add --force to replace the frames of an earlier \
             animation there (other files are left alone), or choose another folder",
            folder.display()
        )),
        other => other.into(),
    }
}

/// The folder that will hold a file, as far as it is there.
pub(super) fn nearest_folder(file: &Path) -> PathBuf {
    let named = |folder: &&Path| !folder.as_os_str().is_empty() && folder.is_dir();
    let there = file.ancestors().skip(1).find(named);
    there.unwrap_or(Path::new(".")).to_owned()
}
