//! The keys of a recipe's text, and what is wrong with those that cannot be.

use super::names::nearest_name;
use super::parameter::PARAMETERS;
use super::recipe_text::{KEYS, RecipeTextError};

/// What grids have and recipes do not.
pub(crate) const AXES: &str = "axes";

/// The text with underscores in its keys made dashes, so that line numbers in errors stay true.
/// Unknown keys are refused here, where the nearest known one can be named.
pub(super) fn with_dashes(text: &str) -> Result<String, RecipeTextError> {
    let table = toml::de::DeTable::parse(text).map_err(|e| not_toml(&e))?;
    let mut dashed = text.to_owned();
    for key in table.get_ref().keys() {
        let known = key.get_ref().replace('_', "-");
        if !KEYS.contains(&known.as_str()) {
            let line = line_at(text, key.span().start);
            let is_grid = table.get_ref().contains_key(AXES);
            return Err(unknown_key(key.get_ref(), line, is_grid));
        }
        // The letters, between quotes where there are any: the spans of others stay.
        let (span, quotes) = (key.span(), key.span().len().saturating_sub(known.len()));
        let letters = span.start + quotes / 2..span.end - quotes / 2;
        if text[letters.clone()] == **key.get_ref() {
            dashed.replace_range(letters, &known);
        }
    }
    Ok(dashed)
}

fn unknown_key(key: &str, line: usize, is_grid: bool) -> RecipeTextError {
    RecipeTextError::UnknownKey {
        key: key.to_owned(),
        line,
        suggestion: match is_grid {
            true => format!("; with [{AXES}] this is a grid, for 'thallus sweep'"),
            false => unknown_name(key, &[]),
        },
    }
}

/// The end of a message about a name that no setting has: which one may have been meant, but for these.
pub(super) fn unknown_name(name: &str, but: &[&str]) -> String {
    let keys = || KEYS.iter().copied().filter(|key| !but.contains(key));
    let near = nearest_name(&name.replace('_', "-"), keys());
    near.map_or_else(
        || format!("; there are {}", keys().collect::<Vec<_>>().join(", ")),
        |near| format!("; did you mean '{near}'?"),
    )
}

/// What is wrong with a value of a text that is TOML: under which key, and what it may have.
pub(super) fn wrong_value(text: &str, error: &toml::de::Error) -> RecipeTextError {
    let (Some(span), Ok(table)) = (error.span(), toml::de::DeTable::parse(text)) else {
        return not_toml(error);
    };
    let is_there = |value: std::ops::Range<usize>| value.contains(&span.start);
    let mut entries = table.get_ref().iter();
    let Some((key, _)) = entries.find(|(_, value)| is_there(value.span())) else {
        return not_toml(error);
    };
    let name = key.get_ref();
    let said = error
        .message()
        .replace(" as i128", "")
        .replace("invalid type: map", "invalid type: table")
        .replace("expected u64", "expected a whole number")
        .replace("expected f64", "expected a number")
        .replace("wanted string or table", "a name in quotes is needed");
    let known = PARAMETERS.iter().find(|parameter| parameter.name == *name);
    let range = known.map_or_else(String::new, |known| format!(" [range: {}]", known.range));
    RecipeTextError::Value {
        key: name.to_string(),
        line: line_at(text, key.span().start),
        problem: said + &range,
    }
}

/// A text that is no TOML, in the words of the parser.
pub(crate) fn not_toml(error: &toml::de::Error) -> RecipeTextError {
    RecipeTextError::Toml(error.to_string().trim_end().to_owned())
}

/// The line of a place in a text, from 1.
pub(crate) fn line_at(text: &str, place: usize) -> usize {
    1 + text[..place].matches('\n').count()
}
