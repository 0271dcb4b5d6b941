//! Errors, one variant per violated assumption.

#![allow(missing_docs, reason = "the message says what each field is")]

use thiserror::Error;

/// Error of a system, its samples or its parameters.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SystemError {
    /// A matrix of a partitioned system that does not fit the others.
    #[error("{name} is {} x {}; it must be {} x {}", found.0, found.1, expected.0, expected.1)]
    Shape {
        /// The name of the matrix in the partition.
        name: &'static str,
        found: (usize, usize),
        /// The shape required by the other matrices.
        expected: (usize, usize),
    },
    /// A singular matrix `I - D Theta` of a linear fractional transformation.
    #[error("the linear fractional transformation is not well posed at theta = {theta:?}")]
    NotWellPosed { theta: Vec<f64> },
    /// An empty list of samples.
    #[error("there are no samples to fit")]
    NoSamples,
    /// Too few different parameter values: a polynomial of order d needs d + 1.
    #[error("{samples} different parameter values are too few for a polynomial of order {order}")]
    TooFewSamples { samples: usize, order: usize },
    /// Samples of different shapes.
    #[error("the shape of the sample at rho = {rho} is {found:?}; that of the first is {expected:?}")]
    UnlikeShapes { rho: f64, expected: (usize, usize), found: (usize, usize) },
    /// A number that makes a weight improper, unstable or infinite.
    #[error("{name} {index} is {found}; it must be {allowed}")]
    Number {
        name: &'static str,
        /// The index of the output or input, from 1.
        index: usize,
        found: f64,
        allowed: &'static str,
    },
    /// A plant of a sampled loop with parameters.
    #[error("the plant has parameter channels ({channels}); freeze the parameters first")]
    Scheduled { channels: usize },
    /// A sample time that is not positive and finite.
    #[error("the sample time is {found:?}; it must be above 0 and finite")]
    SampleTime { found: f64 },
    /// A direct path from the commands to the sampled output, which would jump.
    #[error(
        "the plant has a direct path D22 from u to y, which is discontinuous when sampled; add a lag to the \
         measurements or the controls"
    )]
    DirectPath,
    /// Excessive rounding in a sampled loop, which grows with each doubling of the time.
    #[error(
        "over one sample the plant and its worst input change by a factor of {size:.1e}, which is numerically \
         intractable; remove dynamics faster than a millionth of the sample time, or scale w, z and the states to \
         similar magnitudes"
    )]
    Stiff { size: f64 },
    /// A number of parameters other than one for the ladder of gammas.
    #[error("the plant depends on {found} parameters; the comparison of gammas requires one")]
    NotOneParameter { found: usize },
    /// A grid of the ladder without both ends.
    #[error("at least 2 samples of the closed loop are required, found {found}")]
    TooFewPoints { found: usize },
    /// A parameter value outside the normalised range.
    #[error("theta = {theta} is outside [-1, 1]")]
    OutsideTheBox { theta: f64 },
}

