//! Axes, seeds and what all cells share.

use std::collections::HashMap;
use std::f64::consts::PI;

use super::{Axis, GridError};
use crate::run::{BIAS, Length, Places, Recipe, Settings, SettingsError, StopRule, StopSetting};
use crate::substrate::Substrate;

/// Where no size is asked for, every cell grows to this reach, in radii of the largest elements
/// of the grid: seven times the width of branches at the widest usual L of 20 r.
pub const REACH_RADII: f64 = 150.0;

/// Most runs of a grid.
const MOST_RUNS: f64 = 1e6;

/// Bytes of a cell's name, at most: a file's may have 255, and some of its files are called after it.
const LONGEST_NAME: usize = 200;

/// What is to be grown: every combination of the axes' values, with every seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What all cells share, where an axis says nothing else.
    pub base: Settings,
    /// The first goes across a page, the second down; each combination of further ones is a page.
    pub axes: Vec<Axis>,
    /// Runs a cell. Their seeds are the base's (1 where it has none) and the numbers after it, the
    /// same in every cell.
    pub seeds: u32,
}

/// How the cells of a grid lie: those of a page follow one another, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Values of the first axis.
    pub columns: usize,
    /// Values of the second axis.
    pub rows: usize,
    /// Combinations of the further ones.
    pub pages: usize,
}

/// One combination of the axes' values.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// `L=5r_B=0.2`: a folder's name on any system.
    pub name: String,
    /// Number of the value on each axis.
    pub at: Vec<usize>,
    /// What the values say, over what all cells share.
    pub settings: Settings,
}

/// One lichen of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridRun {
    /// Number of its cell.
    pub cell: usize,
    /// Its seed.
    pub seed: u64,
    /// What grows; or why nothing can, where a value of its cell is out of range or does not suit the
    /// mesh. Such a run has its place in the grid, and the others are grown without it.
    pub recipe: Result<Recipe, SettingsError>,
}

impl GridRun {
    /// A hash of everything that decides the result; the paths of mesh and mask do not. None where nothing can
    /// grow.
    pub fn hash(&self) -> Option<String> {
        let mut recipe = self.recipe.as_ref().ok()?.clone();
        recipe.mesh.file.clear();
        recipe.mask.iter_mut().for_each(|mask| mask.layers.clear());
        let hash = blake3::hash(recipe.to_toml().as_bytes());
        Some(hash.to_hex().to_string())
    }
}

/// A grid on a mesh: its cells and runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The first axis changes fastest.
    pub cells: Vec<Cell>,
    /// Cell by cell, seeds ascending.
    pub runs: Vec<GridRun>,
    /// What each run costs, as far as one can tell before: see [`cost`]. 0 where nothing can grow.
    pub costs: Vec<f64>,
}

impl Grid {
    /// The cells, the first axis changing fastest. Whether they can be grown is found out by
    /// [`Grid::plan`].
    ///
    /// # Errors
    /// When axes exclude one another or what the flags say, nothing varies, or there are more than a
    /// million runs.
    pub fn cells(&self) -> Result<Vec<Cell>, GridError> {
        self.check()?;
        let count = self.axes.iter().map(Axis::len).product();
        (0..count).map(|number| self.cell(number)).collect()
    }

    /// How the cells lie.
    pub fn layout(&self) -> Layout {
        let length = |k: usize| self.axes.get(k).map_or(1, Axis::len);
        let further = self.axes.iter().skip(2);
        Layout {
            columns: length(0),
            rows: length(1),
            pages: further.map(Axis::len).fold(1, usize::saturating_mul),
        }
    }

    /// What a page has in common, as its title: `gain = 2, join = pack`; empty for the only one.
    pub fn page_title(&self, page: usize) -> String {
        let mut rest = page;
        let mut titles = Vec::new();
        for axis in self.axes.iter().skip(2) {
            titles.push(axis.title(rest % axis.len()));
            rest /= axis.len();
        }
        titles.join(", ")
    }

    fn check(&self) -> Result<(), GridError> {
        for (i, axis) in self.axes.iter().enumerate() {
            if self.axes[..i].iter().any(|other| other.key() == axis.key()) {
                return Err(GridError::SameAxis(axis.key()));
            }
        }
        if self.axes.is_empty() && self.seeds == 1 {
            return Err(GridError::Nothing);
        }
        let lengths = self.axes.iter().map(|axis| axis.len() as f64);
        let runs = lengths.product::<f64>() * f64::from(self.seeds);
        match runs {
            0.0 => Err(GridError::Seeds),
            _ if runs > MOST_RUNS => Err(GridError::TooMany { runs }),
            _ => Ok(()),
        }
    }

