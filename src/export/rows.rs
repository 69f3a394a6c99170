//! Some rows of a table of elements.

use std::iter::zip;

use super::elements::{Attribute, Elements, TableError, Values};

impl Elements {
    /// The elements of one colony alone, in birth order: parents are the rows of this table.
    ///
    /// # Errors
    /// When the table [is not sound](Self::check), or an element has a parent in another colony.
    pub fn of_colony(&self, colony: u32) -> Result<Self, TableError> {
        self.check()?;
        let rows: Vec<usize> = (0..self.len())
            .filter(|&row| self.colony[row] == colony)
            .collect();
        let mut alone = self.take_rows(rows.iter().copied());
        for (&element, parent) in zip(&rows, &mut alone.parent) {
            if let Ok(born) = usize::try_from(*parent) {
                let foreign = |_| TableError::Value {
                    element,
                    column: "parent",
                    problem: "is of another colony",
                };
                *parent = rows.binary_search(&born).map_err(foreign)? as i32;
            }
        }
        Ok(alone)
    }

    /// How many colonies there are, by the highest number.
    pub fn colonies(&self) -> u64 {
        let highest = self.colony.iter().max();
        highest.map_or(0, |&highest| u64::from(highest) + 1)
    }

    pub(super) fn first(&self, count: usize) -> Self {
        self.take_rows(0..count)
    }

    fn take_rows(&self, rows: impl Iterator<Item = usize> + Clone) -> Self {
        fn of<T: Copy>(column: &[T], rows: impl Iterator<Item = usize>) -> Vec<T> {
            rows.map(|row| column[row]).collect()
        }
        let attribute = |a: &Attribute| Attribute {
            name: a.name,
            values: match &a.values {
                Values::I32(column) => Values::I32(of(column, rows.clone())),
                Values::F32(column) => Values::F32(of(column, rows.clone())),
                Values::Quaternion(column) => Values::Quaternion(of(column, rows.clone())),
            },
        };
        let source = self.source_triangle.as_ref();
        Self {
            radius: self.radius,
            positions: of(&self.positions, rows.clone()),
            normals: of(&self.normals, rows.clone()),
            parent: of(&self.parent, rows.clone()),
            colony: of(&self.colony, rows.clone()),
            triangle: of(&self.triangle, rows.clone()),
            uv: of(&self.uv, rows.clone()),
            probability: of(&self.probability, rows.clone()),
            source_triangle: source.map(|column| of(column, rows.clone())),
            attributes: self.attributes.iter().map(attribute).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colony_alone_has_parents_among_its_own_rows() {
        let parent = vec![-1, -1, 0, 1, 3, 2, 4];
        let all = Elements {
            radius: 1.0,
            positions: (0..7).map(|i| [f64::from(i), 0.0, 0.0]).collect(),
            normals: vec![[0.0, 0.0, 1.0]; 7],
            colony: vec![0, 1, 0, 1, 1, 0, 1],
            triangle: vec![0; 7],
            uv: vec![[0.0; 2]; 7],
            probability: vec![1.0; 7],
            source_triangle: Some((0..7).collect()),
            attributes: vec![Attribute {
                name: "depth",
                values: Values::I32(vec![0, 0, 1, 1, 2, 2, 3]),
            }],
            parent,
        };
        assert_eq!(all.colonies(), 2);
        let alone = all.of_colony(1).expect("a sound table");
        assert_eq!(alone.parent, [-1, 0, 1, 2]);
        let x: Vec<f64> = alone.positions.iter().map(|p| p[0]).collect();
        assert_eq!(x, [1.0, 3.0, 4.0, 6.0]);
        assert_eq!(alone.source_triangle, Some(vec![1, 3, 4, 6]));
        assert_eq!(alone.attributes[0].values, Values::I32(vec![0, 1, 2, 3]));
        assert!(all.of_colony(2).is_ok_and(|none| none.is_empty()));
        let with_parent = |element: usize, parent: i32| {
            let mut other = all.clone();
            other.parent[element] = parent;
            other.of_colony(1)
        };
        for (element, parent, problem) in [(4, 2, "another colony"), (4, 900, "born before")] {
            let refused = with_parent(element, parent).expect_err("no parent of it");
            assert!(refused.to_string().contains(problem), "{refused}");
        }
        let mut ragged = all;
        ragged.uv.pop();
        assert!(matches!(
            ragged.of_colony(1),
            Err(TableError::Ragged { column: "uv", .. })
        ));
    }
}
