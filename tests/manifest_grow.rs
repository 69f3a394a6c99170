//! Lichen grows on every shared mesh that loads, with the radius that is chosen for it.
//!
//! What an element takes on each, and the worst over the median, is printed:
//! `cargo test --release --test manifest_grow -- --nocapture`.
#![allow(clippy::print_stdout)] // measurements, for whoever asks to see them

mod common;

use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;
use thallus::run::{Execution, Settings, SettingsError, StopSetting, Stopped, grow};
use thallus::substrate::Substrate;

/// Meshes on which a run may stop before it has its elements, and say why: one is a ribbon a billionth as
/// wide as long, which one element would cover many times, and small ones are full at 20,000.
const MOST_CUT_SHORT: usize = 3;

struct Grown {
    file: String,
    triangles: usize,
    elements: usize,
    microseconds: f64,
    /// Why there are not as many as asked for.
    cut_short: Option<String>,
}

fn grow_on(root: &Path, file: &str, elements: u64) -> Grown {
    let begun = Instant::now();
    let substrate = Substrate::load(&root.join(file)).expect(file);
    let settings = Settings {
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    let (elements, cut_short) = match settings.resolve(&substrate, file) {
        Ok(recipe) => {
            let growth = grow(&substrate, &recipe, &Execution::default(), &mut ()).expect(file);
            let cut_short = (growth.stopped != Stopped::Elements).then_some(growth.stopped);
            assert!(matches!(cut_short, None | Some(Stopped::Full)), "{file}");
            (
                growth.cluster.len(),
                cut_short.map(|why| format!("{why:?}")),
            )
        }
        Err(error @ SettingsError::AutoLargerThanSurface { .. }) => (0, Some(error.to_string())),
        Err(error) => panic!("{file}: {error}"),
    };
    Grown {
        file: file.to_owned(),
        triangles: substrate.triangles().len(),
        elements,
        microseconds: begun.elapsed().as_secs_f64() * 1e6 / elements.max(1) as f64,
        cut_short,
    }
}

/// So many elements on each mesh of the collection that loads; none where it is absent.
fn grow_on_all(elements: u64) -> Option<Vec<Grown>> {
    let root = common::shared_folder()?;
    let manifest = std::fs::read_to_string(root.join("MANIFEST.tsv")).expect("a manifest");
    let mut rows = manifest.lines().map(|line| line.split('\t').collect());
    let header: Vec<&str> = rows.next().expect("a header");
    let column = |name| header.iter().position(|h| *h == name).expect(name);
    let (file, expect) = (column("file"), column("expect"));
    let named = |row: Vec<&'_ str>| row[file].trim_start_matches("shared/").to_owned();
    let files = rows
        .filter(|row| row[expect].starts_with("load"))
        .map(named);
    let files: Vec<String> = files.collect();
    // One after the other to each thread, for the meshes cost very different times.
    let grown = files.par_iter().with_max_len(1);
    let grown: Vec<Grown> = grown.map(|file| grow_on(&root, file, elements)).collect();
    assert!(grown.len() > 100, "the manifest has lost its meshes");
    let cut_short: Vec<_> = grown.iter().filter(|g| g.cut_short.is_some()).collect();
    let names: Vec<&str> = cut_short.iter().map(|g| g.file.as_str()).collect();
    assert!(names.len() <= MOST_CUT_SHORT, "{names:?}");
    let whole = |g: &&Grown| g.cut_short.is_none();
    assert!(
        grown
            .iter()
            .filter(whole)
            .all(|g| g.elements as u64 == elements)
    );
    Some(grown)
}

#[test]
fn lichen_grows_on_every_shared_mesh() {
    let Some(mut grown) = grow_on_all(20_000) else {
        return;
    };
    grown.sort_by(|a, b| a.microseconds.total_cmp(&b.microseconds));
    for g in &grown {
        let (file, why) = (&g.file, g.cut_short.as_deref().unwrap_or(""));
        let (took, triangles, elements) = (g.microseconds, g.triangles, g.elements);
        println!("{took:8.1} µs  {triangles:7} triangles  {elements:6} elements  {file} {why}");
    }
    grown.retain(|g| g.cut_short.is_none());
    let [median, worst] = [grown.len() / 2, grown.len() - 1].map(|i| grown[i].microseconds);
    println!(
        "median {median:.1} µs, worst {worst:.1} µs: {:.1} times",
        worst / median
    );
}
