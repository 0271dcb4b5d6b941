//! Linear motion in sway, roll and yaw about straight level flight.

use nalgebra::{Complex, DMatrix};

use crate::motion::level::Pitch;
use crate::motion::trim_error::TrimError;
use crate::motion::turn::{Turn, linearise_turn, turn};
use crate::vehicle::Vehicle;

/// Linear model `x' = A x + B T` with x = \[v p r phi\] (m/s, rad/s, rad/s, rad) about straight level flight; T is the
/// deviation of all actuator outputs (N or rad) from trim. Shapes: A 4 x 4, B 4 x m.
#[derive(Clone, Debug)]
pub struct Lateral {
    /// State matrix.
    pub a: DMatrix<f64>,
    /// Input matrix.
    pub b: DMatrix<f64>,
    /// Straight flight.
    pub straight: Turn,
    /// Steady turns at constant depth, by increasing rate.
    pub turns: Vec<Turn>,
}

impl Lateral {
    /// Symbols of the states.
    pub const STATES: [&str; 4] = ["v", "p", "r", "phi"];

    /// Rates of the turns \[rad/s\].
    pub const RATES: [f64; 4] = [0.05, 0.1, 0.15, 0.2];

    /// Returns the linear motion at a speed V \[m/s\] along the path and a depth \[m\], at the pitch of level trim.
    /// Turns that no outputs balance are omitted.
    ///
    /// # Errors
    /// [`TrimError`]: no straight flight; a vehicle that stays in the vertical plane.
    pub fn at(vehicle: &Vehicle, speed: f64, depth: f64, pitch: &Pitch) -> Result<Self, TrimError> {
        let at_rate = |rate: f64| turn(vehicle, speed, rate, depth, pitch);
        let straight = at_rate(0.0)?;
        let (a, b) = linearise_turn(vehicle, &straight)?;
        let (n, m) = (Self::STATES.len(), b.ncols());
        Ok(Self {
            a: a.view((n, n), (n, n)).into_owned(),
            b: b.view((n, 0), (n, m)).into_owned(),
            straight,
            turns: Self::RATES.iter().filter_map(|rate| at_rate(*rate).ok()).collect(),
        })
    }

    /// Returns the eigenvalues of A \[1/s\], by increasing real part.
    pub fn eigenvalues(&self) -> Vec<Complex<f64>> {
        let mut values: Vec<_> = self.a.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        values
    }

    /// Returns `true` if straight flight is open-loop stable.
    pub fn is_stable(&self) -> bool {
        self.eigenvalues().iter().all(|value| value.re < 0.0)
    }

    /// Returns the steady yaw rate per output of an actuator, r/T, in a slow turn by it alone; `None` if A is singular.
    pub fn gain(&self, actuator: usize) -> Option<f64> {
        let column = self.b.column(actuator).into_owned();
        self.a.clone().lu().solve(&column).map(|x| -x[2])
    }
}
