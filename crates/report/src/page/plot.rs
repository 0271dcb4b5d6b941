//! Plots of a flight: stacked charts over time, and its track from above.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, WIDTH, extent};
use std::path::Path;

/// The kind of a line, which determines its colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// An independent quantity.
    Own,
    /// A reference or a limit.
    Reference,
    /// One of several ordered lines, at a fraction from 0 to 1 between the lowest and the highest.
    Along(f64),
}

/// One line in a panel.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Points (s, value).
    pub points: Vec<(f64, f64)>,
    /// The kind.
    pub kind: Kind,
}

/// One panel.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Label of the vertical axis, with its unit.
    pub label: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// True for a track seen from above: points are (east, north), m.
    pub is_from_above: bool,
}

impl Panel {
    /// A panel over time (s).
    pub fn over_time(label: impl Into<String>, lines: Vec<Line>) -> Self {
        Self { label: label.into(), lines, is_from_above: false }
    }

    /// A track seen from above.
    pub fn from_above(lines: Vec<Line>) -> Self {
        Self { label: String::new(), lines, is_from_above: true }
    }
}

/// Larger numbers come from a diverged flight and would overflow the axes.
const LARGEST_DRAWN: f64 = 1e100;

/// Draws panels as SVG for a file. Lines with the same name have the same colour in all panels.
///
/// # Errors
/// [`Error::Plot`] with the file.
pub fn draw(path: &Path, title: &str, panels: &[Panel]) -> Result<String, Error> {
    let failed = |reason| Error::Plot { path: path.display().to_string(), reason };
    let mut keys: Vec<Key> = Vec::new();
    let mut charts = Vec::new();
    for panel in panels {
        let points = panel.lines.iter().flat_map(|line| &line.points);
        let (low, high) = extent(points.map(|point| point.1));
        if low.abs().max(high.abs()) > LARGEST_DRAWN && low <= high {
            return Err(failed(format!("no axis can be drawn from {low:e} to {high:e}")));
        }
        // Coincident lines stay visible: the last one is narrower and on top.
        let wider = |nth: usize| if nth + 1 < panel.lines.len() { 2.0 * WIDTH } else { WIDTH };
        let lines = panel.lines.iter().enumerate();
        let curves = lines.map(|(nth, line)| curve(line, wider(nth), &mut keys)).collect();
        charts.push(if panel.is_from_above {
            Chart::from_above("track", curves)
        } else {
            Chart::over_time("", panel.label.as_str(), curves)
        });
    }
    let figure = Figure { name: String::new(), caption: String::new(), keys, charts };
    Ok(figure.stacked(title))
}

/// A line as a curve, with its key.
fn curve(line: &Line, width: f64, keys: &mut Vec<Key>) -> Curve {
    let key = keys.iter().position(|key| key.name == line.name).unwrap_or_else(|| {
        let nth = keys.iter().filter(|key| key.colour != Key::reference("").colour).count();
        let name = line.name.as_str();
        keys.push(match line.kind {
            Kind::Reference => Key::reference(name),
            Kind::Own => Key { width, ..Key::coloured(nth, name) },
            Kind::Along(part) => Key::along(part, name),
        });
        keys.len() - 1
    });
    Curve { key, points: line.points.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of nine lines with a reference among them no two look the same.
    #[test]
    fn each_name_has_a_look_of_its_own() {
        let mut keys = vec![];
        for name in [
            "reference",
            "pitch",
            "heading",
            "roll",
            "speed",
            "port",
            "starboard",
            "stern",
            "rudder",
            "depth",
        ] {
            let kind = if name == "reference" { Kind::Reference } else { Kind::Own };
            curve(&Line { name: name.into(), points: vec![], kind }, WIDTH, &mut keys);
        }
        let looks = |key: &Key| (key.colour, key.dash);
        for (index, key) in keys.iter().enumerate() {
            assert!(keys[..index].iter().all(|other| looks(other) != looks(key)), "{}", key.name);
        }
    }

    /// The ticks of a diverged flight would never end.
    #[test]
    fn values_too_large_for_an_axis_are_rejected() {
        let line = Line { name: "pitch".into(), points: vec![(0.0, 1e308), (1.0, -1e308)], kind: Kind::Own };
        let panel = Panel::over_time("rad", vec![line]);
        let folder = tempfile::tempdir().unwrap();
        let error = draw(&folder.path().join("a.svg"), "a", &[panel]).unwrap_err().to_string();
        insta::assert_snapshot!(error.replace(&folder.path().display().to_string(), "TMP"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
