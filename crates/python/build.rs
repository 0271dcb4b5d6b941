//! Flags of the linker.

fn main() {
    // The BLAS that Clarabel calls is the one inside: another one in Python's process, of SciPy say, may not take its
    // place.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-Bsymbolic");
    }
    println!("cargo::rerun-if-changed=build.rs");
}
