//! Sea bottom.

/// Plane bottom, level or sloping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bottom {
    /// Depth of the bottom at north 0 and east 0 \[m\].
    pub depth: f64,
    /// Slope to the north \[1\], or ahead in the vertical plane; positive where it gets deeper.
    pub north: f64,
    /// Slope to the east \[1\], positive where it gets deeper.
    pub east: f64,
}

impl Default for Bottom {
    /// Returns a level bottom deeper than that of any sea.
    fn default() -> Self {
        Self { depth: 11_000.0, north: 0.0, east: 0.0 }
    }
}

impl Bottom {
    /// Returns the depth of the bottom at a position \[m\].
    pub fn depth_at(&self, north: f64, east: f64) -> f64 {
        self.depth + self.north * north + self.east * east
    }
}
