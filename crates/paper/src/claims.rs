//! Rules by which a vehicle confirms the paper's claims: numbers, each with its criterion as text.

use squid_base::numbers::decimals;
use squid_report::page::Part;

/// Outcome of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finding {
    /// The numbers satisfy the criterion.
    Confirmed,
    /// Some of the numbers satisfy it.
    Partly,
    /// No number satisfies it.
    NotConfirmed,
    /// Numbers are missing.
    Unknown,
}

impl Finding {
    /// Returns the finding as text.
    pub fn text(self) -> &'static str {
        match self {
            Finding::Confirmed => "confirmed",
            Finding::Partly => "partly confirmed",
            Finding::NotConfirmed => "not confirmed",
            Finding::Unknown => "undecided",
        }
    }

    /// Returns the CSS class of its mark.
    pub fn class(self) -> &'static str {
        match self {
            Finding::Confirmed => "yes",
            Finding::Partly => "partly",
            Finding::NotConfirmed => "no",
            Finding::Unknown => "unknown",
        }
    }

    /// Confirmed if all answers are true, partly if some are, else not confirmed; unknown if an answer is missing.
    fn of(answers: impl IntoIterator<Item = Option<bool>>) -> Self {
        let Some(answers) = answers.into_iter().collect::<Option<Vec<bool>>>() else {
            return Finding::Unknown;
        };
        match answers.iter().filter(|good| **good).count() {
            _ if answers.is_empty() => Finding::Unknown,
            0 => Finding::NotConfirmed,
            good if good == answers.len() => Finding::Confirmed,
            _ => Finding::Partly,
        }
    }
}

/// Tested claim of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// Text of the claim.
    pub claim: &'static str,
    /// Criterion of the finding.
    pub criterion: String,
    /// Outcome of the test.
    pub finding: Finding,
    /// Numbers that support the finding.
    pub because: String,
}

/// Contents of a section, and its claims.
pub type Found = (Vec<Part>, Vec<Claim>);

/// Error (%) below which differences are rounding.
const EXACT: f64 = 1e-8;

/// Describes the errors (%) of the fits of order 1 and 2, with their ratio.
pub fn compared(first: f64, second: f64) -> String {
    let percent = |v: f64| {
        if v.is_nan() {
            "unknown".to_owned()
        } else if v < EXACT {
            "no more than rounding".to_owned()
        } else {
            format!("{} %", decimals(v, if v < 0.1 { (1.0 - v.log10().floor()) as usize } else { 2 }))
        }
    };
    let text = format!("{} with order 1 and {} with order 2", percent(first), percent(second));
    if first.is_nan() || second.is_nan() || first.min(second) < EXACT {
        return text;
    }
    let (ratio, which) =
        if first < second { (second / first, "larger") } else { (first / second, "smaller") };
    format!("{text}, {} times {which}", decimals(ratio, if ratio < 100.0 { 1 } else { 0 }))
}

/// Factor by which an error must be smaller to count as much smaller.
pub const MUCH: f64 = 2.0;

/// Confirms that the second error is smaller than the first by the factor [`MUCH`]; partly, if it is merely smaller.
pub fn much_smaller(first: f64, second: f64) -> Finding {
    if first.is_nan() || second.is_nan() || (first < EXACT && second < EXACT) {
        Finding::Unknown
    } else if first >= MUCH * second && first > 0.0 {
        Finding::Confirmed
    } else if first > second {
        Finding::Partly
    } else {
        Finding::NotConfirmed
    }
}

/// Least damping ratio of a short-period mode in the best class of MIL-F-8785C (1980), table IV.
pub const LEAST_DAMPING: f64 = 0.35;

/// Confirms that all damping ratios, of modes and of responses, are at least [`LEAST_DAMPING`].
pub fn well_damped(ratios: &[f64]) -> Finding {
    Finding::of(ratios.iter().map(|z| (!z.is_nan()).then_some(*z >= LEAST_DAMPING)))
}

/// Returns the damping ratio of the second-order system whose impulse response swings back as far as this one, by the
/// logarithmic decrement: `zeta = d/sqrt(pi^2 + d^2)`, `d = ln(peak/largest swing back after it)`. 1 without a swing
/// back.
///
/// Source: L. Meirovitch, Fundamentals of Vibrations, 2001, section 2.3.
pub fn equivalent_damping(impulse_response: &[f64]) -> f64 {
    let Some((at, peak)) =
        impulse_response.iter().copied().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    else {
        return f64::NAN;
    };
    if peak == 0.0 || !peak.is_finite() {
        return f64::NAN;
    }
    let swing_back = impulse_response[at..].iter().map(|v| -v / peak).fold(0.0, f64::max);
    if swing_back <= 0.0 {
        return 1.0;
    }
    let decrement = -swing_back.ln();
    decrement / decrement.hypot(std::f64::consts::PI)
}

/// Confirms that all values are below a limit.
pub fn all_below(values: &[f64], limit: f64) -> Finding {
    Finding::of(values.iter().map(|v| (!v.is_nan()).then_some(*v < limit)))
}

