//! Every shared mesh that should load has the topology that its manifest states.
//!
//! The manifest joins pieces over shared edges and welds vertices that are equal as f32, as we do.
//! Where we drop degenerate or duplicate triangles the edges about them change, so there only the
//! numbers of triangles are held against it.

mod common;

use std::collections::HashMap;
use std::path::Path;

use thallus::substrate::Substrate;

type Row<'a> = HashMap<&'a str, &'a str>;

fn number(row: &Row<'_>, column: &str) -> usize {
    row[column].parse().unwrap_or(0)
}

fn compare(root: &Path, row: &Row<'_>) -> Vec<String> {
    let file = row["file"].trim_start_matches("shared/");
    let substrate = match Substrate::load(&root.join(file)) {
        Ok(substrate) => substrate,
        Err(error) => return vec![format!("{file}: {error}")],
    };
    let report = substrate.report();
    let dropped = report.degenerate_triangles + report.duplicate_triangles;
    let mut pairs = vec![(
        "triangles kept and dropped",
        report.triangles + dropped,
        number(row, "triangles"),
    )];
    if dropped == 0 {
        pairs.extend([
            ("vertices", report.vertices, number(row, "welded_vertices")),
            (
                "components",
                report.components.len(),
                number(row, "components"),
            ),
            (
                "boundary edges",
                report.boundary_edges,
                number(row, "boundary_edges"),
            ),
            (
                "non-manifold edges",
                report.non_manifold_edges,
                number(row, "nonmanifold_edges"),
            ),
        ]);
    }
    let expected = number(row, "degenerate_tris") + number(row, "duplicate_tris");
    if (dropped == 0) != (expected == 0) {
        pairs.push(("degenerate and duplicate triangles", dropped, expected));
    }
    let differs = |(_, ours, theirs): &(&str, usize, usize)| ours != theirs;
    let say = |(what, ours, theirs)| format!("{file}: {what} {ours}, manifest {theirs}");
    pairs.into_iter().filter(differs).map(say).collect()
}

/// Instances are counted once in the manifest, and unfolded by us.
const INSTANCED: &str = "InstanceTest.glb";

#[test]
fn shared_meshes_have_the_topology_of_the_manifest() {
    let Some(root) = common::shared_folder() else {
        return;
    };
    let text = std::fs::read_to_string(root.join("MANIFEST.tsv")).expect("a manifest");
    let mut lines = text
        .lines()
        .map(|line| line.split('\t').collect::<Vec<_>>());
    let names = lines.next().expect("a header");
    let rows: Vec<Row<'_>> = lines
        .map(|cells| names.iter().copied().zip(cells).collect())
        .collect();
    let loads =
        |row: &&Row<'_>| row["expect"].starts_with("load (") && !row["file"].ends_with(INSTANCED);
    let wrong: Vec<String> = rows
        .iter()
        .filter(loads)
        .flat_map(|row| compare(&root, row))
        .collect();
    assert!(
        rows.iter().filter(loads).count() > 100,
        "the manifest has lost its meshes"
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
