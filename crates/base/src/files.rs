//! Reading of text files, and atomic writing of files.

use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use strum::IntoStaticStr;
use tempfile::TempPath;
use thiserror::Error as ThisError;

/// Reason why a file cannot be read or written.
#[derive(Debug, ThisError, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Error {
    /// The file cannot be read.
    #[error("{path}: cannot be read: {reason}")]
    Unreadable { path: String, reason: io::Error },
    /// There is no such file.
    #[error("{path}: file not found")]
    NotFound { path: String },
    /// The path is a directory.
    #[error("{path}: this is a directory; it must be a file")]
    Folder { path: String },
    /// A symbolic link that is broken or cyclic.
    #[error(
        "{path}: this is a symbolic link without a target, or in a cycle; it must be a file, or a link to one"
    )]
    Link { path: String },
    /// A pipe, a device or a socket, whose content may be endless.
    #[error("{path}: this is a pipe or a device; it must be a file")]
    Special { path: String },
    /// A file above the size limit.
    #[error("{path}: the file is larger than {} MB, the largest size that is read", LARGEST >> 20)]
    Large { path: String },
    /// Text that is not UTF-8; `place` is the file, with the line if that is known.
    #[error("{place}: the text is {found}; save the file as UTF-8")]
    Encoding { place: String, found: String },
    /// The file cannot be written.
    #[error("{path}: cannot be written: {reason}")]
    Unwritable { path: String, reason: io::Error },
    /// Failure to write or read JSON.
    #[error("{path}: {reason}")]
    Json { path: String, reason: serde_json::Error },
}

const UTF16_MARKS: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];
const UTF8_MARK: char = '\u{feff}';

/// Size limit of a file that is read, in bytes.
const LARGEST: u64 = 256 << 20;

/// Opens a file from an untrusted source.
///
/// # Errors
/// No such file, a directory, a broken link, a pipe or device, more than 256 MB.
pub fn open(path: &Path) -> Result<File, Error> {
    let found = std::fs::metadata(path).map_err(|reason| unreadable(path, reason))?;
    let file = || path.display().to_string();
    if found.is_dir() {
        Err(Error::Folder { path: file() })
    } else if !found.is_file() {
        Err(Error::Special { path: file() })
    } else if found.len() > LARGEST {
        Err(Error::Large { path: file() })
    } else {
        File::open(path).map_err(|reason| unreadable(path, reason))
    }
}

/// Reads a file from an untrusted source.
///
/// # Errors
/// All those of [`open`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = vec![];
    // Files of /proc and /sys report no size, so the length is limited here.
    let read = open(path)?.take(LARGEST + 1).read_to_end(&mut bytes);
    read.map_err(|reason| unreadable(path, reason))?;
    if bytes.len() as u64 > LARGEST {
        return Err(Error::Large { path: path.display().to_string() });
    }
    Ok(bytes)
}

/// Reads UTF-8 text without its byte order mark.
///
/// # Errors
/// All those of [`open`]; another encoding.
pub fn read(path: &Path) -> Result<String, Error> {
    let bytes = read_bytes(path)?;
    let file = path.display();
    let encoded = |place: String, found| Error::Encoding { place, found };
    if UTF16_MARKS.iter().any(|mark| bytes.starts_with(mark)) || bytes.contains(&0) {
        return Err(encoded(file.to_string(), "UTF-16, or binary".into()));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let (at, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        let line = bytes[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        let found = format!("in another encoding, such as Latin-1 (it contains the byte {:#04X})", bytes[at]);
        encoded(format!("{file}:{line}"), found)
    })?;
    Ok(text.strip_prefix(UTF8_MARK).map(str::to_owned).unwrap_or(text))
}

fn unreadable(path: &Path, reason: io::Error) -> Error {
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

/// Checks in advance that files can be written to a directory, without creating it.
///
/// # Errors
/// [`Error::Unwritable`].
pub fn check_directory(directory: &Path) -> Result<(), Error> {
    let there = |p: &&Path| p.symlink_metadata().is_ok();
    let nearest = directory.ancestors().find(there).unwrap_or(Path::new("."));
    let attempt = if nearest.exists() && !nearest.is_dir() {
        Err(io::Error::new(ErrorKind::NotADirectory, "this is a file; it must be a directory"))
    } else {
        tempfile::tempfile_in(nearest).map(|_| ())
    };
    attempt.map_err(|reason| unwritable(nearest, reason))
}

fn unwritable(path: &Path, reason: io::Error) -> Error {
    Error::Unwritable { path: path.display().to_string(), reason }
}

/// Writes a file by renaming a temporary one in the same directory; devices and pipes are written directly.
///
/// # Errors
/// [`Error::Unwritable`] with the path; no file is left behind then.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let special = std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    let attempt = if special {
        OpenOptions::new().write(true).open(path).and_then(|mut device| device.write_all(bytes))
    } else {
        temporary(path, bytes).and_then(|file| Ok(file.persist(path)?))
    };
    attempt.map_err(|reason| unwritable(path, reason))
}

/// Returns a temporary file in the directory of `path`, synced to disk with all bytes; dropping it removes it.
fn temporary(path: &Path, bytes: &[u8]) -> io::Result<TempPath> {
    if path.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "this is a directory; it must be a file"));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::Builder::new().prefix(".squid-").tempfile_in(folder)?;
    // Not by `file` itself, whose errors name the temporary path.
    file.as_file_mut().write_all(bytes)?;
    make_readable(file.as_file())?;
    // Some file systems report a full disk only here.
    file.as_file().sync_all()?;
    Ok(file.into_temp_path())
}

