//! What a run will take in memory, told before it starts, with the [time](super::foreseen).

use std::path::Path;

use thallus::cluster::Cluster;
use thallus::run::{Recipe, StopRule};
use thallus::skin::{Shape, expected_near, expected_triangles};
use thallus::substrate::{Loaded, Substrate};

use super::control_group::{self, number};
use super::failure::Failure;
use super::foreseen::{copies, expected_and_most, seconds_from};
use super::number::{count, duration, short};
use super::terminal::Voice;

/// Bytes that an element takes at the peak of a run, which is when the picture is made. Measured at a
/// million elements: 351 of plain DLA on the plane, which is as sparse as lichen grows, and 365 of
/// packed lichen on the rock. Vectors that grow may take more for a moment.
const BYTES: f64 = 450.0;

/// The same where no picture is made: 279 and 197 were measured.
const BARE_BYTES: f64 = 340.0;

/// Bytes of an element that an earlier run left, from when it is read until all of these are in place again.
const READ_BYTES: f64 = 64.0;

/// Bytes that a triangle of a fine mesh takes besides while coarser copies of it are made, and one of any mesh
/// for its pictures: docs/performance.md has the measurements.
const COPIED_BYTES: f64 = 110.0;
const PICTURED_BYTES: f64 = 190.0;

/// Bytes that a pixel of a preview takes, and one of any picture, which may be transparent.
const TAKEN_BYTES: f64 = 7.5;
const SHADED_BYTES: f64 = 14.0;

/// Bytes that a triangle of a skin takes at the peak, which is while it is made, or while a picture of it is
/// taken: docs/skin.md has the measurements.
const SKIN_BYTES: f64 = 250.0;

/// The same of frames, of which one is written while the next is made, and besides of those that become
/// pictures: docs/animation.md has the measurements.
const FRAME_BYTES: f64 = 250.0;
const PICTURE_BYTES: f64 = 260.0;

/// Bytes that a pixel takes of what is kept from picture to picture, and all of that at most: of large pictures
/// less is kept of each pixel.
const PIXEL_BYTES: f64 = 330.0;
const KEPT_BYTES: f64 = 0.95e9;

/// Bytes for each element that is felt at a triangle, which frames keep, and for what they know of each
/// element's time.
const FELT_BYTES: f64 = 3.5;
const TIMED_BYTES: f64 = 2000.0;

/// Bytes that a texel of maps takes at the peak, and what it takes besides where there is lichen: docs/bake.md
/// has the measurements.
const TEXEL_BYTES: f64 = 30.0;
const LICHEN_BYTES: f64 = 80.0;

/// Bytes that a texel of a part that is done takes until the file that wears it is written: PNG files of the maps in
/// it.
const WORN_BYTES: f64 = 4.0;

/// A triangle while charts of its own are cut and packed: 420 on the shell of a CT scan, more where charts are many.
const CHART_BYTES: f64 = 900.0;

/// Texels that show lichen, at most, for each that elements cover: it is felt beyond them.
const FELT_BEYOND: f64 = 2.0;

/// Runs of so many elements are told what they take, and such as are expected to take a minute, or so many
/// bytes.
const LONG: f64 = 1e6;
const LONG_SECONDS: f64 = 60.0;
const LARGE: f64 = 1e9;

/// What becomes of a run when it has grown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    /// A picture of so many pixels is taken.
    Preview(u64),
    Nothing,
    /// It is measured, and pictured with others.
    Sweep,
}

impl After {
    /// What a picture takes on one thread.
    fn seconds(self) -> f64 {
        const A_PIXEL: f64 = 4e-6;
        match self {
            Self::Preview(pixels) => A_PIXEL * pixels as f64,
            Self::Nothing | Self::Sweep => 0.0,
        }
    }
}

