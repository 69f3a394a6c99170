//! What a mesh file holds, before anything is welded or judged.

use super::SubstrateError;

/// Triangles as a file gave them: the loaders' common output.
///
/// Every polygon is already triangulated and every node transform applied. Vertices may be split
/// at seams, unreferenced, duplicated or degenerate: [`Substrate::from_soup`] deals with that.
/// Every index must be in range and every position that a triangle uses finite, as loaders make
/// sure: it refuses others.
///
/// [`Substrate::from_soup`]: crate::substrate::Substrate::from_soup
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Vertex positions in the file's own units and axes.
    pub positions: Vec<[f64; 3]>,
    /// Corner indices into `positions`, in the file's order.
    pub triangles: Vec<[u32; 3]>,
    /// What the loader had to interpret or pass over, in words for the user
    /// (`"12 polygons triangulated"`, `"3 line primitives ignored"`).
    pub notes: Vec<String>,
}

impl Soup {
    /// Triangles of vertex and index buffers as engines keep them: three indices a triangle. One or two more at the
    /// end are passed over, with a note.
    ///
    /// ```
    /// use thallus::substrate::{Soup, Substrate};
    ///
    /// let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    /// let substrate = Substrate::from_soup(Soup::from_buffers(&vertices, &[0, 2, 1]))?;
    /// assert_eq!(substrate.triangles().len(), 1);
    /// # Ok::<(), thallus::substrate::SubstrateError>(())
    /// ```
    pub fn from_buffers(vertices: &[[f32; 3]], indices: &[u32]) -> Self {
        let (triangles, rest) = indices.as_chunks();
        let note = match rest.len() {
            0 => None,
            1 => Some("1 index beyond the last triangle ignored".to_owned()),
            n => Some(format!("{n} indices beyond the last triangle ignored")),
        };
        Self {
            positions: vertices.iter().map(|p| p.map(f64::from)).collect(),
            triangles: triangles.to_vec(),
            notes: note.into_iter().collect(),
        }
    }

    /// Refuses corners that are not there, or nowhere. Loaders have asked before and named the place in the
    /// file.
    pub(super) fn check(&self) -> Result<(), SubstrateError> {
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for &vertex in corners {
                let Some(&position) = self.positions.get(vertex as usize) else {
                    return Err(SubstrateError::NoSuchVertex {
                        triangle,
                        vertex,
                        vertices: self.positions.len(),
                    });
                };
                if !is_representable(position) {
                    return Err(SubstrateError::NowhereVertex {
                        triangle,
                        vertex,
                        position,
                    });
                }
            }
        }
        Ok(())
    }

    /// BLAKE3 of positions and triangles, hexadecimal: equal to the bit means equal hashes. Notes do not count.
    pub(super) fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        // Where the one list ends and the other begins must count too.
        hasher.update(b"thallus soup");
        hasher.update(&(self.positions.len() as u64).to_le_bytes());
        for x in self.positions.as_flattened() {
            hasher.update(&x.to_le_bytes());
        }
        for corner in self.triangles.as_flattened() {
            hasher.update(&corner.to_le_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// Whether welding can round it to f32; NaN and infinity it cannot.
pub(super) fn is_representable(position: [f64; 3]) -> bool {
    position.iter().all(|x| x.abs() <= f64::from(f32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::Substrate;

    fn square() -> Soup {
        Soup {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            notes: Vec::new(),
        }
    }

    fn refused(soup: Soup) -> SubstrateError {
        Substrate::from_soup(soup).unwrap_err()
    }

    #[test]
    fn buffers_are_the_same_triangles() {
        let vertices = square()
            .positions
            .iter()
            .map(|p| p.map(|x| x as f32))
            .collect::<Vec<_>>();
        let whole = Soup::from_buffers(&vertices, &[0, 1, 2, 0, 2, 3]);
        assert_eq!(whole, square());
        let cut = Soup::from_buffers(&vertices, &[0, 1, 2, 0, 2]);
        assert_eq!(cut.triangles, [[0, 1, 2]]);
        assert_eq!(cut.notes, ["2 indices beyond the last triangle ignored"]);
    }

    #[test]
    fn corners_that_are_not_there_are_refused() {
        for vertex in [4, u32::MAX] {
            let triangles = vec![[0, 1, 2], [0, 2, vertex]];
            let error = refused(Soup {
                triangles,
                ..square()
            });
            let message = error.to_string();
            for part in ["triangle 1", &format!("vertex {vertex},"), "there are 4"] {
                assert!(message.contains(part), "{part} in {message}");
            }
        }
    }

    #[test]
    fn corners_that_are_nowhere_are_refused() {
        for (x, shown) in [
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
            (-1e39, "-1e39"),
            (1e308, "1e308"),
        ] {
            let mut soup = square();
            soup.positions[3][1] = x;
            let message = refused(soup).to_string();
            for part in ["vertex 3", "triangle 1", shown] {
                assert!(message.contains(part), "{part} in {message}");
            }
        }
    }

    #[test]
    fn vertices_that_no_triangle_uses_may_be_anywhere() {
        let mut soup = square();
        soup.positions.push([f64::NAN; 3]);
        let substrate = Substrate::from_soup(soup).unwrap();
        assert_eq!(substrate.triangles().len(), 2);
    }

    #[test]
    fn the_hash_is_that_of_positions_and_triangles() {
        let hash = |soup: Soup| {
            let substrate = Substrate::from_soup(soup).unwrap();
            substrate.mesh_hash().to_owned()
        };
        let plain = hash(square());
        assert_eq!(plain.len(), 64);
        let noted = Soup {
            notes: vec!["a note".to_owned()],
            ..square()
        };
        assert_eq!(hash(noted), plain, "notes");
        let mut moved = square();
        moved.positions[2][0] = 1.0 + 1e-15;
        assert_ne!(hash(moved), plain, "a position");
        let mut turned = square();
        turned.triangles[1] = [2, 3, 0];
        assert_ne!(hash(turned), plain, "a triangle");
    }

    #[test]
    fn canonical_numbers_lead_back() {
        let far = |p: [f64; 3]| [p[0] + 5.0, 2.0 * p[1], p[2]];
        let mut soup = square();
        soup.positions
            .extend(square().positions.into_iter().map(far));
        soup.triangles.extend([[4, 5, 6], [4, 6, 7]]);
        let substrate = Substrate::from_soup(soup).unwrap();
        for t in 0..4 {
            let number = substrate.canonical_triangle(t);
            assert_eq!(substrate.triangle_of_canonical(number), Some(t));
        }
        assert_eq!(substrate.triangle_of_canonical(4), None);
    }
}
