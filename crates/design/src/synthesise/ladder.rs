//! The output of `squid design --ladder`: the cost of each assumption about the speed.

use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use squid_base::numbers::rounded_up;
use squid_lpv::bounded_rate::{SlowOptions, least_gamma};
use squid_lpv::ladder::{Disorder, Ladder, LadderGain, LadderOptions, ladder};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::rate::RateOptions;
use squid_lpv::synthesis::Design;
use std::fmt::Display;
use std::time::Instant;

/// Rates of speed at which the finished loop is analysed, m/s^2.
const ACCELERATIONS: [f64; 4] = [0.01, 0.05, 0.125, 0.5];

/// The relative accuracy of each gamma of the ladder.
const LADDER_ACCURACY: f64 = 1e-3;

/// The number of speeds for which a frozen controller is computed.
const FROZEN_SPEEDS: usize = 6;

/// Computes the ladder of a finished design.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System) if the plant is not scheduled.
pub fn climb(file: &DesignFile, plant: &GeneralisedPlant, design: &Design) -> Result<String, Error> {
    let (centre, half_range) = file.scheduling();
    let speeds = Speeds { centre, half_range };
    let options = LadderOptions {
        thetas: file.spread(FROZEN_SPEEDS).into_iter().map(|v| file.rho(v)).collect(),
        rates: ACCELERATIONS.iter().map(|a| a / half_range).collect(),
        rate: RateOptions { order: 1, accuracy: LADDER_ACCURACY, ..RateOptions::default() },
        accuracy: LADDER_ACCURACY,
        lyapunov: Some(design.certified.x.clone()),
        ..LadderOptions::default()
    };
    let started = Instant::now();
    let rungs = ladder(plant, &design.controller, design.certified.gamma, &options)?;
    let mut out = best_controllers(&rungs, speeds);
    out += &at_bounded_rates(plant, speeds);
    out += &finished_loop(&rungs, speeds, options.samples, 100.0 * crate::synthesise::back_off(design));
    for disorder in rungs.disorders() {
        out += &contradiction(&disorder, speeds);
    }
    Ok(out + &format!("\nComputed in {:.1} s\n", started.elapsed().as_secs_f64()))
}

/// The relation between the scheduling parameter and speed.
#[derive(Clone, Copy)]
struct Speeds {
    centre: f64,
    half_range: f64,
}

impl Speeds {
    fn speed(self, theta: f64) -> f64 {
        self.centre + self.half_range * theta
    }

    /// The assumption of a rung.
    fn name(self, rung: LadderGain) -> String {
        match rung {
            LadderGain::FrozenOptimum(theta) => format!("for {:.2} m/s only", self.speed(theta)),
            LadderGain::Scheduled => "scheduled, for any trajectory of speed".into(),
            LadderGain::ScheduledSymmetric => "the same, symmetric scalings only".into(),
            LadderGain::FrozenGain => "constant speed".into(),
            LadderGain::BoundedRate(rate) => {
                format!("speed changing by at most {:.3} m/s^2", rate * self.half_range)
            }
            LadderGain::ArbitrarilyFast => "speed changing arbitrarily fast".into(),
            LadderGain::Certified => "the same, certified also between the samples".into(),
        }
    }
}

fn best_controllers(found: &Ladder, speeds: Speeds) -> String {
    let mut out = String::from("Least gamma of the best controller under each assumption\n");
    let gammas = found.frozen_optimum.iter().filter_map(|(_, gamma)| gamma.as_ref().ok());
    let hardest = gammas.copied().reduce(f64::max);
    for (theta, gamma) in &found.frozen_optimum {
        out += &row(&speeds.name(LadderGain::FrozenOptimum(*theta)), gamma.as_ref().copied(), None);
    }
    out += &row(&speeds.name(LadderGain::Scheduled), found.scheduled.as_ref().copied(), hardest);
    out += &row(
        &speeds.name(LadderGain::ScheduledSymmetric),
        found.scheduled_symmetric.as_ref().copied(),
        hardest,
    );
    out + "  (+ %: relative to the hardest single speed; the cost of one controller for all trajectories of speed)\n"
}

