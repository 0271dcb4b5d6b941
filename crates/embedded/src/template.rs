//! Text with fields: `@name@` stands for what the field says.

use crate::real::Real;
use squid_scheduled::ControllerDesign;

/// The fields of both files.
pub(crate) fn fields(name: &str, design: &ControllerDesign, real: Real) -> Vec<(&'static str, String)> {
    let title = format!(
        "The autopilot of {} ({} coefficients), design '{}', as written by squid {}.",
        design.vehicle.name,
        design.vehicle.status.word(),
        design.design,
        env!("CARGO_PKG_VERSION")
    );
    vec![
        ("title", plain(&title)),
        ("prefix", name.to_owned()),
        ("PREFIX", name.to_ascii_uppercase()),
        ("real", real.name().to_owned()),
        ("f", real.suffix().to_owned()),
    ]
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
pub(crate) fn lines(lines: impl Iterator<Item = String>) -> String {
    lines.collect::<Vec<_>>().join("\n")
}

/// Words as they may stand in a comment: nothing that ends it, or that a compiler reads otherwise.
pub(crate) fn plain(words: &str) -> String {
    let harmless = |c: char| if c.is_control() || c == '\\' || c == '@' { ' ' } else { c };
    words.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").chars().map(harmless).collect()
}

/// Width of a comment.
const WIDTH: usize = 112;

/// A paragraph as lines of a comment.
pub(crate) fn paragraph(words: &str) -> String {
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
    lines.iter().map(|line| format!(" * {line}\n")).collect()
}
