//! Limits of the references.

use crate::ControllerDesign;
use crate::design::{OverSpeed, ReferenceLimits};
use crate::trim::{AtSpeed, Trim};

/// The limits of each reference.
///
/// ```text
/// r_i = clamp(asked_i, least_i(V_r), largest_i(V_r))                         range
/// r_i = clamp(r_i, last_i + Ts slowest_i(V_r), last_i + Ts fastest_i(V_r))   rate
/// ```
#[derive(Debug)]
pub(crate) struct Envelope {
    sample_time: f64,
    /// Those of each signal with a reference.
    limits: Vec<ReferenceLimits>,
}

/// A reference as it is used.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Used {
    pub(crate) value: f64,
    /// Its slope over what is asked: 0 at a limit.
    pub(crate) by_asked: f64,
    /// Its slope over the speed V_r.
    pub(crate) by_speed: f64,
}

impl Envelope {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Self {
        let of =
            |(signal, _): (&crate::Port, _)| design.envelope.get(&signal.name).cloned().unwrap_or_default();
        Self { sample_time: design.sample_time, limits: design.references().map(of).collect() }
    }

    /// Whether the rate of a reference is limited.
    pub(crate) fn has_rate(&self, signal: usize) -> bool {
        self.limits[signal].rate.is_some()
    }

    /// A reference within its range and, after a `last` one, its rate, at a speed V_r.
    pub(crate) fn used(&self, signal: usize, asked: f64, last: Option<f64>, trim: AtSpeed<'_>) -> f64 {
        let ReferenceLimits { range, rate } = &self.limits[signal];
        let mut value = asked;
        if let Some([least, most]) = range {
            value = within(value, trim.of(least), trim.of(most));
        }
        if let Some(([least, most], last)) = rate.as_ref().zip(last) {
            let [slowest, fastest] = [least, most].map(|end| last + self.sample_time * trim.of(end));
            value = within(value, slowest, fastest);
        }
        value
    }

    /// As [`used`](Self::used), with slopes.
    #[inline]
    pub(crate) fn tangent(
        &self,
        signal: usize,
        asked: f64,
        last: Option<f64>,
        (trim, speed): (&Trim, f64),
    ) -> Used {
        let ReferenceLimits { range, rate } = &self.limits[signal];
        let value = self.used(signal, asked, last, trim.at(speed));
        let ends = |ends: &Option<[OverSpeed; 2]>, base: f64, scale: f64| {
            let end =
                |end: &OverSpeed| (base + scale * trim.at(speed).of(end), scale * trim.slope_of(speed, end));
            ends.as_ref().map(|ends| [end(&ends[0]), end(&ends[1])])
        };
        let of_rate = last.and_then(|last| ends(rate, last, self.sample_time));
        let reached = of_rate.into_iter().chain(ends(range, 0.0, 1.0)).flatten();
        let at_end =
            reached.filter(|(end, _)| value != asked && *end == value).map(|(_, slope)| slope).next();
        Used { value, by_asked: if at_end.is_some() { 0.0 } else { 1.0 }, by_speed: at_end.unwrap_or(0.0) }
    }
}

/// As [`f64::clamp`], but rounding may bring the ends past one another.
fn within(value: f64, least: f64, most: f64) -> f64 {
    if value < least {
        least
    } else if value > most {
        most
    } else {
        value
    }
}
