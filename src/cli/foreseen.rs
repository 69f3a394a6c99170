//! How many elements a run will have, and how long it will take, told before it starts: the time within a factor of two
//! for the usual settings, as docs/performance.md has their times, and of three for those that the tests below have.

use std::f64::consts::PI;

use thallus::growth::{CROSSINGS_PER_TRIANGLE, Join, Law, SeedPlace, Steps};
use thallus::run::{Recipe, StopRule};
use thallus::substrate::Substrate;

use super::progress::DIMENSION;

/// Seconds an element on one thread, besides those for its contacts.
const WALK: f64 = 12e-6;

/// How many times as long walkers take on a fine mesh, over coarser copies and without them.
const ON_COPIES: f64 = 2.0;
const WITHOUT_COPIES: f64 = 6.0;

/// Seconds that steps no longer than r take an element, for each square of the lichen's radius over r: walkers diffuse
/// from where they are launched. Less where paths are Brownian, for steps there are not as short.
const SMALL_STEPS: f64 = 1.4e-6;

/// Seconds a contact, and the curvature radius over r at which counting the elements within it takes as long again.
const CONTACT: f64 = 0.8e-6;
const COUNTED: f64 = 80.0;

/// Seconds for an element of an earlier run, to be put in its place again.
const REPLAY: f64 = 3e-6;

/// Seconds a triangle for coarser copies, on one thread.
const COPY: f64 = 1e-6;

/// Edges that an element's walkers cross at least.
const CROSSED: f64 = 300.0;

/// A round lichen sticks less than a straight edge does, by this times A L over its radius.
const ROUNDNESS: f64 = 0.3;

/// Of contacts with a lichen too round to stick at all but by the lowest chance, those with its tips.
const TIPS: f64 = 0.75;

/// How many times elements cover a surface at most: packed discs cover 0.91 of a plane.
pub(super) const MOST_COVERED: f64 = 1.0;

/// How many times they do when no more find room: packed they stopped at 0.74 on the rock, and where they only touch at
/// 0.6.
fn usually_covered(join: Join) -> f64 {
    match join {
        Join::Pack => 0.8,
        Join::Touch => 0.65,
    }
}

/// About how many elements a run will have.
pub(super) fn expected_elements(substrate: &Substrate, recipe: &Recipe) -> f64 {
    expected_and_most(substrate, recipe)[0]
}

/// The same, and how many it may have, for memory: the room for them is looked for once.
pub(super) fn expected_and_most(substrate: &Substrate, recipe: &Recipe) -> [f64; 2] {
    let cover = room(substrate, recipe);
    let asked = match recipe.stop {
        StopRule::Elements(n) => n as f64,
        StopRule::Reach(length) => {
            colonies(recipe) * Growing::by(recipe).elements(length / recipe.radius)
        }
        StopRule::Cover(share) => share * cover,
    };
    [usually_covered(recipe.join), MOST_COVERED].map(|most| asked.min(most * cover))
}

/// Area of what a run grows on over that of an element.
fn room(substrate: &Substrate, recipe: &Recipe) -> f64 {
    let area = substrate.units().area_to_file(area(substrate, recipe));
    area / (PI * recipe.radius * recipe.radius)
}

/// Of the pieces of the mesh that a run grows on, as far as it may. To find where chance puts a seed takes a look at
/// every triangle.
fn area(substrate: &Substrate, recipe: &Recipe) -> f64 {
    let habitat = recipe.habitat(substrate);
    let largest = || habitat.area(std::iter::once(0));
    let is_on_largest = recipe.at == [SeedPlace::Top] && habitat.is_everywhere();
    if substrate.components().len() == 1 || is_on_largest {
        return largest();
    }
    match recipe.seeds(substrate) {
        Ok(seeds) => habitat.area(seeds.iter().map(|at| at.triangle)),
        Err(_) => largest(),
    }
}

fn colonies(recipe: &Recipe) -> f64 {
    recipe.at.len() as f64
}

/// How many elements a lichen has by its effective radius: share (R_e/r)^D.
struct Growing {
    share: f64,
    dimension: f64,
}

