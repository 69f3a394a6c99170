//! Grids as TOML: a recipe, with `seeds` and a table `[axes]`.

use std::path::Path;

use toml::de::DeTable;

use super::{Axis, Grid, GridFileError, GridTextError};
use crate::input;
use crate::run::{AXES, Settings, line_at, not_toml};

const SEEDS: &str = "seeds";

impl Grid {
    /// Reads a grid file.
    ///
    /// # Errors
    /// When it cannot be read or is no grid.
    pub fn read(path: &Path) -> Result<Self, GridFileError> {
        let fail = |problem| GridFileError::Read {
            path: path.to_owned(),
            problem,
        };
        let text = input::text(path).map_err(fail)?;
        Self::from_toml(&text).map_err(|problem| GridFileError::Text {
            path: path.to_owned(),
            problem,
        })
    }

    /// Reads a grid's text: the keys of a recipe, all of them optional; `seeds = N`; and below a line
    /// `[axes]` a line an axis, its values as text or as an array. The first axis is the first there.
    ///
    /// # Errors
    /// When it is not TOML, or has a key or value that no grid has.
    pub fn from_toml(text: &str) -> Result<Self, GridTextError> {
        let toml = |e: toml::de::Error| GridTextError::Recipe(not_toml(&e));
        let table = DeTable::parse(text).map_err(toml)?;
        let plain: toml::Table = text.parse().map_err(toml)?;
        let axes_start = start_of_axes(text, &table)?;
        let mut recipe = text[..axes_start].to_owned();
        let mut seeds = 1;
        for (key, value) in table.get_ref() {
            if *key.get_ref() == SEEDS {
                seeds = read_seeds(&plain[SEEDS], line_at(text, key.span().start))?;
                // Blank, so that line numbers in errors stay true.
                let span = key.span().start..value.span().end;
                let blank: String = text[span.clone()].chars().map(blank).collect();
                recipe.replace_range(span, &blank);
            }
        }
        let base = Settings::from_toml(&recipe)?;
        let axes = read_axes(text, &table, &plain)?;
        check_said_once(&base, &axes)?;
        Ok(Self {
            base,
            axes: axes.into_iter().map(|(_, axis)| axis).collect(),
            seeds,
        })
    }

    /// The text of this grid on this mesh: to sweep it again, and as the record of a sweep.
    pub fn to_toml(&self) -> String {
        let mut text =
            "# A grid of lichens. The same again: thallus sweep grid.toml -o DIR\n\n".to_owned();
        text += &self.base.to_toml();
        text += &format!("{SEEDS} = {}\n\n[{AXES}]\n", self.seeds);
        self.axes.iter().for_each(|axis| text += &axis.to_toml());
        text
    }

    /// What is different in another grid, in words. The path of the mesh does not count, nor how a number was
    /// written, where cells have the same names.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let mut differences = self.base.differences_and_size(&other.base);
        if self.seeds != other.seeds {
            differences.push(format!("seeds was {} and is {}", self.seeds, other.seeds));
        }
        let lines = |grid: &Self| -> Vec<String> {
            let axes = grid.axes.iter();
            axes.map(|axis| axis.to_toml().trim_end().to_owned())
                .collect()
        };
        let (ours, theirs) = (lines(self), lines(other));
        let pairs = || self.axes.iter().zip(&other.axes);
        let is_other = self.axes.len() != other.axes.len() || pairs().any(|(a, b)| !a.is_same(b));
        if is_other {
            let words = |lines: &[String]| match lines.is_empty() {
                true => "none".to_owned(),
                false => lines.join(", "),
            };
            differences.push(format!(
                "axes were {} and are {}",
                words(&ours),
                words(&theirs)
            ));
        }
        differences
    }
}

fn blank(c: char) -> char {
    if c == '\n' { '\n' } else { ' ' }
}

/// Where the line `[axes]` begins; the end of the text where there is none.
fn start_of_axes(text: &str, table: &toml::Spanned<DeTable<'_>>) -> Result<usize, GridTextError> {
    let keys = || table.get_ref().keys();
    let Some(key) = keys().find(|key| *key.get_ref() == AXES) else {
        return Ok(text.len());
    };
    let start = key.span().start;
    let line = line_at(text, start);
    let line_start = text[..start].rfind('\n').map_or(0, |end| end + 1);
    let fail = |line, problem| Err(GridTextError::Other { line, problem });
    if text[line_start..start].trim() != "[" {
        return fail(line, "write the axes below a line [axes], one a line");
    }
    match keys().find(|key| key.span().start > start) {
        Some(late) => fail(
            line_at(text, late.span().start),
            "only axes may follow [axes]: put everything else above it",
        ),
        None => Ok(line_start),
    }
}

fn read_seeds(value: &toml::Value, line: usize) -> Result<u32, GridTextError> {
    let seeds = value.as_integer().and_then(|n| u32::try_from(n).ok());
    seeds.filter(|&n| n > 0).ok_or(GridTextError::Other {
        line,
        problem: "seeds is how many runs a cell has: a whole number from 1",
    })
}

/// Refuses an axis of what is set for all cells too: one of the two would be without effect.
fn check_said_once(base: &Settings, axes: &[(usize, Axis)]) -> Result<(), GridTextError> {
    for (line, axis) in axes {
        if let Some(key) = axis.overrules(base) {
            return Err(GridTextError::AlsoSet {
                line: *line,
                axis: axis.key(),
                key,
            });
        }
    }
    Ok(())
}

