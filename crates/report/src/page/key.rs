//! Key of curves: style and name of the curves of one kind.

/// Colours of unordered curves, as classes of `chart.css`.
const NAMED: [&str; 7] = ["c0", "c1", "c2", "c3", "c4", "c5", "c6"];

/// Colours of ordered curves, from the lowest to the highest, as classes of `chart.css`.
const ORDERED: [&str; 11] = ["v0", "v1", "v2", "v3", "v4", "v5", "v6", "v7", "v8", "v9", "v10"];

/// Dashes, in units of the page.
const DASHES: [&str; 3] = ["", "7 3", "7 3 2 3"];

/// Width of a curve, in units of the page, as in `chart.css`.
pub const WIDTH: f64 = 1.7;

/// Style and name of the curves of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Name in the legend; a key without a name belongs to the first key of the same colour.
    pub name: String,
    /// Class of the colour in `chart.css`.
    pub colour: &'static str,
    /// SVG dash pattern; empty for a solid line.
    pub dash: &'static str,
    /// Width, in units of the page.
    pub width: f64,
    /// `true` if points are drawn instead of a line.
    pub dots: bool,
}

impl Key {
    fn of(name: impl Into<String>, colour: &'static str) -> Self {
        Self { name: name.into(), colour, dash: "", width: WIDTH, dots: false }
    }

    /// Returns the key of the n-th of several curves, with its own colour and dashes.
    pub fn nth(n: usize, name: impl Into<String>) -> Self {
        Self { dash: DASHES[n % DASHES.len()], ..Self::of(name, NAMED[n % NAMED.len()]) }
    }

    /// Returns the key of the n-th of several curves, with its own colour; dashed where colours repeat.
    pub fn coloured(n: usize, name: impl Into<String>) -> Self {
        Self { dash: DASHES[n / NAMED.len() % DASHES.len()], ..Self::of(name, NAMED[n % NAMED.len()]) }
    }

    /// Returns the key of one of several ordered curves, at a fraction from 0 for the lowest to 1 for the highest.
    pub fn along(part: f64, name: impl Into<String>) -> Self {
        let last = ORDERED.len() - 1;
        Self::of(name, ORDERED[((part * last as f64).round() as usize).min(last)])
    }

    /// Returns the key of a reference or a limit: thin, grey and dashed.
    pub fn reference(name: impl Into<String>) -> Self {
        Self { dash: "3 2", width: 1.2, ..Self::of(name, "reference") }
    }

    /// Returns the key of a background curve: wide and pale.
    pub fn ground(name: impl Into<String>) -> Self {
        Self { width: 5.0, ..Self::of(name, "ground") }
    }

    /// Returns this key with points instead of a line.
    #[must_use]
    pub fn dotted(self) -> Self {
        Self { dots: true, ..self }
    }

    /// Returns the sample in a legend.
    pub fn sample(&self) -> String {
        let (class, style) = (self.class(), self.style());
        let line = if self.dots { "M13 6h0" } else { "M0 6H26" };
        format!("<path class=\"{class}\"{style} d=\"{line}\"/>")
    }

    /// Returns the CSS classes of the curves.
    pub fn class(&self) -> String {
        format!("{}{}", if self.dots { "dots " } else { "" }, self.colour)
    }

    /// Returns the style attribute of the curves.
    pub fn style(&self) -> String {
        if self.dots {
            return String::new();
        }
        let dash =
            if self.dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{}\"", self.dash) };
        format!(" style=\"stroke-width:{}\"{dash}", self.width)
    }
}
