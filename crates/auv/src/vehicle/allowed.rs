//! Ranges of numbers, with their descriptions in messages.

/// The values that a coefficient may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// Any finite number.
    Any,
    /// A finite number above zero.
    Positive,
    /// Zero or a finite number above it.
    NonNegative,
    /// Zero or a finite number below it.
    NonPositive,
}

impl Allowed {
    /// Returns whether `value` is allowed.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => value > 0.0,
                Self::NonNegative => value >= 0.0,
                Self::NonPositive => value <= 0.0,
            }
    }

    /// Describes what is allowed.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Any => "any finite number",
            Self::Positive => "a number above zero",
            Self::NonNegative => "zero or a positive number",
            Self::NonPositive => "zero or a negative number",
        }
    }
}
