//! An LFT in the parameter, fitted to controllers at many of its values.

use crate::error::SystemError;
use crate::matrix::Mat;
use crate::system::{CONTROLLER, Controller, Lft, MatrixPolynomial, Partitioned, Sizes};

/// Returns the LFT of a polynomial fitted to samples `(theta, [A B; C D])` by least squares; singular values up to
/// `tolerance` times the largest are dropped, and with them channels. `sizes` are the numbers of states, measurements
/// and controls.
///
/// # Errors
/// Returns [`SystemError`] for fewer samples than the order needs.
pub(crate) fn through(
    samples: &[(f64, Mat)],
    sizes: Sizes,
    order: usize,
    tolerance: f64,
) -> Result<Controller, SystemError> {
    let Sizes { x: states, y, u, .. } = sizes;
    let lft = Lft::from_polynomial(&MatrixPolynomial::fit(samples, order)?, tolerance);
    let r = lft.size();
    let (inside, outside) = (lft.left.rows(0, states), lft.left.rows(states, u));
    let mut m = Mat::zeros(states + u + r, states + y + r);
    m.view_mut((0, 0), (states + u, states + y)).copy_from(&lft.constant);
    m.view_mut((0, states + y), (states, r)).copy_from(&inside);
    m.view_mut((states, states + y), (u, r)).copy_from(&outside);
    m.view_mut((states + u, 0), (r, states + y)).copy_from(&lft.right);
    m.view_mut((states + u, states + y), (r, r)).copy_from(&lft.inner);
    let sizes = Sizes { t: r, ..sizes };
    Ok(Controller { parts: Partitioned::of(m, CONTROLLER, sizes), blocks: vec![r] })
}
