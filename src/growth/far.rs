//! Far jumps on coarser copies of the surface.
//!
//! Most of the edges that a walker crosses lie far from the lichen. There it walks on a copy with
//! fewer triangles, the farther away the fewer, and comes back to the surface before it is near.
//! Contacts, sheets and joining know nothing of it. On a copy bumps are flatter, so far jumps go over
//! them straighter; what that changes in where walkers come to the lichen is measured in
//! `tests/far.rs`.
//!
//! Where a surface is so smooth that a copy with a small share of its triangles hardly strays from it, as flat
//! faces in small triangles are, walkers are on that copy up to the lichen: see [`near`](super::near). If it has few
//! triangles there are no others.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::surroundings::Ground;
use crate::substrate::{Copies, Errors, Frame, Substrate, SurfacePoint};
use crate::walk::{Footing, Stand};

/// How far the finest copy's vertices may stray from the surface, in element radii; those of each coarser one may four
/// times as far as those of the one before.
const ERROR: f64 = 7.5;

/// How far the vertices of a copy to walk on near the lichen too may stray, in element radii. Over
/// bumps a radius wide and more, ways along the surface are longer by the square of that.
const NEAR_ERROR: f64 = 0.02;

/// A place on it stands for one on the surface that is within this many times as much.
const BESIDE: f64 = 4.0;

/// A walker on a copy lands when its bound is less than this many times what the copy may stray: than 60 radii, where
/// that is 7.5. Of a direction's hits on a lichen of 4,000 on a boulder 2 % differ if walkers land at 15 radii, 1.4 %
/// at 30, 0.7 % at 45, and none that can be told at 60 (at most 0.5 %). What that leaves on larger lichens is in
/// `docs/study.md`.
const LAND: f64 = 8.0;

/// Bounds this many times as large as those below which a walker leaves a copy are for that copy.
const LIFT: f64 = 2.0;

/// The cosine of the steepest slope that is seen from above the copy's triangle.
const STEEP: f64 = 0.3;

/// Walks on the surface to a place on the copy, at most.
const MOST_WALKS: usize = 3;

/// Triangles in which the place straight above one on a copy is looked for, at most.
const MOST_TRIANGLES: usize = 16;

/// A length that is round-off, local units: who is so near is there, and would walk again for nothing. Without a
/// direction it is not known either by which edge a step leaves from the border of a triangle.
const NO_LENGTH: f64 = 1e-13;

/// Coarser copies, and when to walk on them.
pub(super) struct Far {
    copies: Arc<Copies>,
    reaches: Vec<Reach>,
    /// How far a place on the copy that hardly strays may be from the one that it stands for.
    beside: f64,
    /// The surface that walkers are on about the lichen.
    ground: Level,
    /// Bounds above this are for coarser ones.
    most_on_ground: f64,
}

/// Which surface a walker is on: the mesh's own, or the copy with this number from 1, the finest
/// first.
pub(super) type Level = usize;

/// The copy that hardly strays, if there is one.
pub(super) const NEAR: Level = 1;

/// Where a copy serves.
struct Reach {
    /// For each triangle, how far from it the places on the surface are that it stands for, at most. None where
    /// that is next to nothing.
    deviations: Vec<f64>,
    /// A walker on the copy with a smaller bound lands.
    land: f64,
    /// One below it with a greater bound comes to it.
    lift: f64,
}

impl Far {
    /// Whether it seems that a copy that hardly strays is worth having, for elements of this radius, local units.
    pub(super) fn would_hardly_stray(substrate: &Substrate, radius: f64) -> bool {
        substrate.is_smooth(NEAR_ERROR * radius)
    }

