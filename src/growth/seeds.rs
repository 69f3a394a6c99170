//! Where the seed elements of several colonies go: without overlapping.

use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;

use super::Habitat;
use super::habitat::Goal;
use super::hidden::Solids;
use super::launch::AreaSampler;
use super::place::{PlaceError, SeedPlace, TRIES, top};
use crate::rng::{Purpose, Stream};
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::{Ball, Connectivity};

impl SeedPlace {
    /// The places of the seed elements of all colonies, whose elements have this radius in local units.
    ///
    /// A random place is drawn again where its element would overlap an older seed's, or cover its whole piece of
    /// the mesh, or is [inside another](Solids::hide), and as seldom kept as a walker sticks in that
    /// [habitat](Habitat::at). `Top` and `Center` are the [nearest place](Habitat::nearest), and `Highest` the highest,
    /// where something may grow, with room about it if there is any (`Top` on the piece with the most habitat, where
    /// the largest has none), and which no other piece [conceals](Solids::conceal) unless that is so wherever something
    /// may grow. Distances are those through space, but elements on two faces of a sheet do not overlap.
    ///
    /// # Errors
    /// As [`locate`](Self::locate); when nothing may grow at a point or in a triangle that was asked for, or nowhere;
    /// when two seeds would overlap, or chance finds no room for one.
    ///
    /// # Panics
    /// When the radius is not a positive finite number.
    pub fn locate_all(
        places: &[Self],
        habitat: &Habitat<'_>,
        seed: u64,
        radius: f64,
    ) -> Result<Vec<SurfacePoint>, PlaceError> {
        assert!(radius > 0.0 && radius.is_finite(), "radius {radius}");
        let substrate = habitat.substrate;
        let mut seeds = Seeds {
            habitat,
            substrate,
            solids: Solids::of(substrate),
            radius,
            tries: 0,
            places: Vec::with_capacity(places.len()),
            cells: HashMap::new(),
            scratch: Connectivity::new(),
        };
        let mut by_area = None;
        for (colony, place) in (0..).zip(places) {
            if *place == Self::Random {
                let sampler = by_area.get_or_insert_with(|| AreaSampler::of_all(substrate));
                seeds.set_tries()?;
                seeds.draw(sampler, Stream::new(seed, Purpose::SeedPlace, colony))?;
            } else {
                let at = place.locate(substrate, seed, colony)?;
                seeds.put(seeds.suited(place, at)?)?;
            }
        }
        Ok(seeds.places)
    }
}

/// Numbers of cubes, which those beside them are counted on from.
const FARTHEST: i64 = 1 << 60;

/// Radii within which something may grow all about a place, for a seed that is free to choose: it may be in a crumb of
/// the habitat, or in a gap of another lichen. The greatest of these for which there are places.
const ROOMS: [f64; 3] = [40.0, LEAST_ROOM, 0.0];

/// With so many it stays where it is.
const LEAST_ROOM: f64 = 10.0;

/// More random places are not drawn for a seed: so many take some seconds.
const MOST_TRIES: f64 = 1e8;

/// The seeds that have their places, oldest first.
struct Seeds<'a> {
    habitat: &'a Habitat<'a>,
    substrate: &'a Substrate,
    solids: Solids<'a>,
    radius: f64,
    /// Random places to draw for each, once it is known how many: [`TRIES`] of them are where chance lets something
    /// grow.
    tries: usize,
    places: Vec<SurfacePoint>,
    /// Their numbers, by cubes as wide as an element.
    cells: HashMap<[i64; 3], Vec<usize>>,
    scratch: Connectivity,
}

