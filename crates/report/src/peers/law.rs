//! The control laws of the comparison: each takes the place of the controller, with the same sensors, filter of the
//! speed reference, trim feedforward, sample time and limits.

use crate::error::Error;
use crate::subject::Subject;
use squid_auv::Vehicle;
use squid_auv::longitudinal::SPEED;
use squid_design::check::sampled::trapezoidal;
use squid_flight::flight::{Course, Demand, Flight, LawOutput, Sampling, fly_course, used};
use squid_lpv::matrix::{Mat, block, diagonal_blocks};
use squid_lpv::state_space::StateSpace;
use squid_scheduled::{Autopilot, Inputs};
use std::collections::VecDeque;

/// The limits of each command minus its trim at a tick, in units of reach.
pub type Limits<'a> = &'a [(f64, f64)];

/// A running law: from the speed along the path (m/s), the controller's input y and the limits to the commands minus
/// their trim, in units of reach.
pub type RunningLaw<'a> = Box<dyn FnMut(f64, &[f64], Limits) -> Vec<f64> + 'a>;

/// A control law.
pub trait Law: Sync {
    /// The sampled law from y to the commands in units of reach, frozen at a speed along the path (m/s) and away from
    /// limits.
    fn frozen(&self, speed: f64) -> Option<StateSpace>;

    /// The law at rest, ready to run; `None` for the stored autopilot itself.
    fn start(&self) -> Option<RunningLaw<'_>>;
}

/// The controller of the design.
#[derive(Debug)]
pub struct Scheduled<'a>(pub &'a Subject<'a>);

impl Law for Scheduled<'_> {
    fn frozen(&self, speed: f64) -> Option<StateSpace> {
        let Self(subject) = self;
        let controller = &subject.controller;
        let k = controller.frozen(&vec![subject.rho(speed); controller.blocks.len()]).ok()?;
        trapezoidal(&k, subject.inputs.design.sample_time).ok()
    }

    fn start(&self) -> Option<RunningLaw<'_>> {
        None
    }
}

/// H-infinity controllers for single speeds, with the weights of the design. All run; the outputs of the two at the
/// speeds next to the vehicle's are interpolated linearly.
#[derive(Debug)]
pub struct Blended {
    speeds: Vec<f64>,
    controllers: Vec<StateSpace>,
}

impl Blended {
    /// The controllers for the speeds of the subject; `None` if the synthesis fails at one of them.
    pub fn new(subject: &Subject) -> Option<Self> {
        let sampled = |alone: &Result<squid_lpv::synthesis::Design, _>| {
            let k = alone.as_ref().ok()?.controller.frozen(&[]).ok()?;
            trapezoidal(&k, subject.inputs.design.sample_time).ok()
        };
        let controllers = subject.alone().iter().map(sampled).collect::<Option<_>>()?;
        Some(Self { speeds: subject.speeds.clone(), controllers })
    }
}

impl Law for Blended {
    fn frozen(&self, speed: f64) -> Option<StateSpace> {
        let (low, part) = between(&self.speeds, speed);
        let [one, other] = [&self.controllers[low], self.controllers.get(low + 1)?];
        Some(StateSpace {
            a: diagonal_blocks(&[&one.a, &other.a]),
            b: block(&[&[&one.b], &[&other.b]]),
            c: block(&[&[&(&one.c * (1.0 - part)), &(&other.c * part)]]),
            d: &one.d * (1.0 - part) + &other.d * part,
        })
    }

    fn start(&self) -> Option<RunningLaw<'_>> {
        let mut states: Vec<Mat> = self.controllers.iter().map(|k| Mat::zeros(k.a.nrows(), 1)).collect();
        Some(Box::new(move |speed, y, _| {
            let y = Mat::from_column_slice(y.len(), 1, y);
            let (low, part) = between(&self.speeds, speed);
            let output = |i: usize| &self.controllers[i].c * &states[i] + &self.controllers[i].d * &y;
            let u = output(low) * (1.0 - part) + output(low + 1) * part;
            for (k, x) in self.controllers.iter().zip(&mut states) {
                *x = &k.a * &*x + &k.b * &y;
            }
            u.as_slice().to_vec()
        }))
    }
}

/// The index of the interval of two or more increasing speeds that contains a speed, and the fraction of it; clamped
/// at the ends.
pub fn between(speeds: &[f64], speed: f64) -> (usize, f64) {
    let low = speeds.iter().rposition(|v| *v <= speed).unwrap_or(0).min(speeds.len() - 2);
    (low, ((speed - speeds[low]) / (speeds[low + 1] - speeds[low])).clamp(0.0, 1.0))
}

/// Simulates a vehicle on a course under a law. `gains` are the ratios of output to command of its actuators, 1 if left
/// out. The trims are those of the nominal vehicle.
///
/// # Errors
/// As [`fly_course`].
pub fn fly(
    subject: &Subject,
    law: &dyn Law,
    vehicle: &Vehicle,
    gains: &[f64],
    course: Course<impl Fn(f64) -> Demand>,
) -> Result<Flight, Error> {
    let design = &subject.stored.controller;
    // The stored autopilot runs in parallel: it gives the controller's input and the trim.
    let mut autopilot = Autopilot::new(design)?;
    let table = autopilot.trim().clone();
    let mut running = law.start();
    // Commands are delayed as those of the autopilot; the first ones hold before.
    let mut waiting: VecDeque<Vec<f64>> = VecDeque::new();
    let mut started = false;
    let tick = |measured: &Inputs| {
        if !std::mem::replace(&mut started, true) {
            autopilot.initialise(0.0, measured)?;
        }
        let filtered = autopilot.filtered_speed();
        autopilot.tick(measured)?;
        let level = design.reference_filter.map_or(measured.references[SPEED], |_| filtered);
        let mut commands = autopilot.outputs().commands.clone();
        if let Some(running) = &mut running {
            let trims: Vec<f64> = (0..commands.len()).map(|j| table.command(level, j)).collect();
            let actuators = || design.actuators.iter().zip(&trims);
            let limits: Vec<(f64, f64)> =
                actuators().map(|(a, t)| ((a.minimum - t) / a.scale, (a.maximum - t) / a.scale)).collect();
            let speed = table.speed(measured.measured[SPEED]);
            let u = running(speed, autopilot.controller_inputs(), &limits);
            let computed: Vec<f64> =
                actuators().zip(u).map(|((a, t), u)| (t + a.scale * u).clamp(a.minimum, a.maximum)).collect();
            waiting.resize(design.delay_ticks.max(waiting.len()), computed.clone());
            waiting.push_back(computed);
            commands = waiting.pop_front().unwrap_or(commands);
        }
        commands.iter_mut().zip(gains).for_each(|(command, gain)| *command *= gain);
        let outputs = autopilot.outputs();
        let (rho, out_of_range) = (outputs.scheduling_parameter, outputs.out_of_range);
        let references = Some(used(&autopilot));
        Ok(LawOutput { commands, references, rho, out_of_range })
    };
    let sampling = Sampling { sample_time: design.sample_time, trims: &table };
    Ok(fly_course(
        vehicle,
        subject.inputs.design.view(),
        subject.inputs.design.level(),
        course,
        &sampling,
        tick,
    )?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_neighbours_are_blended() {
        let speeds = [1.0, 2.0, 4.0];
        for (speed, low, part) in
            [(0.5, 0, 0.0), (1.25, 0, 0.25), (2.0, 1, 0.0), (3.0, 1, 0.5), (9.0, 1, 1.0)]
        {
            assert_eq!(between(&speeds, speed), (low, part));
        }
    }
}
