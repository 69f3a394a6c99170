//! `thallus check`: what a mesh file holds.

use std::cmp::Ordering;
use std::path::Path;

use serde::Serialize;
use thallus::substrate::{
    LoadError, Loaded, PieceReport, Substrate, SubstrateError, SubstrateReport, Texturing, UpAxis,
    load_soup, load_textured,
};

use super::args::CheckArgs;
use super::check_maps::Maps;
use super::cutout::Cutout;
use super::failure::Failure;
use super::memory::Room;
use super::mesh_file::load_error;
use super::number::{count, percent, place, plural, short};
use super::run_args::start_threads;
use super::{stand_ins, terminal, warnings};

pub(crate) fn check(args: &CheckArgs) -> Result<(), Failure> {
    start_threads(None)?;
    let room = Room::now();
    let (loaded, texturing) = match load(&args.mesh) {
        Ok(loaded) => loaded,
        Err(error) => return no_surface(args, &error.into()),
    };
    room.check(&args.mesh, &loaded)?;
    match Substrate::from_loaded(loaded) {
        Ok(substrate) => surface(args, &substrate, &texturing),
        Err(error) => no_surface(args, &error),
    }
}

/// What else a mesh's file says of its triangles.
#[derive(Default)]
struct Named {
    with_uvs: usize,
    objects: Vec<Name>,
    materials: Vec<Name>,
}

/// What triangles are chosen by, and how many have it.
#[derive(Clone, Debug, Serialize)]
struct Name {
    name: String,
    triangles: usize,
}

/// A mesh, and what its triangles have. Faulty UVs are as good as none: lichen grows without.
fn load(mesh: &Path) -> Result<(Loaded, Texturing), LoadError> {
    match load_textured(mesh) {
        Ok(loaded) => Ok(loaded),
        Err(fault) => {
            let notes = vec![format!("texture coordinates are passed over: {fault}")];
            let none = Texturing {
                notes,
                ..Texturing::default()
            };
            Ok((load_soup(mesh)?, none))
        }
    }
}

fn named(texturing: &Texturing) -> Named {
    let names = |names: Vec<(&str, usize)>| {
        let name = |(name, triangles): (&str, usize)| Name {
            name: name.to_owned(),
            triangles,
        };
        names.into_iter().map(name).collect()
    };
    Named {
        with_uvs: texturing.uvs.iter().flatten().count(),
        objects: names(texturing.objects()),
        materials: names(texturing.named_materials()),
    }
}

/// A file that holds a surface, on which there may still be no room.
fn surface(args: &CheckArgs, substrate: &Substrate, texturing: &Texturing) -> Result<(), Failure> {
    let named = named(texturing);
    let radius = substrate.auto_radius();
    let mut warnings = warnings::warnings(substrate, radius);
    warnings.extend(match Cutout::of(substrate, texturing) {
        Ok(cutout) => cutout.and_then(|c| c.warning(substrate, ("the surface", |_: &_| true))),
        Err(unknown) => Some(unknown),
    });
    warnings.extend(stand_ins::warning(texturing));
    warnings.extend(texturing.notes.iter().cloned());
    warnings.extend(texturing.damaged_images());
    let maps = Maps::of(substrate, texturing);
    let unfit = warnings::unfit(substrate, &args.mesh.display().to_string());
    match args.json {
        true => Answer {
            up: Some(substrate.up_axis()),
            uv_triangles: named.with_uvs,
            maps: maps.as_ref().ok().and_then(Option::as_ref),
            objects: named.objects,
            materials: named.materials,
            ..Answer::surface(substrate.report(), radius, &warnings, unfit.is_none())
        }
        .say()?,
        false => {
            let rows = rows(substrate, &named, &maps);
            terminal::say_text(&text(&args.mesh, &rows, &warnings, unfit.is_none()))?;
        }
    }
    match unfit {
        None => Ok(()),
        Some(reason) => Err(failure(&reason)),
    }
}

