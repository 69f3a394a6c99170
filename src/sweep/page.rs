//! One self-contained HTML page of a sweep: pictures in a grid, charts, numbers, commands.
//!
//! It needs nothing beside it: pictures are data URLs, charts are SVG, style and script are in it.
//! Nothing in it depends on when or how fast the runs were grown.

use std::fmt::Write;

use serde::Serialize;

use super::chart::{chart, hue};
use super::results::FAILED;
use super::{Axis, Results, Summary};
use crate::analysis::SCALARS;
use crate::export::base64::base64;
use crate::picture::number;
use crate::run::Stopped;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The picture of a cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CellPicture {
    /// A JPEG file; empty for none.
    pub jpeg: Vec<u8>,
}

/// What the script of the page knows of a cell.
#[derive(Serialize)]
struct CellData<'a> {
    name: &'a str,
    title: String,
    seeds: Vec<u64>,
    /// A text a measure: mean and deviation.
    summaries: Vec<String>,
    /// A list a measure: a text a seed.
    values: Vec<Vec<String>>,
    stopped: Vec<&'a str>,
    errors: Vec<String>,
    /// Of its picture; where it has none, what its first run was to be.
    command: String,
}

#[derive(Serialize)]
struct Data<'a> {
    measures: Vec<&'a str>,
    cells: Vec<CellData<'a>>,
}

/// The page. `pictures` has one a cell; `facts` are lines about what all cells share.
///
/// # Panics
/// When there are fewer pictures than cells, or fewer outcomes than runs.
pub fn page(results: &Results, pictures: &[CellPicture], facts: &[(String, String)]) -> String {
    let title = title(results);
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{0}</h1>\n",
        escaped(&title)
    );
    push_facts(&mut html, facts);
    html.push_str("</header>\n<main>\n");
    for page in 0..results.grid.layout().pages {
        push_grid(&mut html, results, pictures, page);
    }
    push_charts(&mut html, results);
    push_numbers(&mut html, results);
    html.push_str("</main>\n");
    html.push_str(DIALOG);
    let data = serde_json::to_string(&data(results)).unwrap_or_default();
    let data = data.replace('<', "\\u003c");
    let _ = write!(
        html,
        "<script type=\"application/json\" id=\"data\">{data}</script>\n<script>\n{SCRIPT}</script>\n\
         </body>\n</html>\n"
    );
    html
}

const DIALOG: &str = "\
<div id=\"tip\" hidden></div>
<dialog id=\"cell\" aria-labelledby=\"cell-title\">
<form method=\"dialog\"><h2 id=\"cell-title\">Cell</h2><button type=\"submit\" aria-label=\"Close\">&times;</button></form>
<div class=\"about\"><div id=\"cell-picture\"></div>
<div><p id=\"cell-error\"></p>
<h3>This lichen again</h3>
<div class=\"command\"><code id=\"cell-command\"></code><button type=\"button\" data-copy=\"cell-command\">Copy</button></div>
<h3>All seeds of this cell again</h3>
<div class=\"command\"><code id=\"cell-only\"></code><button type=\"button\" data-copy=\"cell-only\">Copy</button></div>
<div class=\"scroll\"><table id=\"cell-numbers\"></table></div></div></div>
</dialog>
";

/// What a sweep is called: `L × B on rock.obj`.
pub fn title(results: &Results) -> String {
    let names: Vec<_> = results.grid.axes.iter().map(Axis::symbol).collect();
    let names = match names.is_empty() {
        true => "Seeds".to_owned(),
        false => names.join(" × "),
    };
    let mesh = results.mesh();
    let file = match mesh.rsplit(['/', '\\']).next() {
        Some("") | None => "a mesh",
        Some(file) => file,
    };
    format!("{names} on {file}")
}

fn push_facts(html: &mut String, facts: &[(String, String)]) {
    html.push_str("<dl>\n");
    for (name, fact) in facts {
        let _ = writeln!(
            html,
            "<div><dt>{}</dt><dd>{}</dd></div>",
            escaped(name),
            escaped(fact)
        );
    }
    html.push_str("</dl>\n");
}

