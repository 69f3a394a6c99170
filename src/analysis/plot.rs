//! Plots of an analysis, as SVG and PNG.

use std::error::Error;
use std::ops::{Range, RangeInclusive};

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::dimension::{Dimension, Method, Through};
use super::{Analysis, Scaling};
use crate::picture::Image;

/// A plot that could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("the plot '{name}' could not be drawn: {reason}")]
pub struct PlotError {
    /// Its name.
    pub name: &'static str,
    /// What went wrong.
    pub reason: String,
}

/// Pixels of a dashed line.
const DASH: i32 = 6;
const GAP: i32 = 4;

type Area<B> = DrawingArea<B, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// What can be drawn.
#[derive(Clone, Copy)]
enum Plot {
    Dimensions,
    LocalSlopes,
    BranchWidths,
    Growth,
}

const PLOTS: [Plot; 4] = [
    Plot::Dimensions,
    Plot::LocalSlopes,
    Plot::BranchWidths,
    Plot::Growth,
];

/// Names of the files of [`plots`].
pub fn plot_names() -> impl Iterator<Item = &'static str> {
    PLOTS.iter().flat_map(|plot| plot.names())
}

/// The plots by the names of their files, each as SVG and as PNG: the curves that dimensions were
/// fitted to, their local slopes, the widths of the branches, and growth with the density profile.
///
/// # Errors
/// When the plotting library cannot draw one; when numbers are beyond 1e-150 to 1e150, which no axis shows.
pub fn plots(analysis: &Analysis) -> Result<Vec<(&'static str, Vec<u8>)>, PlotError> {
    let mut files = Vec::new();
    for plot in PLOTS {
        let [svg, png] = plot.names();
        let failed = |name: &'static str| {
            move |e: Box<dyn Error>| PlotError {
                name,
                reason: e.to_string(),
            }
        };
        files.push((svg, plot.svg(analysis).map_err(failed(svg))?));
        files.push((png, plot.png(analysis).map_err(failed(png))?));
    }
    Ok(files)
}

impl Plot {
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Dimensions => ["dimensions.svg", "dimensions.png"],
            Self::LocalSlopes => ["local-slopes.svg", "local-slopes.png"],
            Self::BranchWidths => ["branch-widths.svg", "branch-widths.png"],
            Self::Growth => ["growth.svg", "growth.png"],
        }
    }

    /// Width and height; a PNG has twice as many pixels each way.
    fn size(self) -> [u32; 2] {
        match self {
            Self::Dimensions => [1200, 900],
            Self::LocalSlopes | Self::Growth => [1200, 520],
            Self::BranchWidths => [800, 520],
        }
    }

    fn svg(self, analysis: &Analysis) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut svg = String::new();
        let backend = SVGBackend::with_string(&mut svg, self.size().into());
        self.draw(backend, analysis)?;
        Ok(svg.into_bytes())
    }

    fn png(self, analysis: &Analysis) -> Result<Vec<u8>, Box<dyn Error>> {
        let image = Image::drawn(self.size(), |drawing| self.draw(drawing, analysis))?;
        Ok(image.to_png())
    }

    fn draw<B: DrawingBackend>(self, backend: B, analysis: &Analysis) -> Drawn
    where
        B::ErrorType: 'static,
    {
        let area = backend.into_drawing_area();
        area.fill(&WHITE)?;
        match self {
            Self::Dimensions => fits(&area, analysis)?,
            Self::LocalSlopes => slopes(&area, analysis)?,
            Self::BranchWidths => widths(&area, analysis)?,
            Self::Growth => growth(&area, analysis)?,
        }
        area.present()?;
        Ok(())
    }
}

type Points = Vec<(f64, f64)>;

/// Something to draw in a panel.
struct Curve {
    label: String,
    color: RGBColor,
    dashed: bool,
    /// Lines.
    points: Vec<Points>,
    /// Drawn thick on top.
    fit: Vec<Points>,
}