impl Growing {
    /// The curvature rule closes gaps, the more the smaller B is. D was 1.88 to 1.9 at B = 0.1 and 0.3, 1.82 at 0.5,
    /// 1.75 at 0.7 and 1.7 at 0.9, at 150 and 400 radii. Without it the share was 0.63 to 0.73, and half of that
    /// where elements only touch, at 100 to 1000 radii.
    fn by(recipe: &Recipe) -> Self {
        const CLOSED: f64 = 1.9;
        const OPEN: f64 = 1.7;
        if sticks_everywhere_alike(recipe) {
            let share = match recipe.join {
                Join::Pack => 0.68,
                Join::Touch => 0.36,
            };
            return Self {
                share,
                dimension: DIMENSION,
            };
        }
        let closed = ((0.9 - recipe.bias) / 0.6).clamp(0.0, 1.0);
        Self {
            share: 1.0,
            dimension: OPEN + (CLOSED - OPEN) * closed,
        }
    }

    /// At an effective radius of so many radii of elements.
    fn elements(&self, reach: f64) -> f64 {
        self.share * reach.powf(self.dimension)
    }

    /// The effective radius of so many elements, over theirs.
    fn reach(&self, elements: f64) -> f64 {
        (elements / self.share).powf(self.dimension.recip())
    }
}

fn sticks_everywhere_alike(recipe: &Recipe) -> bool {
    recipe.gain == 0.0 || recipe.min_stick == 1.0
}

/// About how long a run takes on one thread.
pub(super) fn seconds(substrate: &Substrate, recipe: &Recipe) -> f64 {
    seconds_from(substrate, recipe, 0.0)
}

/// The same for one that goes on with so many elements.
pub(super) fn seconds_from(substrate: &Substrate, recipe: &Recipe, grown: f64) -> f64 {
    let copying = match copies(substrate, recipe) {
        true => COPY * substrate.triangles().len() as f64,
        false => 0.0,
    };
    let all = expected_elements(substrate, recipe).max(grown);
    let growing = grow_seconds(substrate, recipe, all) - grow_seconds(substrate, recipe, grown);
    copying + REPLAY * grown + growing
}

/// What the first so many elements take.
fn grow_seconds(substrate: &Substrate, recipe: &Recipe, elements: f64) -> f64 {
    let colonies = colonies(recipe);
    let each = elements / colonies;
    let across = Growing::by(recipe).reach(each);
    let walking = elements * walk(substrate, recipe, across);
    let within = (recipe.curvature_radius / recipe.radius).min(across);
    let contact = match sticks_everywhere_alike(recipe) {
        true => CONTACT,
        false => CONTACT * (1.0 + within / COUNTED),
    };
    walking + contact * colonies * contacts(recipe, each)
}

/// What the walkers of an element take in a lichen that becomes as large as this, besides for contacts.
fn walk(substrate: &Substrate, recipe: &Recipe, across: f64) -> f64 {
    let of_mesh = match (substrate.is_fine(), recipe.steps) {
        (false, _) => 1.0,
        (true, Steps::Large) => ON_COPIES,
        (true, _) => WITHOUT_COPIES,
    };
    let of_law = match recipe.law {
        Law::Thesis => 1.0,
        Law::Brownian => 0.6,
    };
    let small = match recipe.steps {
        Steps::Small => of_law * SMALL_STEPS * spread_sq(substrate, recipe, across),
        _ => 0.0,
    };
    of_mesh * (WALK + small)
}

/// Square of the radius that holds the lichen, which becomes as large as this: of several colonies what would hold the
/// surface.
fn spread_sq(substrate: &Substrate, recipe: &Recipe, across: f64) -> f64 {
    match recipe.at.len() {
        1 => across * across,
        _ => room(substrate, recipe).max(across * across),
    }
}

/// Whether a run is so long that coarser copies of the mesh are made.
pub(super) fn copies(substrate: &Substrate, recipe: &Recipe) -> bool {
    let crossed = CROSSED * expected_elements(substrate, recipe);
    let until_copied = CROSSINGS_PER_TRIANGLE as f64 * substrate.triangles().len() as f64;
    let is_long = crossed > until_copied;
    substrate.is_fine() && recipe.steps == Steps::Large && is_long
}

