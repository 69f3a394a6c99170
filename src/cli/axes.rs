//! From the mesh file's axes and units to those of a file for another program.

use clap::Args;
use thallus::export::{Axes, FilmFormat, MeshFormat, Placement, SceneFormat, UpAxis};

use super::choice::up;
use super::failure::Failure;

#[derive(Debug, Args)]
#[command(next_help_heading = FILE)]
pub(crate) struct AxesArgs {
    /// Up axis of the file; glTF and POV-Ray have y and take no other [default: z for PLY; y for OBJ; the mesh's for
    /// USD and tables]
    #[arg(long, value_parser = up(), hide_possible_values = true, value_name = "y|z")]
    up: Option<UpAxis>,
    #[command(flatten)]
    units: UnitArgs,
}

/// The heading of these flags in help texts.
const FILE: &str = "File";

#[derive(Debug, Args)]
#[command(next_help_heading = FILE)]
pub(crate) struct UnitArgs {
    /// What a unit of the mesh is, for glTF, which is in metres, and USD, which says it; other files do not, and it is
    /// refused for them [default: m]
    #[arg(
        long,
        value_enum,
        value_name = "km|m|cm|mm|in|ft",
        hide_possible_values = true
    )]
    unit: Option<Unit>,
    /// Multiply all lengths by this, 1e-12 to 1e12
    #[arg(long, value_name = "FACTOR", value_parser = factor, default_value_t = 1.0, allow_negative_numbers = true)]
    scale: f64,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Unit {
    Km,
    M,
    Cm,
    Mm,
    In,
    Ft,
}

impl Unit {
    fn meters(self) -> f64 {
        match self {
            Self::Km => 1000.0,
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::In => 0.0254,
            Self::Ft => 0.3048,
        }
    }
}

/// A factor that lengths survive.
fn factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(factor) if (1e-12..=1e12).contains(&factor) => Ok(factor),
        _ => Err("give a number from 1e-12 to 1e12".to_owned()),
    }
}

/// A file format, as far as axes and units go.
pub(crate) struct Convention {
    pub(crate) extension: &'static str,
    pub(crate) axes: Axes,
    pub(crate) metres: bool,
}

macro_rules! convention_of {
    ($($format:ty),*) => {$(
        impl From<&$format> for Convention {
            fn from(format: &$format) -> Self {
                Self {
                    extension: format.extension,
                    axes: format.axes,
                    metres: format.metres,
                }
            }
        }
    )*};
}

convention_of!(FilmFormat, MeshFormat, SceneFormat);

impl AxesArgs {
    /// Size of a unit of the file, for files that say it.
    pub(crate) fn meters_per_unit(&self, format: &Convention) -> f64 {
        match format.metres {
            true => 1.0,
            false => self.units.unit_in_meters(),
        }
    }

    /// To the axes and units of the format, or as asked, for a mesh whose up axis is this, if that is known.
    pub(crate) fn placement(
        &self,
        format: &Convention,
        from: Option<UpAxis>,
    ) -> Result<Placement, Failure> {
        self.units.placement(format, from, self.up)
    }
}

/// Another up axis was asked for than files of a format have.
fn other_up(format: &Convention) -> Failure {
    let why = match format.extension {
        "inc" => {
            "have y up, as POV-Ray has: leave --up away, and turn the object Lichen in the scene"
        }
        _ => "are y-up by specification, and programs turn them themselves: leave --up away",
    };
    Failure::usage(format!(".{} files {why}", format.extension))
}

impl UnitArgs {
    fn unit_in_meters(&self) -> f64 {
        self.unit.map_or(1.0, Unit::meters)
    }

    /// To the axes and units of the format, or the up axis that was asked for, for a mesh whose own is this, if that
    /// is known.
    pub(crate) fn placement(
        &self,
        format: &Convention,
        from: Option<UpAxis>,
        up: Option<UpAxis>,
    ) -> Result<Placement, Failure> {
        let says_unit = format.metres || format.axes == Axes::Declared;
        if self.unit.is_some() && !says_unit {
            return Err(Failure::usage(format!(
                ".{} files do not say their unit: leave --unit away, or multiply lengths with --scale",
                format.extension
            )));
        }
        let scale = match format.metres {
            true => self.scale * self.unit_in_meters(),
            false => self.scale,
        };
        let to = match (format.axes, up) {
            (Axes::Fixed(fixed), Some(asked)) if asked != fixed => {
                return Err(other_up(format));
            }
            (Axes::Fixed(up), _) | (_, Some(up)) => Some(up),
            (Axes::Usual(up), None) => Some(up),
            (Axes::Mesh | Axes::Declared, None) => from,
        };
        match (from, to) {
            (Some(from), Some(to)) => Ok(Placement { from, to, scale }),
            (None, None) if format.axes == Axes::Mesh => Ok(Placement {
                scale,
                ..Placement::unchanged(UpAxis::Y)
            }),
            _ => Err(Failure::usage(
                "nothing says which way is up on the mesh: give it with --mesh, or say --mesh-up \
                 y or z",
            )),
        }
    }
}
