//! The closed loop behind the FMU interface.

use squid_auv::VIEWS;
use squid_fmi2::model_description::{DefaultExperiment, identifier};
use squid_fmi2::{About, Log, Model, Resources, SavedState, StateError, Tangents, Variable};
use squid_fmu_controller::{Axis, RESOURCE, healths, of_axis};
use squid_fmu_plant::{PlantModel, TOLERANCE};

use crate::tangents::Own;
use crate::{ClosedLoop, ClosedLoopError};
use squid_scheduled::{MANOEUVRE_RESOURCE, Manoeuvre};

impl Model for ClosedLoop {
    type Error = ClosedLoopError;

    fn load(resources: &Resources) -> Result<Self, ClosedLoopError> {
        let plant = PlantModel::load(resources)?;
        let files = (0..VIEWS.len())
            .map(|axis| of_axis(RESOURCE, axis))
            .take_while(|file| file == RESOURCE || resources.bytes(file).is_ok());
        let axes = files.map(|file| Axis::load(resources, &file)).collect::<Result<_, _>>()?;
        let manoeuvre = Manoeuvre::from_json(resources.text(MANOEUVRE_RESOURCE)?)
            .map_err(ClosedLoopError::ManoeuvreFile)?;
        Self::new(plant, axes, manoeuvre)
    }

    fn about(&self) -> About {
        let (vehicle, design) = (self.plant.vehicle(), self.axes[0].design());
        let steered = design.steered_signal();
        let other = |axis: &Axis| {
            format!(" and its {} controller '{}'", axis.design().steered_signal(), axis.design().design)
        };
        let turning: String = self.axes.iter().skip(1).map(other).collect();
        About {
            identifier: identifier(&vehicle.name),
            name: vehicle.name.clone(),
            description: format!(
                "{} ({} coefficients) in closed loop with its LPV {steered} controller '{}'{turning}, performing a \
                 {steered} step during a speed ramp",
                vehicle.name,
                vehicle.status.word(),
                design.design
            ),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            enumerations: [self.plant.fidelities(), vec![healths()]].concat(),
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: self.manoeuvre.duration,
                step_size: design.sample_time,
                tolerance: Some(TOLERANCE),
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        crate::variables::table(self)
    }

    fn initialise(&mut self, start: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.start(start, log)
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.plant.stands_at(from)?;
        self.axes.iter().try_for_each(|axis| axis.keeps_up(from))?;
        self.advance(to, log)
    }

    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        state.each(&mut self.manoeuvre.numbers())?;
        for step in self.manoeuvre.steps.values_mut() {
            state.real(step)?;
        }
        state.boolean(&mut self.outside.manual)?;
        state.reals(&mut self.outside.references)?;
        state.reals(&mut self.outside.slopes)?;
        self.plant.pass_state(state)?;
        self.axes.iter_mut().try_for_each(|axis| axis.pass_state(state))
    }

    fn tangents() -> Option<Tangents<Self>> {
        Some(Self::carry)
    }

    fn quantities(&self) -> usize {
        Own::count(self.plant.vehicle().actuators.len())
    }

    // The states of model exchange are those of the plant, and every tick of the autopilot is a time event.
    const MODEL_EXCHANGE: bool = true;

    fn states(&self, states: &mut [f64]) {
        self.plant.states(states);
    }

    fn set_states(&mut self, states: &[f64]) {
        self.plant.set_states(states);
    }

    fn set_time(&mut self, time: f64) {
        self.plant.set_time(time);
    }

    fn apply_inputs(&mut self) -> Result<(), ClosedLoopError> {
        Ok(self.plant.apply_inputs()?)
    }

    fn tune(&mut self) -> Result<(), ClosedLoopError> {
        Ok(self.plant.tune()?)
    }

    fn derivatives(&self, rates: &mut [f64]) {
        self.plant.derivatives(rates);
    }

    fn input_rates(&self, tangents: &mut [f64]) {
        self.plant.input_rates(tangents);
    }

    fn next_event(&self) -> Option<f64> {
        Some(self.axes[0].autopilot().next_tick_time())
    }

    /// Runs the tick that is due; returns an error if the importer has skipped more than one time event.
    fn event(&mut self, time: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.axes[0].keeps_up(time)?;
        if self.axes[0].autopilot().is_due_at(time) {
            self.tick(log)?;
        }
        Ok(())
    }

    fn step_completed(&mut self, log: &mut dyn Log) {
        self.plant.step_completed(log);
    }
}
