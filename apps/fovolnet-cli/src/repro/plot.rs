//! Plots: line charts and bar charts.

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Line through points.
pub struct Line {
    pub name: String,
    pub points: Vec<[f64; 2]>,
}

/// Labels of the axes.
#[derive(Clone, Copy)]
pub struct Axes<'a> {
    pub x: &'a str,
    pub y: &'a str,
}

/// Positions along x to mark by vertical lines.
pub type Marks<'a> = &'a [f64];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const SIZE: (u32, u32) = (1060, 420);
/// Width of the chart in pixels; the legend is right of it.
const CHART: u32 = 840;
/// Most points of a line whose points are drawn.
const MARKED: usize = 12;
/// Font size, in pixels.
const FONT: u32 = 14;
/// Colours that colour-blind people can distinguish (Okabe and Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
];

fn colour(number: usize) -> RGBColor {
    COLOURS[number % COLOURS.len()]
}

/// Draws `lines` as SVG. The y axis covers their values, and 0 if `from_zero`.
pub fn lines(axes: Axes<'_>, lines: &[Line], from_zero: bool, marks: Marks<'_>) -> Result<String> {
    let numbers =
        |of: usize| lines.iter().flat_map(move |line| line.points.iter().map(move |point| point[of]));
    let x = range(numbers(0), false);
    let y = range(numbers(1), from_zero);
    drawn(|svg| draw_lines(svg, axes, lines, (x, y), marks))
}

/// Range from the smallest to the largest of `numbers`, with some margin.
fn range(numbers: impl Iterator<Item = f64>, from_zero: bool) -> Range<f64> {
    let finite = numbers.filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let room = ((high - low) * 0.05).max(1e-9);
    if from_zero { 0.0..high + room } else { low - room..high + room }
}

fn drawn(draw: impl FnOnce(&mut String) -> Result<(), String>) -> Result<String> {
    let mut svg = String::new();
    draw(&mut svg).map_err(|e| anyhow!("the plot cannot be drawn: {e}"))?;
    Ok(svg)
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// White canvas with an area for the chart, and one beside it for the legend.
struct Sheet<'a> {
    whole: Area<'a>,
    area: Area<'a>,
    beside: Area<'a>,
}

fn sheet(svg: &mut String) -> Result<Sheet<'_>, String> {
    let whole = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    whole.fill(&WHITE).map_err(text)?;
    let (area, beside) = whole.split_horizontally(CHART);
    Ok(Sheet { whole, area, beside })
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn chart<'a, 'b>(area: &'a Area<'b>, x: Range<f64>, y: Range<f64>) -> Result<Chart<'a, 'b>, String> {
    let mut builder = ChartBuilder::on(area);
    builder.margin(16).x_label_area_size(44).y_label_area_size(64);
    builder.build_cartesian_2d(x, y).map_err(text)
}

fn draw_lines(
    svg: &mut String,
    axes: Axes<'_>,
    lines: &[Line],
    (x, y): (Range<f64>, Range<f64>),
    marks: Marks<'_>,
) -> Result<(), String> {
    let sheet = sheet(svg)?;
    let mut chart = chart(&sheet.area, x, y.clone())?;
    chart
        .configure_mesh()
        .x_desc(axes.x)
        .y_desc(axes.y)
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .label_style(("sans-serif", FONT))
        .light_line_style(WHITE)
        .draw()
        .map_err(text)?;
    let cut = RED.mix(0.6).stroke_width(1);
    let vertical = marks.iter().map(|&at| PathElement::new([(at, y.start), (at, y.end)], cut));
    chart.draw_series(vertical).map_err(text)?;
    for (number, line) in lines.iter().enumerate() {
        let style = colour(number).stroke_width(2);
        let points = line.points.iter().filter(|point| point[1].is_finite()).map(|&[x, y]| (x, y));
        chart.draw_series(LineSeries::new(points, style)).map_err(text)?;
        if line.points.len() <= MARKED {
            let dots = line.points.iter().map(|&[x, y]| Circle::new((x, y), 4, colour(number).filled()));
            chart.draw_series(dots).map_err(text)?;
        }
    }
    legend(&sheet.beside, &lines.iter().map(|line| line.name.as_str()).collect::<Vec<_>>())?;
    sheet.whole.present().map_err(text)
}

/// Draws the legend beside a chart.
fn legend(area: &Area<'_>, names: &[&str]) -> Result<(), String> {
    for (number, name) in names.iter().enumerate() {
        let y = 28 + 22 * number as i32;
        area.draw(&Rectangle::new([(4, y - 5), (18, y + 5)], colour(number).filled())).map_err(text)?;
        let font = ("sans-serif", FONT).into_font().color(&BLACK);
        let place = font.pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new((*name).to_owned(), (24, y), place)).map_err(text)?;
    }
    Ok(())
}

/// Label of an axis, without trailing zeros.
fn label(number: &f64) -> String {
    let rounded = format!("{number:.3}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".into() } else { short.into() }
}

/// Bars of one series, one for each group: its height, and the height of its dark part.
pub struct Bars {
    pub name: String,
    pub heights: Vec<[f64; 2]>,
}

/// Draws a bar chart from 0 upwards as SVG: for each of `groups` one bar of each of `series`.
pub fn bars(unit: &str, groups: &[String], series: &[Bars]) -> Result<String> {
    let high = series.iter().flat_map(|bars| bars.heights.iter().map(|h| h[0])).fold(0.0, f64::max);
    drawn(|svg| draw_bars(svg, unit, groups, series, high * 1.05))
}

fn draw_bars(
    svg: &mut String,
    unit: &str,
    groups: &[String],
    series: &[Bars],
    high: f64,
) -> Result<(), String> {
    let sheet = sheet(svg)?;
    let mut chart = chart(&sheet.area, 0.0..groups.len() as f64, 0.0..high.max(1e-9))?;
    let name = |at: &f64| {
        let middle = (at - at.floor() - 0.5).abs() < 1e-6;
        groups.get(*at as usize).filter(|_| middle).cloned().unwrap_or_default()
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(WHITE)
        .y_desc(unit)
        .x_labels(2 * groups.len() + 1)
        .x_label_formatter(&name)
        .y_label_formatter(&label)
        .label_style(("sans-serif", FONT))
        .draw()
        .map_err(text)?;
    let wide = 0.8 / series.len() as f64;
    for (number, bars) in series.iter().enumerate() {
        let shade = colour(number);
        let left = |group: usize| group as f64 + 0.1 + wide * number as f64;
        let bar = |group: usize, from: f64, to: f64, strength: f64| {
            Rectangle::new(
                [(left(group), from), (left(group) + wide * 0.92, to)],
                shade.mix(strength).filled(),
            )
        };
        let each = bars.heights.iter().enumerate();
        let parts = each
            .flat_map(|(group, &[whole, dark])| [bar(group, 0.0, dark, 1.0), bar(group, dark, whole, 0.5)]);
        chart.draw_series(parts).map_err(text)?;
    }
    legend(&sheet.beside, &series.iter().map(|bars| bars.name.as_str()).collect::<Vec<_>>())?;
    sheet.whole.present().map_err(text)
}
