//! USD in its text form: `Points`, `PointInstancer`, `BasisCurves` (Pixar, *UsdGeom schemas*).
//!
//! Lengths called `widths` are diameters. Attributes are primvars of the elements, names as
//! elsewhere; `primvars:N` and `primvars:pscale` repeat normals and half the widths for programs that read
//! those: Houdini makes the width of curves from `pscale`. Colours are linear, as `displayColor` is.

use std::fmt::Display;
use std::io::{self, Write};

use super::AgeColor;
use super::columns::{Column, Kind, Scalar, columns};
use super::lobe::Lobe;
use super::scene::{Scene, range};
use crate::color::to_linear;
use crate::substrate::UpAxis;

pub(super) fn write_points(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut stage = Stage::of(scene, out)?;
    let every: Vec<usize> = (0..scene.elements.len()).collect();
    stage.open("Points", "elements")?;
    stage.int64s("ids", &every)?;
    stage.points("points", scene, &every)?;
    stage.extent(scene, 1.0)?;
    let normals = &scene.elements.normals;
    stage.vectors(
        "normal3f[] normals",
        VERTEX,
        every.iter().map(|&i| normals[i]),
    )?;
    let radii = scene.shown_radii();
    let widths = radii.iter().map(|radius| 2.0 * radius);
    stage.numbers("float[] widths", VERTEX, widths)?;
    stage.primvars(scene, color, &every, &radii)?;
    stage.close()?;
    stage.close()
}

pub(super) fn write_instances(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut stage = Stage::of(scene, out)?;
    let every: Vec<usize> = (0..scene.elements.len()).collect();
    let radius = scene.elements.radius as f32;
    let radii = vec![radius; every.len()];
    stage.open("PointInstancer", "lobes")?;
    stage.int64s("ids", &every)?;
    stage.points("positions", scene, &every)?;
    stage.extent(scene, 2.0)?;
    let halves = scene.orientations.iter().map(|&[x, y, z, w]| {
        let [w, x, y, z] = [w, x, y, z].map(|c| format!("{c:.5}"));
        format!("({w}, {x}, {y}, {z})")
    });
    stage.list("quath[] orientations", "", halves)?;
    stage.vectors("float3[] scales", "", every.iter().map(|_| [radius; 3]))?;
    stage.list("int[] protoIndices", "", every.iter().map(|_| 0))?;
    stage.line("rel prototypes = </lichen/lobes/prototypes/lobe>")?;
    stage.primvars(scene, color, &every, &radii)?;
    stage.open("Scope", "prototypes")?;
    stage.lobe()?;
    stage.close()?;
    stage.close()?;
    stage.close()
}

pub(super) fn write_curves(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut stage = Stage::of(scene, out)?;
    let vertices: Vec<usize> = scene
        .streams
        .iter()
        .flatten()
        .map(|&i| i as usize)
        .collect();
    stage.open("BasisCurves", "branches")?;
    stage.line("uniform token type = \"linear\"")?;
    let counts = scene.streams.iter().map(Vec::len);
    stage.list("int[] curveVertexCounts", "", counts)?;
    stage.points("points", scene, &vertices)?;
    stage.extent(scene, 1.0)?;
    let widths = vertices.iter().map(|&i| 2.0 * scene.branch_radii[i]);
    stage.numbers("float[] widths", VERTEX, widths)?;
    stage.primvars(scene, color, &vertices, &scene.branch_radii)?;
    stage.close()?;
    stage.close()
}

/// A time code each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    pub(super) first: u64,
    pub(super) last: u64,
    /// Time codes per second.
    pub(super) fps: f64,
}

/// One value a point.
pub(super) const VERTEX: &str = "vertex";

/// The box about nothing, as USD has it: upside down, so that it adds nothing to others.
pub(super) const NO_EXTENT: [[f32; 3]; 2] = [[f32::MAX; 3], [f32::MIN; 3]];

/// A stage that is being written, with its prims open so far.
pub(super) struct Stage<'a> {
    out: &'a mut dyn Write,
    depth: usize,
}

impl<'a> Stage<'a> {
    fn of(scene: &Scene, out: &'a mut dyn Write) -> io::Result<Self> {
        Self::begin(scene.up, scene.meters_per_unit, scene.origin(), out)
    }

    /// The layer's metadata, and the root prim, moved by a vector, which stays open.
    pub(super) fn begin(
        up: UpAxis,
        meters_per_unit: f64,
        origin: [f64; 3],
        out: &'a mut dyn Write,
    ) -> io::Result<Self> {
        Self::begin_film(up, meters_per_unit, origin, None, out)
    }

