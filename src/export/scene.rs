//! What exporters for other programs write: the measured lichen in the axes and units of a file.

use super::elements::{Attribute, Elements, INFINITE, TableError, Values};
use super::ply;
use crate::morphometry::{Morphometry, Sample};
use crate::substrate::UpAxis;

/// How the mesh file's coordinates become those of the file to write: turned about x, then scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The mesh file's up axis.
    pub from: UpAxis,
    /// Up axis of the file to write.
    pub to: UpAxis,
    /// Units of the file to write in a unit of the mesh file, above 0.
    pub scale: f64,
}

impl Placement {
    /// Neither turned nor scaled.
    pub fn unchanged(up: UpAxis) -> Self {
        Self {
            from: up,
            to: up,
            scale: 1.0,
        }
    }

    /// A direction, turned: exactly, as coordinates only change their places and signs.
    pub(super) fn turn<T: Copy + std::ops::Neg<Output = T>>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        match (self.from, self.to) {
            (UpAxis::Y, UpAxis::Z) => [x, -z, y],
            (UpAxis::Z, UpAxis::Y) => [x, z, -y],
            _ => [x, y, z],
        }
    }

    pub(super) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.turn(p).map(|x| x * self.scale)
    }

    /// The product of the turn's quaternion and this one, w ≥ 0.
    pub(super) fn orientation(&self, [x, y, z, w]: [f64; 4]) -> [f64; 4] {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let s = match (self.from, self.to) {
            (UpAxis::Y, UpAxis::Z) => h,
            (UpAxis::Z, UpAxis::Y) => -h,
            _ => return [x, y, z, w],
        };
        let turned = [h * x + s * w, h * y - s * z, h * z + s * y, h * w - s * x];
        if turned[3] < 0.0 {
            turned.map(|c| -c)
        } else {
            turned
        }
    }
}

/// A measured lichen, placed.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The elements, with these attributes: `orient`; `nage`, the normalized age, 1 for the first
    /// born and 0 for the last; `density`; `rim_distance`, −1 where there is no rim; `strahler`;
    /// `depth`; `branch_radius`. [`Morphometry`] says what they are.
    pub elements: Elements,
    /// Unit quaternions x, y, z, w of the elements' [orientations](crate::morphometry::orientations).
    pub orientations: Vec<[f32; 4]>,
    /// Paths from parents to children: see [`Tree::streams`](crate::morphometry::Tree::streams).
    pub streams: Vec<Vec<u32>>,
    /// Half the width of the branch at each element.
    pub branch_radii: Vec<f32>,
    /// Up axis of all of this.
    pub up: UpAxis,
    /// Size of a unit of all of this, for files that say it.
    pub meters_per_unit: f64,
    /// Where files with 32-bit positions and a translation put their own origin: none to choose by these positions
    /// alone. A [moment](Self::at) has that of the scene that it is one of.
    pub fixed_origin: Option<[f64; 3]>,
}

impl Elements {
    /// These elements as a lichen to be measured.
    pub fn sample(&self) -> Sample<'_> {
        Sample {
            radius: self.radius,
            positions: &self.positions,
            normals: &self.normals,
            parents: &self.parent,
        }
    }
}

impl Scene {
    /// Places a lichen with what was measured on it in the mesh file's axes and units.
    pub fn new(
        elements: Elements,
        measured: Morphometry,
        placement: &Placement,
        meters_per_unit: f64,
    ) -> Self {
        let orient = |&q: &[f64; 4]| placement.orientation(q).map(|x| x as f32);
        let orientations: Vec<_> = measured.orientations.iter().map(orient).collect();
        let radius = elements.radius * placement.scale;
        let width = |&taper: &f64| (taper * radius) as f32;
        let branch_radii: Vec<_> = measured.taper.iter().map(width).collect();
        let mut elements = Elements {
            radius,
            positions: elements
                .positions
                .iter()
                .map(|&p| placement.point(p))
                .collect(),
            normals: elements
                .normals
                .iter()
                .map(|&n| placement.turn(n))
                .collect(),
            ..elements
        };
        let columns = attributes(&elements, &measured, placement.scale);
        elements.attributes.push(attribute(
            "orient",
            Values::Quaternion(orientations.clone()),
        ));
        elements.attributes.extend(columns);
        elements.attributes.push(attribute(
            "branch_radius",
            Values::F32(branch_radii.clone()),
        ));
        Self {
            elements,
            orientations,
            streams: measured.streams,
            branch_radii,
            up: placement.to,
            meters_per_unit,
            fixed_origin: None,
        }
    }

