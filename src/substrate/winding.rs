//! Which side of each triangle is the outside.
//!
//! Files may wind neighbours differently. Each component is followed from edge to edge, so that all of
//! it is wound one way: the way that encloses a volume where it is closed, else the way of most of it,
//! by area. A component whose neighbours agree keeps its file's winding, whatever that encloses: it may
//! be a hollow. What has one side only (a Möbius band) is cut along some edges.

use glam::DVec3;

use super::{Component, HalfEdge, Substrate};

/// How the triangles of a substrate are wound, against its file.
#[derive(Debug, Default)]
pub(crate) struct Winding {
    /// Whether each triangle is as in the file; of none where all are.
    kept: Vec<bool>,
    /// Half-edges along which no choice agrees, ascending.
    cut: Vec<HalfEdge>,
}

impl Winding {
    pub(super) fn of(substrate: &Substrate) -> Self {
        if !substrate.winds_differently {
            return Self::default();
        }
        let mut winding = Self {
            kept: vec![true; substrate.triangles().len()],
            cut: Vec::new(),
        };
        let mut seen = vec![false; winding.kept.len()];
        for component in substrate.components() {
            winding.settle(substrate, component, &mut seen);
        }
        winding.cut.sort_unstable();
        winding
    }

    /// Follows the edges of a component from its first triangle, then turns all of it if it has to be.
    fn settle(&mut self, substrate: &Substrate, component: &Component, seen: &mut [bool]) {
        let mut stack = vec![component.triangles.start];
        seen[component.triangles.start as usize] = true;
        let mut is_closed = true;
        while let Some(t) = stack.pop() {
            for h in 3 * t..3 * t + 3 {
                let twin = substrate.twin(h);
                let other = twin.half_edge() / 3;
                is_closed &= twin.half_edge() != h;
                if !seen[other as usize] {
                    seen[other as usize] = true;
                    self.kept[other as usize] = self.kept[t as usize] != twin.is_flipped();
                    stack.push(other);
                }
            }
        }
        let cuts = self.cut.len();
        self.cut_between(substrate, component);
        let has_inside = is_closed && self.cut.len() == cuts;
        if self.is_backward(substrate, component, has_inside) {
            let range = component.triangles.start as usize..component.triangles.end as usize;
            self.kept[range].iter_mut().for_each(|kept| *kept = !*kept);
        }
    }

    /// Cuts between triangles that are wound differently all the same.
    fn cut_between(&mut self, substrate: &Substrate, component: &Component) {
        for h in 3 * component.triangles.start..3 * component.triangles.end {
            let twin = substrate.twin(h);
            let [own, other] = [h, twin.half_edge()].map(|h| self.kept[h as usize / 3]);
            if twin.half_edge() != h && (own == other) == twin.is_flipped() {
                self.cut.push(h);
            }
        }
    }

    /// Whether what was settled is the wrong way round. What was wound one way is as it was.
    fn is_backward(&self, substrate: &Substrate, component: &Component, has_inside: bool) -> bool {
        let triangles = || component.triangles.clone();
        let turned = |t: &u32| !self.kept[*t as usize];
        if !triangles().any(|t| turned(&t)) {
            return false;
        }
        if !has_inside {
            let area: f64 = triangles().filter(turned).map(|t| substrate.area(t)).sum();
            return area > 0.5 * component.area;
        }
        let middle = substrate.corners(component.triangles.start)[0];
        let volume = |t| self.side(t) * pyramid(substrate.corners(t), middle);
        triangles().map(volume).sum::<f64>() < 0.0
    }

    /// 1 where a triangle is wound as in its file, −1 where it is turned.
    pub(crate) fn side(&self, triangle: u32) -> f64 {
        match self.kept.get(triangle as usize) {
            Some(false) => -1.0,
            _ => 1.0,
        }
    }

    /// Whether no surface that keeps to the winding goes on across a half-edge.
    pub(crate) fn is_open(&self, substrate: &Substrate, half_edge: HalfEdge) -> bool {
        substrate.twin(half_edge).half_edge() == half_edge
            || self.cut.binary_search(&half_edge).is_ok()
    }
}

