//! Other lichens on the same mesh: `--also DIR[,COLORMAP]`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rayon::prelude::*;
use thallus::cluster::Cluster;
use thallus::run::shell_path;
use thallus::substrate::{Mask, Substrate};

use super::failure::Failure;
use super::grown::{Grown, Origin};
use super::number::count;
use super::skin_args::ColorArgs;
use super::terminal::Voice;

/// Another lichen, and the colours that it was asked for in.
pub(crate) struct Also {
    /// As it is typed.
    text: String,
    from: PathBuf,
    pub(crate) color: ColorArgs,
    /// Whether it names these itself.
    pub(crate) names_colors: bool,
}

impl Also {
    /// One as it is typed; colours that it does not name are those of the first.
    pub(crate) fn parse(text: &str, first: &ColorArgs) -> Self {
        let (from, own) = match split(text) {
            Some((from, map)) => (from, Some(map.to_owned())),
            None => (text, None),
        };
        Self {
            text: text.to_owned(),
            from: from.into(),
            names_colors: own.is_some(),
            color: ColorArgs {
                colormap: own.or_else(|| first.colormap.clone()),
                ..first.clone()
            },
        }
    }

    /// The lichen, on the mesh of the first.
    pub(crate) fn read(
        &self,
        substrate: &Substrate,
        voice: Voice,
    ) -> Result<(Grown, Cluster), Failure> {
        if self.from.as_os_str().is_empty() {
            return Err(Failure::usage(
                "no folder is named: write DIR or DIR,COLORMAP",
            ));
        }
        let grown = Grown::read(&self.from, voice)?;
        let found = grown.elements.to_cluster_on_turned(substrate);
        let (cluster, _) = found.context("it grew on another mesh than the first")?;
        Ok((grown, cluster))
    }

    /// What is wrong with it, and that it is of this one.
    pub(crate) fn failed(&self, failure: Failure) -> Failure {
        failure.at(format!("--also {}", self.text))
    }
}

/// Says so where a lichen lies on one that it grew beside: that is no longer as it was.
pub(crate) fn tell_of_overlaps<'a>(
    substrate: &Substrate,
    all: impl Iterator<Item = (&'a Origin, &'a Cluster)> + Clone,
    voice: Voice,
) {
    for (origin, cluster) in all.clone() {
        let others = all.clone().filter(|(other, _)| origin.grew_beside(other));
        for (other, first) in others {
            let positions: Vec<_> = first.elements().iter().map(|e| e.position).collect();
            let room = Mask::beside(substrate, &positions, first.radius());
            let radius = cluster.radius() * (1.0 - ROUNDED);
            let lies_on = cluster
                .elements()
                .par_iter()
                .filter(|e| !room.leaves_room(e.position, radius))
                .count();
            if lies_on > 0 {
                let [folder, other] = [&origin.folder, &other.folder].map(|f| shell_path(f));
                voice.warn(&format!(
                    "{folder} grew beside {other}, which is not as it was then: {} of its elements lie on it; grow it \
                     again: thallus grow --recipe {folder} --mask {other} -o, and a new folder",
                    count(lies_on as u64)
                ));
            }
        }
    }
}

/// Of a radius, what a table rounds of positions.
const ROUNDED: f64 = 1e-3;

/// What is there, and the colour map; both may have commas in them.
fn split(text: &str) -> Option<(&str, &str)> {
    let is_there = |from: &str| !from.is_empty() && Path::new(from).exists();
    if is_there(text) {
        return None;
    }
    let commas = text.match_indices(',').map(|(at, _)| at).rev();
    let mut ways = commas.map(|at| (&text[..at], &text[at + 1..]));
    ways.find(|(from, _)| is_there(from))
        .or_else(|| text.split_once(','))
}

#[cfg(test)]
mod tests {
    #[test]
    fn folders_and_colour_maps_may_have_commas() {
        let folder = tempfile::tempdir().unwrap();
        let there = folder.path().join("a,b");
        std::fs::create_dir(&there).unwrap();
        let there = there.to_str().unwrap();
        let split = |rest: &str| {
            let text = format!("{there}{rest}");
            super::split(&text).map(|(from, map)| (from == there, map.to_owned()))
        };
        assert_eq!(split(""), None);
        assert_eq!(split(",xanthoria"), Some((true, "xanthoria".to_owned())));
        let stops = "0:#202020,1:#ffffff";
        assert_eq!(split(&format!(",{stops}")), Some((true, stops.to_owned())));
        assert_eq!(super::split("gone,puce"), Some(("gone", "puce")));
        assert_eq!(super::split(",puce"), Some(("", "puce")));
    }
}
