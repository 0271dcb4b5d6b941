//! Writing files whole or not at all.

use crate::error::Error;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Prints to standard output. A reader that went away, as `head` does, is no reason to stop working.
pub fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{text}").and_then(|()| out.flush());
}

/// Writes a file through a temporary one beside it, renamed at the end.
///
/// # Errors
/// [`Error::Unwritable`] with the path; nothing is then left behind.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let attempt = || -> std::io::Result<()> {
        let folder = path.parent().unwrap_or_else(|| Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut file = tempfile::Builder::new().prefix(".squid-").tempfile_in(folder)?;
        file.write_all(bytes)?;
        readable(file.as_file())?;
        file.persist(path)?;
        Ok(())
    };
    attempt().map_err(|reason| Error::Unwritable { path: path.display().to_string(), reason })
}

/// Temporary files are private; what is handed out may be read by all.
#[cfg(unix)]
fn readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

/// A number with so many decimals, and 0 rather than -0.
pub fn decimals(v: f64, digits: usize) -> String {
    let text = format!("{v:.digits$}");
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if is_zero { text.trim_start_matches('-').into() } else { text }
}

/// A bound from above for people: rounded up, so that what is said is true, too.
pub fn above(bound: f64) -> String {
    const DECIMALS: f64 = 1e4;
    let up = (bound * DECIMALS).ceil() / DECIMALS;
    format!("{:.4}", if up.is_finite() { up } else { bound })
}

/// A value as one line of JSON.
///
/// # Errors
/// [`Error::Json`].
pub fn json(value: &impl Serialize) -> Result<String, Error> {
    serde_json::to_string(value).map_err(|reason| Error::Json { path: "standard output".into(), reason })
}

/// Writes a value as JSON.
///
/// # Errors
/// [`Error::Unwritable`], [`Error::Json`].
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Error> {
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|reason| Error::Json { path: path.display().to_string(), reason })?;
    text.push('\n');
    write(path, text.as_bytes())
}

/// Removes a file, if it is there.
///
/// # Errors
/// [`Error::Unwritable`] with the path.
pub fn remove(path: &Path) -> Result<(), Error> {
    match std::fs::remove_file(path) {
        Err(reason) if reason.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::Unwritable { path: path.display().to_string(), reason })
        }
        _ => Ok(()),
    }
}

/// Reads a text file.
///
/// # Errors
/// [`Error::File`] with the path.
pub fn read(path: &Path) -> Result<String, Error> {
    Ok(auv::read_text(path)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        let shown = [-0.00004, -0.0, 0.0, -0.00006, -12.5].map(|v| decimals(v, 4));
        assert_eq!(shown, ["0.0000", "0.0000", "0.0000", "-0.0001", "-12.5000"]);
        assert_eq!(decimals(f64::NAN, 1), "NaN");
    }
}
