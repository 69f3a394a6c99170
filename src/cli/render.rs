//! `thallus render`: a picture of a run.

use std::borrow::Borrow;
use std::cell::LazyCell;
use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use thallus::cluster::Cluster;
use thallus::export::{Elements, TriMesh, write_file_atomically};
use thallus::picture::{
    Camera, Detail, Disc, Image, Key, Painted, Scene, Settings, Structure, World, draw_legend,
    number, round_below,
};
use thallus::run::Length;
use thallus::skin::{self, Cortex, Paint, Parts, Shape};
use thallus::substrate::Substrate;

use super::failure::Failure;
use super::grown::Grown;
use super::interrupt::leave_no_part;
use super::memory;
use super::number::{duration, elements};
use super::preview::{granules, staged, stone};
use super::render_args::{RenderArgs, What};
use super::render_by::Coloring;
use super::render_camera::{CameraText, warn_unseen};
use super::skin::{check_free, shape, spinner, start_threads};
use super::skin_args::ColorArgs;
use super::skin_paint::paint;
use super::terminal::{self, Voice};

pub(crate) fn render(args: &RenderArgs) -> Result<(), Failure> {
    check_name(&args.output)?;
    check_free(std::slice::from_ref(&args.output), args.force)?;
    leave_no_part();
    start_threads(args.run.threads)?;
    let voice = args.run.voice();
    let mut clock = Clock::new();
    let lichens = Lichens::read(args)?;
    lichens.check_memory(args.what)?;
    let mut seconds = Seconds::default();
    clock.lap(&mut seconds.load);
    let dressed = spin(voice, "dressing the lichen", || lichens.dress(args))?;
    clock.lap(&mut seconds.dress);
    let (mut image, camera) = spin(voice, "taking the picture", || {
        take(args, &lichens, &dressed)
    })?;
    if args.view.legend {
        lichens.draw_legend(args, &dressed, &camera, &mut image);
    }
    clock.lap(&mut seconds.render);
    let png = image.to_png();
    write_file_atomically(&args.output, args.force, |out| out.write_all(&png))?;
    clock.lap(&mut seconds.write);
    let middle = camera.depth(middle(&dressed.discs));
    conclude(
        args,
        &Report {
            file: args.output.display().to_string(),
            width: image.width,
            height: image.height,
            elements: lichens.grown.iter().map(|l| l.cluster.len()).sum(),
            skin_triangles: dressed.skins.iter().map(|s| s.triangles.len()).sum(),
            camera: CameraText::of(&camera, middle.max(f32::MIN_POSITIVE), &lichens.substrate),
            seconds: Seconds {
                total: clock.started.elapsed().as_secs_f64(),
                ..seconds
            },
        },
    )
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
    let spinner = spinner(voice, doing);
    let done = work();
    spinner.finish_and_clear();
    done
}

/// One lichen and its colours.
struct Lichen {
    elements: Elements,
    cluster: Cluster,
    paint: Paint,
}

/// What is to be in the picture.
struct Lichens {
    substrate: Substrate,
    grown: Vec<Lichen>,
    shape: Shape,
}

/// Lichens with shapes and colours.
#[derive(Default)]
struct Dressed {
    /// Every element: where the camera looks, and the picture itself where it is of points.
    discs: Vec<Disc>,
    skins: Vec<Skin>,
    coloring: Option<(Coloring, Vec<f64>)>,
}

/// A skin as pictures take it.
pub(super) struct Skin {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[u8; 3]>,
    triangles: Vec<[u32; 3]>,
    grain: f32,
    structure: Option<Cut<Cortex>>,
}

/// The structure of a skin, as fine as it is.
pub(super) struct Cut<C>(pub(super) C);

impl<C: Borrow<Cortex> + Sync> Structure for Cut<C> {
    fn at(&self, place: [f32; 3], normal: [f32; 3]) -> Detail {
        let detail = self.0.borrow().at(place.map(f64::from), normal, 0.0);
        Detail {
            shade: detail.shade * (1.0 - detail.share),
            cover: detail.cover,
            slope: detail.slope,
        }
    }
}

impl Lichens {
    fn read(args: &RenderArgs) -> Result<Self, Failure> {
        let first = Grown::read(&args.from)?;
        first.tell_of_more(args.run.voice());
        let (substrate, cluster) = first.on_mesh(&args.mesh)?;
        let diagonal = substrate.units().diagonal();
        let radius = first.elements.radius;
        let in_radii = |length: Length| length.in_units(diagonal, radius) / radius;
        let shape = shape(&args.shape, &in_radii);
        shape.check().map_err(|e| Failure::Usage(e.into()))?;
        let paint = match args.by.by {
            Some(_) => Paint::default(),
            None => paint(&args.color, &in_radii)?,
        };
        let first = Lichen {
            elements: first.elements,
            cluster,
            paint,
        };
        let mut lichens = Self {
            substrate,
            grown: vec![first],
            shape,
        };
        for text in &args.also {
            let another = lichens.another(text, &args.color)?;
            lichens.grown.push(another);
        }
        Ok(lichens)
    }

