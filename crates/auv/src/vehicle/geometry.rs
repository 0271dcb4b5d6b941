//! Size of a hull.

/// Length and diameter of a hull, for loads on its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Length \[m\].
    pub length: f64,
    /// Largest diameter \[m\].
    pub diameter: f64,
}

impl Geometry {
    /// Condition on the diameter, for messages.
    pub(crate) const ALLOWED: &str = "above zero and at most half the length, because the equations assume a slender \
        hull";

    /// Returns a hull of this size; `None` if the diameter is not `Geometry::ALLOWED`.
    pub fn new(length: f64, diameter: f64) -> Option<Self> {
        (diameter > 0.0 && 2.0 * diameter <= length && length.is_finite())
            .then_some(Self { length, diameter })
    }
}
