//! Exact derivatives of the plant, from dual numbers in the simulation code.

use squid_auv::{Bottom, Dual64, Instant, Motion, index};

use crate::{PlantModel, Quantity as Q};

impl PlantModel {
    /// Computes the tangents of outputs and derivatives from those of inputs and states, numbered as in
    /// [`Quantity`](crate::Quantity).
    ///
    /// During initialisation the motion through the water is prescribed by the parameters, independent of the current;
    /// the velocities over ground follow from both.
    pub fn carry(&self, initial: bool, tangents: &mut [f64]) {
        if initial {
            self.carry_current(tangents);
        }
        let instant = self.seeded(tangents);
        let output = |index: usize| self.seeded_output(index, tangents);
        let rates = self.plant.rates(&instant, output);
        let motion @ Motion { u, v, w, .. } = instant.motion();
        let actuators = self.plant.actuators();
        for (index, actuator) in actuators.iter().enumerate() {
            let output = self.seeded_output(index, tangents);
            let rate = actuator.output_rate(output, self.seeded_command(index, tangents));
            tangents[Q::output(index)] = output.eps;
            tangents[Q::output_rate(index)] = rate.eps;
        }
        for (state_index, rate) in rates.into_iter().enumerate() {
            tangents[Q::Rate(state_index).number()] = rate.eps;
        }
        let [roll_rate, pitch_rate, heading_rate] = motion.turning();
        for (quantity, value) in [
            (Q::Speed, u),
            (Q::Sway, v),
            (Q::Heave, w),
            (Q::RollRate, roll_rate),
            (Q::PitchRate, pitch_rate),
            (Q::HeadingRate, heading_rate),
        ] {
            tangents[quantity.number()] = value.eps;
        }
        let moved = |state_index: usize| tangents[Q::State(state_index).number()];
        let Bottom { north, east, .. } = self.settings.bottom;
        let altitude = north * moved(index::NORTH) + east * moved(index::EAST) - moved(index::DEPTH);
        tangents[Q::Altitude.number()] = altitude;
        // V has no derivative at rest; 0 is the mean of the one-sided derivatives.
        let square = u * u + w * w + v * v;
        tangents[Q::PathSpeed.number()] =
            if square.re > 0.0 { 0.5 * square.eps / square.re.sqrt() } else { 0.0 };
    }

    fn carry_current(&self, tangents: &mut [f64]) {
        // The velocity through the water of a point at rest over ground is minus that of the current.
        let now = self.instant();
        let mut against = Instant::<Dual64>::zero();
        for angle in [index::ROLL, index::PITCH, index::HEADING] {
            against.state[angle] = Dual64::from(now.state[angle]);
        }
        against.current = self.seeded_current(now.current, tangents);
        let Motion { u, v, w, .. } = against.motion();
        for (index, velocity) in [(index::SURGE, u), (index::SWAY, v), (index::HEAVE, w)] {
            tangents[Q::State(index).number()] = -velocity.eps;
        }
    }

    fn seeded_current(&self, current: [f64; 3], tangents: &[f64]) -> [Dual64; 3] {
        std::array::from_fn(|axis| Dual64::new(current[axis], tangents[Q::Current(axis).number()]))
    }

    fn seeded(&self, tangents: &[f64]) -> Instant<Dual64> {
        let dual = |value: f64, quantity: Q| Dual64::new(value, tangents[quantity.number()]);
        let now = self.instant();
        let in_current = Instant {
            time: dual(now.time, Q::Time),
            state: std::array::from_fn(|index| dual(now.state[index], Q::State(index))),
            current: self.seeded_current(self.inputs.current.in_earth(), tangents),
            operating_speed: dual(now.operating_speed, Q::OperatingSpeed),
            given_speed: dual(now.given_speed, Q::GivenSpeed),
            load: std::array::from_fn(|axis| dual(now.load[axis], Q::External(axis))),
        };
        self.plant.in_water(&in_current)
    }

    /// Returns the output that an input requests from an actuator, with its derivative.
    fn seeded_command(&self, index: usize, tangents: &[f64]) -> Dual64 {
        let (output, slope) = self.plant.actuators()[index].requested_output(self.inputs.commands[index]);
        Dual64::new(output, slope * tangents[Q::command(index)])
    }

    fn seeded_output(&self, index: usize, tangents: &[f64]) -> Dual64 {
        let actuator = &self.plant.actuators()[index];
        if actuator.lag > 0.0 {
            Dual64::new(self.plant.outputs()[index], tangents[Q::output(index)])
        } else {
            actuator.saturate(self.seeded_command(index, tangents))
        }
    }
}
