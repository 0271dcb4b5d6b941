//! How a program of linear matrix inequalities is to be solved.

/// How a program is to be solved.
#[derive(Debug, Clone, Copy)]
pub struct SolverOptions<'a> {
    /// The gap at which to stop.
    pub tolerance: f64,
    /// An objective smaller than this counts as this large when the gap is set in relation to it.
    pub floor: f64,
    /// A point at which all inequalities hold strictly, if one is known. The best point found is then good enough.
    pub start: Option<&'a [f64]>,
    /// A point of about the right size, at which inequalities need not hold. From there the distance to the optimum
    /// is judged by the level mu alone: no multipliers are made that prove it. With the objective at which to give
    /// up: that of the best is above it.
    pub near: Option<(&'a [f64], f64)>,
    /// A gap at which rows of other sizes are not tried for an impatient search: what is left then is rounding at the
    /// optimum, not a search that is stuck on the way.
    pub enough: f64,
    /// Whether a value that has all but stopped falling is the least: enough where a point is all that is wanted, and a
    /// bound from the other side comes late, or never for rounding.
    pub settles: bool,
    /// Whether to go on with the general solver where the first gets stuck at a point that is feasible, but not the
    /// best.
    pub patient: bool,
    /// Whether to do without the general solver, whatever comes of the first.
    pub quick: bool,
}

impl SolverOptions<'_> {
    /// As close to the optimum as rounding lets one come.
    pub fn fine() -> Self {
        Self::within(1e-7)
    }

    /// Within `tolerance` of the optimum, and therefore well inside the inequalities.
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