/// Tells what a long run takes that goes on with so many elements, which have been read, and refuses what does not
/// fit.
pub(super) fn check(
    substrate: &Substrate,
    recipe: &Recipe,
    grown: usize,
    after: After,
    voice: Voice,
) -> Result<(), Failure> {
    let [elements, most] = expected_and_most(substrate, recipe).map(|n| n.max(grown as f64));
    let (each, cure) = match after {
        After::Preview(_) => (
            BYTES,
            "ask for fewer, for a larger --radius, or for a smaller --preview (0 for none)",
        ),
        After::Nothing => (BARE_BYTES, "ask for fewer, or for a larger --radius"),
        After::Sweep => (BYTES, "ask for fewer, or for a larger --radius"),
    };
    let more = each * most + besides(substrate, recipe, after);
    let needed = more + READ_BYTES * grown as f64;
    let [number, most] = [elements, most].map(|n| count(n as u64));
    let triangles = count(substrate.triangles().len() as u64);
    let what = format!("up to {most} elements on {triangles} triangles");
    check_free(more, &what, cure)?;
    let seconds = seconds_from(substrate, recipe, grown as f64) + after.seconds();
    if elements - grown as f64 >= LONG || seconds >= LONG_SECONDS || needed >= LARGE {
        let free = available().map_or_else(String::new, |a| format!(" ({} are free)", size(a)));
        let there = match grown {
            0 => String::new(),
            _ => format!(", {} of them there", count(grown as u64)),
        };
        let full = match recipe.stop {
            StopRule::Elements(asked) if asked as f64 > elements => {
                " (there seems to be room for no more)"
            }
            _ => "",
        };
        voice.note(&format!(
            "about {number} elements{there}{full}: up to {} of memory{free}, and roughly {} on one thread",
            size(needed),
            duration(seconds)
        ));
    }
    Ok(())
}

/// Bytes that a run takes for the mesh, which is ready to walk on.
fn besides(substrate: &Substrate, recipe: &Recipe, after: After) -> f64 {
    let triangles = substrate.triangles().len();
    match after {
        After::Preview(pixels) => pictured_bytes(triangles) + TAKEN_BYTES * pixels as f64,
        After::Sweep => pictured_bytes(triangles),
        After::Nothing if copies(substrate, recipe) => COPIED_BYTES * triangles as f64,
        After::Nothing => 0.0,
    }
}

/// Refuses pictures of a mesh that do not fit.
pub(super) fn check_pictured(substrate: &Substrate) -> Result<(), Failure> {
    check_pictured_within(available(), substrate.triangles().len())
}

fn check_pictured_within(free: Option<f64>, triangles: usize) -> Result<(), Failure> {
    let what = format!("pictures of {} triangles", count(triangles as u64));
    check_within(free, pictured_bytes(triangles), &what, THINNER)
}

/// Refuses a picture of so many pixels that does not fit.
pub(super) fn check_size(size: [u32; 2]) -> Result<(), Failure> {
    check_size_within(available(), SHADED_BYTES, size)
}

/// The same of pictures one after the other, of which one is packed while the next is taken.
pub(super) fn check_sizes(size: [u32; 2]) -> Result<(), Failure> {
    check_size_within(available(), 2.0 * SHADED_BYTES, size)
}

fn check_size_within(
    free: Option<f64>,
    each: f64,
    [width, height]: [u32; 2],
) -> Result<(), Failure> {
    let needed = each * f64::from(width) * f64::from(height);
    let what = format!("pictures of {width} x {height} pixels");
    check_within(free, needed, &what, "make them smaller")
}

/// What to do about a mesh that is too large.
const THINNER: &str = "thin the mesh out (in Blender: Decimate), or make room";

/// Bytes of memory that a triangle takes while a mesh is read and made ready to walk on: see docs/performance.md.
const TRIANGLE_BYTES: f64 = 290.0;

/// What is free before a mesh is read.
pub(super) struct Room(Option<f64>);

impl Room {
    pub(super) fn now() -> Self {
        Self(available())
    }

    /// Refuses a mesh that has been read, but is too large for the rest.
    pub(super) fn check(&self, mesh: &Path, loaded: &Loaded) -> Result<(), Failure> {
        let triangles = loaded.soup.triangles.len();
        let needed = TRIANGLE_BYTES * triangles as f64;
        if self.0.is_none_or(|free| needed <= free) {
            return Ok(());
        }
        let what = format!("{}: {} triangles", mesh.display(), count(triangles as u64));
        check_within(self.0, needed, &what, THINNER)
    }
}

/// Refuses what needs more memory than is free, and says what to do.
fn check_free(needed: f64, what: &str, cure: &str) -> Result<(), Failure> {
    check_within(available(), needed, what, cure)
}

/// The same where so much is free, if that is known.
fn check_within(free: Option<f64>, needed: f64, what: &str, cure: &str) -> Result<(), Failure> {
    match free.filter(|free| needed > *free) {
        None => Ok(()),
        Some(free) => Err(Failure::Failed(anyhow::anyhow!(
            "{what} need {} of memory, and {} are free: {cure}",
            size(needed),
            size(free)
        ))),
    }
}

