//! The index against brute force.

use super::*;
use crate::rng::{Purpose, Stream};

const RADIUS: f64 = 0.002;

/// Points that crowd about the origin, on no surface in particular.
fn random_point(stream: &mut Stream, spread: f64) -> DVec3 {
    let p = stream.in_unit_disc() * spread;
    let height = 0.02 * (9.0 * p.x).sin() + 0.001 * stream.uniform();
    DVec3::new(p.x, p.y, height)
}

struct Brute(Vec<DVec3>);

impl Brute {
    fn nearest(&self, p: DVec3) -> f64 {
        let distances = self.0.iter().map(|c| c.distance(p));
        distances.fold(f64::INFINITY, f64::min)
    }
}

fn empty() -> SparseIndex {
    let corner = DVec3::new(1.0, 1.0, 0.1);
    SparseIndex::new(RADIUS, Some(10.0 * RADIUS), [-corner, corner])
}

/// What an index must never get wrong, and how good its bounds are: the mean of bound over
/// distance where that is several radii.
fn judge(index: &SparseIndex, brute: &Brute, notes: &mut Notes, stream: &mut Stream) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for i in 0..300 {
        let p = random_point(stream, [0.9, 0.3, 0.1][i % 3]);
        // As a walker does, look again nearby, so that all grids get asked.
        for step in [0.0, 0.05, 0.01, 0.002] {
            let p = p + (stream.in_unit_disc() * step).extend(0.0);
            let (look, nearest) = (index.look(p, notes), brute.nearest(p));
            assert!(look.clear <= nearest * (1.0 + 1e-12));
            assert_eq!(look.touching, nearest < 2.0 * RADIUS, "{nearest}");
            if nearest > 6.0 * RADIUS {
                (sum, n) = (sum + look.clear / nearest, n + 1.0);
            }
        }
    }
    sum / n
}

#[test]
fn bounds_and_contacts_agree_with_brute_force() {
    let mut stream = Stream::new(1, Purpose::Walker, 0);
    let (mut index, mut notes, mut brute) = (empty(), Notes::default(), Brute(Vec::new()));
    for births in [1, 9, 90, 900, 2000] {
        for _ in 0..births {
            let p = random_point(&mut stream, 0.2);
            index.insert(p);
            brute.0.push(p);
        }
        let quality = judge(&index, &brute, &mut notes, &mut stream);
        assert!(quality > 0.7, "bounds of {quality} of the distance");
        index.adopt(&mut notes);
    }
}

#[test]
fn blocks_made_late_are_those_made_early() {
    let mut stream = Stream::new(2, Purpose::Walker, 0);
    let births: Vec<DVec3> = (0..1500).map(|_| random_point(&mut stream, 0.1)).collect();
    let places: Vec<DVec3> = (0..400).map(|_| random_point(&mut stream, 0.2)).collect();
    let (mut early, mut late) = (empty(), empty());
    let mut notes = Notes::default();
    for &p in &births {
        places[..20].iter().for_each(|&q| {
            early.look(q, &mut notes);
        });
        early.adopt(&mut notes);
        early.insert(p);
        late.insert(p);
    }
    let (mut of_early, mut of_late) = (Notes::default(), Notes::default());
    for &q in &places {
        assert_eq!(early.look(q, &mut of_early), late.look(q, &mut of_late));
    }
}

#[test]
fn balls_hold_what_brute_force_finds() {
    let mut stream = Stream::new(3, Purpose::Walker, 0);
    let (mut index, mut brute) = (empty(), Brute(Vec::new()));
    for _ in 0..3000 {
        let p = random_point(&mut stream, 0.1);
        index.insert(p);
        brute.0.push(p);
    }
    for i in 0..400 {
        let p = random_point(&mut stream, 0.11);
        let radius = RADIUS * [2.0, 4.0, 7.0, 10.0, 25.0][i % 5];
        let mut found = Vec::new();
        index.within(p, radius, &mut |id, q| found.push((id, q)));
        found.sort_unstable_by_key(|f| f.0);
        let near = |(i, &c): (usize, &DVec3)| (c.distance(p) < radius).then_some((i as u32, c));
        let expected: Vec<(u32, DVec3)> = brute.0.iter().enumerate().filter_map(near).collect();
        assert_eq!(found, expected);
        if radius <= 10.0 * RADIUS {
            assert_eq!(index.at_most(p, radius, 0), expected.len());
            for enough in [1, expected.len(), expected.len() + 1, 10_000] {
                let most = index.at_most(p, radius, enough);
                assert!(most == expected.len() || (expected.len()..enough).contains(&most));
            }
        }
    }
}
