//! Recipes as TOML.
//!
//! Keys are spelled as the flags without their dashes (`curvature-radius`; `curvature_radius` is
//! read too). Numbers are written in the shortest form that reads back to the same bits.

use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::loose::{layers, places, seed, slope, triangles};
use super::parameter as info;
use super::recipe_keys::{with_dashes, wrong_value};
use super::toml_values::{
    float, length, listed_place, name, numbers, one_or_list, place_text, quoted, stop_text, whole,
};
use super::{Length, Recipe, Settings, StopRule, StopSetting};
use crate::growth::{Boundary, Join, Law, SeedPlace, Slope, Steps};
use crate::input;
use crate::substrate::UpAxis;

/// Every key that a recipe may have.
pub(super) const KEYS: &[&str] = &[
    "version",
    "mesh",
    "mesh-hash",
    "mesh-up",
    "mask",
    "mask-hash",
    "slope",
    "preset",
    "radius",
    "curvature-radius",
    "bias",
    "gain",
    "min-stick",
    "seed",
    "at",
    "at-triangle",
    "colonies",
    "launch",
    "kill",
    "join",
    "law",
    "steps",
    "boundary",
    "elements",
    "reach",
    "cover",
];

/// A text that is no recipe.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RecipeTextError {
    /// Not TOML.
    #[error("{0}")]
    Toml(String),
    /// A value that the key cannot have.
    #[error("line {line}: {key}: {problem}")]
    Value {
        /// The key.
        key: String,
        /// Where it is, from 1.
        line: usize,
        /// What is wrong with it, and what it may be.
        problem: String,
    },
    /// A key that no recipe has.
    #[error("line {line}: there is no setting '{key}'{suggestion}")]
    UnknownKey {
        /// The key.
        key: String,
        /// Where it is, from 1.
        line: usize,
        /// What may have been meant, or what there is.
        suggestion: String,
    },
    /// Keys that exclude one another.
    #[error("{0} exclude one another: keep one")]
    Exclusive(String),
}

/// A recipe file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecipeFileError {
    /// It cannot be read.
    #[error("{}: reading the recipe failed: {problem}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        problem: io::Error,
    },
    /// It is no recipe.
    #[error("{}: {problem}", .path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: RecipeTextError,
    },
}

/// The keys as they stand.
#[derive(Default, Deserialize)]
#[serde(rename_all = "kebab-case", default, deny_unknown_fields)]
struct Draft {
    version: Option<String>,
    mesh: Option<String>,
    mesh_hash: Option<String>,
    mesh_up: Option<UpAxis>,
    #[serde(deserialize_with = "layers")]
    mask: Option<Vec<String>>,
    #[serde(deserialize_with = "layers")]
    mask_hash: Option<Vec<String>>,
    #[serde(deserialize_with = "slope")]
    slope: Option<Slope>,
    preset: Option<String>,
    radius: Option<Length>,
    curvature_radius: Option<Length>,
    bias: Option<f64>,
    gain: Option<f64>,
    min_stick: Option<f64>,
    #[serde(deserialize_with = "seed")]
    seed: Option<u64>,
    #[serde(deserialize_with = "places")]
    at: Option<Vec<SeedPlace>>,
    #[serde(deserialize_with = "triangles")]
    at_triangle: Option<Vec<SeedPlace>>,
    colonies: Option<u64>,
    launch: Option<f64>,
    kill: Option<f64>,
    join: Option<Join>,
    law: Option<Law>,
    steps: Option<Steps>,
    boundary: Option<Boundary>,
    elements: Option<u64>,
    reach: Option<Length>,
    cover: Option<f64>,
}

impl Settings {
    /// Reads a recipe file, complete or not.
    ///
    /// # Errors
    /// When the file cannot be read or is no recipe.
    pub fn read(path: &Path) -> Result<Self, RecipeFileError> {
        let fail = |problem| RecipeFileError::Read {
            path: path.to_owned(),
            problem,
        };
        let text = input::text(path).map_err(fail)?;
        Self::from_toml(&text).map_err(|problem| RecipeFileError::Text {
            path: path.to_owned(),
            problem,
        })
    }

