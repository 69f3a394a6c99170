//! The formats that a scene is written in, and what each can hold.

use std::fmt;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::scene::Scene;
use super::{AgeColor, gltf, obj, ply, pov, usda};
use super::{
    CSV, ElementFormat, Extension, NPY, NPZ, PARQUET, UnknownFormat, by_extension, check_unit,
    dotted,
};
use crate::substrate::UpAxis;

/// What of a lichen is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A point an element, with every attribute.
    Points,
    /// A lobe an element, turned and scaled.
    Instances,
    /// The tree of parents, as lines that taper from the seed.
    Curves,
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Points => "points",
            Self::Instances => "instances",
            Self::Curves => "curves",
        })
    }
}

/// Which way is up in a format's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// As in the mesh file, unless asked otherwise.
    Mesh,
    /// As in the mesh file, unless asked otherwise, and the file says which.
    Declared,
    /// This way by convention, unless asked otherwise.
    Usual(UpAxis),
    /// This way by specification.
    Fixed(UpAxis),
}

type WriteScene = fn(&Scene, AgeColor<'_>, &mut dyn Write) -> io::Result<()>;

/// A file format for scenes.
#[derive(Clone, Copy, Debug)]
pub struct SceneFormat {
    /// Extension of its files, lower case, without the dot.
    pub extension: &'static str,
    /// What it is for, in words for the user.
    pub purpose: &'static str,
    /// Which way is up.
    pub axes: Axes,
    /// Whether its unit is the metre by specification.
    pub metres: bool,
    points: WriteScene,
    instances: Option<WriteScene>,
    curves: Option<WriteScene>,
}

/// Every format that scenes are written in.
pub const SCENE_FORMATS: &[SceneFormat] = &[
    SceneFormat {
        extension: "ply",
        purpose: "points or curves (edges) with every attribute: Blender, MeshLab",
        axes: Axes::Usual(UpAxis::Z),
        metres: false,
        points: ply::write_points,
        instances: None,
        curves: Some(ply::write_curves),
    },
    SceneFormat {
        extension: "glb",
        purpose: "glTF, binary: points, instances or curves, in metres",
        axes: Axes::Fixed(UpAxis::Y),
        metres: true,
        points: |s, c, out| gltf::points(s, c).write_glb(out),
        instances: Some(|s, c, out| gltf::instances(s, c).write_glb(out)),
        curves: Some(|s, c, out| gltf::curves(s, c).write_glb(out)),
    },
    SceneFormat {
        extension: "gltf",
        purpose: "the same as text",
        axes: Axes::Fixed(UpAxis::Y),
        metres: true,
        points: |s, c, out| gltf::points(s, c).write_gltf(out),
        instances: Some(|s, c, out| gltf::instances(s, c).write_gltf(out)),
        curves: Some(|s, c, out| gltf::curves(s, c).write_gltf(out)),
    },
    USDA,
    SceneFormat {
        extension: "usd",
        purpose: "the same under its other name",
        ..USDA
    },
    SceneFormat {
        extension: "obj",
        purpose: "coloured points or curves, without attributes",
        axes: Axes::Usual(UpAxis::Y),
        metres: false,
        points: obj::write_points,
        instances: None,
        curves: Some(obj::write_curves),
    },
    SceneFormat {
        extension: "inc",
        purpose: "POV-Ray: spheres, instances, or curves as tapering sphere sweeps",
        axes: Axes::Fixed(UpAxis::Y),
        metres: false,
        points: pov::write_points,
        instances: Some(pov::write_instances),
        curves: Some(pov::write_curves),
    },
    table(CSV, |s, c, out| (CSV.write)(&s.elements, c, out)),
    table(NPY, |s, c, out| (NPY.write)(&s.elements, c, out)),
    table(NPZ, |s, c, out| (NPZ.write)(&s.elements, c, out)),
    table(PARQUET, |s, c, out| (PARQUET.write)(&s.elements, c, out)),
];

const USDA: SceneFormat = SceneFormat {
    extension: "usda",
    purpose: "USD: points, instances or curves: Houdini, Blender, usdview",
    axes: Axes::Declared,
    metres: false,
    points: usda::write_points,
    instances: Some(usda::write_instances),
    curves: Some(usda::write_curves),
};

/// A format of elements, in the mesh's axes.
const fn table(format: ElementFormat, points: WriteScene) -> SceneFormat {
    SceneFormat {
        extension: format.extension,
        purpose: format.purpose,
        axes: Axes::Mesh,
        metres: false,
        points,
        instances: None,
        curves: None,
    }
}

impl Extension for SceneFormat {
    fn extension(&self) -> &'static str {
        self.extension
    }
}

/// Why a file cannot hold what was asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneFormatError {
    /// The name says no known format.
    #[error(transparent)]
    Unknown(#[from] UnknownFormat),
    /// The format cannot hold this.
    #[error(".{extension} files hold no {what}; name the file with one of {}", dotted(SCENE_FORMATS.iter().filter(|f| f.holds(*.what))))]
    Cannot {
        /// The format.
        extension: &'static str,
        /// What was asked for.
        what: What,
    },
}

impl SceneFormat {
    /// The format that a file's extension says, upper or lower case, if it can hold this.
    ///
    /// # Errors
    /// The message names the formats that could.
    pub fn of(path: &Path, what: What) -> Result<&'static Self, SceneFormatError> {
        let format = by_extension(SCENE_FORMATS, "elements", path)?;
        match format.holds(what) {
            true => Ok(format),
            false => Err(SceneFormatError::Cannot {
                extension: format.extension,
                what,
            }),
        }
    }

    /// Whether its files can hold this.
    pub fn holds(&self, what: What) -> bool {
        self.writer(what).is_some()
    }

    fn writer(&self, what: What) -> Option<WriteScene> {
        match what {
            What::Points => Some(self.points),
            What::Instances => self.instances,
            What::Curves => self.curves,
        }
    }

    /// Writes the scene, buffered. The same scene gives the same bytes.
    ///
    /// # Errors
    /// Those of `out`; `InvalidData` around a [`TableError`](super::TableError) when the scene [is not
    /// sound](Scene::check); `InvalidInput` when the format cannot hold what was asked for, that many
    /// elements, or none, or when its unit is no positive number of metres.
    pub fn write(
        &self,
        what: What,
        scene: &Scene,
        color: AgeColor<'_>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let invalid = |problem| io::Error::new(io::ErrorKind::InvalidInput, problem);
        let unsound = |e| io::Error::new(io::ErrorKind::InvalidData, e);
        if scene.elements.is_empty() {
            return Err(invalid("there are no elements to write"));
        }
        if !scene.fits_single() {
            return Err(invalid(
                "its lengths are beyond what 32-bit numbers hold: bring them nearer to 1 with --scale",
            ));
        }
        scene.check().map_err(unsound)?;
        check_unit(scene.meters_per_unit)?;
        if what == What::Curves && scene.streams.is_empty() {
            return Err(invalid("there are no branches: no element has a parent"));
        }
        let Some(write) = self.writer(what) else {
            return Err(invalid("the format does not hold this"));
        };
        let mut out = BufWriter::with_capacity(1 << 16, out);
        write(scene, color, &mut out)?;
        out.flush()
    }
}
