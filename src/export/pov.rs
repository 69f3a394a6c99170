//! POV-Ray include files, which declare `Lichen`: spheres, instances of `Lobe`, or branches as
//! sphere sweeps that taper from the root, as P. Bourke renders aggregates.
//!
//! POV-Ray's axes are left-handed, y up: z is the negative of the mesh's. It takes what is nearer
//! than an absolute distance for the same, and draws nonsense for small sphere sweeps; so all is in
//! element radii from the first element, and put into its place by a matrix, which does not alter
//! the sweeps' own numbers as `scale` does.

use std::io::{self, Write};

use super::AgeColor;
use super::scene::Scene;

pub(super) fn write_points(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    begin(scene, "", out)?;
    for (i, share) in scene.influences().into_iter().enumerate() {
        let centre = place(scene, i);
        let pigment = pigment(scene, color, i);
        writeln!(out, "  sphere {{ <{centre}>, {share} {pigment} }}")?;
    }
    end(scene, out)
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
        let axis = |a: glam::DVec3| coordinates((q * a).to_array());
        let [x, y, z] = glam::DVec3::AXES.map(axis);
        let centre = place(scene, i);
        let pigment = pigment(scene, color, i);
        writeln!(
            out,
            "  object {{ Lobe matrix <{x}, {y}, {z}, {centre}> {pigment} }}"
        )?;
    }
    end(scene, out)
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
            let (place, width) = (place(scene, i as usize), scene.branch_radii[i as usize]);
            let width = f64::from(width) / scene.elements.radius;
            write!(out, ", <{place}>, {width:.4}")?;
        }
        let middle = stream[stream.len() / 2] as usize;
        writeln!(out, " {} }}", pigment(scene, color, middle))?;
    }
    end(scene, out)
}

/// Declares the lichen as a union of what follows; one element alone is a union too.
fn begin(scene: &Scene, before: &str, out: &mut dyn Write) -> io::Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    let elements = match scene.elements.len() {
        1 => "one element".to_owned(),
        many => format!("{many} elements"),
    };
    writeln!(
        out,
        "// thallus {version}: a lichen of {elements}, y up, left-handed"
    )?;
    writeln!(out, "// #include this file, then object {{ Lichen }}")?;
    write!(out, "#version 3.7;\n{before}#declare Lichen = union {{\n")
}

/// Puts the union into its place.
fn end(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let (r, [x, y, z]) = (scene.elements.radius, origin(scene));
    let z = 0.0 - z;
    writeln!(
        out,
        "  matrix <{r}, 0, 0, 0, {r}, 0, 0, 0, {r}, {x}, {y}, {z}>"
    )?;
    writeln!(out, "}}")
}

fn origin(scene: &Scene) -> [f64; 3] {
    scene
        .elements
        .positions
        .first()
        .copied()
        .unwrap_or_default()
}

/// A centre in radii from the origin.
fn place(scene: &Scene, i: usize) -> String {
    let (p, o) = (scene.elements.positions[i], origin(scene));
    coordinates([0, 1, 2].map(|k| (p[k] - o[k]) / scene.elements.radius))
}

fn coordinates([x, y, z]: [f64; 3]) -> String {
    let [x, y, z] = [x, y, 0.0 - z].map(|c| c as f32);
    format!("{x}, {y}, {z}")
}

fn pigment(scene: &Scene, color: AgeColor<'_>, i: usize) -> String {
    let [r, g, b] = color(scene.elements.age(i)).map(|byte| f32::from(byte) / 255.0);
    format!("pigment {{ srgb <{r:.4}, {g:.4}, {b:.4}> }}")
}