/// Six times the volume between a triangle and a place.
fn pyramid(corners: [DVec3; 3], top: DVec3) -> f64 {
    let [a, b, c] = corners.map(|p| p - top);
    a.dot(b.cross(c))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::substrate::{Soup, load_soup};

    /// A mesh of ours with some of its triangles turned in the file.
    fn turned(mesh: &str, is_turned: impl Fn(usize) -> bool) -> Substrate {
        let mut soup = load_soup(Path::new(mesh)).expect("a mesh").soup;
        for (t, corners) in soup.triangles.iter_mut().enumerate() {
            if is_turned(t) {
                corners.swap(1, 2);
            }
        }
        Substrate::from_soup(soup).expect("a surface")
    }

    fn volume(mesh: &Substrate) -> f64 {
        let triangles = 0..mesh.triangles().len() as u32;
        let part = |t| mesh.area_vector(t).dot(mesh.corners(t)[0]) / 3.0;
        triangles.map(part).sum()
    }

    fn are_conflicts(mesh: &Substrate) -> bool {
        mesh.report().winding_conflicts > 0
    }

    #[test]
    fn a_closed_mesh_of_any_windings_has_its_normals_outside() {
        let whole = turned("meshes/rock.obj", |_| false);
        // A third, half and most of them, in no order.
        for share in [3, 5, 8] {
            let mesh = turned("meshes/rock.obj", |t| t * 7919 % 10 < share);
            assert!(are_conflicts(&mesh) && !are_conflicts(&whole));
            let [own, expected] = [&mesh, &whole].map(volume);
            assert!((own - expected).abs() < 1e-9 * expected, "{own} {expected}");
        }
    }

    #[test]
    fn where_neighbours_agree_the_file_is_right() {
        let [whole, inwards] = [false, true].map(|is| turned("meshes/rock.obj", |_| is));
        assert!(!are_conflicts(&inwards));
        assert_eq!(volume(&inwards), -volume(&whole));
    }

    #[test]
    fn an_open_mesh_goes_by_most_of_its_area() {
        let up = |few: bool| {
            let strip = |i: u32| [[2 * i, 2 * i + 1, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 2]];
            let mut triangles: Vec<[u32; 3]> = (0..9).flat_map(strip).collect();
            let turned = if few { 4..8 } else { 2..16 };
            triangles[turned].iter_mut().for_each(|t| t.swap(1, 2));
            let mesh = Substrate::from_soup(Soup {
                positions: (0..20)
                    .map(|v| [f64::from(v / 2), f64::from(v % 2), 0.0])
                    .collect(),
                triangles,
                notes: Vec::new(),
            });
            let mesh = mesh.expect("a surface");
            (0..18).map(|t| mesh.normal(t).z).collect::<Vec<_>>()
        };
        assert_eq!(up(true), [-1.0; 18]);
        assert_eq!(up(false), [1.0; 18]);
    }

    #[test]
    fn what_has_one_side_is_cut_once() {
        // Twelve squares in a ring that closes with half a turn.
        let place = |v: u32| {
            let (i, top) = (v / 2, v % 2 == 1);
            let turn = std::f64::consts::TAU * f64::from(i) / 12.0;
            let across = if top { 0.3 } else { -0.3 };
            let out = 1.0 + across * (0.5 * turn).cos();
            [
                out * turn.cos(),
                across * (0.5 * turn).sin(),
                out * turn.sin(),
            ]
        };
        let ring = |i: u32| {
            let next = |v: u32| if v < 24 { v } else { 49 - v - 24 };
            let [a, b, c, d] = [2 * i, 2 * i + 1, next(2 * i + 3), next(2 * i + 2)];
            [[a, b, c], [a, c, d]]
        };
        let mesh = Substrate::from_soup(Soup {
            positions: (0..24).map(place).collect(),
            triangles: (0..12).flat_map(ring).collect(),
            notes: Vec::new(),
        })
        .expect("a surface");
        assert!(are_conflicts(&mesh));
        assert_eq!(mesh.winding().cut.len(), 2, "both half-edges of one edge");
    }
}
