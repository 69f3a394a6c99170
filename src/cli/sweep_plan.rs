//! What whole sweeps, their parts and merged ones have in common: the plan, and how failures are told.

use std::collections::BTreeMap;
use std::path::Path;

use thallus::substrate::Substrate;
use thallus::sweep::{Grid, Plan};

use super::failure::Failure;
use super::named_mesh;
use super::number::plural;
use super::paths::portable;
use super::terminal::Voice;

/// Says in the grid which mesh it is on.
pub(super) fn settle(
    grid: &mut Grid,
    substrate: &Substrate,
    mesh: &Path,
    is_named: bool,
    voice: Voice,
) -> Result<(), Failure> {
    named_mesh::warn_of_nameless(mesh, voice);
    let shown = mesh.display().to_string();
    match grid.base.check_mesh(&shown, substrate.mesh_hash()) {
        Err(other) if !is_named => {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{other}; name the right one with --mesh"
            )));
        }
        Err(_) => voice.note(&format!(
            "{shown} is another mesh than the grid was made for: lengths stay those of the grid"
        )),
        Ok(()) => {}
    }
    let is_same = grid.base.mesh_hash.as_deref() == Some(substrate.mesh_hash());
    let file = grid.base.mesh.take().filter(|_| is_same);
    grid.base.mesh = Some(file.unwrap_or_else(|| portable(mesh)));
    grid.base.mesh_hash = Some(substrate.mesh_hash().to_owned());
    let hashes =
        |mask: &thallus::substrate::Mask| mask.hashes().into_iter().map(str::to_owned).collect();
    grid.base.mask_hash = substrate.mask().map(hashes);
    grid.base.version = Some(env!("CARGO_PKG_VERSION").to_owned());
    Ok(())
}

/// The runs of a grid that was [settled](settle).
pub(super) fn plan(grid: &Grid, substrate: &Substrate) -> Result<Plan, Failure> {
    let file = grid.base.mesh.as_deref().unwrap_or_default();
    Ok(grid.plan(substrate, file)?)
}

/// The command fails when a run did. `again` tries those that can be grown.
pub(super) fn failed(
    plan: &Plan,
    failures: &BTreeMap<usize, String>,
    again: &str,
) -> Result<(), Failure> {
    let Some((_, reason)) = failures.first_key_value() else {
        return Ok(());
    };
    let names: Vec<_> = failures.keys().map(|&run| plan.name(run)).collect();
    let is_possible = |&run: &usize| plan.runs[run].recipe.is_ok();
    let cure = match failures.keys().any(is_possible) {
        true => again,
        false => "other values are another sweep, in another folder",
    };
    Err(Failure::Failed(anyhow::anyhow!(
        "{} failed: {}; the first one: {} ({cure})",
        plural(names.len(), "run", "runs"),
        first_of(&names),
        reason.trim_end_matches('.'),
    )))
}

/// The first names of many.
pub(super) fn first_of(names: &[String]) -> String {
    const NAMED: usize = 8;
    let named = names[..names.len().min(NAMED)].join(", ");
    match names.len() {
        n if n > NAMED => format!("{named} and {} more", n - NAMED),
        _ => named,
    }
}