    /// The same of a layer with time samples.
    pub(super) fn begin_film(
        up: UpAxis,
        meters_per_unit: f64,
        [x, y, z]: [f64; 3],
        frames: Option<Frames>,
        out: &'a mut dyn Write,
    ) -> io::Result<Self> {
        let up = match up {
            UpAxis::Y => "Y",
            UpAxis::Z => "Z",
        };
        let version = env!("CARGO_PKG_VERSION");
        writeln!(out, "#usda 1.0\n(")?;
        writeln!(out, "    defaultPrim = \"lichen\"")?;
        writeln!(out, "    doc = \"Lichen grown by thallus {version}\"")?;
        if let Some(Frames { last, fps, .. }) = frames {
            writeln!(out, "    endTimeCode = {last}\n    framesPerSecond = {fps}")?;
        }
        writeln!(out, "    metersPerUnit = {meters_per_unit}")?;
        if let Some(Frames { first, fps, .. }) = frames {
            writeln!(
                out,
                "    startTimeCode = {first}\n    timeCodesPerSecond = {fps}"
            )?;
        }
        writeln!(out, "    upAxis = \"{up}\"\n)\n")?;
        let mut stage = Self { out, depth: 0 };
        stage.line("def Xform \"lichen\" (")?;
        stage.line("    kind = \"component\"\n)\n{")?;
        stage.depth = 1;
        if [x, y, z] != [0.0; 3] {
            stage.line(&format!("double3 xformOp:translate = ({x}, {y}, {z})"))?;
            stage.line("uniform token[] xformOpOrder = [\"xformOp:translate\"]")?;
        }
        Ok(stage)
    }

    /// Opens a mesh with a material that reads its colours: many programs show `displayColor` only where one does
    /// (Pixar, *UsdPreviewSurface Specification*).
    pub(super) fn open_skin(&mut self, name: &str) -> io::Result<()> {
        self.material()?;
        self.line(&format!("def Mesh \"{name}\" ("))?;
        self.line("    prepend apiSchemas = [\"MaterialBindingAPI\"]")?;
        self.line(")")?;
        self.begin_block()?;
        self.line("rel material:binding = </lichen/lichen>")
    }

    fn material(&mut self) -> io::Result<()> {
        self.open("Material", "lichen")?;
        self.line("token outputs:surface.connect = </lichen/lichen/surface.outputs:surface>")?;
        self.open("Shader", "surface")?;
        self.line("uniform token info:id = \"UsdPreviewSurface\"")?;
        self.line("color3f inputs:diffuseColor.connect = </lichen/lichen/color.outputs:result>")?;
        self.line("float inputs:roughness = 0.9")?;
        self.line("token outputs:surface")?;
        self.close()?;
        self.open("Shader", "color")?;
        self.line("uniform token info:id = \"UsdPrimvarReader_float3\"")?;
        self.line("string inputs:varname = \"displayColor\"")?;
        self.line("float3 outputs:result")?;
        self.close()?;
        self.close()
    }

    fn indent(&mut self) -> io::Result<()> {
        write!(self.out, "{:1$}", "", 4 * self.depth)
    }

    pub(super) fn line(&mut self, text: &str) -> io::Result<()> {
        self.indent()?;
        writeln!(self.out, "{text}")
    }

    pub(super) fn open(&mut self, schema: &str, name: &str) -> io::Result<()> {
        self.line(&format!("def {schema} \"{name}\""))?;
        self.begin_block()
    }

    fn begin_block(&mut self) -> io::Result<()> {
        self.line("{")?;
        self.depth += 1;
        Ok(())
    }

    pub(super) fn close(&mut self) -> io::Result<()> {
        self.depth -= 1;
        self.line("}")
    }

    /// An attribute, `TYPE[] NAME`, of values that are written as they are shown.
    pub(super) fn list(
        &mut self,
        declared: &str,
        interpolation: &str,
        values: impl Iterator<Item = impl Display>,
    ) -> io::Result<()> {
        self.indent()?;
        write!(self.out, "{declared} = ")?;
        write_list(self.out, values)?;
        match interpolation {
            "" => writeln!(self.out),
            how => writeln!(self.out, " (interpolation = \"{how}\")"),
        }
    }

    /// An attribute that changes, with time samples that `fill` writes.
    pub(super) fn samples(
        &mut self,
        declared: &str,
        interpolation: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        if !interpolation.is_empty() {
            let how = format!("{declared} (interpolation = \"{interpolation}\")");
            self.line(&how)?;
        }
        self.line(&format!("{declared}.timeSamples = {{"))?;
        fill(self.out)?;
        self.line("}")
    }

    pub(super) fn numbers(
        &mut self,
        declared: &str,
        interpolation: &str,
        values: impl Iterator<Item = f32>,
    ) -> io::Result<()> {
        self.list(declared, interpolation, values.map(Number))
    }

    pub(super) fn vectors<const N: usize>(
        &mut self,
        declared: &str,
        interpolation: &str,
        values: impl Iterator<Item = [f32; N]>,
    ) -> io::Result<()> {
        self.list(declared, interpolation, values.map(Tuple))
    }

    fn int64s(&mut self, name: &str, values: &[usize]) -> io::Result<()> {
        self.list(&format!("int64[] {name}"), "", values.iter())
    }

