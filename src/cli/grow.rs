//! `thallus grow`: settings → mesh → recipe → growth → files.

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;
use thallus::export::{OutputDir, OutputError};
use thallus::growth::PlaceError;
use thallus::log::{Log, LogWriter};
use thallus::run::{
    Execution, GrowError, Growth, OPAQUE, Recipe, Run, RunReport, Settings, SettingsError, Stopped,
    Timings, shell_path,
};
use thallus::substrate::{Substrate, SurfacePoint};

use super::args::GrowArgs;
use super::cutout::Cutout;
use super::failure::Failure;
use super::foreseen::MOST_COVERED;
use super::memory::After;
use super::mesh_file::{Looks, MeshFile};
use super::named_mesh::{self, named_mesh};
use super::number::{count, duration, elements, percent, short};
use super::output::{FILES, Finished, RECIPE, check_names_folder, check_replaces_a_run};
use super::paths::portable;
use super::progress::{Display, Goal};
use super::run_args::start_threads;
use super::terminal::{self, Voice};
use super::{buried, ended, interrupt, mask, memory, moved, resume, warnings};

pub(crate) fn grow(args: GrowArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.quiet };
    if args.keep_sound && args.resume.is_none() {
        return Err(Failure::usage(
            "--keep-sound is for a damaged log that is gone on with: give it with --resume DIR",
        ));
    }
    let settings = settings(&args, voice)?;
    check_values(&args, &settings)?;
    let mesh = mesh_file(&args, &settings)?;
    let execution = execution(&args)?;
    args.output.as_deref().map_or(Ok(()), check_names_folder)?;
    let output = output(&args, &mesh, voice)?;
    if args.force {
        check_replaces_a_run(output.path(), &mesh)?;
    }
    interrupt::listen(execution.cancel.clone());

    let recipe_file = args.recipe_file();
    let ready = load(&mesh, &settings, recipe_file.as_slice(), voice)?;
    mask::check_spares(output.path(), &ready.mask_layers)?;
    let (substrate, cutout, seconds) = (ready.substrate, ready.cutout, ready.seconds);
    named_mesh::warn_of_nameless(&mesh, voice);
    let named = mesh_name(&args, &settings, &mesh, output.path());
    let settings = Settings {
        mask: mask_names(&args, &settings, output.path(), &ready.mask_layers),
        ..settings
    };
    let recipe = recipe(&args, settings, &substrate, named, voice)?;
    tell(&args, &substrate, &recipe, voice);
    let after = match args.preview {
        0 => After::Nothing,
        width => After::Preview(u64::from(width) * u64::from(width * 3 / 4)),
    };
    let earlier = resume::earlier(&args, &recipe, voice)?;
    let grown = earlier.as_ref().map_or(0, |log| log.begun.elements.len());
    memory::check(&substrate, &recipe, grown, after, voice)?;
    if execution.is_cancelled() {
        terminal::warn("interrupted before anything grew: nothing is written");
        return Err(Failure::Interrupted);
    }
    let job = Job {
        args: &args,
        substrate: &substrate,
        cutout: cutout.as_ref(),
        recipe: &recipe,
        execution: &execution,
        voice,
    };
    job.run(output, earlier, seconds)
}

/// Says what there is to know before growing.
fn tell(args: &GrowArgs, substrate: &Substrate, recipe: &Recipe, voice: Voice) {
    let warnings = warnings::warnings(substrate, recipe.radius);
    let seeds = recipe.seeds(substrate).unwrap_or_default();
    if args.resume.is_none() {
        let moved = moved::notes(substrate, recipe, &seeds);
        moved.iter().for_each(|note| voice.note(note));
    }
    let hidden = buried::warnings(substrate, &seeds);
    let warnings = warnings.iter().chain(&hidden);
    warnings.for_each(|warning| voice.warn(warning));
}

/// All that is settled when growth starts.
struct Job<'a> {
    args: &'a GrowArgs,
    substrate: &'a Substrate,
    cutout: Option<&'a Cutout>,
    recipe: &'a Recipe,
    execution: &'a Execution,
    voice: Voice,
}

