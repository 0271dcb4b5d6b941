//! The autopilot behind the FMU interface: axes that share sensors and a clock.

use squid_fmi2::model_description::{DefaultExperiment, identifier};
use squid_fmi2::{About, Log, Model, Moment, Resources, SavedState, StateError, Tangents, Variable};
use squid_scheduled::ControllerDesign;

use crate::axis::{Axis, ControllerError, RESOURCE};
use crate::tangents::Quantity;
use crate::variables::{Input, engagement, healths, inputs, outputs, stale_after, validity};

/// Returns the prefix of monitors and constants of a further axis: the name of its design.
pub fn prefix(design: &ControllerDesign) -> String {
    format!("{}_", identifier(&design.design))
}

/// The axes of an autopilot. They share the sample time and all inputs of the same name.
#[derive(Debug, Clone)]
pub struct Controller {
    axes: Vec<Axis>,
    /// Inputs that an axis shares with an earlier one: axis index and input of the earlier, then of this axis.
    shared: Vec<[(usize, Input); 2]>,
}

/// Returns the file of an axis: `controller.json` for the first, `controller_2.json` for the second, and so on.
pub fn of_axis(resource: &str, axis: usize) -> String {
    if axis == 0 { resource.to_owned() } else { resource.replace(".json", &format!("_{}.json", axis + 1)) }
}

impl Controller {
    /// Returns the axes, in the order of their files.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Adds an axis.
    fn add(&mut self, axis: Axis, file: String) -> Result<(), ControllerError> {
        let (here, design) = (self.axes.len(), axis.design());
        if let Some(first) = self.axes.first().map(Axis::design) {
            for (what, found, expected) in [
                ("vehicle", design.vehicle.name.clone(), first.vehicle.name.clone()),
                ("sample_time", design.sample_time.to_string(), first.sample_time.to_string()),
                (
                    "inputs.vehicle_sha256",
                    design.inputs.vehicle_sha256.clone(),
                    first.inputs.vehicle_sha256.clone(),
                ),
            ] {
                if found != expected {
                    return Err(ControllerError::OtherAxes { file, what, found, expected });
                }
            }
        }
        let mut commanded = self.axes.iter().flat_map(|axis| &axis.design().actuators);
        if let Some(one) = commanded.find(|one| design.actuators.iter().any(|own| own.name == one.name)) {
            return Err(ControllerError::SharedActuator { file, name: one.name.clone() });
        }
        let mut shared = vec![];
        for (name, unit, input) in inputs(design) {
            let before = self.axes.iter().enumerate().find_map(|(index, axis)| {
                let (_, unit, input) = inputs(axis.design()).find(|(one, ..)| *one == name)?;
                Some((index, unit.to_owned(), input))
            });
            if let Some((index, expected, there)) = before {
                if expected != unit {
                    let found = unit.to_owned();
                    return Err(ControllerError::OtherAxes {
                        file,
                        what: "the unit of a shared input",
                        found,
                        expected,
                    });
                }
                shared.push([(index, there), (here, input)]);
            }
        }
        self.shared.extend(shared);
        self.axes.push(axis);
        Ok(())
    }

    /// Copies shared inputs to the other axes.
    fn share(&mut self) {
        for [(from, there), (to, here)] in &self.shared {
            let value = there.of(&self.axes[*from]);
            here.set(&mut self.axes[*to], value);
            if let (Input::Measured(there), Input::Measured(here)) = (there, here) {
                self.axes[*to].valid[*here] = self.axes[*from].valid[*there];
            }
        }
        if let Some((first, others)) = self.axes.split_first_mut() {
            for axis in others {
                (axis.applied.engaged, axis.applied.given) = (first.applied.engaged, first.applied.given);
                axis.stale_after = first.stale_after;
            }
        }
    }

