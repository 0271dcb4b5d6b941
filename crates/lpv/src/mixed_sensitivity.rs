//! Mixed-sensitivity design: weights on error, control and output of a loop.
//!
//! ```text
//! w ->(+)-> e ->[K]-> u ->[G]-> y        z = [W1 e; W2 u; W3 y] = [W1 S; W2 K S; W3 T] w
//!      ^-                   |            S = (I + G K)^-1,   T = I - S
//!      '--------------------'
//! ```
//!
//! Source: S. Skogestad, I. Postlethwaite, "Multivariable Feedback Control", 2005, section 2.8.3.

use crate::error::{SynthesisError, SystemError};
use crate::matrix::{Mat, block};
use crate::synthesis::{Design, Options, direct_path};
use crate::system::state_space::StateSpace;
use crate::system::{GeneralisedPlant, Sizes};

/// Weights of the error e, the control u and the output y. One with a single input and output applies to each of
/// several signals; `None` leaves a signal out.
#[derive(Debug, Clone, Default)]
pub struct Weights {
    /// W1 on `e = w - y`.
    pub error: Option<StateSpace>,
    /// W2 on u.
    pub control: Option<StateSpace>,
    /// W3 on y.
    pub output: Option<StateSpace>,
}

/// Returns the weighted plant from `[w; u]` to `[W1 e; W2 u; W3 y; e]`.
///
/// Shapes: G is y x u; e has the size of y, and the last y outputs are the measurement. States: those of G, W1, W2, W3.
///
/// # Errors
/// Returns an error for a weight whose number of inputs is not the size of its signal.
pub fn augw(g: &StateSpace, weights: &Weights) -> Result<StateSpace, SystemError> {
    let (y, u) = g.d.shape();
    let n = g.a.nrows();
    // Each signal as a function of x, w and u.
    let output = block(&[&[&g.c, &Mat::zeros(y, y), &g.d]]);
    let error = block(&[&[&-&g.c, &Mat::identity(y, y), &-&g.d]]);
    let control = block(&[&[&Mat::zeros(u, n + y), &Mat::identity(u, u)]]);
    let given = [
        ("W1", &weights.error, &error),
        ("W2", &weights.control, &control),
        ("W3", &weights.output, &output),
    ];
    let (mut signals, mut filters) = (vec![], vec![]);
    for (name, weight, signal) in given {
        if let Some(weight) = weight {
            filters.push(for_signal(weight, signal.nrows(), name)?);
            signals.push(signal);
        }
    }
    filters.push(StateSpace::constant(Mat::identity(y, y)));
    signals.push(&error);
    let rows: Vec<[&Mat; 1]> = signals.into_iter().map(|signal| [signal]).collect();
    let rows = block(&rows.iter().map(|row| &row[..]).collect::<Vec<_>>());
    let unweighted = StateSpace {
        a: g.a.clone(),
        b: block(&[&[&Mat::zeros(n, y), &g.b]]),
        c: rows.columns(0, n).into_owned(),
        d: rows.columns(n, y + u).into_owned(),
    };
    Ok(StateSpace::side_by_side(&filters).after(&unweighted))
}

/// Designs the controller that minimises the H-infinity norm of [`augw`] in the loop, with a bound of that norm.
///
/// # Errors
/// Errors of [`augw`] and [`direct_path::synthesise`].
pub fn mixsyn(g: &StateSpace, weights: &Weights, options: Options) -> Result<Design, SynthesisError> {
    let augmented = augw(g, weights)?;
    let (y, u) = g.d.shape();
    let sizes = Sizes { x: augmented.a.nrows(), t: 0, w: y, u, z: augmented.c.nrows() - y, y };
    let (plant, d22) = GeneralisedPlant::of_system(&augmented, sizes, vec![]);
    direct_path::synthesise(&plant, &d22, options)
}

/// Expands a weight to a number of signals.
fn for_signal(weight: &StateSpace, signals: usize, name: &'static str) -> Result<StateSpace, SystemError> {
    let (outputs, inputs) = weight.d.shape();
    if inputs == signals {
        return Ok(weight.clone());
    }
    if (outputs, inputs) != (1, 1) {
        return Err(SystemError::Shape { name, found: (outputs, inputs), expected: (outputs, signals) });
    }
    Ok(StateSpace::side_by_side(&vec![weight.clone(); signals]))
}
