//! The index against brute force.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::cluster::NO_PARENT;
use crate::rng::{Purpose, Stream};
use crate::substrate::SurfacePoint;

const RADIUS: f64 = 0.002;

/// Points that crowd about the origin, on no surface in particular.
fn random_point(stream: &mut Stream, spread: f64) -> DVec3 {
    let p = stream.in_unit_disc() * spread;
    let height = 0.02 * (9.0 * p.x).sin() + 0.001 * stream.uniform();
    DVec3::new(p.x, p.y, height)
}

/// An element at a place in space, on a triangle of no surface in particular.
fn element(position: DVec3) -> Element {
    Element {
        at: SurfacePoint::centroid(0),
        position,
        parent: NO_PARENT,
        colony: 0,
        probability: 1.0,
    }
}

fn nearest(elements: &[Element], p: DVec3) -> f64 {
    let distances = elements.iter().map(|e| e.position.distance(p));
    distances.fold(f64::INFINITY, f64::min)
}

fn empty() -> SparseIndex {
    let corner = DVec3::new(1.0, 1.0, 0.1);
    SparseIndex::new(RADIUS, Some(10.0 * RADIUS), [-corner, corner])
}

/// What an index must never get wrong, and how good its bounds are: the mean of bound over
/// distance where that is several radii.
fn judge(index: &SparseIndex, elements: &[Element], notes: &mut Notes, stream: &mut Stream) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    index.begin(elements.len(), notes, false);
    for i in 0..300 {
        let p = random_point(stream, [0.9, 0.3, 0.1][i % 3]);
        // As a walker does, look again nearby, so that all grids get asked.
        for step in [0.0, 0.05, 0.01, 0.002] {
            let p = p + (stream.in_unit_disc() * step).extend(0.0);
            let (look, nearest) = (index.look(&elements.into(), p, notes), nearest(elements, p));
            assert!(look.clear <= nearest * (1.0 + 1e-12));
            assert_eq!(look.touching, nearest < 2.0 * RADIUS, "{nearest}");
            let touched = index.any_touching(&elements.into(), p, notes, &mut |_, _| true);
            assert_eq!(touched, look.touching);
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
    let (mut index, mut notes, mut elements) = (empty(), Notes::default(), Vec::new());
    for births in [1, 9, 90, 900, 2000] {
        for _ in 0..births {
            elements.push(element(random_point(&mut stream, 0.2)));
            index.add(&(&elements).into());
        }
        let quality = judge(&index, &elements, &mut notes, &mut stream);
        assert!(quality > 0.92, "bounds of {quality} of the distance");
        index.adopt(&(&elements).into(), &mut notes);
    }
}

#[test]
fn crowds_hide_no_older_centre() {
    let mut stream = Stream::new(2, Purpose::Walker, 0);
    let place = |stream: &mut Stream, radii: f64| {
        let aside = stream.in_unit_disc() * radii;
        aside.extend(stream.uniform()) * RADIUS
    };
    for _ in 0..40 {
        let (mut index, mut notes, mut elements) = (empty(), Notes::default(), Vec::new());
        let crowd = place(&mut stream, 4.0);
        for birth in 0..46 {
            let position = match birth {
                0..6 => place(&mut stream, 5.0),
                _ => crowd + place(&mut stream, 0.5),
            };
            elements.push(element(position));
            index.add(&(&elements).into());
        }
        // The second time all blocks are there.
        for _ in 0..2 {
            index.begin(elements.len(), &mut notes, false);
            for _ in 0..200 {
                let p = place(&mut stream, 6.0);
                let touching = index.look(&(&elements).into(), p, &mut notes).touching;
                assert_eq!(touching, nearest(&elements, p) < 2.0 * RADIUS);
            }
            index.adopt(&(&elements).into(), &mut notes);
        }
    }
}

/// A place at the end of a block may be said to be in the next one, and what touches it then is asked of that.
#[test]
fn contacts_agree_at_the_ends_of_blocks() {
    let mut stream = Stream::new(15, Purpose::Walker, 0);
    let beside = [0.0, 1e-9, 1.0 / 512.0, 1.0 / 256.0, 0.003, 0.006];
    let apart = [1e-9, 1e-4, 1e-3, 0.004, 0.01, 0.05];
    let mut touching = 0;
    for i in 0..4_000 {
        let (mut index, mut notes) = (empty(), Notes::default());
        let Scale { low, inverse, .. } = index.scale;
        let mut signed = |all: &[f64; 6]| {
            let one = all[(6.0 * stream.uniform()) as usize];
            if stream.uniform() < 0.5 { one } else { -one }
        };
        let mut place = DVec3::new(502.0, 481.0, 63.0);
        // One axis, two or all three.
        for axis in 0..=i % 3 {
            place[(i + axis) % 3] =
                4.0 * (place[(i + axis) % 3] / 4.0).round() - 0.5 + signed(&beside);
        }
        let distance = 2.0 + signed(&apart);
        let along = match i % 2 {
            0 => DVec3::AXES[i / 2 % 3],
            _ => DVec3::from([0; 3].map(|_| stream.uniform() - 0.5)).normalize(),
        };
        let [p, q] = [place, place + along * distance].map(|p| low + p / inverse);
        let elements = vec![element(q)];
        index.add(&(&elements).into());
        // The second time its block is there.
        for _ in 0..2 {
            index.begin(1, &mut notes, false);
            for _ in 0..3 {
                let look = index.look(&(&elements).into(), p, &mut notes);
                assert_eq!(
                    look.touching,
                    p.distance(q) < 2.0 * RADIUS,
                    "{place} {along} {distance}"
                );
                let touched =
                    index.any_touching(&(&elements).into(), p, &mut notes, &mut |_, _| true);
                assert_eq!(touched, look.touching);
                touching += usize::from(look.touching);
            }
            index.adopt(&(&elements).into(), &mut notes);
        }
    }
    assert!((8_000..16_000).contains(&touching), "{touching}");
}

/// Whether a block is there may depend on other walkers: what is said of a place may not, even between two parts of a
/// radius, where round-off decides which it is in.
#[test]
fn a_look_says_the_same_before_and_after_a_block_is_kept() {
    let mut stream = Stream::new(16, Purpose::Walker, 0);
    let mut near = 0;
    for _ in 0..2_000 {
        let (mut index, mut notes) = (empty(), Notes::default());
        let Scale { low, inverse, .. } = index.scale;
        let between = |x: f64| ((x * 128.0).floor() + 0.5) / 128.0;
        let mut away = || between(12.0 * stream.uniform() - 6.0);
        let q = DVec3::new(502.0, 481.0, 63.0);
        let [p, q] = [q + DVec3::new(away(), away(), away()), q].map(|p| low + p / inverse);
        let elements = vec![element(q)];
        index.add(&(&elements).into());
        let said = [(); 2].map(|()| {
            index.begin(1, &mut notes, false);
            let looks = [(); 3].map(|()| index.look(&(&elements).into(), p, &mut notes));
            index.adopt(&(&elements).into(), &mut notes);
            looks[2]
        });
        assert_eq!(said[0], said[1]);
        near += usize::from(said[0].clear > 3.0 * RADIUS);
    }
    assert!(near > 500, "{near}");
}

#[test]
fn blocks_made_late_are_those_made_early() {
    let mut stream = Stream::new(2, Purpose::Walker, 0);
    let births = (0..1500).map(|_| element(random_point(&mut stream, 0.1)));
    let births: Vec<Element> = births.collect();
    let places: Vec<DVec3> = (0..400).map(|_| random_point(&mut stream, 0.2)).collect();
    let (mut early, mut late) = (empty(), empty());
    let mut notes = Notes::default();
    for n in 0..births.len() {
        let before = &births[..n];
        early.begin(n, &mut notes, false);
        places[..20].iter().for_each(|&q| {
            early.look(&before.into(), q, &mut notes);
        });
        early.adopt(&before.into(), &mut notes);
        early.add(&births[..=n].into());
        late.add(&births[..=n].into());
    }
    let (mut of_early, mut of_late) = (Notes::default(), Notes::default());
    early.begin(births.len(), &mut of_early, false);
    late.begin(births.len(), &mut of_late, false);
    for &q in &places {
        let [early, late] = [(&early, &mut of_early), (&late, &mut of_late)]
            .map(|(index, notes)| index.look(&(&births).into(), q, notes));
        assert_eq!(early, late);
    }
}

#[test]
fn balls_hold_what_brute_force_finds() {
    let mut stream = Stream::new(3, Purpose::Walker, 0);
    let (mut index, mut elements) = (empty(), Vec::new());
    for _ in 0..3000 {
        elements.push(element(random_point(&mut stream, 0.1)));
        index.add(&(&elements).into());
    }
    for i in 0..400 {
        let p = random_point(&mut stream, 0.11);
        let radius = RADIUS * [2.0, 4.0, 7.0, 10.0, 25.0][i % 5];
        let mut found = Vec::new();
        index.within(&(&elements).into(), p, radius, &mut |id, e| {
            found.push((id, e.position));
        });
        found.sort_unstable_by_key(|f| f.0);
        let near = |(i, e): (usize, &Element)| {
            (e.position.distance(p) < radius).then_some((i as u32, e.position))
        };
        let expected: Vec<(u32, DVec3)> = elements.iter().enumerate().filter_map(near).collect();
        assert_eq!(found, expected);
        if radius <= 10.0 * RADIUS {
            let nearly = |e: &&Element| e.position.distance(p) < radius * (1.0 + 1e-5);
            let nearly = elements.iter().filter(nearly).count();
            for enough in [0, 1, expected.len(), expected.len() + 1, 10_000] {
                let most = index.count_bound(&(&elements).into(), p, radius, enough);
                assert!(most >= expected.len());
                assert!(most <= nearly || most < enough);
            }
        }
    }
}

/// Copies of a surface may reach beyond its box, and so may walkers on them.
#[test]
fn bounds_hold_beyond_the_box() {
    let mut stream = Stream::new(4, Purpose::Walker, 0);
    let (mut index, mut elements) = (empty(), Vec::new());
    for _ in 0..300 {
        let p = random_point(&mut stream, 0.1);
        elements.push(element(p + DVec3::new(0.9, 0.9, 0.07)));
        index.add(&(&elements).into());
    }
    let mut notes = Notes::default();
    for far in [0.0, 0.01, 0.1, 1.0, 10.0, 1e4] {
        for way in [DVec3::X, -DVec3::X, DVec3::Z, -DVec3::ONE, DVec3::ONE] {
            index.begin(elements.len(), &mut notes, false);
            let p = DVec3::new(0.9, 0.9, 0.1) + far * way;
            let (look, nearest) = (
                index.look(&(&elements).into(), p, &mut notes),
                nearest(&elements, p),
            );
            assert!(look.clear <= nearest * (1.0 + 1e-12), "{far} along {way}");
            assert_eq!(look.touching, nearest < 2.0 * RADIUS);
        }
    }
}

/// Every byte of every block: one that a birth lowers otherwise than a survey finds would show only
/// now and then in where walkers go, when a run is resumed.
#[test]
fn births_lower_blocks_to_what_a_survey_finds() {
    let mut stream = Stream::new(5, Purpose::Walker, 0);
    let (mut index, mut notes, mut elements) = (empty(), Notes::default(), Vec::new());
    for _ in 0..4000 {
        index.begin(elements.len(), &mut notes, false);
        for _ in 0..8 {
            index.look(
                &(&elements).into(),
                random_point(&mut stream, 0.3),
                &mut notes,
            );
        }
        index.adopt(&(&elements).into(), &mut notes);
        elements.push(element(random_point(&mut stream, 0.25)));
        index.add(&(&elements).into());
    }
    let all = (&elements).into();
    let centres = index.scale.of(&all);
    // The coarsest level has one block, which is there from the beginning.
    let blocks: Vec<usize> = (0..index.tree.top())
        .map(|level| {
            let mut blocks = 0;
            let all = [[0; 3], [u32::MAX; 3]];
            index.tree.visit(level, all, |block, number| {
                let lowered = index.grid(level)[number].all();
                let surveyed = index.survey(level, block, &centres);
                assert_eq!(lowered.0, surveyed.0, "level {level}, block {block:?}");
                blocks += 1;
            });
            blocks
        })
        .collect();
    let enough = blocks[0] > 4000 && blocks[1] > 300 && blocks[2] > 20;
    assert!(enough, "{blocks:?}");
}

#[test]
fn the_widest_balls_are_looked_for_in_wide_cells_whatever_the_radius() {
    let mut stream = Stream::new(12, Purpose::Walker, 0);
    for _ in 0..10_000 {
        let radius = 1e-3 + stream.uniform();
        let widest = radius * (3.0 + 27.0 * stream.uniform());
        let bounds = [DVec3::ZERO, DVec3::splat(40.0 * radius)];
        let index = SparseIndex::new(radius, Some(widest), bounds);
        // The quotient that the cells are made for and this product often differ in the last bit.
        let reach = widest * index.scale.inverse;
        let lists = index.wide.expect("wider than contact");
        assert!(lists.holds(reach), "{widest} at {radius}");
    }
}

/// A walker that others are born beside: where it looked, and what it saw.
struct Seen {
    places: Vec<DVec3>,
    looks: Vec<Look>,
    notes: Notes,
}

/// Eight looks of a walker that knows of some elements. None of those may be missed, whoever is born meanwhile.
fn look_around(index: &SparseIndex, elements: &Population<'_>, stream: &mut Stream) -> Seen {
    let known: Vec<DVec3> = elements.since(0).map(|e| e.position).collect();
    let within = |p: DVec3, radius: f64| known.iter().filter(|q| q.distance(p) < radius).count();
    let mut notes = Notes::default();
    index.begin(elements.len(), &mut notes, true);
    let mut p = random_point(stream, 0.2);
    let (mut places, mut looks) = (Vec::new(), Vec::new());
    for _ in 0..8 {
        let look = index.look(elements, p, &mut notes);
        let nearest = known
            .iter()
            .fold(f64::INFINITY, |least, q| least.min(q.distance(p)));
        assert!(look.clear <= nearest * (1.0 + 1e-12));
        assert!(look.touching || nearest >= 2.0 * RADIUS);
        let wide = 10.0 * RADIUS;
        assert!(index.count_bound(elements, p, wide, 0) >= within(p, wide));
        let (mut found, mut ages) = (0, Vec::new());
        index.within(elements, p, wide, &mut |age, _| {
            found += usize::from((age as usize) < known.len());
            ages.push(age);
        });
        assert_eq!(found, within(p, wide));
        ages.sort_unstable();
        assert!(
            ages.windows(2).all(|two| two[0] < two[1]),
            "one found twice"
        );
        places.push(p);
        looks.push(look);
        p += (stream.in_unit_disc() * 0.01).extend(0.0);
    }
    Seen {
        places,
        looks,
        notes,
    }
}

#[test]
fn who_looks_while_others_are_born_misses_none_that_he_knows_and_can_tell_what_changed() {
    const BIRTHS: usize = 200;
    let mut stream = Stream::new(13, Purpose::Walker, 0);
    let (mut index, mut elements) = (empty(), Vec::new());
    let (mut held, mut disturbed) = (0, 0);
    for round in 0..12 {
        let young: Vec<OnceLock<Element>> = (0..BIRTHS).map(|_| OnceLock::new()).collect();
        let births: Vec<Element> = (0..BIRTHS)
            .map(|_| element(random_point(&mut stream, 0.15)))
            .collect();
        let old = elements.len();
        let born = AtomicUsize::new(old);
        let population = |len: usize| Population::from(&elements).with_young(&young, len);
        index.make_room();
        let (index_now, births_now) = (&index, &births);
        let (looked, mut has_room) = (AtomicUsize::new(0), true);
        let seen: Vec<Seen> = std::thread::scope(|scope| {
            let looks = |reader: u64| {
                let (born, population, looked) = (&born, &population, &looked);
                move || {
                    let mut stream = Stream::new(14 + reader, Purpose::Walker, round);
                    let mut seen = Vec::new();
                    while born.load(Ordering::Acquire) < old + BIRTHS {
                        let known = population(born.load(Ordering::Acquire));
                        seen.push(look_around(index_now, &known, &mut stream));
                        looked.fetch_add(1, Ordering::Relaxed);
                    }
                    seen
                }
            };
            let readers = [0, 1].map(|reader| scope.spawn(looks(reader)));
            for (i, birth) in births_now.iter().enumerate() {
                young[i].get_or_init(|| *birth);
                has_room &= index_now.insert(&population(old + i + 1));
                born.store(old + i + 1, Ordering::Release);
                // However busy the machine is, some look among so many births.
                while looked.load(Ordering::Relaxed) < i / 4
                    && !readers
                        .iter()
                        .any(std::thread::ScopedJoinHandle::is_finished)
                {
                    std::thread::yield_now();
                }
            }
            let seen = readers.map(|reader| reader.join().expect("no panic"));
            seen.into_iter().flatten().collect()
        });
        assert!(has_room, "no room for {BIRTHS} births");
        for Seen {
            places,
            looks,
            notes,
        } in seen
        {
            let all = population(old + BIRTHS);
            if !index.mark(&notes).is_within(&index.held(&all, &notes)) {
                disturbed += 1;
                continue;
            }
            held += 1;
            let mut notes = Notes::default();
            index.begin(all.len(), &mut notes, false);
            let again = places.iter().map(|p| index.look(&all, *p, &mut notes));
            assert!(again.eq(looks), "what was held is seen otherwise now");
        }
        elements.extend(births);
    }
    assert!(held > 20 && disturbed > 20, "{held} held, {disturbed} not");
}
