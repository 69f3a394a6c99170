//! A recipe in the making: what the user said, layer over layer, until it is complete.
//!
//! Flags lie over a recipe file, which lies over a preset, which lies over the defaults.

use super::parameter::{self as info, ParameterInfo};
use super::preset;
use super::settings_error::{SettingsError, written};
use super::{Length, MaskId, MeshId, Places, Recipe, StopRule};
use crate::growth::{Boundary, Join, Law, SeedPlace, Slope, Steps};
use crate::substrate::{Substrate, SurfacePoint, UpAxis};

/// What decides the result, as far as it has been said. Lengths are not resolved yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Version of the program that resolved them, when they were read from a complete recipe.
    pub version: Option<String>,
    /// Path of the mesh file.
    pub mesh: Option<String>,
    /// Hash of the mesh that they were resolved for.
    pub mesh_hash: Option<String>,
    /// Which axis of the mesh is up, where its file does not keep to its format's convention.
    pub mesh_up: Option<UpAxis>,
    /// What the mask is made of that says where lichen may grow, layer by layer: the path of an image or of a run, or a
    /// word for something else; or [`NO_MASK`](super::NO_MASK) alone.
    pub mask: Option<Vec<String>>,
    /// Hashes of the mask's layers that they were resolved for.
    pub mask_hash: Option<Vec<String>>,
    /// How steep the surface may be where lichen grows: of any steepness by default.
    pub slope: Option<Slope>,
    /// Name of a preset that lies under them.
    pub preset: Option<String>,
    /// Element radius r: a millionth to half of the bounding box's diagonal, 1/2000 of it by default; see
    /// [`RADIUS`](super::RADIUS).
    pub radius: Option<Length>,
    /// Curvature radius L: 2 r to 1000 r, 10 r by default; see [`CURVATURE_RADIUS`](super::CURVATURE_RADIUS).
    pub curvature_radius: Option<Length>,
    /// Sticking bias B: -1 to 2, 0.5 by default; see [`BIAS`](super::BIAS).
    pub bias: Option<f64>,
    /// Curvature gain A: 0 to 100, 1 by default; see [`GAIN`](super::GAIN).
    pub gain: Option<f64>,
    /// Lowest sticking probability: 1e-6 to 1, 0.01 by default; see [`MIN_STICK`](super::MIN_STICK).
    pub min_stick: Option<f64>,
    /// Seed of every random stream, 1 by default.
    pub seed: Option<u64>,
    /// Where seed elements go, one a colony: [`SeedPlace::Top`] by default, and all at random where the list is empty
    /// and `colonies` says how many.
    pub at: Option<Vec<SeedPlace>>,
    /// How many colonies there are, 1 to 10,000, as many as `at` by default: those that it has no place for start at
    /// random.
    pub colonies: Option<u64>,
    /// Launch radius over the effective radius: 1.1 to 100, 1.5 by default; see [`LAUNCH`](super::LAUNCH).
    pub launch: Option<f64>,
    /// Kill radius over the effective radius: above `launch`, up to 10,000, 10 by default; see [`KILL`](super::KILL).
    pub kill: Option<f64>,
    /// How walkers are joined: [`Join::Pack`] by default.
    pub join: Option<Join>,
    /// How a walker moves: [`Law::Thesis`] by default.
    pub law: Option<Law>,
    /// How long steps may be: [`Steps::Large`] by default.
    pub steps: Option<Steps>,
    /// What open edges do to a walker: [`Boundary::Reflect`] by default.
    pub boundary: Option<Boundary>,
    /// When growth is done: at 20,000 elements by default.
    pub stop: Option<StopSetting>,
}

/// When growth is done, its length not resolved yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopSetting {
    /// At this many elements, 1 to a billion.
    Elements(u64),
    /// When the effective radius reaches this length; of several colonies, when one extends as far from its seed.
    Reach(Length),
    /// When this share, above 0 and up to 1, is covered of the pieces that lichen is on, as far as it may grow there.
    Cover(f64),
}

