//! `squid doctor`: checks this machine for what squid needs.

use crate::error::Error;
use crate::output::{answer, say};
use serde_json::json;
use squid_package::fmu::Binaries;
use squid_package::platform::Platform;
use std::process::Command;

/// A program that squid or its tests need.
struct Tool {
    /// Alternative names of the program; `version` holds the arguments that print its version.
    names: &'static [Text],
    version: &'static [Text],
    needed_for: Text,
    /// `true` if `run.py fly` fails without the program.
    required: bool,
    remedy: Text,
}

type Text = &'static str;

impl Tool {
    /// Returns a program without which `run.py fly` fails.
    const fn required(names: &'static [Text], needed_for: Text, remedy: Text) -> Self {
        Self { names, version: &["--version"], needed_for, required: true, remedy }
    }

    /// Returns a program without which some tests or simulations are skipped.
    const fn optional(names: &'static [Text], needed_for: Text, remedy: Text) -> Self {
        Self { required: false, ..Self::required(names, needed_for, remedy) }
    }
}

const TOOLS: [Tool; 8] = [
    Tool::required(&["cargo"], "building squid", "install Rust from https://rustup.rs"),
    Tool::required(&["cc", "gcc", "clang"], "linking", "apt install gcc libc6-dev"),
    Tool::required(&["python3"], "run.py; 3.10 or later, 3.11 for the tests", "apt install python3"),
    Tool {
        version: &["-c", "import venv, ensurepip, sys; print('venv of', sys.version.split()[0])"],
        ..Tool::optional(
            &["python3"],
            "simulations by FMPy, tests; pip also works",
            "apt install python3-venv",
        )
    },
    Tool::optional(&["valgrind"], "memory tests of the FMUs", "apt install valgrind libc6-dbg"),
    Tool::optional(
        &["wine64", "/usr/lib/wine/wine64"],
        "tests of the FMUs for Windows",
        "apt install wine64",
    ),
    Tool::optional(
        &["qemu-aarch64"],
        "tests of the FMUs for 64-bit ARM",
        "apt install qemu-user libc6-arm64-cross",
    ),
    Tool::optional(
        &["chromium", "chromium-browser", "google-chrome"],
        "tests of the report pages",
        "apt install chromium",
    ),
];

/// Prints which programs are found and which are missing.
///
/// # Errors
/// [`Error::Missing`] if a program is missing without which no FMU can be built.
pub fn run() -> Result<(), Error> {
    let (mut missing, mut rows) = (Vec::new(), Vec::new());
    for tool in &TOOLS {
        let found = tool.names.iter().find_map(|name| version(name, tool.version));
        let (mark, text) = match &found {
            Some(version) => ("found", version.clone()),
            None => ("MISSING", tool.remedy.to_owned()),
        };
        say(&format!("{mark:<8} {:<12} {text}  ({})", tool.names[0], tool.needed_for));
        rows.push(json!({
            "name": tool.names[0], "found": found, "needed_for": tool.needed_for, "remedy": tool.remedy,
        }));
        missing.extend((found.is_none() && tool.required).then_some(tool.names[0]));
    }
    let host = Platform::named(&["host".to_owned()]).map(|platforms| Binaries { platforms, directory: None });
    let libraries = host.and_then(|binaries| binaries.find()).is_ok();
    say(if libraries {
        "found    libraries    the compiled FMUs of this platform  (squid package)"
    } else {
        "MISSING  libraries    python3 run.py fly builds them  (squid package)"
    });
    answer(&json!({ "programs": rows, "libraries": libraries }))?;
    if missing.is_empty() { Ok(()) } else { Err(Error::Missing { programs: missing.join(", ") }) }
}

/// Returns the first line of a program's version output; `None` if the program does not run.
fn version(name: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(name).args(arguments).output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Some(text.lines().next().unwrap_or_default().to_owned())
}
