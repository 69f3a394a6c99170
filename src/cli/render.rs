//! `thallus render`: a picture of a run.

use std::borrow::Borrow;
use std::cell::LazyCell;
use std::iter::zip;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use thallus::cluster::Cluster;
use thallus::export::{Elements, TriMesh, write_file_atomically};
use thallus::picture::{
    Camera, Detail, Disc, Finish, Image, Key, Painted, Scene, Settings, Structure, World,
    draw_legend, number, round_below,
};
use thallus::skin::{self, Cortex, Cover, Paint, Parts, Shape, expected_triangles};
use thallus::substrate::{Substrate, Texturing};

use super::also::{Also, tell_of_overlaps};
use super::dress::{self, Dress, made_up};
use super::failure::Failure;
use super::grown::{Grown, Origin, spare};
use super::interrupt::leave_no_part;
use super::memory;
use super::number::{duration, elements};
use super::output::{check_free, check_names_file};
use super::preview::{granules, staged, stone};
use super::render_args::{RenderArgs, What};
use super::render_by::Coloring;
use super::render_camera::{CameraText, warn_unseen};
use super::run_args::start_threads;
use super::skin_args::ColorArgs;
use super::skin_look::Measure;
use super::terminal::{self, Voice};

pub(crate) fn render(args: &RenderArgs) -> Result<(), Failure> {
    check_shape(args)?;
    check_name(&args.output)?;
    check_names_file(&args.output)?;
    check_free(std::slice::from_ref(&args.output), args.force)?;
    leave_no_part();
    start_threads(args.run.threads)?;
    memory::check_size([args.view.size.width, args.view.size.height])?;
    let mut clock = Clock::new();
    let lichens = Lichens::read(args)?;
    spare(&lichens.files(args), &args.output)?;
    let mut seconds = Seconds::default();
    clock.lap(&mut seconds.load);
    let colored = lichens.colored(args)?;
    let shot = Shot {
        args,
        lichens: &lichens,
        colored: &colored,
    };
    let Taken {
        mut image,
        camera,
        skin_triangles,
    } = shot.take(|| clock.lap(&mut seconds.dress))?;
    if args.view.legend {
        lichens.draw_legend(args, &colored, &camera, &mut image);
    }
    clock.lap(&mut seconds.render);
    let png = image.to_png();
    write_file_atomically(&args.output, args.force, |out| out.write_all(&png))?;
    clock.lap(&mut seconds.write);
    let middle = camera.depth(middle(&colored.discs));
    conclude(
        args,
        &Report {
            file: args.output.display().to_string(),
            width: image.width,
            height: image.height,
            elements: lichens.grown.iter().map(|l| l.cluster.len()).sum(),
            skin_triangles,
            camera: CameraText::of(&camera, middle.max(f32::MIN_POSITIVE), &lichens.substrate),
            seconds: Seconds {
                total: clock.started.elapsed().as_secs_f64(),
                ..seconds
            },
        },
    )
}

/// Of granules only what lies over others has a shape.
fn check_shape(args: &RenderArgs) -> Result<(), Failure> {
    let has_none = args.what == What::Points && args.also.is_empty();
    match args.shape.given.first().filter(|_| has_none) {
        None => Ok(()),
        Some(first) => Err(Failure::usage(format!(
            "{first} is for skins, and --what points draws none: leave one of them away"
        ))),
    }
}

fn check_name(file: &Path) -> Result<(), Failure> {
    let extension = file.extension().and_then(|e| e.to_str());
    match extension.is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        true => Ok(()),
        false => Err(Failure::usage(format!(
            "{}: pictures are PNG; name the file with .png",
            file.display()
        ))),
    }
}

/// Shows that something takes its time.
fn spin<T>(voice: Voice, doing: &str, work: impl FnOnce() -> T) -> T {
    let spinner = voice.spinner(doing);
    let done = work();
    spinner.finish_and_clear();
    done
}

/// One lichen and how it looks.
struct Lichen {
    origin: Origin,
    /// Files that it was read from.
    read: Vec<PathBuf>,
    elements: Elements,
    cluster: Cluster,
    shape: Shape,
    paint: Paint,
}

/// What is to be in the picture.
struct Lichens {
    mesh: PathBuf,
    substrate: Substrate,
    texturing: Texturing,
    grown: Vec<Lichen>,
    /// Those but the first, each of which lies over those before.
    covers: Vec<Cover>,
}

