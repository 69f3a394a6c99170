//! `thallus bake`: the lichen as textures of its mesh.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use thallus::bake::{BakeError, Baked, Baker, Base, Look, MOST_ACROSS, Settings};
use thallus::cluster::Cluster;
use thallus::export::{Axes, OutputDir, OutputError, Placement, UpAxis};
use thallus::input;
use thallus::run::shell_path;
use thallus::skin::{Paint, Shape};
use thallus::substrate::{Substrate, Texturing};

use super::also::{Also, tell_of_overlaps};
use super::axes::Convention;
use super::bake_args::{BakeArgs, Each};
use super::bake_flags::{Flags, Settled, UNWRAP, WASTED, are_few, cure};
use super::bake_parts::{MapPart, Parts, plain};
use super::bake_report::{PartReport, Report, Seconds, conclude};
use super::bake_where::{Where, listed};
use super::bake_write::{GLB, Writer};
use super::dress::{Dress, check_lies};
use super::failure::Failure;
use super::grown::{Grown, Origin};
use super::interrupt::Held;
use super::memory;
use super::mesh_file::load_textured;
use super::number::{count, elements, plural, short};
use super::output::check_names_folder;
use super::run_args::start_threads;
use super::skin_args::{ColorArgs, ReliefArgs};
use super::skin_look::Measure;

pub(crate) fn bake(args: &BakeArgs) -> Result<(), Failure> {
    check_names_folder(&args.output)?;
    let settings = Settings {
        size: args.maps.size,
        gutter: args.maps.gutter,
        samples: args.maps.samples,
        unwrap: args.unwrap,
    };
    settings.check().map_err(|e| Failure::Usage(e.into()))?;
    check_layout(args)?;
    start_threads(args.run.threads)?;
    let started = Instant::now();
    let lichens = Lichens::read(args)?;
    let base = base(args, &lichens)?;
    let placement = placement(args, &lichens.substrate)?;
    let mut folder = OutputDir::create(&args.output, args.force).map_err(taken)?;
    folder.spare(&lichens.read);
    let folder = Held::listen(folder);
    let seconds = Seconds::loaded(started);
    let mut baking = Baking {
        args,
        lichens: &lichens,
        writer: Writer::new(args, &name(args, &lichens.mesh), &placement),
        reports: Vec::new(),
        elements: 0,
        kept: Vec::new(),
        lichened: Vec::new(),
        seconds,
    };
    baking.bake(&base, &settings, &folder)?;
    let written = Instant::now();
    let (mut folder, stop) = folder.take().ok_or(Failure::Interrupted)?;
    let finished = baking.writer.finish(&mut folder, &stop);
    let finished = finished.and_then(|()| folder.commit());
    finished.map_err(|e| stop.reason(e))?;
    baking.seconds.write += written.elapsed().as_secs_f64();
    baking.seconds.total = started.elapsed().as_secs_f64();
    conclude(args, &baking.report())
}

/// Refuses charts of their own in a layout that is asked for too.
fn check_layout(args: &BakeArgs) -> Result<(), Failure> {
    let other = match args.unwrap {
        true if args.uv_set == 1 => "--uv-set 1",
        true if args.each.contains(&Each::Tile) => "--each tile",
        _ => return Ok(()),
    };
    Err(Failure::Usage(anyhow::anyhow!(
        "--unwrap lays maps out in charts of its own, {other} in the mesh's UVs: leave one of them out"
    )))
}

/// Maps that are being made, part by part.
struct Baking<'a> {
    args: &'a BakeArgs,
    lichens: &'a Lichens,
    writer: Writer<'a>,
    /// Of the parts that are done.
    reports: Vec<PartReport>,
    /// On these.
    elements: usize,
    /// The parts without maps.
    kept: Vec<String>,
    /// For each triangle of the file whether lichen may be on it.
    lichened: Vec<bool>,
    seconds: Seconds,
}

