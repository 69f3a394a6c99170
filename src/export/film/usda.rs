//! A film as USD in its text form: attributes with time samples (Pixar, *UsdGeom schemas*, *USD
//! Glossary: Time Sample*), a frame a time code. Topology and counts change from frame to
//! frame, which importers have to expect of a mesh whose `faceVertexIndices` vary.

use std::fmt::Display;
use std::io::{self, Write};

use super::{Spool, Spools};
use crate::color::to_linear;
use crate::export::mesh::usda;
use crate::export::usda::{Frames, NO_EXTENT, Number, Stage, Tuple, VERTEX, write_list};
use crate::export::{AgeColor, Scene, TriMesh, UpAxis, What};

/// A prim, its attributes so far, and where it lies.
#[derive(Debug)]
pub(super) struct Usda {
    spools: Spools,
    pub(super) first: u32,
    frames: u32,
    prim: Option<Prim>,
    pub(super) origin: Option<[f64; 3]>,
    tracks: Vec<Track>,
    /// Vertices of the frame before, as they were written, and its triangles.
    before: (usize, Vec<[u32; 3]>),
}

#[derive(Clone, Copy, Debug)]
struct Prim {
    schema: &'static str,
    name: &'static str,
    /// A line of what does not change.
    fixed: &'static str,
    up: UpAxis,
}

/// An attribute, `TYPE[] NAME`, and its values at each frame.
#[derive(Debug)]
struct Track {
    declared: String,
    interpolation: &'static str,
    samples: Spool,
}

impl Usda {
    pub(super) fn new(spools: Spools) -> Self {
        Self {
            spools,
            first: 1,
            frames: 0,
            prim: None,
            origin: None,
            tracks: Vec::new(),
            before: (0, Vec::new()),
        }
    }

    /// The vertices of a frame that are written: the last of them twice where there would be as many as in the frame
    /// before, but in other triangles.
    ///
    /// Between frames programs interpolate arrays of one length, though vertices have nothing to do with those before,
    /// and hold others (Pixar, *USD Glossary: Value Interpolation*).
    fn vertices(&mut self, mesh: &TriMesh) -> Vec<usize> {
        let mut all: Vec<usize> = (0..mesh.positions.len()).collect();
        if all.len() == self.before.0 && mesh.triangles != self.before.1 {
            all.extend(all.last().copied());
        }
        self.before = (all.len(), mesh.triangles.clone());
        all
    }

