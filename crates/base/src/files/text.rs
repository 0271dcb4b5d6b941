//! Reads a text file, or reports what the path is instead.

use crate::files::error::Error;
use std::io::ErrorKind;
use std::path::Path;

const UTF16_MARKS: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];
const UTF8_MARK: char = '\u{feff}';

/// Reads a text in UTF-8; the byte order mark that some editors put before it is removed.
///
/// # Errors
/// No such file, a folder, a broken link, another encoding.
pub fn read(path: &Path) -> Result<String, Error> {
    let bytes = std::fs::read(path).map_err(|reason| unreadable(path, reason))?;
    let file = path.display();
    let encoded = |place: String, found| Error::Encoding { place, found };
    if UTF16_MARKS.iter().any(|mark| bytes.starts_with(mark)) || bytes.contains(&0) {
        return Err(encoded(file.to_string(), "UTF-16, or no text at all".into()));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let (at, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        let line = bytes[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        let found = format!("Latin-1 or the like (it holds the byte {:#04X})", bytes[at]);
        encoded(format!("{file}:{line}"), found)
    })?;
    Ok(text.strip_prefix(UTF8_MARK).map(str::to_owned).unwrap_or(text))
}

fn unreadable(path: &Path, reason: std::io::Error) -> Error {
    let file = path.display().to_string();
    if path.is_dir() {
        Error::Folder { path: file }
    } else if path.is_symlink() && !path.exists() {
        Error::Link { path: file }
    } else if reason.kind() == ErrorKind::NotFound {
        Error::NotFound { path: file }
    } else {
        Error::Unreadable { path: file, reason }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each says what stands there and what to do; none has a line 0.
    #[test]
    fn files_that_are_no_text() {
        let folder = tempfile::tempdir().unwrap();
        let to = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(to("folder")).unwrap();
        let message = |name: &str| {
            let words = read(&to(name)).unwrap_err().to_string();
            words.strip_prefix(folder.path().to_str().unwrap()).unwrap()[1..].to_owned()
        };
        assert_eq!(message("none"), "none: there is no such file");
        assert_eq!(message("folder"), "folder: this is a folder; it must be a file");
        let utf16: Vec<u8> = "\u{feff}[vehicle]".encode_utf16().flat_map(u16::to_le_bytes).collect();
        std::fs::write(to("utf16"), utf16).unwrap();
        assert_eq!(
            message("utf16"),
            "utf16: the text is not UTF-8 but UTF-16, or no text at all; save the file as UTF-8"
        );
        std::fs::write(to("latin1"), b"[vehicle]\nname = \"caf\xe9\"\n").unwrap();
        assert!(
            message("latin1").starts_with(
                "latin1:2: the text is not UTF-8 but Latin-1 or the like (it holds the byte 0xE9)"
            )
        );
        std::fs::write(to("marked"), "\u{feff}text").unwrap();
        assert_eq!(read(&to("marked")).unwrap(), "text");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("loop", to("loop")).unwrap();
            assert!(
                message("loop").starts_with("loop: this is a link that leads to no file, or back to itself;")
            );
        }
    }
}
