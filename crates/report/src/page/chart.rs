//! One chart as SVG: axes by plotters, curves with dashes, which plotters does not know, put into the frame that it
//! drew.

use crate::page::axis::Axis;
use crate::page::thin::thin;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;
use std::fmt::Write;
use std::ops::Range;

/// Colours that the colour-blind can tell apart (M. Okabe, K. Ito, Color Universal Design, 2008), without yellow.
pub const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000"];

/// Dashes, in units of the page.
const DASHES: [&str; 3] = ["", "7 3", "7 3 2 3"];

/// How curves of one kind are drawn, and what they are called.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// For the legend.
    pub name: String,
    /// As SVG has it.
    pub colour: &'static str,
    /// As SVG has it; empty for a whole line.
    pub dash: &'static str,
    /// Width, in units of the page.
    pub width: f64,
}

impl Key {
    /// The n-th of several curves: another colour, and other dashes where neighbours lie close.
    pub fn nth(n: usize, name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            colour: COLOURS[n % COLOURS.len()],
            dash: DASHES[n % DASHES.len()],
            width: 1.7,
        }
    }

    /// A reference or a limit: thin, grey and dashed.
    pub fn reference(name: impl Into<String>) -> Self {
        Self { name: name.into(), colour: "#707070", dash: "3 2", width: 1.2 }
    }

    /// What others are laid upon: wide and pale.
    pub fn ground(name: impl Into<String>) -> Self {
        Self { name: name.into(), colour: "#BBBBBB", dash: "", width: 5.0 }
    }

    /// Its sample for a legend.
    pub fn sample(&self) -> String {
        format!(
            "<line x1=\"0\" y1=\"6\" x2=\"26\" y2=\"6\" stroke=\"{}\" stroke-width=\"{}\" stroke-dasharray=\"{}\"/>",
            self.colour,
            self.width,
            if self.dash.is_empty() { "none" } else { self.dash }
        )
    }
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Which of the figure's keys it has.
    pub key: usize,
    /// In the order in which they are joined.
    pub points: Vec<(f64, f64)>,
}

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What distinguishes it from its neighbours; may be empty.
    pub title: String,
    /// Horizontal.
    pub x: Axis,
    /// Vertical.
    pub y: Axis,
    /// Drawn in this order.
    pub curves: Vec<Curve>,
}

/// Width and height of a chart, in units of the page.
pub type Size = (u32, u32);
/// A chart among others in a page.
pub const SMALL: Size = (400, 250);
/// A chart as wide as a page.
pub const WIDE: Size = (900, 230);
/// plotters places things on whole units; a unit of the page is this many of its.
const FINE: u32 = 4;
/// Left, right, top and bottom of the frame, in units of the page.
const FRAME: [u32; 4] = [52, 16, 26, 40];
/// What a point may be off to be left out, as a part of the axis: a tenth of a unit of the page.
const INVISIBLE: f64 = 3e-4;
const X_TICKS: usize = 6;
const Y_TICKS: usize = 5;

/// An axis as plotters takes it: evenly spaced axis coordinates, with our ticks.
struct Ticks {
    range: (f64, f64),
    ticks: Vec<f64>,
}

impl Ranged for Ticks {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let part = (value - self.range.0) / (self.range.1 - self.range.0);
        from + (part * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.0..self.range.1
    }
}

type Context<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Ticks, Ticks>>;

impl Chart {
    /// A chart over time (s).
    pub fn over_time(title: impl Into<String>, label: impl Into<String>, curves: Vec<Curve>) -> Self {
        Self { title: title.into(), x: Axis::linear("time (s)"), y: Axis::linear(label), curves }
    }

    /// The contents of an `svg` element whose view box is [`Chart::view_box`] of the same size.
    ///
    /// # Errors
    /// The reason of plotters.
    pub fn svg(&self, keys: &[Key], size: Size) -> Result<String, String> {
        let placed: Vec<(&Key, Vec<(f64, f64)>)> = self
            .curves
            .iter()
            .filter_map(|curve| Some((keys.get(curve.key)?, self.placed(&curve.points))))
            .collect();
        let all = || placed.iter().flat_map(|(_, points)| points);
        let x = self.x.extent(all().map(|p| p.0), false);
        let y = self.y.extent(all().map(|p| p.1), true);
        let mut frame = String::new();
        self.paint(&mut frame, size, x, y).map_err(|reason| reason.to_string())?;
        let inner = frame.split_once('>').and_then(|(_, rest)| rest.rsplit_once("</svg>"));
        let (inner, _) = inner.ok_or("the frame of the chart is no SVG")?;
        Ok(format!("{}{}", inner.trim().replace(">\n", ">"), curves(&placed, size, x, y)))
    }

