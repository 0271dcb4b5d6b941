//! Gamma under each assumption about the speed.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, Part, Table};
use crate::subject::Subject;
use squid_base::numbers::rounded_up;
use squid_lpv::ladder::{Ladder, LadderOptions, ladder};
use squid_lpv::matrix::Mat;
use squid_lpv::rate::{RateOptions, rate_bounded_gain_from};
use squid_proof::claim::parse;

/// Number of speeds at which the finished loop is analysed; fewer than in `squid design --ladder`, to save time.
const SAMPLES: usize = 9;

/// Relative tolerance of each gamma.
const ACCURACY: f64 = 0.01;

/// Largest relative distance of the bounds of the gain at a bounded rate for which it is not computed.
const CLOSE: f64 = 0.05;

/// Returns the section on gamma for each assumption on the rate of the speed.
///
/// # Errors
/// [`Error::Design`] of [`ladder`].
pub fn gammas(subject: &Subject) -> Result<Vec<Part>, Error> {
    let (_, half_range) = subject.inputs.design.scheduling();
    let m = &subject.stored.manoeuvre;
    let acceleration = ((m.speed_to - m.speed_from) / m.ramp_duration).abs();
    let rate = RateOptions { order: 1, accuracy: ACCURACY, ..RateOptions::default() };
    let lyapunov = lyapunov(subject);
    let options = LadderOptions {
        // The gammas at the six speeds are already known.
        thetas: vec![],
        // The gain at a bounded rate is computed below, if its bounds are not close enough.
        rates: vec![],
        samples: SAMPLES,
        rate,
        accuracy: ACCURACY,
        lyapunov: lyapunov.clone(),
    };
    let bound = subject.stored.controller.gamma.bound;
    let gammas = ladder(&subject.plant, &subject.controller, bound, &options)?;
    let certified = rounded_up(gammas.certified);
    let fast = gammas.arbitrarily_fast.as_ref().map_or(certified, |b| b.gamma.min(certified));
    let frozen = gammas.frozen_gain.gamma;
    let slow = if fast <= (1.0 + CLOSE) * frozen {
        None
    } else {
        let samples = subject.plant.close(&subject.controller).sampled(SAMPLES)?;
        let known = lyapunov.as_ref().map(|x| (x, bound));
        rate_bounded_gain_from(&samples, acceleration / half_range, rate, known)
            .ok()
            .map(|b| b.gamma.min(fast))
    };
    let slow = slow.map_or_else(|| format!("{frozen:.4} to {fast:.4}"), |gamma| format!("{gamma:.4}"));
    let rungs = rungs(subject, &gammas, acceleration, slow);
    let mut table = Table::new(["assumption", "gamma"]);
    table.rows.extend(rungs.into_iter().map(|(name, gamma)| vec![name, gamma]));
    let back_off = subject.stored.controller.gamma.back_off;
    let built = if back_off > 0.0 {
        format!("built {:.1} % above its least gamma", 100.0 * back_off)
    } else {
        "with the given controller".to_owned()
    };
    let text = format!(
        "Rows with 'best' contain the least gamma of any controller under this assumption about the speed, within {} \
            %; 'this loop' is the final one, {built}. Only the last row holds for every trajectory of speed, also \
            between the sampled speeds; bounded rates and arbitrarily fast changes are analysed at {SAMPLES} speeds. \
            The gain at a bounded rate lies between that at constant speed and that for arbitrarily fast changes: if \
            these differ by less than {} %, or no closer bound is found, both are given.",
        100.0 * ACCURACY,
        100.0 * CLOSE
    );
    Ok(vec![Part::Text(text), Part::Figure(figure(subject, &gammas)), Part::Table(table)])
}

/// Returns the Lyapunov matrix of the stored certificate, if it claims a gain for an arbitrary rate of the speed.
fn lyapunov(subject: &Subject) -> Option<Mat> {
    let text = subject.stored.certificate.as_ref().ok()?;
    let certificate = parse(text, "certificate.json").ok()?;
    let gain = certificate.gain()?;
    let matrix = |rows: &squid_certificate::Rows| Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let factor = || gain.v.as_ref().map(|v| matrix(v).transpose() * matrix(v));
    gain.x.as_ref().map(matrix).or_else(factor)
}

/// Returns the assumptions and their gains; `slow` is the gain for a bounded acceleration (m/s^2) as text.
fn rungs(subject: &Subject, found: &Ladder, acceleration: f64, slow: String) -> Vec<(String, String)> {
    let alone = subject.alone().iter().filter_map(|design| Some(design.as_ref().ok()?.gamma_optimum));
    let number = |gamma: Option<f64>| gamma.map_or_else(|| "unknown".to_owned(), |g| format!("{g:.4}"));
    let certified = rounded_up(found.certified);
    let fast = found.arbitrarily_fast.as_ref().ok().map(|b| b.gamma.min(certified));
    vec![
        ("best controller for one frozen speed, the hardest of six".into(), number(alone.reduce(f64::max))),
        ("best scheduled controller, any trajectory of speed".into(), number(found.scheduled.clone().ok())),
        ("the same, symmetric scalings only".into(), number(found.scheduled_symmetric.clone().ok())),
        ("this loop, constant speed, worst case".into(), number(Some(found.frozen_gain.gamma))),
        (format!("this loop, speed changing by at most {acceleration:.3} m/s^2, as in the manoeuvre"), slow),
        ("this loop, speed changing arbitrarily fast".into(), number(fast)),
        ("this loop, bound for every trajectory of speed".into(), number(Some(certified))),
    ]
}

fn figure(subject: &Subject, found: &Ladder) -> Figure {
    let (low, high) = (subject.inputs.design.speed_min, subject.inputs.design.speed_max);
    let alone: Vec<(f64, f64)> = subject
        .speeds
        .iter()
        .zip(subject.alone())
        .filter_map(|(v, design)| Some((*v, design.as_ref().ok()?.gamma_optimum)))
        .collect();
    let closed = subject.plant.close(&subject.controller);
    let frozen: Vec<(f64, f64)> = subject
        .inputs
        .design
        .spread(41)
        .into_iter()
        .filter_map(|v| Some((v, closed.frozen(&[subject.rho(v)]).ok()?.hinf_norm().value)))
        .collect();
    let level = |gamma: Option<f64>| gamma.map_or_else(Vec::new, |g| vec![(low, g), (high, g)]);
    let lines = [
        ("best controller for this speed only", alone),
        ("this loop at this speed, frozen", frozen),
        ("best scheduled controller", level(found.scheduled.as_ref().ok().copied())),
        ("this loop, bound for any trajectory of speed", level(Some(found.certified))),
    ];
    let keys = lines.iter().enumerate().map(|(i, (name, _))| Key::nth(i, *name)).collect();
    let curves = lines.into_iter().enumerate().map(|(key, (_, points))| Curve { key, points }).collect();
    Figure {
        name: "ladder-of-gammas".into(),
        caption: format!("Values of gamma for {} over speed.", subject.name()),
        keys,
        charts: vec![Chart::over_speed("gain gamma (-)", curves)],
    }
}
