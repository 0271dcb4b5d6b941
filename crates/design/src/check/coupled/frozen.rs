//! Loop of both autopilots in one steady turn, with the controllers frozen at its speed.

use crate::certify::controller_of;
use crate::check::coupled::plant::part;
use crate::check::coupled::turn::{Axis, Turning};
use crate::check::frozen_controller;
use crate::error::Error;
use nalgebra::DVector;
use squid_lpv::matrix::{Mat, block, diagonal_blocks, eigenvalues};

/// Lag of an actuator without one, s: faster than any mode of the loop.
const SHORTEST_LAG: f64 = 1e-3;

/// Returns the largest real part of the eigenvalues of the loop in a steady turn, at a speed \[m/s\] and a rate of
/// heading \[rad/s\], 1/s; `None` if there is no such turn.
///
/// # Errors
/// [`Error`] of a controller that is not well posed at the speed.
pub fn largest_real_part(turning: &Turning<'_>, speed: f64, rate: f64) -> Result<Option<f64>, Error> {
    let Ok((m, forward_speed)) = turning.motion(speed, rate) else { return Ok(None) };
    let axes = turning.axes();
    // The rows of x' have the indices of the columns of x.
    let x = axes.each_ref().map(Axis::state_columns).concat();
    let y = axes.each_ref().map(Axis::measured_rows).concat();
    let t = axes.each_ref().map(Axis::actuator_columns).concat();
    let frozen = |axis: usize| -> Result<_, Error> {
        let controller = controller_of(&turning.designs[axis].lft)?;
        Ok(frozen_controller(&controller, turning.rho(axis, forward_speed))?.frozen(&[])?)
    };
    let [one, other] = [frozen(0)?, frozen(1)?];
    let [ka, kb, kc, kd] = [(&one.a, &other.a), (&one.b, &other.b), (&one.c, &other.c), (&one.d, &other.d)]
        .map(|(one, other)| diagonal_blocks(&[one, other]));
    let all: Vec<(f64, f64)> = axes.iter().flat_map(|axis| axis.actuators.clone()).collect();
    let diagonal = |values: Vec<f64>| Mat::from_diagonal(&DVector::from_vec(values));
    let rate = diagonal(all.iter().map(|(_, lag)| 1.0 / lag.max(SHORTEST_LAG)).collect());
    let scale = diagonal(all.iter().map(|(scale, _)| *scale).collect());
    let (c, by_command) = (part(&m, &y, &x), &rate * scale);
    let loops = block(&[
        &[&part(&m, &x, &x), &part(&m, &x, &t), &Mat::zeros(x.len(), ka.nrows())],
        &[&(&by_command * kd * &c), &-rate, &(&by_command * kc)],
        &[&(kb * c), &Mat::zeros(ka.nrows(), t.len()), &ka],
    ]);
    Ok(Some(eigenvalues(&loops).iter().map(|one| one.re).fold(f64::NEG_INFINITY, f64::max)))
}