    /// The view box that [`Chart::svg`] draws in.
    pub fn view_box((width, height): Size) -> String {
        format!("0 0 {} {}", FINE * width, FINE * height)
    }

    fn placed(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        points.iter().filter_map(|(x, y)| Some((self.x.place(*x)?, self.y.place(*y)?))).collect()
    }

    fn paint(
        &self,
        svg: &mut String,
        (width, height): Size,
        x: (f64, f64),
        y: (f64, f64),
    ) -> Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(svg, (FINE * width, FINE * height)).into_drawing_area();
        let font = ("sans-serif", 15 * FINE);
        let heading = match self.title.as_str() {
            "" => self.y.label.clone(),
            title => format!("{title}: {}", self.y.label),
        };
        root.draw(&Text::new(heading, (4 * FINE as i32, 4 * FINE as i32), font.into_font()))?;
        let [left, right, top, bottom] = FRAME.map(|side| FINE * side);
        let mut chart: Context = ChartBuilder::on(&root)
            .margin_top(top)
            .margin_right(right)
            .x_label_area_size(bottom)
            .y_label_area_size(left)
            .build_cartesian_2d(
                Ticks { range: x, ticks: self.x.ticks(x, X_TICKS) },
                Ticks { range: y, ticks: self.y.ticks(y, Y_TICKS) },
            )?;
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT).bold_line_style(RGBColor(222, 222, 222).stroke_width(FINE));
        mesh.axis_style(RGBColor(120, 120, 120).stroke_width(FINE)).set_all_tick_mark_size(3 * FINE);
        mesh.x_labels(X_TICKS).y_labels(Y_TICKS).x_desc(self.x.label.as_str());
        mesh.label_style(("sans-serif", 14 * FINE)).axis_desc_style(font);
        let x_word = |v: &f64| self.x.word(*v, x, X_TICKS);
        let y_word = |v: &f64| self.y.word(*v, y, Y_TICKS);
        mesh.x_label_formatter(&x_word).y_label_formatter(&y_word).draw()?;
        root.present()?;
        Ok(())
    }
}

/// The curves, in a nested SVG that ends at the frame: what leaves the axes is cut off.
fn curves(placed: &[(&Key, Vec<(f64, f64)>)], size: Size, x: (f64, f64), y: (f64, f64)) -> String {
    let [left, right, top, bottom] = FRAME.map(|side| FINE * side);
    let (width, height) = (FINE * size.0 - left - right, FINE * size.1 - top - bottom);
    let mut out = format!("<svg x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\">");
    // Dashed ones upon whole ones, so that lines that lie on one another are all seen.
    let (whole, dashed): (Vec<_>, Vec<_>) = placed.iter().partition(|(key, _)| key.dash.is_empty());
    for (key, points) in whole.into_iter().chain(dashed) {
        let unit: Vec<(f64, f64)> =
            points.iter().map(|p| ((p.0 - x.0) / (x.1 - x.0), (p.1 - y.0) / (y.1 - y.0))).collect();
        let mut text = String::new();
        for (across, up) in thin(&unit, INVISIBLE) {
            // Far outside the frame the place does not matter, but drawing programs must be able to read the number.
            let v = (f64::from(height) * (1.0 - up)).clamp(-1e5, 1e5);
            let _ = write!(text, "{:.0},{:.0} ", f64::from(width) * across, v);
        }
        let dash: Vec<String> = key
            .dash
            .split(' ')
            .filter_map(|d| d.parse::<u32>().ok())
            .map(|d| (d * FINE).to_string())
            .collect();
        let dash =
            if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{}\"", dash.join(" ")) };
        let _ = write!(
            out,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dash} points=\"{}\"/>",
            key.colour,
            key.width * f64::from(FINE),
            text.trim_end()
        );
    }
    out + "</svg>"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> Chart {
        Chart::over_time("a < b", "pitch (deg)", vec![Curve { key: 0, points }])
    }

    #[test]
    fn a_chart_has_its_labels_and_thins_what_is_straight() {
        let svg = chart((0..5000).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect())
            .svg(&[Key::nth(1, "one")], SMALL)
            .unwrap();
        for part in ["time (s)", "pitch (deg)", "a &lt; b", "stroke-dasharray=\"28 12\""] {
            assert!(svg.contains(part), "{part}");
        }
        let points = svg.rsplit("points=\"").next().unwrap();
        assert_eq!(points.split('"').next().unwrap().split(' ').count(), 2, "{points}");
    }

    #[test]
    fn what_has_no_place_is_left_out() {
        let svg = chart(vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, f64::INFINITY), (3.0, 2.0)]);
        let svg = svg.svg(&[Key::nth(0, "one")], SMALL).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
