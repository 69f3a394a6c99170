//! The lobe that instances show until an artist puts another in its place: a low dome in the xy
//! plane, its top up z, drawn out along y, about an element of radius 1 wide.

/// Corners round a ring.
const SIDES: usize = 12;

/// Rings from the foot up: share of the foot's radius, and height.
const RINGS: [[f32; 2]; 3] = [[1.0, 0.0], [0.8, 0.22], [0.45, 0.34]];

/// Height of the top.
const TOP: f32 = 0.38;

/// Half the width of the foot; more than 1 lets neighbours overlap, as squamules do.
const WIDTH: f32 = 1.15;

/// How much farther the tip reaches than the sides.
const TIP: f32 = 1.35;

/// A triangle mesh.
pub(super) struct Lobe {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Lobe {
    pub(super) fn new() -> Self {
        let mut positions = Vec::new();
        for [share, height] in RINGS {
            positions.extend((0..SIDES).map(|k| place(share, height, k)));
        }
        positions.push([0.0, 0.0, TOP]);
        let triangles = triangles();
        Self {
            normals: normals(&positions, &triangles),
            positions,
            triangles,
        }
    }
}

fn place(share: f32, height: f32, side: usize) -> [f32; 3] {
    let angle = std::f32::consts::TAU * side as f32 / SIDES as f32;
    let (x, y) = (libm::cosf(angle), libm::sinf(angle));
    let stretch = if y > 0.0 { TIP } else { 1.0 };
    [share * WIDTH * x, share * WIDTH * stretch * y, height]
}

fn triangles() -> Vec<[u32; 3]> {
    let number = |ring: usize, side: usize| (ring * SIDES + side % SIDES) as u32;
    let top = (RINGS.len() * SIDES) as u32;
    let mut triangles = Vec::new();
    for side in 0..SIDES {
        for ring in 1..RINGS.len() {
            let [a, b] = [side, side + 1].map(|s| number(ring - 1, s));
            let [d, c] = [side, side + 1].map(|s| number(ring, s));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let last = RINGS.len() - 1;
        triangles.push([number(last, side), number(last, side + 1), top]);
    }
    triangles
}

/// Means of the faces' normals by area.
fn normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![glam::Vec3::ZERO; positions.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|i| glam::Vec3::from(positions[i as usize]));
        let normal = (b - a).cross(c - a);
        corners.iter().for_each(|&i| sums[i as usize] += normal);
    }
    sums.iter()
        .map(|n| n.normalize_or(glam::Vec3::Z).to_array())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lobe_is_a_dome_that_points_along_y() {
        let lobe = Lobe::new();
        let least = |k: usize| lobe.positions.iter().map(|p| p[k]).fold(f32::MAX, f32::min);
        let most = |k: usize| lobe.positions.iter().map(|p| p[k]).fold(f32::MIN, f32::max);
        assert!(most(1) > -least(1) && (most(0) + least(0)).abs() < 1e-6);
        assert_eq!((least(2), most(2)), (0.0, TOP));
        assert!(lobe.normals.iter().all(|n| n[2] > 0.0));
        let mut sides: Vec<_> = lobe
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .collect();
        let number = sides.len();
        sides.sort_unstable();
        sides.dedup();
        assert_eq!(sides.len(), number, "an edge is used twice one way");
        let open = sides
            .iter()
            .filter(|[a, b]| sides.binary_search(&[*b, *a]).is_err());
        assert_eq!(open.count(), SIDES, "open at the foot only");
    }
}
