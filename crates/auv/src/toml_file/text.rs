//! Reads a text file, or reports what the path is instead.

use std::io::ErrorKind;
use std::path::Path;

use super::error::{FileError, FileProblem};

const UTF16_MARKS: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];
const UTF8_MARK: char = '\u{feff}';

/// Reads a text in UTF-8; the byte order mark that some editors put before it is removed.
///
/// # Errors
/// [`FileError`]: no such file, a folder, a broken link, another encoding.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let file = path.display().to_string();
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(source) => return Err(FileError::one(file, None, unreadable(path, source))),
    };
    let encoded = |line, found| FileError::one(file.clone(), line, FileProblem::Encoding { found });
    if UTF16_MARKS.iter().any(|mark| bytes.starts_with(mark)) || bytes.contains(&0) {
        return Err(encoded(None, "UTF-16, or no text at all".into()));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = line_of(error.as_bytes(), at);
        encoded(Some(line), format!("Latin-1 or the like (it holds the byte {:#04X})", error.as_bytes()[at]))
    })?;
    Ok(text.strip_prefix(UTF8_MARK).map(str::to_owned).unwrap_or(text))
}

/// The line, counted from 1, of a byte offset.
pub(super) fn line_of(text: &[u8], at: usize) -> usize {
    text.iter().take(at).filter(|&&byte| byte == b'\n').count() + 1
}

fn unreadable(path: &Path, source: std::io::Error) -> FileProblem {
    if path.is_dir() {
        FileProblem::Folder
    } else if path.is_symlink() && !path.exists() {
        FileProblem::Link
    } else if source.kind() == ErrorKind::NotFound {
        FileProblem::NotFound
    } else {
        FileProblem::Unreadable { source }
    }
}
