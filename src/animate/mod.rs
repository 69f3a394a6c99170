//! When each element of a grown lichen comes, in an animation of so many frames (Sumner 2001, 8.2).
//!
//! A [`Timing`] makes a list of [`Presence`]s, a moment for each frame. [`SkinFrames`] makes the
//! skins of these moments, and [`Scene::at`] what other files show of them.
//!
//! [`SkinFrames`]: crate::skin::SkinFrames
//! [`Scene::at`]: crate::export::Scene::at

mod curve;

pub use curve::{Curve, CurveError};

use std::collections::HashMap;

use glam::DVec3;

use crate::cluster::{Cluster, Ease, Element, Presence};

/// What grows evenly from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Clock {
    /// The number of elements.
    #[default]
    Birth,
    /// The radius, as real lichens widen by about the same length a year (R. Armstrong and T. Bradwell,
    /// *Growth of foliose lichens: a review*, 2011). It is that of gyration, which a lichen that keeps
    /// its shape has in a fixed ratio to R_e, and which does not leap where one lobe gets ahead. Where it
    /// stands still while gaps close, what is born meanwhile comes at once. Each colony has its own: of several
    /// the root of the mean square counts.
    Radius,
    /// Time on a curve of one's own.
    Curve(Curve),
}

/// How the growth of a lichen is spread over frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// How many frames, 1 or more.
    pub frames: u32,
    /// See [`Presence`]: elements over which influence fades, 0 or more.
    pub window: f64,
    /// How it fades.
    pub ease: Ease,
    /// What grows evenly.
    pub clock: Clock,
}

/// Why there is no such animation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimingError {
    /// There is nothing to animate.
    #[error("there are no elements to animate")]
    Empty,
    /// No frames.
    #[error("an animation has at least one frame")]
    NoFrames,
    /// A window that is no length of time.
    #[error("the window is {0} elements: it may be 0 or more")]
    Window(f64),
    /// The curve goes beyond the last element.
    #[error(
        "the curve goes to {asked} elements, and the lichen has {there}: end it at that, or at 100%"
    )]
    TooMany {
        /// How far it goes.
        asked: f64,
        /// How many there are.
        there: usize,
    },
    /// The curve ends before the first element is there.
    #[error("the curve ends at {0} elements: end it at 1 or more")]
    Nothing(f64),
}

impl Clock {
    /// How many elements there are in the last frame, of a lichen that has so many.
    pub fn end(&self, elements: usize) -> f64 {
        match self {
            Self::Birth | Self::Radius => elements as f64,
            Self::Curve(curve) => curve.elements(1.0, elements),
        }
    }

    /// The most elements that there are in any frame.
    fn most(&self, elements: usize) -> f64 {
        match self {
            Self::Birth | Self::Radius => elements as f64,
            Self::Curve(curve) => curve.most(elements),
        }
    }
}

impl Timing {
    /// A window of four frames of the mean number of births, and no more than a tenth of the
    /// elements that the animation [ends at](Clock::end): wide enough that the rim swells, narrow enough that it does
    /// not blur.
    pub fn usual_window(elements: f64, frames: u32) -> f64 {
        (4.0 * elements / f64::from(frames.max(1))).min(0.1 * elements)
    }

    /// The moments of the frames k = 1 … F, each later than the one before or as late.
    ///
    /// With n elements on the clock at the share k/F of the time, and n_F at its end, the moment is
    /// t = n − W·(1 − n/n_F): before the first frame there is nothing, not even what fades in, and in
    /// the last frame all n_F elements have their full influence. With W = 0, t = n.
    ///
    /// # Errors
    /// When there are no elements or frames, when the window is no length, or when the curve ends
    /// before the first element or beyond the last.
    pub fn moments(&self, cluster: &Cluster) -> Result<Vec<Presence>, TimingError> {
        let there = cluster.len();
        match *self {
            _ if there == 0 => return Err(TimingError::Empty),
            Self { frames: 0, .. } => return Err(TimingError::NoFrames),
            Self { window, .. } if !(window >= 0.0 && window.is_finite()) => {
                return Err(TimingError::Window(window));
            }
            _ => {}
        }
        let counts = self.counts(cluster);
        let last = counts.last().copied().unwrap_or_default();
        let most = self.clock.most(there);
        if most > there as f64 {
            return Err(TimingError::TooMany { asked: most, there });
        }
        if last < 1.0 {
            return Err(TimingError::Nothing(last));
        }
        let at = |n: f64| Presence {
            time: n - self.window * (1.0 - n / last),
            window: self.window,
            ease: self.ease,
        };
        Ok(counts.into_iter().map(at).collect())
    }

