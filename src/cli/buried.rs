//! Whether lichens would start where nobody sees them: on a piece of the mesh, inside another one.

use rayon::prelude::*;
use thallus::growth::Solids;
use thallus::substrate::{Substrate, SurfacePoint};

/// Says so, and what to do.
pub(super) fn warning(substrate: &Substrate, seeds: &[SurfacePoint]) -> Option<String> {
    let solids = Solids::of(substrate);
    let hidden = seeds.par_iter().filter(|at| solids.hide(at));
    let who = match (hidden.count(), seeds.len()) {
        (0, _) => return None,
        (1, 1) => "the lichen starts".to_owned(),
        (some, all) => {
            let start = if some == 1 { "starts" } else { "start" };
            format!("{some} of {all} colonies {start}")
        }
    };
    Some(format!(
        "{who} inside another piece of the mesh: unless that is a room, give a place that is seen with --at ('highest', \
         or X,Y,Z), or make the pieces one surface (in Blender: the Remesh modifier)"
    ))
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
        let settings = Settings {
            at: Some(vec![SeedPlace::Point(at)]),
            ..Settings::default()
        };
        let recipe = settings.resolve(substrate, "").unwrap();
        let seeds = recipe.seeds(substrate).unwrap();
        warning(substrate, &seeds).is_some()
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
}
