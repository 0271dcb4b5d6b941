//! The ascent from a unit perturbation Q to a nearby one with the largest real eigenvalue of `M Q`.
//!
//! To first order the eigenvalue lambda changes by `(M* u)* dQ v`. For every angle theta the blocks are set to the
//! values at which `Re (e^-j theta lambda)` grows most; `Im lambda` grows with theta, and the angle is chosen at which
//! lambda is real. If a real scalar changes its sign there, it is set in between. These are the conditions of P. M.
//! Young, J. C. Doyle, "Computation of mu with real and complex uncertainties", 29th CDC, 1990; a step is taken towards
//! them as long as the eigenvalue grows.

use super::bound::{LowerBound, checked};
use super::modes::{Mode, Modes};
use crate::mu::CMat;
use crate::mu::structure::Block;
use crate::stop;
use nalgebra::Complex;
use std::f64::consts::FRAC_PI_2;

/// The largest number of steps, and of halvings of one.
const ASCENT_STEPS: usize = 60;
const HALVINGS: i32 = 8;

/// The relative growth of the eigenvalue below which the ascent ends.
const LEAST_GROWTH: f64 = 1e-9;

/// The number of bisections of the angle.
const ANGLE_STEPS: usize = 40;

/// The largest number of Newton steps that make an eigenvalue real.
const MOST_CORRECTIONS: usize = 12;

/// The relative imaginary part below which an eigenvalue is taken as real.
const REAL: f64 = 1e-13;

/// Follows a mode of `M Q` to a maximum at which it is real. `None` if it does not become real.
pub(super) fn ascend(modes: &Modes, mut q: CMat, mut mode: Mode) -> Option<LowerBound> {
    for _ in 0..ASCENT_STEPS {
        stop::check();
        let (aim, theta) = aim(modes, &q, &mode);
        let by = aim - &q;
        let price = 1.0 + 2.0 * theta.tan().abs().min(1e3);
        let merit = |lambda: Complex<f64>| lambda.re - price * lambda.im.abs();
        let change = modes.change(&mode, &by);
        let next = (0..HALVINGS).find_map(|halvings| {
            let part = 0.5f64.powi(halvings);
            let next = &q + &by * Complex::new(part, 0.0);
            let found = modes.nearest(&next, mode.lambda + change * part)?;
            let growth = merit(found.lambda) - merit(mode.lambda);
            (growth > LEAST_GROWTH * mode.lambda.norm()).then_some((next, found))
        });
        let Some(next) = next else { break };
        (q, mode) = next;
    }
    exact(modes, &q, &mode)
}

/// Returns the target of the blocks, and the best angle.
fn aim(modes: &Modes, q: &CMat, mode: &Mode) -> (CMat, f64) {
    let at = |theta: f64| {
        let aimed = modes.aimed(q, mode, Complex::from_polar(1.0, theta));
        let im = mode.lambda.im + modes.change(mode, &(&aimed - q)).im;
        (aimed, im)
    };
    let none = REAL * mode.lambda.norm();
    let (plain, im) = at(0.0);
    if im.abs() <= none {
        return (plain, 0.0);
    }
    // The imaginary part grows with the angle.
    let (mut low, mut high) = if im < 0.0 { (0.0, FRAC_PI_2) } else { (-FRAC_PI_2, 0.0) };
    let (mut below, mut above) = (at(low), at(high));
    if below.1 > 0.0 {
        return (below.0, low);
    }
    if above.1 < 0.0 {
        return (above.0, high);
    }
    for _ in 0..ANGLE_STEPS {
        let theta = 0.5 * (low + high);
        let middle = at(theta);
        if middle.1 <= 0.0 {
            (low, below) = (theta, middle);
        } else {
            (high, above) = (theta, middle);
        }
    }
    let range = above.1 - below.1;
    let part = if range > 0.0 { -below.1 / range } else { 0.0 };
    (&below.0 + (above.0 - &below.0) * Complex::new(part, 0.0), low)
}

/// Returns the best perturbation near Q for which the eigenvalue is real and positive.
fn exact(modes: &Modes, q: &CMat, mode: &Mode) -> Option<LowerBound> {
    let real = (0..modes.places.len()).filter(|k| matches!(modes.places[*k].0, Block::Real(_)));
    let found =
        std::iter::once(None).chain(real.map(Some)).filter_map(|scalar| made_real(modes, q, mode, scalar));
    found.max_by(|a, b| a.value.total_cmp(&b.value))
}

/// Rotates all complex blocks, or moves one real scalar, until the eigenvalue is real.
fn made_real(modes: &Modes, q: &CMat, mode: &Mode, scalar: Option<usize>) -> Option<LowerBound> {
    let (mut q, mut mode) = (q.clone(), mode.clone());
    for _ in 0..MOST_CORRECTIONS {
        let near = mode.lambda;
        if near.im.abs() <= REAL * near.norm() {
            break;
        }
        let along = direction(modes, &q, scalar);
        let slope = modes.change(&mode, &along).im;
        if slope == 0.0 {
            return None;
        }
        turn(modes, &mut q, scalar, -near.im / slope)?;
        mode = modes.nearest(&q, near)?;
    }
    let size = mode.lambda.re;
    (size > 0.0).then(|| checked(modes.m, modes.structure, q / Complex::new(size, 0.0)))?
}

/// Returns the derivative of Q with respect to the angle of all complex blocks, or to a real scalar.
fn direction(modes: &Modes, q: &CMat, scalar: Option<usize>) -> CMat {
    let mut out = CMat::zeros(q.nrows(), q.ncols());
    for (k, (block, rows, cols)) in modes.places.iter().enumerate() {
        let region = ((rows.start, cols.start), (rows.len(), cols.len()));
        let mut part = out.view_mut(region.0, region.1);
        match scalar {
            None if !matches!(block, Block::Real(_)) => {
                part.copy_from(&(q.view(region.0, region.1) * Complex::new(0.0, 1.0)));
            }
            Some(chosen) if chosen == k => part.fill_diagonal(Complex::new(1.0, 0.0)),
            _ => {}
        }
    }
    out
}

/// Rotates all complex blocks by an angle, or moves a real scalar; `None` if the scalar leaves its range.
fn turn(modes: &Modes, q: &mut CMat, scalar: Option<usize>, step: f64) -> Option<()> {
    for (k, (block, rows, cols)) in modes.places.iter().enumerate() {
        let mut part = q.view_mut((rows.start, cols.start), (rows.len(), cols.len()));
        match scalar {
            None if !matches!(block, Block::Real(_)) => {
                part *= Complex::from_polar(1.0, step.clamp(-0.5, 0.5));
            }
            Some(chosen) if chosen == k => {
                let next = part[(0, 0)].re + step;
                if !(-1.0..=1.0).contains(&next) {
                    return None;
                }
                part.fill_diagonal(Complex::new(next, 0.0));
            }
            _ => {}
        }
    }
    Some(())
}
