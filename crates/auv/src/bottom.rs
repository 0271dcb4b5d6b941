//! The bottom of the sea.

/// A plane bottom, level or sloping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bottom {
    /// Its depth where north and east are 0 \[m\].
    pub depth: f64,
    /// Its slope to the north \[1\], or ahead in the vertical plane: positive where it gets deeper.
    pub north: f64,
    /// Its slope to the east \[1\].
    pub east: f64,
}

impl Default for Bottom {
    /// A level bottom that is deeper than that of any sea.
    fn default() -> Self {
        Self { depth: 11_000.0, north: 0.0, east: 0.0 }
    }
}

impl Bottom {
    /// Returns its depth under a place \[m\].
    pub fn depth_at(&self, north: f64, east: f64) -> f64 {
        self.depth + self.north * north + self.east * east
    }
}