    /// Refuses what flags say where an axis says it too.
    ///
    /// # Errors
    /// [`GridError::AxisAndFlag`].
    pub fn check_flags(&self, flags: &Settings) -> Result<(), GridError> {
        match self
            .axes
            .iter()
            .find(|axis| axis.overrules(flags).is_some())
        {
            Some(axis) => Err(GridError::AxisAndFlag { axis: axis.key() }),
            None => Ok(()),
        }
    }

    /// Forgets of what all cells share what an axis says in each of them, so that every setting stands in
    /// one place.
    pub fn forget_overruled(&mut self) {
        for axis in &self.axes {
            self.base = std::mem::take(&mut self.base).without(&axis.said());
        }
    }

    fn cell(&self, number: usize) -> Result<Cell, GridError> {
        let mut rest = number;
        let place = |axis: &Axis| {
            let at = rest % axis.len();
            rest /= axis.len();
            at
        };
        let at: Vec<usize> = self.axes.iter().map(place).collect();
        let lines = self.axes.iter().zip(&at).map(|(axis, &i)| axis.line(i));
        let said = Settings::from_toml(&lines.collect::<String>()).map_err(GridError::Exclusive)?;
        let name = self.name(&at);
        let settings = said.over(self.base.clone());
        Ok(Cell { name, at, settings })
    }

    /// `L=5r_B=0.2`; `all` where nothing varies but the seed. Of a long one the beginning, and a hash of all of it.
    fn name(&self, at: &[usize]) -> String {
        let word = |(axis, &i): (&Axis, &usize)| {
            let label = axis.values()[i].label();
            let safe = |c: char| c.is_ascii_alphanumeric() || ".,+-%".contains(c);
            let label: String = label
                .chars()
                .map(|c| if safe(c) { c } else { '~' })
                .collect();
            format!("{}={label}", axis.symbol())
        };
        let whole = self.axes.iter().zip(at).map(word).collect::<Vec<_>>();
        match whole.join("_") {
            none if none.is_empty() => "all".to_owned(),
            long if long.len() > LONGEST_NAME => {
                let hash = blake3::hash(long.as_bytes()).to_hex();
                format!("{}~{}", &long[..LONGEST_NAME - 17], &hash[..16])
            }
            name => name,
        }
    }

    /// The seeds of every cell.
    ///
    /// # Errors
    /// When there are none, or they go beyond 64 bits.
    fn seed_numbers(&self) -> Result<Vec<u64>, GridError> {
        let first = self.base.seed.unwrap_or(1);
        let seeds = (0..u64::from(self.seeds)).map(|k| first.checked_add(k));
        seeds.collect::<Option<Vec<_>>>().ok_or(GridError::Seeds)
    }

    /// The runs on a mesh, `file` being its path as the user gave it. Where nothing says how large
    /// lichens get, each grows to a reach of [`REACH_RADII`] radii of the largest elements
    /// that can be grown.
    ///
    /// # Errors
    /// As [`Grid::cells`]; when two cells are the same, or no cell can be grown. One of many that cannot
    /// is none: its runs say why ([`GridRun::recipe`]).
    pub fn plan(&self, substrate: &Substrate, file: &str) -> Result<Plan, GridError> {
        let mut cells = self.cells()?;
        let seeds = self.seed_numbers()?;
        let places = Places::on(substrate);
        let resolve = |cell: &Cell, seed| {
            let settings = Settings {
                seed: Some(seed),
                ..cell.settings.clone()
            };
            settings.resolve_by(&places, file)
        };
        let radius = |cell: &Cell| {
            let mut recipes = seeds.iter().map(|&seed| resolve(cell, seed));
            recipes.find_map(|recipe| Some(recipe.ok()?.radius))
        };
        if let Some(largest) = cells.iter().filter_map(radius).reduce(f64::max) {
            let reach = StopSetting::Reach(Length::Units(REACH_RADII * largest));
            for cell in &mut cells {
                cell.settings.stop.get_or_insert(reach);
            }
        }
        let run = |(cell, seed)| GridRun {
            cell,
            seed,
            recipe: resolve(&cells[cell], seed),
        };
        let every = (0..cells.len()).flat_map(|cell| seeds.iter().map(move |&seed| (cell, seed)));
        let runs: Vec<GridRun> = every.map(run).collect();
        check_possible(&cells, &runs)?;
        check_different(&cells, &runs)?;
        let area = |recipe: &Recipe| substrate.units().area_to_file(places.area(recipe));
        let cost = |recipe: &Recipe| cost(recipe, area(recipe));
        let cost = |run: &GridRun| run.recipe.as_ref().map_or(0.0, cost);
        let costs = runs.iter().map(cost).collect();
        Ok(Plan { cells, runs, costs })
    }
}

