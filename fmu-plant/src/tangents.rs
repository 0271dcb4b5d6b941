//! Exact derivatives of the plant, by dual numbers in the code that simulates.

use auv::{Dual64, Instant, Rates};

use crate::{PlantModel, Quantity as Q};

impl PlantModel {
    /// Fills in the tangents of outputs and rates from those of inputs and states, as [`Quantity`](crate::Quantity)
    /// numbers them.
    ///
    /// In the initialization the vehicle moves through the water as the parameters prescribe, whatever the current: the
    /// velocities over ground follow from both.
    pub fn carry(&self, initial: bool, tangents: &mut [f64]) {
        if initial {
            self.carry_current(tangents);
        }
        let instant = self.seeded(tangents);
        let output = |index: usize| self.seeded_output(index, tangents);
        let rates = self.plant.rates(&instant, output);
        let motion = instant.motion();
        let Rates { surge, heave, pitch_rate, pitch, distance, depth } = rates;
        let actuators = self.plant.actuators();
        for (index, actuator) in actuators.iter().enumerate() {
            let output = self.seeded_output(index, tangents);
            let rate = actuator.output_rate(output, self.seeded_command(index, tangents));
            tangents[Q::output(index)] = output.eps;
            tangents[Q::output_rate(index)] = rate.eps;
        }
        let square = motion.u * motion.u + motion.w * motion.w;
        for (quantity, value) in [
            (Q::SurgeAcceleration, surge),
            (Q::HeaveAcceleration, heave),
            (Q::PitchAcceleration, pitch_rate),
            (Q::RateOfPitch, pitch),
            (Q::RateOfDistance, distance),
            (Q::RateOfDepth, depth),
            (Q::Speed, motion.u),
            (Q::Heave, motion.w),
        ] {
            tangents[quantity.number()] = value.eps;
        }
        // V = sqrt(u^2 + w^2) has no derivative at rest; 0 is the mean of those to either side.
        tangents[Q::PathSpeed.number()] =
            if square.re > 0.0 { 0.5 * square.eps / square.re.sqrt() } else { 0.0 };
    }

    fn carry_current(&self, tangents: &mut [f64]) {
        let still = Instant { surge: 0.0, heave: 0.0, ..self.instant() };
        let dual = |value: f64, quantity: Q| Dual64::new(value, tangents[quantity.number()]);
        let against = Instant {
            time: Dual64::from(0.0),
            surge: Dual64::from(0.0),
            heave: Dual64::from(0.0),
            pitch_rate: Dual64::from(0.0),
            pitch: Dual64::from(still.pitch),
            distance: Dual64::from(0.0),
            depth: Dual64::from(0.0),
            current_horizontal: dual(still.current_horizontal, Q::CurrentHorizontal),
            current_vertical: dual(still.current_vertical, Q::CurrentVertical),
            operating_speed: Dual64::from(0.0),
            given_speed: Dual64::from(0.0),
            load: [Dual64::from(0.0); 3],
        };
        // At rest over ground the velocity through the water is minus that of the current.
        let water = against.motion();
        tangents[Q::SurgeOverGround.number()] = -water.u.eps;
        tangents[Q::HeaveOverGround.number()] = -water.w.eps;
    }

    fn seeded(&self, tangents: &[f64]) -> Instant<Dual64> {
        let dual = |value: f64, quantity: Q| Dual64::new(value, tangents[quantity.number()]);
        let now = self.instant();
        let in_current = Instant {
            time: dual(now.time, Q::Time),
            surge: dual(now.surge, Q::SurgeOverGround),
            heave: dual(now.heave, Q::HeaveOverGround),
            pitch_rate: dual(now.pitch_rate, Q::PitchRate),
            pitch: dual(now.pitch, Q::Pitch),
            distance: dual(now.distance, Q::Distance),
            depth: dual(now.depth, Q::Depth),
            current_horizontal: dual(self.inputs.current.horizontal, Q::CurrentHorizontal),
            current_vertical: dual(self.inputs.current.vertical, Q::CurrentVertical),
            operating_speed: dual(now.operating_speed, Q::OperatingSpeed),
            given_speed: dual(now.given_speed, Q::GivenSpeed),
            load: std::array::from_fn(|i| dual(now.load[i], Q::EXTERNAL[i])),
        };
        self.plant.in_water(&in_current)
    }

    /// The output that an input asks an actuator for.
    fn seeded_command(&self, index: usize, tangents: &[f64]) -> Dual64 {
        let (asked, slope) = self.plant.actuators()[index].asked(self.inputs.commands[index]);
        Dual64::new(asked, slope * tangents[Q::command(index)])
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