impl<'a> Baking<'a> {
    fn bake(
        &mut self,
        base: &Base,
        settings: &Settings,
        folder: &Held<OutputDir>,
    ) -> Result<(), Failure> {
        let started = Instant::now();
        let looks: Vec<Look> = self.lichens.grown.iter().map(Lichen::look).collect();
        let Lichens {
            substrate,
            texturing,
            parts,
            ..
        } = self.lichens;
        let baker = Baker::new(substrate, texturing, &looks, base, settings);
        let baker = baker.map_err(|e| self.failed(e, None))?;
        self.lichened = baker.lichened();
        let [laid_out, kept] = self.laid_out(&baker)?;
        self.check_lichen(&baker, &laid_out)?;
        self.seconds.bake += started.elapsed().as_secs_f64();
        self.check_memory(laid_out.len(), !kept.is_empty())?;
        let mut largest = 0;
        for (number, part) in laid_out.into_iter().enumerate() {
            let chosen = parts.chosen(part);
            let baked = self.baked(&baker, (number, part), chosen.as_deref())?;
            let elements = self.lichens.elements_on(&baked);
            self.elements += elements;
            self.warn(part, (elements, &baked));
            largest = largest.max(baked.largest_image());
            let started = Instant::now();
            let written = folder.lend(|folder, stop| {
                let written = self.writer.write(folder, stop, (part, &baked));
                written.map_err(|e| stop.reason(e))
            });
            let files = written.ok_or(Failure::Interrupted)??;
            self.seconds.write += started.elapsed().as_secs_f64();
            self.reports
                .push(PartReport::new(part, (elements, &baked), files));
        }
        self.keep(&kept, &baker, folder)?;
        self.tell_of_detail(largest);
        if texturing.is_posed {
            self.args.run.voice().note(&format!(
                "{GLB} has the mesh in the pose of its file; skeletons and animations are left out of it"
            ));
        }
        baker.notes().for_each(|note| self.say_of_mesh(note));
        Ok(())
    }

    /// The parts that maps are made of, unless one is laid out so that it should not be, and those that stay as they
    /// are.
    fn laid_out(&self, baker: &Baker) -> Result<[Vec<&'a MapPart>; 2], Failure> {
        let lichens: &'a Lichens = self.lichens;
        let parts = &lichens.parts;
        let chosen = |part: &MapPart| parts.chosen(part);
        let is_bare =
            |part: &&MapPart| part.name.is_some() && baker.is_bare(chosen(part).as_deref());
        let is_gone = |part: &&MapPart| baker.is_gone(chosen(part).as_deref());
        let (gone, there): (Vec<_>, Vec<_>) = parts.list().iter().partition(is_gone);
        for name in gone.iter().filter_map(|part| part.name.as_ref()) {
            self.say_of_mesh(&format!(
                "'{name}' has no area, or lies where other parts do: its triangles are left out, and it is not in \
                 {GLB}"
            ));
        }
        if there.is_empty() {
            let mesh = lichens.mesh.display();
            return Err(Failure::Failed(anyhow::anyhow!(
                "{mesh}: what is asked for has no area, or lies where other parts of the mesh do: its triangles are left \
                 out; choose others"
            )));
        }
        let (mut kept, mut others): (Vec<_>, Vec<_>) = there.into_iter().partition(is_bare);
        // Whoever asks for nothing but such parts asks for their maps.
        if others.is_empty() {
            std::mem::swap(&mut kept, &mut others);
        }
        let (mut laid_out, mut flat) = (Vec::new(), Vec::new());
        for part in others {
            match baker.check(chosen(part).as_deref()) {
                Ok(()) => laid_out.push(part),
                Err(e @ (BakeError::NoUvs | BakeError::FlatUvs)) if part.name.is_some() => {
                    let name = part.name.as_deref().unwrap_or_default();
                    flat.push((e, name));
                    kept.push(part);
                }
                Err(e) => return Err(self.failed(e, Some(part))),
            }
        }
        if laid_out.is_empty() {
            return Err(self.failed_for(&flat));
        }
        flat.iter().for_each(|(_, name)| self.say_of_flat(name));
        Ok([laid_out, kept])
    }

    /// Says that a part can have no maps.
    fn say_of_flat(&self, name: &str) {
        self.say_of_mesh(&format!(
            "'{name}' has no UVs with area: there are no maps of it, and no lichen on it in {GLB}"
        ));
    }

    /// Names the parts for which there are no maps at all.
    fn failed_for(&self, flat: &[(BakeError, &str)]) -> Failure {
        let Some((error, _)) = flat.first() else {
            return self.failed(BakeError::NoUvs, None);
        };
        let names: Vec<String> = flat.iter().map(|(_, name)| (*name).to_owned()).collect();
        let names = listed(&names);
        let error = anyhow::anyhow!("maps are to be made of {names} only: {error} ({UNWRAP})");
        let mesh = self.lichens.mesh.display();
        error.context(mesh.to_string()).into()
    }

