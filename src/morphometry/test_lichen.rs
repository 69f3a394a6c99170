//! Made-up lichens for the tests of this module.

use glam::DVec3;

use super::Sample;
use super::fold::laid_out;

#[derive(Default)]
pub(super) struct Lichen {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) parents: Vec<i32>,
}

impl Lichen {
    pub(super) fn push(&mut self, position: [f64; 3], normal: [f32; 3], parent: i32) {
        self.positions.push(position);
        self.normals.push(normal);
        self.parents.push(parent);
    }

    pub(super) fn position(&self, i: usize) -> DVec3 {
        self.positions[i].into()
    }

    pub(super) fn sample(&self) -> Sample<'_> {
        Sample {
            radius: 0.05,
            positions: &self.positions,
            normals: &self.normals,
            parents: &self.parents,
        }
    }

    /// Every element moved straight out to the unit sphere, normals outwards.
    pub(super) fn onto_sphere(mut self) -> Self {
        for (p, n) in self.positions.iter_mut().zip(&mut self.normals) {
            let out = DVec3::from(*p).normalize_or(DVec3::Z);
            (*p, *n) = (out.to_array(), out.as_vec3().to_array());
        }
        self
    }
}

/// Elements strewn through a cube about the origin, with any normals and any parents born before.
pub(super) fn blob(n: usize, seed: u64) -> Lichen {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    let mut number = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut lichen = Lichen::default();
    for i in 0..n {
        let position = [number(), number(), number()].map(|x| 2.0 * x - 1.0);
        let normal = DVec3::new(number(), number(), number()) * 2.0 - 1.0;
        let parent = (number() * i as f64) as i32;
        let normal = normal.normalize_or(DVec3::Z).as_vec3().to_array();
        lichen.push(position, normal, if i == 0 { -1 } else { parent });
    }
    lichen
}

/// The same in the plane, facing up.
pub(super) fn flat(n: usize, seed: u64) -> Lichen {
    let mut lichen = blob(n, seed);
    lichen.positions.iter_mut().for_each(|p| p[2] = 0.0);
    lichen.normals.fill([0.0, 0.0, 1.0]);
    lichen
}

/// Whether two elements are neighbours, by the rule for pairs.
pub(super) fn are_near(lichen: &Lichen, pair: [usize; 2], within: f64) -> bool {
    let [p, q] = pair.map(|i| lichen.position(i));
    let normals = pair.map(|i| lichen.normals[i].into());
    p.distance(q) <= within && laid_out(q - p, normals, within).is_some()
}

/// Touching discs of radius 1 in a hexagonal packing, on two half planes that meet in the y axis, the
/// second turned down by an angle: all whose way from the middle over the fold is at most `extent`.
pub(super) fn folded(angle: f64, extent: f64) -> Lichen {
    let (sin, cos) = angle.sin_cos();
    let n = (extent / 3f64.sqrt()) as i32 + 1;
    let mut lichen = Lichen::default();
    for row in -n..=n {
        for column in -n..=n {
            // Off the fold itself, so that each has a side.
            let x = f64::from(row) * 3f64.sqrt() + 0.3;
            let y = f64::from(2 * column + (row & 1));
            if x.hypot(y) > extent {
                continue;
            }
            match x > 0.0 {
                true => lichen.push([x * cos, y, -x * sin], [sin as f32, 0.0, cos as f32], -1),
                false => lichen.push([x, y, 0.0], [0.0, 0.0, 1.0], -1),
            }
        }
    }
    lichen
}

/// The packing of [`folded`] on both faces of a plate, back to back.
pub(super) fn plate(thickness: f64, extent: f64) -> Lichen {
    let mut lichen = folded(0.0, extent);
    for i in 0..lichen.positions.len() {
        let [x, y, _] = lichen.positions[i];
        lichen.push([x, y, -thickness], [0.0, 0.0, -1.0], -1);
    }
    lichen
}
