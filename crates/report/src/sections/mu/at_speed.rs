//! mu for robust stability at one speed: bounds for all frequencies, curves over frequency, and the destabilising
//! perturbation.

use crate::error::Error;
use crate::sections::mu::worst_gain::WorstGain;
use crate::subject::Subject;
use nalgebra::DVector;
use squid_design::axis::Linearisation;
use squid_design::error::Error as DesignError;
use squid_design::uncertain::closed_loop::uncertain_loop;
use squid_design::uncertain::frozen::FrozenUncertain;
use squid_design::uncertain::frozen::at_speed;
use squid_design::uncertain::model::{Block, Uncertain};
use squid_design::uncertain::vehicle;
use squid_lpv::matrix::{Mat, solve, spectral_abscissa};
use squid_lpv::mu::lower::{LowerBound, lower_bound};
use squid_lpv::mu::margin::real_lower_bound;
use squid_lpv::mu::over_frequency::{FrequencyMu, mu_over_frequency};
use squid_lpv::mu::sweep::{FrequencyBound, SweepError, response};
use squid_lpv::mu::upper::{DgScalings, UpperBoundOptions, upper_bound_with};
use squid_lpv::mu::{self, CMat, Structure};
use squid_lpv::state_space::StateSpace;

/// Frequencies of the curves, rad/s: the first and last power of ten, and the number per decade.
pub const DECADES: (i32, i32) = (-3, 2);
const UPPER_POINTS: i32 = 6;
/// Largest number of points added where the curve bends, until each point is within a fraction of the peak of the line
/// between its neighbours, or within a distance of one of them, in decades.
const ADDED: usize = 30;
const SMOOTH: f64 = 0.015;
const FINEST: f64 = 0.01;

/// Frequencies of the lower bounds, which take longer and matter where the upper bounds are high.
const LOWER_DECADES: (i32, i32) = (-2, 1);
const LOWER_POINTS: i32 = 1;

/// Mu analysis at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedMu {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Numbers of uncertain parameters and of their channels.
    pub size: (usize, usize),
    /// Bounds for all frequencies.
    pub bounds: FrequencyMu,
    /// Upper bounds at single frequencies (rad/s).
    pub upper: Vec<(f64, f64)>,
    /// Frequency of the largest of these bounds, rad/s; not always on the curve.
    pub peak: f64,
    /// Lower bounds at the single frequencies (rad/s) where a perturbation was found.
    pub lower: Vec<(f64, f64)>,
    /// Perturbation of the largest lower bound, one entry per parameter, in decreasing order of the shares.
    pub worst: Vec<Change>,
    /// Gain of the loop with and without coefficient errors.
    pub gain: WorstGain,
    /// Size of the perturbation, without its changes of the trim, at which a retrimmed vehicle is unstable: as flown,
    /// and in continuous time.
    pub vehicle: [Option<f64>; 2],
}

/// Change of one uncertain parameter in a perturbation.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Name.
    pub name: String,
    /// Deviation, as text.
    pub by: String,
    /// Share in moving the pole to the axis; all shares add up to 1.
    pub share: f64,
}

impl SpeedMu {
    /// Analyses the loop of the uncertain model at a speed and the controller frozen there.
    ///
    /// # Errors
    /// Errors of [`at_speed`]; [`ModelError::System`](squid_design::error::ModelError::System);
    /// [`DesignError::MuAtSpeed`] if the nominal loop is unstable.
    pub fn new(subject: &Subject, speed: f64) -> Result<Self, Error> {
        let frozen = at_speed(subject.inputs, speed)?;
        let model = &frozen.model;
        let closed = uncertain_loop(subject.inputs, &frozen, &subject.controller)?;
        let (system, structure) = (closed.stability(), &closed.structure);
        let failed = |reason: SweepError| DesignError::MuAtSpeed { speed, reason };
        let lower = real_lower_bound(&system, structure);
        let bounds = match (lower, of_the_verdict(subject, speed)) {
            (lower @ Some(_), Some(upper)) => FrequencyMu { upper, lower },
            _ => mu_over_frequency(&system, structure).map_err(failed)?,
        };
        let mut upper = upper_curve(&system, structure, &bounds).map_err(|reason| failed(reason.into()))?;
        let peak = upper.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |p| p.0);
        upper.retain(|(omega, _)| shown().contains(omega));
        let points = lower_points(&system, structure, &bounds).map_err(|reason| failed(reason.into()))?;
        let lower = bounds.lower.as_ref();
        let perturbation = lower.map(|perturbation| vehicle::values(&frozen, &perturbation.delta));
        let worst = perturbation.as_ref().map_or_else(Vec::new, |values| {
            let shares = shares(&system, &model.blocks, values);
            ordered(&model.blocks, values, &shares)
        });
        let unstable = match &perturbation {
            Some(values) => unstable_at(subject, &frozen, values, bounds.lower.as_ref())?,
            None => [None; 2],
        };
        let of = |delta: &CMat| {
            let l = vehicle::vehicle_at(&subject.inputs.vehicle, &frozen, &vehicle::values(&frozen, delta))?;
            vehicle::gain(subject.inputs, &l, &subject.controller).ok()
        };
        let gain = WorstGain::new(&closed, bounds.upper.upper, &of);
        let size = (model.blocks.len(), model.channels());
        Ok(Self { speed, size, bounds, upper, peak, lower: points, worst, gain, vehicle: unstable })
    }

    /// Returns the guaranteed upper bound on mu over all frequencies.
    pub fn guaranteed(&self) -> f64 {
        self.bounds.upper.upper
    }

    /// Returns the lower bound on mu from a perturbation; `None` if the search found none.
    pub fn shown(&self) -> Option<f64> {
        self.bounds.lower.as_ref().map(|found| found.value)
    }
}