impl Settings {
    /// These settings where they say something, `base` where they don't.
    #[must_use]
    pub fn over(self, base: Self) -> Self {
        Self {
            version: self.version.or(base.version),
            mesh: self.mesh.or(base.mesh),
            mesh_hash: self.mesh_hash.or(base.mesh_hash),
            mesh_up: self.mesh_up.or(base.mesh_up),
            // The hash is that of the mask beside it.
            mask_hash: self
                .mask_hash
                .or(base.mask_hash.filter(|_| self.mask.is_none())),
            mask: self.mask.or(base.mask),
            slope: self.slope.or(base.slope),
            preset: self.preset.or(base.preset),
            radius: self.radius.or(base.radius),
            curvature_radius: self.curvature_radius.or(base.curvature_radius),
            bias: self.bias.or(base.bias),
            gain: self.gain.or(base.gain),
            min_stick: self.min_stick.or(base.min_stick),
            seed: self.seed.or(base.seed),
            at: self.at.or(base.at),
            colonies: self.colonies.or(base.colonies),
            launch: self.launch.or(base.launch),
            kill: self.kill.or(base.kill),
            join: self.join.or(base.join),
            law: self.law.or(base.law),
            steps: self.steps.or(base.steps),
            boundary: self.boundary.or(base.boundary),
            stop: self.stop.or(base.stop),
        }
    }

    /// These settings but for those that `others` say too.
    #[must_use]
    pub fn without(self, others: &Self) -> Self {
        fn left<T, U>(ours: Option<T>, theirs: Option<&U>) -> Option<T> {
            ours.filter(|_| theirs.is_none())
        }
        Self {
            version: left(self.version, others.version.as_ref()),
            mesh: left(self.mesh, others.mesh.as_ref()),
            mesh_hash: left(self.mesh_hash, others.mesh_hash.as_ref()),
            mesh_up: left(self.mesh_up, others.mesh_up.as_ref()),
            mask: left(self.mask, others.mask.as_ref()),
            mask_hash: left(self.mask_hash, others.mask_hash.as_ref()),
            slope: left(self.slope, others.slope.as_ref()),
            preset: left(self.preset, others.preset.as_ref()),
            radius: left(self.radius, others.radius.as_ref()),
            curvature_radius: left(self.curvature_radius, others.curvature_radius.as_ref()),
            bias: left(self.bias, others.bias.as_ref()),
            gain: left(self.gain, others.gain.as_ref()),
            min_stick: left(self.min_stick, others.min_stick.as_ref()),
            seed: left(self.seed, others.seed.as_ref()),
            at: left(self.at, others.at.as_ref()),
            colonies: left(self.colonies, others.colonies.as_ref()),
            launch: left(self.launch, others.launch.as_ref()),
            kill: left(self.kill, others.kill.as_ref()),
            join: left(self.join, others.join.as_ref()),
            law: left(self.law, others.law.as_ref()),
            steps: left(self.steps, others.steps.as_ref()),
            boundary: left(self.boundary, others.boundary.as_ref()),
            stop: left(self.stop, others.stop.as_ref()),
        }
    }

    /// Nothing left unsaid: laid over their preset and the defaults. Then checked, as far as that
    /// takes no mesh.
    ///
    /// # Errors
    /// When there is no such preset, or a value is out of range whatever the mesh.
    pub fn complete(self) -> Result<Complete, SettingsError> {
        let preset = match &self.preset {
            Some(name) => preset::find(name)?.settings(),
            None => Self::default(),
        };
        let complete = Complete::of(self.over(preset));
        complete.check()?;
        Ok(complete)
    }

