//! Options of the solution of a program of linear matrix inequalities.

/// Options of the solution of a program.
#[derive(Debug, Clone, Copy)]
pub struct SolverOptions<'a> {
    /// The gap at which the search stops.
    pub tolerance: f64,
    /// The least magnitude of the objective to which the gap is relative.
    pub floor: f64,
    /// A strictly feasible point, if one is known. The best point found is then accepted.
    pub start: Option<&'a [f64]>,
    /// A point of about the right size that may violate inequalities, and the objective at which to give up. The
    /// distance to the optimum is then estimated by the level mu only, without multipliers that prove it.
    pub near: Option<(&'a [f64], f64)>,
    /// A gap at which an impatient search does not try other row scalings: what remains is rounding at the optimum.
    pub enough: f64,
    /// `true` if an objective that has almost stopped falling is accepted, if a point is sufficient and rounding may
    /// delay or prevent a bound.
    pub settles: bool,
    /// `true` if the general solver continues when the first gets stuck at a feasible point that is not optimal.
    pub patient: bool,
    /// `true` if the general solver is never used.
    pub quick: bool,
}

impl SolverOptions<'_> {
    /// Returns the options of a search as close to the optimum as rounding allows.
    pub fn fine() -> Self {
        Self::within(1e-7)
    }

    /// Returns the options of a search within `tolerance` of the optimum, which ends in the interior of the
    /// inequalities.
    pub fn within(tolerance: f64) -> Self {
        Self {
            tolerance,
            floor: 1.0,
            start: None,
            near: None,
            enough: 1e-3,
            settles: false,
            patient: false,
            quick: false,
        }
    }
}
