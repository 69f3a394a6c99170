//! How much of each element is there at a moment of an animation (Sumner 2001, 8.2).

/// How an element comes in over the window: each goes from 0 to 1, with half at the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ease {
    /// Evenly, as in the thesis: x.
    #[default]
    Linear,
    /// Without a jerk at the ends: 3x² − 2x³.
    Smooth,
    /// Without a jerk in the speed either: 6x⁵ − 15x⁴ + 10x³ (K. Perlin, *Improving noise*, 2002).
    Smoother,
}

impl Ease {
    /// The influence at a share of the window, which is taken for 0 or 1 outside of it.
    pub fn at(self, x: f64) -> f64 {
        let x = x.clamp(0.0, 1.0);
        match self {
            Self::Linear => x,
            Self::Smooth => x * x * (3.0 - 2.0 * x),
            Self::Smoother => x * x * x * (x * (6.0 * x - 15.0) + 10.0),
        }
    }
}

/// A moment of a growth: the first `time` elements have their full influence, and the next ones
/// less and less over a window. Element t + W/2 has half of it, element t + W none.
///
/// With a window of 0 an element is there or not: the thesis's hard cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Presence {
    /// The moment, in elements: 10 is when the tenth has its full influence.
    pub time: f64,
    /// Length of the window, in elements, 0 or more.
    pub window: f64,
    /// How influence rises over the window.
    pub ease: Ease,
}

impl Presence {
    /// The first `count` elements and nothing of the others.
    pub fn first(count: usize) -> Self {
        Self {
            time: count as f64,
            window: 0.0,
            ease: Ease::Linear,
        }
    }

    /// The influence, 0 to 1, of the element of this birth index, which counts from 0.
    pub fn influence(&self, birth: usize) -> f32 {
        let late = (birth + 1) as f64 - self.time;
        if late <= 0.0 {
            1.0
        } else if late >= self.window {
            0.0
        } else {
            self.ease.at(1.0 - late / self.window) as f32
        }
    }

    /// How many of `all` elements have their full influence.
    pub fn settled(&self, all: usize) -> usize {
        (self.time.max(0.0).floor() as usize).min(all)
    }

    /// How many of `all` elements have any influence.
    pub fn born(&self, all: usize) -> usize {
        let end = self.time + self.window;
        let last = match self.window > 0.0 {
            true => end.ceil() - 1.0,
            false => end.floor(),
        };
        // A window may be too short to change the sum.
        (last.max(0.0) as usize).min(all).max(self.settled(all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eases_rise_from_nothing_by_half_to_all() {
        for ease in [Ease::Linear, Ease::Smooth, Ease::Smoother] {
            assert_eq!(
                [-1.0, 0.0, 0.5, 1.0, 2.0].map(|x| ease.at(x)),
                [0.0, 0.0, 0.5, 1.0, 1.0]
            );
            let values: Vec<f64> = (0..=1000).map(|i| ease.at(f64::from(i) / 1000.0)).collect();
            assert!(values.is_sorted());
            // Time can run backwards.
            assert!((0..=1000).all(|i| (values[i] + values[1000 - i] - 1.0).abs() < 1e-12));
        }
    }

    #[test]
    fn elements_come_in_over_the_window() {
        for ease in [Ease::Linear, Ease::Smooth, Ease::Smoother] {
            let presence = Presence {
                time: 10.0,
                window: 8.0,
                ease,
            };
            let influence = |number: usize| presence.influence(number - 1);
            assert_eq!([1, 9, 10].map(influence), [1.0; 3]);
            assert_eq!(influence(14), 0.5);
            assert_eq!([18, 19, 500].map(influence), [0.0; 3]);
            assert_eq!((presence.settled(500), presence.born(500)), (10, 17));
            assert_eq!((presence.settled(5), presence.born(5)), (5, 5));
        }
    }

    #[test]
    fn counts_are_those_of_the_influences() {
        for window in [0.0, f64::MIN_POSITIVE, 1e-15, 0.25, 1.0, 2.5, 7.0] {
            for quarter in -40..80 {
                let time = f64::from(quarter) / 4.0;
                let presence = Presence {
                    time,
                    window,
                    ease: Ease::Smooth,
                };
                let counted =
                    |least: f32| (0..30).filter(|&i| presence.influence(i) > least).count();
                assert_eq!(presence.born(30), counted(0.0), "{presence:?}");
                assert_eq!(presence.settled(30), counted(1.0 - 1e-7), "{presence:?}");
            }
        }
    }

    #[test]
    fn without_a_window_elements_are_there_or_not() {
        let presence = Presence::first(3);
        assert_eq!(
            [0, 1, 2, 3, 4].map(|i| presence.influence(i)),
            [1.0, 1.0, 1.0, 0.0, 0.0]
        );
    }
}
