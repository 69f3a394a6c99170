//! Which pieces of a mesh are about a place.

use glam::DVec3;

use super::Component;
use super::bvh::{Bvh, box_distance_sq};
use super::order::along_curve;

/// A tree over the boxes of pieces.
#[derive(Debug)]
pub(crate) struct Pieces {
    /// Their numbers, along a curve.
    numbers: Vec<u32>,
    tree: Bvh,
}

impl Pieces {
    pub(crate) fn new(pieces: &[Component]) -> Self {
        let middle = |i: usize| 0.5 * pieces[i].bounds[0] + 0.5 * pieces[i].bounds[1];
        let bounds = pieces.iter().fold(
            [DVec3::INFINITY, DVec3::NEG_INFINITY],
            |[low, high], piece| [low.min(piece.bounds[0]), high.max(piece.bounds[1])],
        );
        let numbers = along_curve(bounds, pieces.len(), middle);
        let boxes: Vec<_> = numbers.iter().map(|&i| pieces[i as usize].bounds).collect();
        Self {
            tree: Bvh::of_boxes(&boxes),
            numbers,
        }
    }

    /// The numbers of those whose boxes a place is in, and of some beside it.
    pub(crate) fn near(&self, place: DVec3) -> Vec<u32> {
        let mut near = Vec::new();
        let is_about = |about: &_| box_distance_sq(about, place) == 0.0;
        self.tree
            .visit(is_about, |i| near.push(self.numbers[i as usize]));
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn no_piece_about_a_place_is_left_out() {
        let mut stream = Stream::new(5, Purpose::Walker, 0);
        let mut place = || DVec3::from([(); 3].map(|()| stream.uniform()));
        for count in [1, 2, 8, 9, 500] {
            let pieces: Vec<_> = (0..count)
                .map(|_| {
                    let (middle, half) = (place(), 0.2 * place());
                    Component {
                        triangles: 0..1,
                        area: 1.0,
                        bounds: [middle - half, middle + half],
                    }
                })
                .collect();
            let tree = Pieces::new(&pieces);
            let (mut found, mut looked_at) = (0, 0);
            for _ in 0..300 {
                let here = place();
                let near = tree.near(here);
                looked_at += near.len();
                for (i, piece) in (0..).zip(&pieces) {
                    let [low, high] = piece.bounds;
                    if here.cmpge(low).all() && here.cmple(high).all() {
                        assert!(near.contains(&i));
                        found += 1;
                    }
                }
            }
            if count == 500 {
                assert!(
                    found > 0 && looked_at < 300 * count / 5,
                    "{found} {looked_at}"
                );
            }
        }
    }
}