/// Returns the bound at a speed if the verdict contains it.
fn of_the_verdict(subject: &Subject, speed: f64) -> Option<FrequencyBound> {
    let found = &subject.verdict().ok()?.found.mu;
    found.iter().find(|mu| mu.speed == speed)?.bound.clone()
}

/// Returns the range of the plotted frequencies, rad/s.
fn shown() -> std::ops::RangeInclusive<f64> {
    10f64.powi(DECADES.0)..=10f64.powi(DECADES.1)
}

/// Returns logarithmically spaced frequencies.
fn spread((from, to): (i32, i32), points: i32) -> impl Iterator<Item = f64> {
    (from * points..=to * points).map(move |k| 10f64.powf(f64::from(k) / f64::from(points)))
}

/// Computes upper bounds at single frequencies, including zero and the frequencies of both bounds of the sweep, so that
/// no peak is missed.
fn upper_curve(
    system: &StateSpace,
    structure: &Structure,
    bounds: &FrequencyMu,
) -> Result<Vec<(f64, f64)>, mu::StructureError> {
    let peaks = bounds.lower.iter().filter_map(|l| l.frequency).chain([bounds.upper.frequency]);
    let around = peaks.flat_map(|peak| [0.94, 1.0, 1.06].map(|part| part * peak));
    let mut axis: Vec<f64> = spread(DECADES, UPPER_POINTS).chain(around).chain([0.0]).collect();
    axis.sort_by(f64::total_cmp);
    axis.dedup();
    let at = |omega: f64, from: Option<&DgScalings>| {
        let m = response(system, omega)?;
        let options = UpperBoundOptions { tight: DRAWN, from, ..UpperBoundOptions::default() };
        Some(upper_bound_with(&m, structure, options).map(|found| Drawn {
            omega,
            value: found.value,
            start: found.start,
        }))
    };
    let mut points: Vec<Drawn> = vec![];
    for omega in axis {
        let from = points.last().map(|p| &p.start);
        points.extend(at(omega, from).transpose()?);
    }
    from_neighbours(&mut points, &at)?;
    for _ in 0..ADDED {
        let curve: Vec<(f64, f64)> = points.iter().map(|p| (p.omega, p.value)).collect();
        let Some(omega) = roughest(&curve) else { break };
        let index = points.partition_point(|p| p.omega < omega);
        let repeated = [index - 1, index].map(|i| at(omega, Some(&points[i].start)));
        let repeated: Vec<Drawn> = repeated.into_iter().flatten().collect::<Result<_, _>>()?;
        let Some(lowest) = repeated.into_iter().min_by(|a, b| a.value.total_cmp(&b.value)) else { break };
        points.insert(index, lowest);
    }
    from_neighbours(&mut points, &at)?;
    Ok(points.into_iter().map(|p| (p.omega, p.value)).collect())
}

/// Upper bound at a frequency (rad/s), and the final point of its search.
struct Drawn {
    omega: f64,
    value: f64,
    start: DgScalings,
}

/// Repeats searches that stalled above the least bound: if a bound is well above its neighbour's, the search starts
/// again from the neighbour's final point, which removes steps and spikes that are not in mu.
fn from_neighbours(
    points: &mut [Drawn],
    at: &impl Fn(f64, Option<&DgScalings>) -> Option<Result<Drawn, mu::StructureError>>,
) -> Result<(), mu::StructureError> {
    let rise = SMOOTH * points.iter().map(|p| p.value).fold(0.0, f64::max);
    let up = (1..points.len()).map(|i| (i, i - 1));
    let down = (1..points.len()).rev().map(|i| (i - 1, i));
    for (own, neighbour) in up.chain(down) {
        if points[own].value > points[neighbour].value + rise
            && let Some(again) = at(points[own].omega, Some(&points[neighbour].start))
        {
            let again = again?;
            if again.value < points[own].value {
                points[own] = again;
            }
        }
    }
    Ok(())
}

