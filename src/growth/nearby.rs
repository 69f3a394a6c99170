//! Elements that were found about a place, for what is asked next about smaller balls near there.

use glam::DVec3;

use super::Surroundings;
use crate::cluster::ElementIndex;
use crate::walk::Ball;

/// The elements in a ball, as they were when they were found.
///
/// Others may have been born since, of which what is asked next would know. So only balls may be asked about in which a
/// birth takes the walker back anyway: see [`Asked`](super::flight::Asked).
#[derive(Default)]
pub(super) struct Nearby {
    ball: Option<Ball>,
    all: Vec<Found>,
}

/// An element that was found.
///
/// Its id takes eight bytes, so that none lie empty. Where some do, it is put on the stack before it comes to a list,
/// in other pieces than it is then read in, and that is waited for.
#[derive(Clone, Copy)]
pub(super) struct Found {
    id: u64,
    pub(super) place: DVec3,
}

impl Found {
    #[inline]
    fn new(id: u32, place: DVec3) -> Self {
        let id = u64::from(id);
        Self { id, place }
    }

    #[inline]
    pub(super) fn id(&self) -> u32 {
        self.id as u32
    }
}

/// There mostly are no more of them.
const USUAL: usize = 96;

/// What rounding may add to distances, as a share.
const ROUNDED: f64 = 1e-9;

impl Nearby {
    /// Begins anew: all in this ball are going to be added.
    pub(super) fn begin(&mut self, ball: Ball) {
        self.ball = Some(ball);
        self.all.clear();
        self.all.reserve(USUAL);
    }

    #[inline]
    pub(super) fn add(&mut self, id: u32, place: DVec3) {
        self.all.push(Found::new(id, place));
    }

    /// Whether all within a radius of a place are among them.
    fn holds(&self, p: DVec3, radius: f64) -> bool {
        let reach = |ball: &Ball| (1.0 - ROUNDED) * ball.radius - radius;
        self.ball
            .as_ref()
            .is_some_and(|ball| p.distance(ball.centre) <= reach(ball))
    }
}

impl<I: ElementIndex> Surroundings<'_, I> {
    /// Visits every element with its centre nearer than `radius` to a place, as [`within`](Self::within) does, but
    /// those that were found before where they are all.
    pub(super) fn within_found(
        &self,
        nearby: &Nearby,
        (p, radius): (DVec3, f64),
        mut visit: impl FnMut(Found),
    ) {
        if !nearby.holds(p, radius) {
            return self.within(p, radius, &mut |id, e| visit(Found::new(id, e.position)));
        }
        for found in &nearby.all {
            if found.place.distance_squared(p) < radius * radius {
                visit(*found);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::{Element, SparseIndex};
    use crate::growth::stick::tests::on_rock;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn what_was_found_answers_for_smaller_balls_in_it() {
        on_rock(smaller_balls_are_answered);
    }

    fn smaller_balls_are_answered(around: &Surroundings<SparseIndex>, elements: &[Element]) {
        let radius = around.parameters.curvature_radius;
        let mut stream = Stream::new(5, Purpose::Walker, 0);
        let (mut nearby, mut served) = (Nearby::default(), 0);
        for first in elements.iter().step_by(90) {
            let centre = first.position;
            nearby.begin(Ball { centre, radius });
            around.within(centre, radius, &mut |id, e| nearby.add(id, e.position));
            for _ in 0..20 {
                let aside = DVec3::from([0; 3].map(|_| stream.uniform() - 0.5)) * radius;
                let asked = (centre + aside, 0.9 * stream.uniform() * radius);
                let [mut expected, mut found] = [Vec::new(), Vec::new()];
                around.within(asked.0, asked.1, &mut |id, _| expected.push(id));
                around.within_found(&nearby, asked, |one| {
                    assert_eq!(one.place, around.element(one.id()).position);
                    found.push(one.id());
                });
                expected.sort_unstable();
                found.sort_unstable();
                assert_eq!(found, expected);
                served += usize::from(nearby.holds(asked.0, asked.1));
            }
        }
        assert!((700..1300).contains(&served), "{served}");
    }
}
