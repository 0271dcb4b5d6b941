//! Two axes in one vehicle: the loop of both autopilots, linear and frozen in a steady turn.
//!
//! In straight level flight the two planes decouple, and what is proved of each axis is all there is. In a turn they do
//! not: with x = \[u w q theta v p r phi psi z\] less the turn and the outputs T of the actuators less theirs
//!
//! ```text
//! x' = A(Omega) x + B(Omega) T     see auv::linearise_turn; psi' and z' from the rates and velocities of the turn
//! T' = (u - T)/lag                 u = K_1(rho) y_1 and u = K_2(rho) y_2, each on its own actuators
//! y  = C(Omega) x                  with the rates of the angles, theta' and psi', as they are measured
//! ```

use crate::certify::controller_of;
use crate::check::frozen_controller;
use crate::error::Error;
use auv::{Dual64, Motion, TrimError, Turn, Vehicle, linearise_turn};
use lpv::matrix::{Mat, eigenvalues};
use scheduled::{ControllerDesign, Kind};

/// The states of the vehicle in a turn.
const STATES: [&str; 10] = ["u", "w", "q", "theta", "v", "p", "r", "phi", "psi", "z"];

/// The first of those, on which forces depend.
const DYNAMIC: usize = 8;

/// The largest real part of the eigenvalues of the loop of two frozen designs in a steady turn of a vehicle \[1/s\].
///
/// # Errors
/// [`Error`] of a controller that is not well posed at the speed of the turn; `None` if the turn is not linearised.
pub fn coupled(
    whole: &Vehicle,
    designs: [&ControllerDesign; 2],
    turn: &Turn,
) -> Result<Result<f64, TrimError>, Error> {
    let (a, b) = match linearise_turn(whole, turn) {
        Ok(found) => found,
        Err(reason) => return Ok(Err(reason)),
    };
    // A depth that nothing holds integrates, and is no state.
    let is_held =
        designs.iter().any(|design| design.controller_inputs.iter().any(|one| one.signal == "depth"));
    let (n, m) = (STATES.len() - usize::from(!is_held), whole.actuators.len());
    let [pitch_rate, heading_rate, sinking] = gradients(&turn.motion);
    let mut plant = Mat::zeros(n, n);
    plant.view_mut((0, 0), (DYNAMIC, DYNAMIC)).copy_from(&a);
    plant.view_mut((DYNAMIC, 0), (1, DYNAMIC)).copy_from(&heading_rate);
    if is_held {
        plant.view_mut((DYNAMIC + 1, 0), (1, DYNAMIC)).copy_from(&sinking);
    }
    let mut input = Mat::zeros(n, m);
    input.view_mut((0, 0), (DYNAMIC, m)).copy_from(&b);
    let row = |signal: &str, state: &str| {
        let mut row = Mat::zeros(1, n);
        match signal {
            "pitch_rate" => row.view_mut((0, 0), (1, DYNAMIC)).copy_from(&pitch_rate),
            "heading_rate" => row.view_mut((0, 0), (1, DYNAMIC)).copy_from(&heading_rate),
            _ => {
                if let Some(place) = STATES[..n].iter().position(|one| *one == state) {
                    row[place] = 1.0;
                }
            }
        }
        row
    };
    // The commands, over x and over the states of both controllers: u = by_x x + by_k x_k.
    let (mut by_x, mut by_k) = (Mat::zeros(m, n), Mat::zeros(m, 0));
    let (mut k_by_x, mut k_by_k) = (Mat::zeros(0, n), Mat::zeros(0, 0));
    for design in designs {
        let rho = ((turn.speed - design.scheduling.centre) / design.scheduling.half_range).clamp(-1.0, 1.0);
        let k = frozen_controller(&controller_of(&design.lft)?, rho)?.frozen(&[])?;
        let mut c = Mat::zeros(design.controller_inputs.len(), n);
        for (i, one) in design.controller_inputs.iter().enumerate() {
            let sign = match one.kind {
                Kind::Reference => 0.0,
                Kind::Measurement => 1.0,
                Kind::Error => -1.0,
            };
            let state = state_of(&one.signal);
            c.set_row(i, &(row(&one.signal, state) * (sign / one.scale)).row(0));
        }
        let place = |name: &str| whole.actuators.iter().position(|one| one.name == name);
        let mut select = Mat::zeros(m, design.actuators.len());
        for (j, actuator) in design.actuators.iter().enumerate() {
            if let Some(place) = place(&actuator.name) {
                select[(place, j)] = actuator.scale;
            }
        }
        by_x += &select * &k.d * &c;
        by_k = lpv::matrix::block(&[&[&by_k, &(&select * &k.c)]]);
        k_by_x = lpv::matrix::block(&[&[&k_by_x], &[&(&k.b * &c)]]);
        let (before, own) = (k_by_k.nrows(), k.a.nrows());
        let (right, below) = (Mat::zeros(before, own), Mat::zeros(own, before));
        k_by_k = lpv::matrix::block(&[&[&k_by_k, &right], &[&below, &k.a]]);
    }
    let lags: Vec<f64> = whole.actuators.iter().map(|one| one.lag.max(SHORTEST_LAG)).collect();
    let rate = Mat::from_diagonal(&nalgebra::DVector::from_iterator(m, lags.iter().map(|lag| 1.0 / lag)));
    let loops = lpv::matrix::block(&[
        &[&plant, &input, &Mat::zeros(n, k_by_k.ncols())],
        &[&(&rate * by_x), &(-&rate), &(&rate * by_k)],
        &[&k_by_x, &Mat::zeros(k_by_k.nrows(), m), &k_by_k],
    ]);
    Ok(Ok(eigenvalues(&loops).iter().map(|one| one.re).fold(f64::NEG_INFINITY, f64::max)))
}

/// The lag of an actuator that has none, s: faster than any mode of the loop.
const SHORTEST_LAG: f64 = 1e-3;

/// The state that a signal is, where it is one.
fn state_of(signal: &str) -> &'static str {
    let all = auv::longitudinal::SIGNALS.iter().chain(&auv::lateral::SIGNALS);
    all.filter(|one| one.name == signal).map(|one| one.state).next().unwrap_or_default()
}

/// How theta', psi' and z' change with \[u w q theta v p r phi\], 1 x 8 each.
fn gradients(at: &Motion) -> [Mat; 3] {
    let start = [at.u, at.w, at.q, at.theta, at.v, at.p, at.r, at.phi];
    let mut rows = [(); 3].map(|()| Mat::zeros(1, DYNAMIC));
    for seed in 0..DYNAMIC {
        let part = |i: usize| Dual64::new(start[i], if i == seed { 1.0 } else { 0.0 });
        let motion = Motion {
            u: part(0),
            w: part(1),
            q: part(2),
            theta: part(3),
            v: part(4),
            p: part(5),
            r: part(6),
            phi: part(7),
        };
        let [_, pitch, heading] = motion.turning();
        for (row, value) in rows.iter_mut().zip([pitch, heading, motion.sinking()]) {
            row[seed] = value.eps;
        }
    }
    rows
}
