//! Every file of the shared mesh collection behaves as its manifest says.
//!
//! The rule for triangle counts: a polygon of n corners is n − 2 triangles, degenerate ones are
//! kept (the cleaner drops them later), so a loaded soup has exactly the manifest's `triangles`.
#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements, for whoever asks to see them

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use thallus::substrate::{LoadError, LoadFault, Loaded, Soup, load_soup};

/// Generous: the whole collection loads in a second, a hang would take for ever.
const LONGEST: Duration = Duration::from_secs(5);

/// Files that we load although the manifest's own reader could not, with their true triangles.
const BETTER: [(&str, usize); 3] = [
    // Meshopt data, which the manifest's reader does not decode: 'accessors claim 12 triangles'.
    ("BoxMeshopt.glb", 12),
    ("BoxTextured_meshopt.glb", 12),
    // 80 triangles, of which the manifest counts one instance of 2500.
    ("InstanceTest.glb", 80 * 2500),
];

/// Files whose bounding box the manifest has for something else than what the file says: one instance of many, morph
/// targets without their weights.
const OTHER_BOX: [&str; 2] = ["InstanceTest.glb", "MorphPrimitivesTest.gltf"];

struct Row {
    file: String,
    triangles: Option<usize>,
    size: Option<[f64; 3]>,
    expect: String,
}

fn read_manifest(folder: &Path) -> Vec<Row> {
    let text = std::fs::read_to_string(folder.join("MANIFEST.tsv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split('\t').collect();
    let column = |name| header.iter().position(|title| *title == name).unwrap();
    let (file, triangles, size, expect) = (
        column("file"),
        column("triangles"),
        column("bbox"),
        column("expect"),
    );
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split('\t').collect();
            Row {
                file: cells[file].strip_prefix("shared/").unwrap().into(),
                triangles: cells[triangles].parse().ok(),
                size: read_size(cells[size]),
                expect: cells[expect].into(),
            }
        })
        .collect()
}

fn read_size(cell: &str) -> Option<[f64; 3]> {
    let sides: Vec<f64> = cell
        .split(" x ")
        .filter_map(|side| side.parse().ok())
        .collect();
    sides.try_into().ok()
}

/// The size of the box around the vertices that triangles use.
fn size_of(soup: &Soup) -> [f64; 3] {
    let used = || {
        soup.triangles
            .iter()
            .flatten()
            .map(|&i| soup.positions[i as usize])
    };
    std::array::from_fn(|axis| {
        let low = used().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let high = used().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        high - low
    })
}

fn check_sound(soup: &Soup) -> Result<(), String> {
    let count = soup.positions.len() as u32;
    if soup.triangles.iter().flatten().any(|&i| i >= count) {
        return Err("an index is out of range".into());
    }
    if soup.positions.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a position is not finite".into());
    }
    Ok(())
}

fn check_loaded(row: &Row, loaded: &Loaded) -> Result<(), String> {
    check_sound(&loaded.soup)?;
    if loaded.hash.len() != 64 {
        return Err(format!("hash {:?}", loaded.hash));
    }
    let found = loaded.soup.triangles.len();
    let known = BETTER.iter().find(|(name, _)| row.file.ends_with(name));
    let expected = known.map(|(_, count)| *count).or(row.triangles);
    if expected.is_some_and(|expected| expected != found) {
        return Err(format!("{found} triangles, expected {expected:?}"));
    }
    let Some(expected) = row
        .size
        .filter(|_| !OTHER_BOX.iter().any(|name| row.file.ends_with(name)))
    else {
        return Ok(());
    };
    let size = size_of(&loaded.soup);
    // The manifest prints four significant digits.
    let close = |a: f64, b: f64| (a - b).abs() <= 6e-4 * b.abs() + 1e-9;
    if (0..3).all(|axis| close(size[axis], expected[axis])) {
        return Ok(());
    }
    Err(format!("size {size:?}, expected {expected:?}"))
}

fn check_refused(row: &Row, error: &LoadError, path: &Path) -> Result<(), String> {
    let text = error.to_string();
    if !text.starts_with(&path.display().to_string()) {
        return Err(format!("the message does not begin with the file: {text}"));
    }
    let named = row.expect.split("naming ").nth(1).unwrap_or("");
    let named = if named == "the meshopt extension" {
        "EXT_meshopt_compression"
    } else {
        named
    };
    if !text.contains(named) {
        return Err(format!("the message does not name {named}: {text}"));
    }
    Ok(())
}

/// What the manifest's `expect` asks of the outcome.
fn judge(row: &Row, path: &Path, outcome: &Result<Loaded, LoadError>) -> Result<(), String> {
    let better = BETTER.iter().any(|(name, _)| row.file.ends_with(name));
    match outcome {
        Err(error) => check_refused(row, error, path)?,
        Ok(loaded) => check_sound(&loaded.soup)?,
    }
    let expect = row.expect.as_str();
    let no_triangles = |error: &LoadError| matches!(error.fault, LoadFault::NoTriangles { .. });
    match outcome {
        Ok(loaded) if expect.starts_with("load") || better => check_loaded(row, loaded),
        Ok(loaded) if expect.starts_with("clear message: only degenerate") => {
            check_loaded(row, loaded)
        }
        Ok(_) if expect.starts_with("no panic/hang") => Ok(()),
        Ok(_) => Err("it loaded".into()),
        Err(error) if expect.starts_with("clear message: no triangles") => {
            match no_triangles(error) {
                true => Ok(()),
                false => Err(format!("another error: {error}")),
            }
        }
        Err(error) if expect.starts_with("load") => Err(error.to_string()),
        Err(_) => Ok(()),
    }
}

#[test]
fn every_shared_mesh_loads_or_fails_as_its_manifest_says() {
    let Some(folder) = common::shared_folder() else {
        return;
    };
    let rows = read_manifest(&folder);
    let mut wrong = Vec::new();
    let mut loaded = 0;
    for row in &rows {
        let path = folder.join(&row.file);
        let begun = Instant::now();
        let outcome = load_soup(&path);
        let took = begun.elapsed();
        if took > LONGEST {
            wrong.push(format!("{}: took {took:?}", row.file));
        }
        loaded += usize::from(outcome.is_ok());
        if let Err(problem) = judge(row, &path, &outcome) {
            wrong.push(format!("{} [{}]: {problem}", row.file, row.expect));
        }
        if let (Err(error), Some(_)) = (&outcome, std::env::var_os("THALLUS_SHOW_ERRORS")) {
            eprintln!("{error}");
        }
    }
    assert!(
        !rows.is_empty() && loaded > 0,
        "the collection is there, but nothing was checked"
    );
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        rows.len(),
        wrong.join("\n")
    );
}
