//! What `thallus bake` says at its end.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use thallus::bake::{Baked, LayoutReport, MAPS};

use super::bake_args::BakeArgs;
use super::bake_parts::MapPart;
use super::bake_write::GLB;
use super::failure::Failure;
use super::number::{duration, elements, plural};
use super::terminal;

/// The JSON answer, keys in this order.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Report {
    pub(crate) elements: usize,
    pub(crate) lichens: usize,
    pub(crate) folder: String,
    pub(crate) size: u32,
    /// Where all is in the same maps.
    #[serde(flatten)]
    pub(crate) whole: Option<PartReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<Vec<PartReport>>,
    /// Those without maps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) parts_without_maps: Vec<String>,
    pub(crate) files: Vec<String>,
    pub(crate) seconds: Seconds,
}

#[derive(Debug, Serialize)]
pub(crate) struct PartReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    elements: Option<usize>,
    texel: f64,
    highest: f64,
    covered_by_layout: f64,
    overlapping_texels: usize,
    overlapping_triangles: usize,
    triangles_not_shown: usize,
    /// Of a part.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    maps: Vec<String>,
}

#[derive(Debug, Default, Serialize)]
pub(crate) struct Seconds {
    load: f64,
    pub(crate) bake: f64,
    pub(crate) write: f64,
    pub(crate) total: f64,
}

impl Seconds {
    /// Of loading, which is over.
    pub(crate) fn loaded(started: Instant) -> Self {
        Self {
            load: started.elapsed().as_secs_f64(),
            ..Self::default()
        }
    }
}

impl PartReport {
    /// Of a part, the elements on it and the names of its maps.
    pub(crate) fn new(
        part: &MapPart,
        (elements, baked): (usize, &Baked),
        maps: Vec<String>,
    ) -> Self {
        let LayoutReport {
            texels,
            covered,
            overlaps,
            not_shown,
            texel,
            ..
        } = baked.report();
        Self {
            part: part.name.clone(),
            elements: part.name.as_ref().map(|_| elements),
            texel,
            highest: baked.highest(),
            covered_by_layout: covered as f64 / texels as f64,
            overlapping_texels: overlaps.texels,
            overlapping_triangles: overlaps.triangles,
            triangles_not_shown: not_shown,
            maps: if part.name.is_some() {
                maps
            } else {
                Vec::new()
            },
        }
    }
}

impl Report {
    /// Of what has been baked.
    pub(crate) fn of_parts(mut parts: Vec<PartReport>) -> Self {
        let is_whole = matches!(&parts[..], [one] if one.part.is_none());
        let whole = if is_whole { parts.pop() } else { None };
        Self {
            parts: whole.is_none().then_some(parts),
            whole,
            ..Self::default()
        }
    }
}

pub(crate) fn conclude(args: &BakeArgs, report: &Report) -> Result<(), Failure> {
    if args.json {
        terminal::say_json(report)?;
    } else if !args.run.quiet {
        let (elements, size) = (elements(report.elements), report.size);
        let seconds = duration(report.seconds.total);
        let glb = Path::new(&report.folder).join(GLB);
        let of = match report.lichens {
            1 => String::new(),
            several => format!(" of {several} lichens"),
        };
        let each = match report.parts.as_deref() {
            None => String::new(),
            Some([one]) => format!(" of '{}'", one.part.as_deref().unwrap_or_default()),
            Some(parts) => format!(" for each of {}", plural(parts.len(), "part", "parts")),
        };
        terminal::say(&format!(
            "{}: {elements}{of} in {} maps of {size} x {size}{each}, in {seconds}",
            glb.display(),
            MAPS.len()
        ))?;
    }
    Ok(())
}
