//! `thallus bake`: the lichen as textures of its mesh.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use thallus::bake::{self, BakeError, Baked, Base, LayoutReport, Look, MAPS, Map, Settings};
use thallus::cluster::Cluster;
use thallus::export::{Axes, MapImages, OutputDir, OutputError, Placement, UpAxis};
use thallus::input;
use thallus::skin::{Paint, Shape};
use thallus::substrate::{Substrate, Texturing};

use super::also::{Also, tell_of_overlaps};
use super::axes::Convention;
use super::bake_args::{BakeArgs, FileFormat, NormalFormat};
use super::dress::Dress;
use super::failure::Failure;
use super::grown::{Grown, Origin};
use super::interrupt::{Held, Stop};
use super::memory;
use super::mesh_file::load_textured;
use super::number::{count, duration, elements, plural};
use super::output::check_names_folder;
use super::run_args::start_threads;
use super::skin_args::{ColorArgs, ReliefArgs};
use super::skin_look::Measure;
use super::terminal::{self, Voice};

const GLB: &str = "lichened.glb";
const SIDECAR: &str = "maps.json";

pub(crate) fn bake(args: &BakeArgs) -> Result<(), Failure> {
    check_names_folder(&args.output)?;
    let settings = Settings {
        size: args.maps.size,
        gutter: args.maps.gutter,
        samples: args.maps.samples,
    };
    settings.check().map_err(|e| Failure::Usage(e.into()))?;
    start_threads(args.run.threads)?;
    let voice = args.run.voice();
    let started = Instant::now();
    let lichens = Lichens::read(args)?;
    let base = base(args)?;
    let placement = placement(args, &lichens.substrate)?;
    let clusters = lichens.grown.iter().map(|lichen| &lichen.cluster);
    memory::check_maps(&lichens.substrate, clusters, settings.size)?;
    let folder = OutputDir::create(&args.output, args.force).map_err(taken)?;
    let folder = Held::listen(folder);
    let mut seconds = Seconds {
        load: started.elapsed().as_secs_f64(),
        ..Seconds::default()
    };
    let baked = lichens.bake(args, &base, &settings, &mut seconds)?;
    warn(&lichens, &baked, voice);
    let writer = Writer {
        baked: &baked,
        lichens: &lichens,
        name: &name(args, &lichens.mesh),
        placement: &placement,
        format: args.maps.format,
        normal: args.maps.normal,
    };
    let (folder, stop) = folder.take().ok_or(Failure::Interrupted)?;
    let written = writer.write_all(folder, &stop, voice, &mut seconds);
    written.map_err(|e| {
        if stop.is_told() {
            Failure::Interrupted
        } else {
            e
        }
    })?;
    seconds.total = started.elapsed().as_secs_f64();
    let report = Report::new(args, &lichens, &baked, &writer, seconds);
    conclude(args, &report)
}

/// Of the mesh that wears the maps: its file's, and which part it is.
fn name(args: &BakeArgs, mesh: &Path) -> String {
    let name = mesh.file_stem().unwrap_or("lichened".as_ref());
    let name = name.to_string_lossy();
    match &args.only {
        None => name.into_owned(),
        Some(only) => format!("{name} {only}"),
    }
}

/// Lichens on their mesh, and what the mesh file says about textures.
struct Lichens {
    mesh: PathBuf,
    substrate: Substrate,
    texturing: Texturing,
    /// Which triangles of the file are asked for, where not all are.
    only: Option<Vec<bool>>,
    /// The first, and those that are there also.
    grown: Vec<Lichen>,
}

struct Lichen {
    origin: Origin,
    cluster: Cluster,
    shape: Shape,
    paint: Paint,
}

impl Lichen {
    fn new(
        substrate: &Substrate,
        (origin, cluster): (Origin, Cluster),
        relief: &ReliefArgs,
        color: &ColorArgs,
    ) -> Result<Self, Failure> {
        let measure = Measure::of(substrate, &cluster);
        Ok(Self {
            shape: measure.relief(relief)?,
            paint: measure.paint(color)?,
            origin,
            cluster,
        })
    }

