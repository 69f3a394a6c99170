//! How a command ends when it does not end well.

use std::io;
use std::process::ExitCode;

use thallus::export::OutputError;
use thallus::growth::PlaceError;
use thallus::log::{LOG, LogError};
use thallus::run::preset::UnknownPreset;
use thallus::run::{GrowError, RecipeFileError, SettingsError, shell_path};
use thallus::skin::PALETTE;
use thallus::sweep::{GridError, GridFileError};

use super::number::elements as elements_of;
use super::paths::folder_of;
use super::refusal::{in_words, of_given};
use super::terminal::Unsaid;
use super::{INTERRUPTED, terminal};

/// What went wrong, by exit code.
#[derive(Debug)]
pub(crate) enum Failure {
    /// 1: the work could not be done.
    Failed(anyhow::Error),
    /// 2: it was asked for wrongly.
    Usage(anyhow::Error),
    /// 130: Ctrl-C, and what there was to say has been said.
    Interrupted,
    /// 0: the reader of stdout closed it, having read enough.
    PipeClosed,
}

impl Failure {
    /// Work that could not be done.
    fn failed(message: String) -> Self {
        Self::Failed(anyhow::Error::msg(message))
    }

    /// Something asked for wrongly.
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::Usage(anyhow::Error::msg(message.into()))
    }

    /// The same, where that was.
    pub(crate) fn at(self, place: String) -> Self {
        match self {
            Self::Failed(error) => Self::Failed(error.context(place)),
            Self::Usage(error) => Self::Usage(error.context(place)),
            other => other,
        }
    }

    /// What went wrong, in one line.
    pub(crate) fn reason(&self) -> String {
        match self {
            Self::Failed(error) | Self::Usage(error) => one_line(&with_causes(error)),
            Self::Interrupted => "interrupted".to_owned(),
            Self::PipeClosed => "the reader closed the pipe".to_owned(),
        }
    }

    /// Tells the user and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        let code = match self {
            Self::PipeClosed => return ExitCode::SUCCESS,
            Self::Interrupted => return ExitCode::from(INTERRUPTED),
            Self::Failed(_) => ExitCode::FAILURE,
            Self::Usage(_) => ExitCode::from(2),
        };
        terminal::error(&self.reason());
        code
    }
}

/// An error and what caused it, once: those of other libraries may say that themselves.
fn with_causes(error: &anyhow::Error) -> String {
    let add = |all: String, cause: String| match all.contains(&cause) {
        true => all,
        false => format!("{all}: {cause}"),
    };
    let causes = error.chain().map(ToString::to_string);
    causes.reduce(add).unwrap_or_default()
}

/// A text of many lines as one, without the drawings that parsers make of the place, and without
/// the advice that follows every usage error.
fn one_line(text: &str) -> String {
    let drawn = |line: &str| {
        let rest = line.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
        rest.starts_with('|')
    };
    // What is advised for a flag that there is not is to give it as a file's name.
    const ADVICE: [&str; 3] = ["Usage:", "For more info", "tip: to pass '"];
    let advice = |line: &str| ADVICE.iter().any(|begin| line.starts_with(begin));
    let lines = text.lines().filter(|line| !drawn(line)).map(str::trim);
    let mut joined = String::new();
    for line in lines.filter(|line| !line.is_empty() && !advice(line)) {
        match joined.chars().last() {
            None => {}
            Some(':') => joined.push(' '),
            Some(_) => joined.push_str("; "),
        }
        // Choices come in brackets on a line of their own.
        joined.push_str(
            line.strip_prefix('[')
                .map_or(line, |l| l.trim_end_matches(']')),
        );
    }
    joined
}

impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        let text = one_line(&of_given(error).to_string());
        Self::usage(in_words(text.trim_start_matches("error: ")))
    }
}

