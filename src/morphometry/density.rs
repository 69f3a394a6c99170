//! Local density.

use super::Neighbours;

/// For each element of this radius r the share of a flat disc of radius D that the elements with
/// their centres in it would cover, itself among them: (1 + n)·r²/D² for n neighbours within D.
///
/// The thesis colours and sticks by the count n within its curvature radius L (Sumner 2001, 5.2);
/// with D = L this is that count over what does not depend on the choice of r and L. A dense
/// packing of discs comes to about π/√12 = 0.91, over a fold too. A surface that curves within D
/// holds more or less than a flat one.
pub fn density(radius: f64, neighbours: &Neighbours) -> Vec<f64> {
    let share = (radius / neighbours.within()) * (radius / neighbours.within());
    let of = |i| {
        let mut n = 1u32;
        neighbours.visit(i, |_, _, _| n += 1);
        f64::from(n) * share
    };
    neighbours.map(of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::morphometry::test_lichen::{are_near, blob};
    use std::f64::consts::PI;

    #[test]
    fn density_is_a_count_over_all() {
        let blob = blob(300, 3);
        let within = 0.4;
        let neighbours = Neighbours::new(&blob.positions, &blob.normals, within);
        for (i, density) in density(0.1, &neighbours).into_iter().enumerate() {
            let near = |&j: &usize| are_near(&blob, [i, j], within);
            let n = (0..blob.positions.len()).filter(near).count() as f64;
            assert!((density - n * 0.0625).abs() < 1e-12);
        }
    }

    /// The middle of a hexagonal packing of touching discs, which fills π/√12 of the plane.
    #[test]
    fn packed_discs_have_the_density_of_a_packing() {
        let mut positions = Vec::new();
        for row in -60..=60 {
            for column in -60..=60 {
                let x = f64::from(2 * column + (row & 1));
                positions.push([x, f64::from(row) * 3f64.sqrt(), 0.0]);
            }
        }
        let middle = positions.iter().position(|p| p == &[0.0; 3]).unwrap();
        let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
        let neighbours = Neighbours::new(&positions, &normals, 50.0);
        let density = density(1.0, &neighbours)[middle];
        assert!((density - PI / 12f64.sqrt()).abs() < 0.01, "{density}");
    }
}