    /// Reads a recipe's text, complete or not.
    ///
    /// # Errors
    /// When it is not TOML, or has a key or value that no recipe has.
    pub fn from_toml(text: &str) -> Result<Self, RecipeTextError> {
        let text = with_dashes(text)?;
        let draft = toml::from_str::<Draft>(&text).map_err(|e| wrong_value(&text, &e))?;
        draft.try_into()
    }

    /// The text of a recipe with these settings, with a comment on each line that needs one.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for (key, value, comment) in self.entries() {
            let line = format!("{key} = {value}");
            match comment {
                "" => text += &line,
                comment => text += &format!("{line:<34} # {comment}"),
            }
            text.push('\n');
        }
        text
    }

    /// What is different in others, in words. The paths of mesh and mask and the stop rule change nothing in
    /// what grows, and do not count.
    pub fn differences(&self, others: &Self) -> Vec<String> {
        let growing = |settings: &Self| Self {
            mesh: None,
            mask: None,
            mask_hash: settings.sorted_mask_hash(),
            stop: None,
            ..settings.clone()
        };
        let (ours, theirs) = (growing(self).entries(), growing(others).entries());
        let value = |entries: &[(&str, String, &str)], key: &str| {
            let entry = entries.iter().find(|entry| entry.0 == key);
            entry.map_or_else(|| "unsaid".to_owned(), |entry| entry.1.clone())
        };
        let keys = KEYS
            .iter()
            .map(|key| (key, value(&ours, key), value(&theirs, key)));
        keys.filter(|(_, ours, theirs)| ours != theirs)
            .map(|(key, ours, theirs)| format!("{key} was {ours} and is {theirs}"))
            .collect()
    }

    /// What is said: key, value as TOML, comment.
    pub(super) fn entries(&self) -> Vec<(&'static str, String, &'static str)> {
        const PLACE: &str = "where the seed element goes";
        const PLACES: &str = "where the seed elements go";
        let mut entries = Vec::new();
        let mut say = |key, value: Option<String>, comment| {
            entries.extend(value.map(|value| (key, value, comment)));
        };
        let number = |value: Option<f64>| value.map(float);
        let texts = |texts: &Option<Vec<String>>| {
            texts
                .as_deref()
                .filter(|texts| !texts.is_empty())
                .map(one_or_list)
        };
        say(
            "version",
            self.version.as_deref().map(quoted),
            "of thallus, that made this",
        );
        say("mesh", self.mesh.as_deref().map(quoted), "");
        say("mesh-hash", self.mesh_hash.as_deref().map(quoted), "");
        say(
            "mesh-up",
            self.mesh_up.map(|up| name(&up)),
            "y or z: the axis of the mesh that is up",
        );
        say("mask", texts(&self.mask), "");
        say("mask-hash", texts(&self.mask_hash), "");
        say(
            "slope",
            self.slope.map(|s| format!("[{}]", numbers(&s.angles()))),
            "degrees: how steep it may be where lichen grows",
        );
        say("preset", self.preset.as_deref().map(quoted), "");
        say("radius", self.radius.map(length), "of an element");
        say(
            "curvature-radius",
            self.curvature_radius.map(length),
            "L: width of the branches",
        );
        say(
            "bias",
            number(self.bias),
            "B: high is thin and open, low is thick and closed",
        );
        say(
            "gain",
            number(self.gain),
            "A: how strongly tips are held back",
        );
        say(
            "min-stick",
            number(self.min_stick),
            "lowest chance to stick",
        );
        say("seed", self.seed.map(whole), "of everything random");
        match self.at.as_deref() {
            None => {}
            Some([place]) => {
                let (key, place) = place_text(place);
                say(key, Some(place), PLACE);
            }
            Some(places) => {
                let listed: Vec<String> = places.iter().map(listed_place).collect();
                say("at", Some(format!("[{}]", listed.join(", "))), PLACES);
            }
        }
        say(
            "colonies",
            self.colonies.map(whole),
            "random places for the others",
        );
        say("launch", number(self.launch), "in effective radii");
        say("kill", number(self.kill), "in effective radii");
        say("join", self.join.map(|join| name(&join)), "pack or touch");
        say("law", self.law.map(|law| name(&law)), "thesis or brownian");
        say(
            "steps",
            self.steps.map(|steps| name(&steps)),
            "large, exact or small",
        );
        say(
            "boundary",
            self.boundary.map(|b| name(&b)),
            "reflect or absorb, at open edges",
        );
        let (key, stop) = stop_text(self.stop.as_ref());
        say(key, stop, "when it is done");
        entries
    }
}

