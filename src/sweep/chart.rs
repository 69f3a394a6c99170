//! A measure over the axes, as SVG: the first axis across, a line for each value of the second, bars
//! of one standard deviation over the seeds.

use std::fmt::Write;

use super::{Axis, AxisValue, Results, Summary};
use crate::picture::{number, round_below};

/// Size of a chart and of the space about its frame: left, top, right, bottom; SVG units.
const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 230.0;
const SPACE: [f64; 4] = [62.0, 10.0, 14.0, 40.0];

/// Where values of an axis lie.
struct Scale {
    /// Of each value, 0 to 1 from end to end.
    shares: Vec<f64>,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// At equal distances.
    Words,
    Linear,
    /// Of logarithms.
    Log,
}

impl Scale {
    /// Numbers where all values are, and of one unit: how far 5r is from 5% hangs on the mesh.
    fn of(axis: Option<&Axis>) -> Self {
        let values = axis.map_or(&[][..], Axis::values);
        let numbers: Option<Vec<(f64, &str)>> = values.iter().map(AxisValue::number).collect();
        let numbers = numbers.unwrap_or_default();
        let has_one_unit = numbers.iter().all(|(_, unit)| *unit == numbers[0].1);
        match numbers.len() > 1 && has_one_unit {
            true => Self::of_numbers(numbers.iter().map(|(number, _)| *number).collect()),
            false => Self::of_words(values.len().max(1)),
        }
    }

    fn of_words(count: usize) -> Self {
        let share = |i| (i as f64 + 0.5) / count as f64;
        Self {
            shares: (0..count).map(share).collect(),
            kind: Kind::Words,
        }
    }

    /// Logarithmic where the steps have one ratio, to a twentieth, and not one difference.
    fn of_numbers(mut numbers: Vec<f64>) -> Self {
        let mut sorted = numbers.clone();
        sorted.sort_by(f64::total_cmp);
        let steps = |of: fn(f64, f64) -> f64| -> Vec<f64> {
            sorted.windows(2).map(|w| of(w[0], w[1])).collect()
        };
        let even = |steps: &[f64]| steps.iter().all(|s| (s / steps[0] - 1.0).abs() < 0.05);
        let (mut low, mut high) = (sorted[0], sorted[sorted.len() - 1]);
        let is_log = low > 0.0
            && numbers.len() > 2
            && !even(&steps(|a, b| b - a))
            && even(&steps(|a, b| libm::log(b / a)));
        if is_log {
            let logs = numbers.iter_mut().chain([&mut low, &mut high]);
            logs.for_each(|x| *x = libm::log(*x));
        }
        Self {
            shares: numbers.iter().map(|x| (x - low) / (high - low)).collect(),
            kind: if is_log { Kind::Log } else { Kind::Linear },
        }
    }

    /// The values from left to right: people need not list them so.
    fn left_to_right(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.shares.len()).collect();
        order.sort_by(|&a, &b| self.shares[a].total_cmp(&self.shares[b]));
        order
    }
}

/// The range of numbers on the upright axis.
struct Range {
    low: f64,
    high: f64,
    step: f64,
}

impl Range {
    /// Round numbers about everything that is drawn.
    fn about(summaries: &[Summary]) -> Option<Self> {
        let ends = summaries
            .iter()
            .filter(|s| s.runs > 0)
            .flat_map(|s| [s.mean - s.deviation, s.mean + s.deviation]);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        ends.for_each(|x| (low, high) = (low.min(x), high.max(x)));
        if !(low <= high && (high - low).is_finite()) {
            return None;
        }
        if high - low < 1e-9 * high.abs().max(low.abs()) || high == low {
            let pad = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
            (low, high) = (low - pad, high + pad);
        }
        let step = round_below((high - low) / 2.5);
        Some(Self {
            low: (low / step).floor() * step,
            high: (high / step).ceil() * step,
            step,
        })
    }

