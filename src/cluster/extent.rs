//! Centroid and effective radius R_e, exact after every birth.

use glam::DVec3;

use super::Element;

/// Mean of the centres in space, and the distance from it to the farthest.
///
/// The centroid moves with every birth, so the farthest centre may change at any time. Only the
/// centres near the rim can become it: they are listed at a survey, the farthest first, and the list
/// serves until the centroid has moved by the slack that it was made with, or the rim has moved out
/// by eight. As long as the centroid has moved little, only the first few of it are looked at.
#[derive(Clone, Debug, Default)]
pub struct Extent {
    sum: DVec3,
    centroid: DVec3,
    radius: f64,
    surveyed_from: DVec3,
    slack: f64,
    /// Centres farther from the surveyed centroid are listed, the farthest first.
    inner: f64,
    rim: Vec<Rim>,
}

/// A centre near the rim, and its distance from the surveyed centroid.
#[derive(Clone, Copy, Debug)]
struct Rim {
    distance: f64,
    position: DVec3,
}

/// Slack of a survey, as a share of the effective radius.
const SLACK: f64 = 1.0 / 64.0;

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
    pub(super) fn add(&mut self, elements: &[Element]) {
        let Some(last) = elements.last() else { return };
        self.sum += last.position;
        self.centroid = self.sum / elements.len() as f64;
        let rim = self.rim_of(last);
        if rim.distance >= self.inner {
            let after = self.rim.partition_point(|r| r.distance >= rim.distance);
            self.rim.insert(after, rim);
        }
        let moved = self.centroid.distance(self.surveyed_from) > self.slack;
        if moved || self.radius > self.inner + 8.0 * self.slack {
            self.survey(elements);
        }
        self.radius = self.farthest();
    }

    fn rim_of(&self, element: &Element) -> Rim {
        Rim {
            distance: element.position.distance(self.surveyed_from),
            position: element.position,
        }
    }

    /// Lists the centres that can be the farthest while the centroid stays within the slack: all
    /// but those nearer than R − 2·slack, which stay nearer than R − slack.
    fn survey(&mut self, elements: &[Element]) {
        let centroid = self.centroid;
        let radius = elements
            .iter()
            .map(|e| e.position.distance(centroid))
            .fold(0.0, f64::max);
        self.surveyed_from = centroid;
        self.slack = SLACK * radius;
        self.inner = radius - 2.0 * self.slack;
        let all = elements.iter().map(|e| self.rim_of(e));
        self.rim = all.filter(|r| r.distance >= self.inner).collect();
        self.rim.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    }

    /// The distance from the centroid to the farthest on the list.
    fn farthest(&self) -> f64 {
        let moved = self.centroid.distance(self.surveyed_from);
        let mut farthest = 0.0;
        for rim in &self.rim {
            if rim.distance + moved < farthest {
                break;
            }
            farthest = rim.position.distance(self.centroid).max(farthest);
        }
        farthest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::SurfacePoint;

    #[test]
    fn matches_brute_force_after_every_birth() {
        let mut stream = Stream::new(7, Purpose::Walker, 0);
        let mut elements = Vec::new();
        let mut extent = Extent::default();
        for i in 0..3000 {
            let p = stream.in_unit_disc() * f64::from(1 + i).sqrt();
            let position = DVec3::new(p.x + 3.0 * f64::from(i / 1000), p.y, stream.uniform());
            elements.push(Element {
                at: SurfacePoint::centroid(0),
                position,
                parent: 0,
                colony: 0,
                probability: 1.0,
            });
            extent.add(&elements);
            let mean = elements.iter().map(|e| e.position).sum::<DVec3>() / elements.len() as f64;
            let far = elements
                .iter()
                .map(|e| e.position.distance(mean))
                .fold(0.0, f64::max);
            assert!(extent.centroid().distance(mean) < 1e-9);
            assert!(
                (extent.effective_radius() - far).abs() < 1e-9,
                "at birth {i}"
            );
        }
    }
}
