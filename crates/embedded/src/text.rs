//! Text of C: the files in `c/`, with the name of the autopilot and with fields, `@name@`, that are filled in.

use crate::real::Real;
use squid_scheduled::ControllerDesign;
use squid_signals::{Curve, Law};

/// The first line of both files.
pub(crate) fn title(design: &ControllerDesign) -> String {
    let title = format!(
        "The autopilot of {} ({} coefficients), design '{}', as written by squid {}.",
        design.vehicle.name,
        design.vehicle.status.word(),
        design.design,
        env!("CARGO_PKG_VERSION")
    );
    plain(&title)
}

/// Gives the functions, types and constants of a file the name of an autopilot.
pub(crate) fn named(text: &str, name: &str) -> String {
    let upper = name.to_ascii_uppercase();
    let text = text.replace("autopilot_", &format!("{name}_")).replace("AUTOPILOT_", &format!("{upper}_"));
    text.replace("\"autopilot.h\"", &format!("\"{name}.h\""))
}

/// Fills in a text. A line that is one field alone goes where the field is empty.
pub(crate) fn fill(text: &str, fields: &[(&str, String)]) -> String {
    let mut filled = text.to_owned();
    for (name, value) in fields {
        let field = format!("@{name}@");
        if value.is_empty() {
            filled = filled.replace(&format!("{field}\n"), "");
        }
        filled = filled.replace(&field, value.trim_end_matches('\n'));
    }
    filled
}

/// Lines one below the other.
pub(crate) fn lines(lines: impl IntoIterator<Item = String>) -> String {
    lines.into_iter().collect::<Vec<_>>().join("\n")
}

/// Words as they may stand in a comment: nothing that ends it, or that a compiler reads otherwise.
pub(crate) fn plain(words: &str) -> String {
    let harmless = |c: char| if c.is_control() || c == '\\' || c == '@' { ' ' } else { c };
    words.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").chars().map(harmless).collect()
}

/// Width of a comment.
const WIDTH: usize = 112;

/// Paragraphs as lines of a comment.
pub(crate) fn comment(paragraphs: &[String]) -> String {
    let paragraph = |words: &String| {
        let mut lines = vec![String::new()];
        for word in plain(words).split_whitespace() {
            let last = lines.len() - 1;
            if lines[last].is_empty() {
                lines[last].push_str(word);
            } else if lines[last].chars().count() + 1 + word.chars().count() <= WIDTH {
                lines[last].extend([" ", word]);
            } else {
                lines.push(word.to_owned());
            }
        }
        lines.iter().map(|line| format!(" * {line}\n")).collect::<String>()
    };
    paragraphs.iter().map(paragraph).collect::<Vec<_>>().join(" *\n")
}

/// Whether any actuator has a curve of a kind.
pub(crate) fn has_curve(design: &ControllerDesign, is_kind: fn(&Law) -> bool) -> bool {
    design.actuators.iter().filter_map(|one| one.curve.as_ref()).map(Curve::law).any(is_kind)
}

/// What the source calls of the mathematical library, with what must be linked; nothing without a square law.
pub(crate) fn library(design: &ControllerDesign, real: Real) -> Option<String> {
    let suffix = real.suffix();
    has_curve(design, |law| matches!(law, Law::Square(_)))
        .then(|| format!("calls sqrt{suffix} and copysign{suffix}: link with -lm."))
}
