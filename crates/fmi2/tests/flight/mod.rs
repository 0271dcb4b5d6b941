//! Simulation of any model as an FMU, without the C interface.

#![allow(dead_code, unused_imports, reason = "not every test needs everything")]

#[path = "../../../base/tests/masked/mod.rs"]
mod masked;

pub use masked::masked;
use squid_fmi2::{Described, Experiment, Failure, Instance, Log, Model, Value};

#[derive(Default)]
pub struct Remember(pub Vec<String>);

impl Log for Remember {
    fn warn(&mut self, message: &str) {
        self.0.push(message.to_owned());
    }
}

/// An instance with its log.
pub struct Flight<M: Model> {
    pub instance: Instance<M>,
    pub log: Remember,
}

impl<M: Model> Flight<M> {
    /// Instantiates at a start time; [`Flight::begin`] must follow.
    pub fn prepare(described: Described<M>, start: f64) -> Self {
        let mut instance = Instance::new(described);
        instance.set_up(Experiment { start, ..Experiment::default() }).unwrap();
        Self { instance, log: Remember::default() }
    }

    /// Returns an instance ready to step from time 0.
    pub fn started(described: Described<M>) -> Self {
        let mut flight = Self::prepare(described, 0.0);
        flight.begin().unwrap();
        flight
    }

    pub fn begin(&mut self) -> Result<(), Failure<M::Error>> {
        self.instance.enter_initialization()?;
        self.exit()
    }

    /// Leaves initialization mode.
    pub fn exit(&mut self) -> Result<(), Failure<M::Error>> {
        self.instance.exit_initialization(&mut self.log)
    }

    pub fn reference(&self, name: &str) -> u32 {
        self.instance.table().reference(name).unwrap_or_else(|| panic!("no variable {name}"))
    }

    pub fn set<T: Value + Clone>(&mut self, name: &str, value: T) {
        let reference = self.reference(name);
        self.instance.set(&[reference], |_| value.clone()).unwrap();
    }

    pub fn get(&mut self, name: &str) -> f64 {
        let reference = self.reference(name);
        let mut found = f64::NAN;
        self.instance.get(&[reference], &mut self.log, |_, value| found = value).unwrap();
        found
    }

    /// Steps to a time; the last step is shorter if necessary.
    pub fn fly(&mut self, to: f64, step: f64) {
        while self.instance.time() < to - 1e-9 {
            let now = self.instance.time();
            self.instance.step(now, step.min(to - now), &mut self.log).unwrap();
        }
    }

    /// Steps to a time in equal steps.
    pub fn fly_in(&mut self, to: f64, steps: u32) {
        let from = self.instance.time();
        let size = (to - from) / f64::from(steps);
        for k in 0..steps {
            self.instance.step(from + f64::from(k) * size, size, &mut self.log).unwrap();
        }
    }
}
