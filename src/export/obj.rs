//! Wavefront OBJ: coloured vertices, loose or joined by lines, one a segment: MeshLab and Blender 3.4 read only the
//! first segment of a longer one. Loose ones have no `p` elements:
//! Blender reads vertices without, and complains of each.
//!
//! Colours after the coordinates are the common extension (sRGB, 0 to 1). OBJ has no place for
//! other attributes.

use std::io::{self, Write};

use super::AgeColor;
use super::scene::Scene;

pub(super) fn write_points(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    write_vertices(scene, color, out)?;
    for normal in &scene.elements.normals {
        let [x, y, z] = normal;
        writeln!(out, "vn {x} {y} {z}")?;
    }
    Ok(())
}

pub(super) fn write_curves(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    write_vertices(scene, color, out)?;
    for stream in &scene.streams {
        for link in stream.windows(2) {
            writeln!(out, "l {} {}", link[0] + 1, link[1] + 1)?;
        }
    }
    Ok(())
}

fn write_vertices(scene: &Scene, color: AgeColor<'_>, out: &mut dyn Write) -> io::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    writeln!(out, "# thallus {version}: lichen elements in birth order")?;
    writeln!(out, "o lichen")?;
    for (i, [x, y, z]) in scene.elements.positions.iter().enumerate() {
        let [r, g, b] = color(scene.elements.age(i)).map(|byte| f32::from(byte) / 255.0);
        writeln!(out, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}")?;
    }
    Ok(())
}