/// Lichens with colours.
#[derive(Default)]
struct Colored {
    /// Every element: where the camera looks.
    discs: Vec<Disc>,
    /// Those that no later lichen hides: the picture itself where it is of points.
    seen: Vec<Disc>,
    coloring: Option<(Coloring, Vec<f64>)>,
}

impl Colored {
    /// Those of the elements, where they are not those of the lichen.
    fn colors(&self) -> Option<Vec<[u8; 3]>> {
        self.coloring.as_ref().map(|(c, values)| c.colors(values))
    }
}

/// A skin as pictures take it.
pub(super) struct Skin<'a> {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[u8; 3]>,
    triangles: Vec<[u32; 3]>,
    grain: f32,
    structure: Option<Cut<'a, Cortex>>,
}

/// The structure of a skin, as fine as it is. It is known for places of the substrate, from which a thick skin is far.
pub(super) struct Cut<'a, C> {
    cortex: C,
    substrate: &'a Substrate,
    vertices: Vec<Vertex>,
}

struct Vertex {
    place: [f32; 3],
    /// The place of the substrate nearest to it, once a picture has asked: most of a skin's are seen by none.
    foot: OnceLock<[f32; 3]>,
}

impl<'a, C> Cut<'a, C> {
    pub(super) fn new(cortex: C, substrate: &'a Substrate, skin: &Skin) -> Self {
        let vertex = |&place: &[f32; 3]| Vertex {
            place,
            foot: OnceLock::new(),
        };
        Self {
            cortex,
            substrate,
            vertices: skin.positions.iter().map(vertex).collect(),
        }
    }
}

impl<C: Borrow<Cortex> + Sync> Structure for Cut<'_, C> {
    fn foot(&self, vertex: u32) -> Option<[f32; 3]> {
        let Vertex { place, foot } = self.vertices.get(vertex as usize)?;
        let find = || {
            let (foot, _) = self.substrate.nearest(place.map(f64::from).into());
            self.substrate.position(&foot).as_vec3().to_array()
        };
        Some(*foot.get_or_init(find))
    }

    fn at(&self, place: [f32; 3], normal: [f32; 3]) -> Detail {
        let detail = self.cortex.borrow().at(place.map(f64::from), normal, 0.0);
        Detail {
            shade: detail.shade * (1.0 - detail.share),
            cover: detail.cover,
            slope: detail.slope,
        }
    }
}

impl Lichen {
    fn new(
        substrate: &Substrate,
        (grown, cluster): (Grown, Cluster),
        args: &RenderArgs,
        color: &ColorArgs,
    ) -> Result<Self, Failure> {
        let (origin, read) = (grown.origin(), grown.files(&args.mesh));
        let elements = grown.elements;
        let measure = Measure {
            diagonal: substrate.units().diagonal(),
            radius: elements.radius,
        };
        let shape = measure.shape(&args.shape)?;
        let paint = match args.by.by {
            Some(_) => Paint::default(),
            None => measure.paint(color)?,
        };
        Ok(Self {
            origin,
            read,
            elements,
            cluster,
            shape,
            paint,
        })
    }
}

impl Lichens {
    fn read(args: &RenderArgs) -> Result<Self, Failure> {
        let first = Grown::read(&args.from, args.run.voice())?;
        let mesh = first.file_of(&args.mesh)?;
        let dress = args.view.shot.ground.as_ref();
        let (substrate, cluster, texturing) = first.on_dressed(&mesh, &args.mesh, dress)?;
        let first = Lichen::new(&substrate, (first, cluster), args, &args.color)?;
        let mut lichens = Self {
            mesh,
            substrate,
            texturing,
            grown: vec![first],
            covers: Vec::new(),
        };
        for text in &args.also {
            let also = Also::parse(text, &args.color);
            let another = lichens.another(args, &also).map_err(|e| also.failed(e))?;
            let cover = Cover::new(&lichens.substrate, &another.cluster, &another.shape);
            let cover = cover.map_err(|e| Failure::Usage(e.into()))?;
            lichens.covers.push(cover);
            lichens.grown.push(another);
        }
        let all = lichens.grown.iter().map(|l| (&l.origin, &l.cluster));
        tell_of_overlaps(&lichens.substrate, all, args.run.voice());
        Ok(lichens)
    }

    /// Files that all this was read from.
    fn files(&self, args: &RenderArgs) -> Vec<PathBuf> {
        let lichens = self.grown.iter().flat_map(|lichen| lichen.read.clone());
        let ground = args.view.shot.ground.as_ref().and_then(Dress::file);
        let images = self.texturing.image_files.iter().cloned();
        lichens.chain(images).chain(ground).collect()
    }