    /// Refuses maps in which there is no lichen.
    fn check_lichen(&self, baker: &Baker, laid_out: &[&MapPart]) -> Result<(), Failure> {
        let Lichens {
            substrate,
            texturing,
            parts,
            grown,
            mesh,
            ..
        } = self.lichens;
        let elements = grown.iter().flat_map(|lichen| lichen.cluster.elements());
        let triangles: BTreeSet<u32> = elements.map(|element| element.at.triangle).collect();
        let is_in = |part: &&MapPart| {
            let chosen = parts.chosen(part);
            triangles.iter().any(|&t| {
                let source = substrate.source_triangle(t) as usize;
                let is_chosen = |chosen: &Vec<bool>| chosen.get(source) == Some(&true);
                baker.has_place(t) && chosen.as_ref().is_none_or(is_chosen)
            })
        };
        if laid_out.iter().any(is_in) {
            return Ok(());
        }
        let cure = match triangles.iter().all(|&t| baker.has_place(t)) {
            true => "choose with --only what has lichen",
            false => "lay that out with --unwrap, or choose with --only what has lichen",
        };
        let told = Where::of((substrate, texturing), triangles.into_iter()).told();
        Err(Failure::Failed(anyhow::anyhow!(
            "{}: no element of the lichen would be in a map: {told}; {cure}",
            mesh.display()
        )))
    }

    /// Refuses maps of so many parts, and of others as they are, that memory has no room for.
    fn check_memory(&self, parts: usize, keeps: bool) -> Result<(), Failure> {
        let Lichens {
            substrate,
            texturing,
            grown,
            ..
        } = self.lichens;
        let clusters = grown.iter().map(|lichen| &lichen.cluster);
        let images: usize = texturing.images.iter().map(Vec::len).sum();
        let kept = if keeps { images } else { 0 };
        memory::check_maps(substrate, clusters, (self.args.maps.size, parts, kept))?;
        match self.args.unwrap {
            true => memory::check_charts(substrate),
            false => Ok(()),
        }
    }

    /// Says so where an image of the mesh has more texels along a side than its maps.
    fn tell_of_detail(&self, widest: usize) {
        let size = self.args.maps.size;
        if widest <= size as usize {
            return;
        }
        let enough = (widest as u32).min(MOST_ACROSS);
        let cure = match enough > size {
            true => format!("--size {enough} keeps its detail"),
            false => "there are none larger".to_owned(),
        };
        self.args.run.voice().note(&format!(
            "an image under the lichen is {widest} texels wide or high, and maps are {size}: {cure}"
        ));
    }

    /// Puts parts into the file with what they wear anyway.
    fn keep(
        &mut self,
        kept: &[&MapPart],
        baker: &Baker,
        folder: &Held<OutputDir>,
    ) -> Result<(), Failure> {
        let Lichens {
            texturing, parts, ..
        } = self.lichens;
        if kept.is_empty() {
            return Ok(());
        }
        let mut chosen = vec![false; texturing.material_of.len()];
        for part in kept.iter().filter_map(|part| parts.chosen(part)) {
            chosen
                .iter_mut()
                .zip(part)
                .for_each(|(all, one)| *all |= one);
        }
        let meshes = baker.own_meshes(Some(&chosen));
        self.writer.keep(meshes, (baker, texturing));
        let fits =
            folder.lend(|folder, stop| self.writer.check_size(folder).map_err(|e| stop.reason(e)));
        fits.ok_or(Failure::Interrupted)??;
        self.kept = kept.iter().filter_map(|part| part.name.clone()).collect();
        if let [first, others @ ..] = &self.kept[..] {
            let others = match others.len() {
                0 => String::new(),
                n => format!(" and {n} more"),
            };
            let [have, they] = match self.kept.len() {
                1 => ["has", "it wears"],
                _ => ["have", "they wear"],
            };
            self.args.run.voice().note(&format!(
                "'{first}'{others} {have} no maps: in {GLB} {they} what the mesh's file says"
            ));
        }
        Ok(())
    }

