//! A PID for pitch and, unless the speed is imposed, a PI for speed, with gains scheduled on speed.

use crate::peers::law::{Law, Limits, RunningLaw, between};
use crate::subject::Subject;
use squid_auv::Actuator;
use squid_auv::longitudinal::{PITCH, SPEED, turning};
use squid_design::axis::Linearisation;
use squid_lpv::matrix::{Mat, pseudo_inverse};
use squid_lpv::state_space::StateSpace;

/// The gains at one speed. The outputs are demanded accelerations, of pitch (rad/s^2) and forward (m/s^2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Pitch gains: proportional (1/s^2), integral (1/s^3), measured rate (1/s).
    pub pitch: [f64; 3],
    /// The setpoint weight b of the proportional term.
    pub weight: f64,
    /// Speed gains: proportional (1/s), integral (1/s^2). Without effect if the speed is imposed.
    pub speed: [f64; 2],
}

/// The control law:
///
/// ```text
/// turn   = kp (b r - theta) + Ip - kd q,   Ip+ = Ip + T ki (r - theta)
/// thrust = kv (V_r - u) + Iv,              Iv+ = Iv + T kvi (V_r - u)
/// commands = trim(V_r) + N(V) [turn; thrust]
/// ```
///
/// If the speed is imposed there is no thrust. r and theta are deviations from the trim at V_r. N gives the least
/// commands, in units of reach, for these accelerations in the linear model at a speed. Gains and N are interpolated
/// between the speeds of the tuning. An integral is held if it would drive a command further beyond its limit. Source
/// of setpoint weight and clamping: K. J. Åström, T. Hägglund, Advanced PID Control, 2006, sections 3.4 and 3.5.
#[derive(Debug, Clone)]
pub struct Pid {
    sample_time: f64,
    inputs: Inputs,
    speeds: Vec<f64>,
    gains: Vec<Gains>,
    /// N, m x 2; m x 1 if the speed is imposed.
    allocations: Vec<Mat>,
}

/// The index in y and the scale of each input of the law.
#[derive(Debug, Clone, Copy)]
struct Inputs {
    size: usize,
    reference: (usize, f64),
    pitch: (usize, f64),
    rate: (usize, f64),
    /// `None` if it is imposed.
    speed: Option<(usize, f64)>,
}

impl Inputs {
    fn of(subject: &Subject) -> Option<Self> {
        let design = &subject.inputs.design;
        let p = design.tracked.len();
        let reference = design.tracked.iter().position(|t| t.index == PITCH)?;
        // The law does not control depth.
        if design.has_depth() {
            return None;
        }
        let measured = |index: usize| {
            let row = design.measured.iter().position(|m| m.index == index)?;
            Some((p + row, design.measured[row].scale))
        };
        Some(Self {
            size: p + design.measured.len(),
            reference: (reference, design.tracked[reference].scale),
            pitch: measured(PITCH)?,
            rate: measured(squid_auv::longitudinal::index("pitch_rate")?)?,
            speed: if subject.speed_is_given() { None } else { Some(measured(SPEED)?) },
        })
    }

    /// A row of gains on y.
    fn row(&self, terms: &[((usize, f64), f64)]) -> Mat {
        let mut row = Mat::zeros(1, self.size);
        terms.iter().for_each(|((index, scale), gain)| row[*index] += scale * gain);
        row
    }
}

/// N: the least commands, in units of reach, for a unit pitch acceleration and, if the speed is a state, for a unit
/// surge acceleration.
fn allocation(l: &Linearisation, actuators: &[Actuator]) -> Mat {
    let [heave, q, _] = turning(l.states);
    let driven = if heave > 0 { vec![q, 0] } else { vec![q] };
    let b = Mat::from_fn(driven.len(), actuators.len(), |i, j| l.b[(driven[i], j)] * actuators[j].reach());
    pseudo_inverse(&b, 1e-9)
}

impl Pid {
    /// The law with gains at increasing speeds, given by their linear models; `None` if the design does not track
    /// pitch, or does not measure pitch, pitch rate and, unless it is imposed, speed.
    pub fn new(subject: &Subject, at: &[(&Linearisation, Gains)]) -> Option<Self> {
        let actuators = &subject.inputs.vehicle.actuators;
        Some(Self {
            sample_time: subject.inputs.design.sample_time,
            inputs: Inputs::of(subject)?,
            speeds: at.iter().map(|(l, _)| l.trim.speed).collect(),
            gains: at.iter().map(|(_, gains)| *gains).collect(),
            allocations: at.iter().map(|(l, _)| allocation(l, actuators)).collect(),
        })
    }

    /// Gains and N at a speed (m/s).
    fn at(&self, speed: f64) -> (Gains, Mat) {
        if self.speeds.len() == 1 {
            return (self.gains[0], self.allocations[0].clone());
        }
        let (low, part) = between(&self.speeds, speed);
        let (one, other) = (&self.gains[low], &self.gains[low + 1]);
        let blend = |a: f64, b: f64| (1.0 - part) * a + part * b;
        let gains = Gains {
            pitch: std::array::from_fn(|i| blend(one.pitch[i], other.pitch[i])),
            weight: blend(one.weight, other.weight),
            speed: std::array::from_fn(|i| blend(one.speed[i], other.speed[i])),
        };
        (gains, &self.allocations[low] * (1.0 - part) + &self.allocations[low + 1] * part)
    }
}

impl Law for Pid {
    fn frozen(&self, speed: f64) -> Option<StateSpace> {
        let (Gains { pitch: [kp, ki, kd], weight, speed: [kv, kvi] }, n) = self.at(speed);
        let i = &self.inputs;
        let mut integrals = vec![i.row(&[(i.reference, ki), (i.pitch, -ki)])];
        let mut direct = vec![i.row(&[(i.reference, kp * weight), (i.pitch, -kp), (i.rate, -kd)])];
        if let Some(speed) = i.speed {
            integrals.push(i.row(&[(speed, -kvi)]));
            direct.push(i.row(&[(speed, -kv)]));
        }
        let stacked = |rows: Vec<Mat>| Mat::from_fn(rows.len(), i.size, |row, j| rows[row][j]);
        Some(StateSpace {
            a: Mat::identity(n.ncols(), n.ncols()),
            b: stacked(integrals) * self.sample_time,
            c: n.clone(),
            d: n * stacked(direct),
        })
    }

    fn start(&self) -> Option<RunningLaw<'_>> {
        let mut integrals = [0.0; 2];
        Some(Box::new(move |speed, y, limits: Limits| {
            let (Gains { pitch: [kp, ki, kd], weight, speed: [kv, kvi] }, n) = self.at(speed);
            let value = |(index, scale): (usize, f64)| scale * y[index];
            let Inputs { reference, pitch, rate, speed, .. } = self.inputs;
            let turn = kp * (weight * value(reference) - value(pitch)) + integrals[0] - kd * value(rate);
            let ahead = speed.map_or(0.0, value);
            let wanted = [turn, integrals[1] - kv * ahead];
            let u = &n * Mat::from_column_slice(n.ncols(), 1, &wanted[..n.ncols()]);
            let growth = [ki * (value(reference) - value(pitch)), -kvi * ahead];
            for axis in 0..n.ncols() {
                let pushes = |(j, (low, high)): (usize, &(f64, f64))| {
                    let push = n[(j, axis)] * growth[axis];
                    (u[j] >= *high && push > 0.0) || (u[j] <= *low && push < 0.0)
                };
                if !limits.iter().enumerate().any(pushes) {
                    integrals[axis] += self.sample_time * growth[axis];
                }
            }
            u.as_slice().to_vec()
        }))
    }
}