/// Returns the frequency (rad/s) at which another point smooths a curve most; `None` if it is smooth.
fn roughest(points: &[(f64, f64)]) -> Option<f64> {
    let drawn: Vec<(f64, f64)> = points.iter().filter(|p| p.0 > 0.0).map(|p| (p.0.log10(), p.1)).collect();
    let highest = drawn.iter().map(|p| p.1).fold(0.0, f64::max);
    let bend = |w: &[(f64, f64)]| {
        let part = (w[1].0 - w[0].0) / (w[2].0 - w[0].0);
        let wider = if part > 0.5 { (w[0].0, w[1].0) } else { (w[1].0, w[2].0) };
        let off = (w[1].1 - w[0].1 - part * (w[2].1 - w[0].1)).abs();
        (wider.1 - wider.0 > FINEST && off > SMOOTH * highest).then_some((off, 0.5 * (wider.0 + wider.1)))
    };
    let most = drawn.windows(3).filter_map(bend).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(10f64.powf(most.1))
}

/// Relative tolerance of the curves: less than the thickness of a line.
const DRAWN: f64 = 5e-4;

/// Computes lower bounds at the frequencies where a perturbation is found, including that of the sweep.
fn lower_points(
    system: &StateSpace,
    structure: &Structure,
    bounds: &FrequencyMu,
) -> Result<Vec<(f64, f64)>, mu::StructureError> {
    let mut out: Vec<(f64, f64)> =
        bounds.lower.iter().filter_map(|l| Some((l.frequency?, l.value))).collect();
    for omega in spread(LOWER_DECADES, LOWER_POINTS) {
        let Some(m) = response(system, omega) else { continue };
        out.extend(lower_bound(&m, structure)?.map(|found| (omega, found.value)));
    }
    Ok(out)
}

/// Search range along a perturbation, in units of the size at which the model is unstable; at least the declared
/// uncertainty.
const FOLLOWED: f64 = 2.0;

/// Returns the sizes of a perturbation at which the loop of a retrimmed vehicle is unstable: as flown, and in
/// continuous time.
fn unstable_at(
    subject: &Subject,
    frozen: &FrozenUncertain,
    values: &[f64],
    found: Option<&LowerBound>,
) -> Result<[Option<f64>; 2], Error> {
    let farthest = found.map_or(1.0, |found| (FOLLOWED / found.value).max(1.0));
    let controller =
        subject.frozen(&subject.controller, &frozen.linear(&subject.inputs.vehicle.actuators))?;
    let flies = |l: &Linearisation| subject.sampling().spectral_radius(l, &controller) < 1.0;
    let ideal =
        |l: &Linearisation| spectral_abscissa(&subject.sampling().ideal(l).closed(&controller).a) < 0.0;
    let at = |is_stable: &dyn Fn(&Linearisation) -> bool| {
        vehicle::destabilised_at(&subject.inputs.vehicle, frozen, values, farthest, is_stable)
    };
    Ok([at(&flies), at(&ideal)])
}

/// Returns the largest real part of the poles of a perturbed loop, rad/s; `None` if it is not well posed.
///
/// ```text
/// A + B (I - Delta D)^-1 Delta C
/// ```
fn rightmost(system: &StateSpace, blocks: &[Block], values: &[f64]) -> Option<f64> {
    let entries = blocks.iter().zip(values).flat_map(|(b, v)| std::iter::repeat_n(*v, b.repetitions));
    let delta = Mat::from_diagonal(&DVector::from_iterator(system.d.nrows(), entries));
    let inner =
        solve(&(Mat::identity(delta.nrows(), delta.nrows()) - &delta * &system.d), &(&delta * &system.c))?;
    Some(spectral_abscissa(&(&system.a + &system.b * inner)))
}

/// Relative reduction of a parameter to compute its sensitivity.
const PART: f64 = 1e-4;

/// Returns the share of each parameter in moving the pole to the axis, to first order.
fn shares(system: &StateSpace, blocks: &[Block], values: &[f64]) -> Vec<f64> {
    let all = rightmost(system, blocks, values);
    let without = |i: usize| {
        let mut fewer = values.to_vec();
        fewer[i] *= 1.0 - PART;
        Some(all? - rightmost(system, blocks, &fewer)?)
    };
    let moves: Vec<f64> = (0..values.len()).map(|i| without(i).unwrap_or(0.0)).collect();
    let sum: f64 = moves.iter().sum();
    moves.into_iter().map(|v| if sum > 0.0 { v / sum } else { 0.0 }).collect()
}