/// About how many contacts so many elements take.
///
/// As long as the lichen is so small, and so round, that its edge sticks by the lowest chance alone, each takes what
/// that takes. Later 9 were measured at B = 0.5 and 26 at 0.3.
fn contacts(recipe: &Recipe, elements: f64) -> f64 {
    let (bias, gain) = (recipe.bias, recipe.gain);
    if sticks_everywhere_alike(recipe) {
        return elements / bias.max(recipe.min_stick).min(1.0);
    }
    // The density is never less than 0, so P is never less than B − A.
    let least = recipe.min_stick.max(bias - gain).min(1.0);
    let refused = (TIPS / least).max(1.0);
    let settled = 9.0 * (5.2 * (0.5 - bias / gain.max(1.0))).exp();
    let round = ROUNDNESS * gain * recipe.curvature_radius / recipe.radius;
    let until = match bias > 0.0 {
        true => (round / bias).powi(2).min(elements),
        false => elements,
    };
    until * refused + (elements - until) * settled.min(refused).max(1.0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use thallus::run::{Length, Settings, StopSetting};
    use thallus::substrate::Soup;

    use super::*;

    fn load(file: &str) -> Substrate {
        let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes");
        Substrate::load(&meshes.join(file)).unwrap()
    }

    /// Contacts an element of 5,000 on the rock, for B, A, P_min and L over r.
    const MEASURED: [(f64, f64, f64, f64, f64); 19] = [
        (0.5, 0.0, 0.01, 10.0, 2.0),
        (0.05, 0.0, 0.01, 10.0, 20.0),
        (0.0, 0.0, 0.0001, 10.0, 9956.0),
        (1.0, 1.0, 0.01, 10.0, 2.2),
        (0.5, 1.0, 0.01, 10.0, 9.7),
        (0.3, 1.0, 0.01, 10.0, 26.5),
        (0.1, 1.0, 0.01, 10.0, 73.7),
        (0.0, 1.0, 0.01, 10.0, 84.4),
        (-0.5, 1.0, 0.01, 10.0, 99.8),
        (0.5, 1.0, 0.0001, 10.0, 64.7),
        (0.3, 1.0, 0.0001, 10.0, 113.9),
        (0.1, 1.0, 0.0001, 10.0, 2467.0),
        (0.02, 1.0, 0.0001, 10.0, 6542.0),
        (1.0, 10.0, 0.0001, 10.0, 607.9),
        (0.5, 10.0, 0.0001, 10.0, 3760.0),
        (0.0, 100.0, 0.0001, 10.0, 5440.0),
        (0.5, 1.0, 0.01, 30.0, 15.2),
        (0.5, 1.0, 0.01, 100.0, 69.9),
        (0.5, 1.0, 0.01, 1000.0, 99.3),
    ];

    #[test]
    fn contacts_are_as_measured() {
        let rock = load("rock.obj");
        for (bias, gain, min_stick, radii, measured) in MEASURED {
            let settings = Settings {
                bias: Some(bias),
                gain: Some(gain),
                min_stick: Some(min_stick),
                curvature_radius: Some(Length::Radii(radii)),
                ..Settings::default()
            };
            let recipe = settings.resolve(&rock, "").unwrap();
            let ratio = contacts(&recipe, 5000.0) / 5000.0 / measured;
            assert!(
                (0.4..2.5).contains(&ratio),
                "{bias} {gain} {min_stick} {radii}: {ratio}"
            );
        }
    }

    #[test]
    fn each_element_takes_one_contact_at_least() {
        let rock = load("rock.obj");
        for min_stick in [0.01, 1.0] {
            let settings = Settings {
                bias: Some(2.0),
                min_stick: Some(min_stick),
                ..Settings::default()
            };
            let recipe = settings.resolve(&rock, "").unwrap();
            assert_eq!(contacts(&recipe, 100.0), 100.0);
        }
    }

    /// Microseconds an element in steps of r, of so many elements of 0.001 on the rock.
    #[test]
    fn small_steps_take_as_long_as_measured() {
        let rock = load("rock.obj");
        for (law, plain, elements, measured) in [
            (Law::Thesis, false, 1000, 2027.0),
            (Law::Thesis, false, 2737, 5478.0),
            (Law::Thesis, true, 873, 17_178.0),
            (Law::Brownian, false, 1000, 1001.0),
            (Law::Brownian, false, 3455, 4340.0),
            (Law::Brownian, true, 962, 15_589.0),
        ] {
            let settings = Settings {
                law: Some(law),
                steps: Some(Steps::Small),
                min_stick: plain.then_some(1.0),
                join: plain.then_some(Join::Touch),
                radius: Some(Length::Units(0.001)),
                stop: Some(StopSetting::Elements(elements)),
                ..Settings::default()
            };
            let recipe = settings.resolve(&rock, "").unwrap();
            let each = 1e6 * seconds(&rock, &recipe) / elements as f64;
            let ratio = each / measured;
            assert!(
                (0.5..2.0).contains(&ratio),
                "{law:?} {plain} {elements}: {ratio}"
            );
        }
    }

    #[test]
    fn a_run_that_goes_on_takes_the_rest() {
        let boulder = load("boulder.glb");
        let recipe = |elements| {
            let settings = Settings {
                stop: Some(StopSetting::Elements(elements)),
                ..Settings::default()
            };
            settings.resolve(&boulder, "").unwrap()
        };
        let [half, whole] = [50_000, 100_000].map(recipe);
        let copying = COPY * boulder.triangles().len() as f64;
        let rest = seconds_from(&boulder, &whole, 50_000.0);
        let both = seconds(&boulder, &half) + rest - copying - REPLAY * 50_000.0;
        assert!((both / seconds(&boulder, &whole) - 1.0).abs() < 1e-9);
        let [few, many] = [100, 100_000].map(|n| copies(&boulder, &recipe(n)));
        assert!(many && !few);
    }

    /// On a plane, with r = 0.5 and L = 10 r.
    #[test]
    fn elements_to_a_reach_are_as_measured() {
        let plane = load("plane.obj");
        let (pack, touch) = (Join::Pack, Join::Touch);
        for (bias, min_stick, join, grown) in [
            (0.5, 0.01, pack, 30_564.0),
            (0.3, 0.01, pack, 47_102.0),
            (0.2, 0.01, pack, 52_623.0),
            (0.5, 1.0, pack, 10_904.0),
            (0.5, 1.0, touch, 5290.0),
        ] {
            let settings = Settings {
                radius: Some(Length::Units(0.5)),
                bias: Some(bias),
                min_stick: Some(min_stick),
                join: Some(join),
                stop: Some(StopSetting::Reach(Length::Radii(300.0))),
                ..Settings::default()
            };
            let recipe = settings.resolve(&plane, "").unwrap();
            let ratio = expected_elements(&plane, &recipe) / grown;
            assert!((0.8..1.25).contains(&ratio), "{bias} {min_stick}: {ratio}");
        }
    }

    /// Of two pieces, a large one and a small one.
    #[test]
    fn a_run_has_the_room_of_its_own_piece() {
        let square = |x: f64, side: f64| {
            [[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]].map(|[x, y]| [x, y, 0.0])
        };
        let soup = Soup {
            positions: [square(5.0, 1000.0), square(0.0, 1.0)].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            notes: Vec::new(),
        };
        let substrate = Substrate::from_soup(soup).unwrap();
        let expected = |at: Option<Vec<SeedPlace>>| {
            let settings = Settings {
                radius: Some(Length::Units(0.01)),
                at,
                stop: Some(StopSetting::Cover(0.02)),
                ..Settings::default()
            };
            let recipe = settings.resolve(&substrate, "").unwrap();
            expected_elements(&substrate, &recipe)
        };
        let least = 0.02 / (PI * 1e-4);
        let small = expected(Some(vec![SeedPlace::Point([0.5, 0.5, 0.0])]));
        assert!((small / least - 1.0).abs() < 1e-6, "{small}");
        assert!(expected(None) > 0.99e6 * least);
    }
}
