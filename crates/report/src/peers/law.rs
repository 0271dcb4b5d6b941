//! Control laws of the comparison: autopilots, and blended controllers with the sensors, speed reference filter, trim
//! feedforward, sample time, delay and limits of an autopilot.

use crate::error::Error;
use crate::subject::Subject;
use squid_auv::Vehicle;
use squid_design::axis::Linearisation;
use squid_design::certify::lft_matrices;
use squid_design::check::flown::opened;
use squid_design::check::sampled::trapezoidal;
use squid_design::inputs::design_file::DesignFile;
use squid_design::synthesise::given::{anti_windup, structure};
use squid_flight::flight::{Flight, Variations, fly_varied, fly_with};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, block, diagonal_blocks, to_rows};
use squid_lpv::state_space::StateSpace;
use squid_pid::Pid;
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::collections::VecDeque;

/// Control law of a comparison.
#[derive(Debug)]
pub struct Law<'a> {
    /// Name in a table.
    pub name: String,
    /// Design with the signals of the law.
    pub subject: &'a Subject<'a>,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// Autopilot of a frozen controller.
    Autopilot(Box<ControllerDesign>, Controller),
    /// Sampled H-infinity controllers for the speeds of the subject. All run; the outputs of the two at the speeds next
    /// to the vehicle's are interpolated linearly.
    Blended(Vec<StateSpace>),
}

impl<'a> Law<'a> {
    /// Returns the stored controller of a design.
    pub fn stored(subject: &'a Subject) -> Self {
        let own = Kind::Autopilot(Box::new(subject.stored.controller.clone()), subject.controller.clone());
        Self { name: subject.inputs.design.name.clone(), subject, kind: own }
    }

    /// Returns a PID in place of the controller of a design; `None` if it does not match the signals.
    pub fn pid(subject: &'a Subject, pid: &Pid) -> Option<Self> {
        let actuators = &subject.inputs.vehicle.actuators;
        let file = DesignFile { controller: Some(pid.clone()), ..subject.inputs.design.clone() };
        let controller = structure(actuators, &file, pid).ok()?.controller();
        let frozen = ControllerDesign {
            lft: lft_matrices(&controller),
            anti_windup: anti_windup(actuators, &file).ok()?.map(|gain| to_rows(&gain)),
            follow: vec![],
            gains: vec![],
            ..subject.stored.controller.clone()
        };
        Some(Self { name: "PID".into(), subject, kind: Kind::Autopilot(Box::new(frozen), controller) })
    }

    /// Returns blended H-infinity controllers for single speeds, with the weights of a design; `None` if one fails.
    pub fn blended(subject: &'a Subject) -> Option<Self> {
        let sampled = |alone: &Result<squid_lpv::synthesis::Design, _>| {
            let k = alone.as_ref().ok()?.controller.frozen(&[]).ok()?;
            trapezoidal(&k, subject.inputs.design.sample_time).ok()
        };
        let controllers = subject.alone().iter().map(sampled).collect::<Option<_>>()?;
        Some(Self { name: "blended H-infinity".into(), subject, kind: Kind::Blended(controllers) })
    }

    /// Returns the sampled law from y to the commands in units of reach, frozen at a speed along the path (m/s) and
    /// away from limits.
    pub fn frozen(&self, speed: f64) -> Option<StateSpace> {
        match &self.kind {
            Kind::Autopilot(_, controller) => {
                let rho = vec![self.subject.rho(speed); controller.blocks.len()];
                trapezoidal(&controller.frozen(&rho).ok()?, self.subject.inputs.design.sample_time).ok()
            }
            Kind::Blended(controllers) => {
                let (low, part) = between(&self.subject.speeds, speed);
                let [one, other] = [&controllers[low], &controllers[low + 1]];
                Some(StateSpace {
                    a: diagonal_blocks(&[&one.a, &other.a]),
                    b: block(&[&[&one.b], &[&other.b]]),
                    c: block(&[&[&(&one.c * (1.0 - part)), &(&other.c * part)]]),
                    d: &one.d * (1.0 - part) + &other.d * part,
                })
            }
        }
    }