impl From<&Recipe> for Settings {
    fn from(recipe: &Recipe) -> Self {
        let stop = match recipe.stop {
            StopRule::Elements(n) => StopSetting::Elements(n),
            StopRule::Reach(length) => StopSetting::Reach(Length::Units(length)),
            StopRule::Cover(share) => StopSetting::Cover(share),
        };
        let placed = placed(&recipe.at);
        Self {
            version: Some(recipe.version.clone()),
            mesh: Some(recipe.mesh.file.clone()),
            mesh_hash: Some(recipe.mesh.hash.clone()),
            mesh_up: recipe.mesh_up,
            mask: recipe.mask.as_ref().map(|mask| mask.layers.clone()),
            mask_hash: recipe.mask.as_ref().map(|mask| mask.hashes.clone()),
            slope: recipe.slope,
            preset: None,
            radius: Some(Length::Units(recipe.radius)),
            curvature_radius: Some(Length::Units(recipe.curvature_radius)),
            bias: Some(recipe.bias),
            gain: Some(recipe.gain),
            min_stick: Some(recipe.min_stick),
            seed: Some(recipe.seed),
            at: Some(recipe.at[..placed].to_vec()),
            colonies: (recipe.at.len() > placed).then_some(recipe.at.len() as u64),
            launch: Some(recipe.launch),
            kill: Some(recipe.kill),
            join: Some(recipe.join),
            law: Some(recipe.law),
            steps: Some(recipe.steps),
            boundary: Some(recipe.boundary),
            stop: Some(stop),
        }
    }
}

/// How many places are written down: all but those of chance at the end, which the number of colonies tells, and one
/// where there is any.
fn placed(at: &[SeedPlace]) -> usize {
    let by_chance = |at: &&SeedPlace| **at == SeedPlace::Random;
    let last = at.iter().rev().take_while(by_chance).count();
    (at.len() - last).max(1).min(at.len())
}

impl Recipe {
    /// The whole recipe as the text of `recipe.toml`. Lengths are in mesh units.
    pub fn to_toml(&self) -> String {
        const HEAD: &str = "# How this lichen was grown. Lengths are in the mesh file's units.\n\
                            # The same again: thallus grow --recipe recipe.toml\n\n";
        HEAD.to_owned() + &Settings::from(self).to_toml()
    }
}

impl TryFrom<Draft> for Settings {
    type Error = RecipeTextError;

    fn try_from(draft: Draft) -> Result<Self, RecipeTextError> {
        let at = one_of([("at", draft.at), ("at-triangle", draft.at_triangle)])?;
        let stop = one_of([
            (
                info::ELEMENTS.name,
                draft.elements.map(StopSetting::Elements),
            ),
            (info::REACH.name, draft.reach.map(StopSetting::Reach)),
            (info::COVER.name, draft.cover.map(StopSetting::Cover)),
        ])?;
        Ok(Self {
            version: draft.version,
            mesh: draft.mesh,
            mesh_hash: draft.mesh_hash,
            mesh_up: draft.mesh_up,
            mask: draft.mask,
            mask_hash: draft.mask_hash,
            slope: draft.slope,
            preset: draft.preset,
            radius: draft.radius,
            curvature_radius: draft.curvature_radius,
            bias: draft.bias,
            gain: draft.gain,
            min_stick: draft.min_stick,
            seed: draft.seed,
            at,
            colonies: draft.colonies,
            launch: draft.launch,
            kill: draft.kill,
            join: draft.join,
            law: draft.law,
            steps: draft.steps,
            boundary: draft.boundary,
            stop,
        })
    }
}