/// Confirms that in each pair the first number is smaller than the second.
pub fn each_smaller(pairs: &[(f64, f64)]) -> Finding {
    Finding::of(pairs.iter().map(|(a, b)| (!a.is_nan() && !b.is_nan()).then_some(a < b)))
}

/// Returns the key at which a measure is largest; `None` without numbers or if several keys share the largest.
pub fn worst(measure: &[(f64, f64)]) -> Option<f64> {
    if measure.iter().any(|(_, v)| v.is_nan()) {
        return None;
    }
    let most = measure.iter().map(|m| m.1).fold(f64::NEG_INFINITY, f64::max);
    let mut at = measure.iter().filter(|m| m.1 == most);
    at.next().filter(|_| at.next().is_none()).map(|m| m.0)
}

/// Confirms that every measure of the control effort is largest below a speed (m/s). Each measure is a list of (speed,
/// effort); one with the same largest value at several speeds is left out.
pub fn hardest_below(speed: f64, measures: &[Vec<(f64, f64)>]) -> Finding {
    let answers: Vec<Option<bool>> =
        measures.iter().filter_map(|m| worst(m)).map(|at| Some(at < speed)).collect();
    Finding::of(answers)
}

/// Confirms that a choice has the least cost in every measure. Each measure is a list of (choice, cost).
pub fn best(choice: f64, measures: &[Vec<(f64, f64)>]) -> Finding {
    Finding::of(measures.iter().filter_map(|m| least(m)).map(|at| Some(at == choice)))
}

/// Returns the key at which a measure is least; `None` in the cases of [`worst`].
pub fn least(measure: &[(f64, f64)]) -> Option<f64> {
    worst(&measure.iter().map(|(key, v)| (*key, -v)).collect::<Vec<_>>())
}

/// Confirms that a loop is robustly stable for all of the declared uncertainty. Each case has an upper and a lower
/// bound on mu (not-a-number for none): stable if the upper bound is below 1, unstable if the lower bound is at least
/// 1, else unknown.
pub fn stays_stable(bounds: &[(f64, f64)]) -> Finding {
    let case = |&(upper, lower): &(f64, f64)| match () {
        () if upper < 1.0 => Some(true),
        () if lower >= 1.0 => Some(false),
        () => None,
    };
    Finding::of(bounds.iter().map(case))
}

/// Figures of a flight under a ramp of speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RampFigures {
    /// Root mean square of the pitch error from the step on, relative to the step.
    pub error: f64,
    /// Root mean square of the pitch error over the last tenth of the flight, relative to the step.
    pub error_at_end: f64,
    /// Largest change of a command from one tick to the next, relative to the actuator's reach, except in the second
    /// after the step.
    pub jump: f64,
}

/// Pitch error at the end of a flight, relative to the step, above which the flight has not come to rest.
pub const AT_REST: f64 = 0.05;

/// Factor on the errors and jumps of the scheduled flight above which those of a switched one count as worse.
pub const WORSE: f64 = 1.1;