    fn points(&mut self, name: &str, scene: &Scene, of: &[usize]) -> io::Result<()> {
        let positions = scene.local_positions();
        let points = of.iter().map(|&i| positions[i]);
        self.vectors(&format!("point3f[] {name}"), "", points)
    }

    /// The box about all elements, wider by some radii.
    fn extent(&mut self, scene: &Scene, radii: f64) -> io::Result<()> {
        let positions = scene.local_positions();
        let margin = radii * scene.elements.radius;
        let axis = |k: usize| range(positions.iter().map(|p| f64::from(p[k])));
        let [x, y, z] = [0, 1, 2].map(axis);
        let low = [x[0], y[0], z[0]].map(|c| (c - margin) as f32);
        let high = [x[1], y[1], z[1]].map(|c| (c + margin) as f32);
        self.vectors("float3[] extent", "", [low, high].into_iter())
    }

    /// Colours and every attribute of these elements, which are shown with radii of their own.
    fn primvars(
        &mut self,
        scene: &Scene,
        color: AgeColor<'_>,
        of: &[usize],
        radii: &[f32],
    ) -> io::Result<()> {
        let elements = &scene.elements;
        let colors = of.iter().map(|&i| color(elements.age(i)).map(to_linear));
        self.vectors("color3f[] primvars:displayColor", VERTEX, colors)?;
        let normals = of.iter().map(|&i| elements.normals[i]);
        self.vectors("normal3f[] primvars:N", VERTEX, normals)?;
        let orient = of.iter().map(|&i| scene.orientations[i]);
        let orient = orient.map(|[x, y, z, w]| [w, x, y, z]);
        self.vectors("quatf[] primvars:orient", VERTEX, orient)?;
        let scales = of.iter().map(|&i| radii[i]);
        self.numbers("float[] primvars:pscale", VERTEX, scales)?;
        let columns = columns(elements);
        columns
            .iter()
            .filter(|c| is_own(&c.name))
            .try_for_each(|c| self.primvar(c, of))
    }

    fn primvar(&mut self, column: &Column<'_>, of: &[usize]) -> io::Result<()> {
        let kind = match column.kind {
            Kind::I32 => "int",
            Kind::F32 | Kind::F64 => "float",
        };
        let declared = format!("{kind}[] primvars:{}", column.name);
        self.list(&declared, VERTEX, of.iter().map(|&i| Value(column.at(i))))
    }

    /// The prototype.
    fn lobe(&mut self) -> io::Result<()> {
        let lobe = Lobe::new();
        self.open("Mesh", "lobe")?;
        let extent = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| {
                lobe.positions
                    .iter()
                    .map(|p| p[k])
                    .fold(lobe.positions[0][k], pick)
            })
        };
        let corners = [extent(f32::min), extent(f32::max)];
        self.vectors("float3[] extent", "", corners.into_iter())?;
        let sides = lobe.triangles.iter().map(|_| 3);
        self.list("int[] faceVertexCounts", "", sides)?;
        self.list(
            "int[] faceVertexIndices",
            "",
            lobe.triangles.iter().flatten(),
        )?;
        self.vectors("normal3f[] normals", VERTEX, lobe.normals.iter().copied())?;
        self.vectors("point3f[] points", "", lobe.positions.iter().copied())?;
        self.line("uniform token subdivisionScheme = \"none\"")?;
        self.close()
    }
}

/// Values as they are shown, in brackets.
pub(super) fn write_list(
    out: &mut dyn Write,
    values: impl Iterator<Item = impl Display>,
) -> io::Result<()> {
    write!(out, "[")?;
    for (i, value) in values.enumerate() {
        let comma = if i == 0 { "" } else { ", " };
        write!(out, "{comma}{value}")?;
    }
    write!(out, "]")
}

/// Whether a column is a primvar of its own, and not part of another attribute.
fn is_own(name: &str) -> bool {
    const PARTS: [&str; 7] = ["x", "y", "z", "nx", "ny", "nz", "radius"];
    !PARTS.contains(&name) && !name.starts_with("orient_")
}

/// The shortest text that reads back to the same float32.
pub(super) struct Number(pub(super) f32);

impl Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            x if x != 0.0 && !(1e-5..1e9).contains(&x.abs()) => write!(f, "{x:e}"),
            x => write!(f, "{x}"),
        }
    }
}

/// A value of a column: a whole number, or any as float32.
struct Value(Scalar);

impl Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Scalar::I32(x) => write!(f, "{x}"),
            other => Number(other.single()).fmt(f),
        }
    }
}

/// A vector.
pub(super) struct Tuple<const N: usize>(pub(super) [f32; N]);

impl<const N: usize> Display for Tuple<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, &x) in self.0.iter().enumerate() {
            let before = if i == 0 { "(" } else { ", " };
            write!(f, "{before}{}", Number(x))?;
        }
        write!(f, ")")
    }
}
