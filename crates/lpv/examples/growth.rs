//! Growth of time and memory of a synthesis with the number of states n and of parameter channels r.
//!
//! `growth N R` designs one controller and prints one row: n, r, seconds, peak memory in MB, the least gamma, the
//! proved bound. Run one process per size, because the peak is that of the process (Linux; elsewhere `nan`).
//!
//! The plant is a chain of n/2 unit masses between two walls. Springs and dampers connect neighbours; three parameters
//! change r of them by up to 20 %, each several at once. Two forces act on the two end masses, whose positions are
//! measured with noise. The plant is well posed for every parameter value, moderately damped, and Dtt = 0.

use squid_lpv::error::SynthesisError;
use squid_lpv::matrix::Mat;
use squid_lpv::partition::Group::{T, U, W, X, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::{Options, synthesise};
use std::process::ExitCode;
use std::time::Instant;

/// Stiffness and damping of every link, in N/m and N s/m, for masses of 1 kg.
const STIFFNESS: f64 = 1.0;
const DAMPING: f64 = 0.3;
/// The largest relative change by a parameter.
const CHANGE: f64 = 0.2;

/// Returns the masses that a link connects: +1 and -1, or a single 1 at a wall.
fn link(k: usize, masses: usize) -> Mat {
    Mat::from_fn(masses, 1, |i, _| match (i + 1 == k, i == k) {
        (true, _) => -1.0,
        (_, true) => 1.0,
        _ => 0.0,
    })
}

/// Returns `[link, is a damper]` of every channel: the springs along the chain first, then the dampers.
fn changed(masses: usize, r: usize) -> Vec<(usize, bool)> {
    let links = masses + 1;
    let springs = r.min(links);
    let spread = |count: usize, damper: bool| (0..count).map(move |c| (c * links / count.max(1), damper));
    spread(springs, false).chain(spread(r - springs, true)).collect()
}

/// Returns r channels divided among three parameters: `[3, 3, 2]` for r = 8.
fn repetitions(r: usize) -> Vec<usize> {
    (0..3).map(|i| (r + 2 - i) / 3).filter(|&count| count > 0).collect()
}

/// Returns the chain with n states and r channels.
fn chain(n: usize, r: usize) -> Result<GeneralisedPlant, SynthesisError> {
    let masses = n / 2;
    let mut a = Mat::zeros(n, n);
    for k in 0..=masses {
        let pull = link(k, masses);
        let stiffness = &pull * pull.transpose();
        for (column, size) in [(0, STIFFNESS), (masses, DAMPING)] {
            let mut part = a.view_mut((masses, column), (masses, masses));
            part -= &stiffness * size;
        }
    }
    a.view_mut((0, masses), (masses, masses)).fill_with_identity();
    let (mut bt, mut ct) = (Mat::zeros(n, r), Mat::zeros(r, n));
    for (channel, (k, damper)) in changed(masses, r).into_iter().enumerate() {
        let pull = link(k, masses);
        let (column, size) = if damper { (masses, DAMPING) } else { (0, STIFFNESS) };
        bt.view_mut((masses, channel), (masses, 1)).copy_from(&(-&pull));
        ct.view_mut((channel, column), (1, masses)).copy_from(&(pull.transpose() * (CHANGE * size)));
    }
    let ends = [0, masses - 1];
    let forces = Mat::from_fn(n, 2, |i, j| f64::from(u8::from(i == masses + ends[j])));
    let positions = Mat::from_fn(2, n, |i, j| f64::from(u8::from(j == ends[i])));
    let beside = |m: &Mat, left: usize, total: usize| {
        let mut out = Mat::zeros(m.nrows(), total);
        out.columns_mut(left, m.ncols()).copy_from(m);
        out
    };
    let (noise, effort) = (Mat::identity(2, 2) * 0.1, Mat::identity(2, 2) * 0.3);
    let blocks = [
        (X, X, a),
        (X, T, bt),
        (X, W, beside(&forces, 0, 4)),
        (X, U, forces),
        (T, X, ct),
        (Z, X, beside(&positions.transpose(), 0, 4).transpose()),
        (Z, U, beside(&effort, 2, 4).transpose()),
        (Y, X, positions),
        (Y, W, beside(&noise, 2, 4)),
    ];
    Ok(GeneralisedPlant::new(repetitions(r), &blocks)?)
}

/// Returns the peak memory of this process, in MB.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes =
        line.and_then(|rest| rest.split_whitespace().next()).and_then(|word| word.parse::<f64>().ok());
    kilobytes.unwrap_or(f64::NAN) / 1024.0
}

fn main() -> ExitCode {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let &[n, r] = sizes.as_slice() else {
        eprintln!("two numbers are needed: the states n and the channels r");
        return ExitCode::FAILURE;
    };
    if n < 4 || n % 2 == 1 || r < 3 || r > n + 2 {
        eprintln!("n = {n}, r = {r}: n must be even and at least 4, r from 3 to n + 2");
        return ExitCode::FAILURE;
    }
    let begin = Instant::now();
    match chain(n, r).and_then(|plant| synthesise(&plant, Options::default())) {
        Ok(design) => {
            let seconds = begin.elapsed().as_secs_f64();
            let (least, proved) = (design.gamma_optimum, design.certified.gamma);
            println!("{n} {r} {seconds:.3} {:.1} {least:.6} {proved:.6}", peak_memory());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("n = {n}, r = {r}: {error}");
            ExitCode::FAILURE
        }
    }
}
