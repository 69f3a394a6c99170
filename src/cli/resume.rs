//! The log of a run: begun anew, or gone on with.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::iter;
use std::path::{Path, PathBuf};

use thallus::export::{OutputDir, OutputError, write_file_atomically};
use thallus::input;
use thallus::log::{LOG, Log, LogWriter, count_elements, head};
use thallus::run::{Recipe, Settings, shell_path};

use super::args::GrowArgs;
use super::ended;
use super::failure::Failure;
use super::number::{count, elements, plural};
use super::output::{ELEMENTS, FILES, PREVIEW, RECIPE, REPORT};
use super::paths::hash_of;
use super::terminal::Voice;

impl GrowArgs {
    /// The recipe to read: given, or that of the run to go on with.
    pub(crate) fn recipe_file(&self) -> Option<PathBuf> {
        let in_folder = |folder: &PathBuf| folder.join(RECIPE);
        let given = |file: &PathBuf| match file.is_dir() {
            true => in_folder(file),
            false => file.clone(),
        };
        let resumed = self.resume.as_ref().map(in_folder);
        resumed.or_else(|| self.recipe.as_ref().map(given))
    }

    /// How to name the mesh for the same again.
    pub(crate) fn with_mesh(&self) -> String {
        match (&self.resume, &self.recipe) {
            (Some(folder), _) => format!("thallus grow MESH --resume {}", shell_path(folder)),
            (_, Some(recipe)) => format!("thallus grow MESH --recipe {}", shell_path(recipe)),
            _ => "thallus grow MESH".to_owned(),
        }
    }
}

/// The hash of the mask that a run goes on with, wherever that is now.
pub(crate) fn mask_hash(
    flags: &Settings,
    recipe: &Settings,
) -> Result<Option<Vec<String>>, Failure> {
    let problem = match (&flags.mask, &recipe.mask_hash) {
        (Some(_), None) if !flags.mask_layers().is_empty() => {
            "the run has no mask, and goes on without one"
        }
        (Some(_), Some(_)) if flags.mask_layers().is_empty() => {
            "the run has a mask, and goes on with it"
        }
        (_, hash) => return Ok(hash.clone()),
    };
    Err(Failure::usage(format!(
        "--mask: {problem}; for another lichen begin anew, with another -o"
    )))
}

/// Refuses a folder that holds no run, or whose recipe is no file: the run would put one in its place.
pub(crate) fn check_folder(folder: &Path) -> Result<(), Failure> {
    if folder.is_file() {
        return Err(Failure::usage(format!(
            "{} is a file: --resume goes on with a run by its folder",
            folder.display()
        )));
    }
    let recipe = folder.join(RECIPE);
    let Err(problem) = input::regular(&recipe) else {
        return Ok(());
    };
    Err(Failure::Failed(match problem.kind() {
        ErrorKind::NotFound => anyhow::anyhow!(
            "{} holds no run to go on with: there is no {RECIPE} in it",
            folder.display()
        ),
        _ => anyhow::Error::new(problem)
            .context(format!("{}: reading the recipe failed", recipe.display())),
    }))
}

/// A run's recipe says where the run ends, if it is whole.
pub(crate) fn without_end(recipe: &Path) -> Failure {
    Failure::Failed(anyhow::anyhow!(
        "{}: it does not say where the run ends, as the recipe of each run does: it was cut off or changed. Say how far \
         the run is to go, as by --elements 20000",
        recipe.display()
    ))
}

/// What the run has come to, and whose log is sound; nothing for a run from the start.
pub(crate) fn earlier(
    args: &GrowArgs,
    recipe: &Recipe,
    voice: Voice,
) -> Result<Option<Log>, Failure> {
    let Some(folder) = &args.resume else {
        return Ok(None);
    };
    let path = folder.join(LOG);
    if !path.exists() {
        check_unfinished(folder)?;
        // What a link leads to may be on a disk that is away: that is an error below.
        if path.symlink_metadata().is_err() {
            let missing = path.display();
            voice.note(&format!("{missing} is not there: the run begins anew"));
            return Ok(None);
        }
    }
    let log = match args.keep_sound {
        true => Log::read_sound(&path)?,
        false => Log::read(&path)?,
    };
    log.check(recipe)?;
    ended::spare_foreign(folder, &log)?;
    ended::refuse_fewer(folder, &log, recipe.stop)?;
    tell(&log, ended::lost(folder, &log)?, voice);
    Ok(Some(log))
}

