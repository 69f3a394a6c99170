//! Made-up lichens for the tests of this module.

use glam::DVec3;

use super::Sample;

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

/// Whether two elements' normals lie in one half space.
pub(super) fn same_side(lichen: &Lichen, i: usize, j: usize) -> bool {
    let (a, b) = (lichen.normals[i], lichen.normals[j]);
    glam::Vec3::from(a).dot(b.into()) > 0.0
}
