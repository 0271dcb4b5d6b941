//! Flags of the linker.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let cfg = |name: &str| std::env::var(format!("CARGO_CFG_TARGET_{name}")).unwrap_or_default();
    let flag = match (cfg("OS").as_str(), cfg("ENV").as_str()) {
        // The BLAS that Clarabel calls is the one inside: another one in Python's process, of SciPy say, may not take
        // its place.
        ("linux", _) => "-Wl,-Bsymbolic".to_owned(),
        // Zig's linker exports whatever it finds, unless it is told what.
        ("windows", "gnu") => exports(),
        _ => return,
    };
    println!("cargo::rustc-cdylib-link-arg={flag}");
}

/// Writes what the library exports, and returns the path of the file.
fn exports() -> String {
    let folder = std::env::var("OUT_DIR").unwrap_or_default();
    let file = Path::new(&folder).join("exports.def");
    if let Err(error) = std::fs::write(&file, "EXPORTS\n    PyInit__core\n") {
        println!("cargo::error={}: {error}", file.display());
    }
    file.display().to_string()
}
