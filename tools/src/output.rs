//! What the command prints.

use serde::Serialize;
use squid_base::files;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why output was lost first.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

/// Whether the one thing printed is an object for programs, and whether it has been printed.
static AS_JSON: AtomicBool = AtomicBool::new(false);
static ANSWERED: AtomicBool = AtomicBool::new(false);

/// From now on [`say`] prints nothing, and the first [`answer`] is printed.
pub fn answer_in_json() {
    AS_JSON.store(true, Ordering::Relaxed);
}

/// Whether the answer is for programs.
pub fn is_for_programs() -> bool {
    AS_JSON.load(Ordering::Relaxed)
}

/// What a verb found, for programs: printed with `--json`, the first time that it is called.
///
/// # Errors
/// [`files::Error::Json`] for a value that JSON cannot hold.
pub fn answer(found: &impl Serialize) -> Result<(), files::Error> {
    if is_for_programs() && !ANSWERED.swap(true, Ordering::Relaxed) {
        print_line(&json(found)?);
    }
    Ok(())
}

/// As [`answer`], with what is said of each axis of a design: the object of the only one, or a list `axes`.
///
/// # Errors
/// As [`answer`].
pub fn answer_each(axes: &[impl Serialize]) -> Result<(), files::Error> {
    match axes {
        [one] => answer(one),
        all => answer(&serde_json::json!({ "axes": all })),
    }
}

/// A value as one line of JSON.
///
/// # Errors
/// [`files::Error::Json`].
pub fn json(value: &impl Serialize) -> Result<String, files::Error> {
    serde_json::to_string(value)
        .map_err(|reason| files::Error::Json { path: "standard output".into(), reason })
}

/// The columns in which words for people are set, unless the environment says how many there are: `COLUMNS`, as for the
/// help.
pub const COLUMNS: usize = 100;

/// Prints words for people to standard output, set in [`COLUMNS`]. A failure is kept for [`all_said`] and does not stop
/// the work.
pub fn say(text: &str) {
    say_indented(text, 0);
}

/// The same with lines after a break that begin so far in, or as far in as the line before the break.
pub fn say_indented(text: &str, indent: usize) {
    if !is_for_programs() {
        print_line(&set(text, indent));
    }
}

/// Prints paths, which are never broken.
pub fn say_path(path: &Path) {
    say_whole(&path.display().to_string());
}

/// Prints a text whose lines are never broken, such as a file.
pub fn say_whole(text: &str) {
    if !is_for_programs() {
        print_line(text);
    }
}

/// Prints words for people to standard error, beside a result that is a file on standard output.
pub fn note(text: &str) {
    if !is_for_programs() {
        // Not `eprintln`, which panics where nothing can be written.
        let _ = writeln!(io::stderr(), "{}", set(text, 0));
    }
}

/// Words for people, set in the columns that there are.
pub fn set(text: &str, indent: usize) -> String {
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let columns = asked.filter(|columns| *columns > 0).unwrap_or(COLUMNS);
    text.split('\n').map(|line| set_line(line, indent, columns)).collect::<Vec<_>>().join("\n")
}

/// A line broken at spaces; a word that is longer than the line, such as a path, stays whole. A row of a table is
/// broken between its cells, where that can be, and goes on below the second of them.
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

/// Keeps the first reason why something could not be printed. A closed pipe, as by `head`, does not count.
pub fn printed(outcome: io::Result<()>) {
    if let (Err(reason), Ok(mut first)) = (outcome, UNSAID.lock()) {
        let lost = reason.kind() != ErrorKind::BrokenPipe;
        *first = first.take().or(Some(reason).filter(|_| lost));
    }
}

/// Whether everything since the last call could be printed.
///
/// # Errors
/// [`files::Error::Unwritable`] with the first reason.
pub fn all_said() -> Result<(), files::Error> {
    let lost = UNSAID.lock().ok().and_then(|mut first| first.take());
    lost.map_or(Ok(()), |reason| Err(files::Error::Unwritable { path: "standard output".into(), reason }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines are broken at spaces, those after a break begin where the first did, and a long path stays whole.
    #[test]
    fn lines_fit() {
        assert_eq!(set_line("  one two three", 0, 9), "  one two\n  three");
        assert_eq!(set_line("one two", 4, 7), "one two");
        assert_eq!(set_line("one two three", 3, 8), "one two\n   three");
        assert_eq!(set_line("in /a/long/path/that/stays whole", 0, 10), "in\n/a/long/path/that/stays\nwhole");
        assert_eq!(set_line("", 4, 10), "");
        let row = "stage  met  phase margin  57 deg  0.50 m/s, opened at speed";
        let broken = "stage  met  phase margin  57 deg\n              0.50 m/s, opened at speed";
        assert_eq!(set_line(row, 7, 45), broken);
    }
}
