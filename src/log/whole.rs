//! A log written in one go.

use std::io::{self, Write};

use super::block::{Draft, LARGEST_BLOCK};
use super::head::sealed_head;
use crate::cluster::Element;
use crate::growth::Counts;
use crate::run::Recipe;

/// Writes the log of finished elements: full blocks, and one for the rest. `counts` has what it
/// took up to the end of each.
///
/// Where the blocks of a growing log end is for the clock to say. These bytes depend on recipe,
/// elements and counts alone.
///
/// # Errors
/// Those of `out`.
///
/// # Panics
/// When there are not as many counts as blocks.
pub fn write_whole(
    recipe: &Recipe,
    elements: &[Element],
    counts: &[Counts],
    out: &mut dyn Write,
) -> io::Result<()> {
    let blocks = elements.chunks(LARGEST_BLOCK);
    assert_eq!(blocks.len(), counts.len(), "counts for each block");
    let (head, seal) = sealed_head(recipe);
    out.write_all(&head)?;
    let (mut written, mut first) = (head.len() as u64, 0);
    for (elements, counts) in blocks.zip(counts) {
        let mut draft = Draft::new(first);
        elements.iter().for_each(|e| draft.push(e));
        let block = draft.close(seal, written, counts);
        out.write_all(&block)?;
        written += block.len() as u64;
        first += elements.len() as u64;
    }
    Ok(())
}
