//! A mesh as Wavefront OBJ: vertices with colours behind their coordinates, as most programs read
//! them, normals and triangles. OBJ has no place for other attributes.

use std::io::{self, Write};

use super::TriMesh;

pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let wide = mesh.needs_doubles();
    let version = env!("CARGO_PKG_VERSION");
    writeln!(
        out,
        "# thallus {version}: skin of a lichen\no {}",
        mesh.object()
    )?;
    for (place, color) in mesh.positions.iter().zip(&mesh.colors) {
        match (wide, place, place.map(|x| x as f32)) {
            (true, [x, y, z], _) => write!(out, "v {x} {y} {z}")?,
            (false, _, [x, y, z]) => write!(out, "v {x} {y} {z}")?,
        }
        let [r, g, b] = color.map(|byte| f32::from(byte) / 255.0);
        writeln!(out, " {r:.4} {g:.4} {b:.4}")?;
    }
    for [x, y, z] in &mesh.normals {
        writeln!(out, "vn {x:.4} {y:.4} {z:.4}")?;
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| v + 1);
        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    Ok(())
}
