//! Centroid and effective radius R_e, exact after every birth.

use glam::DVec3;

use super::Population;

/// Mean of the centres in space, and the distance from it to the farthest.
///
/// The centroid moves with every birth, so the farthest centre may change at any time. Only the
/// centres near the rim can become it: a survey lists them, and the list serves until the centroid has
/// moved by the slack that it was made with, or the rim has moved out by eight. Of a long list the same
/// is done again, with an eighth of the slack, until the last is short: each birth looks at that alone.
#[derive(Clone, Debug, Default)]
pub struct Extent {
    sum: DVec3,
    centroid: DVec3,
    radius: f64,
    /// Each of those that the one before lists.
    rims: Vec<Rim>,
}

/// The centres that can be the farthest while the centroid stays near where it was at a survey.
#[derive(Clone, Debug)]
struct Rim {
    surveyed_from: DVec3,
    slack: f64,
    /// Those farther from there are listed.
    inner: f64,
    centres: Vec<DVec3>,
}

/// Slack of the first survey, as a share of the effective radius.
const SLACK: f64 = 1.0 / 64.0;

/// That of each further one, as a share of the one before.
const FINER: f64 = 1.0 / 8.0;

/// A list of so many is not worth another survey.
const FEW: usize = 24;

/// Nor is one that would serve for fewer births.
const LEAST_BIRTHS: f64 = 4.0;

/// Lists at most: the slack of the last is above what rounding adds to distances.
const MOST_LISTS: usize = 8;

impl Extent {
    /// Mean of the centres, local units.
    pub fn centroid(&self) -> DVec3 {
        self.centroid
    }

    /// Effective radius R_e: the distance from the centroid to the farthest centre, local units.
    pub fn effective_radius(&self) -> f64 {
        self.radius
    }

    /// Takes in the last of the elements.
    pub(crate) fn add(&mut self, elements: &Population<'_>) {
        let Some((_, last)) = elements.youngest() else {
            return;
        };
        self.sum += last.position;
        let before = std::mem::replace(&mut self.centroid, self.sum / elements.len() as f64);
        self.rims.iter_mut().for_each(|rim| rim.add(last.position));
        let outdated = |rim: &Rim| !rim.serves(self.centroid, self.radius);
        if let Some(first) = self.rims.iter().position(outdated) {
            self.rims.truncate(first);
        }
        self.survey(elements, self.centroid.distance(before));
        self.radius = match self.rims.last() {
            Some(rim) => farthest(rim.centres.iter().copied(), self.centroid),
            None => 0.0,
        };
    }

    /// Makes lists until the last is short, or would not serve for long where the centroid moves so far
    /// a birth.
    fn survey(&mut self, elements: &Population<'_>, moves: f64) {
        if self.rims.is_empty() {
            let centres = elements.since(0).map(|e| e.position);
            self.rims.push(Rim::new(centres, self.centroid, None));
        }
        while let Some(rim) = self.rims.last()
            && rim.centres.len() > FEW
            && self.rims.len() < MOST_LISTS
            && FINER * rim.slack > LEAST_BIRTHS * moves
        {
            let (centres, slack) = (rim.centres.iter().copied(), FINER * rim.slack);
            let finer = Rim::new(centres, self.centroid, Some(slack));
            self.rims.push(finer);
        }
    }
}

impl Rim {
    /// Those of some centres that can be the farthest while the centroid stays within a slack of where it
    /// is: all but those nearer than R − 2·slack, which stay nearer than R − slack.
    fn new(
        centres: impl Iterator<Item = DVec3> + Clone,
        centroid: DVec3,
        slack: Option<f64>,
    ) -> Self {
        let radius = farthest(centres.clone(), centroid);
        let slack = slack.unwrap_or(SLACK * radius);
        let inner = radius - 2.0 * slack;
        Self {
            surveyed_from: centroid,
            slack,
            inner,
            centres: centres.filter(|p| p.distance(centroid) >= inner).collect(),
        }
    }

    fn add(&mut self, p: DVec3) {
        if p.distance(self.surveyed_from) >= self.inner {
            self.centres.push(p);
        }
    }

    /// Whether the farthest is one of these, and they are not many more than need be.
    fn serves(&self, centroid: DVec3, radius: f64) -> bool {
        let moved = centroid.distance(self.surveyed_from);
        moved <= self.slack && radius <= self.inner + 8.0 * self.slack
    }
}

/// The distance to the farthest of some centres.
fn farthest(centres: impl Iterator<Item = DVec3>, from: DVec3) -> f64 {
    let farthest_sq = centres.map(|p| p.distance_squared(from));
    farthest_sq.fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::Element;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::SurfacePoint;

    fn element(position: DVec3) -> Element {
        Element {
            at: SurfacePoint::centroid(0),
            position,
            parent: 0,
            colony: 0,
            probability: 1.0,
        }
    }

    /// Adds centres one by one, and compares with all of them each time. The most lists that there were.
    fn lists_for(centres: impl Iterator<Item = DVec3>) -> usize {
        let (mut elements, mut extent, mut lists) = (Vec::new(), Extent::default(), 0);
        for p in centres {
            elements.push(element(p));
            extent.add(&(&elements).into());
            let mean = elements.iter().map(|e| e.position).sum::<DVec3>() / elements.len() as f64;
            let far = farthest(elements.iter().map(|e| e.position), mean);
            assert!(extent.centroid().distance(mean) < 1e-9);
            assert!(
                (extent.effective_radius() - far).abs() < 1e-9,
                "at birth {}",
                elements.len()
            );
            lists = lists.max(extent.rims.len());
        }
        lists
    }

    #[test]
    fn matches_brute_force_after_every_birth() {
        let mut stream = Stream::new(7, Purpose::Walker, 0);
        let spreading = (0..3000).map(|i| {
            let p = stream.in_unit_disc() * f64::from(1 + i).sqrt();
            DVec3::new(p.x + 3.0 * f64::from(i / 1000), p.y, stream.uniform())
        });
        lists_for(spreading);
    }

    #[test]
    fn matches_brute_force_where_all_are_nearly_as_far() {
        let mut stream = Stream::new(8, Purpose::Walker, 0);
        let on_a_ball = (0..6000).map(|_| {
            let aside = |stream: &mut Stream| stream.uniform() - 0.5;
            let p = DVec3::from([0; 3].map(|_| aside(&mut stream)));
            p.normalize_or(DVec3::X) * (1.0 + 0.01 * stream.uniform())
        });
        let lists = lists_for(on_a_ball);
        assert!(lists > 1, "{lists}");
    }

    #[test]
    fn lists_serve_wherever_the_centroid_goes_within_the_slack() {
        let mut stream = Stream::new(9, Purpose::Walker, 0);
        for _ in 0..2000 {
            let at = |stream: &mut Stream| stream.in_unit_disc().normalize().extend(0.0);
            let few: Vec<DVec3> = (0..8)
                .map(|_| at(&mut stream) * (1.0 - 4.0 * SLACK * stream.uniform()))
                .collect();
            let rim = Rim::new(few.iter().copied(), DVec3::ZERO, None);
            let moved = at(&mut stream) * rim.slack * 0.999;
            assert!(rim.serves(moved, 1.0));
            let listed = farthest(rim.centres.iter().copied(), moved);
            assert_eq!(listed, farthest(few.iter().copied(), moved));
        }
    }
}