/// Refuses to begin anew where a run has ended.
fn check_unfinished(folder: &Path) -> Result<(), Failure> {
    let has = |name: &str| folder.join(name).symlink_metadata().is_ok();
    match [ELEMENTS, REPORT, PREVIEW].into_iter().any(has) {
        false => Ok(()),
        true => Err(Failure::Failed(anyhow::anyhow!(
            "{} has a finished run whose {LOG} is gone: to grow it again, thallus grow --recipe {} with another -o",
            folder.display(),
            shell_path(&folder.join(RECIPE))
        ))),
    }
}

/// Puts a damaged log aside before what follows the sound part is cut off, unless it was by one who was killed then.
pub(crate) fn set_aside(log: &Path) -> Result<(), Failure> {
    let copy = |out: &mut dyn Write| io::copy(&mut File::open(log)?, out).map(drop);
    let numbered = (2..=MOST_ASIDE).map(|n| format!("{LOG}.damaged-{n}"));
    let mut names = iter::once(format!("{LOG}.damaged")).chain(numbered);
    let free = names.find_map(|name| {
        let aside = log.with_file_name(name);
        match write_file_atomically(&aside, false, copy) {
            Err(OutputError::FileExists(_)) if are_same(log, &aside).unwrap_or(false) => {
                Some(Ok(()))
            }
            Err(OutputError::FileExists(_) | OutputError::NotAFile(_)) => None,
            written => Some(written),
        }
    });
    match free {
        Some(written) => Ok(written?),
        None => Err(Failure::Failed(anyhow::anyhow!(
            "{}: there are {MOST_ASIDE} damaged logs beside it already: move them away",
            log.display()
        ))),
    }
}

/// Whether two files hold the same bytes.
fn are_same(one: &Path, other: &Path) -> io::Result<bool> {
    Ok(hash_of(one)? == hash_of(other)?)
}

/// Damaged logs kept in one folder, at most.
const MOST_ASIDE: u32 = 1000;

fn tell(log: &Log, lost: u64, voice: Voice) {
    let path = log.path.display();
    if log.torn_bytes > 0 {
        let torn = plural(log.torn_bytes as usize, "byte is", "bytes are");
        let usual = if lost == 0 && !log.is_damaged {
            ", as a killed run leaves it"
        } else {
            ""
        };
        voice.warn(&format!(
            "{path}: its end is not sound{usual}: {torn} dropped, and what was in there grows again as it was"
        ));
    }
    if lost > 0 {
        voice.warn(&format!(
            "{path}: the run had ended, and {} of its elements are gone from the log: until they have grown again \
             {ELEMENTS} stays, which has them",
            count(lost)
        ));
    }
    let elements = elements(log.begun.elements.len());
    voice.note(&format!("{path}: going on from {elements}"));
}

/// Puts the recipe and an empty log into the folder, so that the run can be killed from here on.
/// What an earlier run left there goes first: a folder never holds files of two.
pub(crate) fn begin(output: &mut OutputDir, recipe: &Recipe) -> Result<Log, Failure> {
    let (text, head) = (recipe.to_toml(), head(recipe));
    output.replace(FILES, &[(RECIPE, text.as_bytes()), (LOG, &head)])?;
    Ok(Log::read(&output.path().join(LOG))?)
}

/// Replaces the recipe of the run that is gone on with.
pub(crate) fn place_recipe_anew(output: &mut OutputDir, recipe: &Recipe) -> Result<(), Failure> {
    output.check_files(FILES)?;
    place_recipe(output, recipe)
}

/// Takes away the picture of the run that is to grow on: it would be taken for one of the larger lichen if this run
/// ended before it takes its own, which it does last.
pub(crate) fn take_picture_away(output: &mut OutputDir) -> Result<(), Failure> {
    Ok(output.remove(PREVIEW)?)
}