/// The least gamma of controllers for a bounded rate.
fn at_bounded_rates(plant: &GeneralisedPlant, speeds: Speeds) -> String {
    let rows = ACCELERATIONS.map(|a| {
        let options = SlowOptions { accuracy: LADDER_ACCURACY, ..SlowOptions::at(a / speeds.half_range) };
        let name = format!("scheduled, speed changing by at most {a:.3} m/s^2");
        row(&name, least_gamma(plant, options).map(|least| least.gamma), None)
    });
    rows.concat()
        + "  (at a bounded rate: computed at seven speeds only; the controller may require the acceleration as an \
            input)\n"
}

fn finished_loop(found: &Ladder, speeds: Speeds, samples: usize, back_off: f64) -> String {
    let mut out = format!(
        "\nGain of the loop with the controller of this design, built {back_off:.1} % above the least gamma\n"
    );
    let frozen = Some(found.frozen_gain.gamma);
    let worst = speeds.speed(found.frozen_gain.theta);
    let name = format!("{}, worst at {worst:.2} m/s", speeds.name(LadderGain::FrozenGain));
    out += &row(&name, Ok::<_, Error>(found.frozen_gain.gamma), None);
    for (rate, bound) in &found.bounded_rate {
        out += &row(&speeds.name(LadderGain::BoundedRate(*rate)), bound.as_ref().map(|b| b.gamma), frozen);
    }
    let fast = found.arbitrarily_fast.as_ref().map(|b| b.gamma);
    out += &row(&speeds.name(LadderGain::ArbitrarilyFast), fast, frozen);
    out += &row(&speeds.name(LadderGain::Certified), Ok::<_, Error>(rounded_up(found.certified)), frozen);
    out + &format!(
        "  (+ %: relative to constant speed. All but the last are computed at {samples} speeds only, without proof)\n"
    )
}

/// A rung: its name, its gamma or why there is none, and its increase over another.
fn row<E: Display>(name: &str, value: Result<f64, E>, above: Option<f64>) -> String {
    match value {
        Ok(gamma) => {
            let cost =
                above.map_or_else(String::new, |base| format!("{:+8.1} %", 100.0 * (gamma / base - 1.0)));
            format!("  {name:<48} {gamma:8.4}{cost}\n")
        }
        Err(reason) => format!("  {name:<48}  unknown: {reason}\n"),
    }
}

/// Two numbers at least one of which is wrong.
fn contradiction(disorder: &Disorder, speeds: Speeds) -> String {
    let Disorder { lower, upper } = disorder;
    format!(
        "  CONTRADICTION: '{}' has {:.4} and '{}' has {:.4}; theory requires the opposite order, so one of the two \
            is a numerical error\n",
        speeds.name(lower.0),
        lower.1,
        speeds.name(upper.0),
        upper.1
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_lpv::error::SynthesisError;
    use squid_lpv::ladder::FrozenGain;

    const SPEEDS: Speeds = Speeds { centre: 2.0, half_range: 1.0 };

    fn found() -> Ladder {
        let failed = || SynthesisError::Infeasible { stage: "test" };
        Ladder {
            frozen_optimum: vec![(-1.0, Ok(0.5)), (1.0, Ok(0.8))],
            scheduled: Ok(1.0),
            scheduled_symmetric: Err(failed()),
            frozen_gain: FrozenGain { gamma: 0.9, theta: 0.5, frequency: 2.0 },
            bounded_rate: vec![(0.1, Err(failed().into()))],
            arbitrarily_fast: Err(failed().into()),
            certified: 0.99,
        }
    }

    #[test]
    fn costs_are_relative_to_the_hardest_speed() {
        insta::assert_snapshot!(best_controllers(&found(), SPEEDS));
    }

    #[test]
    fn costs_of_the_finished_loop_are_relative_to_constant_speed() {
        insta::assert_snapshot!(finished_loop(&found(), SPEEDS, 33, 10.0));
    }

    #[test]
    fn a_contradiction_names_both_numbers() {
        let disorder = Disorder { lower: (LadderGain::FrozenGain, 1.2), upper: (LadderGain::Certified, 1.1) };
        insta::assert_snapshot!(contradiction(&disorder, SPEEDS));
    }
}