    fn another(&self, args: &RenderArgs, also: &Also) -> Result<Lichen, Failure> {
        let found = also.read(&self.substrate, args.run.voice())?;
        Lichen::new(&self.substrate, found, args, &also.color)
    }

    fn colored(&self, args: &RenderArgs) -> Result<Colored, Failure> {
        let mut colored = Colored::default();
        if let Some(by) = args.by.by {
            let values = by.values(&self.grown[0].elements);
            let colormap = args.color.colormap.as_deref();
            let coloring = Coloring::new(by, colormap, args.by.range, &values)?;
            colored.coloring = Some((coloring, values));
        }
        for (k, Lichen { cluster, paint, .. }) in self.grown.iter().enumerate() {
            let natural = || skin::element_colors(&self.substrate, cluster, paint);
            let colors = match args.what {
                What::Points => colored
                    .colors()
                    .map_or_else(natural, Ok)
                    .context("--colormap")?,
                What::Skin => vec![[0; 3]; cluster.len()],
            };
            let discs = granules(&self.substrate, cluster, colors);
            if args.what == What::Points {
                colored.seen.extend(self.seen(k, &discs));
            }
            colored.discs.extend(discs);
        }
        Ok(colored)
    }

    /// Those elements of a lichen that no later one hides.
    fn seen(&self, k: usize, discs: &[Disc]) -> Vec<Disc> {
        let hides = |cover: &Cover| cover.hides(&self.substrate, &self.grown[k].cluster);
        let hides: Vec<Vec<bool>> = self.covers[k..].iter().map(hides).collect();
        let is_seen = |i: usize| hides.iter().all(|hides| !hides[i]);
        let seen = discs.iter().enumerate().filter(|(i, _)| is_seen(*i));
        seen.map(|(_, disc)| *disc).collect()
    }

    /// The shapes with triangles as fine as a picture shows in which a pixel is so wide, local units.
    fn shapes_at(&self, pixel: f64) -> Vec<Shape> {
        let radii = self.grown.iter().map(|lichen| lichen.cluster.radius());
        let least = radii.fold(f64::INFINITY, f64::min);
        let usual = Shape::default().resolution;
        let shown = (LONGEST_EDGE * pixel / least).clamp(FINEST, usual);
        let shares = self.shares();
        let shapes = self.shapes(shown, &shares);
        if shown == usual {
            return shapes;
        }
        let triangles = zip(&self.grown, &shapes)
            .map(|(l, shape)| expected_triangles(&self.substrate, &l.cluster, shape));
        match (triangles.sum::<f64>() / MOST_TRIANGLES).sqrt() {
            coarser if coarser > 1.0 => self.shapes((shown * coarser).min(usual), &shares),
            _ => shapes,
        }
    }

    /// How much finer the triangles of each are beneath smaller elements, down to a third, so that they are cut off
    /// where those begin.
    fn shares(&self) -> Vec<f64> {
        let share = |(k, lichen): (usize, &Lichen)| {
            let later = zip(&self.grown[k + 1..], &self.covers[k..]);
            let hides = |cover: &Cover| cover.hides(&self.substrate, &lichen.cluster);
            let over = later.filter(|(_, cover)| hides(cover).contains(&true));
            let radii = over.map(|(later, _)| later.cluster.radius());
            let share = radii.fold(f64::INFINITY, f64::min) / lichen.cluster.radius();
            share.clamp(LEAST_SHARE, 1.0)
        };
        self.grown.iter().enumerate().map(share).collect()
    }

    /// Shapes with triangles of this longest edge, in radii, times these shares.
    fn shapes(&self, resolution: f64, shares: &[f64]) -> Vec<Shape> {
        let shape = |(lichen, share): (&Lichen, &f64)| Shape {
            resolution: resolution * share,
            ..lichen.shape
        };
        zip(&self.grown, shares).map(shape).collect()
    }

