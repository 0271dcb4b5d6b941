//! Findings on a synthesis: the sentences of a report that qualify its numbers.

use squid_base::numbers::{at_least, at_most};
use squid_finding::Finding;
use std::fmt::Display;

pub(crate) fn better_may_exist(bound: f64, lower: Option<f64>) -> Finding {
    let none_below =
        lower.map_or_else(String::new, |lower| format!("; none has a gain below {}", at_least(lower)));
    let why = format!(
        "a controller with a gain below {} was found; a better one may exist{none_below}",
        at_most(Some(bound))
    );
    let found = Finding::new("better_may_exist", "certified_gamma", why).value(bound, "");
    lower.into_iter().fold(found, Finding::limit)
}

pub(crate) fn gamma_below_lower_bound(gamma: f64, lower: f64) -> Finding {
    let why = format!(
        "the search ended at a gamma of {gamma:.6}, which contradicts the proved lower bound {} because of rounding \
         errors: the least gamma is unknown",
        at_least(lower)
    );
    Finding::new("gamma_below_lower_bound", "gamma", why).value(gamma, "").limit(lower)
}

pub(crate) fn gamma_is_zero(gamma: f64) -> Finding {
    let why = "the computed least gamma is zero up to rounding: the gains grow as the bound decreases, and no \
               controller attains the infimum; give every control a weight and every measurement noise";
    Finding::new("gamma_is_zero", "gamma", why).value(gamma, "")
}

/// Bound above the lowest gamma, both relative to it.
pub(crate) fn bound_far_above(excess: f64, requested: f64) -> Finding {
    let why = format!(
        "the certified gamma is {:.1} % instead of {:.1} % above the lowest gamma found, because no controller \
         closer to it has a bound that is provable in double precision",
        100.0 * excess,
        100.0 * requested
    );
    Finding::new("bound_far_above", "certified_gamma", why).value(excess, "").limit(requested)
}

pub(crate) fn large_back_off(back_off: f64, requested: f64) -> Finding {
    let why = format!(
        "the controller was built {:.1} % instead of {:.1} % above the lowest gamma found, because none closer could \
            be built",
        100.0 * back_off,
        100.0 * requested
    );
    Finding::new("large_back_off", "back_off", why).value(back_off, "").limit(requested)
}

pub(crate) fn local_search() -> Finding {
    let why =
        "gamma is the result of a local search over controllers of this structure; a better one may exist";
    Finding::new("local_search", "gamma", why)
}

pub(crate) fn symmetric_unknown(reason: &dyn Display) -> Finding {
    let why = format!("the least gamma with symmetric scalings only is unknown: {reason}");
    Finding::new("symmetric_unknown", "gamma_symmetric", why)
}

pub(crate) fn for_any_rate(rate: Option<f64>, reason: &dyn Display) -> Finding {
    let why = format!(
        "the controller is the one for a parameter that changes arbitrarily fast, whose bound also holds at this \
         rate; the search at this rate failed: {reason}"
    );
    rate.into_iter().fold(Finding::new("for_any_rate", "rate", why), |found, rate| found.value(rate, "1/s"))
}

pub(crate) fn for_this_rate_only(rate: f64) -> Finding {
    let why = "the bound holds for this rate only: none was found for a parameter that changes faster";
    Finding::new("for_this_rate_only", "rate", why).value(rate, "1/s")
}

/// Weight and noise that were added to the plant for the design.
pub(crate) fn regularised(added: &dyn Display) -> Finding {
    Finding::new("regularised", "gamma_design", added.to_string())
}