/// No file, or one that holds no surface: what to do is in the error.
fn no_surface(args: &CheckArgs, error: &SubstrateError) -> Result<(), Failure> {
    let reason = load_error(&args.mesh, error);
    if !args.mesh.is_file() {
        return Err(Failure::Failed(anyhow::Error::msg(reason)));
    }
    if args.json {
        Answer::no_surface(std::slice::from_ref(&reason)).say()?;
    }
    Err(failure(&reason))
}

fn failure(reason: &str) -> Failure {
    Failure::Failed(anyhow::anyhow!("unfit to grow on: {reason}"))
}

type Row = (&'static str, String);

fn text(mesh: &Path, rows: &[Row], warnings: &[String], fit: bool) -> String {
    let mut lines = vec![mesh.display().to_string()];
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    lines.extend(
        rows.iter()
            .map(|(name, value)| format!("  {name:width$}  {value}")),
    );
    lines.extend(warnings.iter().map(|w| format!("  warning: {w}")));
    let verdict = if fit { "fit" } else { "unfit" };
    let but = match warnings.len() {
        0 => String::new(),
        n => format!(", with {}", plural(n, "warning", "warnings")),
    };
    lines.push(format!("  {verdict} to grow on{but}"));
    lines.join("\n") + "\n"
}

fn rows(substrate: &Substrate, named: &Named, maps: &Result<Option<Maps>, String>) -> Vec<Row> {
    let report = substrate.report();
    let radius = substrate.auto_radius();
    let [low, high] = report.bounding_box;
    let size = [0, 1, 2].map(|i| short(high[i] - low[i])).join(" x ");
    let [p5, median, p95] = report.edge_length.map(short);
    let mut rows = vec![
        ("triangles", kept(report)),
        (
            "vertices",
            format!("{} after welding", count(report.vertices as u64)),
        ),
        ("pieces", pieces(report)),
        ("open edges", edges(report.boundary_edges)),
        ("non-manifold", edges(report.non_manifold_edges)),
        ("wound apart", edges(report.winding_conflicts)),
        (
            "bounding box",
            format!("{} to {}, {size}", place(low), place(high)),
        ),
        ("up", up(substrate)),
        ("UVs", uvs(named.with_uvs, report.triangles_read)),
        ("area", short(report.area)),
        (
            "edge length",
            format!("median {median} (5 % below {p5}, 5 % above {p95})"),
        ),
        (
            "auto radius",
            format!("{} (diagonal / 2000)", short(radius)),
        ),
    ];
    match maps {
        Ok(None) => {}
        Ok(Some(maps)) => rows.push(("maps", maps.told(radius))),
        Err(problem) => rows.push(("maps", problem.clone())),
    }
    let lists = [("objects", &named.objects), ("materials", &named.materials)];
    let lists = lists.into_iter().filter(|(_, names)| names.len() > 1);
    rows.extend(lists.map(|(kind, names)| (kind, listed(names))));
    rows.extend(
        report
            .repairs
            .iter()
            .map(|repair| ("repaired", repair.clone())),
    );
    rows
}

/// The axis that pictures and files take for up.
fn up(substrate: &Substrate) -> String {
    let (axis, other) = match substrate.up_axis() {
        UpAxis::Y => ("y", "z"),
        UpAxis::Z => ("z", "y"),
    };
    format!("{axis}, as is usual in such files; if it is {other}, grow with --mesh-up {other}")
}

/// What `thallus bake` lays its maps out in.
fn uvs(with: usize, of: usize) -> String {
    match (with, of) {
        (0, _) => "none: lichen is baked into maps with --unwrap".to_owned(),
        (with, of) if with < of => format!(
            "{} of {} triangles have some",
            count(with as u64),
            count(of as u64)
        ),
        _ => "all triangles have some".to_owned(),
    }
}

/// Names of objects or materials, at most, in a row; --json has all.
const NAMES: usize = 8;

/// What lichen may be kept to, with --mask.
fn listed(names: &[Name]) -> String {
    let shown = names.iter().take(NAMES);
    let shown = shown.map(|n| format!("{} ({})", n.name, count(n.triangles as u64)));
    let mut all = shown.collect::<Vec<_>>().join(", ");
    if names.len() > NAMES {
        all += &format!(", and {} more", names.len() - NAMES);
    }
    format!("{}, by triangles: {all}", names.len())
}

fn kept(report: &SubstrateReport) -> String {
    let [kept, read] = [report.triangles, report.triangles_read].map(|n| count(n as u64));
    match report.triangles.cmp(&report.triangles_read) {
        Ordering::Less => format!("{kept} kept of {read}"),
        Ordering::Equal => kept,
        Ordering::Greater => format!("{kept} made of {read}"),
    }
}

/// Pieces named one by one, at most.
const PIECES: usize = 5;

fn pieces(report: &SubstrateReport) -> String {
    let share = |area: f64| percent(area / report.area);
    let named = report.components.iter().take(PIECES);
    let mut areas: Vec<_> = named
        .map(|c| format!("{} ({})", short(c.area), share(c.area)))
        .collect();
    let n = report.components.len();
    if n > PIECES {
        let rest = report.components[PIECES..].iter().map(|c| c.area).sum();
        areas.push(format!(
            "{} in {} more ({})",
            short(rest),
            n - PIECES,
            share(rest)
        ));
    }
    format!("{n}; by area {}", areas.join(", "))
}

fn edges(n: usize) -> String {
    match n {
        0 => "none".to_owned(),
        _ => plural(n, "edge", "edges"),
    }
}

/// The JSON answer, keys in this order.
#[derive(Debug, Default, Serialize)]
struct Answer<'a> {
    triangles_read: usize,
    triangles: usize,
    vertices: usize,
    components: Vec<Piece>,
    boundary_edges: usize,
    non_manifold_edges: usize,
    winding_conflicts: usize,
    degenerate_triangles: usize,
    duplicate_triangles: usize,
    area: f64,
    /// Null, as the next three, for a file without a surface.
    bounding_box: Option<[[f64; 3]; 2]>,
    edge_length: Option<Percentiles>,
    auto_radius: Option<f64>,
    up: Option<UpAxis>,
    uv_triangles: usize,
    /// Null where `thallus bake` can make none.
    maps: Option<&'a Maps>,
    objects: Vec<Name>,
    materials: Vec<Name>,
    repairs: &'a [String],
    warnings: &'a [String],
    fit: bool,
}