/// The parts of a curve where y is between these, for a panel that is logarithmic in x: plotters would draw what is
/// beyond along the border.
fn clipped(points: &[(f64, f64)], between: [f64; 2]) -> Vec<Points> {
    let mut parts: Vec<Points> = Vec::new();
    let shown = |ends: &[(f64, f64)]| clip([ends[0], ends[1]], between);
    for [from, to] in points.windows(2).filter_map(shown) {
        match parts.last_mut().filter(|part| part.last() == Some(&from)) {
            Some(part) => part.push(to),
            None => parts.push(vec![from, to]),
        }
    }
    parts
}

fn clip([from, to]: [(f64, f64); 2], [low, high]: [f64; 2]) -> Option<[(f64, f64); 2]> {
    let is_seen = from.1.max(to.1) >= low && from.1.min(to.1) <= high;
    let at = |end: (f64, f64)| {
        let y = end.1.clamp(low, high);
        let share = (y - from.1) / (to.1 - from.1);
        match y == end.1 {
            true => end,
            false => (from.0 * libm::pow(to.0 / from.0, share), y),
        }
    };
    is_seen.then(|| [at(from), at(to)])
}

/// What a panel says at its edges.
struct Panel<'a> {
    title: &'a str,
    x: &'a str,
    y: &'a str,
    key: SeriesLabelPosition,
}

/// Of M. Okabe and K. Ito (2008), told apart by the colour-blind too.
fn color(method: Method) -> RGBColor {
    match method {
        Method::MassRadius => RGBColor(0x00, 0x72, 0xb2),
        Method::Gyration => RGBColor(0xe6, 0x9f, 0x00),
        Method::Sandbox => RGBColor(0xd5, 0x5e, 0x00),
        Method::Correlation => RGBColor(0x00, 0x9e, 0x73),
        Method::Boxes => RGBColor(0xcc, 0x79, 0xa7),
        Method::Outline => RGBColor(0x56, 0xb4, 0xe9),
    }
}

const PLAIN: RGBColor = RGBColor(0x00, 0x72, 0xb2);

fn label(dimension: &Dimension) -> String {
    let way = match dimension.through {
        Through::Space => "space",
        Through::Surface => "surface",
    };
    let name = dimension.method.name();
    match (dimension.dimension, dimension.error) {
        (Some(d), Some(error)) => format!("{name}, {way}: {d:.2} ± {error:.2}"),
        _ => format!("{name}, {way}"),
    }
}

fn pairs(points: &[[f64; 2]]) -> Vec<(f64, f64)> {
    points.iter().map(|&[x, y]| (x, y)).collect()
}

/// The two ends of the fitted law.
fn line(scaling: &Scaling) -> Vec<(f64, f64)> {
    let ends = scaling.fit.zip(scaling.range).into_iter();
    ends.flat_map(|(fit, range)| range.map(|x| (x, fit.at(x))))
        .collect()
}

