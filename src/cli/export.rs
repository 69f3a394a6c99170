//! `thallus export`: the elements of a run in another format.

use std::path::{Path, PathBuf};

use thallus::export::{format_of, read_elements, write_file_atomically};

use super::args::ExportArgs;
use super::failure::Failure;
use super::number::plural;
use super::{output, terminal};

pub(crate) fn export(args: &ExportArgs) -> Result<(), Failure> {
    let format = format_of(&args.to).map_err(|unknown| Failure::Usage(unknown.into()))?;
    let elements = read_elements(&table_in(&args.from)).map_err(anyhow::Error::new)?;
    write_file_atomically(&args.to, args.force, |out| {
        format.write(&elements, &thallus::picture::age_color, out)
    })?;
    let count = plural(elements.len(), "element", "elements");
    terminal::say(&format!("{}: {count}", args.to.display()))?;
    Ok(())
}

/// The table of a run's folder, or the file itself.
pub(super) fn table_in(from: &Path) -> PathBuf {
    match from.is_dir() {
        true => from.join(output::ELEMENTS),
        false => from.to_owned(),
    }
}
