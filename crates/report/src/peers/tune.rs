//! Tunes the PID: the best gains on the course at each speed, with |S| and noise in the commands no larger than with
//! the scheduled controller.

use crate::error::Error;
use crate::peers::course::{CourseFigures, fly_at};
use crate::peers::law::{Law, Scheduled};
use crate::peers::pid::{Gains, Pid};
use crate::subject::Subject;
use crate::threads::in_parallel;
use cobyla::{Func, RhoBeg, StopTols, minimize};
use squid_auv::longitudinal::SPEED;
use squid_design::axis::Linearisation;
use squid_design::axis::VehicleModel;
use squid_design::check::flown::opened;
use squid_lpv::weights::ReferenceModel;
use std::cell::{Cell, RefCell};

/// The peak sensitivity and the noise response of a loop at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sharpness {
    /// The largest |S| over all loop-opening points.
    pub peak: f64,
    /// The largest RMS command due to sensor noise, relative to its reach.
    pub roughness: f64,
}

/// The sharpness of a law at the speed of a trim; `None` if the loop is unstable.
pub fn sharpness(subject: &Subject, law: &dyn Law, l: &Linearisation) -> Option<Sharpness> {
    let sampling = subject.sampling();
    let system = sampling.held(l).injected(&law.frozen(l.trim.speed)?);
    let (opened, rms) = opened(&sampling, &system)?;
    let relative = rms.iter().zip(sampling.actuators).map(|(rms, a)| rms / a.reach());
    Some(Sharpness { peak: opened.peak_of_sensitivity(), roughness: relative.fold(0.0, f64::max) })
}

/// Frequencies of the initial guesses, relative to those of the reference models of pitch and speed.
const GUESSES: [f64; 3] = [0.7, 1.2, 2.0];
/// The largest change of the logarithm of a gain from a guess.
const FARTHEST: f64 = 4.0;
/// The first step of the logarithm of a gain.
const FIRST: f64 = 0.4;
/// The allowed violation of a constraint, the logarithm of a ratio.
const MISSED: f64 = 1e-4;
/// The tolerance on the logarithms of the gains.
const CLOSE: f64 = 1e-3;
/// The cost of an unstable loop.
const UNSTABLE: f64 = 10.0;

/// The gains at a point x: the setpoint weight, and the logarithms of the gains; those for speed if there are any.
fn gains(x: &[f64]) -> Gains {
    let g = |i: usize| x.get(i).map_or(0.0, |x| x.exp());
    Gains { pitch: [g(1), g(2), g(3)], weight: x[WEIGHT], speed: [g(4), g(5)] }
}

/// The point x of some gains.
fn point(gains: &Gains) -> Vec<f64> {
    let there = gains.pitch.into_iter().chain(gains.speed.into_iter().filter(|gain| *gain > 0.0));
    std::iter::once(gains.weight).chain(there.map(f64::ln)).collect()
}

/// The index of the weight in x.
const WEIGHT: usize = 0;

/// The values of the optimisation problem at a point.
#[derive(Debug, Clone, Copy)]
struct Evaluation {
    cost: f64,
    /// Satisfied if not negative.
    constraints: [f64; 2],
}

/// The requirements of the PID on a design.
const UNFIT: &str = "it takes a design that tracks pitch and no depth, and measures pitch, pitch rate and, where it is \
    not given, speed apart from the references";

/// The PID with gains tuned at some speeds (m/s), with a number of evaluations per search; or, in words, why there is
/// none.
///
/// The cost is the mean of ratios to the scheduled controller's figures on the same course: ITAE of the pitch step and,
/// unless the speed is imposed, of the speed step, settling time of pitch, and peak after the gust. Constraints: |S|
/// and the noise in the commands are no larger than with the scheduled controller at that speed.
///
/// Source of COBYLA: M. J. D. Powell, A direct search optimization method that models the objective and constraint
/// functions by linear interpolation, 1994.
///
/// # Errors
/// The errors of trim and linearisation.
pub fn tuned(subject: &Subject, speeds: &[f64], evaluations: usize) -> Result<Result<Pid, String>, Error> {
    let linear = |v: &f64| Ok(subject.inputs.axis().linearise(*v)?);
    let truth: Vec<Linearisation> = speeds.iter().map(linear).collect::<Result<_, Error>>()?;
    if Pid::new(subject, &[(&truth[0], gains(&guess(subject, 1.0)))]).is_none() {
        return Ok(Err(UNFIT.into()));
    }
    let none_at = |speed: f64| {
        format!(
            "at {speed:.2} m/s the search found no gains with |S| and commands under noise as small as the scheduled \
                controller's"
        )
    };
    // The middle speed starts from several guesses, the others from its best gains and from one guess.
    let middle = speeds.len() / 2;
    let first = GUESSES.iter().map(|factor| (middle, guess(subject, *factor)));
    let Some(best_there) = least(search(subject, &truth, first, evaluations)?, middle) else {
        return Ok(Err(none_at(speeds[middle])));
    };
    let starts = [point(&best_there.1), guess(subject, GUESSES[1])];
    let others = (0..speeds.len()).filter(|i| *i != middle);
    let others = others.flat_map(|i| starts.iter().map(move |start| (i, start.clone())));
    let mut found = search(subject, &truth, others, evaluations)?;
    found.push((middle, Some(best_there)));
    let mut chosen = vec![];
    for (i, l) in truth.iter().enumerate() {
        let Some((_, gains)) = least(found.clone(), i) else { return Ok(Err(none_at(speeds[i]))) };
        chosen.push((l, gains));
    }
    Ok(Pid::new(subject, &chosen).ok_or_else(|| UNFIT.into()))
}

