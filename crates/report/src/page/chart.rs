//! Charts as SVG: a frame with ticks and curves. Colours are classes of `chart.css`.

use crate::page::{Axis, Key, Scale, escaped, thin, tidy};
use std::fmt::Write;

/// Curve of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Index of the curve's key in the figure.
    pub key: usize,
    /// Points, in order.
    pub points: Vec<(f64, f64)>,
}

/// Chart of one or more curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title, which distinguishes the chart from its neighbours; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves, in drawing order.
    pub curves: Vec<Curve>,
}

/// Width and height of a chart, in units of the page.
pub type Size = (u32, u32);
/// Size of a chart next to others on a page.
pub const SMALL: Size = (400, 250);
/// Size of a chart as wide as a page.
pub const WIDE: Size = (900, 230);
/// Margins of the frame, in units of the page: the smallest left and right ones, top and bottom.
const FRAME: [u32; 4] = [56, 12, 28, 42];
/// Approximate widths of a digit, and of a point or a sign, of a tick label in the widest font.
const DIGIT: (f64, f64) = (8.3, 4.8);
/// Tolerance for omitting points, as a fraction of the axis: a tenth of a unit of the page.
const INVISIBLE: f64 = 2.5e-4;
/// Decimals of a coordinate, in units of the page: finer than the tolerance.
const DECIMALS: usize = 2;
/// Largest magnitude of a coordinate, in units of the frame; drawing programs may not read larger ones.
const FARTHEST: f64 = 100.0;
const X_TICKS: usize = 6;
const Y_TICKS: usize = 5;
/// Length of a tick, in units of the page.
const TICK: f64 = 4.0;
/// Distance of a tick label from the axis, in units of the page.
const WORD: f64 = 7.0;

/// Inside of the frame, and the ranges of its axes in axis coordinates.
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: (f64, f64),
    y: (f64, f64),
}

impl Frame {
    fn across(&self, x: f64) -> f64 {
        self.width * (x - self.x.0) / (self.x.1 - self.x.0)
    }

    fn down(&self, y: f64) -> f64 {
        self.height * (1.0 - (y - self.y.0) / (self.y.1 - self.y.0))
    }
}

/// Returns the approximate width of a tick label, in units of the page.
fn breadth(word: &str) -> f64 {
    word.chars().map(|c| if c.is_alphanumeric() { DIGIT.0 } else { DIGIT.1 }).sum()
}

impl Chart {
    /// Creates a chart over time (s).
    pub fn over_time(title: impl Into<String>, label: impl Into<String>, curves: Vec<Curve>) -> Self {
        Self { title: title.into(), x: Axis::linear("time (s)"), y: Axis::linear(label), curves }
    }

    /// Creates a chart over the speed along the path (m/s).
    pub fn over_speed(label: impl Into<String>, curves: Vec<Curve>) -> Self {
        Self { title: String::new(), x: Axis::linear("speed V (m/s)"), y: Axis::linear(label), curves }
    }

    /// Creates a chart over frequency (rad/s).
    pub fn over_frequency(title: impl Into<String>, y: Axis, curves: Vec<Curve>) -> Self {
        Self { title: title.into(), x: Axis::logarithmic("frequency (rad/s)"), y, curves }
    }

    /// Creates a chart of a track seen from above, north upwards; points are (east, north), m.
    pub fn from_above(title: impl Into<String>, curves: Vec<Curve>) -> Self {
        Self {
            title: title.into(),
            x: Axis::linear("east (m)"),
            y: Axis::linear("north (m)").equal(),
            curves,
        }
    }

    /// Returns the chart as an `svg` element with further attributes.
    pub fn svg(&self, keys: &[Key], size: Size, attributes: &str) -> String {
        let placed: Vec<(usize, Vec<(f64, f64)>)> = self
            .curves
            .iter()
            .filter(|curve| curve.key < keys.len())
            .map(|curve| (curve.key, self.placed(&curve.points)))
            .collect();
        let all = || placed.iter().flat_map(|(_, points)| points);
        let x = self.x.extent(all().map(|p| p.0), false);
        let y = self.y.extent(all().map(|p| p.1), true);
        let [left, right, top, bottom] = FRAME.map(f64::from);
        let widest = self.y.labels(y, Y_TICKS).iter().map(|(_, word)| breadth(word)).fold(0.0, f64::max);
        let last = self.x.labels(x, X_TICKS).last().map_or(0.0, |(_, word)| breadth(word));
        let (left, right) = (left.max((widest + WORD + 2.0).ceil()), right.max((0.5 * last).ceil() + 1.0));
        let (width, height) = (f64::from(size.0) - left - right, f64::from(size.1) - top - bottom);
        let (x, y) = if self.y.is_equal { equal((x, y), width / height) } else { (x, y) };
        let frame = Frame { left, top, width, height, x, y };
        format!(
            "<svg {attributes} viewBox=\"0 0 {} {}\"{}>{}{}</svg>",
            size.0,
            size.1,
            self.ranges(&frame),
            self.axes(&frame, size),
            curves(&placed, keys, &frame)
        )
    }

