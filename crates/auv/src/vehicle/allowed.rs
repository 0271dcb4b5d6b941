//! Ranges of numbers, with their descriptions in messages.

/// Allowed values of a coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// Any finite number.
    Any,
    /// A finite number above zero.
    Positive,
    /// Zero or a positive finite number.
    NonNegative,
    /// Zero or a negative finite number.
    NonPositive,
}

impl Allowed {
    /// Returns `true` if `value` is allowed.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => value > 0.0,
                Self::NonNegative => value >= 0.0,
                Self::NonPositive => value <= 0.0,
            }
    }

    /// Describes the allowed values.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Any => "any finite number",
            Self::Positive => "a number above zero",
            Self::NonNegative => "a non-negative number",
            Self::NonPositive => "a non-positive number",
        }
    }
}
