//! A film as USD in its text form: attributes with time samples (Pixar, *UsdGeom schemas*, *USD
//! Glossary: Time Sample*), a frame a time code, from 1 on. Topology and counts change from frame to
//! frame, which importers have to expect of a mesh whose `faceVertexIndices` vary.

use std::fmt::Display;
use std::io::{self, Write};

use super::{Spool, Spools};
use crate::color::to_linear;
use crate::export::usda::{Frames, Number, Stage, Tuple, VERTEX, write_list};
use crate::export::{AgeColor, Scene, TriMesh, UpAxis, What};

/// A prim, its attributes so far, and where it lies.
#[derive(Debug)]
pub(super) struct Usda {
    spools: Spools,
    frames: u32,
    prim: Option<Prim>,
    pub(super) origin: Option<[f64; 3]>,
    tracks: Vec<Track>,
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
            frames: 0,
            prim: None,
            origin: None,
            tracks: Vec::new(),
        }
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
        let local = |p: &[f64; 3]| Tuple([0, 1, 2].map(|k| (p[k] - origin[k]) as f32));
        let counts = mesh.triangles.iter().map(|_| 3);
        self.sample("int[] faceVertexCounts", "", counts)?;
        let corners = mesh.triangles.as_flattened().iter();
        self.sample("int[] faceVertexIndices", "", corners)?;
        // A box about nothing lies where the film does, not at the far origin of its file.
        let extent = match mesh.positions.is_empty() {
            true => [origin; 2],
            false => mesh.bounds(),
        };
        self.sample("float3[] extent", "", extent.iter().map(local))?;
        self.sample("point3f[] points", "", mesh.positions.iter().map(local))?;
        let normals = mesh.normals.iter().map(|n| Tuple(*n));
        self.sample("normal3f[] normals", VERTEX, normals)?;
        let linear = |c: &[u8; 3]| Tuple(c.map(to_linear));
        let colors = mesh.colors.iter().map(linear);
        self.sample("color3f[] primvars:displayColor", VERTEX, colors)?;
        for attribute in &mesh.attributes {
            let declared = format!("float[] primvars:{}", attribute.name);
            let values = attribute.values.iter().map(|x| Number(*x));
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
        write!(out, "            {}: ", self.frames)?;
        write_list(out, values)?;
        writeln!(out, ",")
    }

    pub(super) fn write(self, fps: f64, meters: f64, out: &mut dyn Write) -> io::Result<()> {
        let Some(prim) = self.prim else {
            let problem = "a film has at least one frame";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        };
        let frames = Frames {
            last: self.frames,
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

/// The box about spheres; of none, that of the origin.
fn extent(
    points: impl Iterator<Item = [f32; 3]>,
    radii: impl Iterator<Item = f32>,
) -> Vec<[f32; 3]> {
    let grow = |[low, high]: [[f32; 3]; 2], (p, r): ([f32; 3], f32)| {
        let low = [0, 1, 2].map(|k| low[k].min(p[k] - r));
        [low, [0, 1, 2].map(|k| high[k].max(p[k] + r))]
    };
    let empty = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    match points.zip(radii).fold(empty, grow) {
        nothing if nothing == empty => vec![[0.0; 3]; 2],
        found => found.to_vec(),
    }
}
