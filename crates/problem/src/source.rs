//! A text with its name in messages.

use crate::error::Error;
use base::files;
use std::path::Path;

/// A text and its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The name of a file or a function, for messages.
    pub name: String,
    /// The text.
    pub text: String,
}

impl Source {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Ok(Self { name: path.display().to_string(), text: files::read(path)? })
    }
}