    /// Another lichen on the same mesh: `DIR` or `DIR,COLORMAP`.
    fn another(&self, text: &str, color: &ColorArgs) -> Result<Lichen, Failure> {
        let (from, colormap) = match text.split_once(',') {
            Some((from, map)) if !Path::new(text).exists() => (from, Some(map.to_owned())),
            _ => (text, color.colormap.clone()),
        };
        let elements = Grown::read(Path::new(from))?.elements;
        let cluster = elements.to_cluster(&self.substrate);
        let cluster = cluster.with_context(|| format!("--also {from}"))?;
        let radius = elements.radius;
        let diagonal = self.substrate.units().diagonal();
        let in_radii = |length: Length| length.in_units(diagonal, radius) / radius;
        let color = ColorArgs {
            colormap,
            ..color.clone()
        };
        Ok(Lichen {
            elements,
            cluster,
            paint: paint(&color, &in_radii)?,
        })
    }

    /// Refuses skins that do not fit.
    fn check_memory(&self, what: What) -> Result<(), Failure> {
        let clusters = self.grown.iter().map(|lichen| &lichen.cluster);
        match what {
            What::Points => Ok(()),
            What::Skin => memory::check_skins(&self.substrate, clusters, &self.shape),
        }
    }

    fn dress(&self, args: &RenderArgs) -> Result<Dressed, Failure> {
        let mut dressed = Dressed::default();
        if let Some(by) = args.by.by {
            let values = by.values(&self.grown[0].elements);
            let colormap = args.color.colormap.as_deref();
            let coloring = Coloring::new(by, colormap, args.by.range, &values)?;
            dressed.coloring = Some((coloring, values));
        }
        for lichen in &self.grown {
            let colors = dressed.coloring.as_ref().map(|(c, v)| c.colors(v));
            self.dress_one(lichen, colors, args.what, &mut dressed)?;
        }
        Ok(dressed)
    }

    /// `colors` are those of the elements, where they are not those of the lichen.
    fn dress_one(
        &self,
        lichen: &Lichen,
        colors: Option<Vec<[u8; 3]>>,
        what: What,
        dressed: &mut Dressed,
    ) -> Result<(), Failure> {
        let (substrate, cluster) = (&self.substrate, &lichen.cluster);
        let natural = || skin::element_colors(substrate, cluster, &lichen.paint);
        if what == What::Points {
            let colors = colors.unwrap_or_else(natural);
            dressed.discs.extend(granules(substrate, cluster, colors));
            return Ok(());
        }
        let grey = vec![[0; 3]; cluster.len()];
        dressed.discs.extend(granules(substrate, cluster, grey));
        let made = skin::skin_in_parts(substrate, cluster, &self.shape, &lichen.paint);
        let Parts {
            mesh,
            strongest,
            cortex,
        } = made.map_err(|e| Failure::Usage(e.into()))?;
        dressed.skins.push(match colors {
            None => Skin {
                structure: cortex.map(Cut),
                ..Skin::new(substrate, mesh, cluster.radius() as f32)
            },
            Some(colors) => {
                let of = |&element: &u32| colors[element as usize];
                let colors = strongest.par_iter().map(of).collect();
                Skin::new(substrate, TriMesh { colors, ..mesh }, 0.0)
            }
        });
        Ok(())
    }

    fn draw_legend(
        &self,
        args: &RenderArgs,
        dressed: &Dressed,
        camera: &Camera,
        image: &mut Image,
    ) {
        let unit = args.view.unit.as_deref().unwrap_or("mesh units");
        let width = camera.width_at(
            camera.depth(middle(&dressed.discs)),
            args.view.size.aspect(),
        );
        let width = self.substrate.units().length_to_file(f64::from(width));
        let is_shown = width > 0.0 && width.is_finite();
        let length = round_below(if is_shown { width / 4.0 } else { 1.0 });
        let label = format!("{} {unit}", number(length, length));
        let rule = is_shown.then_some(Key::Length {
            label: &label,
            share: (length / width) as f32,
        });
        match &dressed.coloring {
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

impl Skin {
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

fn take(
    args: &RenderArgs,
    lichens: &Lichens,
    dressed: &Dressed,
) -> Result<(Image, Camera), Failure> {
    let view = &args.view;
    let stone = stone(&lichens.substrate);
    let bare = staged(&lichens.substrate, &stone, view.shot.ground, &dressed.discs);
    let granular = LazyCell::new(|| {
        World::new(&Scene {
            discs: &dressed.discs,
            ..bare
        })
    });
    let aspect = view.size.aspect();
    let camera = view
        .shot
        .camera
        .camera(&lichens.substrate, &granular, aspect)?;
    let camera = view.shot.zoomed(&camera, middle(&dressed.discs), aspect);
    warn_unseen(&camera, &granular, aspect, args.run.voice());
    let settings = Settings {
        width: view.size.width,
        height: view.size.height,
        samples: view.shot.samples,
        background: view.shot.background,
    };
    let taken = |world: &World| thallus::picture::render(world, &camera, &settings);
    let image = match args.what {
        What::Points => taken(&granular),
        What::Skin => {
            drop(granular);
            let skins: Vec<Painted> = dressed.skins.iter().map(Skin::painted).collect();
            let skins = &skins;
            taken(&World::new(&Scene { skins, ..bare }))
        }
    };
    Ok((image, camera))
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
        let json = serde_json::to_string_pretty(report).context("writing JSON")?;
        terminal::say(&json)?;
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
