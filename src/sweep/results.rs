//! What the runs of a grid came to.

use super::{Axis, Cell, Grid, Plan};
use crate::analysis::SCALARS;
use crate::export::{Table, TableColumn, TableValues};
use crate::run::{COLONIES, COVER, ELEMENTS, REACH, Settings, Stopped, shell_word, unquoted};

/// What a run came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Why it ended: one word.
    pub stopped: String,
    /// Named numbers, NaN for none. Runs are compared by those that the first of them has.
    pub measures: Vec<(String, f64)>,
    /// Seconds that growing took: different every time.
    pub seconds: f64,
}

/// What all runs of a grid came to: an error in words for those that failed.
#[derive(Clone, Copy, Debug)]
pub struct Results<'a> {
    /// The grid.
    pub grid: &'a Grid,
    /// Its runs.
    pub plan: &'a Plan,
    /// One a run.
    pub outcomes: &'a [Result<Outcome, String>],
}

/// A measure over the seeds of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Mean of the runs that have a number; NaN for none.
    pub mean: f64,
    /// Sample standard deviation over the runs that have a number; 0 for one.
    pub deviation: f64,
    /// How many runs have a number.
    pub runs: usize,
}

impl Summary {
    fn of(values: &[f64]) -> Self {
        let runs = values.len();
        let mean = values.iter().sum::<f64>() / runs as f64;
        let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
        let deviation = match runs {
            0 | 1 => 0.0,
            _ => (squares / (runs - 1) as f64).sqrt(),
        };
        Self {
            mean,
            deviation,
            runs,
        }
    }
}

/// The word for a run that failed, where others say why they ended.
pub(super) const FAILED: &str = "failed";

