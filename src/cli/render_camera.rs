//! Where a picture is taken from, as `--camera` says it.

use std::cell::LazyCell;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use anyhow::Context;
use serde::{Deserialize, Serialize};
use thallus::input;
use thallus::picture::{Camera, Sight, World};
use thallus::substrate::Substrate;

use super::failure::Failure;
use super::terminal::Voice;

/// The value of the flag.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum View {
    Auto,
    /// Degrees.
    Side {
        azimuth: f32,
        elevation: f32,
    },
    Given(CameraText),
    File(String),
}

/// A camera in the mesh file's units and axes.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraText {
    eye: [f64; 3],
    target: [f64; 3],
    /// The mesh's, if it is not said.
    up: Option<[f64; 3]>,
    /// Degrees from the bottom to the top of the picture.
    #[serde(default = "portrait")]
    opening: f32,
}

/// Sides by their names: azimuth and elevation.
const SIDES: [(&str, f32, f32); 6] = [
    ("front", 0.0, 0.0),
    ("right", 90.0, 0.0),
    ("back", 180.0, 0.0),
    ("left", -90.0, 0.0),
    ("top", 0.0, 90.0),
    ("bottom", 0.0, -90.0),
];

fn portrait() -> f32 {
    30.0
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text == "auto" {
            return Ok(Self::Auto);
        }
        if let Some(&(_, azimuth, elevation)) = SIDES.iter().find(|(name, ..)| *name == text) {
            return Ok(Self::Side { azimuth, elevation });
        }
        if text.starts_with('{') {
            return camera_text(text).map(Self::Given);
        }
        if text.to_lowercase().ends_with(".json") {
            return Ok(Self::File(text.to_owned()));
        }
        let angle = |text: &str| text.trim().parse::<f32>().ok().filter(|a| a.is_finite());
        match text.split_once(',').map(|(a, e)| (angle(a), angle(e))) {
            Some((Some(azimuth), Some(elevation))) if elevation.abs() <= 90.0 => {
                Ok(Self::Side { azimuth, elevation })
            }
            Some((Some(_), Some(_))) => Err("the elevation may be -90 to 90".to_owned()),
            _ => Err(
                "write auto, front, back, left, right, top, bottom, two angles in degrees as 30,45, {\"eye\": [0,1,5], \"target\": \
                      [0,0,0]}, or the name of a .json file with that"
                    .to_owned(),
            ),
        }
    }
}

/// As it is read.
impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Side { azimuth, elevation } => write!(f, "{azimuth},{elevation}"),
            Self::Given(camera) => {
                f.write_str(&serde_json::to_string(camera).map_err(|_| fmt::Error)?)
            }
            Self::File(name) => f.write_str(name),
        }
    }
}

/// A camera, or what `render --json` says of a picture, which has one in it.
fn written(text: &str) -> serde_json::Result<CameraText> {
    let mut value: serde_json::Value = serde_json::from_str(text)?;
    match value.get_mut("camera") {
        Some(camera) => serde_json::from_value(camera.take()),
        None => serde_json::from_str(text),
    }
}

fn camera_text(text: &str) -> Result<CameraText, String> {
    let camera = written(text).map_err(|e| {
        format!("it is no camera: {e}; write one as {{\"eye\": [x,y,z], \"target\": [x,y,z]}}, or what render --json prints")
    })?;
    let [eye, target] = [camera.eye, camera.target].map(glam::DVec3::from);
    let way = target - eye;
    let up = camera.up.map_or(glam::DVec3::ONE, glam::DVec3::from);
    match () {
        () if !(way.is_finite() && way.length() > 0.0) => {
            Err("eye and target must be two different places".to_owned())
        }
        () if !(up.is_finite() && up.length() > 0.0) => Err("up must have a length".to_owned()),
        () if !(0.1..=170.0).contains(&camera.opening) => {
            Err("the opening may be 0.1 to 170 degrees".to_owned())
        }
        () => Ok(camera),
    }
}

impl View {
    /// With what is in a file instead of its name.
    pub(super) fn in_full(self) -> Result<Self, Failure> {
        match self {
            Self::File(name) => read(Path::new(&name)).map(Self::Given),
            view => Ok(view),
        }
    }

