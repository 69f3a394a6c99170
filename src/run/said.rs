//! What settings say, key by key: for tables, for commands, and to vary one of them.

use std::path::Path;

use super::Settings;
use super::recipe_keys::unknown_name;
use super::recipe_text::KEYS;

/// A name that no setting has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no setting '{name}'{suggestion}")]
pub struct UnknownSetting {
    name: String,
    /// What may have been meant, or what there is.
    suggestion: String,
}

impl UnknownSetting {
    /// The same where some settings cannot have been meant.
    pub(crate) fn but(self, but: &[&str]) -> Self {
        Self {
            suggestion: unknown_name(&self.name, but),
            name: self.name,
        }
    }
}

impl Settings {
    /// The key that a name stands for: `curvature_radius` is `curvature-radius`.
    ///
    /// # Errors
    /// When there is no such setting; the message names the nearest one.
    pub fn key(name: &str) -> Result<&'static str, UnknownSetting> {
        let dashed = name.replace('_', "-");
        let known = KEYS.iter().find(|key| **key == dashed);
        known.copied().ok_or_else(|| UnknownSetting {
            name: name.to_owned(),
            suggestion: unknown_name(name, &[]),
        })
    }

    /// The keys that are said, each with its value as TOML.
    pub fn said(&self) -> Vec<(&'static str, String)> {
        let entries = self.entries().into_iter();
        entries.map(|(key, value, _)| (key, value)).collect()
    }

    /// What is [different](Self::differences) in others, the size at which growth stops included.
    pub fn differences_and_size(&self, others: &Self) -> Vec<String> {
        let mut differences = self.differences(others);
        if self.stop != others.stop {
            let [was, is] = [self, others].map(Self::size);
            differences.push(format!("the size was {was} and is {is}"));
        }
        differences
    }

    /// `elements = 500`.
    fn size(&self) -> String {
        let stop = Self {
            stop: self.stop,
            ..Self::default()
        };
        match stop.said().pop() {
            Some((key, value)) => format!("{key} = {value}"),
            None => "the usual".to_owned(),
        }
    }

    /// What is said as flags of `thallus grow`, each with its value in one word of a POSIX shell.
    /// Version, mesh and hashes are no flags.
    pub fn flags(&self) -> String {
        let is_flag = |key: &str| !["version", "mesh", "mesh-hash", "mask-hash"].contains(&key);
        let said = self.said().into_iter().filter(|(key, _)| is_flag(key));
        let flag = |key: &str, word: &str| format!("--{key}={}", shell_word(word));
        let flags = said.flat_map(|(key, value)| {
            let words = match (key, &self.at, &self.mask) {
                ("at", Some(places), _) => places.iter().map(ToString::to_string).collect(),
                ("mask", _, Some(layers)) => layers.clone(),
                _ => vec![as_typed(&value)],
            };
            words.into_iter().map(move |word| flag(key, &word))
        });
        flags.collect::<Vec<_>>().join(" ")
    }
}

/// A TOML value as it is typed after a flag: strings bare, lists without brackets.
fn as_typed(value: &str) -> String {
    match read(value) {
        Some(toml::Value::Array(_)) => value.replace(['[', ']', ' '], ""),
        _ => unquoted(value),
    }
}

/// The text that a TOML value holds.
pub(crate) fn unquoted(value: &str) -> String {
    match read(value) {
        Some(toml::Value::String(text)) => text,
        _ => value.to_owned(),
    }
}

fn read(value: &str) -> Option<toml::Value> {
    let table = format!("v = {value}").parse::<toml::Table>();
    table.ok()?.remove("v")
}

/// A path as one word of this system's shells: for commands that a message names. One that looks like a flag is named
/// from the present folder.
pub fn shell_path(path: &Path) -> String {
    let text = path.to_string_lossy();
    let word = match text.starts_with('-') {
        true => format!("./{text}"),
        false => text.into_owned(),
    };
    match cfg!(windows) {
        true => windows_word(&word),
        false => shell_word(&word),
    }
}

/// One word of a POSIX shell, quoted where it must be.
pub fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+%:@".contains(c);
    match !text.is_empty() && text.chars().all(plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

/// One word of `cmd` and of PowerShell, for a path: a backslash before the last quote would be of that quote.
fn windows_word(path: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || r"-_./\:".contains(c);
    match !path.is_empty() && path.chars().all(plain) {
        true => path.to_owned(),
        false => format!("\"{}\"", path.trim_end_matches('\\').replace('"', "\\\"")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Length, SeedPlace, StopSetting};

    #[test]
    fn names_are_found_or_the_nearest_is_named() {
        assert_eq!(
            Settings::key("curvature_radius").unwrap(),
            "curvature-radius"
        );
        let message = Settings::key("biass").unwrap_err().to_string();
        assert!(message.contains("did you mean 'bias'?"), "{message}");
    }

    #[test]
    fn flags_are_what_was_said() {
        let settings = Settings {
            mesh: Some("rock.obj".to_owned()),
            preset: Some("foliose".to_owned()),
            curvature_radius: Some(Length::Radii(5.0)),
            bias: Some(-0.25),
            seed: Some(u64::MAX),
            at: Some(vec![SeedPlace::Point([-1.0, 0.5, 2.0])]),
            stop: Some(StopSetting::Reach(Length::Units(0.1))),
            ..Settings::default()
        };
        assert_eq!(
            settings.flags(),
            "--preset=foliose --curvature-radius=5.0r --bias=-0.25 --seed=18446744073709551615 \
             --at=-1.0,0.5,2.0 --reach=0.1"
        );
    }

    #[test]
    fn words_survive_the_shell() {
        assert_eq!(shell_word("out/a-b_1.5r"), "out/a-b_1.5r");
        assert_eq!(shell_word("my rock's.obj"), r"'my rock'\''s.obj'");
        assert_eq!(shell_word(""), "''");
        assert_eq!(windows_word(r"C:\out\a-b"), r"C:\out\a-b");
        assert_eq!(windows_word("my rock's.obj"), "\"my rock's.obj\"");
        assert_eq!(windows_word(r"my runs\"), "\"my runs\"");
        assert_eq!(shell_path(Path::new("-o")), "./-o");
        let quotes = if cfg!(windows) { '"' } else { '\'' };
        let spaced = shell_path(Path::new("my runs/1"));
        assert_eq!(spaced, format!("{quotes}my runs/1{quotes}"));
    }
}
