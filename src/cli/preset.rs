//! `thallus preset`: looks by name.

use thallus::run::Settings;
use thallus::run::preset::{PRESETS, Preset, find};

use super::failure::Failure;
use super::terminal;

pub(crate) fn list() -> Result<(), Failure> {
    let width = PRESETS.iter().map(|p| p.name.len()).max().unwrap_or(0);
    let line = |p: &Preset| format!("{:width$}  {}\n", p.name, p.look);
    terminal::say_text(&PRESETS.iter().map(line).collect::<String>())?;
    Ok(())
}

pub(crate) fn show(name: &str) -> Result<(), Failure> {
    let preset = find(name).map_err(|unknown| Failure::Usage(unknown.into()))?;
    terminal::say_text(&recipe(preset))?;
    Ok(())
}

/// The preset as a recipe file to start from.
fn recipe(preset: &Preset) -> String {
    let Preset { name, look, .. } = preset;
    let settings: Settings = preset.settings();
    format!("# {name}: {look}.\n\n{}", settings.to_toml())
}