impl<'a> Results<'a> {
    /// The first run that did not fail.
    fn first(&self) -> Option<&'a Outcome> {
        self.outcomes.iter().find_map(|o| o.as_ref().ok())
    }

    /// Names of the measures: those of the first run that did not fail.
    pub fn measures(&self) -> Vec<&'a str> {
        let names = self
            .first()
            .map(|o| o.measures.iter().map(|(name, _)| name.as_str()));
        names.into_iter().flatten().collect()
    }

    /// The runs of a cell, in the order of their seeds.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn runs_of(&self, cell: usize) -> std::ops::Range<usize> {
        let seeds = self.grid.seeds as usize;
        cell * seeds..(cell + 1) * seeds
    }

    /// How many runs of a cell stopped for this reason.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn stopped(&self, cell: usize, why: Stopped) -> usize {
        let is_so = |run: &usize| {
            let outcome = self.outcomes[*run].as_ref();
            outcome.is_ok_and(|o| o.stopped == why.name())
        };
        self.runs_of(cell).filter(is_so).count()
    }

    /// How many runs of a cell failed.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn failed(&self, cell: usize) -> usize {
        let has_failed = |run: &usize| self.outcomes[*run].is_err();
        self.runs_of(cell).filter(has_failed).count()
    }

    /// The run of a cell that stands for it in pictures: the first that was grown.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn pictured(&self, cell: usize) -> Option<usize> {
        self.runs_of(cell).find(|&run| self.outcomes[run].is_ok())
    }

    /// The path of the mesh: that of the plan, and that of the grid where the plan has none.
    pub(super) fn mesh(&self) -> &'a str {
        let mut files = self.plan.recipes().map(|recipe| recipe.mesh.file.as_str());
        let said = self.grid.base.mesh.as_deref();
        let planned = files.find(|file| !file.is_empty());
        planned.or(said).unwrap_or_default()
    }

    /// The command that grows a run again, and the same bytes.
    ///
    /// # Panics
    /// When there is no such run.
    pub fn command(&self, run: usize) -> String {
        let cell = self.cell_of(run);
        let settings = Settings {
            seed: Some(self.plan.runs[run].seed),
            ..cell.settings.clone()
        };
        format!(
            "thallus grow {} -o {} {}",
            shell_word(self.mesh()),
            shell_word(&cell.name),
            settings.flags()
        )
    }

    /// A measure of a run, by its number among [`Results::measures`]; NaN where the run failed, or does not have
    /// the measure of that name.
    ///
    /// # Panics
    /// When there is no such run or measure.
    pub fn value(&self, run: usize, measure: usize) -> f64 {
        let (name, _) = &self.first().expect("a run with measures").measures[measure];
        let Ok(Outcome { measures, .. }) = &self.outcomes[run] else {
            return f64::NAN;
        };
        // As a rule all runs have the same, in one order.
        let beside = measures.get(measure).filter(|(beside, _)| beside == name);
        let found = beside.or_else(|| measures.iter().find(|(other, _)| other == name));
        found.map_or(f64::NAN, |(_, value)| *value)
    }

    /// A measure over the seeds of a cell.
    ///
    /// # Panics
    /// When there is no such cell or measure.
    pub fn summary(&self, cell: usize, measure: usize) -> Summary {
        let values = self.runs_of(cell).map(|run| self.value(run, measure));
        Summary::of(&values.filter(|x| x.is_finite()).collect::<Vec<_>>())
    }

    /// A row a run: cell, the axes as they were written, seed, every parameter in mesh units, why it
    /// ended, every measure; last what took how long, which is different every time.
    ///
    /// # Panics
    /// When there are fewer outcomes than runs.
    pub fn table(&self) -> Table {
        let mut columns = vec![self.texts("cell", |run| self.cell_of(run).name.clone())];
        for (k, axis) in self.grid.axes.iter().enumerate() {
            columns.push(self.axis_column(k, axis));
        }
        let seed = |run: usize| self.plan.runs[run].seed;
        columns.push(self.column("seed", TableValues::U64(self.runs().map(seed).collect())));
        columns.extend(self.parameter_columns());
        columns.push(self.texts("stopped", |run| match &self.outcomes[run] {
            Ok(outcome) => outcome.stopped.clone(),
            Err(_) => FAILED.to_owned(),
        }));
        for (measure, name) in self.measures().into_iter().enumerate() {
            // A measure may be a parameter too, as the radius is.
            if columns.iter().all(|column| column.name != name) {
                columns.push(self.numbers(name, |run| self.value(run, measure)));
            }
        }
        columns.push(self.numbers("seconds_grow", |run| {
            let outcome = self.outcomes[run].as_ref();
            outcome.map_or(f64::NAN, |o| o.seconds)
        }));
        Table { columns }
    }

    fn runs(&self) -> std::ops::Range<usize> {
        0..self.plan.runs.len()
    }

    fn cell_of(&self, run: usize) -> &'a Cell {
        &self.plan.cells[self.plan.runs[run].cell]
    }

    fn column(&self, name: &str, values: TableValues) -> TableColumn {
        TableColumn {
            name: name.to_owned(),
            values,
        }
    }

    fn texts(&self, name: &str, of: impl Fn(usize) -> String) -> TableColumn {
        self.column(name, TableValues::Text(self.runs().map(of).collect()))
    }

    fn numbers(&self, name: &str, of: impl Fn(usize) -> f64) -> TableColumn {
        let values = self.runs().map(of).collect();
        let values = match is_count(name) {
            true => TableValues::Counts(values),
            false => TableValues::F64(values),
        };
        self.column(name, values)
    }

    /// The values of an axis as they were written: numbers where all of them are.
    fn axis_column(&self, k: usize, axis: &Axis) -> TableColumn {
        let name = format!("axis_{}", axis.symbol().replace('-', "_"));
        let label = |run: usize| axis.values()[self.cell_of(run).at[k]].label().to_owned();
        let is_number = |v: &super::AxisValue| v.label().parse::<f64>().is_ok();
        match axis.values().iter().all(is_number) {
            true => self.numbers(&name, |run| label(run).parse().unwrap_or(f64::NAN)),
            false => self.texts(&name, label),
        }
    }

    /// A column a parameter. Those that are numbers in every run are columns of numbers. Of a run that
    /// cannot be, lengths in mesh units may not exist: it has none.
    fn parameter_columns(&self) -> Vec<TableColumn> {
        let said: Vec<Vec<(&str, String)>> = self
            .runs()
            .map(|run| match &self.plan.runs[run].recipe {
                Ok(recipe) => Settings::from(recipe).said(),
                Err(_) => Vec::new(),
            })
            .collect();
        let mut keys: Vec<&str> = Vec::new();
        for (key, _) in said.iter().flatten() {
            if *key != "seed" && !keys.contains(key) {
                keys.push(key);
            }
        }
        let column = |key: &&str| {
            let value = |run: usize| {
                let entry = said[run].iter().find(|(k, _)| k == key);
                match (entry, &self.plan.runs[run].recipe) {
                    (Some((_, value)), _) => value.clone(),
                    // They are unsaid where each has a place of its own.
                    (None, Ok(recipe)) if *key == COLONIES.name => recipe.at.len().to_string(),
                    (None, _) => String::new(),
                }
            };
            let is_number = |text: &String| text.is_empty() || text.parse::<f64>().is_ok();
            let name = column_name(key);
            match self.runs().map(value).all(|text| is_number(&text)) {
                true => self.numbers(&name, |run| value(run).parse().unwrap_or(f64::NAN)),
                false => self.texts(&name, |run| unquoted(&value(run))),
            }
        };
        keys.iter().map(column).collect()
    }
}

/// Whether a column has numbers that are whole by their nature, of a measure, an axis or a parameter.
fn is_count(column: &str) -> bool {
    let said = ["axis_", "stop_"].iter();
    let name = said.fold(column, |name, prefix| {
        name.strip_prefix(prefix).unwrap_or(name)
    });
    name == COLONIES.name || SCALARS.iter().any(|s| s.name == name && s.is_count())
}

/// What a parameter is called: where growth was to stop, and where it stopped, are two things.
fn column_name(key: &str) -> String {
    let name = key.replace('-', "_");
    match [ELEMENTS.name, REACH.name, COVER.name].contains(&key) {
        true => format!("stop_{name}"),
        false => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_are_mean_and_sample_deviation() {
        let summary = Summary::of(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!((summary.mean, summary.runs), (5.0, 8));
        assert!((summary.deviation - (32.0f64 / 7.0).sqrt()).abs() < 1e-15);
        assert_eq!(Summary::of(&[3.0]).deviation, 0.0);
        assert!(Summary::of(&[]).mean.is_nan());
    }

    #[test]
    fn counts_are_those_of_things() {
        for name in [
            "elements",
            "stop_elements",
            "axis_elements",
            "tips",
            "colonies",
            "axis_colonies",
            "strahler_order",
        ] {
            assert!(is_count(name), "{name}");
        }
        for name in [
            "radius",
            "stop_reach",
            "axis_B",
            "walkers_per_element",
            "seconds_grow",
        ] {
            assert!(!is_count(name), "{name}");
        }
    }
}
