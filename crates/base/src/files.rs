//! Files: read as text, and written whole or not at all.

mod error;
mod text;

pub use error::Error;
pub use text::read;

use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// Checks, before the work for it, that files can be written to a directory; it need not exist yet, and is not made.
///
/// # Errors
/// [`Error::Unwritable`].
pub fn check_directory(directory: &Path) -> Result<(), Error> {
    let there = |p: &&Path| p.symlink_metadata().is_ok();
    let nearest = directory.ancestors().find(there).unwrap_or(Path::new("."));
    let attempt = if nearest.exists() && !nearest.is_dir() {
        Err(io::Error::new(ErrorKind::NotADirectory, "it is a file, and a directory is needed here"))
    } else {
        tempfile::tempfile_in(nearest).map(|_| ())
    };
    attempt.map_err(|reason| unwritable(nearest, reason))
}

fn unwritable(path: &Path, reason: io::Error) -> Error {
    Error::Unwritable { path: path.display().to_string(), reason }
}

/// Writes a file through a temporary one beside it, renamed at the end; devices and pipes are written directly.
///
/// # Errors
/// [`Error::Unwritable`] with the path; nothing is then left behind.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let special = std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    let attempt = if special {
        OpenOptions::new().write(true).open(path).and_then(|mut device| device.write_all(bytes))
    } else {
        temporary(path, bytes).and_then(|file| Ok(file.persist(path)?))
    };
    attempt.map_err(|reason| unwritable(path, reason))
}

/// A file under another name beside the one that it is for, on the disk with all its bytes; gone when dropped.
fn temporary(path: &Path, bytes: &[u8]) -> io::Result<TempPath> {
    if path.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "it is a directory, and a file is needed here"));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::Builder::new().prefix(".squid-").tempfile_in(folder)?;
    file.write_all(bytes)?;
    readable(file.as_file())?;
    // Some file systems say no sooner than this that they are full.
    file.as_file().sync_all()?;
    Ok(file.into_temp_path())
}

/// Temporary files are private; what is handed out may be read by all.
#[cfg(unix)]
fn readable(file: &File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_: &File) -> io::Result<()> {
    Ok(())
}

/// Files of one directory that belong together: all of them are written, or none.
///
/// The last one is removed first and written last: where it exists, all files are of the same set, even after a loss
/// of power.
#[derive(Debug, Default)]
pub struct Files(Vec<(PathBuf, Option<Vec<u8>>)>);

impl Files {
    /// A file to be written.
    pub fn add(&mut self, path: PathBuf, bytes: impl Into<Vec<u8>>) {
        self.0.push((path, Some(bytes.into())));
    }

    /// A value to be written as JSON.
    ///
    /// # Errors
    /// [`Error::Json`].
    pub fn add_json(&mut self, path: PathBuf, value: &impl Serialize) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|reason| Error::Json { path: path.display().to_string(), reason })?;
        self.add(path, text + "\n");
        Ok(())
    }

    /// A file of an earlier set to be removed.
    pub fn remove(&mut self, path: PathBuf) {
        self.0.push((path, None));
    }

    /// Writes all of them, while nobody else writes to the directory or reads a set there.
    ///
    /// # Errors
    /// [`Error::Unwritable`] with the path; where a disk is full or a file cannot be made, all is as it was.
    pub fn save(&self, directory: &Path) -> Result<(), Error> {
        let held = std::fs::create_dir_all(directory).and_then(|()| hold(directory, File::lock));
        let _held = held.map_err(|reason| unwritable(directory, reason))?;
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

/// The file that is locked. It is never removed, because a lock on a file being removed excludes nobody.
const LOCK: &str = ".squid-lock";

/// Locks a directory until the guard is dropped. A file system without locks excludes nobody.
fn hold(directory: &Path, lock: fn(&File) -> io::Result<()>) -> io::Result<File> {
    let path = directory.join(LOCK);
    let made = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
    let file = made.or_else(|reason| File::open(&path).map_err(|_| reason))?;
    let _ = lock(&file);
    Ok(file)
}

/// Locks a set of files, named by its last one, for reading until the guard is dropped. A directory that cannot be
/// written to is not locked, because its files cannot change.
pub fn reading(last: &Path) -> Option<File> {
    let directory = last.parent()?;
    // While a set is being written, its last file is not there for a moment, but the lock is.
    let there = last.is_file() || directory.join(LOCK).is_file();
    there.then(|| hold(directory, File::lock_shared).ok()).flatten()
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<(), Error> {
    match std::fs::remove_file(path) {
        Err(reason) if reason.kind() != ErrorKind::NotFound => Err(unwritable(path, reason)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_checked_and_not_made() {
        let folder = tempfile::tempdir().unwrap();
        let (file, deep) = (folder.path().join("file"), folder.path().join("a").join("b"));
        std::fs::write(&file, "mine").unwrap();
        check_directory(&deep).unwrap();
        check_directory(Path::new("")).unwrap();
        assert!(!deep.parent().unwrap().exists());
        for wrong in [file.clone(), file.join("deeper")] {
            let message = check_directory(&wrong).unwrap_err().to_string();
            assert_eq!(
                message,
                format!(
                    "{}: cannot be written: it is a file, and a directory is needed here",
                    file.display()
                )
            );
        }
    }

    #[test]
    fn a_set_is_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let to = |name: &str| folder.path().join(name);
        let set = |first: &str| {
            let mut files = Files::default();
            files.add(to("a"), first);
            files.remove(to("b"));
            files.add(to("c/d"), "2");
            files
        };
        std::fs::write(to("a"), "0").unwrap();
        std::fs::write(to("b"), "0").unwrap();
        std::fs::create_dir_all(to("c/d")).unwrap();
        let message = set("1").save(folder.path()).unwrap_err().to_string();
        assert!(message.contains("it is a directory, and a file is needed here"), "{message}");
        assert_eq!((read(&to("a")).unwrap().as_str(), read(&to("b")).unwrap().as_str()), ("0", "0"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4, "a, b, c and the lock");
        std::fs::remove_dir(to("c/d")).unwrap();
        set("1").save(folder.path()).unwrap();
        assert_eq!((read(&to("a")).unwrap().as_str(), read(&to("c/d")).unwrap().as_str()), ("1", "2"));
        assert!(!to("b").exists());
    }
}
