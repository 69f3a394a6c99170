//! Whether a run fits into memory, told before it starts.

use std::f64::consts::PI;
use std::fs;

use thallus::growth::Join;
use thallus::run::{Recipe, StopRule};
use thallus::substrate::Substrate;

use super::failure::Failure;
use super::number::{count, short};
use super::progress::DIMENSION;
use super::terminal::Voice;

/// Bytes that an element takes at the peak of a run, index and files included. Measured at a million
/// elements: 379 of plain DLA on the plane, which is as sparse as lichen grows, and 371 of packed
/// lichen on the rock. Vectors that grow may take more for a moment.
const BYTES: f64 = 480.0;

/// Runs of so many elements are told what they take.
const LONG: f64 = 1e6;

/// Discs that only touch may lie over one another: this many times as many have room.
const OVERLAP: f64 = 4.0;

/// Tells what a long run takes, and refuses what does not fit.
pub(crate) fn check(substrate: &Substrate, recipe: &Recipe, voice: Voice) -> Result<(), Failure> {
    let elements = expected_elements(substrate, recipe);
    let needed = needed(substrate, recipe);
    let number = count(elements as u64);
    let available = available();
    if let Some(available) = available.filter(|available| needed > *available) {
        return Err(Failure::Failed(anyhow::anyhow!(
            "about {number} elements need {} of memory, and {} are free: ask for fewer, or for a \
             larger --radius",
            size(needed),
            size(available)
        )));
    }
    if elements >= LONG {
        let free = available.map_or_else(String::new, |a| format!(" ({} are free)", size(a)));
        voice.note(&format!(
            "about {number} elements: up to {} of memory{free}; how long it takes is told as it goes",
            size(needed)
        ));
    }
    Ok(())
}

/// Bytes that a run is expected to take at its peak, the mesh aside.
pub(super) fn needed(substrate: &Substrate, recipe: &Recipe) -> f64 {
    BYTES * expected_elements(substrate, recipe)
}

/// About how many elements a run will have.
pub(super) fn expected_elements(substrate: &Substrate, recipe: &Recipe) -> f64 {
    let largest = substrate.components().first().map_or(0.0, |c| c.area);
    let area = substrate.units().area_to_file(largest);
    let cover = area / (PI * recipe.radius * recipe.radius);
    let room = match recipe.join {
        Join::Pack => cover,
        Join::Touch => OVERLAP * cover,
    };
    let asked = match recipe.stop {
        StopRule::Elements(n) => n as f64,
        StopRule::Reach(length) => (length / recipe.radius).powf(DIMENSION),
        StopRule::Cover(share) => share * cover,
    };
    asked.min(room)
}

/// Bytes of memory that are free, where the system says so.
pub(super) fn available() -> Option<f64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find(|line| line.starts_with("MemAvailable:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024.0 * kilobytes)
}

pub(super) fn size(bytes: f64) -> String {
    match bytes {
        ..1e9 => format!("{} MB", (bytes / 1e6).ceil()),
        _ => format!("{} GB", short(bytes / 1e9)),
    }
}