    fn baked<'b>(
        &mut self,
        baker: &'b Baker,
        (number, part): (usize, &MapPart),
        chosen: Option<&'b [bool]>,
    ) -> Result<Baked<'b>, Failure> {
        let started = Instant::now();
        let what = match &part.name {
            None => elements(self.lichens.elements()),
            Some(name) => format!(
                "'{name}' ({} of {})",
                number + 1,
                self.lichens.parts.list().len()
            ),
        };
        let spinner = self.args.run.voice().spinner(&format!("baking {what}"));
        let baked = match chosen {
            None => baker.whole(),
            Some(chosen) => baker.part(chosen),
        };
        spinner.finish_and_clear();
        self.seconds.bake += started.elapsed().as_secs_f64();
        baked.map_err(|e| self.failed(e, Some(part)))
    }

    /// Names the file that is at fault, the part of it, and the cure.
    fn failed(&self, error: BakeError, part: Option<&MapPart>) -> Failure {
        let named = match (&self.args.maps.base, &error) {
            (Some(Dress::Image(image)), BakeError::Base(_)) => image,
            _ => &self.lichens.mesh,
        };
        let sharing = part.filter(|_| error.is_of_sharing());
        let error = match sharing.map(|part| self.cure(part)) {
            Some(cure) => anyhow::anyhow!("{error}, or: {cure}"),
            None if error.is_of_missing_uvs() => anyhow::anyhow!("{error} ({UNWRAP})"),
            None if error == BakeError::Crowded => match self.args.maps.size * 2 {
                size if size <= MOST_ACROSS => {
                    anyhow::anyhow!("{error} (--size {size}, or --each)")
                }
                _ => anyhow::anyhow!("{error} (--each)"),
            },
            None => error.into(),
        };
        let error = match part.and_then(|part| self.left_out(part)) {
            Some(part) => error.context(part),
            None => error,
        };
        error.context(named.display().to_string()).into()
    }

    /// A part by its name, and how to do without it.
    fn left_out(&self, part: &MapPart) -> Option<String> {
        let name = part.name.as_ref()?;
        let parts = &self.lichens.parts;
        let all = parts.list();
        let without = |kind| {
            let Some(own) = parts.own_name(part) else {
                return format!("triangles of no {kind} that has a name");
            };
            let same = all.iter().filter(|part| parts.own_name(part) == Some(own));
            let it = match same.count() {
                same if same == all.len() => return format!("{kind} '{name}'"),
                1 => "it".to_owned(),
                _ => format!("all that the file calls '{own}'"),
            };
            let others = shell_path(Path::new(&format!("{kind}:!{own}")));
            format!("{kind} '{name}' (to do without {it}: --only {others})")
        };
        Some(match self.args.each[..] {
            [Each::Object] => without("object"),
            [Each::Material] => without("material"),
            _ => format!("'{name}'"),
        })
    }

    fn say_of_mesh(&self, what: &str) {
        let mesh = self.lichens.mesh.display();
        self.args.run.voice().warn(&format!("{mesh}: {what}"));
    }

    fn warn(&self, part: &MapPart, (elements, baked): (usize, &Baked)) {
        let report = baked.report();
        let of = part
            .name
            .as_ref()
            .map_or(String::new(), |name| format!("'{name}': "));
        let shared = report.overlaps;
        let share = shared.texels as f64 / report.covered.max(1) as f64;
        if !are_few(share) {
            let share = 100.0 * share;
            let overlap = plural(shared.triangles, "triangle overlaps", "triangles overlap");
            self.say_of_mesh(&format!(
                "{of}{overlap} in the UVs: {share:.1} % of the texels in use show \
                 one place of the surface and stand for several; {}",
                self.cure(part)
            ));
        }
        // Charts of their own have no place only for needles that hold nothing.
        if report.not_shown > 0 && !self.args.unwrap {
            let [hidden, all] = [report.not_shown, report.triangles].map(|n| count(n as u64));
            self.say_of_mesh(&format!(
                "{of}{hidden} of {all} triangles have no UVs, or no area in them: lichen there is in no \
                 map"
            ));
        }
        if elements == 0 {
            self.say_of_mesh(&format!(
                "{of}no element of the lichen is there, at most its rim from beside: --only leaves parts out"
            ));
        }
        let radii = self.lichens.grown.iter().map(|l| l.cluster.radius());
        let radius = radii.fold(f64::INFINITY, f64::min);
        let radius = self.lichens.substrate.units().length_to_file(radius);
        if report.texel > COARSE * radius {
            let radii = report.texel / radius;
            // Nobody can pack charts of its own better.
            let used = match self.args.unwrap {
                true => 1.0,
                false => report.covered as f64 / report.texels as f64,
            };
            self.args.run.voice().warn(&format!(
                "{of}a texel is {radii:.1} element radii wide: single elements do not show; {}",
                how_to_show_more(used, self.args.maps.size)
            ));
        }
    }

    /// What to do where several places of a part share texels: what has been tried and serves, or else is sure to.
    fn cure(&self, part: &MapPart) -> String {
        let Lichens {
            substrate,
            texturing,
            parts,
            ..
        } = self.lichens;
        let chosen = parts.chosen(part);
        let settled = Settled {
            each: &self.args.each,
            is_second: self.args.uv_set == 1,
            chosen: chosen.as_deref(),
            lichened: Some(&self.lichened),
        };
        let best = Flags::best(substrate, texturing, settled);
        match best.ok().and_then(|best| best.that_serve()) {
            Some(flags) => format!("with {flags} no place of it shares texels with another"),
            None => cure(texturing, settled.is_second),
        }
    }

    fn report(&mut self) -> Report {
        let lichens = self.lichens;
        Report {
            elements: self.elements,
            lichens: lichens.grown.len(),
            folder: self.args.output.display().to_string(),
            size: self.args.maps.size,
            parts_without_maps: std::mem::take(&mut self.kept),
            files: self.writer.files().to_vec(),
            seconds: std::mem::take(&mut self.seconds),
            ..Report::of_parts(std::mem::take(&mut self.reports))
        }
    }
}