    /// Refuses skins that do not fit.
    fn skins(&self, shapes: &[Shape], colored: &Colored) -> Result<Vec<Skin<'_>>, Failure> {
        let clusters = self.grown.iter().map(|lichen| &lichen.cluster);
        memory::check_skins(&self.substrate, zip(clusters, shapes))?;
        let all = zip(&self.grown, shapes).enumerate();
        let skin =
            |(k, (lichen, shape))| self.skin(lichen, shape, colored.colors(), &self.covers[k..]);
        let skins: Result<Vec<Skin>, Failure> = all.map(skin).collect();
        let is_seen = |skin: &Skin| !skin.triangles.is_empty();
        Ok(skins?.into_iter().filter(is_seen).collect())
    }

    fn skin(
        &self,
        Lichen { cluster, paint, .. }: &Lichen,
        shape: &Shape,
        colors: Option<Vec<[u8; 3]>>,
        above: &[Cover],
    ) -> Result<Skin<'_>, Failure> {
        let made = skin::skin_in_parts(&self.substrate, cluster, shape, paint, above);
        let Parts {
            mesh,
            strongest,
            cortex,
        } = made.map_err(|e| Failure::Usage(e.into()))?;
        Ok(match colors {
            None => {
                let skin = Skin::new(&self.substrate, mesh, cluster.radius() as f32);
                let cut = |cortex| Cut::new(cortex, &self.substrate, &skin);
                Skin {
                    structure: cortex.map(cut),
                    ..skin
                }
            }
            Some(colors) => {
                let of = |&element: &u32| colors[element as usize];
                let colors = strongest.par_iter().map(of).collect();
                Skin::new(&self.substrate, TriMesh { colors, ..mesh }, 0.0)
            }
        })
    }

    fn draw_legend(
        &self,
        args: &RenderArgs,
        colored: &Colored,
        camera: &Camera,
        image: &mut Image,
    ) {
        let unit = args.view.unit.as_deref().unwrap_or("mesh units");
        let width = camera.width_at(
            camera.depth(middle(&colored.discs)),
            args.view.size.aspect(),
        );
        let width = self.substrate.units().length_to_file(f64::from(width));
        let is_shown = width > 0.0 && width.is_finite();
        let smaller = width * f64::from(args.view.size.aspect().recip().min(1.0));
        let length = round_below(if is_shown { smaller / 4.0 } else { 1.0 });
        let label = format!("{} {unit}", number(length, length));
        let rule = is_shown.then_some(Key::Length {
            label: &label,
            share: (length / width) as f32,
        });
        match &colored.coloring {
            None => draw_legend(image, rule.as_slice()),
            Some((coloring, values)) => coloring.with_key(values, unit, |key| {
                let keys: Vec<Key> = std::iter::once(key).chain(rule).collect();
                draw_legend(image, &keys);
            }),
        }
    }
}

/// The middle of a lichen.
pub(super) fn middle(discs: &[Disc]) -> [f32; 3] {
    let sum: glam::DVec3 = discs
        .iter()
        .map(|d| glam::Vec3::from(d.center).as_dvec3())
        .sum();
    (sum / discs.len() as f64).as_vec3().to_array()
}

impl Skin<'_> {
    pub(super) fn new(substrate: &Substrate, mesh: TriMesh, grain: f32) -> Self {
        let local = |p: &[f64; 3]| substrate.units().to_local(*p).as_vec3().to_array();
        Self {
            positions: mesh.positions.par_iter().map(local).collect(),
            normals: mesh.normals,
            colors: mesh.colors,
            triangles: mesh.triangles,
            grain,
            structure: None,
        }
    }

    pub(super) fn painted(&self) -> Painted<'_> {
        Painted {
            positions: &self.positions,
            normals: &self.normals,
            colors: &self.colors,
            triangles: &self.triangles,
            grain: self.grain,
            structure: self.structure.as_ref().map(|cut| cut as &dyn Structure),
        }
    }
}

/// Where nothing else is said, pixels that the longest edge of a skin's triangles takes at the depth of the lichen's
/// middle: larger ones show at the edge of shadows, as teeth.
const LONGEST_EDGE: f64 = 6.0;

/// The finest resolution that is gone to for that, in element radii: it is as smooth as elements are.
const FINEST: f64 = 0.7;

/// Beneath smaller elements they are no finer than this share of what they are elsewhere.
const LEAST_SHARE: f64 = 1.0 / 3.0;

/// Triangles that are made for that, about, at most.
const MOST_TRIANGLES: f64 = 3e6;

/// A picture that is to be taken.
struct Shot<'a> {
    args: &'a RenderArgs,
    lichens: &'a Lichens,
    colored: &'a Colored,
}

/// One that was.
struct Taken {
    image: Image,
    camera: Camera,
    skin_triangles: usize,
}