    /// For elements of this radius, local units; with one that hardly strays, if that is worth having, or without.
    /// None where no copy would be.
    pub(super) fn new(substrate: &Substrate, radius: f64, near: bool) -> Option<Self> {
        let near_error = NEAR_ERROR * radius;
        let copies = substrate.coarser(Errors {
            near: near.then_some(near_error),
            far: ERROR * radius,
        });
        let beside = BESIDE * near_error;
        let mut reaches: Vec<Reach> = Vec::new();
        for copy in &copies.all {
            reaches.push(match copies.has_near && reaches.is_empty() {
                true => Reach {
                    deviations: Vec::new(),
                    land: f64::NEG_INFINITY,
                    lift: radius + beside,
                },
                false => {
                    let finer = reaches.last().map(|reach| reach.deviations.as_slice());
                    let land = LAND * copy.error();
                    Reach {
                        deviations: copy.deviations(finer),
                        land,
                        lift: LIFT * land,
                    }
                }
            });
        }
        let ground = usize::from(copies.has_near);
        (!reaches.is_empty()).then_some(Self {
            most_on_ground: reaches.get(ground).map_or(f64::INFINITY, |next| next.lift),
            copies,
            reaches,
            beside,
            ground,
        })
    }

    /// The bound up to which a walker stays on its level, where that is the surface about the lichen. On others it
    /// is asked for more.
    #[inline]
    pub(super) fn stays_to(&self, level: Level) -> f64 {
        match level == self.ground {
            true => self.most_on_ground,
            false => f64::NEG_INFINITY,
        }
    }

    /// Whether a level is a copy that hardly strays, where lichen is touched as on the surface.
    #[inline]
    pub(super) fn is_near(&self, level: Level) -> bool {
        level == NEAR && self.copies.has_near
    }

    /// The component of the copy that hardly strays that stands for one of the surface.
    pub(super) fn component_of_copy(&self, triangles: &Range<u32>) -> Range<u32> {
        let copy = &self.copies.all[0];
        let of_first = copy.stand_ins()[triangles.start as usize];
        copy.surface().component_of(of_first).triangles.clone()
    }

    /// The copy that hardly strays.
    pub(super) fn near(&self) -> Ground<'_> {
        let copy = &self.copies.all[0];
        Ground {
            surface: copy.surface(),
            stand_ins: Some(copy.stand_ins()),
        }
    }

    /// The surface to walk on.
    #[inline]
    pub(super) fn surface<'a>(&'a self, level: Level, substrate: &'a Substrate) -> &'a Substrate {
        match level {
            0 => substrate,
            _ => self.copies.all[level - 1].surface(),
        }
    }

    /// How far from a triangle of this level the places on the surface are that it stands for, at most.
    pub(super) fn deviation(&self, level: Level, triangle: u32) -> f64 {
        match level {
            0 => 0.0,
            _ => {
                let deviations = &self.reaches[level - 1].deviations;
                deviations.get(triangle as usize).copied().unwrap_or(0.0)
            }
        }
    }

    /// Bounds below this are for a finer level.
    pub(super) fn least(&self, level: Level) -> f64 {
        match level {
            0 => f64::NEG_INFINITY,
            _ => self.reaches[level - 1].land,
        }
    }

    /// Bounds above this are for the next coarser level.
    pub(super) fn most(&self, level: Level) -> f64 {
        let next = self.reaches.get(level);
        next.map_or(f64::INFINITY, |next| next.lift)
    }

    /// From a level to the next coarser one. None where the one that hardly strays is not near.
    pub(super) fn lifted(&self, level: Level, here: &Stand) -> Option<Footing> {
        let copy = &self.copies.all[level];
        let facet = copy
            .surface()
            .facet(copy.stand_ins()[here.triangle as usize]);
        let below = facet.frame.flatten(here.position);
        let there = match facet.chart.contains(below) {
            true => Footing::new(facet, below),
            // The triangle ends before it is straight below.
            false => {
                let nearest = copy.surface().nearest_in(facet.triangle, here.position);
                let begin = Footing::new(facet, facet.chart.place(nearest.weights()));
                walk_to(copy.surface(), begin, here.position)
            }
        };
        let aside = there.stand.position.distance(here.position);
        (!self.is_near(level + 1) || aside <= self.beside).then_some(there)
    }

    /// The same as [`landed`](Self::landed) for whoever has no facet at hand, and needs none.
    pub(super) fn landed_from(
        &self,
        level: Level,
        substrate: &Substrate,
        here: &Stand,
    ) -> Option<Stand> {
        let here = Footing::of(*here, self.surface(level, substrate));
        Some(self.landed(level, substrate, &here)?.stand)
    }

    /// From a copy to the next finer level, straight up or down by the copy's triangle, from a triangle near there.
    pub(super) fn landed(
        &self,
        level: Level,
        substrate: &Substrate,
        here: &Footing,
    ) -> Option<Footing> {
        let Footing {
            stand,
            facet: above,
        } = here;
        let triangle = self.copies.all[level - 1].below(above, stand.at);
        if triangle == u32::MAX {
            return None;
        }
        let finer = self.surface(level - 1, substrate);
        let middle = || {
            let facet = finer.facet(triangle);
            Footing::new(facet, facet.chart.place([1.0 / 3.0; 3]))
        };
        let there = straight_from(finer, triangle, stand.position, &above.frame)
            .unwrap_or_else(|| walk_above(finer, middle(), stand.position, &above.frame));
        let aside = there.stand.position.distance(stand.position);
        match self.is_near(level) {
            true => (aside <= self.beside).then_some(there),
            false if aside <= self.deviation(level, above.triangle) + NO_LENGTH => Some(there),
            // Under an overhang what is straight above is not what the triangle stands for.
            false => Some(walk_to(finer, middle(), stand.position)),
        }
    }
}

