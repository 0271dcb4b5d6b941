//! Searches the weights for the fastest design that meets what is required.
//!
//! ```text
//! min over x   mean of ln(rise time) of the tracked outputs
//! subject to   room_k(x) >= SPARE for every key of [require] with a limit
//! ```
//!
//! x: the logarithms of the factors on the keys ([`Knob`]). First all models are made slower together, since that
//! costs one design a step; where none of these is good enough, and the weights of the best ask for more than it has,
//! also with slow references that count less. From the best of these each search is COBYLA, on keys that are turned
//! together (`Direction`) and then on each by itself, from another start on each processor: M. J. D. Powell, A direct
//! search optimization method that models the objective and constraint functions by linear interpolation, 1994. What
//! it finds is judged in full, and proved.

use crate::attempt::{attempt_until_missed, room};
use crate::error::Error;
use crate::finals::best;
use crate::knob::Knob;
use crate::tried::{LOST, SPARE, Tried, front, merit};
use cobyla::{Func, RhoBeg, StopTols, minimize};
use rayon::prelude::*;
use squid_design::fit::Model;
use squid_design::fit::authority::remarks;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{DesignFile, REQUIREMENTS};
use squid_design::progress::Progress;
use squid_design::run::Finished;
use squid_design::verdict::Verdict;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How far the logarithm of a factor may go, and how far it goes at first and in the end.
const FARTHEST: f64 = 3.0;
const FIRST: f64 = 0.3;
const CLOSE: f64 = 0.02;
/// The factors on all frequencies and bandwidths that are tried first.
const PACES: [f64; 4] = [1.0, 0.65, 0.42, 0.27];
/// Where none of these meets what is required, and the best has a gamma above 1, the factor on how much more slow
/// references count: the slow errors are what it cannot keep as small, and the margins pay for trying.
const LESS: f64 = 0.07;
/// The most searches side by side.
const MOST_SEARCHES: usize = 4;
/// Most evaluations of one search; those after the time is over are empty.
const MOST: usize = 1000;

/// The outcome of a search.
#[derive(Debug)]
pub struct Tuned {
    /// The text of the design file.
    pub text: String,
    /// The finished design of that text.
    pub finished: Finished,
    /// How many designs were tried.
    pub tried: usize,
    /// Of the designs that meet what is required, or of all where none does, those that no other beats in both rise and
    /// disk margin, the fastest first.
    pub front: Vec<Tried>,
    /// What the actuators cannot give, whatever the controller, by the linear model: of the design that is written.
    pub limits: Vec<String>,
}

/// How long to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// At most so long.
    pub time: Duration,
    /// At most so many designs.
    pub designs: usize,
}

/// Searches about the numbers of a design file of this text.
///
/// # Errors
/// [`Error::NoDesign`]; [`Error::NotATable`]; those of the model.
pub fn search(inputs: &Inputs, text: &str, budget: Budget, progress: &Progress) -> Result<Tuned, Error> {
    let search = Search {
        inputs,
        model: Model::new(&inputs.vehicle, &inputs.design)?,
        knobs: Knob::all(&inputs.design),
        keys: REQUIREMENTS
            .iter()
            .map(|r| r.key)
            .filter(|key| inputs.design.require.limit(key).is_some())
            .collect(),
        deadline: Instant::now() + budget.time,
        designs: budget.designs,
        begun: AtomicUsize::new(0),
        done: Mutex::new((vec![], None)),
        progress,
    };
    let minutes = budget.time.as_secs_f64() / 60.0;
    progress.timed("tune", &format!("searching for {minutes:.1} minutes"), || search.run());
    let (tried, reason) = search.done.into_inner().unwrap_or_else(PoisonError::into_inner);
    let known: Vec<&Tried> = tried.iter().filter(|t| t.cost < LOST).collect();
    if known.is_empty() {
        return Err(Error::NoDesign { tried: tried.len(), reason: reason.unwrap_or_default() });
    }
    let front = front(&known);
    let file = &inputs.design.file;
    let (text, finished) = best(inputs, text, &search.knobs, known, progress)?;
    let design = DesignFile::parse(&text, file, &inputs.design.name)?;
    let limits = remarks(&inputs.vehicle.actuators, &design, &finished.model);
    Ok(Tuned { text, finished, tried: tried.len(), front, limits })
}