fn push_grid(html: &mut String, results: &Results, pictures: &[CellPicture], page: usize) {
    let layout = results.grid.layout();
    let title = results.grid.page_title(page);
    html.push_str("<div class=\"page\">\n");
    if !title.is_empty() {
        let _ = writeln!(html, "<h2>{}</h2>", escaped(&title));
    }
    let has_rows = results.grid.axes.len() > 1;
    let class = if has_rows { "grid rows" } else { "grid" };
    let _ = writeln!(
        html,
        "<div class=\"scroll\"><div class=\"{class}\" style=\"--columns:{}\">",
        layout.columns
    );
    if has_rows {
        html.push_str("<span></span>\n");
    }
    if let Some(axis) = results.grid.axes.first() {
        for i in 0..layout.columns {
            let _ = writeln!(
                html,
                "<span class=\"column\">{}</span>",
                escaped(&axis.title(i))
            );
        }
    }
    for row in 0..layout.rows {
        if let Some(axis) = results.grid.axes.get(1) {
            let _ = writeln!(
                html,
                "<span class=\"row\">{}</span>",
                escaped(&axis.title(row))
            );
        }
        for column in 0..layout.columns {
            let cell = (page * layout.rows + row) * layout.columns + column;
            push_cell(html, results, &pictures[cell], cell);
        }
    }
    html.push_str("</div></div>\n</div>\n");
}

fn push_cell(html: &mut String, results: &Results, picture: &CellPicture, cell: usize) {
    let name = escaped(&results.plan.cells[cell].name);
    let _ = write!(
        html,
        "<button type=\"button\" class=\"cell\" data-cell=\"{cell}\">"
    );
    match picture.jpeg.is_empty() {
        true => html.push_str("<span class=\"failed\">failed</span>"),
        false => {
            let data = base64(&picture.jpeg);
            let _ = write!(
                html,
                "<img loading=\"lazy\" alt=\"Lichen of {name}\" src=\"data:image/jpeg;base64,{data}\">"
            );
        }
    }
    html.push_str("<span class=\"caption\">");
    for line in captions(results, cell) {
        let _ = write!(html, "<span>{}</span>", escaped(&line));
    }
    html.push_str("</span></button>\n");
}

/// What stands under the picture of a cell: effective radius R_e in mesh units and number of
/// elements n, with their standard deviations over several seeds; whether no free surface was left
/// before the lichen had its size; and how many runs failed, of which the numbers say nothing.
///
/// # Panics
/// When there is no such cell.
pub fn captions(results: &Results, cell: usize) -> Vec<String> {
    let names = results.measures();
    let of = |name: &str| names.iter().position(|n| *n == name);
    let summary = |name: &str| of(name).map(|measure| results.summary(cell, measure));
    let mut lines = Vec::new();
    if let Some(radius) = summary("effective_radius").filter(|s| s.runs > 0) {
        lines.push(format!("R_e {}", spread(&radius)));
    }
    if let Some(elements) = summary("elements").filter(|s| s.runs > 0) {
        lines.push(format!("n {}", counted(&elements)));
    }
    let runs = results.runs_of(cell).len();
    let early = [Stopped::Full, Stopped::Starved, Stopped::Hemmed];
    let short = early.map(|why| (results.stopped(cell, why), why.name()));
    for (some, word) in short.into_iter().chain([(results.failed(cell), FAILED)]) {
        match some {
            0 => {}
            some if some == runs && (runs == 1 || word == FAILED) => lines.push(word.to_owned()),
            some => lines.push(format!("{some} of {runs} {word}")),
        }
    }
    lines
}

/// How many seeds a mean is of, in words: fewer where some runs of a cell failed.
pub fn mean_of(results: &Results) -> String {
    let seeds = results.grid.seeds;
    let is_partial = |cell| (1..results.runs_of(cell).len()).contains(&results.failed(cell));
    match (0..results.plan.cells.len()).any(is_partial) {
        true => format!("mean of up to {seeds} seeds"),
        false => format!("mean of {seeds} seeds"),
    }
}

/// Where there is no number.
const NONE: &str = "–";

