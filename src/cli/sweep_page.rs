//! What a finished sweep is looked at by: tables, pictures, contact sheets, one page.

use std::io::{self, Write};

use thallus::export::write_file_atomically;
use thallus::run::{StopRule, Stopped};
use thallus::sweep::{mean_of, page};

use super::failure::Failure;
use super::number::{count, duration, elements, plural, short};
use super::sweep_ended::Ended;
use super::sweep_files::CSV;
use super::sweep_picture::Pictures;
use super::sweep_view::PictureStyle;
use super::terminal;

const PARQUET: &str = "results.parquet";
const REPORT: &str = "report.html";

/// Why runs end before they have the size asked for, and what helps.
struct Early {
    why: Stopped,
    words: &'static str,
    cure: &'static str,
}

const EARLY: [Early; 3] = [
    Early {
        why: Stopped::Full,
        words: "no free surface was left",
        cure: "ask for a smaller one, or take smaller elements",
    },
    Early {
        why: Stopped::Starved,
        words: "open edges took all walkers",
        cure: "--boundary reflect loses none",
    },
    Early {
        why: Stopped::Hemmed,
        words: "mask or slope left no place",
        cure: "other habitat is reached by --colonies, or from elsewhere (--at)",
    },
];

impl Ended<'_> {
    /// Makes all of it; what stood there is replaced.
    pub(super) fn make(&self, style: &PictureStyle) -> Result<(), Failure> {
        let results = self.results();
        let table = results.table();
        self.write(CSV, |out| table.write_csv(out))?;
        self.write(PARQUET, |out| table.write_parquet(out))?;
        let pictures = Pictures::take(self, style)?;
        for number in 0..self.grid.layout().pages {
            let png = pictures.sheet(&results, number, self.note()).to_png();
            self.write(&self.sheet_name(number), |out| out.write_all(&png))?;
        }
        let html = page(&results, &pictures.for_page(), &self.facts());
        self.write(REPORT, |out| out.write_all(html.as_bytes()))
    }

    /// `contact-sheet.png`, or one a page.
    fn sheet_name(&self, page: usize) -> String {
        match self.grid.layout().pages {
            1 => "contact-sheet.png".to_owned(),
            _ => format!("contact-sheet-{}.png", page + 1),
        }
    }

    /// All of them, in a few words.
    fn sheet_names(&self) -> String {
        match self.grid.layout().pages {
            1 => self.sheet_name(0),
            pages => format!("{} to -{pages}.png", self.sheet_name(0)),
        }
    }

    /// What all cells have in common, in one line.
    fn note(&self) -> String {
        let seeds = match self.grid.seeds {
            1 => String::new(),
            _ => format!(
                "; {}, the picture is of the first",
                mean_of(&self.results())
            ),
        };
        format!(
            "each grown to {}; same camera and scale{seeds}",
            self.size()
        )
    }

    /// How large the lichens were to get.
    fn size(&self) -> String {
        let mut rules = self.plan.recipes().map(|recipe| recipe.stop);
        let rule = rules
            .next()
            .filter(|first| rules.all(|rule| rule == *first));
        let Some(rule) = rule else {
            return "the size of its cell".to_owned();
        };
        let size = match rule {
            StopRule::Elements(n) => elements(n as usize),
            StopRule::Reach(length) if self.are_alone() => {
                format!("R_e = {} mesh units", short(length))
            }
            StopRule::Reach(length) => format!("a reach of {} mesh units", short(length)),
            StopRule::Cover(share) => format!("a share of {} of the surface", short(share)),
        };
        let ends = EARLY.iter().filter(|end| self.stopped(end.why) > 0);
        ends.fold(size, |size, end| format!("{size}, or until {}", end.words))
    }

    /// Whether every lichen is one colony.
    fn are_alone(&self) -> bool {
        self.plan.recipes().all(|recipe| recipe.at.len() == 1)
    }

    fn stopped(&self, why: Stopped) -> usize {
        let results = self.results();
        (0..self.plan.cells.len())
            .map(|cell| results.stopped(cell, why))
            .sum()
    }

    /// What the page says of all cells.
    fn facts(&self) -> Vec<(String, String)> {
        let fact = |name: &str, text: String| (name.to_owned(), text);
        let mesh = self.grid.base.mesh.clone().unwrap_or_default();
        let mut facts = vec![fact("Mesh", mesh)];
        let triangles = self.substrate.triangles().len() as u64;
        facts.push(fact("Triangles", count(triangles)));
        let mut radii = self.plan.recipes().map(|recipe| recipe.radius);
        if let Some(radius) = radii.next().filter(|first| radii.all(|r| r == *first)) {
            facts.push(fact("Radius r", format!("{} mesh units", short(radius))));
        }
        facts.push(fact("Grown to", self.size()));
        let runs = plural(self.plan.runs.len(), "run", "runs");
        let seeds = plural(self.grid.seeds as usize, "seed", "seeds");
        let failed = match self.failed() {
            0 => String::new(),
            failed => format!("; {} failed", count(failed as u64)),
        };
        facts.push(fact("Runs", format!("{runs}, {seeds} a cell{failed}")));
        let said = self.grid.base.flags();
        if !said.is_empty() {
            facts.push(fact("All cells", said));
        }
        facts.push(fact("Thallus", env!("CARGO_PKG_VERSION").to_owned()));
        facts
    }

    fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        Ok(write_file_atomically(&self.folder.join(name), true, fill)?)
    }

    /// Tells what there is now.
    pub(super) fn tell(&self) -> Result<(), Failure> {
        for end in &EARLY {
            if let some @ 1.. = self.stopped(end.why) {
                self.voice.warn(&format!(
                    "{} short of the size asked for, as {}: '{}' in {CSV}; {}",
                    plural(some, "lichen stopped", "lichens stopped"),
                    end.words,
                    end.why.name(),
                    end.cure,
                ));
            }
        }
        if self.voice.quiet {
            return Ok(());
        }
        let seconds = self.outcomes.iter().flatten().map(|o| o.seconds).sum();
        terminal::say(&format!(
            "{0}: {1} of {2}, {3} of growing; look at {4}\n  {REPORT}, {5}, {CSV}, {PARQUET}, \
             pictures/, cells/",
            self.folder.display(),
            plural(self.plan.runs.len(), "run", "runs"),
            plural(self.plan.cells.len(), "cell", "cells"),
            duration(seconds),
            self.folder.join(REPORT).display(),
            self.sheet_names(),
        ))?;
        Ok(())
    }
}