    fn y(&self, value: f64) -> f64 {
        let share = (value - self.low) / (self.high - self.low);
        HEIGHT - SPACE[3] - share * (HEIGHT - SPACE[1] - SPACE[3])
    }

    fn ticks(&self) -> impl Iterator<Item = f64> + '_ {
        let count = ((self.high - self.low) / self.step).round() as usize;
        (0..=count).map(|k| self.low + k as f64 * self.step)
    }
}

/// The hue of the k-th of n lines, degrees: from blue by green to orange.
pub(super) fn hue(k: usize, n: usize) -> f64 {
    let share = match n {
        0 | 1 => 0.0,
        _ => k as f64 / (n - 1) as f64,
    };
    (215.0 - 190.0 * share).round()
}

/// The chart of a measure on a page of the grid; none where no run has a number.
pub(super) fn chart(results: &Results, measure: usize, page: usize) -> Option<String> {
    let layout = results.grid.layout();
    let first = page * layout.columns * layout.rows;
    let cells = first..first + layout.columns * layout.rows;
    let summaries: Vec<Summary> = cells.map(|c| results.summary(c, measure)).collect();
    let range = Range::about(&summaries)?;
    let across = results.grid.axes.first();
    let scale = Scale::of(across);
    let inner = WIDTH - SPACE[0] - SPACE[2];
    // Away from the frame, so that no point lies on it.
    let x = |i: usize| SPACE[0] + inner * (0.06 + 0.88 * scale.shares[i]);
    let mut svg = format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\">");
    draw_frame(&mut svg, &range);
    for i in 0..layout.columns {
        let label = across.map_or("", |a| a.values()[i].label());
        draw_label(&mut svg, x(i), label);
    }
    if let Some(axis) = across {
        let middle = SPACE[0] + 0.5 * inner;
        let name = super::page::escaped(axis.symbol());
        let y = HEIGHT - 6.0;
        let _ = write!(
            svg,
            "<text class=\"name\" x=\"{middle}\" y=\"{y}\">{name}</text>"
        );
    }
    let order = scale.left_to_right();
    for (row, summaries) in summaries.chunks(layout.columns).enumerate() {
        let row = Row {
            points: order.iter().map(|&i| (x(i), summaries[i])).collect(),
            seeds: results.grid.seeds as usize,
            hue: hue(row, layout.rows),
            is_line: scale.kind != Kind::Words,
            name: match results.grid.axes.get(1) {
                Some(axis) => axis.title(row),
                None => String::new(),
            },
        };
        row.draw(&mut svg, &range);
    }
    svg.push_str("</svg>");
    Some(svg)
}

fn draw_frame(svg: &mut String, range: &Range) {
    let (left, right) = (SPACE[0], WIDTH - SPACE[2]);
    for tick in range.ticks() {
        let y = range.y(tick);
        let label = number(tick, range.step);
        let (x, base) = (left - 6.0, y + 3.5);
        let _ = write!(
            svg,
            "<line class=\"rule\" x1=\"{left}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
             <text class=\"tick\" x=\"{x}\" y=\"{base:.1}\">{label}</text>"
        );
    }
}

fn draw_label(svg: &mut String, x: f64, label: &str) {
    let y = HEIGHT - SPACE[3] + 15.0;
    let label = super::page::escaped(label);
    let _ = write!(
        svg,
        "<text class=\"value\" x=\"{x:.1}\" y=\"{y}\">{label}</text>"
    );
}

/// The values of a measure along the first axis.
struct Row {
    /// Where each lies across, from left to right, and what it is.
    points: Vec<(f64, Summary)>,
    seeds: usize,
    hue: f64,
    is_line: bool,
    name: String,
}

