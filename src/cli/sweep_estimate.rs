//! About how long a sweep takes: growing, what is measured of each lichen, and the pictures.

use thallus::run::Recipe;
use thallus::substrate::Substrate;

use super::foreseen;
use super::sweep_view::PictureStyle;

/// Seconds an element on one thread for the measures of a finished run: 33 to 40 µs were found at 4,000
/// to 100,000 elements, as much as many take to grow.
const MEASURES: f64 = 35e-6;

/// Seconds an element to read it again and to put a skin on it, of all threads together.
const SKIN: f64 = 15e-6;

/// Seconds a pixel at one ray of all threads together; rays are added where they are needed, and about √N
/// times the time was found for N of them: 16 took 2.4 times as long as 4.
const PIXEL: f64 = 0.95e-6;

/// What the runs of a sweep take on one thread.
#[derive(Debug, Default)]
pub(super) struct Estimate {
    /// All runs, one after the other.
    runs: f64,
    /// The longest of them, which one thread grows alone.
    longest: f64,
    pictures: f64,
}

impl Estimate {
    pub(super) fn add_run(&mut self, substrate: &Substrate, recipe: &Recipe) {
        let measures = MEASURES * foreseen::expected_elements(substrate, recipe);
        let seconds = foreseen::seconds(substrate, recipe) + measures;
        self.runs += seconds;
        self.longest = self.longest.max(seconds);
    }

    pub(super) fn add_picture(
        &mut self,
        substrate: &Substrate,
        recipe: &Recipe,
        style: &PictureStyle,
    ) {
        let pixels = f64::from(style.size.width) * f64::from(style.size.height);
        let rays = f64::from(style.samples).sqrt();
        let skin = SKIN * foreseen::expected_elements(substrate, recipe);
        self.pictures += skin + PIXEL * pixels * rays;
    }

    /// Seconds that go by on so many threads.
    pub(super) fn seconds(&self, threads: usize) -> f64 {
        let threads = threads.max(1) as f64;
        (self.runs / threads).max(self.longest) + self.pictures / threads
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use thallus::run::{Length, Settings, StopSetting};

    use super::*;
    use crate::cli::render_args::Size;

    fn rock() -> Substrate {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/rock.obj");
        Substrate::load(&file).unwrap()
    }

    fn recipe(substrate: &Substrate, curvature_radius: f64, bias: f64) -> Recipe {
        let settings = Settings {
            curvature_radius: Some(Length::Radii(curvature_radius)),
            bias: Some(bias),
            stop: Some(StopSetting::Reach(Length::Radii(150.0))),
            ..Settings::default()
        };
        settings.resolve(substrate, "").unwrap()
    }

    /// Took 4.7 CPU seconds, 72,000 elements: `thallus sweep meshes/rock.obj --L 5r,20r --B 0.3,0.9
    /// --seeds 2 --size 16x16`.
    #[test]
    fn small_cells_take_what_was_measured_within_a_factor_of_two() {
        let rock = rock();
        let (mut estimate, mut found) = (Estimate::default(), 0.0);
        let style = PictureStyle {
            size: Size {
                width: 16,
                height: 16,
            },
            ..PictureStyle::usual()
        };
        for (curvature_radius, bias) in [(5.0, 0.3), (5.0, 0.9), (20.0, 0.3), (20.0, 0.9)] {
            let recipe = recipe(&rock, curvature_radius, bias);
            for _seed in 0..2 {
                estimate.add_run(&rock, &recipe);
                found += foreseen::expected_elements(&rock, &recipe);
            }
            estimate.add_picture(&rock, &recipe, &style);
        }
        assert!((36e3..144e3).contains(&found), "{found}");
        let seconds = estimate.seconds(1);
        assert!((2.35..9.4).contains(&seconds), "{seconds}");
        assert!(estimate.seconds(2) > 0.49 * seconds);
        assert!(estimate.seconds(1000) > estimate.longest);
    }

    #[test]
    fn pictures_take_longer_the_larger_they_are() {
        let rock = rock();
        let recipe = recipe(&rock, 10.0, 0.9);
        let seconds = |width, samples| {
            let style = PictureStyle {
                size: Size { width, height: 800 },
                samples,
                ..PictureStyle::usual()
            };
            let mut estimate = Estimate::default();
            estimate.add_picture(&rock, &recipe, &style);
            estimate.seconds(1)
        };
        // 100,000 elements took 1.1 s more than at 16 x 16.
        assert!((0.55..2.2).contains(&seconds(800, 4)));
        assert!(seconds(1600, 4) > 1.8 * seconds(800, 4));
        assert!(seconds(800, 16) > 1.8 * seconds(800, 4));
    }
}