    /// Resolves them for a mesh, `file` being its path as the user gave it.
    ///
    /// Settings of a complete recipe may be resolved for another mesh than that was made for: whether they
    /// suit it is asked (lengths, seed elements, axis up), whether it is the same is not:
    /// [`check_mesh`](Self::check_mesh) asks that. The recipe names the mesh that it is resolved for.
    ///
    /// # Errors
    /// As [`Settings::complete`]; when a length does not suit the mesh, a seed element has no place on it, or
    /// another axis is said to be up than [the substrate was told](Substrate::with_up), or a mask that it
    /// [does not have](Substrate::with_mask).
    pub fn resolve(self, substrate: &Substrate, file: &str) -> Result<Recipe, SettingsError> {
        self.resolve_by(&Places::on(substrate), file)
    }

    /// The same, for many recipes on one mesh.
    ///
    /// # Errors
    /// As [`Settings::resolve`].
    pub(crate) fn resolve_by(self, places: &Places, file: &str) -> Result<Recipe, SettingsError> {
        let substrate = places.substrate;
        if let Some(said) = self.mesh_up.filter(|up| *up != substrate.up_axis()) {
            return Err(SettingsError::OtherUp { said });
        }
        let mesh = MeshId {
            file: file.to_owned(),
            hash: substrate.mesh_hash().to_owned(),
        };
        let mask = self.mask_id(substrate)?;
        let complete = self.complete()?;
        let is_auto = complete.radius == Length::Auto;
        let recipe = Recipe {
            mesh_up: substrate.unusual_up(),
            mask,
            ..complete.measured(substrate.units().diagonal(), mesh)?
        };
        let seeds = places.of(&recipe)?;
        check_room(substrate, &seeds, &recipe, is_auto)?;
        Ok(recipe)
    }

    /// Checks that a mesh is the one that these settings were resolved for, if they were.
    ///
    /// # Errors
    /// [`SettingsError::OtherMesh`].
    pub fn check_mesh(&self, file: &str, hash: &str) -> Result<(), SettingsError> {
        match &self.mesh_hash {
            Some(expected) if expected != hash => Err(SettingsError::OtherMesh {
                file: file.to_owned(),
                found: hash.to_owned(),
                expected: expected.clone(),
            }),
            _ => Ok(()),
        }
    }
}

/// Settings with nothing left unsaid, still without a mesh to measure their lengths by: to be compared with others.
#[derive(Clone, Debug, PartialEq)]
pub struct Complete {
    mesh_up: Option<UpAxis>,
    /// That of a complete recipe.
    mask: Option<MaskId>,
    slope: Option<Slope>,
    radius: Length,
    curvature_radius: Length,
    bias: f64,
    gain: f64,
    min_stick: f64,
    seed: u64,
    /// One a colony.
    at: Vec<SeedPlace>,
    colonies: u64,
    launch: f64,
    kill: f64,
    join: Join,
    law: Law,
    steps: Steps,
    boundary: Boundary,
    stop: StopSetting,
}

impl Complete {
    /// What is unsaid becomes the default.
    fn of(settings: Settings) -> Self {
        let at = settings.at.unwrap_or_else(|| vec![SeedPlace::Top]);
        Self {
            mesh_up: settings.mesh_up,
            mask: settings
                .mask
                .zip(settings.mask_hash)
                .map(|(layers, hashes)| MaskId { layers, hashes }),
            // Of any steepness is what holds without one.
            slope: settings.slope.filter(|s| s.angles() != [0.0, 180.0]),
            radius: settings.radius.unwrap_or(Length::Auto),
            curvature_radius: settings
                .curvature_radius
                .unwrap_or(Length::Radii(info::DEFAULT_CURVATURE_RADII)),
            bias: settings.bias.unwrap_or(0.5),
            gain: settings.gain.unwrap_or(1.0),
            min_stick: settings.min_stick.unwrap_or(0.01),
            seed: settings.seed.unwrap_or(1),
            colonies: settings.colonies.unwrap_or(at.len() as u64),
            at,
            launch: settings.launch.unwrap_or(1.5),
            kill: settings.kill.unwrap_or(10.0),
            join: settings.join.unwrap_or(Join::Pack),
            law: settings.law.unwrap_or(Law::Thesis),
            steps: settings.steps.unwrap_or(Steps::Large),
            boundary: settings.boundary.unwrap_or(Boundary::Reflect),
            stop: settings
                .stop
                .unwrap_or(StopSetting::Elements(info::DEFAULT_ELEMENTS)),
        }
    }