impl Shot<'_> {
    /// Tells when the lichens have their shapes.
    fn take(&self, dressed: impl FnOnce()) -> Result<Taken, Failure> {
        let (view, voice) = (&self.args.view, self.args.run.voice());
        let (substrate, discs) = (&self.lichens.substrate, &self.colored.discs);
        let stone = spin(voice, "dressing the stone", || stone(substrate))?;
        let lichens = self.lichens;
        let dress = view.shot.ground.as_ref();
        let looks = (substrate, &lichens.texturing);
        let own = dress::appearance(dress, looks, &lichens.mesh, voice)?;
        let bare = Scene {
            finish: own.as_ref().map(|own| own as &dyn Finish),
            ..staged(substrate, &stone, made_up(dress), discs)
        };
        let granular = LazyCell::new(|| World::new(&Scene { discs, ..bare }));
        let aspect = view.size.aspect();
        let camera = view.shot.camera.camera(substrate, &granular, aspect)?;
        let middle = middle(discs);
        let camera = view.shot.zoomed(&camera, &granular, (middle, aspect));
        warn_unseen(&camera, &granular, aspect, voice);
        let settings = self.settings();
        let picture = |world: &World| thallus::picture::render(world, &camera, &settings);
        let doing = "taking the picture";
        if self.args.what == What::Points {
            dressed();
            let discs = &self.colored.seen;
            let image = match discs.len() == self.colored.discs.len() {
                true => spin(voice, doing, || picture(&granular)),
                false => spin(voice, doing, || {
                    picture(&World::new(&Scene { discs, ..bare }))
                }),
            };
            return Ok(Taken {
                image,
                camera,
                skin_triangles: 0,
            });
        }
        drop(granular);
        let shapes = self.shapes(&camera);
        let skins = || self.lichens.skins(&shapes, self.colored);
        let skins = spin(voice, "dressing the lichen", skins)?;
        dressed();
        let painted: Vec<Painted> = skins.iter().map(Skin::painted).collect();
        let scene = Scene {
            skins: &painted,
            ..bare
        };
        Ok(Taken {
            image: spin(voice, doing, || picture(&World::new(&scene))),
            camera,
            skin_triangles: skins.iter().map(|s| s.triangles.len()).sum(),
        })
    }

    /// How far away lichen is: its middle, or, of a camera that went nearer, the nearest of it in the picture.
    fn depth(&self, camera: &Camera) -> f32 {
        let view = &self.args.view;
        let discs = &self.colored.discs;
        let aspect = view.size.aspect();
        let is_inside = |disc: &&Disc| camera.frames(disc.center, aspect).is_some();
        let inside = discs
            .iter()
            .filter(is_inside)
            .map(|disc| camera.depth(disc.center));
        let nearest = inside.reduce(f32::min).filter(|_| view.shot.zoom > 1.0);
        nearest.unwrap_or_else(|| camera.depth(middle(discs)))
    }

    /// As it is said, or as fine as the camera shows it.
    fn shapes(&self, camera: &Camera) -> Vec<Shape> {
        let size = &self.args.view.size;
        let width = f64::from(camera.width_at(self.depth(camera), size.aspect()));
        match self.args.shape.resolution {
            None if width > 0.0 => self.lichens.shapes_at(width / f64::from(size.width)),
            _ => self.lichens.grown.iter().map(|l| l.shape).collect(),
        }
    }

    fn settings(&self) -> Settings {
        let view = &self.args.view;
        Settings {
            width: view.size.width,
            height: view.size.height,
            samples: view.shot.samples,
            background: view.shot.background,
        }
    }
}

/// Times one thing after another.
struct Clock {
    started: Instant,
    lap: Instant,
}

impl Clock {
    fn new() -> Self {
        let now = Instant::now();
        Self {
            started: now,
            lap: now,
        }
    }

    fn lap(&mut self, seconds: &mut f64) {
        let now = Instant::now();
        *seconds = (now - self.lap).as_secs_f64();
        self.lap = now;
    }
}

/// The JSON answer, keys in this order.
#[derive(Debug, Serialize)]
struct Report {
    file: String,
    width: u32,
    height: u32,
    elements: usize,
    skin_triangles: usize,
    camera: CameraText,
    seconds: Seconds,
}

#[derive(Debug, Default, Serialize)]
struct Seconds {
    load: f64,
    dress: f64,
    render: f64,
    write: f64,
    total: f64,
}

fn conclude(args: &RenderArgs, report: &Report) -> Result<(), Failure> {
    if args.json {
        terminal::say_json(report)?;
    } else if !args.run.quiet {
        let Report { width, height, .. } = report;
        let elements = elements(report.elements);
        let seconds = duration(report.seconds.total);
        terminal::say(&format!(
            "{}: {width} x {height}, {elements}, in {seconds}",
            report.file
        ))?;
    }
    Ok(())
}