/// Refuses skins, all of which are there at a time, that do not fit; about how many triangles they have.
pub(super) fn check_skins<'a>(
    substrate: &Substrate,
    skins: impl IntoIterator<Item = (&'a Cluster, &'a Shape)>,
) -> Result<f64, Failure> {
    let triangles = |(cluster, shape)| expected_triangles(substrate, cluster, shape);
    let triangles = skins.into_iter().map(triangles).sum();
    check_triangles(triangles, SKIN_BYTES * triangles)?;
    Ok(triangles)
}

/// What becomes of the frames of an animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Frames {
    Meshes,
    /// Of so many pixels each.
    Pictures(u64),
}

/// Refuses frames that do not fit: those of a lichen share what one takes, and keep what is felt where.
pub(super) fn check_frames<'a>(
    substrate: &Substrate,
    lichens: impl IntoIterator<Item = (&'a Cluster, &'a Shape)>,
    frames: Frames,
) -> Result<(), Failure> {
    let (picture, kept) = match frames {
        Frames::Meshes => (0.0, 0.0),
        Frames::Pictures(pixels) => {
            let kept = (PIXEL_BYTES * pixels as f64).min(KEPT_BYTES);
            (PICTURE_BYTES, kept)
        }
    };
    let (mut all, mut needed) = (0.0, kept);
    for (cluster, shape) in lichens {
        let felt = FELT_BYTES * expected_near(cluster, shape);
        let triangles = expected_triangles(substrate, cluster, shape);
        let timed = TIMED_BYTES * cluster.len() as f64;
        all += triangles;
        needed += (FRAME_BYTES + picture + felt) * triangles + timed;
    }
    check_triangles(all, needed)
}

fn check_triangles(triangles: f64, needed: f64) -> Result<(), Failure> {
    let what = format!("about {} triangles of skin", short(triangles));
    check_free(needed, &what, "make --resolution coarser")
}

/// Refuses maps of so many texels in a row that do not fit. They make no skin: its resolution does not matter.
pub(super) fn check_maps<'a>(
    substrate: &Substrate,
    clusters: impl Iterator<Item = &'a Cluster>,
    (texels, parts, kept): (u32, usize, usize),
) -> Result<(), Failure> {
    let area: f64 = substrate.components().iter().map(|c| c.area).sum();
    let covered = clusters.map(Cluster::covered_area).sum::<f64>() / area;
    let free = available().map(|free| free - kept as f64);
    check_maps_within(free, (texels, parts), covered)
}

/// Refuses charts of its own for a mesh that memory has no room for.
pub(super) fn check_charts(substrate: &Substrate) -> Result<(), Failure> {
    let triangles = substrate.triangles().len();
    let what = format!("charts of {} triangles", count(triangles as u64));
    check_within(
        available(),
        CHART_BYTES * triangles as f64,
        &what,
        "decimate the mesh, or unwrap it in another program",
    )
}

fn check_maps_within(
    free: Option<f64>,
    (texels, parts): (u32, usize),
    covered: f64,
) -> Result<(), Failure> {
    let each = TEXEL_BYTES + LICHEN_BYTES * (FELT_BEYOND * covered).min(1.0);
    let kept = WORN_BYTES * parts.saturating_sub(1) as f64;
    let needed = (each + kept) * f64::from(texels).powi(2);
    let of_parts = match parts {
        1 => String::new(),
        several => format!(" for each of {several} parts"),
    };
    let what = format!("maps of {texels} x {texels} texels{of_parts}");
    check_within(free, needed, &what, "make --size smaller")
}

/// Bytes that pictures of a mesh take.
pub(super) fn pictured(substrate: &Substrate) -> f64 {
    pictured_bytes(substrate.triangles().len())
}

fn pictured_bytes(triangles: usize) -> f64 {
    PICTURED_BYTES * triangles as f64
}

/// Bytes that a run with a picture is expected to take at its peak, the mesh aside.
pub(super) fn needed(substrate: &Substrate, recipe: &Recipe) -> f64 {
    let [_, most] = expected_and_most(substrate, recipe);
    BYTES * most
}

/// Bytes of memory that are free, where the system says so: of the machine, of the container, and of what
/// this process may take (`ulimit -v`).
pub(super) fn available() -> Option<f64> {
    [of_machine(), control_group::left(), address_space()]
        .into_iter()
        .flatten()
        .reduce(f64::min)
}