    /// Elements on the clock at each frame.
    fn counts(&self, cluster: &Cluster) -> Vec<f64> {
        let shares = (1..=self.frames).map(|k| f64::from(k) / f64::from(self.frames));
        let all = cluster.len() as f64;
        match &self.clock {
            Clock::Birth => shares.map(|s| s * all).collect(),
            Clock::Curve(curve) => shares.map(|s| curve.elements(s, cluster.len())).collect(),
            Clock::Radius => {
                let radii = radii(cluster);
                let mut counts: Vec<f64> = shares.map(|s| reaching(&radii, s)).collect();
                // Elements that no longer widen it belong to the last frame.
                counts.pop();
                counts.push(all);
                counts
            }
        }
    }
}

/// The largest radius of gyration so far, after each birth: root of the mean squared distance from the centroid, of
/// several colonies from those of each.
fn radii(cluster: &Cluster) -> Vec<f64> {
    let (mut spreads, mut all) = (HashMap::<u32, Spread>::new(), 0.0);
    let (mut sum, mut most) = (0.0, 0.0);
    let radius = |element: &Element| {
        let own = spreads.entry(element.colony);
        let own = own.or_insert_with(|| Spread::about(element.position));
        sum -= own.sum_of_squares();
        own.add(element.position);
        sum += own.sum_of_squares();
        all += 1.0;
        most = (sum / all).max(most);
        most.sqrt()
    };
    cluster.elements().iter().map(radius).collect()
}

/// How far the elements of a colony are from their centroid.
struct Spread {
    seed: DVec3,
    count: f64,
    /// Of the ways from the seed, and their squares.
    sum: DVec3,
    squares: f64,
}

impl Spread {
    fn about(seed: DVec3) -> Self {
        Self {
            seed,
            count: 0.0,
            sum: DVec3::ZERO,
            squares: 0.0,
        }
    }

    fn add(&mut self, place: DVec3) {
        let way = place - self.seed;
        self.count += 1.0;
        self.sum += way;
        self.squares += way.length_squared();
    }

    /// Of the distances from the centroid.
    fn sum_of_squares(&self) -> f64 {
        match self.count {
            0.0 => 0.0,
            count => self.squares - self.sum.length_squared() / count,
        }
    }
}

