//! Curves with linear or logarithmic axes, as SVG.
//!
//! Colours are told apart by the colour-blind, and each curve carries its name where it ends. The page's style sheet
//! knows the colours by their numbers and gives them others in the dark.

use super::ReportError;
use super::numbers::power_of_ten;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Size in units of its own; a page shows it at half of that or so.
const SIZE: (u32, u32) = (1440, HEIGHT as u32);
const HEIGHT: i32 = 880;
/// Height of letters.
const LETTERS: i32 = 25;
/// Room below the curves for numbers.
const LABELS: i32 = 84;
/// Room to the right of the curves for their names.
const NAMES: u32 = 270;

const INK: RGBColor = RGBColor(0x1a, 0x1a, 0x1a);
const SOFT: RGBColor = RGBColor(0x5a, 0x5a, 0x5a);
const LINE: RGBColor = RGBColor(0xe4, 0xe4, 0xe1);
const FONT: &str = "system-ui, Segoe UI, Helvetica, Arial, sans-serif";

/// A colour of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// For the main thing.
    Blue,
    /// For what competes with it.
    Vermillion,
    /// Another.
    Green,
    /// Another.
    Purple,
    /// Another.
    Sky,
    /// Another.
    Amber,
    /// For references.
    Grey,
    /// For marks.
    Black,
}

impl Ink {
    /// Those that curves take in turn.
    pub const ALL: [Self; 6] =
        [Self::Blue, Self::Vermillion, Self::Green, Self::Purple, Self::Amber, Self::Sky];

    const fn color(self) -> RGBColor {
        match self {
            Self::Blue => RGBColor(0x00, 0x72, 0xb2),
            Self::Vermillion => RGBColor(0xc0, 0x4e, 0x00),
            Self::Green => RGBColor(0x00, 0x7a, 0x5a),
            Self::Purple => RGBColor(0xa8, 0x48, 0x7f),
            Self::Sky => RGBColor(0x2a, 0x86, 0xb8),
            Self::Amber => RGBColor(0x94, 0x62, 0x00),
            Self::Grey => SOFT,
            Self::Black => INK,
        }
    }
}

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten.
    Log,
}

/// An axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Written where it ends.
    pub name: String,
    /// Its colour.
    pub ink: Ink,
    /// In the order of drawing. What is not finite, and on a logarithmic axis what is not positive, is left out.
    pub points: Vec<[f64; 2]>,
    /// Whether each point has a dot.
    pub dots: bool,
    /// Whether it is broken into dashes.
    pub dashed: bool,
}

/// A ring around a point, with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where.
    pub at: [f64; 2],
    /// What it is.
    pub name: String,
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// For those who cannot see it.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// Curves, drawn in this order.
    pub curves: Vec<Curve>,
    /// Marks, on top.
    pub marks: Vec<Mark>,
}

impl Axis {
    /// Divided by powers of ten.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log }
    }

    /// Divided evenly.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    fn has(&self, x: f64) -> bool {
        x.is_finite() && (self.scale == Scale::Linear || x > 0.0)
    }

    /// From where to where it goes so that all is on it: whole powers of ten, or a little more than needed.
    fn range(&self, numbers: impl Iterator<Item = f64>) -> Range<f64> {
        let numbers = numbers.filter(|&x| self.has(x));
        let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        match self.scale {
            _ if low > high => 1.0..10.0,
            Scale::Log => low_mark(low * 0.9)..high_mark(high * 1.1),
            Scale::Linear => {
                let room = if high > low { 0.04 * (high - low) } else { 0.5 * low.abs().max(1.0) };
                (if low >= 0.0 && low < 0.3 * high { 0.0 } else { low - room })..high + room
            }
        }
    }

    fn tick(&self, x: f64) -> String {
        match self.scale {
            Scale::Log => power_of_ten(x.log10().round() as i32),
            Scale::Linear => format!("{}", (x * 1e9).round() / 1e9),
        }
    }
}