#[cfg(target_os = "linux")]
fn of_machine() -> Option<f64> {
    number("/proc/meminfo", "MemAvailable:").map(|kilobytes| 1024.0 * kilobytes)
}

/// Nought is what systems say that do not tell.
#[cfg(not(target_os = "linux"))]
fn of_machine() -> Option<f64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    Some(system.available_memory() as f64).filter(|&bytes| bytes > 0.0)
}

/// What is left of the limit on this process's addresses.
fn address_space() -> Option<f64> {
    let most = number("/proc/self/limits", "Max address space")?;
    let taken = number("/proc/self/status", "VmSize:")?;
    Some((most - 1024.0 * taken).max(0.0))
}

pub(super) fn size(bytes: f64) -> String {
    match bytes {
        ..1e9 => format!("{} MB", (bytes / 1e6).ceil()),
        _ => format!("{} GB", short(bytes / 1e9)),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use thallus::run::{Settings, StopSetting};

    use super::*;

    #[test]
    fn meshes_that_do_not_fit_are_refused_with_the_number() {
        let file = Path::new("meshes/rock.obj");
        let loaded = thallus::substrate::load_soup(file).expect("a mesh");
        let room = |free| Room(free).check(file, &loaded);
        assert!(room(None).is_ok() && room(Some(1.4e6)).is_ok());
        let Err(Failure::Failed(refused)) = room(Some(1.3e6)) else {
            panic!("a mesh of 1.34 MB in 1.3");
        };
        let said = refused.to_string();
        let parts = ["rock.obj", "4,608 triangles", "2 MB are free", "Decimate"];
        assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    }

    #[test]
    fn pictures_of_meshes_that_do_not_fit_are_refused_with_the_number() {
        assert!(check_pictured_within(None, 10_000_000).is_ok());
        assert!(check_pictured_within(Some(2e9), 10_000_000).is_ok());
        let refused = check_pictured_within(Some(1e9), 10_000_000).unwrap_err();
        assert_eq!(
            refused.reason(),
            "pictures of 10,000,000 triangles need 1.9 GB of memory, and 1 GB are free: thin the mesh out \
             (in Blender: Decimate), or make room"
        );
    }

    #[test]
    fn pictures_that_do_not_fit_are_refused_with_the_number() {
        let check = |free| check_size_within(free, SHADED_BYTES, [16_384; 2]);
        assert!(check(None).is_ok() && check(Some(4e9)).is_ok());
        let refused = check(Some(3e9)).unwrap_err();
        assert_eq!(
            refused.reason(),
            "pictures of 16384 x 16384 pixels need 3.758 GB of memory, and 3 GB are free: make them smaller"
        );
    }

    #[test]
    fn a_fine_mesh_counts_where_copies_are_made_and_pictures_taken() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/boulder.glb");
        let boulder = Substrate::load(&file).unwrap();
        let recipe = |elements| {
            let settings = Settings {
                stop: Some(StopSetting::Elements(elements)),
                ..Settings::default()
            };
            settings.resolve(&boulder, "").unwrap()
        };
        let [short, long] = [100, 100_000].map(recipe);
        let triangles = boulder.triangles().len() as f64;
        assert_eq!(besides(&boulder, &short, After::Nothing), 0.0);
        let copied = besides(&boulder, &long, After::Nothing);
        assert_eq!(copied, COPIED_BYTES * triangles);
        for recipe in [&short, &long] {
            let pictured = besides(&boulder, recipe, After::Preview(0));
            assert_eq!(pictured, PICTURED_BYTES * triangles);
        }
        let wide = besides(&boulder, &short, After::Preview(12_000_000));
        assert_eq!(wide - PICTURED_BYTES * triangles, 90e6);
    }

    #[test]
    fn maps_that_do_not_fit_are_refused_with_the_number() {
        for (free, texels, covered) in [
            (None, 8192, 1.0),
            (Some(10e9), 8192, 1.0),
            (Some(3e9), 8192, 0.05),
            (Some(3e9), 4096, 1.0),
        ] {
            assert!(check_maps_within(free, (texels, 1), covered).is_ok());
        }
        let refused = check_maps_within(Some(4e9), (8192, 1), 0.7).unwrap_err();
        assert_eq!(
            refused.reason(),
            "maps of 8192 x 8192 texels need 7.382 GB of memory, and 4 GB are free: make --size smaller"
        );
    }
}