/// Failure of a synthesis: the problem is infeasible ([`SynthesisError::is_infeasible`]), a further requirement was not
/// met ([`SynthesisError::TooFast`]), the input is invalid, or the numerics failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SynthesisError {
    /// A mode that is neither stable nor controllable from any control.
    #[error(
        "the plant cannot be stabilised: no control input acts on the mode at {:.4} {:+.4}i", shown(*re), shown(*im)
    )]
    NotStabilisable {
        /// Real part of the mode, rad/s.
        re: f64,
        /// Imaginary part of the mode, rad/s.
        im: f64,
    },
    /// A mode that is neither stable nor observable from any measurement.
    #[error(
        "the plant cannot be stabilised: no measurement depends on the mode at {:.4} {:+.4}i",
        shown(*re), shown(*im)
    )]
    NotDetectable {
        /// Real part of the mode, rad/s.
        re: f64,
        /// Imaginary part of the mode, rad/s.
        im: f64,
    },
    /// A plant that no single Lyapunov function shows to be stabilisable for every trajectory of the parameters.
    #[error(
        "no quadratic Lyapunov function common to all parameter values, with these scalings, shows that a control \
         stabilises the plant for every parameter trajectory (another kind of controller may exist); narrow the \
         parameter range, add actuators, or bound the rate of the parameters"
    )]
    NotQuadraticallyStabilisable,
    /// The dual of [`Self::NotQuadraticallyStabilisable`], for the measurements.
    #[error(
        "no quadratic Lyapunov function common to all parameter values, with these scalings, shows that an observer \
         converges for every parameter trajectory (another kind of controller may exist); narrow the parameter \
         range, add measurements, or bound the rate of the parameters"
    )]
    NotQuadraticallyDetectable,
    /// A direct path from w to z, with which the H2 norm of the loop is infinite.
    #[error("D11 has an entry of {largest:.4e}; it must be zero for a finite H2 norm (filter z, w or both)")]
    H2DirectPath {
        /// The largest magnitude of an entry.
        largest: f64,
    },
    /// A D12 without full column rank or a D21 without full row rank.
    #[error(
        "a combination of controls has no weight in z, or a combination of measurements has no noise in w; the \
         H2-optimal controller requires full column rank of D12 and full row rank of D21"
    )]
    Singular,
    /// A proof of the solver that no gamma is feasible.
    #[error("the matrix inequalities of '{stage}' have no solution (the solver has a certificate of this)")]
    Infeasible { stage: &'static str },
    /// A least gamma above the limit.
    #[error(
        "the least gamma found is {optimum:.6e}, {:.2} % above the limit {limit:.6e}{}",
        100.0 * (optimum / limit - 1.0),
        dominant_text(dominant)
    )]
    AboveLimit {
        optimum: f64,
        /// A lower bound of gamma, also above the limit.
        lower: f64,
        limit: f64,
        /// The channel that dominates in the loop of the best controller, frozen at Theta = 0: output z, input w
        /// (from 1), and frequency in rad/s.
        dominant: Option<(usize, usize, f64)>,
    },
    /// A controller whose fastest mode, on a grid of the parameters, is above the limit. This does not prove that every
    /// controller is too fast: only some of those that keep gamma were tried.
    #[error(
        "every controller found, also with a larger back-off, has a mode {ratio:.3} times as fast as the limit; a \
         slower controller may or may not exist; raise the limit or relax the weights"
    )]
    TooFast {
        /// The fastest mode of the last controller tried, relative to the limit.
        ratio: f64,
    },
    /// Controllers for the plant without D22, but none found whose loop with D22 is well posed.
    #[error(
        "with the direct path D22 from u to y the loop of every controller found is not well posed: I + Duy D22 is \
         singular within the parameter box; add a lag to the measurements or the controls of the plant"
    )]
    NotWellPosed,
    /// A numerical failure: the solver stopped without a valid answer.
    #[error("numerical failure in '{stage}': {diagnosis}")]
    Numerical { stage: &'static str, diagnosis: String },
    /// Matrices of the plant that do not fit together.
    #[error(transparent)]
    System(#[from] SystemError),
}

impl SynthesisError {
    /// Returns [`SynthesisError::Numerical`].
    pub fn numerical(stage: &'static str, diagnosis: impl Into<String>) -> Self {
        Self::Numerical { stage, diagnosis: diagnosis.into() }
    }

    /// Returns the error if no controller within the limit was found but none is excluded.
    pub(crate) fn undecided(gamma: f64, lower: f64, limit: f64) -> Self {
        let diagnosis = format!(
            "the least gamma found, {gamma:.6e}, is above the limit {limit:.6e}, but infeasibility is shown only \
             below {lower:.6e}"
        );
        Self::numerical("limit of gamma", diagnosis)
    }

    /// Returns `true` if the problem is known to have no solution, in contrast to a failure to find one.
    pub fn is_infeasible(&self) -> bool {
        matches!(
            self,
            Self::NotQuadraticallyStabilisable
                | Self::NotQuadraticallyDetectable
                | Self::NotStabilisable { .. }
                | Self::NotDetectable { .. }
                | Self::Infeasible { .. }
                | Self::AboveLimit { .. }
        )
    }
}

fn dominant_text(dominant: &Option<(usize, usize, f64)>) -> String {
    dominant.map_or_else(String::new, |(z, w, omega)| {
        format!("; the dominant path from w{w} to z{z} peaks at {omega:.3} rad/s: relax its weight")
    })
}

/// Returns a number for display with four decimals: 0 instead of -0.0000.
fn shown(v: f64) -> f64 {
    if v.abs() < 0.5e-4 { 0.0 } else { v }
}

/// Failure to compute a gain at a bounded rate of the parameter.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RateError {
    /// An empty list of samples.
    #[error("no samples of the system are given")]
    NoSamples,
    /// Samples that are not in ascending order of the parameter.
    #[error("the sample at theta = {theta} is not above the previous one")]
    NotAscending { theta: f64 },
    /// A sample whose shape differs from the others.
    #[error("the sample at theta = {theta}: {source}")]
    Shape { theta: f64, source: SystemError },
    /// A negative bound on the rate.
    #[error("the bound on the rate of the parameter is {rate:?}; it must be at least zero")]
    NegativeRate { rate: f64 },
    /// A system that is unstable at a constant parameter, which has no finite gain.
    #[error("the system at theta = {theta} has a mode with real part {re:.3e}")]
    Unstable {
        theta: f64,
        /// The largest real part of its modes, rad/s.
        re: f64,
    },
    /// No Lyapunov function of this order, or a numerical failure, as the source states.
    #[error(transparent)]
    Inequality(#[from] SynthesisError),
}