/// The surface that walkers set out on from the launch sphere's arcs: the copy that hardly strays, if there is one.
pub(super) fn outset<'a>(far: Option<&'a Far>, substrate: &'a Substrate) -> (Level, &'a Substrate) {
    match far.filter(|far| far.copies.has_near) {
        Some(far) => (1, far.near().surface),
        None => (0, substrate),
    }
}

/// The place on the surface that one on a copy stands for.
pub(super) fn on_mesh(
    far: Option<&Far>,
    substrate: &Substrate,
    level: Level,
    there: &Stand,
) -> Option<SurfacePoint> {
    let down = |here: Stand, level| far?.landed_from(level, substrate, &here);
    let on_mesh = (1..=level).rev().try_fold(*there, down)?;
    Some(on_mesh.surface_point(substrate))
}

/// Short walks over a surface, each towards a place, as long as they lead nearer.
fn walk_to(surface: &Substrate, there: Footing, to: DVec3) -> Footing {
    walk(surface, there, |there| {
        let onward = to - there.stand.position;
        (there.facet.frame.turned(onward), onward.length_squared())
    })
}

/// The place straight above or below one in a plane, looked for from triangle to triangle. None where the surface
/// is steep or ends, or the place is many triangles away, and where the first is wound the other way.
///
/// A walker comes to a copy straight down on its triangle, so that a round trip returns to the starting point. The
/// nearest place would be another one on a slope, each time farther towards where the two surfaces meet.
fn straight_from(
    surface: &Substrate,
    mut triangle: u32,
    from: DVec3,
    plane: &Frame,
) -> Option<Footing> {
    let mut up = plane.x.cross(plane.y);
    for _ in 0..MOST_TRIANGLES {
        let flat = surface.unscaled(triangle);
        let there = flat.pierced(from, up, STEEP)?;
        let Some(edge) = flat.edge_towards(there) else {
            return Some(Footing::on(&flat, there));
        };
        let twin = surface.twin(3 * triangle + edge);
        let is_open = twin.half_edge() / 3 == triangle;
        if is_open {
            return None;
        }
        if twin.is_flipped() {
            up = -up;
        }
        triangle = twin.half_edge() / 3;
    }
    None
}