    fn look(&self) -> Look<'_> {
        Look {
            cluster: &self.cluster,
            shape: &self.shape,
            paint: &self.paint,
        }
    }
}

impl Lichens {
    fn read(args: &BakeArgs) -> Result<Self, Failure> {
        let grown = Grown::read(&args.from, args.run.voice())?;
        grown.spare(&args.output.join(GLB), &args.mesh)?;
        let mesh = grown.file_of(&args.mesh)?;
        let (substrate, mut texturing) = load_textured(&mesh)?;
        grown.hide_mask(&mut texturing);
        let only = { args.only.as_ref() }.map(|only| only.triangles(&texturing));
        let only = only
            .transpose()
            .with_context(|| mesh.display().to_string())?;
        { only.iter() }.for_each(|only| texturing.keep_uvs_of(only));
        let (substrate, cluster) = grown.on_turned(substrate, &args.mesh, &mesh)?;
        let first = Lichen::new(
            &substrate,
            (grown.origin(), cluster),
            &args.relief,
            &args.color,
        )?;
        let mut lichens = Self {
            mesh,
            substrate,
            texturing,
            only,
            grown: vec![first],
        };
        for text in &args.also {
            let also = Also::parse(text, &args.color);
            let another = lichens.another(args, &also).map_err(|e| also.failed(e))?;
            lichens.grown.push(another);
        }
        let all = lichens.grown.iter().map(|l| (&l.origin, &l.cluster));
        tell_of_overlaps(&lichens.substrate, all, args.run.voice());
        Ok(lichens)
    }

    fn another(&self, args: &BakeArgs, also: &Also) -> Result<Lichen, Failure> {
        let (grown, cluster) = also.read(&self.substrate, args.run.voice())?;
        grown.spare(&args.output.join(GLB), &args.mesh)?;
        Lichen::new(
            &self.substrate,
            (grown.origin(), cluster),
            &args.relief,
            &also.color,
        )
    }

    /// Whether a triangle is asked for.
    fn is_asked_for(&self, triangle: u32) -> bool {
        let source = self.substrate.source_triangle(triangle) as usize;
        { self.only.as_ref() }.is_none_or(|only| only.get(source) == Some(&true))
    }

    /// Triangles that should be in the maps, and of these those that are not.
    fn not_shown(&self, baked: &Baked) -> [usize; 2] {
        let all = 0..self.substrate.triangles().len() as u32;
        let others = all.clone().filter(|&t| !self.is_asked_for(t)).count();
        [all.len() - others, baked.report().not_shown - others]
    }

    /// What to do where several places share texels.
    fn cure_of_overlaps(&self) -> String {
        let otherwise = match has_tiles(&self.texturing) {
            true => {
                "they reach beyond one image, as UDIM tiles do: bake the parts of one tile at a time"
            }
            false => "unwrap the mesh without overlaps",
        };
        self.part_by_part().unwrap_or_else(|| otherwise.to_owned())
    }

    /// How to bake a mesh of several materials or objects, where that is not what was asked for.
    fn part_by_part(&self) -> Option<String> {
        let counts = [self.texturing.named_materials(), self.texturing.objects()];
        let mut kinds = ["material", "object"].into_iter().zip(counts);
        let (kind, names) = kinds.find(|(_, names)| names.len() > 1 && self.only.is_none())?;
        Some(format!(
            "where each of its {} {kind}s has a layout of its own, bake one at a time, with --only {kind}:NAME (thallus check \
             names them)",
            names.len()
        ))
    }

    /// Elements of all.
    fn elements(&self) -> usize {
        self.grown.iter().map(|lichen| lichen.cluster.len()).sum()
    }