impl Job<'_> {
    fn run(
        &self,
        mut output: OutputDir,
        earlier: Option<Log>,
        mut seconds: Timings,
    ) -> Result<(), Failure> {
        let started = Instant::now();
        let (run, log) = self.begin(&mut output, earlier)?;
        let (growth, mut log) = self.watch(run, log);
        seconds.grow = started.elapsed().as_secs_f64();
        let folder = output.path().to_owned();
        if let Err(error) = log.close() {
            return Err(resume::cut_short(error, (&folder, self.recipe), &log));
        }
        ended::spare_finished(&folder, self.recipe.stop, &growth)?;
        let finished = Finished {
            substrate: self.substrate,
            cutout: self.cutout,
            recipe: self.recipe,
            growth: &growth,
            log: &log,
            execution: self.execution,
            seconds,
            preview: (self.args.preview > 0).then_some(self.args.preview),
        };
        let spinner = (self.args.preview > 0).then(|| self.voice.spinner("taking the picture"));
        let written = finished.write(output);
        spinner.iter().for_each(ProgressBar::finish_and_clear);
        let report =
            written.map_err(|error| resume::cut_short(error, (&folder, self.recipe), &log))?;
        let how = match (growth.stopped, self.execution.is_cancelled()) {
            (Stopped::Cancelled, _) => How::CutShort,
            (_, true) => How::WithoutPicture,
            _ => How::Whole,
        };
        conclude(&report, how, &folder, self.voice)?;
        if let Some(told) = buried::told(self.substrate, &growth.cluster) {
            self.voice.warn(&told);
        }
        Ok(())
    }

    /// The run with what it has of an earlier one, and its log. The recipe of the earlier one is
    /// replaced, and its picture goes if anything is to grow, when it is sure that this one goes on with it.
    fn begin(
        &self,
        output: &mut OutputDir,
        earlier: Option<Log>,
    ) -> Result<(Run<'_>, LogWriter), Failure> {
        let Some(earlier) = earlier else {
            let (log, begun) = LogWriter::open(resume::begin(output, self.recipe)?)?;
            return Ok((Run::new(self.substrate, self.recipe, begun)?, log));
        };
        let damaged = earlier.is_damaged.then(|| earlier.path.clone());
        let (log, begun) = LogWriter::open(earlier)?;
        let run = Run::new(self.substrate, self.recipe, begun).map_err(|problem| {
            let is_usage = matches!(problem, GrowError::PastTheEnd { .. });
            let folder = output.path().display().to_string();
            let named = anyhow::Error::new(problem).context(folder);
            match is_usage {
                true => Failure::Usage(named),
                false => Failure::Failed(named),
            }
        })?;
        if let Some(damaged) = damaged {
            resume::set_aside(&damaged)?;
        }
        resume::place_recipe_anew(output, self.recipe)?;
        if run.ended().is_none() {
            resume::take_picture_away(output)?;
        }
        Ok((run, log))
    }

    /// Grows, shown and logged.
    fn watch(&self, run: Run<'_>, log: LogWriter) -> (Growth, LogWriter) {
        let goal = Goal {
            stop: self.recipe.stop,
            most_covered: MOST_COVERED,
            colonies: self.recipe.at.len(),
        };
        let display = Display::new(goal, &run.progress(), self.voice.quiet);
        let mut watchers = (log, display);
        let growth = run.grow(self.execution, &mut watchers);
        let (log, display) = watchers;
        display.finish();
        (growth, log)
    }
}