impl Row {
    fn draw(&self, svg: &mut String, range: &Range) {
        let shown = || self.points.iter().filter(|(_, s)| s.runs > 0);
        let _ = write!(svg, "<g style=\"--h:{}\">", self.hue);
        if self.is_line {
            let points = shown().map(|(x, s)| format!("{x:.1},{:.1}", range.y(s.mean)));
            let points = points.collect::<Vec<_>>().join(" ");
            let _ = write!(svg, "<polyline points=\"{points}\"/>");
        }
        for (x, s) in shown() {
            self.draw_point(svg, *x, s, range);
        }
        svg.push_str("</g>");
    }

    fn draw_point(&self, svg: &mut String, x: f64, s: &Summary, range: &Range) {
        let y = range.y(s.mean);
        let [top, foot] = [s.mean + s.deviation, s.mean - s.deviation].map(|v| range.y(v));
        if s.deviation > 0.0 {
            let (a, b) = (x - 3.0, x + 3.0);
            let _ = write!(
                svg,
                "<path d=\"M{x:.1} {top:.1}V{foot:.1}M{a:.1} {top:.1}H{b:.1}M{a:.1} {foot:.1}H{b:.1}\"/>"
            );
        }
        let numbers = super::page::spread_of(s, self.seeds);
        let title = super::page::escaped(&self.name);
        let gap = if title.is_empty() { "" } else { ": " };
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\"><title>{title}{gap}{numbers}</title></circle>"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(name: &str, text: &str) -> Scale {
        Scale::of(Some(&Axis::parse(name, text).unwrap()))
    }

    #[test]
    fn scales_follow_the_values() {
        let cases = [
            ("L", "5r,10r,20r", Kind::Log, &[0.0, 0.5, 1.0] as &[f64]),
            ("L", "5r,10r,15r", Kind::Linear, &[0.0, 0.5, 1.0]),
            ("L", "5r,10r", Kind::Linear, &[0.0, 1.0]),
            ("B", "0.2,0.3,0.7", Kind::Linear, &[0.0, 0.2, 1.0]),
            ("preset", "dla,foliose", Kind::Words, &[0.25, 0.75]),
            // In any order.
            ("L", "20r,5r,10r", Kind::Log, &[1.0, 0.0, 0.5]),
            ("L", "15r,5r,10r", Kind::Linear, &[1.0, 0.0, 0.5]),
            // Of several units there is no common scale.
            ("L", "5r,5%", Kind::Words, &[0.25, 0.75]),
            ("L", "5r,0.2", Kind::Words, &[0.25, 0.75]),
            ("L", "0.5%,1%", Kind::Linear, &[0.0, 1.0]),
        ];
        for (name, text, kind, shares) in cases {
            let scale = scale(name, text);
            assert_eq!(scale.kind, kind, "{text}");
            assert_eq!(scale.shares.len(), shares.len(), "{text}");
            for (found, expected) in scale.shares.iter().zip(shares) {
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{text}: {:?}",
                    scale.shares
                );
            }
        }
        assert_eq!(scale("L", "20r,5r,10r").left_to_right(), [1, 2, 0]);
        assert_eq!(Scale::of(None).shares, [0.5]);
    }

    #[test]
    fn ranges_are_round_and_hold_everything() {
        let summary = |mean, deviation| Summary {
            mean,
            deviation,
            runs: 2,
        };
        for values in [
            [0.13, 0.87],
            [5.0, 5.0],
            [0.0, 0.0],
            [-3.0, 1e6],
            [1.0, 1.000_001],
        ] {
            let range = Range::about(&values.map(|v| summary(v, 0.01 * v.abs()))).unwrap();
            for v in values {
                assert!(range.low <= v && v <= range.high, "{values:?}");
            }
            let ticks = range.ticks().count();
            assert!((2..=8).contains(&ticks), "{values:?}: {ticks}");
        }
        assert!(Range::about(&[]).is_none());
    }

    #[test]
    fn hues_run_from_blue_to_orange() {
        assert_eq!([hue(0, 1), hue(0, 3), hue(2, 3)], [215.0, 215.0, 25.0]);
    }
}