/// The curves that dimensions are read from, one panel for each kind.
fn fits<B: DrawingBackend>(area: &Area<B>, analysis: &Analysis) -> Drawn
where
    B::ErrorType: 'static,
{
    use Method::{Boxes, Correlation, Gyration, MassRadius, Outline, Sandbox};
    const LENGTH: &str = "distance, mesh units";
    let panels: [(&[Method], Panel<'_>); 4] = [
        (
            &[MassRadius, Sandbox],
            rising("Mass", LENGTH, "elements within"),
        ),
        (
            &[Correlation],
            falling("Density-density correlation", LENGTH, "elements per area"),
        ),
        (
            &[Boxes, Outline],
            falling("Box counting", "edge of a box, mesh units", "boxes"),
        ),
        (
            &[Gyration],
            rising("Radius of gyration", "elements", "radius, mesh units"),
        ),
    ];
    for (area, (methods, panel)) in area.split_evenly((2, 2)).iter().zip(&panels) {
        let of_panel = |d: &&Dimension| methods.contains(&d.method);
        let curve = |d: &Dimension| Curve {
            label: label(d),
            color: color(d.method),
            dashed: d.through == Through::Surface,
            points: vec![pairs(&d.scaling.points)],
            fit: d.fit().map(|_| line(&d.scaling)).into_iter().collect(),
        };
        let curves: Vec<_> = analysis
            .dimensions
            .iter()
            .filter(of_panel)
            .map(curve)
            .collect();
        log_log(area, panel, &curves)?;
    }
    Ok(())
}

/// Dimensions by local slope, which are level where there is scaling; the range of the fit thick.
fn slopes<B: DrawingBackend>(area: &Area<B>, analysis: &Analysis) -> Drawn
where
    B::ErrorType: 'static,
{
    /// Dimensions that are shown.
    const SLOPES: [f64; 2] = [0.0, 2.5];
    let is_growth = |d: &&Dimension| d.method == Method::Gyration;
    let curve = |d: &Dimension| {
        let is_there = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let points: Vec<_> = d.local().map(|[x, y]| (x, y)).filter(is_there).collect();
        let range = d.fit().and(d.scaling.range);
        let fitted = |p: &&(f64, f64)| range.is_some_and(|[from, to]| p.0 >= from && p.0 <= to);
        Curve {
            label: label(d),
            color: color(d.method),
            dashed: d.through == Through::Surface,
            fit: clipped(
                &points.iter().filter(fitted).copied().collect::<Vec<_>>(),
                SLOPES,
            ),
            points: clipped(&points, SLOPES),
        }
    };
    let areas = area.split_evenly((1, 2));
    let (growth, length): (Vec<&Dimension>, Vec<_>) =
        analysis.dimensions.iter().partition(is_growth);
    for (area, dimensions, x) in [
        (&areas[0], length, "distance, mesh units"),
        (&areas[1], growth, "elements"),
    ] {
        let curves: Vec<_> = dimensions.into_iter().map(curve).collect();
        let panel = rising("Dimension by local slope", x, "dimension");
        if is_empty(&curves) {
            say_empty(area, &panel)?;
            continue;
        }
        let x = positive_range(all_points(&curves).map(|p| p.0))?.log_scale();
        draw(area, &panel, x, SLOPES[0]..SLOPES[1], &curves)?;
    }
    Ok(())
}

/// Share of the elements by the width of their branch.
fn widths<B: DrawingBackend>(area: &Area<B>, analysis: &Analysis) -> Drawn
where
    B::ErrorType: 'static,
{
    let histogram = &analysis.branch_widths;
    let all = histogram.counts.iter().sum::<u64>().max(1) as f64;
    let bar = |(k, &n): (usize, &u64)| {
        let [from, to] = [k, k + 1].map(|k| k as f64 * histogram.bin);
        ([from, to], n as f64 / all)
    };
    let bars: Vec<_> = histogram.counts.iter().enumerate().map(bar).collect();
    let widest = bars.last().map_or(histogram.bin, |(bar, _)| bar[1]);
    let highest = bars.iter().map(|(_, share)| *share).fold(0.01, f64::max);
    let panel = falling(
        "Width of the branches",
        "width, mesh units",
        "share of the elements",
    );
    let mut chart = ChartBuilder::on(area);
    let mut chart = chart
        .caption(panel.title, ("sans-serif", 20))
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(70)
        .build_cartesian_2d(range_to(1.05 * widest)?, range_to(1.1 * highest)?)?;
    mesh(&mut chart, &panel)?;
    let bar = |([from, to], share): ([f64; 2], f64)| {
        Rectangle::new([(from, 0.0), (to, share)], PLAIN.mix(0.75).filled())
    };
    chart.draw_series(bars.into_iter().map(bar))?;
    Ok(())
}

/// R_e against births, and the density profile.
fn growth<B: DrawingBackend>(area: &Area<B>, analysis: &Analysis) -> Drawn
where
    B::ErrorType: 'static,
{
    let areas = area.split_evenly((1, 2));
    let growth = &analysis.front.growth;
    let exponent = growth.fit.map_or(String::new(), |f| {
        format!(": births^{:.3} ± {:.3}", f.slope, f.error)
    });
    let curve = Curve {
        label: format!("effective radius{exponent}"),
        color: PLAIN,
        dashed: false,
        points: vec![pairs(&growth.points)],
        fit: vec![line(growth)],
    };
    let of_growth = rising("Growth", "births", "effective radius, mesh units");
    log_log(&areas[0], &of_growth, &[curve])?;
    let points = pairs(&analysis.front.profile);
    let [far, high] = points
        .iter()
        .fold([analysis.radius, 0.1], |[x, y], p| [p.0.max(x), p.1.max(y)]);
    let title = match points.is_empty() {
        true => "Density profile: not measured",
        false => "Density profile",
    };
    let profile = Curve {
        label: "covered share".to_owned(),
        color: PLAIN,
        dashed: true,
        points: vec![points],
        fit: Vec::new(),
    };
    let of_profile = falling(
        title,
        "distance from the seed along the surface, mesh units",
        "share covered",
    );
    draw(
        &areas[1],
        &of_profile,
        range_to(1.05 * far)?,
        range_to(1.1 * high)?,
        &[profile],
    )
}

/// With the key below curves that rise.
fn rising<'a>(title: &'a str, x: &'a str, y: &'a str) -> Panel<'a> {
    let key = SeriesLabelPosition::LowerRight;
    Panel { title, x, y, key }
}

