//! Name of a shared library inside an FMU, for the build scripts of the `library` crates.

use std::env::var;

/// Names the library that cargo is building, on macOS: `@rpath/lib<package>.dylib`.
///
/// Without it the linker writes the path at which it puts the file into it, a path of the machine that built it.
pub fn set_install_name() {
    println!("cargo::rerun-if-env-changed=CARGO_PKG_NAME");
    if var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "macos")
        && let Ok(name) = var("CARGO_PKG_NAME")
    {
        let file = format!("lib{}.dylib", name.replace('-', "_"));
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/{file}");
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
