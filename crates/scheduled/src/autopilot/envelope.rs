//! Limits of the references.

use super::governor::Transition;
use crate::ControllerDesign;
use crate::design::{OverSpeed, ReferenceLimits};
use crate::trim::{AtSpeed, Trim};

/// Limits of each reference.
///
/// ```text
/// target_i = clamp(request_i, least_i(V_r), largest_i(V_r))                        range
/// r_i      = clamp((1 - share_i) target_i + share_i start_i, least_i, largest_i)   transition, see `governor`
/// r_i      = clamp(r_i, last_i + Ts slowest_i(V_r), last_i + Ts fastest_i(V_r))    rate
/// ```
#[derive(Debug)]
pub(crate) struct Envelope {
    sample_time: f64,
    /// Limits of each signal with a reference.
    limits: Vec<ReferenceLimits>,
}

/// Limited reference with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LimitedReference {
    pub(crate) value: f64,
    /// Derivative with respect to the request, or to the value to which it yields; 0 at a limit.
    pub(crate) by_request: f64,
    /// Derivative with respect to the speed V_r.
    pub(crate) by_speed: f64,
    /// Derivative with respect to the last reference; 1 at the rate limit, otherwise 0.
    pub(crate) by_last: f64,
}

impl Envelope {
    #[inline]
    pub(crate) fn new(design: &ControllerDesign) -> Self {
        let limits_of =
            |(signal, _): (&crate::Port, _)| design.envelope.get(&signal.name).cloned().unwrap_or_default();
        Self { sample_time: design.sample_time, limits: design.references().map(limits_of).collect() }
    }

    /// Returns `true` if the rate of a reference is limited.
    pub(crate) fn has_rate(&self, signal: usize) -> bool {
        self.limits[signal].rate.is_some()
    }

    /// Returns a rate, limited to the allowed rates of a reference at a speed V_r.
    pub(crate) fn rate(&self, signal: usize, rate: f64, trim: AtSpeed<'_>) -> f64 {
        match &self.limits[signal].rate {
            Some([slowest, fastest]) => within(rate, trim.value(slowest), trim.value(fastest)),
            None => rate,
        }
    }

    /// Returns the request, limited to the range of a reference at a speed V_r.
    pub(crate) fn target(&self, signal: usize, request: f64, trim: AtSpeed<'_>) -> f64 {
        match &self.limits[signal].range {
            Some([least, most]) => within(request, trim.value(least), trim.value(most)),
            None => request,
        }
    }

    /// Returns the reference in transition to a `target`, limited to its range and, after a `last` reference, its rate,
    /// at a speed V_r.
    pub(crate) fn limited(
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
            let [slowest, fastest] = [least, most].map(|end| last + self.sample_time * trim.value(end));
            value = within(value, slowest, fastest);
        }
        value
    }

    /// Returns the same as [`limited`](Self::limited), with derivatives.
    #[inline]
    pub(crate) fn tangent(
        &self,
        signal: usize,
        request: f64,
        transition: Transition,
        last: Option<f64>,
        (trim, speed): (&Trim, f64),
    ) -> LimitedReference {
        let ReferenceLimits { range, rate } = &self.limits[signal];
        let target = self.target(signal, request, trim.at(speed));
        let value = self.limited(signal, target, transition, last, trim.at(speed));
        let in_transition = transition.to(target);
        let end_at = |ends: Option<&[OverSpeed; 2]>, base: f64, scale: f64, unlimited: f64, limited: f64| {
            let end = |end: &OverSpeed| {
                (base + scale * trim.at(speed).value(end), scale * trim.slope_of_value(speed, end))
            };
            let ends = ends.map(|ends| [end(&ends[0]), end(&ends[1])]);
            let ends = ends.into_iter().flatten();
            ends.filter(|(end, _)| unlimited != limited && *end == limited).map(|(_, slope)| slope).next()
        };
        let at_rate =
            last.and_then(|last| end_at(rate.as_ref(), last, self.sample_time, in_transition, value));
        let at_range = || end_at(range.as_ref(), 0.0, 1.0, in_transition, value);
        let by_last = if at_rate.is_some() { 1.0 } else { 0.0 };
        if let Some(slope) = at_rate.or_else(at_range) {
            return LimitedReference { value, by_request: 0.0, by_speed: slope, by_last };
        }
        let free = 1.0 - transition.share;
        match end_at(range.as_ref(), 0.0, 1.0, request, target) {
            Some(slope) => LimitedReference { value, by_request: 0.0, by_speed: free * slope, by_last },
            None => LimitedReference { value, by_request: free, by_speed: 0.0, by_last },
        }
    }
}

/// Clamps like [`f64::clamp`], but accepts ends that rounding has swapped.
fn within(value: f64, least: f64, most: f64) -> f64 {
    if value < least {
        least
    } else if value > most {
        most
    } else {
        value
    }
}
