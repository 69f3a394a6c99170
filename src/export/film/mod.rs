//! A growing lichen in one file: USD with time samples, or glTF with a node a frame.
//!
//! Frames come one after the other and files want them by attribute, or their size first, so a film
//! keeps them in temporary files, which the system removes however the process ends.

mod glb;
mod usda;

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::{
    AgeColor, Axes, Extension, Scene, TriMesh, UnknownFormat, UpAxis, What, by_extension,
    check_unit,
};

/// A file format for films.
#[derive(Clone, Copy, Debug)]
pub struct FilmFormat {
    /// Extension of its files, lower case, without the dot.
    pub extension: &'static str,
    /// What it is for, in words for the user.
    pub purpose: &'static str,
    /// Which way is up.
    pub axes: Axes,
    /// Whether its unit is the metre by specification.
    pub metres: bool,
}

/// Every format that films are written in.
pub const FILM_FORMATS: &[FilmFormat] = &[
    FilmFormat {
        extension: "glb",
        purpose: "one glTF with an animation that viewers play; in Blender from frame 0 on",
        axes: Axes::Fixed(UpAxis::Y),
        metres: true,
    },
    USDA,
    FilmFormat {
        extension: "usd",
        purpose: "the same under its other name",
        ..USDA
    },
];

const USDA: FilmFormat = FilmFormat {
    extension: "usda",
    purpose: "one USD with time samples: Houdini, Blender, usdview",
    axes: Axes::Declared,
    metres: false,
};

impl Extension for FilmFormat {
    fn extension(&self) -> &'static str {
        self.extension
    }
}

impl FilmFormat {
    /// The format that a file's extension says, upper or lower case.
    ///
    /// # Errors
    /// When there is no extension or no such format; the message names those that there are.
    pub fn of(path: &Path) -> Result<&'static Self, UnknownFormat> {
        by_extension(FILM_FORMATS, "films", path)
    }
}

/// A film that is being made: of skins, of points or of curves, one of them in all frames. The same
/// frames give the same bytes.
#[derive(Debug)]
pub struct Film {
    fps: f64,
    form: Form,
    /// What its frames are of, as soon as there is one.
    of: Option<Frames>,
    /// Whether any frame shows anything.
    shows: bool,
}

/// What all frames of a film are of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Frames {
    Skins,
    Scenes(What),
}

#[derive(Debug)]
enum Form {
    Usda(usda::Usda),
    Glb(glb::Glb),
}

impl Film {
    /// A film without frames as yet, at so many a second; temporary files lie in a folder that is there.
    pub fn new(format: &FilmFormat, fps: f64, folder: &Path) -> Self {
        let spools = Spools(folder.to_owned());
        let form = match format.extension {
            "glb" => Form::Glb(glb::Glb::new(spools)),
            _ => Form::Usda(usda::Usda::new(spools)),
        };
        Self {
            fps,
            form,
            of: None,
            shows: false,
        }
    }

    /// This film of skins that come to lie where these vertices do: in glTF, and where 32 bits would not say
    /// these places, the film's lie about their middle, and are moved there.
    #[must_use]
    pub fn about(mut self, whole: &TriMesh) -> Self {
        match &mut self.form {
            Form::Usda(film) => film.origin = Some(whole.origin()),
            Form::Glb(film) => film.lies_about(whole),
        }
        self
    }

    /// This film, as long as it has no frames, with numbers of frames from this one on, not from 1: time codes in USD, names
    /// of nodes in glTF.
    #[must_use]
    pub fn starting_at(mut self, first: u32) -> Self {
        match &mut self.form {
            Form::Usda(film) => film.first = first,
            Form::Glb(film) => film.first = first,
        }
        self
    }

    /// The next frame of a film of skins. Without [`about`](Self::about) places are stored as the first
    /// of them has it.
    ///
    /// # Errors
    /// `InvalidData` around a [`MeshError`](super::MeshError) when the mesh is not sound; `InvalidInput` in a film of
    /// something else; those of temporary files.
    pub fn add_skin(&mut self, mesh: &TriMesh) -> io::Result<()> {
        mesh.check()
            .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        self.check_is_of(Frames::Skins)?;
        self.shows |= !mesh.triangles.is_empty();
        match &mut self.form {
            Form::Usda(film) => film.add_skin(mesh),
            Form::Glb(film) => film.add_skin(mesh),
        }
    }

