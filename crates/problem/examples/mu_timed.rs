//! Bounds mu of the problem in a file repeatedly, and prints the median of the seconds: `mu_timed FILE.json [CALLS]`.
//!
//! The file is as for `squid lpv mu`. For a matrix only `upper_bound` is timed, for a system the complete sweep over
//! frequency with the perturbation. One JSON object is printed: `seconds`, `upper`, `lower` (of a system) and
//! `intervals`.

use serde_json::json;
use squid_lpv::mu::over_frequency::mu_over_frequency;
use squid_lpv::mu::upper::upper_bound;
use squid_problem::mu_file::{MuProblem, Perturbed, mu_problem};
use squid_problem::source::Source;
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Returns the median time of a call in seconds, without the first call, and the last result.
fn timed<T, E>(calls: usize, mut call: impl FnMut() -> Result<T, E>) -> Result<(f64, T), E> {
    let mut result = call()?;
    let mut seconds = Vec::with_capacity(calls);
    for _ in 0..calls {
        let begin = Instant::now();
        result = black_box(call()?);
        seconds.push(begin.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    Ok((seconds[calls / 2], result))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("a file is needed: a problem of `squid lpv mu`")?;
    let calls = arguments.next().map_or(Ok(1), |count| count.parse::<usize>())?.max(1);
    let MuProblem { perturbed, structure, .. } = mu_problem(&Source::read(path.as_ref())?)?;
    let report = match perturbed {
        Perturbed::Matrix(m) => {
            let (seconds, bound) = timed(calls, || upper_bound(black_box(&m), &structure))?;
            json!({ "seconds": seconds, "upper": bound.value })
        }
        Perturbed::System(system) => {
            let (seconds, found) = timed(calls, || mu_over_frequency(black_box(&system), &structure))?;
            let (upper, lower) = (found.upper, found.lower.map_or(0.0, |l| l.value));
            json!({ "seconds": seconds, "upper": upper.upper, "lower": lower, "intervals": upper.pieces.len() })
        }
        Perturbed::WithPerformance(..) => {
            return Err("a problem without performance channels is needed".into());
        }
    };
    println!("{report}");
    Ok(())
}
