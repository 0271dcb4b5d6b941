//! Block diagrams as SVG: boxes with text, connected by arrows.

use crate::page::escaped;
use std::fmt::Write;

/// Block diagram.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// Anchor in the page.
    pub name: String,
    /// Caption.
    pub caption: String,
    size: (u32, u32),
    drawn: String,
}

/// Line spacing in a box, in units of the page.
const LINE: f64 = 17.0;
/// Half the width, and the length, of an arrow head.
const HEAD: (f64, f64) = (3.5, 9.0);

impl Diagram {
    /// Creates an empty diagram; `size` is its width and height in units of the page.
    pub fn new(name: &str, caption: String, size: (u32, u32)) -> Self {
        Self { name: name.into(), caption, size, drawn: String::new() }
    }

    /// Draws a box with a centre, a width and height, and lines of text.
    pub fn block(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), lines: &[String]) {
        let (left, top) = (x - 0.5 * width, y - 0.5 * height);
        let _ = write!(
            self.drawn,
            "<rect class=\"axis\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" rx=\"3\"/>"
        );
        let first = y + 5.0 - 0.5 * LINE * (lines.len() as f64 - 1.0);
        for (i, line) in lines.iter().enumerate() {
            self.label((x, first + LINE * i as f64), line);
        }
    }

    /// Draws text centred at a point on its baseline.
    pub fn label(&mut self, (x, y): (f64, f64), text: &str) {
        let _ = write!(self.drawn, "<text x=\"{x}\" y=\"{y}\">{}</text>", escaped(text));
    }

    /// Draws a summing junction.
    pub fn sum(&mut self, (x, y): (f64, f64)) {
        let _ = write!(self.drawn, "<circle class=\"axis\" cx=\"{x}\" cy=\"{y}\" r=\"8\"/>");
    }

    /// Draws a line through corners, with an arrow head at its end.
    pub fn wire(&mut self, corners: &[(f64, f64)]) {
        let [.., before, end] = corners else { return };
        let path: Vec<String> = corners.iter().map(|(x, y)| format!("{x} {y}")).collect();
        let length = (end.0 - before.0).hypot(end.1 - before.1);
        let along = ((end.0 - before.0) / length, (end.1 - before.1) / length);
        let foot = (end.0 - HEAD.1 * along.0, end.1 - HEAD.1 * along.1);
        let side = (HEAD.0 * along.1, HEAD.0 * along.0);
        let _ = write!(
            self.drawn,
            "<path class=\"axis\" d=\"M{}\"/><path fill=\"currentColor\" d=\"M{} {}L{} {}L{} {}Z\"/>",
            path.join("L"),
            end.0,
            end.1,
            foot.0 - side.0,
            foot.1 + side.1,
            foot.0 + side.0,
            foot.1 - side.1
        );
    }

    /// Returns the diagram as part of a page.
    pub fn html(&self) -> String {
        let (name, caption, (width, height)) = (&self.name, escaped(&self.caption), self.size);
        format!(
            "<figure id=\"{name}\" class=\"diagram\">\n<svg role=\"img\" aria-label=\"{caption}\" viewBox=\"0 0 \
                {width} {height}\" width=\"{width}\" font-size=\"14\" text-anchor=\"middle\">{}</svg>\n\
                <figcaption style=\"max-width:{width}px\">{caption}</figcaption>\n</figure>\n",
            self.drawn
        )
    }
}
