//! Linear motion of two axes about a steady turn.

use crate::error::Error;
use squid_auv::{Dual64, Motion, Pitch, TrimError, VIEWS, Vehicle, lateral, linearise_turn};
use squid_lpv::matrix::Mat;
use squid_scheduled::{Autopilot, ControllerDesign, Kind, Trim};

/// States of [`linearise_turn`], on which forces depend.
const DYNAMIC: [&str; 8] = ["u", "w", "q", "theta", "v", "p", "r", "phi"];

/// States of each axis.
const LEVEL: [&str; 5] = ["u", "w", "q", "theta", "z"];
const LATERAL: [&str; 5] = ["v", "p", "r", "phi", "psi"];

/// Vehicle in turns at one depth, and the designs of its axes: of pitch or depth, and of heading.
#[derive(Debug, Clone)]
pub struct Turning<'a> {
    vehicle: &'a Vehicle,
    depth: f64,
    pitch: &'a Pitch,
    /// Designs of the axis of pitch or depth, and of the axis of heading.
    pub designs: [&'a ControllerDesign; 2],
    trims: [Trim; 2],
}

/// Indices of an axis in the matrix M of [`Turning::motion`].
#[derive(Debug, Clone)]
pub struct Axis {
    /// Rows of x' and of y.
    pub rows: Vec<usize>,
    /// Columns of x and of T.
    pub columns: Vec<usize>,
    /// Number of states x.
    pub states: usize,
    /// Output per command of the controller, and lag \[s\], of each actuator of the axis.
    pub actuators: Vec<(f64, f64)>,
}

impl Axis {
    /// Returns the columns of x.
    pub fn state_columns(&self) -> &[usize] {
        &self.columns[..self.states]
    }

    /// Returns the columns of T.
    pub fn actuator_columns(&self) -> &[usize] {
        &self.columns[self.states..]
    }

    /// Returns the rows of y.
    pub fn measured_rows(&self) -> &[usize] {
        &self.rows[self.states..]
    }
}

impl<'a> Turning<'a> {
    /// Combines a vehicle in six degrees of freedom, at a depth \[m\] and with a pitch in trim, with a design of pitch
    /// or depth and one of heading.
    ///
    /// # Errors
    /// [`Error`] of a design that cannot be flown.
    pub fn new(
        vehicle: &'a Vehicle,
        (depth, pitch): (f64, &'a Pitch),
        designs: [&'a ControllerDesign; 2],
    ) -> Result<Self, Error> {
        let trim = |design| Ok::<_, Error>(Autopilot::new(design)?.trim().clone());
        let trims = [trim(designs[0])?, trim(designs[1])?];
        Ok(Self { vehicle, depth, pitch, designs, trims })
    }
}

impl Turning<'_> {
    /// Returns the common range of speed of both designs, m/s.
    pub fn speeds(&self) -> [f64; 2] {
        let [one, other] = self.designs.map(|design| &design.scheduling);
        [one.minimum.max(other.minimum), one.maximum.min(other.maximum)]
    }

    /// Returns the rho of an axis at a forward speed \[m/s\], as computed by its autopilot. In a turn the forward speed
    /// differs from the speed along the path, which identifies a turn.
    pub fn rho(&self, axis: usize, forward_speed: f64) -> f64 {
        let scheduling = &self.designs[axis].scheduling;
        ((self.trims[axis].speed(forward_speed) - scheduling.centre) / scheduling.half_range).clamp(-1.0, 1.0)
    }

    /// Returns the limit of the rate of turn at a speed along the path \[m/s\], rad/s: that of the reference, the
    /// smaller of both sides.
    pub fn fastest(&self, speed: f64) -> f64 {
        let limits = self.designs[1].envelope.get(lateral::SIGNALS[lateral::HEADING].name);
        let ends = limits.and_then(|limits| limits.rate.as_ref());
        let trim = &self.trims[1];
        let end =
            |end: usize| ends.map_or(0.0, |ends| trim.over(trim.forward_speed(speed), &ends[end]).abs());
        end(0).min(end(1))
    }

    /// States x of both axes.
    fn states(&self) -> Vec<&'static str> {
        // A depth that is not controlled only integrates and is no state; nor is a given speed.
        let holds = |design: &&ControllerDesign| {
            design.controller_inputs.iter().any(|one| ["depth", "altitude"].contains(&one.signal.as_str()))
        };
        let is_held = self.designs.iter().any(holds);
        let is_given = self.vehicle.coefficients.surge.is_given();
        let level = LEVEL.into_iter().filter(|one| (*one != "z" || is_held) && (*one != "u" || !is_given));
        level.chain(LATERAL).collect()
    }