    /// The next frame of a film of points or curves: a [moment](Scene::at) of a scene, the same one
    /// for all frames.
    ///
    /// # Errors
    /// `InvalidInput` for instances, and in a film of something else; `InvalidData` around a
    /// [`TableError`](super::TableError) when the scene [is not sound](Scene::check); those of temporary files.
    pub fn add_scene(&mut self, what: What, scene: &Scene, color: AgeColor<'_>) -> io::Result<()> {
        if what == What::Instances {
            return Err(invalid("films hold skins, points or curves"));
        }
        let unsound = |e| io::Error::new(io::ErrorKind::InvalidData, e);
        scene.check().map_err(unsound)?;
        self.check_is_of(Frames::Scenes(what))?;
        self.shows |= match what {
            What::Curves => scene.streams.iter().any(|stream| !stream.is_empty()),
            _ => !scene.elements.is_empty(),
        };
        match &mut self.form {
            Form::Usda(film) => film.add_scene(what, scene, color),
            Form::Glb(film) => film.add_scene(what, scene, color),
        }
    }

    /// Refuses a frame of something else than those before it.
    fn check_is_of(&mut self, frames: Frames) -> io::Result<()> {
        match *self.of.get_or_insert(frames) == frames {
            true => Ok(()),
            false => Err(invalid(
                "a film is of skins, of points or of curves in all frames",
            )),
        }
    }

    /// Writes the film, whose unit is so many metres where the file says it.
    ///
    /// # Errors
    /// Those of `out` and of the temporary files; `InvalidInput` when the format cannot hold as much, when no frame
    /// shows anything, or when the frames a second or the metres a unit are no positive number.
    pub fn write(self, meters_per_unit: f64, out: &mut dyn Write) -> io::Result<()> {
        if !(self.fps > 0.0 && self.fps.is_finite()) {
            return Err(invalid("frames a second are a positive number"));
        }
        check_unit(meters_per_unit)?;
        if !self.shows {
            return Err(invalid(NOTHING));
        }
        let mut out = BufWriter::with_capacity(1 << 16, out);
        match self.form {
            Form::Usda(film) => film.write(self.fps, meters_per_unit, &mut out)?,
            Form::Glb(film) => film.write(self.fps, &mut out)?,
        }
        out.flush()
    }
}

/// Why there is no film.
const NOTHING: &str = "there is nothing to see in any frame";

fn invalid(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, problem)
}

/// Where temporary files lie.
#[derive(Debug)]
struct Spools(PathBuf);

/// A temporary file without a name.
#[derive(Debug)]
struct Spool(BufWriter<File>);

impl Spools {
    fn make(&self) -> io::Result<Spool> {
        let file = tempfile::tempfile_in(&self.0)?;
        Ok(Spool(BufWriter::with_capacity(1 << 16, file)))
    }
}