#[derive(Debug, Serialize)]
struct Piece {
    triangles: usize,
    area: f64,
}

#[derive(Debug, Serialize)]
struct Percentiles {
    p5: f64,
    p50: f64,
    p95: f64,
}

impl<'a> Answer<'a> {
    fn surface(
        report: &'a SubstrateReport,
        auto_radius: f64,
        warnings: &'a [String],
        fit: bool,
    ) -> Self {
        let pieces = report.components.iter();
        let [p5, p50, p95] = report.edge_length;
        Self {
            triangles_read: report.triangles_read,
            triangles: report.triangles,
            vertices: report.vertices,
            components: pieces.map(Piece::from).collect(),
            boundary_edges: report.boundary_edges,
            non_manifold_edges: report.non_manifold_edges,
            winding_conflicts: report.winding_conflicts,
            degenerate_triangles: report.degenerate_triangles,
            duplicate_triangles: report.duplicate_triangles,
            area: report.area,
            bounding_box: Some(report.bounding_box),
            edge_length: Some(Percentiles { p5, p50, p95 }),
            auto_radius: Some(auto_radius),
            repairs: &report.repairs,
            warnings,
            fit,
            ..Self::default()
        }
    }

    fn no_surface(reason: &'a [String]) -> Self {
        Self {
            warnings: reason,
            ..Self::default()
        }
    }

    fn say(&self) -> Result<(), Failure> {
        Ok(terminal::say_json(self)?)
    }
}

impl From<&PieceReport> for Piece {
    fn from(piece: &PieceReport) -> Self {
        Self {
            triangles: piece.triangles,
            area: piece.area,
        }
    }
}