/// With the key above curves that fall.
fn falling<'a>(title: &'a str, x: &'a str, y: &'a str) -> Panel<'a> {
    let key = SeriesLabelPosition::UpperRight;
    Panel { title, x, y, key }
}

/// Ends of axes: beyond, their marks are never all found.
const AXIS: RangeInclusive<f64> = 1e-150..=1e150;

fn checked(range: Range<f64>) -> Result<Range<f64>, Box<dyn Error>> {
    let Range { start, end } = range;
    let is_sound = (start == 0.0 || AXIS.contains(&start)) && AXIS.contains(&end);
    match is_sound {
        true => Ok(range),
        false => Err(format!("no axis goes from {start:e} to {end:e}").into()),
    }
}

/// From zero.
fn range_to(end: f64) -> Result<Range<f64>, Box<dyn Error>> {
    checked(0.0..end)
}

/// From the least to the greatest of positive values, with some room: to whole decades where there
/// would be few of them.
fn positive_range(values: impl Iterator<Item = f64>) -> Result<Range<f64>, Box<dyn Error>> {
    const FEW: f64 = 100.0;
    let decade = |value: f64, whole: fn(f64) -> f64| libm::exp10(whole(libm::log10(value)));
    let positive = values.filter(|&value| value > 0.0);
    let (least, greatest) = positive.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), v| {
        (a.min(v), b.max(v))
    });
    checked(match () {
        () if least > greatest => 0.5..2.0,
        () if least == greatest => 0.5 * least..2.0 * least,
        () if greatest < FEW * least => decade(least, libm::floor)..decade(greatest, libm::ceil),
        () => least / 1.2..greatest * 1.2,
    })
}

fn all_points(curves: &[Curve]) -> impl Iterator<Item = &(f64, f64)> {
    curves.iter().flat_map(|c| c.points.iter().flatten())
}

fn is_empty(curves: &[Curve]) -> bool {
    all_points(curves).next().is_none()
}

/// A panel without axes, where nothing could be measured.
fn say_empty<B: DrawingBackend>(area: &Area<B>, panel: &Panel<'_>) -> Drawn
where
    B::ErrorType: 'static,
{
    let title = format!("{}: not measured", panel.title);
    area.titled(&title, ("sans-serif", 20))?;
    Ok(())
}

fn log_log<B: DrawingBackend>(area: &Area<B>, panel: &Panel<'_>, curves: &[Curve]) -> Drawn
where
    B::ErrorType: 'static,
{
    if is_empty(curves) {
        return say_empty(area, panel);
    }
    let x = positive_range(all_points(curves).map(|p| p.0))?;
    let y = positive_range(all_points(curves).map(|p| p.1))?;
    draw(area, panel, x.log_scale(), y.log_scale(), curves)
}

fn draw<B, X, Y>(area: &Area<B>, panel: &Panel<'_>, x: X, y: Y, curves: &[Curve]) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area);
    let mut chart = chart
        .caption(panel.title, ("sans-serif", 20))
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(70)
        .build_cartesian_2d(x, y)?;
    mesh(&mut chart, panel)?;
    for curve in curves {
        add(&mut chart, curve)?;
    }
    chart
        .configure_series_labels()
        .position(panel.key.clone())
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(0xc8, 0xc8, 0xc8))
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

/// Draws a curve, with its line in the key as it is drawn.
fn add<'a, B, X, Y>(chart: &mut ChartContext<'a, B, Cartesian2d<X, Y>>, curve: &Curve) -> Drawn
where
    B: DrawingBackend + 'a,
    B::ErrorType: 'static,
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let Curve { color, dashed, .. } = *curve;
    let style = color.stroke_width(2);
    let key = move |(x, y)| {
        let ends = [(x, y), (x + 22, y)];
        match dashed {
            true => DashedPathElement::new(ends, DASH, GAP, style).into_dyn(),
            false => PathElement::new(ends, style).into_dyn(),
        }
    };
    for (k, line) in curve.points.iter().enumerate() {
        let line = line.iter().copied();
        let drawn = match dashed {
            true => chart.draw_series(DashedLineSeries::new(line, DASH, GAP, style))?,
            false => chart.draw_series(LineSeries::new(line, style))?,
        };
        if k == 0 {
            drawn.label(&curve.label).legend(key);
        }
    }
    for line in &curve.fit {
        let thick = color.mix(0.35).stroke_width(7);
        chart.draw_series(LineSeries::new(line.iter().copied(), thick))?;
    }
    Ok(())
}

