//! `thallus export`: a run's lichen for another program.

use std::borrow::Cow;
use std::path::Path;

use anyhow::Context;
use thallus::export::{
    Attribute, Elements, NotOnMesh, Scene, SceneFormat, SceneFormatError, UpAxis, Values, What,
    write_file_atomically,
};
use thallus::morphometry::{measure, smooth_normals};
use thallus::picture::age_color;
use thallus::substrate::{Substrate, SurfacePoint};

use super::args::ExportArgs;
use super::axes::Convention;
use super::failure::Failure;
use super::grown::Grown;
use super::interrupt::leave_no_part;
use super::mesh_args::MeshArgs;
use super::mesh_file::load;
use super::number::{elements, plural};
use super::output::check_names_file;
use super::run_args::start_threads;
use super::terminal::{self, Voice};

pub(crate) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let wrong = |e: SceneFormatError| Failure::Usage(e.into());
    let format = SceneFormat::of(&args.output, args.what).map_err(wrong)?;
    let convention = Convention::from(format);
    check_names_file(&args.output)?;
    leave_no_part();
    start_threads(args.run.threads)?;
    let voice = args.run.voice();
    let mut grown = Grown::read(&args.from, voice)?;
    grown.spare(&args.output, &args.mesh)?;
    let up = smooth(&mut grown, &args.mesh, voice)?;
    let placement = args.axes.placement(&convention, up)?;
    let measured = measure(&grown.elements.sample(), grown.curvature_radius());
    let meters_per_unit = args.axes.meters_per_unit(&convention);
    let scene = Scene::new(grown.elements, measured, &placement, meters_per_unit);
    write_file_atomically(&args.output, args.force, |out| {
        format.write(args.what, &scene, &age_color, out)
    })?;
    if args.run.quiet {
        return Ok(());
    }
    let elements = elements(scene.elements.len());
    let what = match args.what {
        What::Curves => plural(scene.streams.len(), "branch", "branches") + " of " + &elements,
        _ => elements,
    };
    terminal::say(&format!("{}: {what}", args.output.display()))?;
    Ok(())
}

/// Gives elements the smooth normals of their mesh, and its up axis, as far as it is known. The
/// lichen is whole without a mesh: its normals are then those of the flat triangles.
fn smooth(grown: &mut Grown, mesh: &MeshArgs, voice: Voice) -> Result<Option<UpAxis>, Failure> {
    let up = grown.up(mesh);
    let placed = match grown.file_of(mesh) {
        Ok(file) => place(grown, mesh, &file, up),
        Err(unknown) => Err(Failure::Failed(unknown.into())),
    };
    match placed {
        Ok(up) => Ok(Some(up)),
        Err(Failure::Failed(error)) if mesh.file.is_none() => {
            voice.warn(&format!(
                "{error:#}; normals are those of the flat triangles: give the mesh with --mesh"
            ));
            Ok(grown.up_unseen(mesh))
        }
        Err(other) => Err(other),
    }
}

fn place(
    grown: &mut Grown,
    mesh: &MeshArgs,
    file: &Path,
    up: Option<UpAxis>,
) -> Result<UpAxis, Failure> {
    let substrate = load(file)?;
    grown.tell_of_change(mesh.file.as_deref(), file, &substrate);
    let found = smooth_on(&mut grown.elements, &substrate);
    let (places, is_turned) = found.with_context(|| file.display().to_string())?;
    grown.tell_of_turn(file, is_turned);
    number_on(&mut grown.elements, &substrate, &places);
    let up = if is_turned { mesh.up } else { up };
    Ok(substrate.with_up(up).up_axis())
}

/// Gives elements the smooth normals of their mesh, and its axes where a program has [turned](Elements::on_turned) it;
/// where they are, and whether one has.
pub(super) fn smooth_on(
    elements: &mut Elements,
    substrate: &Substrate,
) -> Result<(Vec<SurfacePoint>, bool), NotOnMesh> {
    let (table, places) = elements.on_turned(substrate)?;
    let is_turned = matches!(table, Cow::Owned(_));
    if let Cow::Owned(turned) = table {
        *elements = turned;
    }
    let normals = smooth_normals(substrate, &places);
    elements.normals = normals.iter().map(|n| n.as_vec3().to_array()).collect();
    Ok((places, is_turned))
}

/// Says of elements where they are in the triangles of this mesh, and in those of its file.
pub(super) fn number_on(elements: &mut Elements, substrate: &Substrate, places: &[SurfacePoint]) {
    let number = |place: &SurfacePoint| substrate.canonical_triangle(place.triangle);
    elements.triangle = places.iter().map(number).collect();
    elements.uv = places.iter().map(|p| [p.u as f32, p.v as f32]).collect();
    let source = places.iter().map(|place| substrate.source_of_place(place));
    let (triangles, weights): (Vec<u32>, Vec<[f64; 3]>) = source.unzip();
    elements.source_triangle = Some(triangles);
    let column = |name, corner: usize| Attribute {
        name,
        values: Values::F32(weights.iter().map(|w| w[corner] as f32).collect()),
    };
    let columns = [column("source_u", 1), column("source_v", 2)];
    elements.attributes.extend(columns);
}