/// Judges if switching degrades the loop. Confirmed, if a switched flight does not come to rest although the scheduled
/// one does, or if alternation between stable controllers makes the loop unstable (a growth rate above 0); partly, if
/// neither, but a switched flight has errors or jumps above [`WORSE`] times those of the scheduled one.
pub fn switching_harms(scheduled: RampFigures, switched: &[RampFigures], rates: &[f64]) -> Finding {
    let numbers = |r: &RampFigures| !(r.error.is_nan() || r.error_at_end.is_nan() || r.jump.is_nan());
    if switched.is_empty() || !numbers(&scheduled) || !switched.iter().all(numbers) {
        return Finding::Unknown;
    }
    let rests = |r: &RampFigures| r.error_at_end <= AT_REST;
    if rates.iter().any(|r| *r > 0.0) || (rests(&scheduled) && !switched.iter().all(rests)) {
        return Finding::Confirmed;
    }
    let worse = |r: &RampFigures| r.error > WORSE * scheduled.error || r.jump > WORSE * scheduled.jump;
    if switched.iter().any(worse) { Finding::Partly } else { Finding::NotConfirmed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn much_smaller_both_ways() {
        assert_eq!(much_smaller(3.0, 1.0), Finding::Confirmed);
        assert_eq!(much_smaller(1.5, 1.0), Finding::Partly);
        assert_eq!(much_smaller(1.0, 1.5), Finding::NotConfirmed);
        assert_eq!(much_smaller(0.0, 0.0), Finding::Unknown);
        assert_eq!(much_smaller(f64::NAN, 1.0), Finding::Unknown);
        assert_eq!(much_smaller(3e-13, 1e-13), Finding::Unknown);
        assert_eq!(much_smaller(3.0, 1e-13), Finding::Confirmed);
    }

    #[test]
    fn compares_errors_down_to_rounding() {
        let texts = [(1.54, 0.45), (0.0042, 0.002), (1.0, 2.0), (3.2, 2e-14), (3e-13, 1e-13)]
            .map(|(first, second)| compared(first, second));
        insta::assert_snapshot!(texts.join("\n"));
    }

    #[test]
    fn damping_both_ways() {
        assert_eq!(well_damped(&[0.36, 1.0]), Finding::Confirmed);
        assert_eq!(well_damped(&[0.2, 1.0]), Finding::Partly);
        assert_eq!(well_damped(&[0.2, 0.1]), Finding::NotConfirmed);
        assert_eq!(well_damped(&[0.5, f64::NAN]), Finding::Unknown);
        assert_eq!(well_damped(&[]), Finding::Unknown);
    }

    /// The damping of h = exp(-zeta t) sin(omega_d t) is recovered.
    #[test]
    fn damping_of_a_known_response() {
        for zeta in [0.1, 0.35, 0.6] {
            let damped = f64::sqrt(1.0 - zeta * zeta);
            let h: Vec<f64> = (0..20000)
                .map(|i| 1e-3 * f64::from(i))
                .map(|t| (-zeta * t).exp() * (damped * t).sin())
                .collect();
            assert!((equivalent_damping(&h) - zeta).abs() < 1e-4, "{zeta}");
        }
        assert_eq!(equivalent_damping(&[0.0, 1.0, 0.5, 0.2]), 1.0);
        assert!(equivalent_damping(&[]).is_nan());
        assert!(equivalent_damping(&[0.0, f64::INFINITY]).is_nan());
    }

    #[test]
    fn limits_both_ways() {
        assert_eq!(all_below(&[0.4, 0.9], 1.0), Finding::Confirmed);
        assert_eq!(all_below(&[0.4, 1.2], 1.0), Finding::Partly);
        assert_eq!(all_below(&[1.0], 1.0), Finding::NotConfirmed);
        assert_eq!(each_smaller(&[(1.0, 2.0), (3.0, f64::INFINITY)]), Finding::Confirmed);
        assert_eq!(each_smaller(&[(1.0, 2.0), (3.0, 2.0)]), Finding::Partly);
        assert_eq!(each_smaller(&[(f64::INFINITY, f64::INFINITY)]), Finding::NotConfirmed);
    }

    #[test]
    fn hardest_both_ways() {
        let (low, high) = (vec![(1.0, 9.0), (2.0, 3.0)], vec![(1.0, 2.0), (2.0, 3.0)]);
        let (even, none) = (vec![(1.0, 3.0), (2.0, 3.0)], vec![(1.0, f64::NAN)]);
        assert_eq!(hardest_below(1.5, &[low.clone(), low.clone(), even.clone()]), Finding::Confirmed);
        assert_eq!(hardest_below(1.5, &[low, high.clone()]), Finding::Partly);
        assert_eq!(hardest_below(1.5, &[high]), Finding::NotConfirmed);
        assert_eq!(hardest_below(1.5, &[even, none]), Finding::Unknown);
    }

    #[test]
    fn stability_both_ways() {
        assert_eq!(stays_stable(&[(0.9, 0.8), (0.5, f64::NAN)]), Finding::Confirmed);
        assert_eq!(stays_stable(&[(0.9, 0.8), (1.2, 1.1)]), Finding::Partly);
        assert_eq!(stays_stable(&[(1.2, 1.0)]), Finding::NotConfirmed);
        assert_eq!(stays_stable(&[(0.9, 0.8), (1.2, 0.9)]), Finding::Unknown);
        assert_eq!(stays_stable(&[(0.9, 0.8), (1.0, f64::NAN)]), Finding::Unknown);
        assert_eq!(stays_stable(&[(f64::NAN, f64::NAN)]), Finding::Unknown);
        assert_eq!(stays_stable(&[]), Finding::Unknown);
    }

    #[test]
    fn best_both_ways() {
        let (a, b) = (vec![(0.1, 1.0), (0.23, 0.5)], vec![(0.1, 1.0), (0.23, 1.5)]);
        assert_eq!(best(0.23, &[a.clone(), a.clone()]), Finding::Confirmed);
        assert_eq!(best(0.23, &[a, b.clone()]), Finding::Partly);
        assert_eq!(best(0.23, &[b]), Finding::NotConfirmed);
        assert_eq!(best(0.23, &[]), Finding::Unknown);
    }

    #[test]
    fn switching_both_ways() {
        let good = RampFigures { error: 0.1, error_at_end: 0.01, jump: 0.2 };
        let rough = RampFigures { jump: 0.5, ..good };
        let lost = RampFigures { error_at_end: 2.0, ..good };
        assert_eq!(switching_harms(good, &[good], &[-0.1]), Finding::NotConfirmed);
        assert_eq!(switching_harms(good, &[good, rough], &[-0.1]), Finding::Partly);
        assert_eq!(switching_harms(good, &[rough, lost], &[]), Finding::Confirmed);
        assert_eq!(switching_harms(good, &[good], &[-0.1, 0.1]), Finding::Confirmed);
        assert_eq!(switching_harms(lost, &[lost], &[]), Finding::NotConfirmed);
        assert_eq!(switching_harms(good, &[], &[]), Finding::Unknown);
        assert_eq!(switching_harms(good, &[RampFigures { error: f64::NAN, ..good }], &[]), Finding::Unknown);
    }
}