    /// Checks everything that takes no mesh.
    fn check(&self) -> Result<(), SettingsError> {
        in_range(&info::BIAS, self.bias)?;
        in_range(&info::GAIN, self.gain)?;
        in_range(&info::MIN_STICK, self.min_stick)?;
        in_range(&info::LAUNCH, self.launch)?;
        in_range(&info::KILL, self.kill)?;
        if self.kill <= self.launch {
            return Err(SettingsError::KillInsideLaunch {
                launch: self.launch,
                kill: self.kill,
            });
        }
        self.check_notations()?;
        match self.stop {
            StopSetting::Elements(n) => in_range(&info::ELEMENTS, n as f64),
            StopSetting::Cover(share) => in_range(&info::COVER, share),
            StopSetting::Reach(_) => Ok(()),
        }?;
        self.check_colonies()
    }

    fn check_colonies(&self) -> Result<(), SettingsError> {
        in_range(&info::COLONIES, self.colonies as f64)?;
        if (self.colonies as usize) < self.at.len() {
            return Err(SettingsError::MorePlaces {
                places: self.at.len(),
                colonies: self.colonies,
            });
        }
        match self.stop {
            StopSetting::Elements(elements) if elements < self.colonies => {
                Err(SettingsError::MoreColonies {
                    elements,
                    colonies: self.colonies,
                })
            }
            _ => Ok(()),
        }
    }

    fn check_notations(&self) -> Result<(), SettingsError> {
        const OWN: &str = "the radius cannot be measured by itself; write mesh units (0.02), percent \
                           of the bounding box's diagonal (0.5%) or auto";
        const AUTO: &str = "only the radius can be auto; write mesh units, radii (10r) or percent";
        if matches!(self.radius, Length::Radii(_)) {
            return Err(notation(&info::RADIUS, self.radius, OWN));
        }
        if self.curvature_radius == Length::Auto {
            return Err(notation(&info::CURVATURE_RADIUS, Length::Auto, AUTO));
        }
        match self.stop {
            StopSetting::Reach(Length::Auto) => Err(notation(&info::REACH, Length::Auto, AUTO)),
            _ => Ok(()),
        }
    }

    /// The recipe for a mesh with this bounding box's diagonal. Nothing that takes the mesh itself is asked: neither
    /// whether seeds have a place there, nor which mask it has, so that one without a hash is left out.
    ///
    /// # Errors
    /// When a length does not suit the mesh.
    pub(super) fn measured(mut self, diagonal: f64, mesh: MeshId) -> Result<Recipe, SettingsError> {
        let radius = self.radius.in_units(diagonal, 0.0);
        check_radius(self.radius, radius, diagonal)?;
        let curvature_radius = self.curvature_radius.in_units(diagonal, radius);
        if !within_rounding(&info::CURVATURE_RADIUS, curvature_radius / radius) {
            let radii = crate::growth::four_digits(curvature_radius / radius);
            let given = match self.curvature_radius {
                Length::Radii(_) => self.curvature_radius.to_string(),
                other => format!("{other}, which is {radii}r here,"),
            };
            return Err(out_of_range(&info::CURVATURE_RADIUS, given));
        }
        self.at.resize(self.colonies as usize, SeedPlace::Random);
        Ok(Recipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            mesh,
            mesh_up: self.mesh_up,
            mask: self.mask,
            slope: self.slope,
            radius,
            curvature_radius,
            bias: self.bias,
            gain: self.gain,
            min_stick: self.min_stick,
            seed: self.seed,
            at: self.at,
            launch: self.launch,
            kill: self.kill,
            join: self.join,
            law: self.law,
            steps: self.steps,
            boundary: self.boundary,
            stop: stop_rule(self.stop, diagonal, radius)?,
        })
    }
}

