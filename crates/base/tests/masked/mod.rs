//! Masking of computed numbers in snapshots, for the tests of several crates.

/// Returns a text with each run of digits masked.
pub fn masked(text: &str) -> String {
    let mut masked = text.replace(|c: char| c.is_ascii_digit(), "#");
    while masked.contains("##") {
        masked = masked.replace("##", "#");
    }
    masked
}
