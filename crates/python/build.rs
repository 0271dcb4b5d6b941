//! Linker flags.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let cfg = |name: &str| std::env::var(format!("CARGO_CFG_TARGET_{name}")).unwrap_or_default();
    let flag = match (cfg("OS").as_str(), cfg("ENV").as_str()) {
        // Binds Clarabel to its own BLAS rather than to another one in Python's process, such as SciPy's.
        ("linux", _) => "-Wl,-Bsymbolic".to_owned(),
        // Zig's linker exports every symbol unless given a list.
        ("windows", "gnu") => exports(),
        _ => return,
    };
    println!("cargo::rustc-cdylib-link-arg={flag}");
}

/// Writes the list of exported symbols, and returns the path of the file.
fn exports() -> String {
    let folder = std::env::var("OUT_DIR").unwrap_or_default();
    let file = Path::new(&folder).join("exports.def");
    if let Err(error) = std::fs::write(&file, "EXPORTS\n    PyInit__core\n") {
        println!("cargo::error={}: {error}", file.display());
    }
    file.display().to_string()
}
