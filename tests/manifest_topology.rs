//! Every shared mesh that should load has the topology that its manifest states.
//!
//! The manifest welds vertices that are equal as f32, as we do (noise near 0, which we weld too,
//! makes no difference to any of these meshes), but counts unused ones too. Its
//! pieces are joined at shared vertices (its README says edges; its numbers say vertices), ours at
//! shared edges, because no walker can cross a vertex: so pieces are counted its way here. Where we
//! drop degenerate or duplicate triangles the edges about them change, and there only the numbers
//! of triangles are held against it.

mod common;

use std::collections::HashMap;
use std::path::Path;

use thallus::substrate::{Substrate, SubstrateReport};

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
    // Those that hold others together are not dropped but become parts of these, and others are divided.
    let divided = report.repairs.iter().any(|r| r.contains("on whose edges"));
    let kept = match divided && report.triangles + dropped > report.triangles_read {
        true => sources(&substrate),
        false => report.triangles,
    };
    let mut pairs = vec![(
        "triangles kept and dropped",
        kept + dropped,
        number(row, "triangles"),
    )];
    if dropped == 0 {
        pairs.extend([
            (
                "vertices",
                report.vertices,
                number(row, "welded_vertices").min(report.vertices),
            ),
            (
                "components",
                pieces_by_vertex(&substrate),
                number(row, "components"),
            ),
            (
                "boundary edges",
                report.boundary_edges + joined_by_rounding(report),
                number(row, "boundary_edges"),
            ),
            (
                "non-manifold edges",
                report.non_manifold_edges,
                number(row, "nonmanifold_edges"),
            ),
            (
                "winding conflicts",
                report.winding_conflicts,
                number(row, "winding_conflicts"),
            ),
        ]);
    }
    let expected = number(row, "degenerate_tris") + number(row, "duplicate_tris");
    if (dropped == 0) != (expected == 0) && !divided {
        pairs.push(("degenerate and duplicate triangles", dropped, expected));
    }
    let differs = |(_, ours, theirs): &(&str, usize, usize)| ours != theirs;
    let say = |(what, ours, theirs)| format!("{file}: {what} {ours}, manifest {theirs}");
    pairs.into_iter().filter(differs).map(say).collect()
}

/// Open edges that the manifest, which welds what is equal as f32, counts, and that we close.
fn joined_by_rounding(report: &SubstrateReport) -> usize {
    let note = report
        .repairs
        .iter()
        .find(|r| r.contains("a rounding error away"));
    let number = note.and_then(|note| note.split(' ').next()?.parse().ok());
    number.unwrap_or(0)
}

/// Triangles of the file that are there, be it in parts.
fn sources(substrate: &Substrate) -> usize {
    let triangles = 0..substrate.triangles().len() as u32;
    let all: std::collections::HashSet<u32> =
        triangles.map(|t| substrate.source_triangle(t)).collect();
    all.len()
}

/// Pieces joined at shared vertices.
fn pieces_by_vertex(substrate: &Substrate) -> usize {
    let mut parent: Vec<usize> = (0..substrate.vertices().len()).collect();
    fn root(parent: &mut [usize], mut v: usize) -> usize {
        while parent[v] != v {
            parent[v] = parent[parent[v]];
            v = parent[v];
        }
        v
    }
    for t in substrate.triangles() {
        for k in 0..2 {
            let (a, b) = (
                root(&mut parent, t[k] as usize),
                root(&mut parent, t[k + 1] as usize),
            );
            parent[a] = b;
        }
    }
    (0..parent.len()).filter(|&v| parent[v] == v).count()
}

/// Concave polygons are fans in the manifest, which fold over themselves; ours do not.
const CONCAVE: &str = "concave_polygon.obj";

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
    let loads = |row: &&Row<'_>| {
        row["expect"].starts_with("load (")
            && ![INSTANCED, CONCAVE]
                .iter()
                .any(|f| row["file"].ends_with(f))
    };
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
