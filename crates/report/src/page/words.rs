//! Text of a page.

/// Text escaped for HTML and attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The text with a capital first letter.
pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A number with `digits` decimals, without trailing zeros and without a minus before zero.
pub fn tidy(v: f64, digits: usize) -> String {
    let text = format!("{v:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

/// A time in words, which may be infinite or unknown.
pub fn seconds(v: f64) -> String {
    if v.is_nan() {
        return "-".into();
    }
    if v.is_finite() { format!("{v:.2}") } else { "never".into() }
}
