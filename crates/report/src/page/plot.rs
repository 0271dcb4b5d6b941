//! Plots over time as SVG: panels one above the other with a common axis.

use crate::error::Error;
use plotters::prelude::*;
use std::path::Path;

/// Colours that the colour-blind can tell apart (M. Okabe, K. Ito, Color Universal Design, 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// One line in a panel.
#[derive(Debug, Clone)]
pub struct Line {
    /// For the legend.
    pub name: String,
    /// (s, value).
    pub points: Vec<(f64, f64)>,
    /// References and limits are drawn dashed and grey.
    pub reference: bool,
}

/// One panel.
#[derive(Debug, Clone)]
pub struct Panel {
    /// What the vertical axis shows, with its unit.
    pub label: String,
    /// The lines.
    pub lines: Vec<Line>,
}

const WIDTH: u32 = 900;
const PANEL_HEIGHT: u32 = 230;
const TITLE_HEIGHT: u32 = 40;

/// Numbers beyond this come of a flight that ran off; the drawing of axes would overflow with them.
const WIDEST: f64 = 1e100;

/// Draws panels over time (s) as SVG for a file.
///
/// # Errors
/// [`Error::Plot`] with the file.
pub fn draw(path: &Path, title: &str, panels: &[Panel]) -> Result<String, Error> {
    let mut svg = String::new();
    let height = TITLE_HEIGHT + PANEL_HEIGHT * panels.len() as u32;
    paint(&mut svg, height, title, panels)
        .map_err(|reason| Error::Plot { path: path.display().to_string(), reason: reason.to_string() })?;
    Ok(svg)
}

fn paint(
    svg: &mut String,
    height: u32,
    title: &str,
    panels: &[Panel],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let (head, body) = root.split_vertically(TITLE_HEIGHT);
    head.draw(&Text::new(title.to_owned(), (62, 12), ("sans-serif", 18).into_font()))?;
    for (i, (area, panel)) in body.split_evenly((panels.len(), 1)).iter().zip(panels).enumerate() {
        paint_panel(area, panel, i + 1 == panels.len())?;
    }
    root.present()?;
    Ok(())
}

fn paint_panel<B: DrawingBackend>(
    area: &DrawingArea<B, plotters::coord::Shift>,
    panel: &Panel,
    last: bool,
) -> Result<(), Box<dyn std::error::Error>>
where
    B::ErrorType: 'static,
{
    let points = || panel.lines.iter().flat_map(|l| &l.points);
    let end = points().map(|p| p.0).fold(f64::MIN_POSITIVE, f64::max);
    let start = points().map(|p| p.0).fold(end, f64::min);
    let low = points().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let high = points().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let room = (0.08 * (high - low)).max(1e-3 * high.abs()).max(1e-9);
    for (from, to) in [(start, end), (low, high)] {
        if to - from > WIDEST || to.abs().max(from.abs()) > WIDEST {
            return Err(format!("no axis can be drawn from {from:e} to {to:e}").into());
        }
    }
    let mut chart = ChartBuilder::on(area)
        .margin_right(190)
        .margin_top(8)
        .x_label_area_size(if last { 38 } else { 22 })
        .y_label_area_size(62)
        .build_cartesian_2d(start..end, (low - room)..(high + room))?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE).bold_line_style(RGBColor(225, 225, 225)).y_labels(6).x_labels(10);
    mesh.y_desc(panel.label.as_str()).label_style(("sans-serif", 13)).axis_desc_style(("sans-serif", 14));
    if last {
        mesh.x_desc("time (s)");
    }
    mesh.y_label_formatter(&|v| number(*v)).x_label_formatter(&|v| number(*v));
    mesh.draw()?;
    let drawn = panel.lines.iter().filter(|l| !l.reference).count();
    let mut colour = 0;
    let unit = (end - start, high - low + 2.0 * room);
    for (row, line) in panel.lines.iter().enumerate() {
        let points = thinned(&line.points, unit);
        let style = if line.reference {
            RGBColor(120, 120, 120).stroke_width(1)
        } else {
            colour += 1;
            // Lines that lie on one another stay visible: those drawn first are wider.
            COLOURS[(colour - 1) % COLOURS.len()].stroke_width(2 + (drawn - colour).min(2) as u32)
        };
        if line.reference {
            chart.draw_series(DashedLineSeries::new(points, 6, 4, style))?;
        } else {
            chart.draw_series(LineSeries::new(points, style))?;
        }
        legend(area, row, line, style)?;
    }
    Ok(())
}

