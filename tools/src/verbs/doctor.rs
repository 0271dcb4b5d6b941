//! `squid doctor`: what this machine has of what squid needs.

use crate::error::Error;
use crate::output::{answer, say};
use serde_json::json;
use squid_package::fmu::Binaries;
use squid_package::platform::Platform;
use std::process::Command;

/// A program that some work needs.
struct Tool {
    /// Names under which it may be found, and what makes each print its version.
    names: &'static [&'static str],
    version: &'static [&'static str],
    needed_for: &'static str,
    /// Whether `run.py fly` fails without it.
    required: bool,
    remedy: &'static str,
}

const TOOLS: [Tool; 8] = [
    Tool {
        names: &["cargo"],
        version: &["--version"],
        needed_for: "building everything",
        required: true,
        remedy: "install Rust from https://rustup.rs",
    },
    Tool {
        names: &["cc", "gcc", "clang"],
        version: &["--version"],
        needed_for: "linking",
        required: true,
        remedy: "apt install gcc libc6-dev",
    },
    Tool {
        names: &["python3"],
        version: &["--version"],
        needed_for: "run.py; 3.10 or later, 3.11 for the tests",
        required: true,
        remedy: "apt install python3",
    },
    Tool {
        names: &["python3"],
        version: &["-c", "import venv, ensurepip, sys; print('venv of', sys.version.split()[0])"],
        needed_for: "flights by FMPy, tests; pip does as well",
        required: false,
        remedy: "apt install python3-venv",
    },
    Tool {
        names: &["valgrind"],
        version: &["--version"],
        needed_for: "tests of the FMUs' memory",
        required: false,
        remedy: "apt install valgrind libc6-dbg",
    },
    Tool {
        names: &["wine64", "/usr/lib/wine/wine64"],
        version: &["--version"],
        needed_for: "tests of the FMUs for Windows",
        required: false,
        remedy: "apt install wine64",
    },
    Tool {
        names: &["qemu-aarch64"],
        version: &["--version"],
        needed_for: "tests of the FMUs for 64-bit ARM",
        required: false,
        remedy: "apt install qemu-user libc6-arm64-cross",
    },
    Tool {
        names: &["chromium", "chromium-browser", "google-chrome"],
        version: &["--version"],
        needed_for: "tests of the report's pages",
        required: false,
        remedy: "apt install chromium",
    },
];

/// Prints what is there and what is missing.
///
/// # Errors
/// [`Error::Missing`] where something is missing without which no FMU can be made.
pub fn run() -> Result<(), Error> {
    let (mut missing, mut rows) = (Vec::new(), Vec::new());
    for tool in &TOOLS {
        let found = tool.names.iter().find_map(|name| version(name, tool.version));
        let (mark, words) = match &found {
            Some(version) => ("found", version.clone()),
            None => ("MISSING", tool.remedy.to_owned()),
        };
        say(&format!("{mark:<8} {:<12} {words}  ({})", tool.names[0], tool.needed_for));
        rows.push(json!({
            "name": tool.names[0], "found": found, "needed_for": tool.needed_for, "remedy": tool.remedy,
        }));
        missing.extend((found.is_none() && tool.required).then_some(tool.names[0]));
    }
    let host = Platform::named(&["host".to_owned()]).map(|platforms| Binaries { platforms, directory: None });
    let libraries = host.and_then(|binaries| binaries.find()).is_ok();
    say(match libraries {
        true => "found    libraries    the compiled FMUs of this platform  (squid package)",
        false => "MISSING  libraries    python3 run.py fly builds them  (squid package)",
    });
    answer(&json!({ "programs": rows, "libraries": libraries }))?;
    match missing.is_empty() {
        true => Ok(()),
        false => Err(Error::Missing { programs: missing.join(", ") }),
    }
}

/// The first line that a program prints of its version; `None` where it does not run.
fn version(name: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(name).args(arguments).output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Some(text.lines().next().unwrap_or_default().to_owned())
}
