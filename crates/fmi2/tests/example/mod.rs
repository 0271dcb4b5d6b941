//! A small model with a variable of each type: a first-order lag, `y' = (gain u - y)/tau`; its `count` increases every
//! second.

use squid_fmi2::model_description::{DefaultExperiment, Enumeration};
use squid_fmi2::{
    About, Log, Model, Moment, ResourceError, Resources, Role, SavedState, StateError, Tangents, Variable,
};

#[derive(Debug, Clone)]
pub struct Lag {
    pub gain: f64,
    pub u: f64,
    pub y: f64,
    pub count: i32,
    pub armed: bool,
    pub label: String,
    pub method: i32,
}

#[derive(Debug, thiserror::Error)]
pub enum LagError {
    #[error(transparent)]
    Resource(#[from] ResourceError),
    #[error("resources/gain.txt holds '{found}', which is no number")]
    NoNumber { found: String },
    #[error("gain 0 lets nothing through")]
    NoGain,
}

const TAU: f64 = 0.5;

pub fn methods() -> Enumeration {
    Enumeration::new("Method", "how to integrate", &[("exact", "exponential"), ("panic", "a defect")])
}

impl Model for Lag {
    type Error = LagError;

    fn load(resources: &Resources) -> Result<Self, LagError> {
        let text = resources.text("gain.txt")?.trim();
        let gain = text.parse().map_err(|_| LagError::NoNumber { found: text.to_owned() })?;
        Ok(Self { gain, u: 0.0, y: 0.0, count: 0, armed: true, label: "lag".to_owned(), method: 1 })
    }

    fn about(&self) -> About {
        About {
            identifier: "lag".to_owned(),
            name: "First-order lag".to_owned(),
            description: "A test".to_owned(),
            version: "1.0".to_owned(),
            enumerations: vec![methods()],
            default_experiment: DefaultExperiment {
                start_time: 0.0,
                stop_time: 1.0,
                step_size: 0.01,
                tolerance: None,
            },
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        type V = Variable<Lag>;
        type R<T> = Role<Lag, T>;
        vec![
            V::real("u", "input", |m| m.u, R::input(|m, v| m.u = v))
                .unit("rad")
                .range(-10.0, 10.0)
                .quantity(0),
            V::real("y", "output", |m| m.y, R::output())
                .unit("rad")
                .nominal(4.0)
                .depends_linearly_on("y")
                .quantity(1),
            V::real("gain", "gain", |m| m.gain, R::parameter(|m, v| m.gain = v)).nominal(2.0),
            V::integer("count", "steps so far", |m| m.count, R::output()).depends_on(&[]),
            V::boolean("armed", "lets u through", |m| m.armed, R::tunable(|m, v| m.armed = v)),
            V::string("label", "name", |m| m.label.clone(), R::parameter(|m, v| m.label = v)),
            V::enumeration("method", "way", &methods(), |m| m.method, R::parameter(|m, v| m.method = v)),
            V::real("tau", "time constant", |_| TAU, R::constant()).unit("s"),
            V::real("der(y)", "rate", |m| m.rate(), R::local())
                .unit("rad/s")
                .derivative_of("y")
                .depends_on(&["u", "y"])
                .quantity(2),
        ]
    }

    fn initialise(&mut self, _: f64, _: &mut dyn Log) -> Result<(), LagError> {
        if self.gain == 0.0 {
            return Err(LagError::NoGain);
        }
        self.y = self.gain * self.u;
        self.count = 0;
        Ok(())
    }

    fn step(&mut self, from: f64, to: f64, log: &mut dyn Log) -> Result<(), LagError> {
        assert!(self.method == 1, "method 2 is broken");
        if self.u.abs() > 10.0 {
            log.warn("input 100 % beyond its range");
        }
        let target = if self.armed { self.gain * self.u } else { 0.0 };
        self.y = target + (self.y - target) * (-(to - from) / TAU).exp();
        self.count += 1;
        Ok(())
    }

    fn pass_state(&mut self, state: &mut dyn SavedState) -> Result<(), StateError> {
        state.each(&mut [&mut self.gain, &mut self.u, &mut self.y])?;
        let [mut count, mut method] = [self.count as u64, self.method as u64];
        state.integer(&mut count)?;
        state.boolean(&mut self.armed)?;
        state.text(&mut self.label)?;
        state.integer(&mut method)?;
        self.count = i32::try_from(count).map_err(StateError::inconsistent)?;
        self.method = i32::try_from(method).map_err(StateError::inconsistent)?;
        Ok(())
    }

    fn tangents() -> Option<Tangents<Self>> {
        Some(|model, moment: Moment, tangents| {
            let gain = if model.armed { model.gain } else { 0.0 };
            if moment.initial {
                tangents[1] = model.gain * tangents[0];
            }
            tangents[2] = model.rate() * 0.0 + (gain * tangents[0] - tangents[1]) / TAU;
            Ok(())
        })
    }

    fn quantities(&self) -> usize {
        3
    }

    const MODEL_EXCHANGE: bool = true;

    fn states(&self, states: &mut [f64]) {
        states[0] = self.y;
    }

    fn set_states(&mut self, states: &[f64]) {
        self.y = states[0];
    }

    fn derivatives(&self, rates: &mut [f64]) {
        rates[0] = self.rate();
    }

    fn next_event(&self) -> Option<f64> {
        Some(f64::from(self.count))
    }

    fn event(&mut self, time: f64, _: &mut dyn Log) -> Result<(), LagError> {
        assert!(self.method == 1, "method 2 is broken");
        while f64::from(self.count) <= time {
            self.count += 1;
        }
        Ok(())
    }
}

impl Lag {
    /// Returns the derivative of the output; NaN beyond a million.
    fn rate(&self) -> f64 {
        let target = if self.armed { self.gain * self.u } else { 0.0 };
        if self.y > 1e6 { f64::NAN } else { (target - self.y) / TAU }
    }
}