/// Flags over the recipe file.
fn settings(args: &GrowArgs, voice: Voice) -> Result<Settings, Failure> {
    if let Some(folder) = &args.resume {
        resume::check_folder(folder)?;
    }
    let Some(path) = &args.recipe_file() else {
        return Ok(args.settings());
    };
    let recipe = Settings::read(path)?;
    let this = env!("CARGO_PKG_VERSION");
    if let Some(version) = recipe.version.as_deref().filter(|version| *version != this) {
        voice.warn(&format!(
            "{} was made by thallus {version}, this is {this}: the result may differ",
            path.display()
        ));
    }
    let flags = args.settings();
    let [said, there] = [&flags, &recipe].map(|settings| settings.mask_layers().len());
    if (1..there).contains(&said) && args.resume.is_none() {
        voice.note(&format!(
            "{} has {there} masks, and --mask names {}: the others are left out",
            path.display(),
            count(said as u64)
        ));
    }
    let mask_hash = match args.resume {
        Some(_) => resume::mask_hash(&flags, &recipe)?,
        None => None,
    };
    let settings = flags.over(recipe);
    let settings = Settings {
        mask_hash: mask_hash.or(settings.mask_hash),
        ..settings
    };
    if args.resume.is_some() && settings.stop.is_none() {
        return Err(resume::without_end(path));
    }
    if let Some(idle) = idle_preset(&settings) {
        voice.note(&format!(
            "preset {idle} changes nothing: {} says everything that it would",
            path.display()
        ));
    }
    Ok(settings)
}

/// Refuses values out of range, and names the recipe file where the flags are not to blame.
fn check_values(args: &GrowArgs, settings: &Settings) -> Result<(), Failure> {
    let Err(error) = settings.clone().complete() else {
        return Ok(());
    };
    Err(blaming(args, error, |flags| flags.complete().is_ok()))
}

/// Names the recipe file where the flags alone are sound.
fn blaming(args: &GrowArgs, error: SettingsError, are_sound: impl Fn(Settings) -> bool) -> Failure {
    match args.recipe_file() {
        Some(recipe) if are_sound(args.settings()) => {
            Failure::Usage(anyhow::Error::new(error).context(recipe.display().to_string()))
        }
        _ => error.into(),
    }
}

/// The preset's name, when every value of it is overridden.
fn idle_preset(settings: &Settings) -> Option<&str> {
    let without = Settings {
        preset: None,
        ..settings.clone()
    };
    let idle = settings.clone().complete() == without.complete();
    settings.preset.as_deref().filter(|_| idle)
}

/// MESH, or the [mesh that the recipe names](named_mesh()).
fn mesh_file(args: &GrowArgs, settings: &Settings) -> Result<PathBuf, Failure> {
    if let Some(mesh) = &args.mesh {
        return match mesh
            .extension()
            .is_some_and(|extension| extension == "toml")
        {
            false => Ok(mesh.clone()),
            true => Err(Failure::usage(format!(
                "{} is a recipe by its name: give it as --recipe {0}",
                shell_path(mesh)
            ))),
        };
    }
    let Some(recipe) = &args.recipe_file() else {
        return Err(Failure::usage(
            "no mesh to grow on: thallus grow MESH -o DIR, or --recipe with one that names its mesh",
        ));
    };
    let Some(named) = &settings.mesh else {
        return Err(Failure::usage(format!(
            "{} names no mesh: give one, as in {}",
            recipe.display(),
            args.with_mesh()
        )));
    };
    named_mesh(recipe, named, settings.mesh_hash.as_deref()).ok_or_else(|| {
        Failure::Failed(anyhow::anyhow!(
            "{named}: the mesh that {} names is not here, nor beside the recipe or above; name it: {}",
            recipe.display(),
            args.with_mesh()
        ))
    })
}

/// Folders of one mesh that are tried before giving up.
const MOST_FOLDERS: u32 = 10_000;

/// The folder asked for, or the first by the mesh's name that holds no other run.
fn output(args: &GrowArgs, mesh: &Path, voice: Voice) -> Result<OutputDir, OutputError> {
    if let Some(folder) = &args.resume {
        return OutputDir::create(folder, true);
    }
    if let Some(folder) = &args.output {
        return OutputDir::create(folder, args.force);
    }
    let first = default_folder(mesh, 1);
    for number in 1..=MOST_FOLDERS {
        let folder = default_folder(mesh, number);
        match OutputDir::create(&folder, args.force) {
            Err(OutputError::FolderExists(_) | OutputError::Locked { .. }) if !args.force => {}
            Ok(output) if number > 1 => {
                let (first, folder) = (first.display(), folder.display());
                voice.note(&format!("{first} is taken: writing to {folder}"));
                return Ok(output);
            }
            other => return other,
        }
    }
    Err(OutputError::FolderExists(first))
}