    fn bake(
        &self,
        args: &BakeArgs,
        base: &Base,
        settings: &Settings,
        seconds: &mut Seconds,
    ) -> Result<Baked<'_>, Failure> {
        let started = Instant::now();
        let elements = elements(self.elements());
        let spinner = args.run.voice().spinner(&format!("baking {elements}"));
        let looks: Vec<Look> = self.grown.iter().map(Lichen::look).collect();
        let baked = bake::bake(&self.substrate, &self.texturing, &looks, base, settings);
        spinner.finish_and_clear();
        seconds.bake = started.elapsed().as_secs_f64();
        let named = match (&args.maps.base, &baked) {
            (Some(Dress::Image(image)), Err(BakeError::Base(_))) => image,
            _ => &self.mesh,
        };
        let cure = match &baked {
            Err(BakeError::Stacked { .. }) => self.part_by_part(),
            _ => None,
        };
        let baked = match cure {
            Some(cure) => baked.with_context(|| cure),
            None => baked.map_err(anyhow::Error::new),
        };
        Ok(baked.with_context(|| named.display().to_string())?)
    }
}

/// What the mesh looks like where there is no lichen.
fn base(args: &BakeArgs) -> Result<Base, Failure> {
    match &args.maps.base {
        None | Some(Dress::Own) => Ok(Base::Mesh),
        Some(Dress::Drawn(ground)) => Ok(Base::Ground(*ground)),
        Some(Dress::Image(file)) => {
            let failed = || {
                format!(
                    "{}: reading the image of the base colour failed",
                    file.display()
                )
            };
            Ok(Base::Image(input::bytes(file).with_context(failed)?))
        }
    }
}

/// To the axes and units of glTF.
fn placement(args: &BakeArgs, substrate: &Substrate) -> Result<Placement, Failure> {
    let convention = Convention {
        extension: "glb",
        axes: Axes::Fixed(UpAxis::Y),
        metres: true,
    };
    let up = Some(substrate.up_axis());
    args.units.placement(&convention, up, None)
}

/// What another run wrote is not told apart from what stands there otherwise.
fn taken(error: OutputError) -> Failure {
    match error {
        OutputError::FolderExists(folder) => Failure::Failed(anyhow::anyhow!(
            "{} exists already and is not empty: add --force to overwrite maps there (other files \
             are left alone), or choose another folder",
            folder.display()
        )),
        other => other.into(),
    }
}

fn warn(lichens: &Lichens, baked: &Baked, voice: Voice) {
    let mesh = lichens.mesh.display();
    let report = baked.report();
    let shared = report.overlaps;
    if shared.texels > 0 {
        let share = 100.0 * shared.texels as f64 / report.covered.max(1) as f64;
        let overlap = plural(shared.triangles, "triangle overlaps", "triangles overlap");
        voice.warn(&format!(
            "{mesh}: {overlap} in the UVs: {share:.1} % of the texels in use show \
             one place of the surface and stand for several; {}",
            lichens.cure_of_overlaps()
        ));
    }
    let [all, hidden] = lichens.not_shown(baked);
    if hidden > 0 {
        let [hidden, all] = [hidden, all].map(|n| count(n as u64));
        voice.warn(&format!(
            "{mesh}: {hidden} of {all} triangles have no UVs, or no area in them: lichen there is in no \
             map"
        ));
    }
    for note in baked.notes() {
        voice.warn(&format!("{mesh}: {note}"));
    }
    let radii = lichens.grown.iter().map(|l| l.cluster.radius());
    let radius = radii.fold(f64::INFINITY, f64::min);
    let radius = lichens.substrate.units().length_to_file(radius);
    if report.texel > COARSE * radius {
        let radii = report.texel / radius;
        voice.warn(&format!(
            "a texel is {radii:.1} element radii wide: single elements do not show; a larger --size \
             shows more"
        ));
    }
}

/// Whether triangles lie in images beside the first, as in UDIM tiles.
fn has_tiles(texturing: &Texturing) -> bool {
    // Rows are counted from above, so that tiles above the first have negative ones.
    let lies_beside = |uvs: &[[f64; 2]; 3]| {
        let right = uvs.iter().all(|[u, _]| *u >= 1.0);
        right || uvs.iter().all(|[_, v]| *v <= 0.0)
    };
    texturing.uvs.iter().flatten().any(lies_beside)
}

/// Texels wider than this, in element radii, show no elements.
const COARSE: f64 = 2.0;

/// Writes maps.
struct Writer<'a> {
    baked: &'a Baked<'a>,
    lichens: &'a Lichens,
    /// The mesh's.
    name: &'a str,
    placement: &'a Placement,
    format: FileFormat,
    normal: NormalFormat,
}

