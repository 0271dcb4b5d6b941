//! A text to read, with the name that messages give it.

use crate::error::Error;
use base::files;
use std::path::Path;

/// A text and its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The name in messages, of a file or a function.
    pub name: String,
    /// What is read.
    pub text: String,
}

impl Source {
    /// That of a file.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Ok(Self { name: path.display().to_string(), text: files::read(path)? })
    }
}