fn mesh<B, X, Y>(chart: &mut ChartContext<'_, B, Cartesian2d<X, Y>>, panel: &Panel<'_>) -> Drawn
where
    B: DrawingBackend,
    B::ErrorType: 'static,
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .x_desc(panel.x)
        .y_desc(panel.y)
        .x_labels(8)
        .y_labels(8)
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .axis_desc_style(("sans-serif", 15))
        .label_style(("sans-serif", 13))
        .bold_line_style(RGBColor(0xe2, 0xe2, 0xe2))
        .light_line_style(RGBColor(0xf4, 0xf4, 0xf4))
        .draw()?;
    Ok(())
}

/// A number at an axis, without the zeros that say nothing.
fn tick(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_what_is_drawn_and_end() {
        let range = |values: &[f64]| positive_range(values.iter().copied()).ok();
        assert_eq!(range(&[]), Some(0.5..2.0));
        assert_eq!(range(&[5.0; 3]), Some(2.5..10.0));
        assert_eq!(range(&[3.0, 0.0, 50.0, f64::NAN]), Some(1.0..100.0));
        assert_eq!(range(&[1.2, 1200.0]), Some(1.0..1440.0));
        for odd in [1e-310, 1e160, f64::INFINITY] {
            assert_eq!(range(&[1.0, odd]), None, "{odd}");
            assert!(range_to(odd).is_err(), "{odd}");
        }
        assert!(range_to(f64::NAN).is_err() && range_to(0.0).is_err());
    }

    #[test]
    fn what_is_beyond_a_panel_is_cut_off_and_not_drawn_along_its_border() {
        let points = [(1.0, 1.0), (100.0, 3.0), (1e4, 1.0), (1e5, 9.0), (1e6, 8.0)];
        let [left, right] = &clipped(&points, [0.0, 2.0])[..] else {
            panic!("two parts");
        };
        let near = |part: &Points, expected: [(f64, f64); 2]| {
            let mut both = part.iter().zip(expected);
            part.len() == 2 && both.all(|(a, b)| (a.0 / b.0 - 1.0).abs() < 1e-12 && a.1 == b.1)
        };
        assert!(near(left, [(1.0, 1.0), (10.0, 2.0)]), "{left:?}");
        assert_eq!(right.len(), 3);
        assert_eq!(right[1], (1e4, 1.0));
        assert!((right[2].0 / libm::pow(10.0, 4.125) - 1.0).abs() < 1e-12);
        assert_eq!(clipped(&points, [0.0, 10.0]), [points.to_vec()]);
        assert!(clipped(&points, [10.0, 20.0]).is_empty());
    }

    /// As wide as axes are.
    #[test]
    fn the_widest_axes_are_drawn() {
        let ends = vec![(1e-149, 1e149), (1e149, 1e-149)];
        let curve = Curve {
            label: "ends".to_owned(),
            color: PLAIN,
            dashed: false,
            points: vec![ends.clone()],
            fit: vec![ends],
        };
        let drawn = Image::drawn([600, 400], |drawing| {
            log_log(
                &drawing.into_drawing_area(),
                &rising("a", "b", "c"),
                &[curve],
            )
        });
        assert!(drawn.is_ok());
    }
}