impl From<Unsaid> for Failure {
    fn from(Unsaid(error): Unsaid) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::PipeClosed,
            _ => Self::Failed(anyhow::Error::new(error).context("writing to stdout")),
        }
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Failed(error)
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::FileExists(file) => Self::failed(format!(
                "{} exists already: add --force to overwrite it, or choose another name",
                file.display()
            )),
            OutputError::FolderExists(folder) => Self::failed(format!(
                "{} exists already and is not empty: add --force to replace what an earlier run wrote there \
                 (other files are left alone), go on with that run by --resume, or choose another folder",
                folder.display()
            )),
            // As where one file is asked for that is read.
            OutputError::IsRead(_) => Self::Usage(error.into()),
            _ => Self::Failed(error.into()),
        }
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        Self::failed(match &error {
            LogError::NoLog(_) => format!(
                "{error}: --resume goes on with the folder of a run; to begin anew name the mesh"
            ),
            LogError::Head(_) | LogError::Version { .. } => format!("{error} (--recipe and -o)"),
            LogError::Mesh { .. } => format!("{error} as MESH"),
            LogError::Damaged { path, at, elements } => format!(
                "{} is damaged at byte {at}: the {} before that {} sound; thallus grow --resume {} \
                 --keep-sound goes on from them (the rest grows again as it was) and keeps the damaged log as {LOG}.damaged",
                path.display(),
                elements_of(*elements),
                if *elements == 1 { "is" } else { "are" },
                shell_path(folder_of(path))
            ),
            _ => return Self::Failed(error.into()),
        })
    }
}

impl From<GrowError> for Failure {
    fn from(error: GrowError) -> Self {
        match error {
            GrowError::Recipe(error) => error.into(),
            GrowError::Place(error) => SettingsError::from(error).into(),
            _ => Self::Usage(error.into()),
        }
    }
}

impl From<SettingsError> for Failure {
    fn from(error: SettingsError) -> Self {
        match error {
            // It is the mesh that is wrong, not what was asked for.
            SettingsError::AutoLargerThanSurface { .. } => Self::failed(with_flags(&error)),
            _ => Self::usage(with_flags(&error)),
        }
    }
}

fn is_colormap(name: &str) -> bool {
    PALETTE.iter().any(|map| map.name == name)
}

/// The library names settings; their flags have the same names.
fn with_flags(error: &SettingsError) -> String {
    let text = error.to_string();
    let text = match error {
        SettingsError::OutOfRange { .. }
        | SettingsError::Notation { .. }
        | SettingsError::RadiusLargerThanMesh { .. }
        | SettingsError::RadiusLargerThanSurface { .. }
        | SettingsError::KillInsideLaunch { .. }
        | SettingsError::MorePlaces { .. }
        | SettingsError::MoreColonies { .. } => format!("--{text}"),
        SettingsError::Preset(UnknownPreset { name }) if is_colormap(name) => {
            return format!("{text}; {name} is a colour map: thallus skin --colormap {name}");
        }
        SettingsError::Place(PlaceError::NoHabitat) => return text,
        SettingsError::Place(_) => format!("--{text}"),
        SettingsError::AutoLargerThanSurface { .. } => text,
        _ => return text,
    };
    let said = [
        ("(at)", "(--at)"),
        ("(radius)", "(--radius)"),
        ("try radius", "try --radius"),
        ("than launch", "than --launch"),
    ];
    said.iter()
        .fold(text, |text, (setting, flag)| text.replace(setting, flag))
}

impl From<RecipeFileError> for Failure {
    fn from(error: RecipeFileError) -> Self {
        match error {
            RecipeFileError::Read { .. } => Self::Failed(error.into()),
            _ => Self::Usage(error.into()),
        }
    }
}

impl From<GridError> for Failure {
    fn from(error: GridError) -> Self {
        Self::usage(match &error {
            GridError::NoCell { cell, problem } => format!(
                "no cell of the grid can be grown; cell {cell}: {}",
                with_flags(problem)
            ),
            GridError::Nothing => "there is nothing to compare: give an axis (--L 5r,10r,20r --B 0.2..1.0/5, or --axis \
                                   NAME=VALUES), or --seeds N"
                .to_owned(),
            GridError::Seeds => format!("--seeds: {error}"),
            _ => return Self::Usage(error.into()),
        })
    }
}