impl Writer<'_> {
    fn write_all(
        &self,
        mut folder: OutputDir,
        stop: &Stop,
        voice: Voice,
        seconds: &mut Seconds,
    ) -> Result<(), Failure> {
        let started = Instant::now();
        let spinner = voice.spinner(&format!("writing to {}", folder.path().display()));
        let written = self.write_into(&mut folder, stop);
        let written = written.and_then(|()| {
            self.remove_others(&mut folder);
            folder.commit()
        });
        spinner.finish_and_clear();
        written?;
        seconds.write = started.elapsed().as_secs_f64();
        Ok(())
    }

    fn write_into(&self, folder: &mut OutputDir, stop: &Stop) -> Result<(), OutputError> {
        let files: Vec<std::io::Result<Vec<u8>>> =
            MAPS.par_iter().map(|m| self.encoded(m)).collect();
        let mut worn = HashMap::new();
        for (map, file) in MAPS.iter().zip(files) {
            folder.write(&self.file_name(map), |out| {
                stop.check()?;
                let file = file?;
                out.write_all(&file)?;
                worn.insert(map.name, file);
                Ok(())
            })?;
        }
        folder.write(GLB, |out| {
            stop.check()?;
            self.write_glb(&worn, out)
        })?;
        let sidecar = self.sidecar();
        folder.write(SIDECAR, |out| {
            serde_json::to_writer_pretty(&mut *out, &sidecar)?;
            out.write_all(b"\n")
        })
    }

    fn file_name(&self, map: &Map) -> String {
        format!("{}.{}", map.name, self.format.extension())
    }

    /// Takes away the maps of an earlier bake in another format: they show another lichen, or another size.
    fn remove_others(&self, folder: &mut OutputDir) {
        if !folder.path().join(SIDECAR).is_file() {
            return;
        }
        let others = [FileFormat::Png, FileFormat::Exr]
            .into_iter()
            .filter(|f| *f != self.format);
        let names = others.flat_map(|f| {
            MAPS.iter()
                .map(move |m| format!("{}.{}", m.name, f.extension()))
        });
        names.for_each(|name| folder.outdate(&name));
    }

    /// A map's file.
    fn encoded(&self, map: &Map) -> std::io::Result<Vec<u8>> {
        let down = map.name == "normal" && self.normal == NormalFormat::Directx;
        let factor = self.exr_factor(map);
        let value = |x: usize, y: usize| {
            let [r, g, b] = self.baked.value(map, x, y).map(|v| v * factor);
            [r, if down { 1.0 - g } else { g }, b]
        };
        let texture = self.baked.texture(map, &value);
        let mut file = Vec::new();
        match self.format {
            FileFormat::Png => texture.write_png(map.png_bits, &mut file)?,
            FileFormat::Exr => texture.write_exr(map.is_exact, &mut file)?,
        }
        Ok(file)
    }

    /// Heights are in metres in EXR, which has numbers beyond 1.
    fn exr_factor(&self, map: &Map) -> f32 {
        match (self.format, map.name) {
            (FileFormat::Exr, "height") => map.range(self.baked, self.placement.scale).one as f32,
            _ => 1.0,
        }
    }

    /// The mesh with its material; `files` are the maps as they were written.
    fn write_glb(
        &self,
        files: &HashMap<&str, Vec<u8>>,
        out: &mut dyn Write,
    ) -> std::io::Result<()> {
        let worn = ["base_color", "normal", "orm"];
        let images: std::io::Result<Vec<Cow<[u8]>>> =
            worn.par_iter().map(|name| self.worn(name, files)).collect();
        let images = images?;
        let mut mesh = self.baked.mesh_of(|t| self.lichens.is_asked_for(t));
        mesh.shape.name = Some(self.name.to_owned());
        mesh.place(self.placement);
        let images = MapImages {
            base_color: &images[0],
            normal: &images[1],
            orm: &images[2],
        };
        mesh.write_glb(&images, out)
    }

    /// A map as glTF wants it: PNG of 8 bits, green up.
    fn worn<'f>(
        &self,
        name: &str,
        files: &'f HashMap<&str, Vec<u8>>,
    ) -> std::io::Result<Cow<'f, [u8]>> {
        let written = files.get(name).filter(|_| self.format == FileFormat::Png);
        match (written, Map::named(name)) {
            (Some(file), Some(map)) if map.png_bits == 8 => Ok(Cow::Borrowed(file)),
            (_, Some(map)) => {
                let value = |x: usize, y: usize| self.baked.value(map, x, y);
                let mut file = Vec::new();
                self.baked.texture(map, &value).write_png(8, &mut file)?;
                Ok(Cow::Owned(file))
            }
            (_, None) => Err(std::io::Error::other("there is no such map")),
        }
    }

    fn sidecar(&self) -> serde_json::Value {
        let map = |map: &Map| {
            let range = map.range(self.baked, self.placement.scale);
            let factor = f64::from(self.exr_factor(map)).max(f64::MIN_POSITIVE);
            let space = match (map.is_color, self.format) {
                (true, FileFormat::Png) => "sRGB",
                (true, FileFormat::Exr) => "linear sRGB",
                (false, _) => "data",
            };
            serde_json::json!({
                "file": self.file_name(map),
                "what": map.what,
                "color_space": space,
                "zero": range.zero,
                "one": if factor == 1.0 { range.one } else { 1.0 },
                "unit": range.unit,
            })
        };
        let report = self.baked.report();
        let green = match self.normal {
            NormalFormat::Opengl => "up (OpenGL)",
            NormalFormat::Directx => "down (DirectX)",
        };
        serde_json::json!({
            "thallus": env!("CARGO_PKG_VERSION"),
            "mesh": GLB,
            "size": self.baked.size(),
            "texel_meters": report.texel * self.placement.scale,
            "highest_meters": self.baked.highest() * self.placement.scale,
            "normal_green": green,
            "maps": MAPS.iter().map(map).collect::<Vec<_>>(),
        })
    }
}

