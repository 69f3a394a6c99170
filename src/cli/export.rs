//! `thallus export`: a run's lichen for another program.

use thallus::export::{
    Axes, Placement, Scene, SceneFormat, SceneFormatError, UpAxis, What, write_file_atomically,
};
use thallus::morphometry::measure;
use thallus::picture::age_color;

use super::args::ExportArgs;
use super::failure::Failure;
use super::grown::Grown;
use super::number::plural;
use super::terminal;

pub(crate) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let wrong = |e: SceneFormatError| Failure::Usage(e.into());
    let format = SceneFormat::of(&args.output, args.what).map_err(wrong)?;
    let grown = Grown::read(&args.from, args.mesh.as_deref())?;
    let placement = placement(args, format, grown.up)?;
    let measured = measure(&grown.elements.sample(), grown.curvature_radius);
    let meters_per_unit = match format.metres {
        true => 1.0,
        false => args.unit.meters(),
    };
    let scene = Scene::new(grown.elements, measured, &placement, meters_per_unit);
    write_file_atomically(&args.output, args.force, |out| {
        format.write(args.what, &scene, &age_color, out)
    })?;
    let elements = plural(scene.elements.len(), "element", "elements");
    let what = match args.what {
        What::Curves => plural(scene.streams.len(), "branch", "branches") + " of " + &elements,
        _ => elements,
    };
    terminal::say(&format!("{}: {what}", args.output.display()))?;
    Ok(())
}

/// From the mesh file's axes and units to those of the format, or as asked.
fn placement(
    args: &ExportArgs,
    format: &SceneFormat,
    mesh_up: Option<UpAxis>,
) -> Result<Placement, Failure> {
    let scale = match format.metres {
        true => args.scale * args.unit.meters(),
        false => args.scale,
    };
    let from = args.mesh_up.or(mesh_up);
    let to = match (format.axes, args.up) {
        (Axes::Fixed(fixed), Some(asked)) if asked != fixed => {
            return Err(Failure::usage(format!(
                ".{} files are y-up by specification, and programs turn them themselves: leave \
                 --up away",
                format.extension
            )));
        }
        (Axes::Fixed(up), _) | (_, Some(up)) => Some(up),
        (Axes::Usual(up), None) => Some(up),
        (Axes::Mesh | Axes::Declared, None) => from,
    };
    match (from, to) {
        (Some(from), Some(to)) => Ok(Placement { from, to, scale }),
        (None, None) if format.axes == Axes::Mesh => Ok(Placement {
            scale,
            ..Placement::unchanged(UpAxis::Y)
        }),
        _ => Err(Failure::usage(
            "nothing says which way is up on the mesh: give it with --mesh, or say --mesh-up y or z",
        )),
    }
}
