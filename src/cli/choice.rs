//! Flags that take one of some words.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use thallus::substrate::UpAxis;

/// One of some named values.
pub(super) fn choice<T: Copy + Send + Sync + 'static, const N: usize>(
    values: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    let names = values.map(|(name, _)| PossibleValue::new(name));
    let named = move |name: String| values.into_iter().find(|(known, _)| name == *known);
    PossibleValuesParser::new(names).try_map(move |name| {
        let value = named(name).map(|(_, value)| value);
        value.ok_or("not one of the values")
    })
}

pub(super) fn up() -> impl TypedValueParser<Value = UpAxis> {
    choice([("y", UpAxis::Y), ("z", UpAxis::Z)])
}