struct Search<'a> {
    inputs: &'a Inputs,
    model: Model,
    knobs: Vec<Knob>,
    keys: Vec<&'static str>,
    deadline: Instant,
    designs: usize,
    begun: AtomicUsize,
    /// What was tried, and why the first that failed did.
    done: Mutex<(Vec<Tried>, Option<String>)>,
    progress: &'a Progress<'a>,
}

impl Search<'_> {
    /// Paces first, then a search on each processor, from the best pace and from those after it.
    fn run(&self) {
        let slowed = |pace: &f64, follow: f64| -> Vec<f64> {
            let factor = |knob: &Knob| match knob {
                Knob::Frequency(_) | Knob::Bandwidth(_) => *pace,
                Knob::Follow(_) => follow,
                _ => 1.0,
            };
            self.knobs.iter().map(|knob| factor(knob).ln()).collect()
        };
        let all = |follow| PACES.par_iter().map(move |pace| self.attempt(&slowed(pace, follow)));
        let mut paces: Vec<Tried> = all(1.0).collect();
        paces.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
        if !paces.iter().any(Tried::meets_all) && paces[0].gamma > 1.0 {
            paces.extend(all(LESS).collect::<Vec<_>>());
            paces.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
        }
        let searches = rayon::current_num_threads().clamp(2, MOST_SEARCHES);
        paces[..searches].par_iter().for_each(|pace| self.from(pace.clone()));
    }

    /// One search after another, each from the best that is known, until the budget is spent.
    fn from(&self, start: Tried) {
        let each: Vec<Direction> = (0..self.knobs.len())
            .filter(|i| !matches!(self.knobs[*i], Knob::Follow(_)))
            .map(|i| Direction(vec![i]))
            .collect();
        let together = Direction::together(&self.knobs);
        let mut best = start;
        let mut first = FIRST;
        while !self.is_over() && first > CLOSE {
            for directions in [&together, &each] {
                best = self.around(&best, directions, first);
            }
            first *= 0.5;
            let done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            let known = done.0.iter().min_by(|a, b| merit(a).total_cmp(&merit(b)));
            best = known.cloned().unwrap_or(best);
        }
    }

    /// The best of a search in some directions about a design.
    fn around(&self, start: &Tried, directions: &[Direction], first: f64) -> Tried {
        let best = RefCell::new(start.clone());
        let last = RefCell::new((vec![0.0; directions.len()], start.clone()));
        let evaluate = |y: &[f64]| -> Tried {
            if last.borrow().0 == y {
                return last.borrow().1.clone();
            }
            let mut x = start.x.clone();
            for (direction, step) in directions.iter().zip(y) {
                direction.0.iter().for_each(|i| x[*i] = (x[*i] + step).clamp(-FARTHEST, FARTHEST));
            }
            let tried = self.attempt(&x);
            if merit(&tried) < merit(&best.borrow()) {
                *best.borrow_mut() = tried.clone();
            }
            *last.borrow_mut() = (y.to_vec(), tried.clone());
            tried
        };
        let objective = |y: &[f64], (): &mut ()| evaluate(y).cost;
        let holds: Vec<_> = (0..self.keys.len())
            .map(|k| {
                let evaluate = &evaluate;
                move |y: &[f64], (): &mut ()| evaluate(y).rooms[k] - SPARE
            })
            .collect();
        let constraints: Vec<&dyn Func<()>> = holds.iter().map(|holds| holds as &dyn Func<()>).collect();
        let here = vec![0.0; directions.len()];
        let bounds = vec![(-FARTHEST, FARTHEST); here.len()];
        let close = StopTols { xtol_abs: vec![0.3 * first; here.len()], ..StopTols::default() };
        let _ = minimize(objective, &here, &bounds, &constraints, (), MOST, RhoBeg::All(first), Some(close));
        best.into_inner()
    }

    /// Whether the budget is spent.
    fn is_over(&self) -> bool {
        Instant::now() >= self.deadline || self.begun.load(Ordering::Relaxed) >= self.designs
    }

    /// One design; after the deadline one that is lost.
    fn attempt(&self, x: &[f64]) -> Tried {
        let lost = Tried {
            x: x.to_vec(),
            cost: LOST,
            gamma: f64::INFINITY,
            rooms: vec![-1.0; self.keys.len()],
            rise: f64::NAN,
            disk: f64::NAN,
        };
        if Instant::now() >= self.deadline || self.begun.fetch_add(1, Ordering::Relaxed) >= self.designs {
            return lost;
        }
        let turned: Vec<(Knob, f64)> = self.knobs.iter().copied().zip(x.iter().map(|x| x.exp())).collect();
        let found = attempt_until_missed(self.inputs, &self.model, &turned);
        let tried = found.as_ref().map_or(lost, |verdict| self.read(x, verdict));
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        let (all, reason) = &mut *done;
        if let Err(why) = found {
            reason.get_or_insert_with(|| why.to_string());
        }
        if all.iter().all(|other| merit(&tried) < merit(other)) && tried.cost < LOST {
            let words = format!(
                "design {}: rise {:.2} s, disk margin {:.1} deg, {}",
                all.len() + 1,
                tried.rise,
                tried.disk,
                self.missed(&tried)
            );
            self.progress.done("tune", &words);
        }
        all.push(tried.clone());
        tried
    }

    /// What a design misses most, of the keys with a limit.
    fn missed(&self, tried: &Tried) -> String {
        let worst = self.keys.iter().zip(&tried.rooms).min_by(|a, b| a.1.total_cmp(b.1));
        match worst {
            Some((key, room)) if *room < 0.0 => format!("misses {key} by {:.0} %", -100.0 * room),
            _ => "all met".into(),
        }
    }

    fn read(&self, x: &[f64], verdict: &Verdict) -> Tried {
        let rows = |key: &'static str| verdict.rows.iter().filter(move |row| row.key == key);
        let least = |key: &&'static str| {
            let rooms = rows(key).map(|row| room(row, 1.0)).map(|v| if v.is_nan() { -1.0 } else { v });
            rooms.fold(f64::INFINITY, f64::min).clamp(-LOST, 1.0)
        };
        let rises: Vec<f64> = verdict
            .rows
            .iter()
            .filter(|row| row.key.ends_with("_rise"))
            .map(|row| row.achieved.value)
            .collect();
        let mean = rises.iter().map(|rise| rise.ln()).sum::<f64>() / rises.len().max(1) as f64;
        Tried {
            x: x.to_vec(),
            cost: if mean.is_finite() { mean.min(LOST) } else { LOST },
            gamma: rows("gamma").next().map_or(f64::NAN, |row| row.achieved.value),
            rooms: self.keys.iter().map(least).collect(),
            rise: rises.first().copied().unwrap_or(f64::NAN),
            disk: rows("disk_margin").next().map_or(f64::NAN, |row| row.achieved.value),
        }
    }
}

/// Keys that are turned by the same factor, by their places.
struct Direction(Vec<usize>);

impl Direction {
    /// Frequency and bandwidth of each track, all noises, and what is left by itself.
    ///
    /// How much slow references count stays as it began: each direction costs a design before the first step.
    fn together(knobs: &[Knob]) -> Vec<Self> {
        let group = |knob: &Knob| match knob {
            Knob::Frequency(i) | Knob::Bandwidth(i) => Some(*i),
            Knob::Follow(_) => None,
            Knob::Noise(_) => Some(usize::MAX - 2),
            Knob::Weight => Some(usize::MAX - 1),
            Knob::Disturbance => Some(usize::MAX),
        };
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, knob) in knobs.iter().enumerate() {
            if let Some(group) = group(knob) {
                groups.entry(group).or_default().push(i);
            }
        }
        groups.into_values().map(Self).collect()
    }
}
