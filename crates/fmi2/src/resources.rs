//! The files of `resources/`, in memory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Named files, sorted by name; names use `/` between folders.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Resources {
    files: BTreeMap<String, Vec<u8>>,
}

/// Reason for which a resource cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum ResourceError {
    /// A folder or file that cannot be read.
    #[error("'{}' cannot be read: {source}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    /// A file name that is not Unicode, and so has no unique byte representation in the GUID.
    #[error("the name of '{}' is not Unicode", path.display())]
    NameNotUnicode { path: PathBuf },
    /// A missing file.
    #[error("resources/{name} is missing")]
    Missing { name: String },
    /// A text file that is not UTF-8.
    #[error("resources/{name} is not UTF-8 (from byte {valid_up_to})")]
    NotText { name: String, valid_up_to: usize },
}

impl Resources {
    /// Reads a folder with all its subfolders; names that start with a dot are skipped.
    ///
    /// # Errors
    /// [`ResourceError::Unreadable`], [`ResourceError::NameNotUnicode`].
    pub fn from_folder(folder: &Path) -> Result<Self, ResourceError> {
        let mut resources = Self::default();
        resources.collect(folder, "")?;
        Ok(resources)
    }

    fn collect(&mut self, folder: &Path, prefix: &str) -> Result<(), ResourceError> {
        let unreadable = |path: &Path| {
            let path = path.to_owned();
            move |source| ResourceError::Unreadable { path, source }
        };
        for entry in fs::read_dir(folder).map_err(unreadable(folder))? {
            let path = entry.map_err(unreadable(folder))?.path();
            let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
                return Err(ResourceError::NameNotUnicode { path });
            };
            let name = format!("{prefix}{name}");
            if name.rsplit('/').next().is_some_and(|last| last.starts_with('.')) {
                continue;
            }
            if path.is_dir() {
                self.collect(&path, &format!("{name}/"))?;
            } else {
                let bytes = fs::read(&path).map_err(unreadable(&path))?;
                self.files.insert(name, bytes);
            }
        }
        Ok(())
    }

    /// Adds or replaces a file.
    pub fn insert(&mut self, name: &str, bytes: impl Into<Vec<u8>>) {
        self.files.insert(name.to_owned(), bytes.into());
    }

    /// Iterates over the files, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// Returns a file as bytes.
    ///
    /// # Errors
    /// [`ResourceError::Missing`].
    pub fn bytes(&self, name: &str) -> Result<&[u8], ResourceError> {
        let bytes = self.files.get(name).map(Vec::as_slice);
        bytes.ok_or_else(|| ResourceError::Missing { name: name.to_owned() })
    }

    /// Returns a file as text.
    ///
    /// # Errors
    /// [`ResourceError::Missing`], [`ResourceError::NotText`].
    pub fn text(&self, name: &str) -> Result<&str, ResourceError> {
        std::str::from_utf8(self.bytes(name)?).map_err(|error| ResourceError::NotText {
            name: name.to_owned(),
            valid_up_to: error.valid_up_to(),
        })
    }
}

impl<N: AsRef<str>, B: Into<Vec<u8>>> FromIterator<(N, B)> for Resources {
    fn from_iter<I: IntoIterator<Item = (N, B)>>(files: I) -> Self {
        let own = |(name, bytes): (N, B)| (name.as_ref().to_owned(), bytes.into());
        Self { files: files.into_iter().map(own).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_a_folder_sorted_and_without_hidden_files() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("sub")).unwrap();
        for name in ["b.json", "a.json", ".DS_Store", "sub/c.bin"] {
            fs::write(folder.path().join(name), name).unwrap();
        }
        let resources = Resources::from_folder(folder.path()).unwrap();
        let names: Vec<_> = resources.iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["a.json", "b.json", "sub/c.bin"]);
        assert_eq!(resources.text("a.json").unwrap(), "a.json");
        assert!(matches!(resources.text("d.json"), Err(ResourceError::Missing { .. })));
    }

    #[test]
    fn reports_the_first_byte_that_is_not_utf8() {
        let resources: Resources = [("a", vec![b'x', 0xff])].into_iter().collect();
        assert!(matches!(resources.text("a"), Err(ResourceError::NotText { valid_up_to: 1, .. })));
    }
}