    /// Returns the largest |S| at all loop openings, the largest rms command under sensor noise relative to its reach,
    /// and the delay margin \[s\] of all commands at once, at the speed of a trim; `None` if the loop is unstable.
    pub fn at(&self, l: &Linearisation) -> Option<[f64; 3]> {
        let sampling = self.subject.sampling();
        let system = sampling.held(l).injected(&self.frozen(l.trim.speed)?);
        let (opened, rms) = opened(&sampling, &system)?;
        let relative = rms.iter().zip(sampling.actuators).map(|(rms, a)| rms / a.reach());
        let (from, m) = (sampling.design.fed_back().len(), sampling.actuators.len());
        let rough = relative.fold(0.0, f64::max);
        Some([opened.peak_of_sensitivity(), rough, opened.common_delay(from..from + m)])
    }

    /// Simulates a vehicle under this law.
    ///
    /// # Errors
    /// Errors of [`fly_varied`].
    pub fn fly(
        &self,
        vehicle: &Vehicle,
        manoeuvre: &Manoeuvre,
        variations: &Variations,
    ) -> Result<Flight, Error> {
        match &self.kind {
            Kind::Autopilot(design, _) => {
                let level = self.subject.inputs.design.level();
                Ok(fly_varied(vehicle, design, level, manoeuvre, variations)?)
            }
            Kind::Blended(controllers) => {
                let mut states: Vec<Mat> = controllers.iter().map(|k| Mat::zeros(k.a.nrows(), 1)).collect();
                fly_instead(self.subject, vehicle, manoeuvre, variations, |speed, y| {
                    let (low, part) = between(&self.subject.speeds, speed);
                    let output = |i: usize| &controllers[i].c * &states[i] + &controllers[i].d * y;
                    let u = output(low) * (1.0 - part) + output(low + 1) * part;
                    for (k, x) in controllers.iter().zip(&mut states) {
                        *x = &k.a * &*x + &k.b * y;
                    }
                    u
                })
            }
        }
    }
}

/// Returns the index of the interval of two or more increasing speeds that contains a speed, and the fraction within
/// it; clamped at the ends.
fn between(speeds: &[f64], speed: f64) -> (usize, f64) {
    let low = speeds.iter().rposition(|v| *v <= speed).unwrap_or(0).min(speeds.len() - 2);
    (low, ((speed - speeds[low]) / (speeds[low + 1] - speeds[low])).clamp(0.0, 1.0))
}

/// Simulates a vehicle under a law in place of the stored controller: from the speed along the path (m/s) and the
/// controller's input y to the commands minus their trim, in units of reach.
///
/// # Errors
/// Errors of [`fly_with`].
pub fn fly_instead(
    subject: &Subject,
    vehicle: &Vehicle,
    manoeuvre: &Manoeuvre,
    variations: &Variations,
    mut law: impl FnMut(f64, &Mat) -> Mat,
) -> Result<Flight, Error> {
    let design = &subject.stored.controller;
    // Commands are delayed as in the autopilot; the first command fills the delay line.
    let mut delay_line: VecDeque<Vec<f64>> = VecDeque::new();
    let level = subject.inputs.design.level();
    Ok(fly_with(vehicle, design, level, manoeuvre, variations, |autopilot, inputs, trimmed_at| {
        let (trims, y) = (autopilot.trim(), autopilot.controller_inputs());
        let u = law(trims.speed(autopilot.speed(inputs)), &Mat::from_column_slice(y.len(), 1, y));
        let command = |(j, a): (usize, &squid_scheduled::Actuator)| {
            (trims.command(trimmed_at, j) + a.scale * u[j]).clamp(a.minimum, a.maximum)
        };
        let computed: Vec<f64> = design.actuators.iter().enumerate().map(command).collect();
        delay_line.resize(design.delay_ticks.max(delay_line.len()), computed.clone());
        delay_line.push_back(computed);
        delay_line.pop_front().unwrap_or_default()
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blends_the_two_adjacent_speeds() {
        let speeds = [1.0, 2.0, 4.0];
        for (speed, low, part) in
            [(0.5, 0, 0.0), (1.25, 0, 0.25), (2.0, 1, 0.0), (3.0, 1, 0.5), (9.0, 1, 1.0)]
        {
            assert_eq!(between(&speeds, speed), (low, part));
        }
    }
}