/// Elements that each would cover the surface this many times are refused.
const MOST_COVER: f64 = 1.0;

/// Refuses elements that have no room on the smallest piece that a seed is on.
pub(super) fn check_room(
    substrate: &Substrate,
    seeds: &[SurfacePoint],
    recipe: &Recipe,
    is_auto: bool,
) -> Result<(), SettingsError> {
    let radius = recipe.radius;
    let area = |at: &SurfacePoint| substrate.component_of(at.triangle).area;
    let smallest = seeds.iter().map(area).fold(f64::INFINITY, f64::min);
    let area = substrate.units().area_to_file(smallest);
    let times = std::f64::consts::PI * radius * radius / area;
    if times < MOST_COVER {
        return Ok(());
    }
    let least = info::RADIUS.low * substrate.units().diagonal();
    let thousand = Some(radius / (1000.0 * times).sqrt()).filter(|&radius| radius >= least);
    Err(match is_auto {
        true => SettingsError::AutoLargerThanSurface {
            file: recipe.mesh.file.clone(),
            radius,
            times,
            thousand,
        },
        false => SettingsError::RadiusLargerThanSurface {
            radius,
            times,
            thousand,
        },
    })
}

fn stop_rule(stop: StopSetting, diagonal: f64, radius: f64) -> Result<StopRule, SettingsError> {
    match stop {
        StopSetting::Elements(n) => Ok(StopRule::Elements(n)),
        StopSetting::Cover(share) => Ok(StopRule::Cover(share)),
        StopSetting::Reach(length) => {
            let reach = length.in_units(diagonal, radius);
            if reach > 0.0 && reach.is_finite() {
                return Ok(StopRule::Reach(reach));
            }
            Err(out_of_range(&info::REACH, length))
        }
    }
}

fn check_radius(given: Length, radius: f64, diagonal: f64) -> Result<(), SettingsError> {
    if radius > info::RADIUS.high * diagonal {
        return Err(SettingsError::RadiusLargerThanMesh {
            radius,
            times: 2.0 * radius / diagonal,
            diagonal,
            auto: Length::Auto.in_units(diagonal, 0.0),
        });
    }
    match radius >= info::RADIUS.low * diagonal * (1.0 - 1e-12) && radius > 0.0 {
        true => Ok(()),
        false => Err(out_of_range(&info::RADIUS, given)),
    }
}

/// In range but for what resolving to mesh units and dividing back may round away.
fn within_rounding(info: &ParameterInfo, value: f64) -> bool {
    info.allows(value * (1.0 + 1e-12)) || info.allows(value * (1.0 - 1e-12))
}

fn in_range(info: &ParameterInfo, value: f64) -> Result<(), SettingsError> {
    match info.allows(value) {
        true => Ok(()),
        false => Err(out_of_range(info, written(value))),
    }
}

fn out_of_range(info: &ParameterInfo, value: impl ToString) -> SettingsError {
    SettingsError::OutOfRange {
        name: info.name,
        value: value.to_string(),
        range: info.range,
        looks: info.looks,
    }
}

