//! Whether lichens would start where nobody sees them: on a piece of the mesh, inside another one.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;
use thallus::growth::SeedPlace;
use thallus::run::Recipe;
use thallus::substrate::{Component, Substrate, SurfacePoint};

/// Seeds that are looked at: of each, the solid angles of all triangles about it are added up.
const MOST_SEEDS: usize = 100;

/// Says so, and what to do.
pub(super) fn warning(
    substrate: &Substrate,
    recipe: &Recipe,
    seeds: &[SurfacePoint],
) -> Option<String> {
    if substrate.components().len() == 1 {
        return None;
    }
    let looked_at = &seeds[..seeds.len().min(MOST_SEEDS)];
    let buried = looked_at.par_iter().filter(|at| is_buried(substrate, at));
    let who = match (buried.count(), looked_at.len()) {
        (0, _) => return None,
        (1, 1) => "the lichen starts".to_owned(),
        (some, all) => {
            let first = if all < seeds.len() { "the first " } else { "" };
            let start = if some == 1 { "starts" } else { "start" };
            format!("{some} of {first}{all} colonies {start}")
        }
    };
    let places = match recipe.at.contains(&SeedPlace::Random) {
        true => "give places that are seen with --at (X,Y,Z)",
        false => "give a place that is seen with --at ('highest', or X,Y,Z)",
    };
    Some(format!(
        "{who} inside another piece of the mesh: unless that is a room, {places}, or make the pieces one surface (in \
         Blender: the Remesh modifier)"
    ))
}

fn is_buried(substrate: &Substrate, at: &SurfacePoint) -> bool {
    let place = substrate.position(at);
    let own = substrate.component_of(at.triangle);
    let mut others = substrate.components().iter();
    others.any(|piece| piece != own && is_inside(substrate, piece, place))
}

/// Whether a place is inside a piece that is closed, or nearly so, whichever way it is wound: by its winding number
/// (Jacobson, Kavan, Sorkine-Hornung 2013), the sum of the solid angles of its triangles (Van Oosterom, Strackee 1983).
fn is_inside(substrate: &Substrate, piece: &Component, place: DVec3) -> bool {
    let [low, high] = piece.bounds;
    if place.cmplt(low).any() || place.cmpgt(high).any() {
        return false;
    }
    let angle = |t| {
        let [a, b, c] = substrate.corners(t).map(|corner| corner - place);
        let side = substrate.normal(t).dot((b - a).cross(c - a)).signum();
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * side * a.dot(b.cross(c)).atan2(below)
    };
    let winding: f64 = piece.triangles.clone().map(angle).sum::<f64>() / (4.0 * PI);
    winding.abs() > 0.5
}

#[cfg(test)]
mod tests {
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
        warning(substrate, &recipe, &seeds).is_some()
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
