//! Makes the meshes in `meshes/`, the same bytes on every machine.
//!
//!     cargo run --release --example make_meshes -- meshes            writes them
//!     cargo run --release --example make_meshes -- --check meshes    fails if a file there would differ
//!
//! Only + − × ÷ √ and the `libm` crate decide a coordinate, and the noise is an integer hash, so that the bytes don't
//! depend on the platform's mathematics library. Every mesh is audited before it is written: closed, in one piece, an
//! oriented 2-manifold without degenerate triangles, on the coordinates as they stand in the file.

mod audit;
mod boulder;
mod branch;
mod crossings;
mod formats;
mod limb;
mod nets;
mod noise;
mod plates;
mod rock;
mod stone;
mod surface;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use crate::audit::audit;
use crate::formats::{Glb, glb, obj, obj_coordinate, single_coordinate, stl};
use crate::surface::Surface;

const REMARK: &str = "Part of Thallus. CC0 1.0: no rights reserved. Metres, y up.";
/// Names and makers of the shipped files.
const FILES: [(&str, fn() -> Result<Vec<u8>>); 5] = [
    ("rock.obj", rock_obj),
    ("boulder.glb", boulder_glb),
    ("branch.glb", branch_glb),
    ("slab.stl", slab_stl),
    ("plane.obj", plane_obj),
];

fn main() -> Result<()> {
    let (check, folder) = arguments()?;
    for (name, make) in FILES {
        let bytes = make().with_context(|| format!("{name} is unfit to ship"))?;
        let path = folder.join(name);
        if check {
            compare(&path, &bytes)?;
        } else {
            std::fs::write(&path, &bytes).with_context(|| format!("cannot write {}", path.display()))?;
        }
        let done = if check { "unchanged" } else { "written" };
        writeln!(io::stdout(), "{}: {} bytes, {done}", path.display(), bytes.len())?;
    }
    Ok(())
}

fn arguments() -> Result<(bool, PathBuf)> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--check", folder] => Ok((true, folder.into())),
        [folder] if !folder.starts_with('-') => Ok((false, folder.into())),
        _ => bail!("usage: make_meshes [--check] FOLDER"),
    }
}

fn compare(path: &Path, bytes: &[u8]) -> Result<()> {
    let kept = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    ensure!(kept == bytes, "{} differs from what this program makes", path.display());
    Ok(())
}

/// Rounds to the file's coordinates, then insists on a closed body of one piece without handles.
fn sealed(surface: &mut Surface, coordinate: fn(f64) -> f64) -> Result<()> {
    surface.round(coordinate);
    let found = audit(surface)?;
    ensure!(found.is_closed_body(), "not one closed body: {found:?}");
    Ok(())
}

fn rock_obj() -> Result<Vec<u8>> {
    let mut rock = rock::rock()?;
    sealed(&mut rock, obj_coordinate)?;
    Ok(obj(&rock, "rock", REMARK))
}

fn boulder_glb() -> Result<Vec<u8>> {
    let mut boulder = boulder::boulder()?;
    sealed(&mut boulder.surface, single_coordinate)?;
    Ok(glb(&Glb {
        name: "boulder",
        remark: REMARK,
        surface: &boulder.surface,
        normals: &boulder.normals,
        uv: Some(&boulder.uv),
        colour: [0.42, 0.40, 0.38],
    }))
}

fn branch_glb() -> Result<Vec<u8>> {
    let mut branch = branch::branch()?;
    let normals = branch.normals();
    sealed(&mut branch, single_coordinate)?;
    Ok(glb(&Glb {
        name: "branch",
        remark: REMARK,
        surface: &branch,
        normals: &normals,
        uv: None,
        colour: [0.23, 0.17, 0.12],
    }))
}

fn slab_stl() -> Result<Vec<u8>> {
    let mut slab = plates::slab();
    sealed(&mut slab, single_coordinate)?;
    Ok(stl(&slab, REMARK))
}

fn plane_obj() -> Result<Vec<u8>> {
    let plane = plates::plane();
    audit(&plane)?;
    Ok(obj(&plane, "plane", REMARK))
}