impl Seeds<'_> {
    fn set_tries(&mut self) -> Result<(), PlaceError> {
        if self.tries > 0 {
            return Ok(());
        }
        let all = self.substrate.components().iter();
        let chance = self.habitat.chance(all.map(|piece| piece.triangles.start));
        if chance == 0.0 {
            return Err(PlaceError::NoHabitat);
        }
        self.tries = (TRIES as f64 / chance).min(MOST_TRIES) as usize;
        Ok(())
    }

    /// A place that was found for one, if something may grow there. Where it was asked for by its name, and nothing
    /// may, or has no room, or nobody would see it, the best place for that name.
    fn suited(&self, place: &SeedPlace, at: SurfacePoint) -> Result<SurfacePoint, PlaceError> {
        if !matches!(place, SeedPlace::Point(_) | SeedPlace::Triangle { .. }) {
            return self.named(place, at).ok_or(PlaceError::NoHabitat);
        }
        if self.habitat.at(&at) > 0.0 {
            return Ok(at);
        }
        let in_file = |at: SurfacePoint| {
            let units = self.substrate.units();
            units.to_file(self.substrate.position(&at)).to_array()
        };
        Err(PlaceError::Barren {
            place: place.to_string(),
            nearest: self.habitat.nearest(&at, &[0.0]).map(in_file),
        })
    }

    /// Of a place by its name that, or the best instead: with room about it if there is any, in sight if there is any.
    fn named(&self, place: &SeedPlace, at: SurfacePoint) -> Option<SurfacePoint> {
        let room = LEAST_ROOM * self.radius;
        let suits =
            |at: &SurfacePoint| self.habitat.at(at) > 0.0 && self.habitat.has_room(at, room);
        let at = match place {
            SeedPlace::Top if !suits(&at) => self.top_of_habitat(at),
            _ => at,
        };
        if suits(&at) && !self.solids.conceal(&at) {
            return Some(at);
        }
        let goal = match place {
            SeedPlace::Highest => Goal::Summit,
            _ => Goal::Near(at),
        };
        let rooms = ROOMS.map(|radii| radii * self.radius);
        // With less room about it the same places are asked again.
        let asked = RefCell::new(HashMap::new());
        let is_concealed = |at: &SurfacePoint| {
            let key = (at.triangle, at.weights().map(f64::to_bits));
            *{ asked.borrow_mut() }
                .entry(key)
                .or_insert_with(|| self.solids.conceal(at))
        };
        let best = |is_seen: bool| {
            let is_chosen = |at: &SurfacePoint| !is_seen || !is_concealed(at);
            self.habitat.best(&goal, &rooms, is_chosen)
        };
        best(true)
            .or_else(|| suits(&at).then_some(at))
            .or_else(|| best(false))
    }

    /// The top of the mesh, or, where its piece has no habitat, of the piece with the most.
    fn top_of_habitat(&self, at: SurfacePoint) -> SurfacePoint {
        if self.habitat.share([at.triangle].into_iter()) > 0.0 {
            return at;
        }
        let widest = self.habitat.widest_piece();
        widest.map_or(at, |piece| top(self.substrate, piece))
    }

    /// Gives the next one this place.
    fn put(&mut self, at: SurfacePoint) -> Result<(), PlaceError> {
        if let Some((first, distance)) = self.overlapped(&at) {
            let units = self.substrate.units();
            return Err(PlaceError::Overlap {
                first,
                second: self.places.len(),
                distance: units.length_to_file(distance),
                diameter: units.length_to_file(2.0 * self.radius),
            });
        }
        self.push(at);
        Ok(())
    }

    fn push(&mut self, at: SurfacePoint) {
        let cell = self.cell(self.substrate.position(&at));
        self.cells.entry(cell).or_default().push(self.places.len());
        self.places.push(at);
    }

    /// Gives the next one the first random place with room for it that is inside of no other piece. Where there is
    /// none, a place without: whoever asks for the room of an element says which radius would do.
    fn draw(&mut self, sampler: &AreaSampler, mut stream: Stream) -> Result<(), PlaceError> {
        let (mut unseen, mut overlaps) = (None, false);
        for _ in 0..self.tries {
            let at = sampler.sample(&mut stream);
            if !self.suits(&at, &mut stream) {
                continue;
            }
            if self.is_covered(&at) || self.solids.hide(&at) {
                unseen.get_or_insert(at);
            } else if self.overlapped(&at).is_none() {
                self.push(at);
                return Ok(());
            } else {
                overlaps = true;
            }
        }
        match unseen.filter(|_| !overlaps) {
            Some(at) => self.push(at),
            None => {
                let colony = self.places.len();
                return Err(PlaceError::Crowded { colony });
            }
        }
        Ok(())
    }

    /// Whether chance lets something grow at a place.
    fn suits(&self, at: &SurfacePoint, stream: &mut Stream) -> bool {
        match self.habitat.at(at) {
            0.0 => false,
            1.0 => true,
            factor => stream.uniform() < factor,
        }
    }

    /// Whether an element would cover the whole piece of the mesh that a place is on.
    fn is_covered(&self, at: &SurfacePoint) -> bool {
        let piece = self.substrate.component_of(at.triangle);
        PI * self.radius * self.radius >= piece.area
    }

    /// A seed that an element at a place would overlap on the same sheet, and how far from it that is.
    fn overlapped(&mut self, at: &SurfacePoint) -> Option<(usize, f64)> {
        let here = (at.triangle, self.substrate.position(at));
        self.near(here.1).into_iter().find(|&(seed, _)| {
            let other = self.places[seed];
            let there = (other.triangle, self.substrate.position(&other));
            let ball = Ball::of_contact([here.1, there.1], self.radius);
            self.scratch.joined(self.substrate, [here, there], &ball)
        })
    }

    /// The seeds nearer than an element's diameter through space, and how far they are.
    fn near(&self, p: DVec3) -> Vec<(usize, f64)> {
        let [x, y, z] = self.cell(p);
        let beside = |c: i64| c - 1..=c + 1;
        let cells = beside(x).flat_map(|x| beside(y).map(move |y| (x, y)));
        let cells = cells.flat_map(|(x, y)| beside(z).map(move |z| [x, y, z]));
        let seeds = cells.filter_map(|cell| self.cells.get(&cell)).flatten();
        let distance = |&seed: &usize| p.distance(self.substrate.position(&self.places[seed]));
        seeds
            .map(|seed| (*seed, distance(seed)))
            .filter(|(_, distance)| *distance < 2.0 * self.radius)
            .collect()
    }

    fn cell(&self, p: DVec3) -> [i64; 3] {
        (p / (2.0 * self.radius))
            .to_array()
            .map(|x| (x.floor() as i64).clamp(-FARTHEST, FARTHEST))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::substrate::Soup;

    fn load(mesh: &str) -> Substrate {
        Substrate::load(Path::new(mesh)).expect("a mesh")
    }

    /// Counts of seeds by eighths of a plane's area along two axes, of elements so small that none is in the way of
    /// another: chi-square of 7 degrees of freedom is beyond 29.9 once in 10,000.
    #[test]
    fn random_seeds_are_uniform_by_area() {
        let plane = load("meshes/plane.obj");
        let seeds = random(&plane, 4000, 1e-9);
        let [low, high] = plane.bounds();
        let thin = (high - low).min_position();
        for axis in (0..3).filter(|axis| *axis != thin) {
            let mut counts = [0.0; 8];
            for p in &seeds {
                let share = (p[axis] - low[axis]) / (high[axis] - low[axis]);
                counts[((8.0 * share) as usize).min(7)] += 1.0;
            }
            let off = counts.map(|n: f64| (n - 500.0) * (n - 500.0) / 500.0);
            let chi_square = off.iter().sum::<f64>();
            assert!(chi_square < 29.9, "{chi_square}: {counts:?}");
        }
    }

    #[test]
    fn random_seeds_never_overlap() {
        let plane = load("meshes/plane.obj");
        let radius = 0.002 * plane.units().local_diagonal();
        let seeds = random(&plane, 4000, radius);
        for (i, p) in seeds.iter().enumerate() {
            let apart = |q: &DVec3| p.distance(*q) >= 2.0 * radius;
            assert!(seeds[..i].iter().all(apart), "seed {i}");
        }
    }

    fn random(substrate: &Substrate, colonies: usize, radius: f64) -> Vec<DVec3> {
        let places = vec![SeedPlace::Random; colonies];
        let habitat = Habitat::new(substrate, None, 1e-3);
        let seeds = SeedPlace::locate_all(&places, &habitat, 3, radius).expect("room");
        seeds.iter().map(|at| substrate.position(at)).collect()
    }

    /// A large square, and a small one that an element covers.
    #[test]
    fn random_seeds_keep_to_pieces_with_room() {
        let square = |x: f64, side: f64| {
            [[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]].map(|[x, y]| [x, y, 0.0])
        };
        let soup = Soup {
            positions: [square(0.0, 10.0), square(20.0, 3.0)].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            notes: Vec::new(),
        };
        let mesh = Substrate::from_soup(soup).expect("a mesh");
        let on_small = |radius: f64| {
            let radius = mesh.units().length_to_local(radius);
            let large = mesh.components()[0].area;
            let seeds = (1..=100).flat_map(|seed| {
                let habitat = Habitat::new(&mesh, None, 1e-3);
                SeedPlace::locate_all(&[SeedPlace::Random], &habitat, seed, radius)
                    .expect("a place")
            });
            seeds
                .filter(|at| mesh.component_of(at.triangle).area < large)
                .count()
        };
        assert!((1..30).contains(&on_small(0.01)), "both have room");
        assert_eq!(on_small(2.0), 0, "the large one alone has room");
        assert!((1..30).contains(&on_small(6.0)), "neither has room");
    }

    #[test]
    fn a_colony_alone_goes_where_its_place_is() {
        let rock = load("meshes/rock.obj");
        for place in [SeedPlace::Top, SeedPlace::Highest, SeedPlace::Random] {
            let habitat = Habitat::new(&rock, None, 1e-3);
            let alone = SeedPlace::locate_all(std::slice::from_ref(&place), &habitat, 5, 0.01);
            assert_eq!(
                alone,
                place.locate(&rock, 5, 0).map(|at| vec![at]),
                "{place:?}"
            );
        }
    }

    /// Discs put at random cover 0.547 of a plane at the end.
    #[test]
    fn seeds_without_room_are_refused() {
        let plane = load("meshes/plane.obj");
        let radius = plane.units().local_diagonal() / 50.0;
        let locate = |places: &[SeedPlace]| {
            let habitat = Habitat::new(&plane, None, 1e-3);
            SeedPlace::locate_all(places, &habitat, 1, radius).expect_err("no room")
        };
        let twice = locate(&[SeedPlace::Top, SeedPlace::Random, SeedPlace::Top]);
        assert!(
            matches!(twice, PlaceError::Overlap { first: 0, second: 2, distance, .. } if distance == 0.0),
            "{twice}"
        );
        let crowded = locate(&vec![SeedPlace::Random; 3000]);
        let PlaceError::Crowded { colony } = crowded else {
            panic!("{crowded}");
        };
        assert!((150..230).contains(&colony), "{colony} had room");
    }
}
