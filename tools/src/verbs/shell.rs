//! `squid completions` and `squid man`: output that clap generates from the command line.

use crate::cli::Cli;
use crate::error::Error;
use crate::output::{answer, say, say_unwrapped};
use clap::CommandFactory;
use clap_complete::{Shell, generate};
use serde_json::json;
use squid_base::files;
use std::path::Path;

/// Prints the completions for a shell.
///
/// # Errors
/// Errors of the output only.
pub fn completions(shell: Shell) -> Result<(), Error> {
    let mut script = Vec::new();
    generate(shell, &mut Cli::command(), "squid", &mut script);
    let script = String::from_utf8_lossy(&script);
    say_unwrapped(script.trim_end());
    Ok(answer(&json!({ "script": script }))?)
}

/// Writes a manual page for the command and for each verb.
///
/// # Errors
/// Errors of the directory.
pub fn man(directory: &Path) -> Result<(), Error> {
    let unwritable = |reason| files::Error::Unwritable { path: directory.display().to_string(), reason };
    std::fs::create_dir_all(directory).map_err(unwritable)?;
    clap_mangen::generate_to(Cli::command(), directory).map_err(unwritable)?;
    say(&format!("{0}/squid.1 and a page for each verb; man {0}/squid.1", directory.display()));
    Ok(answer(&json!({ "directory": directory }))?)
}