    /// Returns attributes for the page's script: the ranges of the axes, and the logarithmic axes.
    fn ranges(&self, frame: &Frame) -> String {
        let logarithmic = |axis: &Axis| axis.scale == Scale::Logarithmic;
        let both = [("x", &self.x), ("y", &self.y)];
        let scales: String =
            both.iter().filter(|(_, axis)| logarithmic(axis)).map(|(name, _)| *name).collect();
        let scales = if scales.is_empty() { scales } else { format!(" data-log=\"{scales}\"") };
        let range = |(from, to): (f64, f64)| format!("{from:.6e} {to:.6e}");
        format!(" data-x=\"{}\" data-y=\"{}\"{scales}", range(frame.x), range(frame.y))
    }

    fn placed(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        points.iter().filter_map(|(x, y)| Some((self.x.place(*x)?, self.y.place(*y)?))).collect()
    }

    /// Returns heading, grid, ticks, tick labels, and the label of the horizontal axis.
    fn axes(&self, frame: &Frame, (width, height): Size) -> String {
        let heading = match self.title.as_str() {
            "" => self.y.label.clone(),
            title => format!("{title}: {}", self.y.label),
        };
        let (right, bottom) = (frame.left + frame.width, frame.top + frame.height);
        let [mut grid, mut ticks, mut below, mut beside] = [const { String::new() }; 4];
        for (tick, word) in self.x.labels(frame.x, X_TICKS) {
            let x = tidy(frame.left + frame.across(tick), DECIMALS);
            let _ = write!(grid, "M{x} {}V{bottom}", frame.top);
            let _ = write!(ticks, "M{x} {bottom}v{TICK}");
            let _ = write!(below, "<text x=\"{x}\" y=\"{}\">{word}</text>", bottom + 17.0);
        }
        for (tick, word) in self.y.labels(frame.y, Y_TICKS) {
            let y = frame.top + frame.down(tick);
            let _ = write!(grid, "M{} {}H{right}", frame.left, tidy(y, DECIMALS));
            let _ = write!(ticks, "M{} {}h-{TICK}", frame.left, tidy(y, DECIMALS));
            let _ = write!(
                beside,
                "<text x=\"{}\" y=\"{}\">{word}</text>",
                frame.left - WORD,
                tidy(y + 4.5, DECIMALS)
            );
        }
        format!(
            "<text x=\"4\" y=\"16\" font-size=\"14\">{}</text><path class=\"grid\" d=\"{grid}\"/>\
                <path class=\"axis\" d=\"M{} {}V{bottom}H{right}{ticks}\"/><g font-size=\"13\" \
                text-anchor=\"end\">{beside}</g><g font-size=\"13\" text-anchor=\"middle\">{below}<text \
                x=\"{}\" y=\"{}\">{}</text></g>",
            escaped(&heading),
            frame.left,
            frame.top,
            f64::from(width) / 2.0 + 20.0,
            height - 6,
            escaped(&self.x.label)
        )
    }
}

/// Widens one of two ranges about its middle until their units have equal length in a frame with the ratio `shape` of
/// width to height.
fn equal((x, y): ((f64, f64), (f64, f64)), shape: f64) -> ((f64, f64), (f64, f64)) {
    let widened = |(from, to): (f64, f64), length: f64| {
        let (middle, half) = (0.5 * (from + to), 0.5 * length.max(to - from));
        (middle - half, middle + half)
    };
    (widened(x, shape * (y.1 - y.0)), widened(y, (x.1 - x.0) / shape))
}