/// Returns the parameters in decreasing order of their shares.
fn ordered(blocks: &[Block], values: &[f64], shares: &[f64]) -> Vec<Change> {
    let change = |((b, v), share): ((&Block, &f64), &f64)| Change {
        name: b.name.clone(),
        by: by(b, *v),
        share: *share,
    };
    let mut out: Vec<Change> = blocks.iter().zip(values).zip(shares).map(change).collect();
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out
}

/// Returns the deviation of a parameter as text: relative to its value, or in its unit if the value is 0 or belongs to
/// the trim.
fn by(block: &Block, delta: f64) -> String {
    let off = delta * block.half_range;
    if matches!(block.uncertain, Uncertain::Parameter(_))
        && (block.value == 0.0 || block.uncertain.is_of_trim())
    {
        return match block.unit {
            "rad" => format!("{:+.1} deg", off.to_degrees()),
            unit => format!("{off:+.3} {unit}"),
        };
    }
    format!("{:+.0} %", 100.0 * off / block.value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    fn block(value: f64, half_range: f64) -> Block {
        Block {
            uncertain: Uncertain::Gain(0),
            name: "a".into(),
            value,
            half_range,
            unit: "1",
            repetitions: 1,
        }
    }

    /// The pole of x' = -x + 0.5 d1 x + 0.25 d2 x is at -1 + 0.5 d1 + 0.25 d2.
    #[test]
    fn shares_of_a_known_pole() {
        let system = StateSpace {
            a: dmatrix![-1.0],
            b: dmatrix![0.5, 0.25],
            c: dmatrix![1.0; 1.0],
            d: dmatrix![0.0, 0.0; 0.0, 0.0],
        };
        let blocks = [block(2.0, 0.6), block(-4.0, 0.4)];
        let values = [4.0 / 3.0; 2];
        assert!(rightmost(&system, &blocks, &values).unwrap().abs() < 1e-12);
        let found = shares(&system, &blocks, &values);
        assert!((found[0] - 2.0 / 3.0).abs() < 1e-8 && (found[1] - 1.0 / 3.0).abs() < 1e-8, "{found:?}");
        let ordered = ordered(&blocks, &values, &[0.3, 0.7]);
        assert_eq!((ordered[0].by.as_str(), ordered[1].by.as_str()), ("-13 %", "+40 %"));
    }

    /// A spike of a stalled search is removed, and a true peak remains.
    #[test]
    fn repeats_searches_well_above_their_neighbours() {
        let one = Structure::new(vec![mu::Block::Real(1)]).unwrap();
        let start = mu::upper::upper_bound(&CMat::identity(1, 1), &one).unwrap().start;
        let drawn = |omega: f64, value| Drawn { omega, value, start: start.clone() };
        let truth = |omega: f64| if omega == 4.0 { 0.3 } else { 0.1 };
        let mut points: Vec<Drawn> = [0.1, 0.25, 0.25, 0.3, 0.1]
            .into_iter()
            .enumerate()
            .map(|(i, value)| drawn(1.0 + i as f64, value))
            .collect();
        from_neighbours(&mut points, &|omega, _| Some(Ok(drawn(omega, truth(omega))))).unwrap();
        assert_eq!(points.iter().map(|p| p.value).collect::<Vec<_>>(), [0.1, 0.1, 0.1, 0.3, 0.1]);
    }

    /// Added points make the curve smooth at a peak of a twentieth of a decade between two points of the grid.
    #[test]
    fn adds_points_until_a_peak_is_smooth() {
        let peak = |x: f64| 1.0 / (1.0 + ((x - 0.13) / 0.05).powi(2));
        let mut points: Vec<(f64, f64)> =
            (-6..=6).map(|k| f64::from(k) / 6.0).map(|x| (10f64.powf(x), peak(x))).collect();
        while let Some(omega) = roughest(&points) {
            points.insert(points.partition_point(|p| p.0 < omega), (omega, peak(omega.log10())));
            assert!(points.len() < 80);
        }
        let highest = points.iter().map(|p| p.1).fold(0.0, f64::max);
        assert!(highest > 0.98 && points.len() > 20, "{highest} {}", points.len());
    }

    #[test]
    fn deviations_of_trim_parameters_are_absolute() {
        let uncertain = Uncertain::Parameter(squid_auv::Parameter::Incidence);
        let incidence = Block { uncertain, unit: "rad", ..block(0.02, 0.01) };
        assert_eq!(by(&incidence, 2.0), "+1.1 deg");
    }
}
