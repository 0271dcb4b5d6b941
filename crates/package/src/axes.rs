//! The axes that are packed into one FMU: one, or one of pitch or depth and one of heading.

use crate::error::Error;
use auv::Vehicle;
use scheduled::Manoeuvre;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;

/// What there is of each axis.
#[derive(Debug, Clone, Copy)]
pub struct Axes<T> {
    /// Of the axis of pitch or depth; of that of heading if there is no other.
    pub first: T,
    /// Of the axis of heading beside it.
    pub heading: Option<T>,
}

impl<T> Axes<T> {
    /// References to what there is.
    pub fn as_ref(&self) -> Axes<&T> {
        Axes { first: &self.first, heading: self.heading.as_ref() }
    }

    /// What is made of each.
    pub fn map<U>(self, mut made: impl FnMut(T) -> U) -> Axes<U> {
        Axes { first: made(self.first), heading: self.heading.map(made) }
    }

    /// As [`Axes::map`], until something fails.
    ///
    /// # Errors
    /// The first of `made`.
    pub fn try_map<U, E>(self, mut made: impl FnMut(T) -> Result<U, E>) -> Result<Axes<U>, E> {
        Ok(Axes { first: made(self.first)?, heading: self.heading.map(made).transpose()? })
    }

    /// What the proofs of two axes do not say; `coupled` is whether there is one of both together.
    pub fn unproved(&self, coupled: bool) -> Option<&'static str> {
        self.heading.is_some().then_some(if coupled {
            "Beyond that each axis is proved alone, about straight level flight without roll. What is proved of both \
             is of the linear motion, in continuous time and without limits of actuators; the rest is simulated (squid \
             simulate --heading)."
        } else {
            "Each axis is proved alone, about straight level flight without roll, where the two decouple. What a turn \
             or a roll couples is simulated, and checked in frozen turns (squid simulate --heading), not proved."
        })
    }

    /// Words about an axis that is called `name`: after its name, if there is another axis.
    pub fn said(&self, name: &str, words: &str) -> String {
        if self.heading.is_some() { format!("{name}: {words}") } else { words.to_owned() }
    }
}

impl<T> IntoIterator for Axes<T> {
    type Item = T;
    type IntoIter = std::iter::Chain<std::iter::Once<T>, std::option::IntoIter<T>>;

    /// The first, then that of heading.
    fn into_iter(self) -> Self::IntoIter {
        std::iter::once(self.first).chain(self.heading)
    }
}

/// The files of each axis, and its stored design.
pub type Designs<'a> = Axes<(&'a Inputs, &'a Stored)>;

impl<'a> Axes<&'a Inputs> {
    /// Checks that the axes have one clock, and a speed at which both fly.
    ///
    /// # Errors
    /// [`Error::SampleTimes`], [`Error::NoCommonSpeed`].
    pub fn check(self) -> Result<(), Error> {
        let Some(heading) = self.heading else { return Ok(()) };
        let both = [&self.first.design, &heading.design];
        let files = both.map(|design| design.source());
        let times = both.map(|design| design.sample_time);
        if times[0] != times[1] {
            return Err(Error::SampleTimes { files, times });
        }
        let speeds = both.map(|design| [design.speed_min, design.speed_max]);
        if speeds[0][0].max(speeds[1][0]) > speeds[0][1].min(speeds[1][1]) {
            let said = |i: usize| format!("{} is of {} to {} m/s", files[i], speeds[i][0], speeds[i][1]);
            return Err(Error::NoCommonSpeed { one: said(0), other: said(1) });
        }
        Ok(())
    }

    /// That one is proved at fewer speeds than the other, and that the default manoeuvre leaves a range.
    pub fn narrower(self) -> Option<String> {
        let both = [Some(self.first), self.heading].map(|inputs| inputs.map(|inputs| &inputs.design));
        let [Some(one), Some(other)] = both else { return None };
        let (low, high) = (one.speed_min.max(other.speed_min), one.speed_max.min(other.speed_max));
        let ends = [one.manoeuvre.speed_from, one.manoeuvre.speed_to];
        let leaves = ends.iter().any(|speed| *speed < low || *speed > high);
        let differs = one.speed_min != other.speed_min || one.speed_max != other.speed_max;
        differs.then(|| {
            let flown = if leaves { "; the default manoeuvre of the loop leaves that range" } else { "" };
            format!(
                "{} and {} have the speeds {low} to {high} m/s in common{flown}",
                one.source(),
                other.source()
            )
        })
    }

    /// The vehicle of plant and loop: in the vertical plane if nothing holds its heading.
    pub fn vehicle(self) -> &'a Vehicle {
        if self.heading.is_some() { &self.first.whole } else { &self.first.vehicle }
    }

    /// The default manoeuvre: that of the first axis, with the steps of the other.
    pub fn manoeuvre(self) -> Manoeuvre {
        let mut manoeuvre = self.first.design.manoeuvre.clone();
        let others = self.heading.map(|inputs| inputs.design.manoeuvre.steps.clone());
        manoeuvre.steps.extend(others.unwrap_or_default());
        manoeuvre
    }
}