impl Plot {
    /// Draws it.
    pub fn svg(&self) -> Result<String, ReportError> {
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            let failed = |e: &dyn std::fmt::Display| ReportError::Plot(format!("{}: {e}", self.title));
            let numbers = |i: usize| {
                let points = self.curves.iter().flat_map(|curve| &curve.points);
                points.chain(self.marks.iter().map(|mark| &mark.at)).map(move |point| point[i])
            };
            let (x, y) = (self.x.range(numbers(0)), self.y.range(numbers(1)));
            let drawn = match (self.x.scale, self.y.scale) {
                (Scale::Log, Scale::Log) => self.draw(&root, x.log_scale(), y.log_scale()),
                (Scale::Log, Scale::Linear) => self.draw(&root, x.log_scale(), y),
                (Scale::Linear, Scale::Log) => self.draw(&root, x, y.log_scale()),
                (Scale::Linear, Scale::Linear) => self.draw(&root, x, y),
            };
            drawn.map_err(|e| failed(&e))?;
            root.present().map_err(|e| failed(&e))?;
        }
        // One picture of several in a page: a name instead of a size, so that it takes the room it is given.
        let svg = svg.trim();
        let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
        let title = maud::html! { (self.title) }.into_string();
        let svg = svg.replacen(&size, &format!("role=\"img\" aria-label=\"{title}\" "), 1);
        // Read alone, as a file, it has no page behind it.
        Ok(svg.replacen(">\n", ">\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n", 1))
    }

    fn draw<X, Y>(
        &self,
        root: &DrawingArea<SVGBackend<'_>, Shift>,
        x: X,
        y: Y,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(root)
            .margin_top(24)
            .margin_right(NAMES)
            .x_label_area_size(LABELS)
            .y_label_area_size(118)
            .build_cartesian_2d(x, y)?;
        let letters = (FONT, LETTERS).into_font();
        chart
            .configure_mesh()
            .bold_line_style(LINE.stroke_width(2))
            .light_line_style(TRANSPARENT)
            .axis_style(SOFT.stroke_width(2))
            .label_style(letters.clone().color(&SOFT))
            .axis_desc_style(letters.clone().color(&INK))
            .x_label_formatter(&|x| self.x.tick(*x))
            .y_label_formatter(&|y| self.y.tick(*y))
            .x_labels(8)
            .y_labels(9)
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .draw()?;
        let mut ends = Vec::new();
        for curve in &self.curves {
            let color = curve.ink.color();
            let here = |point: &&[f64; 2]| self.x.has(point[0]) && self.y.has(point[1]);
            let points: Vec<(f64, f64)> = curve.points.iter().filter(here).map(|&[x, y]| (x, y)).collect();
            let Some(&end) = points.last() else { continue };
            if curve.dashed {
                chart.draw_series(DashedLineSeries::new(points.clone(), 9, 9, color.stroke_width(3)))?;
            } else {
                chart.draw_series(LineSeries::new(points.clone(), color.stroke_width(4)))?;
            }
            if curve.dots {
                chart.draw_series(points.iter().map(|&point| Circle::new(point, 6, color.filled())))?;
            }
            ends.push((chart.backend_coord(&end), curve));
        }
        let on_it = |mark: &&Mark| self.x.has(mark.at[0]) && self.y.has(mark.at[1]);
        let marks = self.marks.iter().filter(on_it);
        let marks = marks.map(|mark| (chart.backend_coord(&(mark.at[0], mark.at[1])), mark)).collect();
        write_names(root, marks, ends)
    }
}

/// Rings with their names to the lower left, and the names of curves where they end.
fn write_names(
    root: &DrawingArea<SVGBackend<'_>, Shift>,
    marks: Vec<((i32, i32), &Mark)>,
    mut ends: Vec<((i32, i32), &Curve)>,
) -> Result<(), Box<dyn std::error::Error>> {
    let letters = (FONT, LETTERS).into_font();
    for ((x, y), mark) in marks {
        root.draw(&Circle::new((x, y), 15, INK.stroke_width(3)))?;
        let style = letters.clone().color(&INK).pos(Pos::new(HPos::Right, VPos::Top));
        root.draw(&Text::new(mark.name.clone(), (x - 16, y + 6), style))?;
    }
    spread(&mut ends);
    for ((x, y), curve) in ends {
        let style = letters.clone().color(&curve.ink.color()).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(curve.name.clone(), (x + 16, y), style))?;
    }
    Ok(())
}

/// The largest of 1, 2, 5 times a power of ten that is not above `x`.
fn low_mark(x: f64) -> f64 {
    let decade = 10_f64.powf(x.log10().floor());
    let marks = [5.0, 2.0, 1.0].map(|mark| mark * decade);
    marks.into_iter().find(|&mark| mark <= x).unwrap_or(decade)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `x`.
fn high_mark(x: f64) -> f64 {
    1.0 / low_mark(1.0 / x)
}

/// Moves names that would stand on one another: down, and at the bottom up again.
fn spread(names: &mut [((i32, i32), &Curve)]) {
    // Letters are a little more than half as wide as high.
    let width = |curve: &Curve| curve.name.chars().map(|_| LETTERS * 11 / 20).sum::<i32>();
    names.sort_by_key(|((_, y), _)| *y);
    let meets = |a: &((i32, i32), &Curve), b: &((i32, i32), &Curve)| {
        let ((ax, ay), (bx, by)) = (a.0, b.0);
        ax < bx + width(b.1) && bx < ax + width(a.1) && (ay - by).abs() < LETTERS + 4
    };
    for i in 1..names.len() {
        for j in 0..i {
            if meets(&names[i], &names[j]) {
                names[i].0.1 = names[j].0.1 + LETTERS + 4;
            }
        }
    }
    let bottom = HEIGHT - LABELS - LETTERS / 2;
    for i in (0..names.len()).rev() {
        names[i].0.1 = names[i].0.1.min(bottom);
        for j in (i + 1..names.len()).rev() {
            if meets(&names[i], &names[j]) {
                names[i].0.1 = names[j].0.1 - LETTERS - 4;
            }
        }
    }
}
