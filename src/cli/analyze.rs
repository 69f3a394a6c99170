//! `thallus analyze`: numbers about a lichen.

use std::path::Path;

use anyhow::{Context, Error};
use serde::Serialize;
use thallus::analysis::{
    Analysis, Centres, Dimension, SCALARS, Scalar, SurfaceMetric, Through, analyze as measure,
    plot_names, plots,
};
use thallus::export::write_file_atomically;
use thallus::substrate::{Substrate, SurfacePoint};

use super::analyze_args::AnalyzeArgs;
use super::export::smooth_on;
use super::failure::Failure;
use super::grown::Grown;
use super::interrupt::leave_no_part;
use super::mesh_file::load;
use super::number::{count, elements, short};
use super::output::{check_free, check_names_folder};
use super::run_args::start_threads;
use super::terminal::{self, Voice};

pub(crate) fn analyze(args: &AnalyzeArgs) -> Result<(), Failure> {
    let folder = args.plots.iter();
    let files: Vec<_> = folder
        .flat_map(|folder| plot_names().map(|name| folder.join(name)))
        .collect();
    args.plots.as_deref().map_or(Ok(()), check_names_folder)?;
    check_free(&files, args.force)?;
    leave_no_part();
    start_threads(args.run.threads)?;
    let voice = args.run.voice();
    let mut grown = Grown::read(&args.from, voice)?;
    choose_colony(args, &mut grown, voice)?;
    let ground = ground(args, &mut grown, voice)?;
    let doing = elements(grown.elements.len());
    let spinner = voice.spinner(&format!("measuring {doing}"));
    let metric = ground
        .as_ref()
        .map(|(substrate, places)| SurfaceMetric::new(substrate, places));
    let metric = metric.as_ref().map(|metric| metric as _);
    let analysis = measure(&grown.elements.sample(), metric, centres(args));
    spinner.finish_and_clear();
    let analysis = analysis.with_context(|| args.from.display().to_string())?;
    if let Some(folder) = &args.plots {
        write_plots(folder, args.force, &analysis)?;
    }
    match args.json {
        true => say_json(args, &analysis),
        false => Ok(terminal::say_text(&text(args, &analysis))?),
    }
}

/// Leaves the colony that was asked for.
fn choose_colony(args: &AnalyzeArgs, grown: &mut Grown, voice: Voice) -> Result<(), Failure> {
    let colonies = grown.elements.colonies();
    let Some(colony) = args.colony else {
        if colonies > 1 {
            voice.warn(&format!(
                "these are {} colonies, measured as one lichen, without front, growth and dimension by gyration: \
                 --colony N, from 0 to {}, measures one alone",
                count(colonies),
                colonies - 1
            ));
        }
        return Ok(());
    };
    let alone = grown.elements.of_colony(colony);
    grown.elements = alone.with_context(|| args.from.display().to_string())?;
    match grown.elements.is_empty() {
        false => Ok(()),
        true => Err(Failure::usage(format!(
            "{}: no element is of colony {colony}; give one from 0 to {}",
            args.from.display(),
            colonies.saturating_sub(1)
        ))),
    }
}

fn centres(args: &AnalyzeArgs) -> Centres {
    Centres {
        space: args.centres as usize,
        surface: args.surface_centres as usize,
    }
}

/// The mesh, and where on it the elements are, which get its smooth normals. Without it the lichen
/// is measured through space alone; a mesh that was asked for has to be the right one.
fn ground(
    args: &AnalyzeArgs,
    grown: &mut Grown,
    voice: Voice,
) -> Result<Option<(Substrate, Vec<SurfacePoint>)>, Failure> {
    let mesh = match (&args.mesh, grown.mesh_file()) {
        (Some(mesh), _) => mesh.clone(),
        (None, Ok(mesh)) => mesh,
        (None, Err(unknown)) => {
            voice.warn(&format!(
                "{unknown}: distances along the surface and the density profile are not measured; give the mesh with --mesh"
            ));
            return Ok(None);
        }
    };
    let substrate = load(&mesh)?;
    grown.tell_of_change(args.mesh.as_deref(), &mesh, &substrate);
    let found = smooth_on(&mut grown.elements, &substrate);
    let (places, is_turned) = found.with_context(|| mesh.display().to_string())?;
    grown.tell_of_turn(&mesh, is_turned);
    Ok(Some((substrate, places)))
}

fn write_plots(folder: &Path, force: bool, analysis: &Analysis) -> Result<(), Failure> {
    for (name, bytes) in plots(analysis).map_err(Error::new)? {
        write_file_atomically(&folder.join(name), force, |out| out.write_all(&bytes))?;
    }
    Ok(())
}

/// The JSON answer: the scalars by name, and all that they were read from.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    /// Which one was measured alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    colony: Option<u32>,
    scalars: serde_json::Map<String, serde_json::Value>,
    #[serde(flatten)]
    analysis: &'a Analysis,
}

fn say_json(args: &AnalyzeArgs, analysis: &Analysis) -> Result<(), Failure> {
    let value = |(name, value): (&str, f64)| (name.to_owned(), value.into());
    let answer = Answer {
        colony: args.colony,
        scalars: analysis.scalars().into_iter().map(value).collect(),
        analysis,
    };
    Ok(terminal::say_json(&answer)?)
}

fn text(args: &AnalyzeArgs, analysis: &Analysis) -> String {
    let elements = elements(analysis.elements);
    let from = args.from.display();
    let mut lines = vec![match args.colony {
        None => format!("{from}: {elements}"),
        Some(colony) => format!("{from}: {elements} of colony {colony}"),
    }];
    let form = SCALARS.iter().filter(|s| !s.name.contains("dimension_"));
    lines.extend(form.map(|s| scalar_line(s, analysis)));
    if let Some(pace) = analysis.front.pace.filter(|_| analysis.colonies < 2) {
        lines.push(format!("R_e grows by birth: {}", pace.word()));
    }
    lines.push("fractal dimensions".to_owned());
    lines.extend(analysis.dimensions.iter().map(dimension_line));
    lines.join("\n") + "\n"
}

fn scalar_line(scalar: &Scalar, analysis: &Analysis) -> String {
    let value = scalar.of(analysis).map_or("-".to_owned(), short);
    let unit = match scalar.unit {
        "1" => "",
        unit => unit,
    };
    let Scalar { name, meaning, .. } = scalar;
    format!("  {name:26}{value:>10} {unit:10}  {meaning}")
}

fn dimension_line(dimension: &Dimension) -> String {
    let way = match dimension.through {
        Through::Space => "through space",
        Through::Surface => "along the surface",
    };
    let found = match (dimension.dimension, dimension.error) {
        (Some(value), Some(error)) => format!("{value:.3} +- {error:.3}"),
        _ => "-".to_owned(),
    };
    let [from, to] = dimension.scaling.range.unwrap_or_default().map(short);
    let points = dimension.scaling.fit.map_or(0, |fit| fit.points);
    let range = match (points, dimension.dimension) {
        (0, _) => "too small a lichen to fit".to_owned(),
        (n, None) => format!("{n} points from {from} to {to}: its error would be above 1"),
        (n, _) => format!("{n} points from {from} to {to}"),
    };
    let alpha = dimension
        .alpha
        .map_or_else(String::new, |alpha| format!(", alpha {alpha:.3}"));
    let method = dimension.method.name();
    format!("  {method:12}{way:19}{found:15}  {range}{alpha}")
}