/// `out/rock`, `out/rock-2`, `out/rock-3`.
fn default_folder(mesh: &Path, number: u32) -> PathBuf {
    let mut name = mesh.file_stem().unwrap_or("lichen".as_ref()).to_owned();
    if number > 1 {
        name.push(format!("-{number}"));
    }
    Path::new("out").join(name)
}

fn execution(args: &GrowArgs) -> Result<Execution, Failure> {
    start_threads(args.threads)?;
    Ok(Execution {
        threads: rayon::current_num_threads(),
        ..Execution::default()
    })
}

/// A mesh to grow on.
pub(super) struct Ready {
    pub(super) substrate: Substrate,
    /// Where the layers of its mask were found.
    pub(super) mask_layers: Vec<String>,
    /// What of it is seen, if not all is.
    pub(super) cutout: Option<Cutout>,
    seconds: Timings,
}

/// The mesh as settings have it, with the axis up and the mask that they say. They may be those of recipe files, beside
/// which the mask may lie.
pub(super) fn load(
    mesh: &Path,
    settings: &Settings,
    recipes: &[PathBuf],
    voice: Voice,
) -> Result<Ready, Failure> {
    mask::check_words(settings)?;
    let started = Instant::now();
    let looks = match mask::needs_looks(settings, recipes) {
        true => Looks::All,
        false => Looks::Openings,
    };
    let file = MeshFile::read(mesh, looks)?;
    let load = started.elapsed().as_secs_f64();
    let (substrate, texturing) = file.surface()?;
    let found = mask::read(settings, recipes, (mesh, &substrate, &texturing), voice);
    let found = found.map_err(|failure| {
        match settings.check_mesh(&mesh.display().to_string(), substrate.mesh_hash()) {
            Ok(()) => failure,
            Err(_) => failure.at(format!(
                "{} is another mesh than the recipe was made for",
                mesh.display()
            )),
        }
    })?;
    let precompute = started.elapsed().as_secs_f64() - load;
    let seconds = Timings {
        load,
        precompute,
        ..Timings::default()
    };
    let cutout = Cutout::of(&substrate, &texturing).unwrap_or_else(|unknown| {
        voice.warn(&format!("{}: {unknown}", mesh.display()));
        None
    });
    if !settings.mask_layers().iter().any(|layer| layer == OPAQUE) {
        let mask = found.as_ref().map(|found| &found.mask);
        let grows = |at: &SurfacePoint| mask.is_none_or(|mask| mask.at(at) > 0.0);
        let what = if mask.is_some() {
            "what the mask leaves"
        } else {
            "the surface"
        };
        let warning = cutout
            .as_ref()
            .and_then(|cutout| cutout.warning(&substrate, (what, grows)));
        warning.iter().for_each(|warning| voice.warn(warning));
    }
    let (mask, mask_layers) = match found {
        Some(found) => (Some(found.mask), found.layers),
        None => (None, Vec::new()),
    };
    Ok(Ready {
        substrate: substrate.with_up(settings.mesh_up).with_mask(mask),
        mask_layers,
        cutout,
        seconds,
    })
}

/// The mesh as the run's recipe will name it.
fn mesh_name(args: &GrowArgs, settings: &Settings, mesh: &Path, folder: &Path) -> String {
    let named = settings.mesh.as_deref().filter(|_| args.mesh.is_none());
    name_for(folder, named, settings.mesh_hash.as_deref(), mesh, args)
}

/// The layers of the mask as the run's recipe will name them.
fn mask_names(
    args: &GrowArgs,
    settings: &Settings,
    folder: &Path,
    found: &[String],
) -> Option<Vec<String>> {
    match args.resume.is_some() || args.settings().mask.is_some() {
        true => settings.mask.clone(),
        false => mask::named(settings, found, &folder.join(RECIPE)),
    }
}