/// The same of a number of things.
fn counted(summary: &Summary) -> String {
    let [mean, deviation] = [summary.mean, summary.deviation].map(|x| number(x, 1.0));
    match summary.runs {
        1 => mean,
        _ => format!("{mean} ± {deviation}"),
    }
}

/// The same, and of how many runs where not all have a number: such a mean is of a selection.
pub(super) fn spread_of(summary: &Summary, runs: usize) -> String {
    match summary.runs {
        some if some > 0 && some < runs => format!("{} (of {some})", spread(summary)),
        _ => spread(summary),
    }
}

/// Mean and standard deviation, to the decimals of the larger one.
pub(super) fn spread(summary: &Summary) -> String {
    let Summary {
        mean, deviation, ..
    } = *summary;
    let decimals = decimals(mean.abs().max(deviation));
    match (summary.runs, decimals) {
        (0, _) => NONE.to_owned(),
        (1, _) => short(mean),
        (_, Some(0)) => format!("{} ± {}", number(mean, 1.0), number(deviation, 1.0)),
        (_, Some(decimals)) => format!("{mean:.decimals$} ± {deviation:.decimals$}"),
        (_, None) => format!("{mean:.2e} ± {deviation:.0e}"),
    }
}

/// Decimals after which a number of this size has four digits that count; none where it is better
/// written with a power of ten.
fn decimals(size: f64) -> Option<usize> {
    match size {
        0.0 => Some(1),
        _ if !(1e-4..1e7).contains(&size) => None,
        _ => Some((3 - libm::floor(libm::log10(size)) as i32).max(0) as usize),
    }
}

fn push_charts(html: &mut String, results: &Results) {
    html.push_str("<section>\n<h2>Measures</h2>\n");
    push_legend(html, results);
    for page in 0..results.grid.layout().pages {
        let title = results.grid.page_title(page);
        if !title.is_empty() {
            let _ = writeln!(html, "<h3>{}</h3>", escaped(&title));
        }
        html.push_str("<div class=\"charts\">\n");
        for (measure, name) in results.measures().into_iter().enumerate() {
            // An error is that of another measure, and in the table beside it.
            let is_error = name.ends_with("_error");
            if let Some(svg) = chart(results, measure, page).filter(|_| !is_error) {
                let _ = writeln!(html, "<figure>{}{svg}</figure>", figure_caption(name));
            }
        }
        html.push_str("</div>\n");
    }
    html.push_str("</section>\n");
}

/// What a chart is of, with its unit and its meaning where the analysis knows them.
fn figure_caption(name: &str) -> String {
    let shown = escaped(&name.replace('_', " "));
    match SCALARS.iter().find(|scalar| scalar.name == name) {
        None => format!("<figcaption>{shown}</figcaption>"),
        Some(scalar) => {
            let unit = match scalar.unit {
                "1" => String::new(),
                unit => format!(", {}", escaped(&unit_in_words(unit))),
            };
            let meaning = escaped(&scalar.meaning.replace("^2", "²"));
            format!("<figcaption>{shown}<small>{unit}</small><p>{meaning}</p></figcaption>")
        }
    }
}

/// The unit of a measure as readers of a page know it: its length is that of the mesh's file.
fn unit_in_words(unit: &str) -> String {
    unit.replace("unit", "mesh units").replace("^2", "²")
}

/// Which line is which, and what the bars are.
fn push_legend(html: &mut String, results: &Results) {
    html.push_str("<p class=\"legend\">");
    if let Some(axis) = results.grid.axes.get(1) {
        for i in 0..axis.len() {
            let hue = hue(i, axis.len());
            let title = escaped(&axis.title(i));
            let _ = write!(html, "<span style=\"--h:{hue}\"><i></i>{title}</span> ");
        }
    }
    if results.grid.seeds > 1 {
        let mean = mean_of(results);
        let _ = write!(html, "<span>{mean}, bars ± one standard deviation</span>");
    }
    html.push_str("</p>\n");
}