/// Short walks towards [the place straight above or below](straight_from) one in a plane, as far as there is one where
/// the surface is steep.
fn walk_above(surface: &Substrate, there: Footing, from: DVec3, plane: &Frame) -> Footing {
    let up = plane.x.cross(plane.y);
    walk(surface, there, |there| {
        let frame = &there.facet.frame;
        let straight = from - there.stand.position;
        let aside = straight - up * straight.dot(up);
        let normal = frame.x.cross(frame.y);
        let steep = normal.dot(up);
        // The way in the triangle's own plane that is this way when seen from above.
        let slope = if steep > STEEP {
            aside.dot(normal) / steep
        } else {
            0.0
        };
        (frame.turned(aside - up * slope), aside.length_squared())
    })
}

/// Short walks over a surface, as long as they lead nearer to where they go: `onward` is that way in a triangle's
/// chart, and how far it is, squared.
fn walk(
    surface: &Substrate,
    mut there: Footing,
    onward: impl Fn(&Footing) -> (DVec2, f64),
) -> Footing {
    let (mut way, mut far) = onward(&there);
    for _ in 0..MOST_WALKS {
        if way.length_squared() < NO_LENGTH * NO_LENGTH {
            break;
        }
        let next = there.after(surface, way);
        let before = far;
        (way, far) = onward(&next);
        if far >= before {
            break;
        }
        there = next;
    }
    there
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::growth::launch::{AreaSampler, LaunchRing};
    use crate::rng::{Purpose, Stream};
    use crate::substrate::{Facet, Soup, load_soup};

    fn boulder() -> (Substrate, Far) {
        let substrate = Substrate::load(Path::new("meshes/boulder.glb")).expect("a mesh");
        let radius = substrate.units().length_to_local(substrate.auto_radius());
        let far = Far::new(&substrate, radius, false).expect("worth having");
        (substrate, far)
    }

    #[test]
    fn copies_have_ever_fewer_triangles_and_serve_ever_larger_bounds() {
        let (substrate, far) = boulder();
        assert_eq!(far.copies.all.len(), 2);
        let mut finer = &substrate;
        for level in 1..=2 {
            let copy = far.surface(level, &substrate);
            assert!(4 * copy.triangles().len() < finer.triangles().len());
            assert!(far.most(level - 1) > far.least(level));
            finer = copy;
        }
        assert_eq!(far.most(2), f64::INFINITY);
    }

    /// As who goes on from a milestone works it out anew.
    fn assert_is_facet_there(footing: &Footing, surface: &Substrate) {
        let facet = surface.facet(footing.stand.triangle);
        let numbers = |facet: &Facet| format!("{facet:?}");
        assert_eq!(numbers(&footing.facet), numbers(&facet));
    }

    /// From what is nearest of the triangle that stands for the place, whether that is straight below or not.
    fn lifted_by_walking(far: &Far, level: Level, here: &Stand) -> Stand {
        let copy = &far.copies.all[level - 1];
        let triangle = copy.stand_ins()[here.triangle as usize];
        let nearest = copy.surface().nearest_in(triangle, here.position);
        let begin = Stand::new(copy.surface(), &nearest);
        walk_to(
            copy.surface(),
            Footing::of(begin, copy.surface()),
            here.position,
        )
        .stand
    }

    #[test]
    fn places_on_copies_stand_for_places_within_the_deviation() {
        let (substrate, far) = boulder();
        let area = AreaSampler::new(&substrate, 0..substrate.triangles().len() as u32);
        let mut stream = Stream::new(1, Purpose::Walker, 0);
        let (mut adrift, mut beyond) = (0, 0);
        for _ in 0..2000 {
            let mut here = Stand::new(&substrate, &area.sample(&mut stream));
            let there = here.position;
            for level in 1..=2 {
                let lifted = far.lifted(level - 1, &here).expect("a place");
                assert_is_facet_there(&lifted, far.surface(level, &substrate));
                let slow = lifted_by_walking(&far, level, &here);
                assert!(slow.position.distance(lifted.stand.position) < 1e-12);
                here = lifted.stand;
                let most = far.deviation(level, here.triangle);
                assert!(here.position.distance(there) <= most);
            }
            for level in [2, 1] {
                // Some triangles of a copy stand for none: nobody lands from there.
                let footing = Footing::of(here, far.surface(level, &substrate));
                let Some(landed) = far.landed(level, &substrate, &footing) else {
                    adrift += 1;
                    break;
                };
                assert_is_facet_there(&landed, far.surface(level - 1, &substrate));
                let landed = landed.stand;
                let aside = landed.position.distance(here.position);
                let most = far.deviation(level, here.triangle);
                assert!(aside <= 2.0 * most, "{aside} aside, level {level}");
                beyond += usize::from(aside > most);
                here = landed;
            }
        }
        assert!(adrift < 40, "{adrift} of 2000");
        // What is nearest to a place may be one that the triangle beside stands for.
        assert!(beyond < 20, "{beyond} of 4000");
    }

    /// A place on the boulder's first copy, and the triangle from which the place below is looked for.
    fn place_on_copy(substrate: &Substrate, far: &Far, stream: &mut Stream) -> (Footing, u32) {
        let copy = far.surface(1, substrate);
        let area = AreaSampler::new(copy, 0..copy.triangles().len() as u32);
        let mut place = || {
            let there = Footing::of(Stand::new(copy, &area.sample(stream)), copy);
            (there, far.copies.all[0].below(&there.facet, there.stand.at))
        };
        // Some triangles of a copy stand for none.
        let some = std::iter::repeat_with(&mut place).find(|place| place.1 != u32::MAX);
        some.expect("one that stands for some")
    }

    /// How high above a place in a plane a triangle is, if it is straight above or below.
    fn height(corners: [DVec3; 3], from: DVec3, up: DVec3) -> Option<f64> {
        let [a, b, c] = corners.map(|corner| corner - from);
        let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|area| area.dot(up));
        let sum: f64 = volumes.iter().sum();
        let weights = volumes.map(|volume| volume / sum);
        let there = a * weights[0] + b * weights[1] + c * weights[2];
        weights.iter().all(|w| *w >= 0.0).then(|| there.dot(up))
    }

    #[test]
    fn what_is_straight_below_is_the_surface_where_it_is_nearest_that_way() {
        let (substrate, far) = boulder();
        let mut stream = Stream::new(7, Purpose::Walker, 0);
        let (mut none, mut other) = (0, 0);
        for _ in 0..400 {
            let (Footing { stand, facet }, triangle) = place_on_copy(&substrate, &far, &mut stream);
            let from = stand.position;
            let Some(below) = straight_from(&substrate, triangle, from, &facet.frame) else {
                none += 1;
                continue;
            };
            assert_is_facet_there(&below, &substrate);
            let up = facet.frame.x.cross(facet.frame.y);
            let way = below.stand.position - from;
            assert!(
                (way - up * way.dot(up)).length() < 1e-12,
                "{way} along {up}"
            );
            let all = 0..substrate.triangles().len() as u32;
            let heights = all.filter_map(|t| height(substrate.corners(t), from, up));
            let nearest = heights.fold(f64::INFINITY, |least, h| least.min(h.abs()));
            other += usize::from((way.dot(up).abs() - nearest).abs() > 1e-12);
        }
        assert!(none < 20, "nothing below {none} of 400");
        assert!(other < 4, "{other} of 400 are on another fold");
    }

    /// The boulder with every other triangle wound the other way.
    fn turned_boulder() -> Substrate {
        let loaded = load_soup(Path::new("meshes/boulder.glb")).expect("a mesh");
        let mut soup = loaded.soup;
        let turned = soup.triangles.iter_mut().step_by(2);
        turned.for_each(|corners| corners.swap(1, 2));
        Substrate::from_soup(soup).expect("a mesh")
    }

    #[test]
    fn it_is_the_same_however_triangles_are_wound() {
        let ((substrate, far), turned) = (boulder(), turned_boulder());
        let mut stream = Stream::new(8, Purpose::Walker, 0);
        let (mut found, mut turns) = (0, 0);
        for _ in 0..400 {
            let (Footing { stand, facet }, triangle) = place_on_copy(&substrate, &far, &mut stream);
            let middle = |of: &Substrate, t| of.corners(t).into_iter().sum::<DVec3>();
            let here = middle(&substrate, triangle);
            let away = |t: &u32| middle(&turned, *t).distance_squared(here);
            let all = 0..turned.triangles().len() as u32;
            let same = all
                .min_by(|a, b| away(a).total_cmp(&away(b)))
                .expect("some");
            let below = |on, triangle| straight_from(on, triangle, stand.position, &facet.frame);
            let normal = |of: &Substrate, t| {
                let [a, b, c] = of.corners(t);
                (b - a).cross(c - a)
            };
            let is_turned = normal(&substrate, triangle).dot(normal(&turned, same)) < 0.0;
            match (below(&substrate, triangle), below(&turned, same)) {
                (Some(one), Some(other)) => {
                    assert!(one.stand.position.distance(other.stand.position) < 1e-12);
                    turns += usize::from(one.stand.triangle != triangle);
                    found += 1;
                }
                (one, None) => assert!(one.is_none() || is_turned),
                (None, Some(_)) => panic!("found only on the one that is turned"),
            }
        }
        assert!(found > 150 && turns > 80, "{turns} of {found} in another");
    }

    #[test]
    fn who_goes_to_a_copy_and_back_is_where_he_was() {
        let (substrate, far) = boulder();
        let radius = substrate.units().length_to_local(substrate.auto_radius());
        let area = AreaSampler::new(&substrate, 0..substrate.triangles().len() as u32);
        let mut stream = Stream::new(3, Purpose::Walker, 0);
        let mut moved: Vec<f64> = (0..4000)
            .map(|_| {
                let here = Stand::new(&substrate, &area.sample(&mut stream));
                let there = far.lifted(0, &here).expect("a place");
                let back = far.landed(1, &substrate, &there);
                back.map_or(f64::INFINITY, |back| {
                    back.stand.position.distance(here.position) / radius
                })
            })
            .collect();
        moved.sort_by(f64::total_cmp);
        assert!(moved[3600] < 1e-9, "{} r", moved[3600]);
        assert!(moved[3880] < 1.0, "{} r", moved[3880]);
    }

    /// On an edge round-off says whether a place is still in its triangle.
    #[test]
    fn who_is_there_already_goes_nowhere_from_an_edge_either() {
        let cube = cubes(&[1.0], 5);
        for t in 0..cube.triangles().len() as u32 {
            for weights in (0..=8).map(|k| [f64::from(k), f64::from(8 - k), 0.0]) {
                let edges = [0, 1, 2].map(|first| {
                    let mut weights = weights;
                    weights.rotate_left(first);
                    weights
                });
                for edge in edges {
                    let here = Stand::new(&cube, &SurfacePoint::from_weights(t, edge));
                    let footing = Footing::of(here, &cube);
                    let there = walk_to(&cube, footing, here.position).stand;
                    assert_eq!(there.position, here.position, "{t} {edge:?}");
                }
            }
        }
    }

    /// Adds a flat square cut into so many along its sides, whose corners lie at places along these.
    fn add_square(soup: &mut Soup, squares: u32, place: impl Fn([f64; 2]) -> [f64; 3]) {
        let at = |corner: [u32; 2]| place(corner.map(|k| f64::from(k) / f64::from(squares)));
        for (i, j) in (0..squares).flat_map(|i| (0..squares).map(move |j| (i, j))) {
            let first = soup.positions.len() as u32;
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            soup.positions.extend(corners.map(at));
            let halves = [[0, 1, 2], [0, 2, 3]];
            soup.triangles.extend(halves.map(|t| t.map(|k| first + k)));
        }
    }

    /// Cubes beside each other with sides of these lengths, each face cut into so many squares along its sides.
    fn cubes(sides: &[f64], squares: u32) -> Substrate {
        let mut soup = Soup::default();
        for (&side, beside) in sides.iter().zip(0..) {
            for face in 0..6 {
                let height = if face < 3 { side } else { -side } / 2.0;
                add_square(&mut soup, squares, |[i, j]| {
                    let mut p = [side * (i - 0.5), side * (j - 0.5), height];
                    p.rotate_left(face % 3);
                    p[0] += 2.0 * f64::from(beside);
                    p
                });
            }
        }
        Substrate::from_soup(soup).expect("a mesh")
    }

    #[test]
    fn flat_faces_have_one_copy_that_hardly_strays_and_places_there_and_back_are_the_same() {
        let cube = cubes(&[1.0], 60);
        let radius = cube.units().length_to_local(cube.auto_radius());
        let far = Far::new(&cube, radius, true).expect("worth having");
        assert!(far.is_near(1) && far.copies.all.len() == 1);
        assert!(16 * far.near().surface.triangles().len() <= cube.triangles().len());
        let area = AreaSampler::new(&cube, 0..cube.triangles().len() as u32);
        let mut stream = Stream::new(2, Purpose::Walker, 0);
        for _ in 0..2000 {
            let here = Stand::new(&cube, &area.sample(&mut stream));
            let there = far.lifted(0, &here).expect("beside");
            assert!(there.stand.position.distance(here.position) < 1e-9 * radius);
            let back = far.landed(1, &cube, &there).expect("beside");
            assert!(back.stand.position.distance(here.position) < 1e-9 * radius);
        }
    }

    #[test]
    fn the_launch_sphere_cuts_that_copy_as_it_does_the_faces() {
        let cubes = cubes(&[0.8, 1.0, 0.9], 60);
        let radius = cubes.units().length_to_local(cubes.auto_radius());
        let far = Far::new(&cubes, radius, true).expect("worth having");
        let (level, copy) = outset(Some(&far), &cubes);
        assert_eq!((level, outset(None, &cubes).0), (1, 0));
        assert_eq!(cubes.components().len(), 3);
        for component in cubes.components() {
            let component = &component.triangles;
            let centre = cubes.position(&SurfacePoint::from_weights(component.start, [1.0; 3]));
            let length = |surface, triangles| {
                LaunchRing::new(surface, &[triangles], centre, 40.0 * radius).length()
            };
            let on_mesh = length(&cubes, component.clone());
            let on_copy = length(copy, far.component_of_copy(component));
            assert!(on_mesh > 40.0 * radius);
            assert!((on_copy / on_mesh - 1.0).abs() < 1e-9);
        }
    }

    /// Sheets in one place that share their corners only have no such copy. Some way apart they have, on which
    /// each stands for itself.
    #[test]
    fn a_piece_does_not_stand_for_another() {
        let near = |apart: f64| {
            let mut soup = Soup::default();
            for (squares, height) in [(150, 0.0), (149, apart)] {
                add_square(&mut soup, squares, |[i, j]| [i, j, height]);
            }
            let sheets = Substrate::from_soup(soup).expect("a mesh");
            assert_eq!(sheets.components().len(), 2);
            let radius = sheets.units().length_to_local(sheets.auto_radius());
            let far = Far::new(&sheets, radius, true).filter(|far| far.is_near(1));
            (sheets, far)
        };
        assert!(near(0.0).1.is_none());
        let (sheets, far) = near(0.2);
        let far = far.expect("worth having");
        let stand_ins = far.copies.all[0].stand_ins();
        for component in sheets.components() {
            let mut triangles = component.triangles.clone();
            let of_copy = far.component_of_copy(&triangles);
            assert!(triangles.all(|t| of_copy.contains(&stand_ins[t as usize])));
        }
    }

    #[test]
    fn rough_surfaces_have_none_that_hardly_strays() {
        let (substrate, far) = boulder();
        let radius = substrate.units().length_to_local(substrate.auto_radius());
        let both = Far::new(&substrate, radius, true).expect("worth having");
        assert!(!both.is_near(1));
        assert_eq!(both.copies.all.len(), far.copies.all.len());
    }
}
