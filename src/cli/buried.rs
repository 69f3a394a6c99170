//! Whether lichens would start, or have grown, where nobody sees them: on a piece of the mesh, inside or under another
//! one.

use rayon::prelude::*;
use thallus::cluster::Cluster;
use thallus::growth::Solids;
use thallus::run::EXPOSED;
use thallus::substrate::{Mask, Substrate, SurfacePoint};

use super::number::percent;

/// Says so, and what to do.
pub(super) fn warnings(substrate: &Substrate, seeds: &[SurfacePoint]) -> Vec<String> {
    let solids = Solids::of(substrate);
    let (inside, outside): (Vec<SurfacePoint>, Vec<SurfacePoint>) =
        seeds.par_iter().partition(|at| solids.hide(at));
    let under = outside.par_iter().filter(|at| solids.is_under(at));
    let (all, cure) = (seeds.len(), cure(substrate));
    let found = [
        starts(inside.len(), all).map(|who| {
            format!("{who} inside another piece of the mesh: unless that is a room, {cure}")
        }),
        starts(under.count(), all)
            .map(|who| format!("{who} close under another piece of the mesh: {cure}")),
    ];
    found.into_iter().flatten().collect()
}

/// What to do; what is said to be exposed has been looked for already.
fn cure(substrate: &Substrate) -> &'static str {
    match substrate.mask().is_some_and(Mask::asks_for_exposed) {
        true => "give a place that is seen with --at ('highest', or X,Y,Z)",
        false => {
            "give a place that is seen with --at ('highest', or X,Y,Z), say --mask exposed, or make the pieces one surface \
             (in Blender: the Remesh modifier)"
        }
    }
}

/// Elements that are looked at, evenly among all.
const LOOKED_AT: usize = 2000;

/// A share of these is told of from here on.
const MANY: f64 = 0.01;

/// Says how much of a lichen has grown there, unless that is little.
pub(super) fn told(substrate: &Substrate, cluster: &Cluster) -> Option<String> {
    if substrate.mask().is_some_and(Mask::asks_for_exposed) {
        return None;
    }
    let (all, solids) = (cluster.elements(), Solids::of(substrate));
    let some = all.len().min(LOOKED_AT);
    let radius = substrate.units().length_to_file(cluster.radius());
    let looked_at = (0..some)
        .into_par_iter()
        .map(|i| &all[i * all.len() / some].at);
    let buried = looked_at.filter(|at| solids.bury(at, radius)).count();
    let share = buried as f64 / some.max(1) as f64;
    (share >= MANY).then(|| {
        format!(
            "about {} of the lichen is inside other pieces of the mesh or right beneath them, where nobody sees it: --mask \
             {EXPOSED} keeps it out",
            percent((100.0 * share).round() / 100.0)
        )
    })
}

/// Which of all colonies do.
fn starts(some: usize, all: usize) -> Option<String> {
    match (some, all) {
        (0, _) => None,
        (1, 1) => Some("the lichen starts".to_owned()),
        (1, _) => Some(format!("1 of {all} colonies starts")),
        _ => Some(format!("{some} of {all} colonies start")),
    }
}

#[cfg(test)]
mod tests {
    use thallus::growth::SeedPlace;
    use thallus::run::Settings;
    use thallus::substrate::Soup;

    use super::*;

    /// Cubes by centre and half of their side, the last with or without its lid.
    fn cubes(cubes: &[(f64, f64)], lid: bool) -> Substrate {
        const QUADS: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [1, 3, 7, 5],
            [0, 4, 6, 2],
        ];
        let mut soup = Soup {
            positions: Vec::new(),
            triangles: Vec::new(),
            notes: Vec::new(),
        };
        for (i, &(x, half)) in cubes.iter().enumerate() {
            let first = 8 * i as u32;
            let corner = |k: u32| {
                let [i, j, k] = [k & 1, k >> 1 & 1, k >> 2].map(|bit| 2.0 * f64::from(bit) - 1.0);
                [x + half * i, half * j, half * k]
            };
            soup.positions.extend((0..8).map(corner));
            let open = usize::from(!lid && i + 1 == cubes.len());
            for [a, b, c, d] in QUADS.into_iter().skip(open) {
                let [a, b, c, d] = [a, b, c, d].map(|k| first + k);
                soup.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        Substrate::from_soup(soup).unwrap()
    }

    fn tells(substrate: &Substrate, at: [f64; 3]) -> bool {
        !told(substrate, at).is_empty()
    }

    fn told(substrate: &Substrate, at: [f64; 3]) -> Vec<String> {
        let settings = Settings {
            at: Some(vec![SeedPlace::Point(at)]),
            ..Settings::default()
        };
        let recipe = settings.resolve(substrate, "").unwrap();
        let seeds = recipe.seeds(substrate).unwrap();
        warnings(substrate, &seeds)
    }

    #[test]
    fn a_place_inside_another_piece_is_told_of() {
        let nested = cubes(&[(0.0, 1.0), (0.9, 0.5)], true);
        assert!(tells(&nested, [0.4, 0.0, 0.0]));
        assert!(tells(&nested, [1.0, 0.1, 0.1]));
        assert!(!tells(&nested, [1.4, 0.0, 0.0]));
        assert!(!tells(&nested, [-1.0, 0.0, 0.0]));
        assert!(!tells(&cubes(&[(0.0, 1.0)], true), [1.0, 0.0, 0.0]));
        assert!(!tells(
            &cubes(&[(0.0, 1.0), (3.0, 0.5)], true),
            [1.0, 0.0, 0.0]
        ));
    }

    /// A piece with an opening holds what is deep in it.
    #[test]
    fn a_piece_may_be_open() {
        let cup = cubes(&[(0.0, 0.2), (0.0, 1.0)], false);
        assert!(tells(&cup, [0.2, 0.0, 0.0]));
    }

    /// Cubes in a row of half side 1, this far from face to face: the nearest face is a wall before what lies behind.
    #[test]
    fn a_place_close_under_another_piece_is_told_of() {
        let touching = cubes(&[(0.0, 1.0), (2.0, 1.0)], true);
        assert!(tells(&touching, [1.0, 0.0, 0.0]));
        for (gap, is_told) in [(0.001, true), (0.05, true), (1.0, false)] {
            let row = cubes(&[(0.0, 1.0), (2.0 + gap, 1.0)], true);
            let told = told(&row, [1.0, 0.0, 0.0]);
            assert_eq!(told.len(), usize::from(is_told), "{gap} {told:?}");
            let under = "the lichen starts close under another piece";
            assert!(told.iter().all(|told| told.starts_with(under)), "{told:?}");
            assert!(!tells(&row, [0.0, 1.0, 0.0]), "on the side");
        }
    }

    /// What is near behind a place does not cover it.
    #[test]
    fn what_is_behind_covers_nothing() {
        let plates = cubes(&[(0.0, 1.0), (-2.02, 1.0)], true);
        assert!(!tells(&plates, [1.0, 0.0, 0.0]));
        assert!(tells(&plates, [-1.0, 0.0, 0.0]));
    }
}