/// A file as a run's recipe will name it: as the recipe does that it is grown from, where that is found from the run's
/// folder too. So the same files are written, wherever the program was called from.
fn name_for(
    folder: &Path,
    named: Option<&str>,
    hash: Option<&str>,
    file: &Path,
    args: &GrowArgs,
) -> String {
    let place = |file: &Path| file.canonicalize().ok();
    let is_found = |named: &&str| {
        if args.resume.is_some() {
            return true;
        }
        let found = named_mesh(&folder.join(RECIPE), named, hash);
        found.and_then(|found| place(&found)) == place(file)
    };
    match named.filter(is_found) {
        Some(named) => named.to_owned(),
        None => portable(file),
    }
}

/// The complete recipe, for the mesh that was loaded.
fn recipe(
    args: &GrowArgs,
    settings: Settings,
    substrate: &Substrate,
    file: String,
    voice: Voice,
) -> Result<Recipe, Failure> {
    match settings.check_mesh(&file, substrate.mesh_hash()) {
        Err(_) if args.resume.is_some() => return Err(other_mesh(args, &settings, substrate)),
        Err(other) if args.mesh.is_none() => {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{other}; name the right file, or name this one as MESH to grow on it all the same"
            )));
        }
        Err(_) => voice.note(&format!(
            "{file} is another mesh than the recipe was made for: lengths stay those of the recipe"
        )),
        Ok(()) => {}
    }
    let limits = mask::limits(&settings);
    let cure = match settings.mask_layers() {
        [_, _, ..] => " Lichen grows only where all masks let it",
        _ => "",
    };
    settings
        .resolve(substrate, &file)
        .map_err(|error| match error {
            SettingsError::Place(PlaceError::NoHabitat) => {
                Failure::usage(format!("{limits}: {error}{cure}"))
            }
            other => blaming(args, other, |flags| flags.resolve(substrate, "").is_ok()),
        })
}

fn other_mesh(args: &GrowArgs, settings: &Settings, substrate: &Substrate) -> Failure {
    Failure::Failed(anyhow::anyhow!(
        "this is another mesh than the run was on: its hash is {}, that of the run's mesh {}; name \
         the right file: {}",
        substrate.mesh_hash(),
        settings.mesh_hash.as_deref().unwrap_or("unknown"),
        args.with_mesh()
    ))
}

/// How much of a run there is.
enum How {
    Whole,
    /// Ctrl-C ended the growth.
    CutShort,
    /// Ctrl-C came after the growth, while the picture was taken or files were written.
    WithoutPicture,
}

/// What came of it, and how the command ends.
fn conclude(report: &RunReport, how: How, folder: &Path, voice: Voice) -> Result<(), Failure> {
    let summary = format!(
        "{}: {}{}, covering {}{}, grown in {}; it ended because {}",
        folder.display(),
        elements(report.elements),
        match report.colonies {
            1 => format!(", effective radius {}", short(report.effective_radius)),
            several => format!(" in {} colonies", count(several as u64)),
        },
        percent(report.covered_share),
        match report.habitat_share < 1.0 {
            true => " of where it may grow",
            false => "",
        },
        duration(report.seconds.grow),
        report.stopped_because,
    );
    let interrupted = match how {
        How::CutShort => Some(format!(
            "interrupted; what there is was written. {summary}; to go on: thallus grow --resume {}",
            shell_path(folder)
        )),
        How::WithoutPicture => Some(format!(
            "interrupted after the growth: all was written but for the picture, if that was being taken. {summary}"
        )),
        How::Whole => None,
    };
    if let Some(said) = interrupted {
        terminal::warn(&said);
        return Err(Failure::Interrupted);
    }
    if !voice.quiet {
        let there = FILES.iter().filter(|file| folder.join(file).exists());
        let there: Vec<&str> = there.copied().collect();
        terminal::say(&format!("{summary}\n  {}", there.join(", ")))?;
    }
    Ok(())
}
