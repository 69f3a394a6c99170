//! Values of settings as TOML.

use super::{Length, StopSetting, parameter as info};
use crate::growth::SeedPlace;

/// Shortest decimal that reads back to the same bits, and TOML's word for what has none.
pub(super) fn float(value: f64) -> String {
    format!("{value:?}").to_ascii_lowercase()
}

pub(super) fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// A text alone, or a list where there are several.
pub(super) fn one_or_list(texts: &[String]) -> String {
    match texts {
        [only] => quoted(only),
        several => {
            let quoted: Vec<String> = several.iter().map(|text| quoted(text)).collect();
            format!("[{}]", quoted.join(", "))
        }
    }
}

pub(super) fn length(length: Length) -> String {
    match length {
        Length::Units(units) => float(units),
        other => quoted(&other.to_string()),
    }
}

/// TOML's integers end at 2⁶³: larger seeds are written as text.
pub(super) fn whole(value: u64) -> String {
    match i64::try_from(value) {
        Ok(value) => value.to_string(),
        Err(_) => quoted(&value.to_string()),
    }
}

pub(super) fn name(value: &impl serde::Serialize) -> String {
    toml::Value::try_from(value).map_or_else(|_| String::new(), |name| name.to_string())
}

/// Under which key a place alone is written, and how.
pub(super) fn place_text(place: &SeedPlace) -> (&'static str, String) {
    match place {
        SeedPlace::Triangle { triangle, uv } => {
            let uv = uv.map_or_else(String::new, |uv| format!(", {}", numbers(&uv)));
            ("at-triangle", format!("[{triangle}{uv}]"))
        }
        other => ("at", listed_place(other)),
    }
}

/// A place among others.
pub(super) fn listed_place(place: &SeedPlace) -> String {
    match place {
        SeedPlace::Point(p) => format!("[{}]", numbers(p)),
        other => quoted(&other.to_string()),
    }
}

pub(super) fn numbers(all: &[f64]) -> String {
    let all: Vec<String> = all.iter().copied().map(float).collect();
    all.join(", ")
}

pub(super) fn stop_text(stop: Option<&StopSetting>) -> (&'static str, Option<String>) {
    match stop {
        None => (info::ELEMENTS.name, None),
        Some(StopSetting::Elements(n)) => (info::ELEMENTS.name, Some(n.to_string())),
        Some(StopSetting::Reach(reach)) => (info::REACH.name, Some(length(*reach))),
        Some(StopSetting::Cover(share)) => (info::COVER.name, Some(float(*share))),
    }
}