/// Of the mesh that wears the maps: its file's, and which part it is.
fn name(args: &BakeArgs, mesh: &Path) -> String {
    let name = mesh.file_stem().unwrap_or("lichened".as_ref());
    let only = args.only.iter().map(|only| plain(&format!("_{only}")));
    name.to_string_lossy().into_owned() + &only.collect::<String>()
}

/// Lichens on their mesh, and what the mesh file says about textures.
struct Lichens {
    mesh: PathBuf,
    substrate: Substrate,
    texturing: Texturing,
    /// What of it has maps of its own.
    parts: Parts,
    /// The first, and those that are there also.
    grown: Vec<Lichen>,
    /// Files that all this was read from.
    read: Vec<PathBuf>,
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
        let mut read = grown.files(&args.mesh);
        let (substrate, mut texturing) = load_textured(&mesh)?;
        read.extend(texturing.image_files.iter().cloned());
        read.extend(args.maps.base.as_ref().and_then(Dress::file));
        grown.hide_mask(&mut texturing);
        if args.uv_set == 1 {
            texturing.swap_uv_sets();
            check_has_uvs(&texturing).with_context(|| mesh.display().to_string())?;
        }
        let parts = Parts::of(args, &texturing).with_context(|| mesh.display().to_string())?;
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
            parts,
            grown: vec![first],
            read,
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

    fn another(&mut self, args: &BakeArgs, also: &Also) -> Result<Lichen, Failure> {
        let (grown, cluster) = also.read(&self.substrate, args.run.voice())?;
        grown.spare(&args.output.join(GLB), &args.mesh)?;
        self.read.extend(grown.files(&args.mesh));
        Lichen::new(
            &self.substrate,
            (grown.origin(), cluster),
            &args.relief,
            &also.color,
        )
    }

    /// Elements of all.
    fn elements(&self) -> usize {
        self.grown.iter().map(|lichen| lichen.cluster.len()).sum()
    }

    /// Of all, those on the triangles that are shown.
    fn elements_on(&self, baked: &Baked) -> usize {
        let all = self
            .grown
            .iter()
            .flat_map(|lichen| lichen.cluster.elements());
        all.filter(|element| baked.shows(element.at.triangle))
            .count()
    }
}

/// What the mesh looks like where there is no lichen.
fn base(args: &BakeArgs, lichens: &Lichens) -> Result<Base, Failure> {
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
            if args.unwrap {
                check_lies((&lichens.mesh, &lichens.texturing), ("--base", file))?;
            }
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

fn check_has_uvs(texturing: &Texturing) -> anyhow::Result<()> {
    match texturing.uvs.is_empty() {
        true => Err(anyhow::anyhow!(
            "--uv-set 1: the mesh has no second set of UVs that can be read, which is TEXCOORD_1 of a glTF file"
        )),
        false => Ok(()),
    }
}

/// Texels wider than this, in element radii, show no elements.
const COARSE: f64 = 2.0;

/// Of an image whose UVs use this share.
fn how_to_show_more(used: f64, size: u32) -> String {
    match used {
        wasted if wasted < WASTED => format!(
            "the UVs use {} % of the image: pack them to be larger",
            short(100.0 * used)
        ),
        _ if size < MOST_ACROSS => "a larger --size shows more".to_owned(),
        _ => "--size is the largest that there is: lay the UVs out over several tiles, objects or materials, and give \
              each its maps with --each"
            .to_owned(),
    }
}
