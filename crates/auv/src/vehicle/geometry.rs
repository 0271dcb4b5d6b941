//! The size of a hull.

/// Length and diameter of a hull, for what acts on its shape as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// m.
    pub length: f64,
    /// m.
    pub diameter: f64,
}

impl Geometry {
    /// What the diameter must be.
    pub(crate) const ALLOWED: &str = "above zero, and at most half the length: the hull is taken as slender";

    /// A hull of this size; `None` if the diameter is not `Geometry::ALLOWED`.
    pub fn new(length: f64, diameter: f64) -> Option<Self> {
        (diameter > 0.0 && 2.0 * diameter <= length && length.is_finite())
            .then_some(Self { length, diameter })
    }
}