impl From<GridFileError> for Failure {
    fn from(error: GridFileError) -> Self {
        match error {
            GridFileError::Read { .. } => Self::Failed(error.into()),
            _ => Self::Usage(error.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::{
        Failure, GrowError, LogError, OutputError, PlaceError, SettingsError, one_line, shell_path,
        with_causes,
    };

    #[test]
    fn many_lines_become_one() {
        let toml =
            "TOML parse error at line 1, column 8\n  |\n1 | bias = x\n  |        ^\nbad value\n";
        assert_eq!(
            one_line(toml),
            "TOML parse error at line 1, column 8; bad value"
        );
        let clap = "missing:\n  --to <FILE>\n\nUsage: thallus export\n\nFor more information, try";
        assert_eq!(one_line(clap), "missing: --to <FILE>");
        assert_eq!(one_line("one line"), "one line");
        let choices = "invalid value 'x' for '--to <a|b>'\n  [possible values: a, b]\n";
        assert_eq!(
            one_line(choices),
            "invalid value 'x' for '--to <a|b>'; possible values: a, b"
        );
    }

    fn told(failure: impl Into<Failure>) -> String {
        failure.into().reason()
    }

    #[test]
    fn what_the_library_refuses_is_told_with_the_flags_that_cure_it() {
        let log = || PathBuf::from("my out/run.log");
        let damaged = LogError::Damaged {
            path: log(),
            at: 99,
            elements: 7,
        };
        let folder = shell_path(Path::new("my out"));
        let cure = format!(
            "my out/run.log is damaged at byte 99: the 7 elements before that are sound; thallus grow --resume {folder} \
             --keep-sound goes on from them (the rest grows again as it was) and keeps the damaged log as run.log.damaged"
        );
        assert_eq!(told(damaged), cure);
        let no_log = "my out/run.log is not a log of thallus: --resume goes on with the folder of a run; to begin anew \
                      name the mesh";
        assert_eq!(told(LogError::NoLog(log())), no_log);
        let head = told(LogError::Head(log()));
        assert!(
            head.ends_with("grow again by the same recipe, into another folder (--recipe and -o)"),
            "{head}"
        );
        let [found, expected] = ["a1", "b2"].map(str::to_owned);
        let mesh = told(LogError::Mesh {
            path: log(),
            found,
            expected,
        });
        assert!(
            mesh.ends_with("the log's b2; give the right file as MESH"),
            "{mesh}"
        );
        let there = |error: OutputError| assert!(told(error).contains(": add --force to "));
        there(OutputError::FileExists(log()));
        there(OutputError::FolderExists(log()));
    }

    #[test]
    fn settings_are_told_as_flags() {
        let kill = SettingsError::KillInsideLaunch {
            launch: 1.5,
            kill: 1.2,
        };
        assert!(told(kill).starts_with("--kill 1.2 must be larger than --launch 1.5: "));
        let wide = SettingsError::RadiusLargerThanSurface {
            radius: 3.0,
            times: 2.0,
            thousand: Some(0.1),
        };
        let wide = told(wide);
        assert!(wide.starts_with("--radius 3.0 (in mesh units): "), "{wide}");
        assert!(
            wide.contains("put it elsewhere (--at), or try --radius 0.1, with"),
            "{wide}"
        );
        let mesh = SettingsError::RadiusLargerThanMesh {
            radius: 3.0,
            times: 2.0,
            diagonal: 3.0,
            auto: 0.1,
        };
        assert!(told(mesh).ends_with("; try --radius auto, which is 0.1 here"));
        let place = PlaceError::NotFinite {
            point: [f64::NAN; 3],
        };
        assert!(told(GrowError::Place(place)).starts_with("--at [NaN"));
        let crowded = told(GrowError::Place(PlaceError::Crowded { colony: 7 }));
        assert!(
            crowded.starts_with("--colonies: ") && crowded.ends_with("smaller elements (--radius)"),
            "{crowded}"
        );
        let more = SettingsError::MorePlaces {
            places: 3,
            colonies: 2,
        };
        let more = told(more);
        assert!(
            more.starts_with("--colonies 2 is less than the 3 places given (--at): "),
            "{more}"
        );
    }

    #[test]
    fn a_cause_is_said_once() {
        let cause = anyhow::anyhow!("no such file");
        let said = cause
            .context("reading failed: no such file")
            .context("a.ply");
        assert_eq!(with_causes(&said), "a.ply: reading failed: no such file");
        let cured = anyhow::anyhow!("no room").context("writing failed: no room; make some");
        assert_eq!(with_causes(&cured), "writing failed: no room; make some");
    }
}