/// Returns the curves in a nested SVG that clips them at the frame.
fn curves(placed: &[(usize, Vec<(f64, f64)>)], keys: &[Key], frame: &Frame) -> String {
    let Frame { left, top, width, height, .. } = frame;
    let mut out =
        format!("<svg class=\"plot\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\">");
    // Dashed curves are drawn over solid ones, so that coincident lines are all visible.
    let (solid, dashed): (Vec<_>, Vec<_>) = placed.iter().partition(|(key, _)| keys[*key].dash.is_empty());
    for (index, points) in solid.into_iter().chain(dashed) {
        let key = &keys[*index];
        let group = match key.name.as_str() {
            "" => keys.iter().position(|other| other.colour == key.colour).unwrap_or(*index),
            _ => *index,
        };
        let unit: Vec<(f64, f64)> =
            points.iter().map(|p| (frame.across(p.0) / width, frame.down(p.1) / height)).collect();
        let unit = if key.dots { unit } else { thin(&unit, INVISIBLE) };
        let (mut coordinates, near) = (String::new(), |v: f64| v.clamp(-FARTHEST, FARTHEST));
        for (across, down) in unit {
            let (x, y) = (tidy(width * near(across), DECIMALS), tidy(height * near(down), DECIMALS));
            let _ =
                if key.dots { write!(coordinates, "M{x} {y}h0") } else { write!(coordinates, "{x},{y} ") };
        }
        let (class, style, coordinates) = (key.class(), key.style(), coordinates.trim_end());
        let _ = if key.dots {
            write!(out, "<path data-k=\"{group}\" class=\"{class}\" d=\"{coordinates}\"/>")
        } else {
            write!(out, "<polyline data-k=\"{group}\" class=\"{class}\"{style} points=\"{coordinates}\"/>")
        };
    }
    out + "</svg>"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> Chart {
        Chart::over_time("a < b", "pitch (deg)", vec![Curve { key: 0, points }])
    }

    /// Returns the coordinates of the first curve.
    fn coordinates(svg: &str) -> Vec<(f64, f64)> {
        let points = svg.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
        let pair = |p: &str| p.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()));
        points.split(' ').map(|p| pair(p).unwrap()).collect()
    }

    #[test]
    fn writes_labels_and_thins_straight_lines() {
        let line = chart((0..5000).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect());
        let svg = line.svg(&[Key::nth(1, "one")], SMALL, "");
        for part in ["time (s)", "pitch (deg)", "a &lt; b", "stroke-dasharray=\"7 3\""] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(coordinates(&svg).len(), 2, "{svg}");
    }

    /// Each coordinate of a slow curve has an error below 0.05 units, so that no steps are visible.
    #[test]
    fn coordinates_are_not_rounded_to_units() {
        let curve: Vec<(f64, f64)> = (0..=400).map(|i| 0.05 * f64::from(i)).map(|t| (t, t.sin())).collect();
        let fixed = |label: &str| Axis::linear(label).over(-10.0, 10.0);
        let chart = Chart { y: fixed("y (m)"), x: Axis::linear("x (s)").over(0.0, 20.0), ..chart(curve) };
        let svg = chart.svg(&[Key::nth(0, "one")], SMALL, "");
        let [left, right, top, bottom] = FRAME.map(f64::from);
        let (width, height) = (f64::from(SMALL.0) - left - right, f64::from(SMALL.1) - top - bottom);
        for (x, y) in coordinates(&svg) {
            let expected = height * (0.5 - 0.05 * (20.0 * x / width).sin());
            assert!((y - expected).abs() < 0.05, "{y} {expected}");
        }
    }

    /// Labels fit for any number of digits.
    #[test]
    fn tick_labels_are_not_clipped() {
        let mut chart = chart(vec![(0.3, 0.000_025_1), (0.38, 0.000_038)]);
        for scale in [1.0, 1e-3] {
            chart.curves[0].points.iter_mut().for_each(|p| p.1 *= scale);
            let svg = chart.svg(&[Key::nth(0, "one")], SMALL, "");
            let frame = svg.split("class=\"plot\" x=\"").nth(1).unwrap();
            let left: f64 = frame.split('"').next().unwrap().parse().unwrap();
            let width: f64 =
                frame.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            let widest = chart.y.labels((2.5e-5 * scale, 3.8e-5 * scale), Y_TICKS);
            assert!(widest.iter().all(|(_, word)| breadth(word) + WORD < left), "{widest:?} {left}");
            assert!(left + width + 0.5 * breadth("0.38") <= f64::from(SMALL.0), "{left} {width}");
        }
    }

    /// A square seen from above has equal sides, in a frame of any shape, and is inside the frame.
    #[test]
    fn square_from_above_has_equal_sides() {
        for scale in [(1.0, 1.0), (200.0, 3.0), (3.0, 200.0)] {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (scale.0, scale.1)];
            let chart = Chart::from_above("", vec![Curve { key: 0, points: corners.to_vec() }]);
            let coordinates = coordinates(&chart.svg(&[Key::nth(0, "one")], SMALL, ""));
            let (wide, high) = (coordinates[1].0 - coordinates[0].0, coordinates[1].1 - coordinates[2].1);
            assert!((wide - high).abs() < 0.02 * wide.max(1.0), "{coordinates:?}");
            let [left, right, top, bottom] = FRAME.map(f64::from);
            let inside = |p: &(f64, f64)| {
                (0.0..=f64::from(SMALL.0) - left - right).contains(&p.0)
                    && (0.0..=f64::from(SMALL.1) - top - bottom).contains(&p.1)
            };
            assert!(coordinates.iter().all(inside), "{coordinates:?}");
        }
    }

    #[test]
    fn omits_values_that_are_not_finite() {
        let svg = chart(vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, f64::INFINITY), (3.0, 2.0)]);
        let svg = svg.svg(&[Key::nth(0, "one")], SMALL, "");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
