//! Limits of the references.

use super::governor::Transition;
use crate::ControllerDesign;
use crate::design::{OverSpeed, ReferenceLimits};
use crate::trim::{AtSpeed, Trim};

/// The limits of each reference.
///
/// ```text
/// target_i = clamp(asked_i, least_i(V_r), largest_i(V_r))                      range
/// r_i      = clamp((1 - share_i) target_i + share_i start_i, least_i, largest_i)   the way there, see `governor`
/// r_i      = clamp(r_i, last_i + Ts slowest_i(V_r), last_i + Ts fastest_i(V_r))    rate
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
    /// Its slope over what is asked, or over where it yields to: 0 at a limit.
    pub(crate) by_asked: f64,
    /// Its slope over the speed V_r.
    pub(crate) by_speed: f64,
    /// Its slope over the last one: 1 at its rate.
    pub(crate) by_last: f64,
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

    /// A rate within that of a reference at a speed V_r.
    pub(crate) fn rate(&self, signal: usize, rate: f64, trim: AtSpeed<'_>) -> f64 {
        match &self.limits[signal].rate {
            Some([slowest, fastest]) => within(rate, trim.of(slowest), trim.of(fastest)),
            None => rate,
        }
    }

    /// What is asked of a reference, within its range at a speed V_r.
    pub(crate) fn target(&self, signal: usize, asked: f64, trim: AtSpeed<'_>) -> f64 {
        match &self.limits[signal].range {
            Some([least, most]) => within(asked, trim.of(least), trim.of(most)),
            None => asked,
        }
    }

    /// A reference on its way to a `target` within its range and, after a `last` one, its rate, at a speed V_r.
    pub(crate) fn used(
        &self,
        signal: usize,
        target: f64,
        transition: Transition,
        last: Option<f64>,
        trim: AtSpeed<'_>,
    ) -> f64 {
        let mut value = target;
        if transition.share != 0.0 {
            value = self.target(signal, transition.to(target), trim);
        }
        if let Some(([least, most], last)) = self.limits[signal].rate.as_ref().zip(last) {
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
        transition: Transition,
        last: Option<f64>,
        (trim, speed): (&Trim, f64),
    ) -> Used {
        let ReferenceLimits { range, rate } = &self.limits[signal];
        let target = self.target(signal, asked, trim.at(speed));
        let value = self.used(signal, target, transition, last, trim.at(speed));
        let on_the_way = transition.to(target);
        let end_at = |ends: Option<&[OverSpeed; 2]>, base: f64, scale: f64, wanted: f64, reached: f64| {
            let end =
                |end: &OverSpeed| (base + scale * trim.at(speed).of(end), scale * trim.slope_of(speed, end));
            let ends = ends.map(|ends| [end(&ends[0]), end(&ends[1])]);
            let ends = ends.into_iter().flatten();
            ends.filter(|(end, _)| wanted != reached && *end == reached).map(|(_, slope)| slope).next()
        };
        let at_rate = last.and_then(|last| end_at(rate.as_ref(), last, self.sample_time, on_the_way, value));
        let at_range = || end_at(range.as_ref(), 0.0, 1.0, on_the_way, value);
        let by_last = if at_rate.is_some() { 1.0 } else { 0.0 };
        if let Some(slope) = at_rate.or_else(at_range) {
            return Used { value, by_asked: 0.0, by_speed: slope, by_last };
        }
        let free = 1.0 - transition.share;
        match end_at(range.as_ref(), 0.0, 1.0, asked, target) {
            Some(slope) => Used { value, by_asked: 0.0, by_speed: free * slope, by_last },
            None => Used { value, by_asked: free, by_speed: 0.0, by_last },
        }
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
