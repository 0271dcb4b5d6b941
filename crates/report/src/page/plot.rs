//! Plots of a flight: stacked charts over time, and its track from above.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, WIDTH, extent};
use std::path::Path;

/// Kind of a line, which determines its colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Independent quantity.
    Own,
    /// Reference or limit.
    Reference,
    /// One of several ordered lines, at a fraction from 0 for the lowest to 1 for the highest.
    Along(f64),
}

/// Line of a panel.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Points (s, value).
    pub points: Vec<(f64, f64)>,
    /// Kind.
    pub kind: Kind,
}

/// Panel of a plot.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Label of the vertical axis, with its unit.
    pub label: String,
    /// Lines.
    pub lines: Vec<Line>,
    /// `true` for a track seen from above; points are (east, north), m.
    pub is_from_above: bool,
}

impl Panel {
    /// Creates a panel over time (s).
    pub fn over_time(label: impl Into<String>, lines: Vec<Line>) -> Self {
        Self { label: label.into(), lines, is_from_above: false }
    }

    /// Creates a panel of a track seen from above.
    pub fn from_above(lines: Vec<Line>) -> Self {
        Self { label: String::new(), lines, is_from_above: true }
    }
}

/// Largest magnitude of a plotted number; larger ones come from a diverged flight and would overflow the axes.
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
        // The last line is narrower and on top, so that coincident lines stay visible.
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

/// Converts a line to a curve, and adds its key if it is new.
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

    /// Ten lines, one of them a reference, all have different styles.
    #[test]
    fn each_name_has_its_own_style() {
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
        let style = |key: &Key| (key.colour, key.dash);
        for (index, key) in keys.iter().enumerate() {
            assert!(keys[..index].iter().all(|other| style(other) != style(key)), "{}", key.name);
        }
    }

    /// Values of a diverged flight would need an endless number of ticks.
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