fn notation(info: &ParameterInfo, value: Length, problem: &'static str) -> SettingsError {
    SettingsError::Notation {
        name: info.name,
        value: value.to_string(),
        problem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::Soup;

    fn mesh() -> MeshId {
        MeshId {
            file: "rock.obj".to_owned(),
            hash: "ab12".to_owned(),
        }
    }

    fn resolve(settings: Settings) -> Result<Recipe, SettingsError> {
        settings.complete()?.measured(200.0, mesh())
    }

    fn message(settings: Settings) -> String {
        resolve(settings).unwrap_err().to_string()
    }

    #[test]
    fn nothing_said_is_the_default_in_mesh_units() {
        let recipe = resolve(Settings::default()).unwrap();
        assert_eq!(recipe.radius, 0.1);
        assert_eq!(recipe.curvature_radius, 1.0);
        assert_eq!(recipe.stop, StopRule::Elements(20_000));
        assert_eq!(recipe.at, [SeedPlace::Top]);
        assert_eq!(recipe.mesh, mesh());
    }

    #[test]
    fn elements_larger_than_the_surface_are_refused() {
        let ribbon = |length| {
            let soup = Soup {
                positions: vec![
                    [0.0; 3],
                    [length, 0.0, 0.0],
                    [length, 1.0, 0.0],
                    [0.0, 1.0, 0.0],
                ],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                notes: Vec::new(),
            };
            Substrate::from_soup(soup).unwrap()
        };
        let (short, ribbon) = (ribbon(1e4), ribbon(1e9));
        let settings = |radius| Settings {
            radius: Some(Length::Units(radius)),
            ..Settings::default()
        };
        let refused = settings(500.0).resolve(&short, "").unwrap_err().to_string();
        assert!(
            refused.contains(" 78.54 times") && refused.contains("radius 1.784"),
            "{refused}"
        );
        // There the radius of which a thousand have room is below the smallest.
        let refused = settings(5e5).resolve(&ribbon, "").unwrap_err().to_string();
        assert!(
            refused.contains(" 785.4 times") && refused.ends_with("(at)"),
            "{refused}"
        );
        assert!(settings(1.5e4).resolve(&ribbon, "").is_ok());
        let refused = Settings::default().resolve(&ribbon, "ribbon.obj");
        let refused = refused.unwrap_err().to_string();
        assert!(
            refused.starts_with("ribbon.obj: ") && refused.ends_with("(at)"),
            "{refused}"
        );
    }

    #[test]
    fn the_table_says_the_defaults_that_hold() {
        let complete = Settings::default().complete().unwrap();
        let number = |info: &ParameterInfo| info.default.parse::<f64>().unwrap();
        let length = |info: &ParameterInfo| info.default.parse::<Length>().unwrap();
        assert_eq!(complete.radius, length(&info::RADIUS));
        assert_eq!(complete.curvature_radius, length(&info::CURVATURE_RADIUS));
        assert_eq!(complete.bias, number(&info::BIAS));
        assert_eq!(complete.gain, number(&info::GAIN));
        assert_eq!(complete.min_stick, number(&info::MIN_STICK));
        assert_eq!(complete.launch, number(&info::LAUNCH));
        assert_eq!(complete.kill, number(&info::KILL));
        let elements = number(&info::ELEMENTS) as u64;
        assert_eq!(complete.stop, StopSetting::Elements(elements));
    }

    #[test]
    fn layers_lie_over_one_another() {
        let flags = Settings {
            bias: Some(0.9),
            ..Settings::default()
        };
        let recipe = Settings {
            bias: Some(0.8),
            gain: Some(2.0),
            preset: Some("crustose".to_owned()),
            stop: Some(StopSetting::Cover(0.2)),
            ..Settings::default()
        };
        let recipe = resolve(flags.over(recipe)).unwrap();
        assert_eq!(recipe.bias, 0.9, "flags over the recipe");
        assert_eq!(recipe.gain, 2.0, "the recipe over the default");
        assert_eq!(recipe.curvature_radius, 2.0, "the preset over the default");
        assert_eq!(
            recipe.stop,
            StopRule::Cover(0.2),
            "the recipe over the preset"
        );
        assert_eq!(recipe.kill, 10.0, "the default");
    }

    #[test]
    fn numbers_out_of_range_are_named_with_range_and_look() {
        let bias = |bias| Settings {
            bias: Some(bias),
            ..Settings::default()
        };
        let message = message(bias(7.0));
        for part in ["bias 7", "-1 to 2", "Openness"] {
            assert!(message.contains(part), "{part} in {message}");
        }
        assert!(resolve(bias(f64::NAN)).is_err());
        assert!(resolve(bias(-1.0)).is_ok() && resolve(bias(2.0)).is_ok());
    }

    #[test]
    fn every_number_has_its_range() {
        type Set = fn(&mut Settings, f64);
        let fields: [(ParameterInfo, Set); 5] = [
            (info::BIAS, |s, x| s.bias = Some(x)),
            (info::GAIN, |s, x| s.gain = Some(x)),
            (info::MIN_STICK, |s, x| s.min_stick = Some(x)),
            (info::LAUNCH, |s, x| s.launch = Some(x)),
            (info::COVER, |s, x| s.stop = Some(StopSetting::Cover(x))),
        ];
        for (info, set) in fields {
            for value in [info.low - 0.5, info.high + 0.5, f64::INFINITY, f64::NAN] {
                let mut settings = Settings {
                    kill: Some(10_000.0),
                    ..Settings::default()
                };
                set(&mut settings, value);
                let message = message(settings);
                assert!(
                    message.contains(info.name) && message.contains(info.range),
                    "{message}"
                );
            }
        }
        let elements = |n| Settings {
            stop: Some(StopSetting::Elements(n)),
            ..Settings::default()
        };
        assert!(message(elements(0)).starts_with("elements 0 is out of range"));
        assert!(
            message(elements(1_000_000_001)).starts_with("elements 1000000001 is out of range")
        );
    }

    #[test]
    fn kill_lies_outside_launch() {
        let settings = Settings {
            launch: Some(5.0),
            kill: Some(5.0),
            ..Settings::default()
        };
        assert!(message(settings).contains("kill 5.0 must be larger than launch 5.0"));
    }

    #[test]
    fn radii_suit_the_mesh() {
        let radius = |radius| Settings {
            radius: Some(radius),
            ..Settings::default()
        };
        let large = message(radius(Length::Units(150.0)));
        assert!(
            large.contains("larger than the mesh") && large.contains("0.1"),
            "{large}"
        );
        assert!(message(radius(Length::Units(1e-5))).contains("a millionth"));
        assert!(message(radius(Length::Units(-1.0))).starts_with("radius -1"));
        assert!(message(radius(Length::Percent(0.0))).starts_with("radius 0"));
        assert!(message(radius(Length::Radii(3.0))).contains("by itself"));
        assert!(resolve(radius(Length::Percent(50.0))).is_ok());
    }

    #[test]
    fn other_lengths_are_checked_too() {
        let curvature = |length| Settings {
            curvature_radius: Some(length),
            ..Settings::default()
        };
        assert!(message(curvature(Length::Radii(1.9))).contains("2r to 1000r"));
        assert!(message(curvature(Length::Units(0.0))).starts_with("curvature-radius 0"));
        assert!(message(curvature(Length::Auto)).contains("only the radius"));
        assert!(resolve(curvature(Length::Radii(2.0))).is_ok());
        let reach = |length| Settings {
            stop: Some(StopSetting::Reach(length)),
            ..Settings::default()
        };
        assert!(message(reach(Length::Auto)).contains("reach auto"));
        assert!(message(reach(Length::Units(-2.0))).contains("above 0"));
        assert_eq!(
            resolve(reach(Length::Radii(30.0))).unwrap().stop,
            StopRule::Reach(3.0)
        );
    }

    #[test]
    fn another_mesh_is_told_apart() {
        let settings = Settings {
            mesh_hash: Some("ab12".to_owned()),
            ..Settings::default()
        };
        assert!(settings.check_mesh("rock.obj", "ab12").is_ok());
        assert!(Settings::default().check_mesh("rock.obj", "cd34").is_ok());
        let message = settings
            .check_mesh("rock.obj", "cd34")
            .unwrap_err()
            .to_string();
        for part in ["rock.obj", "ab12", "cd34"] {
            assert!(message.contains(part), "{message}");
        }
    }
}
