//! Mixed-sensitivity design: weights on error, control and output of a loop.
//!
//! ```text
//! w ->(+)-> e ->[K]-> u ->[G]-> y        z = [W1 e; W2 u; W3 y] = [W1 S; W2 K S; W3 T] w
//!      ^-                   |            S = (I + G K)^-1,   T = I - S
//!      '--------------------'
//! ```
//!
//! Source: S. Skogestad, I. Postlethwaite, "Multivariable Feedback Control", 2005, section 2.8.3.

use crate::error::{ShapeError, SynthesisError};
use crate::matrix::{Mat, block, diagonal_blocks};
use crate::synthesis::{Design, Options, direct_path};
use crate::system::partition::{PLANT, Partitioned};
use crate::system::state_space::StateSpace;
use crate::system::{GeneralisedPlant, Group::U, Group::Y, Sizes};

/// Weights of the error e, the control u and the output y. One with a single input and output stands for as many as
/// there are signals; `None` leaves a signal out.
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
/// A weight with another number of inputs than its signal.
pub fn augw(g: &StateSpace, weights: &Weights) -> Result<StateSpace, ShapeError> {
    let (y, u) = g.d.shape();
    let n = g.a.nrows();
    let (no_w, unit) = (Mat::zeros(y, y), Mat::identity(y, y));
    // Rows of each signal over x, w and u.
    let output = block(&[&[&g.c, &no_w, &g.d]]);
    let error = block(&[&[&-&g.c, &unit, &-&g.d]]);
    let control = block(&[&[&Mat::zeros(u, n), &Mat::zeros(u, y), &Mat::identity(u, u)]]);
    let given = [
        ("W1", &weights.error, &error),
        ("W2", &weights.control, &control),
        ("W3", &weights.output, &output),
    ];
    let mut a = g.a.clone();
    let mut b = block(&[&[&Mat::zeros(n, y), &g.b]]);
    let mut rows: Vec<(Mat, Mat, Mat)> = vec![];
    for (name, weight, signal) in given {
        let Some(weight) = weight else { continue };
        let weight = for_signal(weight, signal.nrows(), name)?;
        let (of_x, of_input) = (signal.columns(0, n).into_owned(), signal.columns(n, y + u).into_owned());
        let mut into = Mat::zeros(weight.a.nrows(), a.nrows());
        into.columns_mut(0, n).copy_from(&(&weight.b * &of_x));
        let states = a.nrows();
        a = block(&[&[&a, &Mat::zeros(states, weight.a.nrows())], &[&into, &weight.a]]);
        b = block(&[&[&b], &[&(&weight.b * &of_input)]]);
        let mut c = Mat::zeros(weight.c.nrows(), states);
        c.columns_mut(0, n).copy_from(&(&weight.d * of_x));
        rows.push((c, weight.c, weight.d * of_input));
    }
    let outputs: usize = rows.iter().map(|(c, _, _)| c.nrows()).sum();
    let (mut c, mut d) = (Mat::zeros(outputs + y, a.nrows()), Mat::zeros(outputs + y, y + u));
    let mut at = 0;
    for (of_others, own, direct) in rows {
        let from = of_others.ncols();
        c.view_mut((at, 0), of_others.shape()).copy_from(&of_others);
        c.view_mut((at, from), own.shape()).copy_from(&own);
        d.view_mut((at, 0), direct.shape()).copy_from(&direct);
        at += own.nrows();
    }
    c.view_mut((at, 0), (y, n)).copy_from(&error.columns(0, n));
    d.rows_mut(at, y).copy_from(&error.columns(n, y + u));
    Ok(StateSpace { a, b, c, d })
}

/// Designs the controller that minimises the H-infinity norm of [`augw`] in the loop, with a bound of that norm.
///
/// # Errors
/// As [`augw`] and [`direct_path::synthesise`].
pub fn mixsyn(g: &StateSpace, weights: &Weights, options: Options) -> Result<Design, SynthesisError> {
    let augmented = augw(g, weights)?;
    let (y, u) = g.d.shape();
    let sizes = Sizes { x: augmented.a.nrows(), t: 0, w: y, u, z: augmented.c.nrows() - y, y };
    let matrix = block(&[&[&augmented.a, &augmented.b], &[&augmented.c, &augmented.d]]);
    let mut parts = Partitioned::of(matrix, PLANT, sizes);
    let d22 = parts.block(Y, U);
    parts.block_mut(Y, U).fill(0.0);
    direct_path::synthesise(&GeneralisedPlant { parts, blocks: vec![] }, &d22, options)
}

/// A weight for a number of signals.
fn for_signal(weight: &StateSpace, signals: usize, name: &'static str) -> Result<StateSpace, ShapeError> {
    let (outputs, inputs) = weight.d.shape();
    if inputs == signals {
        return Ok(weight.clone());
    }
    if (outputs, inputs) != (1, 1) {
        return Err(ShapeError { name, found: (outputs, inputs), expected: (outputs, signals) });
    }
    let repeated = |m: &Mat| diagonal_blocks(&vec![m; signals]);
    let StateSpace { a, b, c, d } = weight;
    Ok(StateSpace { a: repeated(a), b: repeated(b), c: repeated(c), d: repeated(d) })
}