impl Spool {
    /// Copies all that was written.
    fn pour(self, out: &mut dyn Write) -> io::Result<()> {
        let mut file = self
            .0
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        let mut buffer = vec![0; 1 << 20];
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(()),
                n => out.write_all(&buffer[..n])?,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_of_nothing_or_of_no_time_are_refused() {
        let mesh = TriMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            colors: vec![[9; 3]; 3],
            triangles: vec![[0, 1, 2]],
            ..TriMesh::default()
        };
        let folder = tempfile::tempdir().expect("a folder");
        for format in FILM_FORMATS {
            let is_made = |fps: f64, mesh: &TriMesh| {
                let mut film = Film::new(format, fps, folder.path());
                film.add_skin(mesh).expect("a frame");
                film.write(1.0, &mut Vec::new()).is_ok()
            };
            assert!(is_made(24.0, &mesh));
            assert!(!is_made(24.0, &TriMesh::default()));
            for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                assert!(!is_made(fps, &mesh), "{fps}");
            }
        }
    }

    /// What lies in the JSON of a binary glTF.
    fn document(glb: &[u8]) -> serde_json::Value {
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap());
        serde_json::from_slice(&glb[20..][..length as usize]).unwrap()
    }

    /// Viewers take nodes of scale 0 into the box of all that there is, and frame that.
    #[test]
    fn hidden_frames_of_a_gltf_are_inside_the_lichen() {
        let corner = [3.0, -7.1, 1001.3];
        let mesh = |size: f64| TriMesh {
            positions: vec![
                corner,
                [corner[0] + size, corner[1], corner[2]],
                [corner[0], corner[1] + size, corner[2]],
            ],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            colors: vec![[9; 3]; 3],
            triangles: vec![[0, 1, 2]],
            ..TriMesh::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let new = || Film::new(&FILM_FORMATS[0], 24.0, folder.path());
        for mut film in [new(), new().about(&mesh(2.0))] {
            film.add_skin(&mesh(1.0)).unwrap();
            film.add_skin(&mesh(2.0)).unwrap();
            let mut out = Vec::new();
            film.write(1.0, &mut out).unwrap();
            let document = document(&out);
            let nodes = document["nodes"].as_array().unwrap();
            let at = &nodes.last().unwrap()["translation"];
            for mesh in document["meshes"].as_array().unwrap() {
                let place = &mesh["primitives"][0]["attributes"]["POSITION"];
                let stored = &document["accessors"][place.as_u64().unwrap() as usize];
                for (k, corner) in corner.into_iter().enumerate() {
                    let [at, low] = [&at[k], &stored["min"][k]].map(|x| x.as_f64().unwrap());
                    assert!((at + low - corner).abs() < 1e-4, "{at} {low}");
                    assert!((-1e-4..2.0).contains(&(at - corner)), "{at}");
                }
            }
        }
    }

    /// The values of each frame of an array in a film of USD.
    fn samples<'t>(text: &'t str, array: &str) -> Vec<&'t str> {
        let (_, rest) = text
            .split_once(&format!("{array}.timeSamples = {{"))
            .unwrap();
        let (samples, _) = rest.split_once('}').unwrap();
        samples.trim().lines().map(str::trim).collect()
    }

    /// Between two arrays of one length programs interpolate, vertex by vertex.
    #[test]
    fn frames_of_other_triangles_have_other_numbers_of_vertices() {
        let square = |triangles: [[u32; 3]; 2]| TriMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            colors: vec![[9; 3]; 4],
            attributes: vec![super::super::VertexAttribute {
                name: "birth",
                values: vec![1.0, 2.0, 3.0, 4.0],
                is_length: false,
            }],
            triangles: triangles.to_vec(),
            ..TriMesh::default()
        };
        let one = || square([[0, 1, 2], [0, 2, 3]]);
        let other = || square([[0, 1, 3], [1, 2, 3]]);
        let folder = tempfile::tempdir().unwrap();
        let mut film = Film::new(&USDA, 24.0, folder.path()).starting_at(7);
        for mesh in [one(), one(), other(), one(), other(), TriMesh::default()] {
            film.add_skin(&mesh).unwrap();
        }
        let mut out = Vec::new();
        film.write(1.0, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let commas = |array: &str, of_one: usize| {
            let counts = samples(&text, array)
                .into_iter()
                .map(|frame| frame.matches(',').count());
            counts.map(|n| n / of_one).collect::<Vec<_>>()
        };
        for array in ["points", "normals", "primvars:displayColor"] {
            assert_eq!(commas(array, 3), [4, 4, 5, 4, 5, 0], "{array}");
        }
        assert_eq!(commas("primvars:birth", 1), [4, 4, 5, 4, 5]);
        let last = samples(&text, "primvars:birth")[2];
        assert_eq!(last, "9: [1, 2, 3, 4, 4],");
        assert_eq!(commas("int[] faceVertexCounts", 1), [2, 2, 2, 2, 2, 1]);
    }

    /// In map coordinates, where places are stored from an origin.
    #[test]
    fn the_box_of_an_empty_frame_holds_nothing() {
        let far = [500_000.0, 5_400_000.0, 112.0];
        let mesh = TriMesh {
            positions: vec![
                far,
                [far[0] + 1.0, far[1], far[2]],
                [far[0], far[1] + 1.0, far[2]],
            ],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            colors: vec![[9; 3]; 3],
            triangles: vec![[0, 1, 2]],
            ..TriMesh::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let mut film = Film::new(&USDA, 24.0, folder.path()).about(&mesh);
        film.add_skin(&TriMesh::default()).unwrap();
        film.add_skin(&mesh).unwrap();
        let mut out = Vec::new();
        film.write(1.0, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let (_, extents) = text.split_once("float3[] extent").unwrap();
        let nothing = "1: [(3.4028235e38, 3.4028235e38, 3.4028235e38), (-3.4028235e38, -3.4028235e38, -3.4028235e38)],";
        assert!(extents.contains(nothing), "{text}");
        assert!(
            extents.contains("2: [(-0.5, -0.5, 0), (0.5, 0.5, 0)],"),
            "{text}"
        );
    }
}
