//! Numbers and names in messages.

/// Formats a number for messages: the shortest digits that read back to it, with an exponent instead of many zeros.
///
/// ```
/// assert_eq!([0.2, -60.0, 1e300, 1e-300].map(squid_auv::number), ["0.2", "-60", "1e300", "1e-300"]);
/// ```
pub fn number(v: f64) -> String {
    let size = v.abs();
    if size == 0.0 {
        return "0".into();
    }
    if (1e-4..1e7).contains(&size) || !v.is_finite() { v.to_string() } else { format!("{v:e}") }
}

/// Formats a computed number for messages: six significant digits without trailing zeros.
///
/// ```
/// assert_eq!([1443.6461006741401, 2.0 / 3.0, -0.0].map(squid_auv::rounded), ["1443.65", "0.666667", "0"]);
/// assert_eq!(squid_auv::rounded(3e300), "3e300");
/// assert_eq!([100.0, -250000.0, 999999.7].map(squid_auv::rounded), ["100", "-250000", "1000000"]);
/// assert_eq!([1.5e-5, f64::NAN].map(squid_auv::rounded), ["1.5e-5", "NaN"]);
/// ```
pub fn rounded(v: f64) -> String {
    Rounded(v).to_string()
}

/// Returns the factor from a unit to its readable equivalent, and the latter: degrees for radians.
pub fn readable(unit: &str) -> (f64, &str) {
    if unit == "rad" { (1f64.to_degrees(), "deg") } else { (1.0, unit) }
}

/// Displays a number like [`rounded`].
pub(crate) struct Rounded(pub(crate) f64);

impl std::fmt::Display for Rounded {
    // Optimised for size, since it is part of every FMU: a decimal parser would take 20 kB there.
    #[cold]
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let v = self.0;
        let (mut size, mut decimals) = (v.abs(), 5_usize);
        if !(size == 0.0 || (1e-4..1e6).contains(&size)) {
            let text = format!("{v:.5e}");
            let at = text.find('e').unwrap_or(text.len());
            return write!(f, "{}{}", short(&text[..at]), &text[at..]);
        }
        while size >= 10.0 {
            (size, decimals) = (size / 10.0, decimals - 1);
        }
        while size < 1.0 && decimals < 9 {
            (size, decimals) = (size * 10.0, decimals + 1);
        }
        let text = format!("{v:.decimals$}");
        let digits = short(&text);
        f.write_str(if digits == "-0" { "0" } else { digits })
    }
}

/// Returns the digits without trailing zeros after the decimal point.
fn short(digits: &str) -> &str {
    let mut end = digits.len();
    if digits.contains('.') {
        let bytes = digits.as_bytes();
        end -= bytes.iter().rev().take_while(|b| **b == b'0').count();
        end -= usize::from(bytes[end - 1] == b'.');
    }
    &digits[..end]
}

/// Returns the candidate most similar to the word, if one is similar.
pub(crate) fn nearest(word: &str, candidates: &[&str]) -> Option<String> {
    let likeness = |candidate: &str| strsim::jaro_winkler(&word.to_lowercase(), &candidate.to_lowercase());
    let scored = candidates.iter().map(|candidate| (likeness(candidate), candidate));
    let (score, candidate) = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (score > 0.8).then(|| candidate.to_string())
}
