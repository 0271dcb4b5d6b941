//! Figures: charts with a common legend, as part of a page or as an SVG file.

use crate::page::{Chart, Key, SMALL, Size, WIDE, escaped};
use std::fmt::Write;

/// Charts with a common legend and a caption.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File name without extension; also the anchor in the page.
    pub name: String,
    /// Caption of one or two sentences.
    pub caption: String,
    /// Keys of the curves; a key without a name is not in the legend.
    pub keys: Vec<Key>,
    /// Charts.
    pub charts: Vec<Chart>,
}

/// Colours of charts, for light and dark pages.
pub const STYLE: &str = include_str!("chart.css");
/// Font of text and charts.
pub const FONT: &str = "system-ui,-apple-system,'Segoe UI',Roboto,'Liberation Sans',sans-serif";
/// Charts per row in an SVG file.
const ACROSS: usize = 3;
/// Height of the title and of a row of the legend, in units of the page.
const LINE: u32 = 20;
/// Approximate width of a letter in the widest font, in units of the page.
const LETTER: f64 = 7.6;
/// Approximate width of a letter of the title, in units of the page.
const TITLE_LETTER: f64 = 8.8;

/// Wraps text to lines of at most `letters` letters.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

impl Figure {
    /// Returns the keys of the legend, with their indices.
    fn named(&self) -> impl Iterator<Item = (usize, &Key)> {
        self.keys.iter().enumerate().filter(|(_, key)| !key.name.is_empty())
    }

    /// Returns the figure as part of a page, with charts side by side if there is space, otherwise stacked.
    pub fn html(&self) -> String {
        let mut out = format!("<figure id=\"{}\">\n", self.name);
        if self.keys.len() > 1 {
            out += "<div class=\"legend\">";
            for (index, key) in self.named() {
                let _ = writeln!(
                    out,
                    "<span data-k=\"{index}\"><svg width=\"26\" height=\"12\" aria-hidden=\"true\">{}</svg> {}</span>",
                    key.sample(),
                    escaped(&key.name)
                );
            }
            out += "</div>\n";
        }
        out += "<div class=\"charts\">\n";
        for chart in &self.charts {
            let label = format!("{} {} over {}", chart.title, chart.y.label, chart.x.label);
            let attributes = format!("role=\"img\" aria-label=\"{}\"", escaped(label.trim()));
            let _ = writeln!(out, "{}", chart.svg(&self.keys, SMALL, &attributes));
        }
        let _ = write!(out, "</div>\n<figcaption>{}</figcaption>\n</figure>\n", escaped(&self.caption));
        out
    }

    /// Returns the figure as an SVG file.
    pub fn file(&self, title: &str) -> String {
        self.laid_out(title, self.charts.len().clamp(1, ACROSS), SMALL)
    }

    /// Returns the figure as an SVG file with stacked charts.
    pub fn stacked(&self, title: &str) -> String {
        self.laid_out(title, 1, WIDE)
    }

    fn laid_out(&self, title: &str, across: usize, size: Size) -> String {
        let width = size.0 * across as u32;
        let lines = wrapped(title, (f64::from(width) / TITLE_LETTER) as usize);
        let head = LINE * lines.len() as u32;
        let (legend, rows) = self.legend(f64::from(width), head);
        let top = head + LINE * rows + 12;
        // A track seen from above gets twice the height.
        let high = |row: &[Chart]| if row.iter().any(|chart| chart.y.is_equal) { 2 * size.1 } else { size.1 };
        let height = top + self.charts.chunks(across).map(high).sum::<u32>();
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
                {height}\" class=\"sheet\" font-family=\"{FONT}\">\n<style>{STYLE}</style>\n<rect width=\"{width}\" \
                height=\"{height}\"/>\n"
        );
        for (i, line) in lines.iter().enumerate() {
            let y = LINE * i as u32 + 16;
            let _ = writeln!(out, "<text x=\"6\" y=\"{y}\" font-size=\"15\">{}</text>", escaped(line));
        }
        out += &legend;
        let mut y = top;
        for row in self.charts.chunks(across) {
            let size = (size.0, high(row));
            for (i, chart) in row.iter().enumerate() {
                let x = size.0 * i as u32;
                let position = format!("x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\"", size.0, size.1);
                let _ = writeln!(out, "{}", chart.svg(&self.keys, size, &position));
            }
            y += size.1;
        }
        out + "</svg>\n"
    }

    /// Returns the legend, and the number of its rows, below a title of height `head`.
    fn legend(&self, width: f64, head: u32) -> (String, u32) {
        if self.keys.len() < 2 {
            return (String::new(), 0);
        }
        let (mut out, mut x, mut row) = (String::new(), 6.0, 0u32);
        for (_, key) in self.named() {
            let width_of_key = 52.0 + LETTER * key.name.chars().count() as f64;
            if x > 6.0 && x + width_of_key > width {
                (x, row) = (6.0, row + 1);
            }
            let y = head + LINE * row + 6;
            let _ = writeln!(
                out,
                "<svg x=\"{x}\" y=\"{y}\" width=\"26\" height=\"12\">{}</svg><text x=\"{}\" y=\"{}\" \
                    font-size=\"13\">{}</text>",
                key.sample(),
                x + 32.0,
                y + 11,
                escaped(&key.name)
            );
            x += width_of_key;
        }
        (out, row + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::axis::Axis;
    use crate::page::chart::Curve;

    #[test]
    fn long_legend_takes_several_rows() {
        let chart = Chart {
            title: String::new(),
            x: Axis::linear("x"),
            y: Axis::linear("y"),
            curves: vec![Curve { key: 0, points: vec![(0.0, 0.0), (1.0, 1.0)] }],
        };
        let names = ["a name of thirty letters & more"; 6].into_iter().chain([""]);
        let keys = names.enumerate().map(|(i, name)| Key::nth(i, name)).collect();
        let figure = Figure { name: "f".into(), caption: "c".into(), keys, charts: vec![chart] };
        let (legend, rows) = figure.legend(f64::from(SMALL.0), 20);
        assert_eq!(rows, 6, "{legend}: the one without a name takes none");
        assert!(!legend.contains("& "), "escaped");
        assert_eq!(wrapped("1 2 345", 4), ["1 2", "345"]);
        assert!(figure.file("t").starts_with("<svg xmlns"));
    }
}
