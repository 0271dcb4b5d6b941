//! Build script of the shared libraries: names each as macOS asks for. The linker would write the path at which it puts
//! the file into it, a path of the machine that built it.
#![allow(missing_docs)]

use std::env::var;

fn main() {
    println!("cargo::rerun-if-env-changed=CARGO_PKG_NAME");
    if var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "macos")
        && let Ok(name) = var("CARGO_PKG_NAME")
    {
        let file = format!("lib{}.dylib", name.replace('-', "_"));
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/{file}");
    }
}