    /// The camera for pictures of this width over height; `world` is what is to be seen, if that is asked.
    pub(super) fn camera<'a, F: FnOnce() -> World<'a>>(
        &self,
        substrate: &Substrate,
        world: &LazyCell<World<'a>, F>,
        aspect: f32,
    ) -> Result<Camera, Failure> {
        Ok(match self {
            Self::Auto => Camera::best_view(world, aspect),
            Self::Side { azimuth, elevation } => {
                Camera::from_side(world, aspect, *azimuth, *elevation)
            }
            Self::Given(camera) => camera.on(substrate)?,
            Self::File(name) => read(Path::new(name))?.on(substrate)?,
        })
    }
}

/// Says so where the camera shows no lichen.
pub(super) fn warn_unseen(camera: &Camera, world: &World, aspect: f32, voice: Voice) {
    let why = match camera.sight(world, aspect) {
        Sight::Seen => return,
        Sight::Hidden => "the mesh hides it",
        Sight::Past => "the camera looks past it",
    };
    voice.warn(&format!(
        "no lichen is in the picture: {why}; --camera auto finds the side that shows most of it"
    ));
}

fn read(file: &Path) -> Result<CameraText, Failure> {
    let shown = file.display();
    let text = input::text(file).with_context(|| format!("{shown}: reading the camera failed"))?;
    camera_text(&text).map_err(|e| Failure::usage(format!("{shown}: {e}")))
}

/// The farthest that eye and target may be from the mesh, in its sizes: beyond that 32-bit numbers, in which
/// pictures are worked out, cannot hold the squares of distances.
const FARTHEST: f64 = 1e15;

impl CameraText {
    fn on(&self, substrate: &Substrate) -> Result<Camera, Failure> {
        let away = |p: [f64; 3]| substrate.units().to_local(p).length();
        if away(self.eye).max(away(self.target)) > FARTHEST {
            return Err(Failure::usage(
                "--camera: eye and target may be up to 1e15 times the mesh's size away from it",
            ));
        }
        let local = |p: [f64; 3]| substrate.units().to_local(p).as_vec3().to_array();
        let up = self.up.map_or(substrate.up(), glam::DVec3::from);
        let half_height = libm::tanf(0.5 * self.opening.to_radians());
        let up = up.normalize().as_vec3().to_array();
        let (eye, target) = (local(self.eye), local(self.target));
        Ok(Camera::look_at(eye, target, up, half_height))
    }

    /// A camera in the mesh file's units, aimed at what is this far from it.
    pub(super) fn of(camera: &Camera, distance: f32, substrate: &Substrate) -> Self {
        let eye = glam::Vec3::from(camera.eye());
        let target = eye + glam::Vec3::from(camera.forward()) * distance;
        let to_file = |p: glam::Vec3| substrate.units().to_file(p.as_dvec3()).to_array();
        Self {
            eye: to_file(eye),
            target: to_file(target),
            up: Some(camera.above().map(f64::from)),
            // What is beyond that is rounding.
            opening: (1e4 * camera.opening()).round() / 1e4,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_read() {
        let side = |azimuth, elevation| Ok(View::Side { azimuth, elevation });
        assert_eq!("auto".parse(), Ok(View::Auto));
        assert_eq!("30,45".parse(), side(30.0, 45.0));
        assert_eq!("-30, -90".parse(), side(-30.0, -90.0));
        assert_eq!("left".parse(), "-90,0".parse::<View>());
        assert_eq!(" top".parse(), side(0.0, 90.0));
        assert_eq!("a.json".parse(), Ok(View::File("a.json".to_owned())));
        let camera: View = r#"{"eye": [0,0,5], "target": [0,0,0]}"#.parse().unwrap();
        let View::Given(camera) = camera else {
            panic!("{camera:?}")
        };
        assert_eq!((camera.up, camera.opening), (None, 30.0));
        for wrong in [
            "",
            "30",
            "above",
            "30,91",
            "nan,0",
            "1,2,3",
            "{}",
            r#"{"eye": [0,0,5], "target": [0,0,5]}"#,
            r#"{"eye": [0,0,5], "target": [0,0,0], "up": [0,0,0]}"#,
            r#"{"eye": [0,0,5], "target": [0,0,0], "opening": 180}"#,
            r#"{"eye": [0,0,5], "target": [0,0,0], "fov": 30}"#,
        ] {
            assert!(wrong.parse::<View>().is_err(), "{wrong}");
        }
    }
}
