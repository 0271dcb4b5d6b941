//! C text: the files in `c/` with the name of the autopilot and with their fields, `@name@`, filled in.

use crate::real::Real;
use squid_scheduled::ControllerDesign;
use squid_signals::{Curve, Law};

/// Returns the first line of both files.
pub(crate) fn title(design: &ControllerDesign) -> String {
    let title = format!(
        "Autopilot of {} ({} coefficients), design '{}', written by squid {}.",
        design.vehicle.name,
        design.vehicle.status.word(),
        design.design,
        env!("CARGO_PKG_VERSION")
    );
    plain(&title)
}

/// Prefixes the functions, types and constants of a file with the name of an autopilot.
pub(crate) fn named(text: &str, name: &str) -> String {
    let upper = name.to_ascii_uppercase();
    let text = text.replace("autopilot_", &format!("{name}_")).replace("AUTOPILOT_", &format!("{upper}_"));
    text.replace("\"autopilot.h\"", &format!("\"{name}.h\""))
}

/// Fills in the fields of a text. A line that consists of an empty field is removed.
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

/// Joins lines.
pub(crate) fn lines(lines: impl IntoIterator<Item = String>) -> String {
    lines.into_iter().collect::<Vec<_>>().join("\n")
}

/// Escapes text for a comment: removes what ends the comment or what a compiler interprets.
pub(crate) fn plain(text: &str) -> String {
    let harmless = |c: char| if c.is_control() || c == '\\' || c == '@' { ' ' } else { c };
    text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").chars().map(harmless).collect()
}

/// Width of a comment, in columns.
const WIDTH: usize = 112;

/// Formats paragraphs as lines of a comment.
pub(crate) fn comment(paragraphs: &[String]) -> String {
    let paragraph = |text: &String| {
        let mut lines = vec![String::new()];
        for word in plain(text).split_whitespace() {
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

/// Returns `true` if any actuator has a curve of the given kind.
pub(crate) fn has_curve(design: &ControllerDesign, is_kind: fn(&Law) -> bool) -> bool {
    design.actuators.iter().filter_map(|one| one.curve.as_ref()).map(Curve::law).any(is_kind)
}

/// Returns the calls of the mathematical library and the linker option; `None` without a square law.
pub(crate) fn library(design: &ControllerDesign, real: Real) -> Option<String> {
    let suffix = real.suffix();
    has_curve(design, |law| matches!(law, Law::Square(_)))
        .then(|| format!("calls sqrt{suffix} and copysign{suffix}: link with -lm."))
}
