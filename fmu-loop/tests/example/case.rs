//! Cases for derivatives: two vehicles, both fidelities, and two designs.

#![allow(dead_code, reason = "not every test needs everything")]

use squid_fmi2::model_description::{Causality, Kind, ModelDescription};
use squid_fmi2::{Described, Experiment, Instance, Interface, Model, Resources, Silent, describe};

use crate::example::{SEA, resources, turning, with_curves, with_given_speed, with_two_degrees, without_lag};

/// Files, number of the equations of motion, and use of waves of one case.
#[derive(Clone, Copy)]
pub struct Case {
    pub resources: fn() -> Resources,
    pub fidelity: i32,
    pub waves: bool,
}

pub const SQUID: Case = Case { resources, fidelity: 1, waves: false };
pub const LPV: Case = Case { resources, fidelity: 2, waves: false };
pub const WITHOUT_LAG: Case = Case { resources: without_lag, fidelity: 1, waves: false };
pub const TWO_DEGREES: Case = Case { resources: with_two_degrees, fidelity: 1, waves: false };
pub const CURVED: Case = Case { resources: with_curves, fidelity: 1, waves: false };
pub const GIVEN: Case = Case { resources: with_given_speed, fidelity: 1, waves: false };
pub const GIVEN_LPV: Case = Case { resources: with_given_speed, fidelity: 2, waves: false };
pub const WAVES: Case = Case { waves: true, ..TWO_DEGREES };
pub const LPV_WAVES: Case = Case { waves: true, ..LPV };
pub const TURNING: Case = Case { resources: turning, fidelity: 1, waves: false };
pub const TURNING_WAVES: Case = Case { waves: true, ..TURNING };
pub const CASES: [Case; 11] = [
    SQUID,
    LPV,
    WITHOUT_LAG,
    TWO_DEGREES,
    CURVED,
    GIVEN,
    GIVEN_LPV,
    WAVES,
    LPV_WAVES,
    TURNING,
    TURNING_WAVES,
];

/// Sets the waves of [`SEA`] at a depth of 4 m; does nothing for a model without waves.
pub fn set_waves<M: Model>(instance: &mut Instance<M>) {
    for (name, value) in SEA.into_iter().chain([("initial_depth", 4.0)]) {
        if let Some(parameter) = instance.table().reference(name) {
            instance.set(&[parameter], |_| value).unwrap();
        }
    }
}

impl Case {
    pub fn describe<M: Model>(self) -> Described<M> {
        describe(&(self.resources)()).unwrap()
    }

    /// Returns an instance in initialisation mode.
    pub fn instance<M: Model>(self, interface: Interface) -> Instance<M> {
        let mut instance = self.set_up(interface);
        instance.enter_initialization().unwrap();
        instance
    }

    /// Returns an instance before initialisation mode.
    pub fn set_up<M: Model>(self, interface: Interface) -> Instance<M> {
        let mut instance = Instance::made_for(interface, self.describe::<M>());
        instance.set_up(Experiment::default()).unwrap();
        if let Some(fidelity) = instance.table().reference("fidelity") {
            instance.set(&[fidelity], |_| self.fidelity).unwrap();
        }
        if self.waves {
            set_waves(&mut instance);
        }
        instance
    }
}

pub fn described<M: Model>() -> ModelDescription {
    SQUID.describe::<M>().description
}

pub fn instance<M: Model>(interface: Interface) -> Instance<M> {
    SQUID.instance(interface)
}

/// Returns an instance ready to step, or in event mode.
pub fn started<M: Model>(interface: Interface) -> Instance<M> {
    let mut instance = instance(interface);
    instance.exit_initialization(&mut Silent).unwrap();
    instance
}

/// Returns reference, start and nominal value of the Real variables of a causality.
pub fn real_of(description: &ModelDescription, causality: Causality) -> Vec<(u32, f64, f64)> {
    let all = description.variables.iter().filter(|one| one.causality == causality);
    let number = |one: &squid_fmi2::model_description::ScalarVariable| match one.kind {
        Kind::Real { start, nominal, .. } => {
            Some((one.value_reference, start.unwrap_or(0.0), nominal.unwrap_or(1.0)))
        }
        _ => None,
    };
    all.filter_map(number).collect()
}

pub fn references(signals: &[(u32, f64, f64)]) -> Vec<u32> {
    signals.iter().map(|one| one.0).collect()
}

pub fn read<M: Model>(instance: &mut Instance<M>, references: &[u32]) -> Vec<f64> {
    let mut values = Vec::new();
    instance.get(references, &mut Silent, |_, value: f64| values.push(value)).unwrap();
    values
}

pub fn write<M: Model>(instance: &mut Instance<M>, references: &[u32], values: &[f64]) {
    instance.set(references, |position| values[position]).unwrap();
}