/// Every number, for those who cannot see the charts, or will not trust them.
fn push_numbers(html: &mut String, results: &Results) {
    html.push_str(
        "<details>\n<summary>All numbers</summary>\n<p>A row a cell, lengths in mesh \
         units. A row a run is in results.csv and results.parquet.</p>\n<div \
         class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">cell</th>",
    );
    let names = results.measures();
    for name in &names {
        let _ = write!(
            html,
            "<th scope=\"col\">{}</th>",
            escaped(&name.replace('_', " "))
        );
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for (number, cell) in results.plan.cells.iter().enumerate() {
        let _ = write!(html, "<tr><th scope=\"row\">{}</th>", escaped(&cell.name));
        for measure in 0..names.len() {
            let summary = results.summary(number, measure);
            let text = spread_of(&summary, results.runs_of(number).count());
            let _ = write!(html, "<td>{text}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n</details>\n");
}

fn data<'a>(results: &'a Results<'a>) -> Data<'a> {
    let measures = results.measures();
    let cell = |cell: usize| {
        let runs = || results.runs_of(cell);
        let axes = results.grid.axes.iter().zip(&results.plan.cells[cell].at);
        let titles: Vec<_> = axes.map(|(axis, &i)| axis.title(i)).collect();
        let value = |run, measure| match results.value(run, measure) {
            x if x.is_finite() => short(x),
            _ => NONE.to_owned(),
        };
        CellData {
            name: &results.plan.cells[cell].name,
            title: match titles.is_empty() {
                true => "all".to_owned(),
                false => titles.join(", "),
            },
            seeds: runs().map(|run| results.plan.runs[run].seed).collect(),
            summaries: (0..measures.len())
                .map(|measure| spread_of(&results.summary(cell, measure), runs().count()))
                .collect(),
            values: (0..measures.len())
                .map(|measure| runs().map(|run| value(run, measure)).collect())
                .collect(),
            stopped: runs()
                .map(|run| {
                    results.outcomes[run]
                        .as_ref()
                        .map_or(FAILED, |o| o.stopped.as_str())
                })
                .collect(),
            errors: runs().filter_map(|run| error(results, run)).collect(),
            command: results.command(results.pictured(cell).unwrap_or(runs().start)),
        }
    };
    Data {
        cells: (0..results.plan.cells.len()).map(cell).collect(),
        measures,
    }
}

fn error(results: &Results, run: usize) -> Option<String> {
    let reason = results.outcomes[run].as_ref().err()?;
    let seed = results.plan.runs[run].seed;
    Some(format!("seed {seed}: {reason}"))
}

/// A number with four digits that count.
pub(super) fn short(value: f64) -> String {
    match decimals(value.abs()) {
        _ if value == 0.0 => "0".to_owned(),
        None => format!("{value:.2e}"),
        Some(0) => number(value, 1.0),
        Some(decimals) => {
            let digits = format!("{value:.decimals$}");
            digits
                .trim_end_matches('0')
                .trim_end_matches('.')
                .to_owned()
        }
    }
}

/// A text in HTML, also within quotes.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_cannot_break_out() {
        assert_eq!(
            escaped("<b a='1'>&\""),
            "&lt;b a=&#39;1&#39;&gt;&amp;&quot;"
        );
    }

    #[test]
    fn spreads_have_the_decimals_of_the_larger() {
        let spread = |mean, deviation, runs| {
            spread(&Summary {
                mean,
                deviation,
                runs,
            })
        };
        assert_eq!(spread(0.099_812, 0.000_029, 2), "0.09981 ± 0.00003");
        assert_eq!(spread(5723.2, 28.3, 3), "5,723 ± 28");
        assert_eq!(spread(0.5, 0.0, 1), "0.5");
        assert_eq!(spread(0.0, 2.5, 2), "0.000 ± 2.500");
        assert_eq!(spread(3e-7, 1e-8, 2), "3.00e-7 ± 1e-8");
        assert_eq!(spread(f64::NAN, 0.0, 0), NONE);
        let some = Summary {
            mean: 0.5,
            deviation: 0.25,
            runs: 2,
        };
        assert_eq!(spread_of(&some, 2), "0.5000 ± 0.2500");
        assert_eq!(spread_of(&some, 3), "0.5000 ± 0.2500 (of 2)");
    }

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (0.5, "0.5"),
            (0.123_456, "0.1235"),
            (12_345.6, "12,346"),
            (1e-9, "1.00e-9"),
            (342.819, "342.8"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }
}