/// The JSON answer, keys in this order.
#[derive(Debug, Serialize)]
struct Report {
    elements: usize,
    lichens: usize,
    folder: String,
    size: usize,
    texel: f64,
    highest: f64,
    covered_by_layout: f64,
    overlapping_texels: usize,
    overlapping_triangles: usize,
    triangles_not_shown: usize,
    files: Vec<String>,
    seconds: Seconds,
}

#[derive(Debug, Default, Serialize)]
struct Seconds {
    load: f64,
    bake: f64,
    write: f64,
    total: f64,
}

impl Report {
    fn new(
        args: &BakeArgs,
        lichens: &Lichens,
        baked: &Baked,
        writer: &Writer,
        seconds: Seconds,
    ) -> Self {
        let LayoutReport {
            texels,
            covered,
            overlaps,
            not_shown,
            texel,
        } = baked.report();
        let maps = MAPS.iter().map(|map| writer.file_name(map));
        let others = [GLB, SIDECAR].map(str::to_owned);
        Self {
            elements: lichens.elements(),
            lichens: lichens.grown.len(),
            folder: args.output.display().to_string(),
            size: baked.size(),
            texel,
            highest: baked.highest(),
            covered_by_layout: covered as f64 / texels as f64,
            overlapping_texels: overlaps.texels,
            overlapping_triangles: overlaps.triangles,
            triangles_not_shown: not_shown,
            files: maps.chain(others).collect(),
            seconds,
        }
    }
}

fn conclude(args: &BakeArgs, report: &Report) -> Result<(), Failure> {
    if args.json {
        terminal::say_json(report)?;
    } else if !args.run.quiet {
        let (elements, size) = (elements(report.elements), report.size);
        let seconds = duration(report.seconds.total);
        let glb = Path::new(&report.folder).join(GLB);
        let of = match report.lichens {
            1 => String::new(),
            several => format!(" of {several} lichens"),
        };
        terminal::say(&format!(
            "{}: {elements}{of} in {} maps of {size} x {size}, in {seconds}",
            glb.display(),
            MAPS.len()
        ))?;
    }
    Ok(())
}
