//! Current: steady, uniform motion of the water.

/// Steady, uniform current in the earth frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Current {
    /// Horizontal velocity U_c \[m/s\]: along the vehicle's heading, or north for six degrees of freedom.
    pub horizontal: f64,
    /// Velocity east \[m/s\], for six degrees of freedom only.
    pub east: f64,
    /// Vertical velocity W_c \[m/s\], positive down.
    pub vertical: f64,
}

impl Current {
    /// Returns the current in body axes: `u_c = U_c cos - W_c sin`, `w_c = U_c sin + W_c cos`.
    pub(crate) fn along_body(self, theta: f64) -> (f64, f64) {
        let (sin, cos) = theta.sin_cos();
        (self.horizontal * cos - self.vertical * sin, self.horizontal * sin + self.vertical * cos)
    }

    /// Returns the velocity north, east and down.
    pub fn in_earth(self) -> [f64; 3] {
        [self.horizontal, self.east, self.vertical]
    }

    /// Returns the current at a later time \[s\], changing at constant rates.
    pub(crate) fn after(self, elapsed: f64, rates: Self) -> Self {
        Self {
            horizontal: self.horizontal + rates.horizontal * elapsed,
            east: self.east + rates.east * elapsed,
            vertical: self.vertical + rates.vertical * elapsed,
        }
    }
}

impl From<[f64; 3]> for Current {
    /// Returns the current with a velocity north, east and down.
    fn from([horizontal, east, vertical]: [f64; 3]) -> Self {
        Self { horizontal, east, vertical }
    }
}

impl std::ops::Add for Current {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.after(1.0, other)
    }
}

/// Returns `x' = u cos + w sin + U_c` and `z' = -u sin + w cos + W_c`.
pub(crate) fn earth_velocity([u, w]: [f64; 2], [sin, cos]: [f64; 2], current: Current) -> (f64, f64) {
    (u * cos + w * sin + current.horizontal, w * cos - u * sin + current.vertical)
}