pub(crate) fn place_recipe(output: &mut OutputDir, recipe: &Recipe) -> Result<(), Failure> {
    let text = recipe.to_toml();
    Ok(output.place(RECIPE, |out| out.write_all(text.as_bytes()))?)
}

/// What could not be written, and what is safe all the same: what the log has, whatever was done to it.
pub(crate) fn cut_short(
    error: OutputError,
    (folder, recipe): (&Path, &Recipe),
    log: &LogWriter,
) -> Failure {
    let safe = |elements: u64| plural(elements as usize, "element is", "elements are");
    let durable = log.durable_elements();
    let go_on = |sound: u64| {
        let on = shell_path(folder);
        anyhow::anyhow!(
            "{error}; {} safe: go on with thallus grow --resume {on}",
            safe(sound)
        )
    };
    Failure::Failed(
        match (log.is_in_place(), count_elements(&folder.join(LOG))) {
            (Ok(true), Ok(sound)) => go_on(sound.min(durable)),
            (Ok(true), Err(lost)) => anyhow::anyhow!("{error}; what was durable is lost: {lost}"),
            // The log of a run that has ended is put in the place of the one that was written to.
            (Ok(false), Ok(sound)) if is_of(recipe, &folder.join(LOG)) => go_on(sound),
            (Ok(false), _) => anyhow::anyhow!(
                "{error}; what was durable went with it, unless {} was moved: then {} safe, and \
             thallus grow --resume goes on with the folder where it lies now",
                folder.display(),
                safe(durable)
            ),
            (Err(_), _) => anyhow::anyhow!(
                "{error}; {} in {}: when that can be read again, go on with thallus grow --resume {}",
                safe(durable),
                folder.join(LOG).display(),
                shell_path(folder)
            ),
        },
    )
}

/// Whether a log begins as one of this recipe does.
fn is_of(recipe: &Recipe, log: &Path) -> bool {
    let expected = head(recipe);
    let mut there = Vec::with_capacity(expected.len());
    let read = File::open(log).and_then(|file| {
        let mut start = file.take(expected.len() as u64);
        start.read_to_end(&mut there)
    });
    read.is_ok() && there == expected
}

#[cfg(test)]
mod tests {
    use thallus::run::Settings;
    use thallus::substrate::Substrate;

    use super::*;

    /// Where the last files of a run cannot be put in place, its whole log may be already.
    #[test]
    fn what_is_in_another_log_of_the_run_is_safe() {
        let mesh = Path::new("meshes/plane.obj");
        let plane = Substrate::load(mesh).unwrap();
        let recipe = |seed| {
            let settings = Settings {
                seed: Some(seed),
                ..Settings::default()
            };
            settings.resolve(&plane, "plane.obj").unwrap()
        };
        let own = recipe(1);
        let folder = tempfile::tempdir().unwrap();
        let (path, away) = (folder.path().join(LOG), folder.path().join("away"));
        let mut log = LogWriter::create(&path, &own).unwrap();
        log.close().unwrap();
        let told_of = |recipe: &Recipe| {
            let error = OutputError::FileExists(path.clone());
            cut_short(error, (folder.path(), recipe), &log).reason()
        };
        let told = || told_of(&own);
        // In its place it is the run's, whatever size that was to have when the log began.
        let said = told_of(&recipe(2));
        assert!(said.contains("0 elements are safe: go on with"), "{said}");
        // Its number is given to no other file.
        std::fs::hard_link(&path, folder.path().join("kept")).unwrap();
        std::fs::copy(&path, &away).unwrap();
        std::fs::rename(&away, &path).unwrap();
        let said = told();
        assert!(said.contains("0 elements are safe: go on with"), "{said}");
        std::fs::write(&away, head(&recipe(2))).unwrap();
        std::fs::rename(&away, &path).unwrap();
        let said = told();
        assert!(said.contains("went with it, unless"), "{said}");
        std::fs::remove_file(&path).unwrap();
        let said = told();
        assert!(said.contains("went with it, unless"), "{said}");
    }
}