/// The axes and their lines, in the order in which they are written.
fn read_axes(
    text: &str,
    table: &toml::Spanned<DeTable<'_>>,
    plain: &toml::Table,
) -> Result<Vec<(usize, Axis)>, GridTextError> {
    let Some(written) = table
        .get_ref()
        .get(AXES)
        .and_then(|v| v.get_ref().as_table())
    else {
        return Ok(Vec::new());
    };
    let mut keys: Vec<_> = written.keys().collect();
    keys.sort_by_key(|key| key.span().start);
    let axis = |key: &toml::Spanned<toml::de::DeString<'_>>| {
        let name: &str = key.get_ref();
        let line = line_at(text, key.span().start);
        match Axis::from_toml(name, &plain[AXES][name]) {
            Ok(axis) => Ok((line, axis)),
            Err(problem) => Err(GridTextError::Axis { line, problem }),
        }
    };
    keys.into_iter().map(axis).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Length;
    use proptest::prelude::*;

    const TEXT: &str = "\
        mesh = \"rock.obj\" # a rock\n\
        seeds = 3\n\
        gain = 2\n\
        \n\
        [axes]\n\
        L = \"5r,10r\"\n\
        bias = [0.2, 0.5]\n\
        at = [[0, 1, 0], \"top\"]\n";

    fn message(text: &str) -> String {
        Grid::from_toml(text).unwrap_err().to_string()
    }

    #[test]
    fn a_grid_is_a_recipe_with_axes() {
        let grid = Grid::from_toml(TEXT).unwrap();
        assert_eq!((grid.seeds, grid.base.gain), (3, Some(2.0)));
        let keys: Vec<_> = grid.axes.iter().map(Axis::key).collect();
        assert_eq!(keys, ["curvature-radius", "bias", "at"], "in their order");
        assert_eq!(Grid::from_toml(&grid.to_toml()).unwrap(), grid);
        assert!(grid.differences(&grid).is_empty());
        let recipe = Grid::from_toml("radius = 2").unwrap();
        assert_eq!(recipe.base.radius, Some(Length::Units(2.0)));
        assert!(recipe.axes.is_empty());
    }

    #[test]
    fn what_differs_is_named() {
        let grid = Grid::from_toml(TEXT).unwrap();
        for (old, new, part) in [
            ("seeds = 3", "seeds = 4", "seeds was 3 and is 4"),
            ("gain = 2", "gain = 3", "gain was 2.0 and is 3.0"),
            (
                "gain = 2",
                "gain = 2\nreach = 5",
                "the size was the usual and is reach = 5.0",
            ),
            ("5r,10r", "5r,20r", "axes were curvature-radius"),
        ] {
            let other = Grid::from_toml(&TEXT.replace(old, new)).unwrap();
            let differences = grid.differences(&other);
            assert_eq!(differences.len(), 1, "{differences:?}");
            assert!(differences[0].contains(part), "{differences:?}");
        }
    }

    #[test]
    fn a_number_written_otherwise_is_the_same_axis() {
        let grid = |text: &str| Grid::from_toml(&format!("[axes]\n{text}\n")).unwrap();
        for (one, other) in [
            ("B = \"0,1\"", "bias = [0.0, 1]"),
            ("B = [0.50]", "B = [5e-1]"),
            ("elements = \"1000\"", "elements = \"1e3\""),
        ] {
            assert!(grid(one).differences(&grid(other)).is_empty(), "{other}");
        }
        let named = grid("L = \"5r,10r\"").differences(&grid("L = \"5.0r,10r\""));
        assert!(!named.is_empty(), "cells have other names");
    }

    #[test]
    fn faults_have_their_line() {
        for (old, new, parts) in [
            ("seeds = 3", "seeds = 0", ["line 2", "whole number from 1"]),
            ("gain = 2", "biass = 2", ["line 3", "did you mean 'bias'"]),
            ("5r,10r", "5r,x", ["line 6", "axis curvature-radius"]),
            ("[axes]", "[axes2]", ["line 5", "axes2"]),
            (
                "[axes]\n",
                "axes.bias = [1]\n",
                ["line 5", "below a line [axes]"],
            ),
            (
                "bias = [0.2, 0.5]",
                "bias = [0.2, 0.2]",
                ["line 7", "twice"],
            ),
            (
                "gain = 2",
                "bias = 0.2",
                ["line 7", "bias is an axis, and bias is set for all cells"],
            ),
            (
                "gain = 2",
                "at-triangle = 3",
                ["line 8", "at is an axis, and at-triangle is set"],
            ),
        ] {
            let message = message(&TEXT.replace(old, new));
            for part in parts {
                assert!(message.contains(part), "{new}: '{part}' not in {message}");
            }
        }
        let late = message(&format!("{TEXT}[more]\nbias = 1\n"));
        assert!(
            late.contains("line 9") && late.contains("above it"),
            "{late}"
        );
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "(\\[axes\\]\n|seeds = |L|bias|[-0-9.,;/rlog%\n\" =\\[\\]]){0,30}") {
            let _ = Grid::from_toml(&text);
        }
    }
}