/// Makes a file readable for all: temporary files are private.
#[cfg(unix)]
fn make_readable(file: &File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &File) -> io::Result<()> {
    Ok(())
}

/// Set of files in one directory: all are written, or none.
///
/// The last file is removed first and written last: where it exists, all files are of the same set, even after a loss
/// of power.
#[derive(Debug, Default)]
pub struct Files(Vec<(PathBuf, Option<Vec<u8>>)>);

impl Files {
    /// Adds a file to write.
    pub fn add(&mut self, path: PathBuf, bytes: impl Into<Vec<u8>>) {
        self.0.push((path, Some(bytes.into())));
    }

    /// Adds a value to write as JSON.
    ///
    /// # Errors
    /// [`Error::Json`].
    pub fn add_json(&mut self, path: PathBuf, value: &impl Serialize) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|reason| Error::Json { path: path.display().to_string(), reason })?;
        self.add(path, text + "\n");
        Ok(())
    }

    /// Adds a file of an earlier set to remove.
    pub fn remove(&mut self, path: PathBuf) {
        self.0.push((path, None));
    }

    /// Writes the set under an exclusive lock of the directory.
    ///
    /// # Errors
    /// [`Error::Unwritable`] with the path; if the disk is full or a file cannot be created, the earlier set is
    /// untouched, and folders and lock that were created for the set are removed again.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let parents = self.0.iter().filter_map(|(path, _)| path.parent());
        let folders: Vec<_> = parents.chain([directory]).flat_map(missing_folders).collect();
        let lock = directory.join(LOCK);
        let was_locked_before = lock.exists();
        let held = lock_to_write(directory).map_err(|reason| unwritable(directory, reason));
        let outcome = held.and_then(|_held| {
            let written = self.write();
            if written.is_err() && !was_locked_before {
                let _ = std::fs::remove_file(&lock);
            }
            written
        });
        if outcome.is_err() {
            // The deepest first; a folder that is not empty stays.
            let mut folders = folders;
            folders.sort_by_key(|folder| std::cmp::Reverse(folder.components().count()));
            folders.iter().for_each(|folder| _ = std::fs::remove_dir(folder));
        }
        outcome
    }

    /// Writes the set in a locked directory.
    fn write(&self) -> Result<(), Error> {
        let mut staged = Vec::new();
        for (path, bytes) in &self.0 {
            let file = bytes.as_ref().map(|bytes| temporary(path, bytes)).transpose();
            staged.push((path, file.map_err(|reason| unwritable(path, reason))?));
        }
        if let Some((last, _)) = staged.last() {
            remove(last)?;
        }
        for (path, file) in staged {
            match file {
                Some(file) => file.persist(path).map_err(|failed| unwritable(path, failed.error))?,
                None => remove(path)?,
            }
        }
        Ok(())
    }
}

/// Returns a folder and those above it, as far as they do not exist.
fn missing_folders(folder: &Path) -> impl Iterator<Item = PathBuf> + '_ {
    folder.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.exists()).map(Path::to_owned)
}

/// Name of the lock file. It is removed only while it is locked for writing; whoever waited for that lock takes a new
/// one, because a lock on a deleted file excludes nobody.
const LOCK: &str = ".squid-lock";

/// Creates a directory, and locks it for writing until the guard is dropped.
fn lock_to_write(directory: &Path) -> io::Result<File> {
    let lock = || std::fs::create_dir_all(directory).and_then(|()| lock_directory(directory, File::lock));
    // Whoever created the directory may just have removed it.
    lock().or_else(|reason| if reason.kind() == ErrorKind::NotFound { lock() } else { Err(reason) })
}

/// Locks a directory until the guard is dropped; has no effect on a file system without locks.
fn lock_directory(directory: &Path, lock: fn(&File) -> io::Result<()>) -> io::Result<File> {
    let path = directory.join(LOCK);
    let held = || {
        let created = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let file = created.or_else(|reason| File::open(&path).map_err(|_| reason))?;
        let _ = lock(&file);
        Ok(file)
    };
    for _ in 1..MOST_LOCKS {
        let file = held()?;
        if is_file_at(&file, &path) {
            return Ok(file);
        }
    }
    held()
}

/// Largest number of locks that are removed while one waits for them, on a file system that identifies files.
const MOST_LOCKS: usize = 100;

/// Returns `true` if an open file is the one at a path, which may have been removed meanwhile.
#[cfg(unix)]
fn is_file_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |found: std::fs::Metadata| (found.dev(), found.ino());
    file.metadata().ok().map(identity) == std::fs::metadata(path).ok().map(identity)
}

#[cfg(not(unix))]
fn is_file_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Locks a set of files, named by its last one, for reading until the guard is dropped. A read-only directory is not
/// locked, because its files cannot change.
pub fn reading(last: &Path) -> Option<File> {
    let directory = last.parent()?;
    // While a set is being written, its last file is absent for a moment, but the lock exists.
    let there = last.is_file() || directory.join(LOCK).is_file();
    there.then(|| lock_directory(directory, File::lock_shared).ok()).flatten()
}

/// Removes a file, if it exists.
fn remove(path: &Path) -> Result<(), Error> {
    match std::fs::remove_file(path) {
        Err(reason) if reason.kind() != ErrorKind::NotFound => Err(unwritable(path, reason)),
        _ => Ok(()),
    }
}