/// How many elements have this share of the last radius, between births by straight lines.
fn reaching(radii: &[f64], share: f64) -> f64 {
    let wanted = share * radii.last().copied().unwrap_or_default();
    let after = radii.partition_point(|r| *r < wanted).min(radii.len() - 1);
    let before = match after {
        0 => 0.0,
        _ => radii[after - 1],
    };
    let step = radii[after] - before;
    let part = if step > 0.0 {
        (wanted - before) / step
    } else {
        1.0
    };
    after as f64 + part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::SurfacePoint;

    /// Pairs of elements, the k-th pair k² away on both sides, and a last one in the middle.
    fn spread(pairs: u32) -> Cluster {
        let mut cluster = Cluster::new(0.1);
        let places = (1..=pairs).flat_map(|k| [1.0, -1.0].map(|side| side * f64::from(k * k)));
        for x in places.chain([0.0]) {
            cluster.push(Element {
                at: SurfacePoint::centroid(0),
                position: DVec3::new(x, 0.0, 0.0),
                parent: 0,
                colony: 0,
                probability: 1.0,
            });
        }
        cluster
    }

    fn timing(frames: u32, window: f64, clock: Clock) -> Timing {
        Timing {
            frames,
            window,
            ease: Ease::Linear,
            clock,
        }
    }

    fn times(timing: &Timing, cluster: &Cluster) -> Vec<f64> {
        let moments = timing.moments(cluster).unwrap();
        moments.iter().map(|m| m.time).collect()
    }

    #[test]
    fn by_birth_each_frame_has_as_many_more() {
        let cluster = spread(10);
        assert_eq!(
            times(&timing(3, 0.0, Clock::Birth), &cluster),
            [7.0, 14.0, 21.0]
        );
        // From nothing, not even fading in, to all.
        let wide = times(&timing(21, 10.5, Clock::Birth), &cluster);
        assert_eq!((wide[0], wide[20]), (1.0 - 10.0, 21.0));
        assert!(wide.is_sorted());
    }

    #[test]
    fn by_radius_each_frame_is_as_much_wider() {
        let cluster = spread(60);
        let radii = radii(&cluster);
        let times = times(&timing(30, 0.0, Clock::Radius), &cluster);
        for (k, time) in times[..29].iter().enumerate() {
            let wanted = (k + 1) as f64 / 30.0 * radii[120];
            let i = time.floor() as usize;
            let straight = radii[i - 1] + (time - time.floor()) * (radii[i] - radii[i - 1]);
            assert!(
                (straight - wanted).abs() < 1e-9 * wanted,
                "{straight} {wanted}"
            );
        }
        assert_eq!(times[29], 121.0);
        let alone = spread(0);
        assert_eq!(
            super::tests::times(&timing(2, 0.0, Clock::Radius), &alone),
            [1.0, 1.0]
        );
    }

    /// Two unlike that grow in turn, far from each other: of all, the mean square about the centroids of each.
    #[test]
    fn several_colonies_widen_each_by_itself() {
        let one = spread(60);
        let mut two = Cluster::new(0.1);
        for element in one.elements() {
            for (colony, size, away) in [(0, 1.0, 0.0), (1, 3.0, 1e7)] {
                two.push(Element {
                    position: size * element.position + DVec3::Y * away,
                    colony,
                    ..*element
                });
            }
        }
        let [one, two] = [one, two].map(|cluster| radii(&cluster));
        for (n, alone) in one.iter().enumerate() {
            // The squares of the sizes are 1 and 9.
            let expected = 5f64.sqrt() * alone;
            let found = two[2 * n + 1];
            assert!(
                (found - expected).abs() < 1e-6 * (1.0 + expected),
                "{n}: {found} {expected}"
            );
        }
    }

    /// One far ahead of all others makes no leap of it.
    #[test]
    fn the_radius_of_many_is_not_that_of_one() {
        let mut cluster = Cluster::new(0.1);
        let golden = 2.399_963_229_728_653;
        for k in 0..2000u32 {
            let ahead = if k == 1000 { 2.0 } else { 1.0 };
            let (sin, cos) = (f64::from(k) * golden).sin_cos();
            let position = ahead * f64::from(k).sqrt() * DVec3::new(cos, sin, 0.0);
            cluster.push(Element {
                at: SurfacePoint::centroid(0),
                position,
                parent: 0,
                colony: 0,
                probability: 1.0,
            });
        }
        let times = times(&timing(50, 0.0, Clock::Radius), &cluster);
        for (k, time) in (1..).map(f64::from).zip(&times).skip(9) {
            let even = 2000.0 * (k / 50.0) * (k / 50.0);
            assert!(
                (time - even).abs() < 0.01 * 2000.0,
                "{k}: {time}, not {even}"
            );
        }
    }

    #[test]
    fn a_curve_says_how_many() {
        let cluster = spread(10);
        let clock = |text: &str| Clock::Curve(text.parse().unwrap());
        let paused = timing(4, 0.0, clock("0:0,1:10,3:10,4:100%"));
        assert_eq!(times(&paused, &cluster), [10.0, 10.0, 10.0, 21.0]);
        let partial = timing(2, 6.0, clock("10:0,20:12"));
        assert_eq!(times(&partial, &cluster), [6.0 - 3.0, 12.0]);
        let beyond = timing(2, 0.0, clock("0:0,1:22")).moments(&cluster);
        let expected = TimingError::TooMany {
            asked: 22.0,
            there: 21,
        };
        assert_eq!(beyond, Err(expected.clone()));
        let falling = timing(2, 0.0, clock("0:0,1:22,2:100%")).moments(&cluster);
        assert_eq!(falling, Err(expected));
    }

    #[test]
    fn what_is_no_animation_is_refused() {
        let cluster = spread(1);
        let error = |timing: Timing| timing.moments(&cluster).unwrap_err();
        assert_eq!(error(timing(0, 0.0, Clock::Birth)), TimingError::NoFrames);
        assert_eq!(
            error(timing(1, -1.0, Clock::Birth)),
            TimingError::Window(-1.0)
        );
        assert!(matches!(
            error(timing(1, f64::NAN, Clock::Birth)),
            TimingError::Window(_)
        ));
        let none = timing(1, 0.0, Clock::Birth).moments(&Cluster::new(1.0));
        assert_eq!(none, Err(TimingError::Empty));
    }
}