    /// Returns the number of the first quantity of an axis; see [`Variable::quantity`].
    fn first(&self, axis: usize) -> usize {
        self.axes[..axis].iter().map(|axis| Quantity::count(axis.design())).sum()
    }

    /// Computes the tangents of the outputs from those of the inputs.
    fn carry(&self, moment: Moment, tangents: &mut [f64]) -> Result<(), ControllerError> {
        for [(from, there), (to, here)] in &self.shared {
            let number = |axis: usize, input: Input| {
                self.first(axis) + input.quantity().number(self.axes[axis].design())
            };
            tangents[number(*to, *here)] = tangents[number(*from, *there)];
        }
        // A new value of a shared input is copied to the other axes at the next step.
        let mut next = self.clone();
        next.share();
        for (index, axis) in next.axes.iter().enumerate() {
            let first = self.first(index);
            axis.carry(moment, &mut tangents[first..first + Quantity::count(axis.design())])?;
        }
        Ok(())
    }
}

impl Model for Controller {
    type Error = ControllerError;

    fn load(resources: &Resources) -> Result<Self, ControllerError> {
        let mut controller = Self { axes: vec![], shared: vec![] };
        let files = (0..).map(|axis| of_axis(RESOURCE, axis));
        for file in files.take_while(|file| file == RESOURCE || resources.bytes(file).is_ok()) {
            controller.add(Axis::load(resources, &file)?, file)?;
        }
        Ok(controller)
    }

    fn about(&self) -> About {
        let ControllerDesign { vehicle, sample_time, .. } = self.axes[0].design();
        let name = &vehicle.name;
        let each = self.axes.iter().map(|axis| {
            let ControllerDesign { design, gamma, .. } = axis.design();
            let proof = if gamma.certified { "certified" } else { "not certified" };
            (
                axis.design().steered_signal(),
                format!("design '{design}', L2 gain below {}, {proof}", gamma.bound),
            )
        });
        let (steered, designs): (Vec<String>, Vec<String>) = each.unzip();
        About {
            identifier: format!("{}_controller", identifier(name)),
            name: format!("{name} controller"),
            description: format!(
                "LPV {} controller of {name} ({} coefficients), {}",
                steered.join(" and "),
                vehicle.status.word(),
                designs.join("; ")
            ),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            enumerations: vec![healths()],
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: 60.0,
                step_size: *sample_time,
                tolerance: None,
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        let mut table = vec![];
        for (index, axis) in self.axes.iter().enumerate() {
            let design = axis.design();
            let prefix = if index == 0 { String::new() } else { prefix(design) };
            let is_shared = |input: Input| self.shared.iter().any(|[_, here]| *here == (index, input));
            let own = || inputs(design).filter(|(.., input)| !is_shared(*input)).map(|(.., input)| input);
            let judged = self.axes.iter().any(|axis| axis.design().failsafe.is_some());
            let of_all = engagement().into_iter().chain(judged.then(stale_after)).filter(|_| index == 0);
            let valid = own().filter_map(|input| validity(input, design));
            let own = own().map(|input| input.variable(design)).chain(of_all).chain(valid);
            let all = own.chain(outputs(design, &prefix));
            let first = self.first(index);
            table.extend(all.map(|one| {
                one.embedded(move |m: &Self| &m.axes[index], move |m| &mut m.axes[index]).quantity_from(first)
            }));
        }
        table
    }

    fn initialise(&mut self, start: f64, _: &mut dyn Log) -> Result<(), ControllerError> {
        self.share();
        self.axes.iter_mut().try_for_each(|axis| axis.initialise(start))
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), ControllerError> {
        self.share();
        self.axes.iter_mut().try_for_each(|axis| axis.step(from, to, log))
    }

    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        self.axes.iter_mut().try_for_each(|axis| axis.pass_state(state))
    }

    fn tangents() -> Option<Tangents<Self>> {
        Some(Self::carry)
    }

    fn quantities(&self) -> usize {
        self.first(self.axes.len())
    }
}