    pub(super) fn add_skin(&mut self, mesh: &TriMesh) -> io::Result<()> {
        self.frames += 1;
        self.prim = Some(Prim {
            schema: "Mesh",
            name: "skin",
            fixed: "uniform token subdivisionScheme = \"none\"",
            up: mesh.up,
        });
        // A mesh without vertices lies nowhere yet.
        if self.origin.is_none() && !mesh.positions.is_empty() {
            self.origin = Some(mesh.origin());
        }
        let origin = self.origin.unwrap_or_default();
        let local = |p: [f64; 3]| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32);
        let vertices = self.vertices(mesh);
        let vertices = || vertices.iter().copied();
        let counts = mesh.triangles.iter().map(|_| 3);
        self.sample("int[] faceVertexCounts", "", counts)?;
        let corners = mesh.triangles.as_flattened().iter();
        self.sample("int[] faceVertexIndices", "", corners)?;
        let extent = usda::extent(mesh, origin).map(Tuple);
        self.sample("float3[] extent", "", extent.into_iter())?;
        let points = vertices().map(|v| Tuple(local(mesh.positions[v])));
        self.sample("point3f[] points", "", points)?;
        let normals = vertices().map(|v| Tuple(mesh.normals[v]));
        self.sample("normal3f[] normals", VERTEX, normals)?;
        let colors = vertices().map(|v| Tuple(mesh.colors[v].map(to_linear)));
        self.sample("color3f[] primvars:displayColor", VERTEX, colors)?;
        for attribute in &mesh.attributes {
            let declared = format!("float[] primvars:{}", attribute.name);
            let values = vertices().map(|v| Number(attribute.values[v]));
            self.sample(&declared, VERTEX, values)?;
        }
        Ok(())
    }

    pub(super) fn add_scene(
        &mut self,
        what: What,
        scene: &Scene,
        color: AgeColor<'_>,
    ) -> io::Result<()> {
        self.frames += 1;
        let elements = &scene.elements;
        let origin = *self.origin.get_or_insert_with(|| scene.origin());
        let curves = what == What::Curves;
        self.prim = Some(Prim {
            schema: if curves { "BasisCurves" } else { "Points" },
            name: if curves { "branches" } else { "elements" },
            fixed: if curves {
                "uniform token type = \"linear\""
            } else {
                ""
            },
            up: scene.up,
        });
        let of: Vec<usize> = match curves {
            true => scene
                .streams
                .iter()
                .flatten()
                .map(|&i| i as usize)
                .collect(),
            false => (0..elements.len()).collect(),
        };
        let local = |i: &usize| {
            let p = elements.positions[*i];
            [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)
        };
        let influence = scene.influences();
        let diameter = |i: usize| match curves {
            true => 2.0 * scene.branch_radii[i],
            false => (2.0 * elements.radius) as f32 * influence[i],
        };
        if curves {
            let counts = scene.streams.iter().map(Vec::len);
            self.sample("int[] curveVertexCounts", "", counts)?;
        } else {
            self.sample("int64[] ids", "", of.iter())?;
        }
        self.sample("point3f[] points", "", of.iter().map(|i| Tuple(local(i))))?;
        let extent = extent(of.iter().map(local), of.iter().map(|&i| 0.5 * diameter(i)));
        self.sample("float3[] extent", "", extent.into_iter().map(Tuple))?;
        let widths = of.iter().map(|&i| Number(diameter(i)));
        self.sample("float[] widths", VERTEX, widths)?;
        let radii = of.iter().map(|&i| Number(0.5 * diameter(i)));
        self.sample("float[] primvars:pscale", VERTEX, radii)?;
        self.primvars(scene, color, &of, &influence)
    }

    fn primvars(
        &mut self,
        scene: &Scene,
        color: AgeColor<'_>,
        of: &[usize],
        influence: &[f32],
    ) -> io::Result<()> {
        let elements = &scene.elements;
        let colors = of
            .iter()
            .map(|&i| Tuple(color(elements.age(i)).map(to_linear)));
        self.sample("color3f[] primvars:displayColor", VERTEX, colors)?;
        let normals = of.iter().map(|&i| Tuple(elements.normals[i]));
        self.sample("normal3f[] primvars:N", VERTEX, normals)?;
        let orient = of.iter().map(|&i| {
            let [x, y, z, w] = scene.orientations[i];
            Tuple([w, x, y, z])
        });
        self.sample("quatf[] primvars:orient", VERTEX, orient)?;
        self.sample("int[] primvars:birth", VERTEX, of.iter())?;
        let colonies = of.iter().map(|&i| elements.colony[i]);
        self.sample("int[] primvars:colony", VERTEX, colonies)?;
        if let Some(nage) = scene.floats("nage") {
            let nage = of.iter().map(|&i| Number(nage[i]));
            self.sample("float[] primvars:nage", VERTEX, nage)?;
        }
        let influences = of.iter().map(|&i| Number(influence[i]));
        self.sample("float[] primvars:influence", VERTEX, influences)
    }

    /// Values of the frame that is being added.
    fn sample(
        &mut self,
        declared: &str,
        interpolation: &'static str,
        values: impl Iterator<Item = impl Display>,
    ) -> io::Result<()> {
        let known = self.tracks.iter().position(|t| t.declared == declared);
        let track = match known {
            Some(track) => track,
            None => {
                self.tracks.push(Track {
                    declared: declared.to_owned(),
                    interpolation,
                    samples: self.spools.make()?,
                });
                self.tracks.len() - 1
            }
        };
        let out = &mut self.tracks[track].samples.0;
        let number = u64::from(self.first) + u64::from(self.frames) - 1;
        write!(out, "            {number}: ")?;
        write_list(out, values)?;
        writeln!(out, ",")
    }

    pub(super) fn write(self, fps: f64, meters: f64, out: &mut dyn Write) -> io::Result<()> {
        let Some(prim) = self.prim else {
            let problem = "a film has at least one frame";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        };
        let frames = Frames {
            first: self.first.into(),
            last: u64::from(self.first) + u64::from(self.frames) - 1,
            fps,
        };
        let origin = self.origin.unwrap_or_default();
        let mut stage = Stage::begin_film(prim.up, meters, origin, Some(frames), out)?;
        match prim.schema {
            "Mesh" => stage.open_skin(prim.name)?,
            schema => stage.open(schema, prim.name)?,
        }
        if !prim.fixed.is_empty() {
            stage.line(prim.fixed)?;
        }
        for track in self.tracks {
            stage.samples(&track.declared, track.interpolation, |out| {
                track.samples.pour(out)
            })?;
        }
        stage.close()?;
        stage.close()
    }
}

/// The box about spheres.
fn extent(
    points: impl Iterator<Item = [f32; 3]>,
    radii: impl Iterator<Item = f32>,
) -> [[f32; 3]; 2] {
    let grow = |[low, high]: [[f32; 3]; 2], (p, r): ([f32; 3], f32)| {
        let low = [0, 1, 2].map(|k| low[k].min(p[k] - r));
        [low, [0, 1, 2].map(|k| high[k].max(p[k] + r))]
    };
    points.zip(radii).fold(NO_EXTENT, grow)
}
