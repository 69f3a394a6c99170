//! `thallus check`: what a mesh file holds.

use std::path::Path;

use serde_json::{Value, json};
use thallus::substrate::{Substrate, SubstrateError, SubstrateReport};

use super::args::CheckArgs;
use super::failure::Failure;
use super::number::{count, percent, place, plural, short};
use super::{terminal, warnings};

pub(crate) fn check(args: &CheckArgs) -> Result<(), Failure> {
    match Substrate::load(&args.mesh) {
        Ok(substrate) => fit(args, &substrate),
        Err(error) => unfit(args, &error),
    }
}

fn fit(args: &CheckArgs, substrate: &Substrate) -> Result<(), Failure> {
    let radius = substrate.auto_radius();
    let warnings = warnings::warnings(substrate, radius);
    let text = match args.json {
        true => pretty(&json(substrate.report(), radius, &warnings)),
        false => text(&args.mesh, substrate, &warnings),
    };
    terminal::say_text(&text)?;
    Ok(())
}

/// A file that holds no surface: what to do is in the error.
fn unfit(args: &CheckArgs, error: &SubstrateError) -> Result<(), Failure> {
    let reason = load_error(&args.mesh, error);
    if args.json && args.mesh.is_file() {
        terminal::say_text(&pretty(&unfit_json(&reason)))?;
    }
    Err(Failure::Failed(anyhow::anyhow!(
        "unfit to grow on: {reason}"
    )))
}

/// Why a mesh could not be loaded, with the file's name.
pub(crate) fn load_error(mesh: &Path, error: &SubstrateError) -> String {
    match error {
        SubstrateError::Load(named) => named.to_string(),
        unnamed => format!("{}: {unnamed}", mesh.display()),
    }
}

fn text(mesh: &Path, substrate: &Substrate, warnings: &[String]) -> String {
    let mut lines = vec![mesh.display().to_string()];
    let rows = rows(substrate);
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    lines.extend(
        rows.iter()
            .map(|(name, value)| format!("  {name:width$}  {value}")),
    );
    lines.extend(warnings.iter().map(|w| format!("  warning: {w}")));
    lines.push("  fit to grow on".to_owned());
    lines.join("\n") + "\n"
}

fn rows(substrate: &Substrate) -> Vec<(&'static str, String)> {
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
        (
            "open edges",
            edges(report.boundary_edges, &report.boundary_places),
        ),
        (
            "non-manifold",
            edges(report.non_manifold_edges, &report.non_manifold_places),
        ),
        (
            "bounding box",
            format!("{} to {}, {size}", place(low), place(high)),
        ),
        ("area", short(report.area)),
        (
            "edge length",
            format!("{median} (5 % below {p5}, 5 % above {p95})"),
        ),
        (
            "auto radius",
            format!("{} (diagonal / 2000)", short(radius)),
        ),
    ];
    rows.extend(
        report
            .repairs
            .iter()
            .map(|repair| ("repaired", repair.clone())),
    );
    rows
}

fn kept(report: &SubstrateReport) -> String {
    let [kept, read] = [report.triangles, report.triangles_read].map(|n| count(n as u64));
    match kept == read {
        true => kept,
        false => format!("{kept} kept of {read}"),
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

fn edges(n: usize, places: &[[f64; 3]]) -> String {
    let near: Vec<_> = places.iter().copied().map(place).collect();
    match n {
        0 => "none".to_owned(),
        _ => format!("{}, near {}", plural(n, "edge", "edges"), near.join(", ")),
    }
}

fn json(report: &SubstrateReport, auto_radius: f64, warnings: &[String]) -> Value {
    let component =
        |c: &thallus::substrate::PieceReport| json!({"triangles": c.triangles, "area": c.area});
    let [p5, p50, p95] = report.edge_length;
    json!({
        "triangles_read": report.triangles_read,
        "triangles": report.triangles,
        "vertices": report.vertices,
        "components": report.components.iter().map(component).collect::<Vec<_>>(),
        "boundary_edges": report.boundary_edges,
        "non_manifold_edges": report.non_manifold_edges,
        "degenerate_triangles": report.degenerate_triangles,
        "duplicate_triangles": report.duplicate_triangles,
        "area": report.area,
        "bounding_box": report.bounding_box,
        "edge_length": {"p5": p5, "p50": p50, "p95": p95},
        "auto_radius": auto_radius,
        "repairs": report.repairs,
        "warnings": warnings,
        "fit": true,
    })
}

/// The same keys for a file without a surface; what cannot be known is null.
fn unfit_json(reason: &str) -> Value {
    json!({
        "triangles_read": 0,
        "triangles": 0,
        "vertices": 0,
        "components": [],
        "boundary_edges": 0,
        "non_manifold_edges": 0,
        "degenerate_triangles": 0,
        "duplicate_triangles": 0,
        "area": 0.0,
        "bounding_box": null,
        "edge_length": null,
        "auto_radius": null,
        "repairs": [],
        "warnings": [reason],
        "fit": false,
    })
}

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}
