//! Simulation loop of every flight: vehicle, environment, and a control law at each tick.

use crate::error::Error;
use crate::sea::Conditions;
use crate::surfacing::{Surfacing, surfacing};
use squid_auv::{Current, Plant, State};

/// Sampled simulation of a vehicle.
pub(crate) struct Ticks {
    pub(crate) plant: Plant,
    /// Sea; `None` for still water.
    pub(crate) conditions: Option<Conditions>,
    /// Sample time, s.
    pub(crate) sample_time: f64,
    /// Duration, s.
    pub(crate) duration: f64,
}

/// A tick: the state before the law acts, the plant that receives its commands, and the sea.
pub(crate) struct Tick<'a> {
    pub(crate) time: f64,
    pub(crate) state: State,
    pub(crate) plant: &'a mut Plant,
    pub(crate) conditions: Option<&'a mut Conditions>,
}

impl Ticks {
    /// Simulates the vehicle from tick to tick, to the end or to the surface. At each tick `environment` sets loads and
    /// scheduling speed, and returns the current, to which that of the sea is added, and the demand on the law; `law`
    /// sets the commands.
    ///
    /// # Errors
    /// [`Error::Simulation`], and the errors of the two functions.
    pub(crate) fn fly<D>(
        self,
        mut environment: impl FnMut(f64, &mut Plant) -> Result<(Current, D), Error>,
        mut law: impl FnMut(Tick<'_>, D) -> Result<(), Error>,
    ) -> Result<Option<Surfacing>, Error> {
        let Self { mut plant, mut conditions, sample_time, duration } = self;
        let bottom = conditions.as_ref().map(Conditions::bottom).unwrap_or_default();
        for k in 0..=(duration / sample_time).round() as u64 {
            let time = k as f64 * sample_time;
            let (current, demand) = environment(time, &mut plant)?;
            let gauss_markov = conditions.as_ref().map(Conditions::gauss_markov).unwrap_or_default();
            plant.set_current(current + gauss_markov)?;
            let state = plant.state();
            let state = State { bottom: bottom.depth_at(state.x, state.east), ..state };
            let end = surfacing(conditions.as_ref(), time, &state);
            if end.is_some() {
                return Ok(end);
            }
            law(Tick { time, state, plant: &mut plant, conditions: conditions.as_mut() }, demand)?;
            conditions.iter_mut().for_each(|sea| sea.advance(sample_time));
            plant.advance((k + 1) as f64 * sample_time)?;
        }
        Ok(None)
    }
}
