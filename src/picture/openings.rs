//! Rays through what is cut out of the substrate, or transparent.

use super::Finish;
use super::sample::{hash, unit};
use super::trace::{CLEAR, Mesh, Spot, Stone, World};
use super::wide::Ray;

/// Open places in the way of a ray that are gone through, at most: behind as many there is nothing.
const MOST_OPEN: u32 = 10_000;

impl World<'_> {
    /// Where a ray first meets the substrate, and to where it is cut.
    pub(super) fn first_stone(&self, ray: &mut Ray) -> Option<Spot> {
        let mesh = &self.stone.mesh;
        match self.openings {
            None => mesh.first(ray),
            Some(finish) => self.first_closed(mesh, finish, ray),
        }
    }

    /// Whether the substrate is in the way of a ray.
    pub(super) fn stone_blocks(&self, ray: &Ray) -> bool {
        match self.openings {
            None => self.stone.mesh.blocks(ray),
            Some(_) => self.first_stone(&mut ray.clone()).is_some(),
        }
    }

    /// Goes on behind each place that is open.
    fn first_closed(&self, mesh: &Mesh, finish: &dyn Finish, ray: &mut Ray) -> Option<Spot> {
        let (origin, direction) = (ray.origin.get(0), ray.direction.get(0));
        let clear = CLEAR * self.stage.size;
        let (mut behind, mut step, mut last) = (0.0, clear, None);
        for _ in 0..MOST_OPEN {
            let mut rest = ray.clone().starting_at(origin + direction * behind);
            rest.end = ray.end - behind;
            let spot = mesh.first(&mut rest)?;
            if !is_open(self.stone, finish, &spot) {
                ray.end = behind + rest.end;
                return Some(spot);
            }
            // A ray along a triangle may meet it again and again.
            step = if last == Some(spot.number) {
                2.0 * step
            } else {
                clear
            };
            last = Some(spot.number);
            behind += rest.end + step;
        }
        None
    }
}

fn is_open(stone: &Stone, finish: &dyn Finish, spot: &Spot) -> bool {
    let Spot {
        number, weights, ..
    } = *spot;
    let mixed = weights
        .iter()
        .fold(number, |mixed, w| hash(mixed ^ w.to_bits()));
    finish.is_open(stone.number(spot), weights, unit(mixed))
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::super::{Coat, Scene};
    use super::*;

    /// Sheets one above the other, of two triangles each; one of them is open where a corner counts for less than this,
    /// or to this share of the rays.
    struct Sheet {
        open: std::ops::Range<u32>,
        weight: f32,
        opacity: f32,
    }

    impl Finish for Sheet {
        fn at(&self, _: u32, _: [f32; 3], _: [f32; 3]) -> Option<Coat> {
            None
        }

        fn has_openings(&self) -> bool {
            true
        }

        fn is_open(&self, triangle: u32, weights: [f32; 3], chance: f32) -> bool {
            self.open.contains(&triangle) && weights[0] < self.weight && self.opacity <= chance
        }
    }

    /// Of rays down onto them, at which height each is stopped.
    fn heights(sheets: u32, finish: &Sheet) -> Vec<Option<f32>> {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for sheet in 0..sheets {
            let height = -(sheet as f32);
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            vertices.extend(corners.map(|[x, y]: [f32; 2]| [x, y, height]));
            let first = 4 * sheet;
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|k| first + k)));
        }
        let stone = Stone::new(&vertices, &triangles);
        let world = World::new(&Scene {
            finish: Some(finish),
            ..Scene::bare(&stone, [0.0, 0.0, 1.0])
        });
        let ray = |i: u32| {
            let across = |k| 0.01 + 0.98 * unit(hash(2 * i + k));
            let from = Vec3A::new(across(0), across(1), 1.0);
            let met = world.hit(from, Vec3A::NEG_Z);
            let blocked = world.is_behind(from, Vec3A::NEG_Z);
            assert_eq!(blocked, met.is_some());
            met.map(|hit| hit.place.z)
        };
        (0..2000).map(ray).collect()
    }

    #[test]
    fn rays_go_through_what_is_open_and_stop_at_the_next() {
        let whole = Sheet {
            open: 0..4,
            weight: 2.0,
            opacity: 0.0,
        };
        let found = heights(3, &whole);
        let below = |z: &Option<f32>| z.is_some_and(|z| (z + 2.0).abs() < 1e-5);
        assert!(found.iter().all(below), "{found:?}");
        assert!(heights(2, &whole).iter().all(Option::is_none));
    }

    #[test]
    fn a_sheet_is_open_in_part() {
        let part = Sheet {
            open: 0..2,
            weight: 0.5,
            opacity: 0.0,
        };
        // A corner of a triangle counts for less than half on three quarters of its area.
        let found = heights(2, &part);
        let through = found.iter().filter(|z| **z == Some(-1.0)).count();
        assert!(through.abs_diff(1500) < 100, "{through}");
        assert!(found.iter().all(Option::is_some));
    }

    /// Two thousand rays through a sheet that stops three of ten: 600, give or take 5 σ.
    #[test]
    fn what_is_half_transparent_stops_its_share_of_the_rays() {
        let half = Sheet {
            open: 0..2,
            weight: 2.0,
            opacity: 0.3,
        };
        let stopped = heights(1, &half).iter().flatten().count();
        assert!(stopped.abs_diff(600) < 103, "{stopped}");
    }
}
