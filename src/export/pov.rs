//! POV-Ray include files, which declare `Lichen`: spheres, instances of `Lobe`, or branches as
//! sphere sweeps that taper from the root, as P. Bourke renders aggregates.
//!
//! POV-Ray's axes are left-handed, y up: z is the negative of the mesh's.

use std::io::{self, Write};

use super::AgeColor;
use super::scene::Scene;

pub(super) fn write_points(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    begin(scene, "", out)?;
    let radius = scene.elements.radius;
    for i in 0..scene.elements.len() {
        let centre = point(scene.elements.positions[i]);
        let pigment = pigment(scene, color, i);
        writeln!(out, "  sphere {{ {centre}, {radius} {pigment} }}")?;
    }
    writeln!(out, "}}")
}

const LOBE: &str = "\
// Your own: declare Lobe before including this file. It lies in the xy plane, its top up z, its tip
// along y, about one unit in radius.
#ifndef (Lobe)
  #declare Lobe = intersection {
    sphere { <0, 0, 0>, 1 scale <1.15, 1.35, 0.38> }
    plane { -z, 0 }
  }
#end
";

pub(super) fn write_instances(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    begin(scene, LOBE, out)?;
    for (i, &q) in scene.orientations.iter().enumerate() {
        let q = glam::DQuat::from_array(q.map(f64::from));
        let axis = |a: glam::DVec3| coordinates((q * a * scene.elements.radius).to_array());
        let [x, y, z] = glam::DVec3::AXES.map(axis);
        let centre = coordinates(scene.elements.positions[i]);
        let pigment = pigment(scene, color, i);
        writeln!(
            out,
            "  object {{ Lobe matrix <{x}, {y}, {z}, {centre}> {pigment} }}"
        )?;
    }
    writeln!(out, "}}")
}

pub(super) fn write_curves(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    begin(scene, "", out)?;
    for stream in &scene.streams {
        write!(out, "  sphere_sweep {{ linear_spline {}", stream.len())?;
        for &i in stream {
            let place = point(scene.elements.positions[i as usize]);
            write!(out, ", {place}, {}", scene.branch_radii[i as usize])?;
        }
        let middle = stream[stream.len() / 2] as usize;
        writeln!(out, " {} }}", pigment(scene, color, middle))?;
    }
    writeln!(out, "}}")
}

/// Declares the lichen as a union of what follows; one element alone is a union too.
fn begin(scene: &Scene, before: &str, out: &mut dyn Write) -> io::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    let elements = scene.elements.len();
    writeln!(
        out,
        "// thallus {version}: a lichen of {elements} elements, y up, left-handed"
    )?;
    writeln!(out, "// #include this file, then object {{ Lichen }}")?;
    write!(out, "#version 3.7;\n{before}#declare Lichen = union {{\n")
}

fn point(p: [f64; 3]) -> String {
    format!("<{}>", coordinates(p))
}

fn coordinates([x, y, z]: [f64; 3]) -> String {
    let z = 0.0 - z;
    format!("{x}, {y}, {z}")
}

fn pigment(scene: &Scene, color: AgeColor<'_>, i: usize) -> String {
    let [r, g, b] = color(scene.elements.age(i)).map(|byte| f32::from(byte) / 255.0);
    format!("pigment {{ srgb <{r:.4}, {g:.4}, {b:.4}> }}")
}