/// The best gains at a speed, with their cost; `None` if no gains satisfy the constraints.
type Found = (usize, Option<(f64, Gains)>);

/// The gains of least cost at a speed.
fn least(found: Vec<Found>, at: usize) -> Option<(f64, Gains)> {
    let here = found.into_iter().filter(|(i, _)| *i == at).filter_map(|(_, found)| found);
    here.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Searches from some starting points in parallel.
fn search(
    subject: &Subject,
    truth: &[Linearisation],
    starts: impl Iterator<Item = (usize, Vec<f64>)> + Send,
    evaluations: usize,
) -> Result<Vec<Found>, Error> {
    let ours = Scheduled(subject);
    let work = |(i, start): (usize, Vec<f64>)| -> Result<Found, Error> {
        let l = &truth[i];
        let Some(limits) = sharpness(subject, &ours, l) else { return Ok((i, None)) };
        let figures = fly_at(subject, &ours, l.trim.speed)?;
        let found = best(subject, l, limits, figures, &start, evaluations);
        let outcome =
            found.map_or("no gains meet the constraints".into(), |(cost, _)| format!("cost {cost:.3}"));
        subject.progress.done("report", &format!("  PID at {:.2} m/s: {outcome}", l.trim.speed));
        Ok((i, found))
    };
    in_parallel(starts, work).into_iter().collect()
}

/// An initial guess: poles near the frequencies of the reference models of pitch and speed, times a factor.
fn guess(subject: &Subject, factor: f64) -> Vec<f64> {
    let model = |speed: bool| {
        let tracked = subject.inputs.design.tracked.iter().find(|t| (t.index == SPEED) == speed);
        tracked.and_then(|t| t.model).map_or(1.0, |ReferenceModel { frequency, .. }| frequency)
    };
    let w = factor * model(false);
    let v = if subject.speed_is_given() { 0.0 } else { factor * model(true) };
    point(&Gains { pitch: [w * w, 0.3 * w * w * w, 2.0 * w], weight: 0.7, speed: [v, 0.2 * v * v] })
}

/// The best gains from one starting point that satisfy the constraints, with their cost.
fn best(
    subject: &Subject,
    l: &Linearisation,
    limits: Sharpness,
    ours: CourseFigures,
    start: &[f64],
    evaluations: usize,
) -> Option<(f64, Gains)> {
    let around = |(i, x): (usize, &f64)| if i == WEIGHT { (0.0, 1.0) } else { (x - FARTHEST, x + FARTHEST) };
    let bounds: Vec<(f64, f64)> = start.iter().enumerate().map(around).collect();
    let known: RefCell<Option<(Vec<f64>, Evaluation)>> = RefCell::new(None);
    let best: RefCell<Option<(f64, Gains)>> = RefCell::new(None);
    let flights = Cell::new(0);
    let evaluate = |x: &[f64]| -> Evaluation {
        if let Some((_, tried)) = known.borrow().as_ref().filter(|(at, _)| at == x) {
            return *tried;
        }
        let tried = attempt(subject, l, limits, ours, gains(x));
        flights.set(flights.get() + 1);
        let holds = tried.constraints.iter().all(|c| *c >= -MISSED);
        let better = best.borrow().is_none_or(|(cost, _)| tried.cost < cost);
        if holds && better && tried.cost < UNSTABLE {
            *best.borrow_mut() = Some((tried.cost, gains(x)));
        }
        *known.borrow_mut() = Some((x.to_vec(), tried));
        tried
    };
    let objective = |x: &[f64], (): &mut ()| evaluate(x).cost;
    let sharp = |x: &[f64], (): &mut ()| evaluate(x).constraints[0];
    let rough = |x: &[f64], (): &mut ()| evaluate(x).constraints[1];
    let constraints: [&dyn Func<()>; 2] = [&sharp, &rough];
    let mut start = start.to_vec();
    // A new search starts from the best point of the last one. The best of all points is kept, however a search ends.
    while flights.get() + start.len() < evaluations {
        let left = evaluations - flights.get();
        let close = StopTols { xtol_abs: vec![CLOSE; start.len()], ..StopTols::default() };
        let _ = minimize(objective, &start, &bounds, &constraints, (), left, RhoBeg::All(FIRST), Some(close));
        let reached = best.borrow().as_ref().map(|(_, gains)| point(gains));
        match reached {
            Some(reached) if reached != start => start = reached,
            _ => break,
        }
    }
    best.into_inner()
}

/// Cost and constraints of gains at one speed.
fn attempt(
    subject: &Subject,
    l: &Linearisation,
    limits: Sharpness,
    ours: CourseFigures,
    gains: Gains,
) -> Evaluation {
    let lost = Evaluation { cost: UNSTABLE, constraints: [-UNSTABLE; 2] };
    let Some(pid) = Pid::new(subject, &[(l, gains)]) else { return lost };
    let Some(found) = sharpness(subject, &pid, l) else { return lost };
    let constraints = [limits.peak / found.peak, limits.roughness / found.roughness].map(f64::ln);
    let Ok(figures) = fly_at(subject, &pid, l.trim.speed) else { return lost };
    let mut ratios = vec![
        figures.pitch.itae / ours.pitch.itae,
        figures.pitch.settling_time / ours.pitch.settling_time,
        figures.gust / ours.gust,
    ];
    if !subject.speed_is_given() {
        ratios.push(figures.speed.itae / ours.speed.itae);
    }
    let cost = ratios.iter().map(|r| r.min(UNSTABLE)).sum::<f64>() / ratios.len() as f64;
    Evaluation { cost, constraints }
}
