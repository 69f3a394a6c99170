//! `thallus skin`: the elements of a run as a triangle mesh.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;
use thallus::cluster::Cluster;
use thallus::export::{MeshFormat, Placement, TriMesh, mesh_format_of, write_file_atomically};
use thallus::skin::{self, Paint, Shape, expected_near};
use thallus::substrate::Substrate;

use super::axes::Convention;
use super::failure::Failure;
use super::grown::Grown;
use super::interrupt::leave_no_part;
use super::memory;
use super::number::{count, duration, elements, plural};
use super::output::{check_free, check_names_file};
use super::run_args::start_threads;
use super::skin_args::SkinArgs;
use super::skin_levels::{Grounds, Thinner};
use super::skin_look::Measure;
use super::terminal::{self, Voice};

pub(crate) fn skin(args: &SkinArgs) -> Result<(), Failure> {
    let format = mesh_format_of(&args.output).map_err(|unknown| Failure::Usage(unknown.into()))?;
    let files = files(args);
    check_names_file(&args.output)?;
    check_free(&files, args.force)?;
    leave_no_part();
    start_threads(args.run.threads)?;
    let voice = args.run.voice();
    let started = Instant::now();
    let grown = Grown::read(&args.from, voice)?;
    files
        .iter()
        .try_for_each(|file| grown.spare(file, &args.mesh))?;
    let (substrate, cluster) = grown.on_mesh(&args.mesh)?;
    let convention = Convention::from(format);
    let placement = args
        .axes
        .placement(&convention, Some(substrate.up_axis()))?;
    let meters_per_unit = args.axes.meters_per_unit(&convention);
    let measure = Measure::of(&substrate, &cluster);
    let shape = measure.shape(&args.shape)?;
    let paint = measure.paint(&args.color)?;
    let triangles = memory::check_skins(&substrate, [(&cluster, &shape)])?;
    tell_of_time(triangles, expected_near(&cluster, &shape), voice);
    let mut report = Report::new(cluster.len());
    report.seconds.load = started.elapsed().as_secs_f64();
    let mesh = grow_skin(&substrate, &cluster, &shape, &paint, voice, &mut report)?;
    let how = MeshFile {
        format,
        meters_per_unit,
        placement,
        force: args.force,
        has_levels: args.size.lod.is_some(),
    };
    let lichen = Grounds {
        substrate,
        cluster,
        shape,
        paint,
    };
    let thinner = Thinner::new(lichen, mesh, &args.size, voice);
    write_all(thinner, &files, &how, voice, &mut report)?;
    warn_of_more_levels(args, voice);
    report.seconds.total = started.elapsed().as_secs_f64();
    conclude(args, &report)
}

/// Says how long a skin of so many triangles, with so many elements near each, will take, where that is long.
fn tell_of_time(triangles: f64, near: f64, voice: Voice) {
    let threads = rayon::current_num_threads();
    let seconds = triangles * (TRIANGLE_SECONDS + FELT_SECONDS * near) / threads as f64;
    if seconds >= LONG {
        voice.note(&format!(
            "about {} triangles of skin, which take roughly {} on {}",
            count(triangles as u64),
            duration(seconds),
            plural(threads, "thread", "threads")
        ));
    }
}

/// Seconds of one thread that a triangle of skin takes, and each element near it besides: within a factor of 2.5 for 14
/// skins of three lichens, of 20 to 380 elements near a triangle.
const TRIANGLE_SECONDS: f64 = 0.7e-6;
const FELT_SECONDS: f64 = 0.035e-6;

/// Less is not told.
const LONG: f64 = 10.0;

/// The files to write, the finest first.
fn files(args: &SkinArgs) -> Vec<PathBuf> {
    let Some(levels) = args.size.lod else {
        return vec![args.output.clone()];
    };
    (0..levels).map(|level| level_of(args, level)).collect()
}

/// The file of a level of detail.
fn level_of(args: &SkinArgs, level: u8) -> PathBuf {
    let mut name = args.output.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_lod{level}."));
    name.push(args.output.extension().unwrap_or_default());
    args.output.with_file_name(name)
}