fn check_possible(cells: &[Cell], runs: &[GridRun]) -> Result<(), GridError> {
    let problems: Option<Vec<_>> = runs.iter().map(|run| run.recipe.as_ref().err()).collect();
    match problems.as_deref() {
        Some([problem, ..]) => Err(GridError::NoCell {
            cell: cells[0].name.clone(),
            problem: (*problem).clone(),
        }),
        _ => Ok(()),
    }
}

fn check_different(cells: &[Cell], runs: &[GridRun]) -> Result<(), GridError> {
    let mut seen = HashMap::new();
    for run in runs {
        let Some(hash) = run.hash() else { continue };
        if let Some(first) = seen.insert(hash, run.cell) {
            return Err(GridError::SameCell {
                first: cells[first].name.clone(),
                second: cells[run.cell].name.clone(),
            });
        }
    }
    Ok(())
}

/// What a run costs, in elements that stick at first contact, as far as one can tell before.
///
/// The number of elements is taken as that of a fractal of dimension 2 at B ≤ 0.3, falling to 1.71
/// at B = 1, and each as 1 + 1/P at a straight front, for contacts that are refused (P = B, at least
/// P_min and 0.05). `area` is that of the pieces it grows on, mesh units squared.
pub fn cost(recipe: &Recipe, area: f64) -> f64 {
    let open = ((recipe.bias - 0.3) / 0.7).clamp(0.0, 1.0);
    let room = area / (PI * recipe.radius * recipe.radius);
    let elements = match recipe.stop {
        StopRule::Elements(n) => n as f64,
        StopRule::Reach(length) => {
            recipe.at.len() as f64 * libm::pow(length / recipe.radius, 2.0 - 0.29 * open)
        }
        StopRule::Cover(share) => share * room,
    };
    let chance = recipe
        .bias
        .max(recipe.min_stick)
        .clamp(0.05, BIAS.high.min(1.0));
    elements.min(room) * (1.0 + 1.0 / chance)
}

impl Plan {
    /// Why a cell cannot be grown, whatever the seed.
    ///
    /// # Panics
    /// When there is no such cell.
    pub fn problem(&self, cell: usize) -> Option<&SettingsError> {
        let seeds = self.runs.len() / self.cells.len();
        let runs = self.runs[cell * seeds..(cell + 1) * seeds].iter();
        let mut problems = runs.map(|run| run.recipe.as_ref().err());
        let first = problems.next()??;
        problems.all(|problem| problem.is_some()).then_some(first)
    }

    /// What the runs grow that can.
    pub fn recipes(&self) -> impl Iterator<Item = &Recipe> {
        self.runs.iter().flat_map(|run| &run.recipe)
    }

    /// The runs, the costliest first: whoever takes the next one when free is done soonest.
    pub fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.runs.len()).collect();
        order.sort_by(|&a, &b| self.costs[b].total_cmp(&self.costs[a]).then(a.cmp(&b)));
        order
    }

    /// The runs of the `part`-th of `parts` parts, from 1, the costliest first. They are dealt out
    /// in the order of [`Plan::order`], so that parts cost about the same.
    ///
    /// # Panics
    /// When `part` is not one of 1 to `parts`.
    pub fn shard(&self, part: usize, parts: usize) -> Vec<usize> {
        assert!((1..=parts).contains(&part), "part {part} of {parts}");
        let order = self.order();
        order.into_iter().skip(part - 1).step_by(parts).collect()
    }

    /// The folder of a run, within that of its sweep, with `/` between its parts.
    ///
    /// # Panics
    /// When there is no such run.
    pub fn folder(&self, run: usize) -> String {
        let GridRun { cell, seed, .. } = &self.runs[run];
        format!("cells/{}/seed-{seed}", self.cells[*cell].name)
    }

    /// The name of a run: cell and seed.
    ///
    /// # Panics
    /// When there is no such run.
    pub fn name(&self, run: usize) -> String {
        let GridRun { cell, seed, .. } = &self.runs[run];
        format!("{} seed {seed}", self.cells[*cell].name)
    }
}