    /// Returns the indices of both axes in M.
    pub fn axes(&self) -> [Axis; 2] {
        let states = self.states();
        let mut measured = states.len();
        [0, 1].map(|axis| {
            let design = self.designs[axis];
            let is_own = |state: &str| LATERAL.contains(&state) == (axis == 1);
            let own: Vec<usize> = (0..states.len()).filter(|i| is_own(states[*i])).collect();
            let first = measured;
            measured += design.controller_inputs.len();
            let index = |name: &str| self.vehicle.actuators.iter().position(|one| one.name == name);
            let found = design.actuators.iter().filter_map(|one| Some((index(&one.name)?, one.scale)));
            let found: Vec<(usize, f64)> = found.collect();
            Axis {
                rows: own.iter().copied().chain(first..measured).collect(),
                columns: own.iter().copied().chain(found.iter().map(|(at, _)| states.len() + at)).collect(),
                states: own.len(),
                actuators: found
                    .iter()
                    .map(|(at, scale)| (*scale, self.vehicle.actuators[*at].lag))
                    .collect(),
            }
        })
    }

    /// Returns M at a speed along the path \[m/s\] and a rate of heading \[rad/s\], and the forward speed in that turn
    /// \[m/s\]. Rows of M: x' of both axes, then y1 and y2 in units of their scales; columns: x of both axes, then the
    /// outputs of all actuators of the vehicle.
    ///
    /// # Errors
    /// [`TrimError`]: no such turn.
    pub fn motion(&self, speed: f64, rate: f64) -> Result<(Mat, f64), TrimError> {
        let turn = squid_auv::turn(self.vehicle, speed, rate, self.depth, self.pitch)?;
        let (a, b) = linearise_turn(self.vehicle, &turn)?;
        let [pitch_rate, heading_rate, sinking] = gradients(&turn.motion);
        let states = self.states();
        let (n, m) = (states.len(), self.vehicle.actuators.len());
        let index = |state: &str| DYNAMIC.iter().position(|one| *one == state);
        // Rearranges a row over the states of `linearise_turn` to one over [x; T].
        let over = |row: &Mat| {
            let entry = |j: usize| states.get(j).and_then(|state| index(state)).map_or(0.0, |from| row[from]);
            Mat::from_fn(1, n + m, |_, j| entry(j))
        };
        let rows: Vec<Mat> = states
            .iter()
            .map(|state| match (*state, index(state)) {
                (_, Some(from)) => {
                    let mut row = over(&a.rows(from, 1).into_owned());
                    row.columns_mut(n, m).copy_from(&b.rows(from, 1));
                    row
                }
                ("psi", None) => over(&heading_rate),
                _ => over(&sinking),
            })
            .chain(self.designs.iter().flat_map(|design| &design.controller_inputs).map(|one| {
                let sign = match one.kind {
                    Kind::Reference => 0.0,
                    Kind::Measurement => 1.0,
                    Kind::Error => -1.0,
                };
                let entries = row_of(&one.signal);
                let entry = |state: &str| entries.iter().find(|(symbol, _)| *symbol == state);
                let row = match one.signal.as_str() {
                    "pitch_rate" => over(&pitch_rate),
                    "heading_rate" => over(&heading_rate),
                    _ => Mat::from_fn(1, n + m, |_, j| {
                        states.get(j).and_then(|state| entry(state)).map_or(0.0, |(_, entry)| *entry)
                    }),
                };
                row * (sign / one.scale)
            }))
            .collect();
        Ok((Mat::from_fn(rows.len(), n + m, |i, j| rows[i][j]), turn.motion.u))
    }
}

/// Row of a signal in the output equation of its view.
fn row_of(signal: &str) -> &'static [(&'static str, f64)] {
    let mut all = VIEWS.iter().flat_map(|view| view.interface.signals);
    all.find(|one| one.name == signal).map_or(&[], |one| one.row)
}

/// Gradients of theta', psi' and z' with respect to the states of [`linearise_turn`], 1 x 8 each.
fn gradients(at: &Motion) -> [Mat; 3] {
    let start = [at.u, at.w, at.q, at.theta, at.v, at.p, at.r, at.phi];
    let mut rows = [(); 3].map(|()| Mat::zeros(1, DYNAMIC.len()));
    for seed in 0..DYNAMIC.len() {
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
        for (row, value) in rows.iter_mut().zip([pitch, heading, motion.depth_rate()]) {
            row[seed] = value.eps;
        }
    }
    rows
}