/// Tells of a coarser level of an earlier skin: what reads all of them would take it for one of this.
fn warn_of_more_levels(args: &SkinArgs, voice: Voice) {
    let next = args.size.lod.map(|levels| level_of(args, levels));
    if let Some(next) = next.filter(|next| next.exists()) {
        voice.warn(&format!(
            "{}: a level of an earlier skin, not of this one: remove it and those after it",
            next.display()
        ));
    }
}

fn grow_skin(
    substrate: &Substrate,
    cluster: &Cluster,
    shape: &Shape,
    paint: &Paint,
    voice: Voice,
    report: &mut Report,
) -> Result<TriMesh, Failure> {
    let started = Instant::now();
    let doing = format!("putting a skin on {}", elements(cluster.len()));
    let spinner = voice.spinner(&doing);
    let mesh = skin::skin(substrate, cluster, shape, paint);
    spinner.finish_and_clear();
    report.seconds.skin = started.elapsed().as_secs_f64();
    mesh.map_err(|e| Failure::Usage(e.into()))
}

/// How meshes are written.
struct MeshFile {
    format: &'static MeshFormat,
    meters_per_unit: f64,
    placement: Placement,
    force: bool,
    /// Whether there are levels of detail, whose objects engines know by their names.
    has_levels: bool,
}

/// Writes every level of detail.
fn write_all(
    mut thinner: Thinner,
    files: &[PathBuf],
    how: &MeshFile,
    voice: Voice,
    report: &mut Report,
) -> Result<(), Failure> {
    for (level, file) in files.iter().enumerate() {
        let started = Instant::now();
        thinner.thin(level, file)?;
        let mut mesh = match level + 1 == files.len() {
            true => thinner.last_shown(),
            false => thinner.shown(),
        };
        report.seconds.decimate += started.elapsed().as_secs_f64();
        mesh.name = how.has_levels.then(|| format!("lichen_LOD{level}"));
        mesh.place(&how.placement);
        write(&mesh, file, how, voice, report)?;
    }
    Ok(())
}

fn write(
    mesh: &TriMesh,
    file: &Path,
    how: &MeshFile,
    voice: Voice,
    report: &mut Report,
) -> Result<(), Failure> {
    let started = Instant::now();
    let spinner = voice.spinner(&format!("writing {}", file.display()));
    let written = write_file_atomically(file, how.force, |out| {
        how.format.write(mesh, how.meters_per_unit, out)
    });
    spinner.finish_and_clear();
    written?;
    report.seconds.write += started.elapsed().as_secs_f64();
    report.files.push(FileReport {
        file: file.display().to_string(),
        triangles: mesh.triangles.len(),
        vertices: mesh.positions.len(),
        bytes: file.metadata().map_or(0, |m| m.len()),
    });
    Ok(())
}

/// The JSON answer, keys in this order.
#[derive(Debug, Serialize)]
struct Report {
    elements: usize,
    files: Vec<FileReport>,
    seconds: Seconds,
}

#[derive(Debug, Serialize)]
struct FileReport {
    file: String,
    triangles: usize,
    vertices: usize,
    bytes: u64,
}

#[derive(Debug, Default, Serialize)]
struct Seconds {
    load: f64,
    skin: f64,
    decimate: f64,
    write: f64,
    total: f64,
}

impl Report {
    fn new(elements: usize) -> Self {
        Self {
            elements,
            files: Vec::new(),
            seconds: Seconds::default(),
        }
    }
}

fn conclude(args: &SkinArgs, report: &Report) -> Result<(), Failure> {
    if args.json {
        terminal::say_json(report)?;
        return Ok(());
    }
    for file in report.files.iter().filter(|_| !args.run.quiet) {
        let [triangles, vertices] = [file.triangles, file.vertices].map(|n| count(n as u64));
        let name = &file.file;
        terminal::say(&format!(
            "{name}: {triangles} triangles, {vertices} vertices"
        ))?;
    }
    if !args.run.quiet {
        let elements = elements(report.elements);
        let seconds = duration(report.seconds.total);
        terminal::say(&format!("  a skin on {elements} in {seconds}"))?;
    }
    Ok(())
}
