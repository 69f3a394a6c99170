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

const REMARK: &str = "Part of Thallus. CC0 1.0: no rights reserved. y up.";

/// Makes the bytes of one file.
type Maker = fn() -> Result<Vec<u8>>;

/// Names and makers of the shipped files.
const FILES: [(&str, Maker); 5] = [
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
            std::fs::write(&path, &bytes)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        let done = if check { "unchanged" } else { "written" };
        writeln!(
            io::stdout(),
            "{}: {} bytes, {done}",
            path.display(),
            bytes.len()
        )?;
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
    ensure!(
        kept == bytes,
        "{} differs from what this program makes",
        path.display()
    );
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

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("meshes")
            .join(name)
    }

    #[test]
    fn the_shipped_files_are_what_this_program_makes() {
        for (name, make) in FILES {
            compare(&shipped(name), &make().unwrap()).unwrap();
        }
    }

    #[test]
    fn a_changed_or_missing_file_is_named() {
        let kept = shipped("plane.obj");
        let message = compare(&kept, b"other").unwrap_err().to_string();
        assert!(message.contains("plane.obj"), "{message}");
        let message = compare(&kept.with_extension("none"), b"")
            .unwrap_err()
            .to_string();
        assert!(message.contains("plane.none"), "{message}");
    }

    #[test]
    fn an_independent_reader_accepts_the_glb_files() {
        for (name, vertices, triangles, charts) in [
            ("boulder.glb", 41_334, 80_688, true),
            ("branch.glb", 29_090, 58_176, false),
        ] {
            let file = gltf::Gltf::open(shipped(name)).unwrap();
            let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
            let reader = primitive.reader(|_| file.blob.as_deref());
            assert_eq!(reader.read_positions().unwrap().len(), vertices);
            assert!(
                reader
                    .read_normals()
                    .unwrap()
                    .all(|n| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5)
            );
            let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            assert_eq!(indices.len(), 3 * triangles);
            assert_eq!(indices.iter().max(), Some(&(vertices as u32 - 1)));
            assert_eq!(reader.read_tex_coords(0).is_some(), charts);
        }
    }

    #[test]
    fn independent_readers_accept_the_obj_and_stl_files() {
        let (models, _) =
            tobj::load_obj(shipped("rock.obj"), &tobj::LoadOptions::default()).unwrap();
        assert_eq!(
            (models[0].mesh.positions.len(), models[0].mesh.indices.len()),
            (3 * 2306, 3 * 4608)
        );
        let mut file = std::fs::File::open(shipped("slab.stl")).unwrap();
        let slab = stl_io::read_stl(&mut file).unwrap();
        assert_eq!(slab.faces.len(), 16_896);
        slab.validate().unwrap();
    }
}