/// The points that are drawn: those left out lie within a tenth of a unit of the drawing.
fn thinned(points: &[(f64, f64)], (across, up): (f64, f64)) -> Vec<(f64, f64)> {
    let unit: Vec<(f64, f64)> = points.iter().map(|p| (p.0 / across, p.1 / up)).collect();
    thin(&unit, 1e-4).into_iter().map(|p| (p.0 * across, p.1 * up)).collect()
}

/// The legend stands to the right of the panel, so that it never covers a line.
fn legend<B: DrawingBackend>(
    area: &DrawingArea<B, plotters::coord::Shift>,
    row: usize,
    line: &Line,
    style: ShapeStyle,
) -> Result<(), Box<dyn std::error::Error>>
where
    B::ErrorType: 'static,
{
    let (left, top) = (WIDTH as i32 - 180, 16 + 19 * row as i32);
    let dashes = if line.reference { vec![(0, 6), (10, 16), (20, 24)] } else { vec![(0, 24)] };
    for (from, to) in dashes {
        area.draw(&PathElement::new(vec![(left + from, top), (left + to, top)], style))?;
    }
    area.draw(&Text::new(line.name.clone(), (left + 28, top - 7), ("sans-serif", 13).into_font()))?;
    Ok(())
}

/// Leaves out points that a line through those kept passes within `tolerance` of; the first and the last are kept.
///
/// Both coordinates are in units of their axis. Source: D. Douglas, T. Peucker, Cartographica 10(2), 1973.
pub fn thin(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let mut keep = vec![false; points.len()];
    let mut open = Vec::new();
    if let Some(last) = points.len().checked_sub(1) {
        (keep[0], keep[last]) = (true, true);
        open.push((0, last));
    }
    while let Some((from, to)) = open.pop() {
        let between = (from + 1..to).map(|i| (i, distance(points[i], points[from], points[to])));
        if let Some((at, farthest)) = between.max_by(|a, b| a.1.total_cmp(&b.1))
            && farthest > tolerance
        {
            keep[at] = true;
            open.extend([(from, at), (at, to)]);
        }
    }
    points.iter().zip(keep).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// From a point to a piece of a line.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let along = (b.0 - a.0, b.1 - a.1);
    let square = along.0 * along.0 + along.1 * along.1;
    let part = if square > 0.0 { ((p.0 - a.0) * along.0 + (p.1 - a.1) * along.1) / square } else { 0.0 };
    let part = part.clamp(0.0, 1.0);
    (p.0 - a.0 - part * along.0).hypot(p.1 - a.1 - part * along.1)
}

/// A number for an axis: no more digits than it needs.
fn number(v: f64) -> String {
    let text = format!("{v:.3}");
    let trimmed = text.trim_end_matches('0').trim_end_matches('.');
    if trimmed == "-0" { "0".into() } else { trimmed.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every point left out lies within the tolerance of the lines that are drawn, and there are far fewer of them.
    #[test]
    fn thinning_cannot_be_seen() {
        let step = |t: f64| 1.0 - (-t).exp() * (3.0 * t).cos();
        let points: Vec<(f64, f64)> = (0..3000)
            .map(|i| f64::from(i) / 3000.0)
            .map(|x| (x, if x < 0.3 { 0.0 } else { step(10.0 * (x - 0.3)) }))
            .collect();
        let kept = thin(&points, 3e-4);
        assert!(kept.len() < 200, "{}", kept.len());
        for p in &points {
            let nearest = kept.windows(2).map(|w| distance(*p, w[0], w[1])).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 3e-4, "{p:?} is {nearest} off");
        }
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[2999]));
    }

    /// The axis of a flight that ran off would never be finished.
    #[test]
    fn what_no_axis_can_show_is_refused() {
        let line = Line { name: "pitch".into(), points: vec![(0.0, 1e308), (1.0, -1e308)], reference: false };
        let panel = Panel { label: "rad".into(), lines: vec![line] };
        let folder = tempfile::tempdir().unwrap();
        let told = draw(&folder.path().join("a.svg"), "a", &[panel]).unwrap_err().to_string();
        assert!(told.contains("no axis can be drawn from -1e308 to 1e308"), "{told}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn few_points_are_kept() {
        assert_eq!(thin(&[], 1.0), vec![]);
        assert_eq!(thin(&[(0.0, 0.0)], 1.0), vec![(0.0, 0.0)]);
        assert_eq!(thin(&[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)], 0.0).len(), 2);
    }
}
