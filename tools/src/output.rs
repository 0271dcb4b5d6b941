//! Output of the command.

use serde::Serialize;
use squid_base::files;
use squid_finding::Finding;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// First reason for which output was lost.
static LOST_OUTPUT: Mutex<Option<io::Error>> = Mutex::new(None);

/// `true` if the output is one JSON object; `ANSWERED` is `true` once it has been printed.
static AS_JSON: AtomicBool = AtomicBool::new(false);
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// Silences [`say`] from now on, and enables [`answer`].
pub fn answer_in_json() {
    AS_JSON.store(true, Ordering::Relaxed);
}

/// Returns `true` if the output is JSON.
pub fn is_for_programs() -> bool {
    AS_JSON.load(Ordering::Relaxed)
}

/// Findings reported as warnings.
static WARNINGS: Mutex<Vec<Finding>> = Mutex::new(vec![]);

/// Prints a finding as a warning, and adds it to the answer for programs; a repeated one only once.
pub fn warn(finding: &Finding) {
    let mut all = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
    if !all.contains(finding) {
        say(&format!("WARNING: {finding}"));
        all.push(finding.clone());
    }
}

/// Prints the result of a verb as JSON if `--json` was given, at the first call only; an object also has the
/// `warnings`.
///
/// # Errors
/// [`files::Error::Json`] if JSON cannot represent the value.
pub fn answer(found: &impl Serialize) -> Result<(), files::Error> {
    if is_for_programs() && !ANSWERED.swap(true, Ordering::Relaxed) {
        let mut found = serde_json::to_value(found).map_err(not_json)?;
        let warnings = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(object) = found.as_object_mut() {
            object.insert("warnings".into(), serde_json::to_value(&*warnings).map_err(not_json)?);
        }
        print_line(&json(&found)?);
    }
    Ok(())
}

fn not_json(reason: serde_json::Error) -> files::Error {
    files::Error::Json { path: "standard output".into(), reason }
}

/// Prints the results for the axes of a design as [`answer`] does: the object of a single axis, or a list `axes`.
///
/// # Errors
/// Errors of [`answer`].
pub fn answer_each(axes: &[impl Serialize]) -> Result<(), files::Error> {
    match axes {
        [one] => answer(one),
        all => answer(&serde_json::json!({ "axes": all })),
    }
}

/// Returns a value as one line of JSON.
///
/// # Errors
/// [`files::Error::Json`].
pub fn json(value: &impl Serialize) -> Result<String, files::Error> {
    serde_json::to_string(value).map_err(not_json)
}

/// Default line width of text for people; the environment variable `COLUMNS` overrides it, as for the help.
pub const COLUMNS: usize = 100;

/// Prints text for people to standard output, wrapped at [`COLUMNS`]. A failure is stored for [`flush`] and does not
/// stop the work.
pub fn say(text: &str) {
    say_indented(text, 0);
}

/// Prints text with continuation lines indented by `indent`, or as far as the line itself if that is more.
pub fn say_indented(text: &str, indent: usize) {
    if !is_for_programs() {
        print_line(&set(text, indent));
    }
}

/// Prints a path, which is never wrapped.
pub fn say_path(path: &Path) {
    say_unwrapped(&path.display().to_string());
}

/// Prints a text that is not wrapped, such as a file.
pub fn say_unwrapped(text: &str) {
    if !is_for_programs() {
        print_line(text);
    }
}

/// Prints text for people to standard error, in addition to a result that is a file on standard output.
pub fn note(text: &str) {
    if !is_for_programs() {
        // `eprintln` would panic if nothing can be written.
        let _ = writeln!(io::stderr(), "{}", set(text, 0));
    }
}

/// Wraps text for people at the available width.
pub fn set(text: &str, indent: usize) -> String {
    let requested = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let columns = requested.filter(|columns| *columns > 0).unwrap_or(COLUMNS);
    text.split('\n').map(|line| set_line(line, indent, columns)).collect::<Vec<_>>().join("\n")
}

/// Wraps a line at spaces; a word longer than the line, such as a path, is not broken. A table row is broken between
/// cells if possible, and continues below its second cell.
fn set_line(line: &str, indent: usize, columns: usize) -> String {
    let head = line.len() - line.trim_start().len();
    let (mut begin, indent) = (head.max(indent), indent.max(head).min(columns / 2));
    let second = line.get(begin..).and_then(|cells| cells.find("  ").map(|at| (begin + at, &cells[at..])));
    let second = second.map(|(at, rest)| at + rest.len() - rest.trim_start().len());
    let after = second.map_or(indent, |second| second + 2).min(columns / 2);
    let (mut out, mut rest, mut used) = (String::new(), line, 0);
    while used + rest.chars().count() > columns {
        let room = columns.saturating_sub(used) + 1;
        let room = rest.char_indices().nth(room).map_or(rest.len(), |(at, _)| at);
        let within = |pattern: &str| rest[..room].rfind(pattern).filter(|at| *at > begin);
        let later = || rest.get(begin..)?.find(' ').map(|at| begin + at);
        let Some(at) = within("  ").or_else(|| within(" ")).or_else(later) else { break };
        out += rest[..at].trim_end();
        out.push('\n');
        out += &" ".repeat(after);
        (rest, begin, used) = (rest[at..].trim_start(), 0, after);
    }
    out + rest
}

fn print_line(text: &str) {
    let mut out = io::stdout().lock();
    printed(writeln!(out, "{text}").and_then(|()| out.flush()));
}

/// Stores the first reason for which something could not be printed. A closed pipe, as by `head`, does not count.
pub fn printed(outcome: io::Result<()>) {
    if let (Err(reason), Ok(mut first)) = (outcome, LOST_OUTPUT.lock()) {
        let lost = reason.kind() != ErrorKind::BrokenPipe;
        *first = first.take().or(Some(reason).filter(|_| lost));
    }
}

/// Checks that everything since the last call was printed.
///
/// # Errors
/// [`files::Error::Unwritable`] with the first reason.
pub fn flush() -> Result<(), files::Error> {
    let lost = LOST_OUTPUT.lock().ok().and_then(|mut first| first.take());
    lost.map_or(Ok(()), |reason| Err(files::Error::Unwritable { path: "standard output".into(), reason }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines are wrapped at spaces with continuation lines indented, and a long path is not broken.
    #[test]
    fn lines_fit() {
        assert_eq!(set_line("  one 2 three", 0, 9), "  one 2\n  three");
        assert_eq!(set_line("one two", 4, 7), "one two");
        assert_eq!(set_line("one 2 three", 3, 8), "one 2\n   three");
        assert_eq!(set_line("in /a/long/path/that/stays whole", 0, 10), "in\n/a/long/path/that/stays\nwhole");
        assert_eq!(set_line("", 4, 10), "");
        let row = "stage  met  phase margin  57 deg  0.50 m/s, opened at speed";
        let broken = "stage  met  phase margin  57 deg\n              0.50 m/s, opened at speed";
        assert_eq!(set_line(row, 7, 45), broken);
    }
}