    /// Checks what every file promises: [sound elements](Elements::check), an orientation and a branch radius for each,
    /// all of them finite, and streams of elements that there are.
    ///
    /// # Errors
    /// The first that does not hold.
    pub fn check(&self) -> Result<(), TableError> {
        self.elements.check()?;
        let expected = self.elements.len();
        let orientations = self
            .orientations
            .iter()
            .map(|q| q.iter().all(|x| x.is_finite()));
        check_column("orientation", orientations, expected)?;
        let radii = self.branch_radii.iter().map(|x| x.is_finite());
        check_column("branch_radius", radii, expected)?;
        if !self.fixed_origin.iter().flatten().all(|x| x.is_finite()) {
            return Err(TableError::Origin);
        }
        let strays = |stream: &Vec<u32>| stream.iter().any(|&i| i as usize >= expected);
        match self.streams.iter().position(strays) {
            None => Ok(()),
            Some(stream) => Err(TableError::Stream(stream)),
        }
    }

    /// Where files with float32 positions and a double translation put their own origin: zero,
    /// unless float32 would move elements by more than a hundredth of their radius.
    pub(super) fn origin(&self) -> [f64; 3] {
        if let Some(origin) = self.fixed_origin {
            return origin;
        }
        if !ply::Wide::of(&self.elements).positions {
            return [0.0; 3];
        }
        let [low, high] = self.bounds();
        [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k])
    }

    /// Lower and upper corner of the box about all centres.
    pub(super) fn bounds(&self) -> [[f64; 3]; 2] {
        let points = &self.elements.positions;
        let axes = [0, 1, 2].map(|k| range(points.iter().map(|p| p[k])));
        [0, 1].map(|side| axes.map(|axis| axis[side]))
    }

    /// Whether float32, which attributes and most formats have, can say these lengths.
    pub(super) fn fits_single(&self) -> bool {
        let range = f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX) / 16.0;
        let mut positions = self.elements.positions.iter().flatten();
        range.contains(&self.elements.radius) && positions.all(|x| x.abs() < range.end)
    }

    /// Positions from the [`origin`](Self::origin).
    pub(super) fn local_positions(&self) -> Vec<[f32; 3]> {
        let o = self.origin();
        let local = |p: &[f64; 3]| [0, 1, 2].map(|k| (p[k] - o[k]) as f32);
        self.elements.positions.iter().map(local).collect()
    }
}

/// Refuses a column of another length, or with a value that is not finite.
fn check_column(
    column: &'static str,
    mut finite: impl ExactSizeIterator<Item = bool>,
    expected: usize,
) -> Result<(), TableError> {
    let found = finite.len();
    if found != expected {
        return Err(TableError::Ragged {
            column,
            found,
            expected,
        });
    }
    match finite.position(|is_finite| !is_finite) {
        None => Ok(()),
        Some(element) => Err(TableError::Value {
            element,
            column,
            problem: INFINITE,
        }),
    }
}

fn attributes(elements: &Elements, measured: &Morphometry, scale: f64) -> Vec<Attribute> {
    let float = |column: &[f64]| Values::F32(column.iter().map(|&x| x as f32).collect());
    let whole = |column: &[u32]| Values::I32(column.iter().map(|&x| x as i32).collect());
    let rim = |d: &Option<f64>| d.map_or(-1.0, |d| (d * scale) as f32);
    let rim = measured.rim_distance.iter().map(rim).collect();
    let nage = (0..elements.len()).map(|i| 1.0 - elements.age(i)).collect();
    vec![
        attribute("nage", Values::F32(nage)),
        attribute("density", float(&measured.density)),
        attribute("rim_distance", Values::F32(rim)),
        attribute("strahler", whole(&measured.strahler)),
        attribute("depth", whole(&measured.depth)),
    ]
}

fn attribute(name: &'static str, values: Values) -> Attribute {
    Attribute { name, values }
}

/// Least and greatest of some numbers; of none, 0 and 0.
pub(super) fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    let wider = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    numbers
        .map(|x| [x, x])
        .reduce(|a, b| wider(a, b[0]))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    #[test]
    fn placing_turns_points_and_orientations_alike() {
        for (from, to) in [
            (UpAxis::Y, UpAxis::Z),
            (UpAxis::Z, UpAxis::Y),
            (UpAxis::Z, UpAxis::Z),
        ] {
            let placement = Placement {
                from,
                to,
                scale: 2.0,
            };
            let up = |axis| match axis {
                UpAxis::Y => [0.0, 1.0, 0.0],
                UpAxis::Z => [0.0, 0.0, 1.0],
            };
            assert_eq!(placement.turn(up(from)), up(to));
            let q = DQuat::from_xyzw(0.1, -0.5, 0.7, 0.2).normalize();
            let turned = DQuat::from_array(placement.orientation(q.to_array()));
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let expected = DVec3::from(placement.point((q * axis).to_array())) / 2.0;
                assert!((turned * axis - expected).length() < 1e-12);
            }
        }
    }
}