/// The one that was given, of keys that exclude one another.
fn one_of<T, const N: usize>(
    keys: [(&'static str, Option<T>); N],
) -> Result<Option<T>, RecipeTextError> {
    let mut given: Vec<_> = keys
        .into_iter()
        .filter(|(_, value)| value.is_some())
        .collect();
    if given.len() > 1 {
        let names: Vec<_> = given.iter().map(|(key, _)| *key).collect();
        return Err(RecipeTextError::Exclusive(names.join(" and ")));
    }
    Ok(given.pop().and_then(|(_, value)| value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{MaskId, MeshId};
    use proptest::prelude::*;

    fn read(text: &str) -> Settings {
        Settings::from_toml(text).unwrap()
    }

    fn message(text: &str) -> String {
        Settings::from_toml(text).unwrap_err().to_string()
    }

    #[test]
    fn seeds_beyond_signed_numbers_are_read_quoted_or_not() {
        for text in ["18446744073709551615", "\"18446744073709551615\""] {
            let settings = Settings::from_toml(&format!("seed = {text}"));
            assert_eq!(settings.unwrap().seed, Some(u64::MAX), "{text}");
        }
    }

    #[test]
    fn keys_are_read_with_dashes_and_underscores() {
        let settings = read("curvature_radius = \"12r\"\nmin-stick = 1\n\"mesh_hash\" = \"x\"");
        assert_eq!(settings.curvature_radius, Some(Length::Radii(12.0)));
        assert_eq!(settings.min_stick, Some(1.0));
        assert_eq!(settings.mesh_hash.as_deref(), Some("x"));
        assert_eq!(read("\"min_stick\" = 0.5").min_stick, Some(0.5));
        assert!(message("\"min\\u005fstick\" = 0.5").contains("min_stick"));
    }

    #[test]
    fn values_may_be_written_as_flags_or_lists() {
        assert_eq!(read("at = \"1,2,-3\"").at, read("at = [1, 2.0, -3]").at);
        assert_eq!(read("at-triangle = 7").at, read("at-triangle = \"7\"").at);
        assert_eq!(
            read("at-triangle = [7, 0.25, 0.5]").at,
            read("at-triangle = \"7,0.25,0.5\"").at
        );
        assert_eq!(read("seed = 5").seed, read("seed = \"5\"").seed);
        assert_eq!(read("radius = 2").radius, Some(Length::Units(2.0)));
        assert_eq!(
            read("reach = \"0.5%\"").stop,
            Some(StopSetting::Reach(Length::Percent(0.5)))
        );
        assert_eq!(read(""), Settings::default());
    }

    #[test]
    fn unknown_keys_are_named_with_their_line_and_a_near_one() {
        let message = message("bias = 0.5\n\ncurvatureradius = 3\n");
        assert!(message.contains("line 3"), "{message}");
        assert!(
            message.contains("did you mean 'curvature-radius'?"),
            "{message}"
        );
        let message = super::tests::message("colour = 1");
        assert!(message.contains("there are version"), "{message}");
    }

    #[test]
    fn wrong_values_are_named_with_their_line() {
        for (text, part) in [
            ("gain = 1\nbias = \"high\"", "line 2"),
            ("radius = \"10 cows\"", "is not a length"),
            ("join = \"glue\"", "pack"),
            ("seed = -1", "the seed must be a whole number"),
            ("at = [1, 2]", "is not a place"),
            ("at-triangle = [1, 0.9, 0.9]", "outside the triangle"),
            ("elements = 1.5", "line 1: elements: "),
            (
                "gain = 1\nelements = \"many\"",
                "expected a whole number [range: 1 to",
            ),
            ("elements = -5", "line 1: elements: "),
            ("bias = true", "expected a number [range: -1 to 2]"),
            ("radius = true", "[range: auto"),
            ("join = 3", "line 1: join: a name in quotes"),
            ("min_stick = []", "line 1: min-stick: "),
            ("bias = ", "line 1"),
            ("bias = 1\nbias = 2", "line 2"),
            ("radius = nan", "line 1"),
        ] {
            let message = message(text);
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn keys_that_exclude_one_another_are_refused() {
        assert!(message("elements = 5\ncover = 0.5").contains("elements and cover"));
        assert!(message("at = \"top\"\nat-triangle = 5").contains("at and at-triangle"));
    }

    #[test]
    fn what_is_read_can_be_read_again_be_it_no_number() {
        for said in ["nan", "inf", "-inf", "1e300"] {
            let text = read(&format!("bias = {said}")).to_toml();
            assert!(text.starts_with(&format!("bias = {said} ")), "{text}");
            read(&text);
        }
    }

    #[test]
    fn several_places_are_read_and_written() {
        let text = "at = [\"top\", [1.0, -2.0, 0.5], \"triangle 7,0.25,0.5\"]";
        let several = read(text);
        let places = several.at.as_deref().unwrap();
        let triangle = SeedPlace::Triangle {
            triangle: 7,
            uv: Some([0.25, 0.5]),
        };
        let point = SeedPlace::Point([1.0, -2.0, 0.5]);
        assert_eq!(places, [SeedPlace::Top, point, triangle]);
        assert!(several.to_toml().starts_with(text));
        let flags = "--at=top --at=1.0,-2.0,0.5 --at='triangle 7,0.25,0.5'";
        assert_eq!(several.flags(), flags);
        assert_eq!(read("at = [\"1,-2,0.5\"]").at, read("at = [1, -2, 0.5]").at);
        let triangles = read("at-triangle = [[7, 0.25, 0.5], 9]").to_toml();
        assert!(
            triangles.starts_with("at = [\"triangle 7,0.25,0.5\", \"triangle 9\"]"),
            "{triangles}"
        );
        for (text, part) in [
            ("at = [\"top\", 3]", "'3' is not a place"),
            ("at = [[1, 2], \"top\"]", "'1,2' is not a place"),
            ("at = {x = 1}", "a list of places"),
            ("at = []", "an empty list has no place"),
        ] {
            assert!(message(text).contains(part), "{}", message(text));
        }
    }

    #[test]
    fn colonies_beyond_their_places_are_random() {
        let mesh = || MeshId {
            file: String::new(),
            hash: String::new(),
        };
        let recipe = |text: &str| read(text).complete()?.measured(200.0, mesh());
        let at = |text: &str| recipe(text).unwrap().at;
        assert_eq!(
            at("colonies = 3"),
            [SeedPlace::Top, SeedPlace::Random, SeedPlace::Random]
        );
        assert_eq!(
            at("at = \"random\"\ncolonies = 2"),
            vec![SeedPlace::Random; 2]
        );
        let text = recipe("colonies = 3").unwrap().to_toml();
        assert!(
            text.contains("at = \"top\" ") && text.contains("colonies = 3 "),
            "{text}"
        );
        assert!(!recipe("").unwrap().to_toml().contains("colonies"));
        for (text, part) in [
            ("colonies = 0", "colonies 0 is out of range (1 to 10000)"),
            ("colonies = 10001", "colonies 10001 is out of range"),
            (
                "colonies = 1\nat = [\"top\", \"random\"]",
                "colonies 1 is less than the 2 places",
            ),
            (
                "colonies = 5\nelements = 4",
                "elements 4 is less than the 5 colonies",
            ),
        ] {
            let message = recipe(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_mesh_given_as_recipe_is_an_error() {
        assert!(Settings::from_toml("v 0 0 0\nf 1 2 3\n").is_err());
    }

    fn place() -> impl Strategy<Value = SeedPlace> {
        let real = proptest::num::f64::NORMAL;
        let weights = (0.0..0.5f64, 0.0..0.5f64).prop_map(|(u, v)| [u, v]);
        prop_oneof![
            Just(SeedPlace::Top),
            Just(SeedPlace::Highest),
            Just(SeedPlace::Center),
            Just(SeedPlace::Random),
            (real, real, real).prop_map(|(x, y, z)| SeedPlace::Point([x, y, z])),
            (any::<u32>(), proptest::option::of(weights))
                .prop_map(|(triangle, uv)| SeedPlace::Triangle { triangle, uv }),
        ]
    }

    fn stop() -> impl Strategy<Value = StopRule> {
        prop_oneof![
            (10..1_000_000_000u64).prop_map(StopRule::Elements),
            (1e-300..1e300f64).prop_map(StopRule::Reach),
            (1e-9..1.0f64).prop_map(StopRule::Cover),
        ]
    }

    fn steps() -> impl Strategy<Value = Steps> {
        prop_oneof![Just(Steps::Large), Just(Steps::Exact), Just(Steps::Small)]
    }

    prop_compose! {
        fn recipe()(
            // Control characters, quotes and backslashes included.
            file in "(\\PC|[\\x00-\\x1f\"'\\\\#]){0,20}",
            radius in 2e-4..100.0f64,
            radii in 2.0..1000.0f64,
            numbers in (-1.0..2.0f64, 0.0..100.0f64, 1e-6..1.0f64, 1.1..100.0f64, 101.0..1e4f64),
            seed in any::<u64>(),
            at in proptest::collection::vec(place(), 1..6),
            stop in stop(),
            choices in (any::<bool>(), steps(), any::<bool>(), any::<bool>()),
            mesh_up in prop_oneof![Just(None), Just(Some(UpAxis::Y)), Just(Some(UpAxis::Z))],
            mask in proptest::option::of(proptest::collection::vec("\\PC{0,20}", 1..4)),
            slope in proptest::option::of((0.0..100.0f64, 101.0..180.0f64)),
        ) -> Recipe {
            Recipe {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                mesh: MeshId { file, hash: "ab12".to_owned() },
                mesh_up,
                mask: mask.map(|layers| MaskId { hashes: layers.clone(), layers }),
                slope: slope.and_then(|(least, most)| Slope::new(least, most)),
                radius,
                curvature_radius: radii * radius,
                bias: numbers.0,
                gain: numbers.1,
                min_stick: numbers.2,
                seed,
                at,
                launch: numbers.3,
                kill: numbers.4,
                join: if choices.0 { Join::Pack } else { Join::Touch },
                law: if choices.3 { Law::Thesis } else { Law::Brownian },
                steps: choices.1,
                boundary: if choices.2 { Boundary::Reflect } else { Boundary::Absorb },
                stop,
            }
        }
    }

    proptest! {
        #[test]
        fn recipes_come_back_to_the_bit(recipe in recipe()) {
            let text = recipe.to_toml();
            let settings = Settings::from_toml(&text).unwrap();
            let again = settings.complete().unwrap().measured(200.0, recipe.mesh.clone()).unwrap();
            prop_assert_eq!(&again, &recipe);
            prop_assert_eq!(again.to_toml(), text);
        }

        #[test]
        fn mesh_names_come_back(recipe in recipe()) {
            let settings = Settings::from_toml(&recipe.to_toml()).unwrap();
            prop_assert_eq!(settings.mesh, Some(recipe.mesh.file));
        }

        #[test]
        fn no_text_panics(text in "(\\PC|[\n=\"\\[\\],.#-]){0,60}") {
            let _ = Settings::from_toml(&text);
        }
    }
}
