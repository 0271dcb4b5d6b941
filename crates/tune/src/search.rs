//! Searches the weights for the fastest design that meets what is required.
//!
//! ```text
//! min over x   mean of ln(rise time) of the tracked outputs
//! subject to   room_k(x) >= SPARE for every key of [require] with a limit
//! ```
//!
//! x: the logarithms of the factors on the keys ([`Knob`]). First all models are made slower together, since that
//! costs one design a step; where none of these is good enough, and the weights of the best ask for more than it has,
//! also with slow references that count less. Then follow rounds of two searches side by side: each is COBYLA, on keys
//! that are turned together (`Direction`) and on each by itself, the one in this order and the other in the reverse; in
//! the first round from the two best of the paces, then from the best that is known: M. J. D. Powell, A direct search
//! optimization method that models the objective and constraint functions by linear interpolation, 1994. The search
//! ends after a round that gains too little, or after a number of designs. What it finds is judged in full, and proved.
//!
//! No clock and no number of processors has a part in it: the same files give the same design.

use crate::attempt::{attempt_until_missed, room};
use crate::direction::Direction;
use crate::error::Error;
use crate::finals::{Final, finals};
use crate::knob::Knob;
use crate::tried::{Attempted, LOST, SPARE, Searched, Tried, front, merit};
use base::progress::Progress;
use cobyla::{Func, RhoBeg, StopTols, minimize};
use rayon::prelude::*;
use squid_design::fit::Model;
use squid_design::fit::authority::remarks;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{DesignFile, REQUIREMENTS};
use squid_design::run::Finished;
use squid_design::verdict::Verdict;
use std::cell::{Cell, RefCell};
use std::sync::{Mutex, PoisonError};

/// How far the logarithm of a factor may go, and how far it goes at first and in the end.
const FARTHEST: f64 = 3.0;
const FIRST: f64 = 0.3;
const CLOSE: f64 = 0.02;
/// A round that lowers the merit by less has gained nothing: one hundredth of the rise time, or of a limit.
const GAIN: f64 = 0.01;
/// The factors on all frequencies and bandwidths that are tried first.
const PACES: [f64; 4] = [1.0, 0.65, 0.42, 0.27];
/// Where none of these meets what is required, and the best has a gamma above 1, the factor on how much more slow
/// references count: the slow errors are what it cannot keep as small, and the margins pay for trying.
const LESS: f64 = 0.07;
/// Searches side by side, on any machine.
const SEARCHES: usize = 2;

/// The outcome of a search.
#[derive(Debug)]
pub struct Tuned {
    /// The text of the design file.
    pub text: String,
    /// The finished design of that text.
    pub finished: Finished,
    /// How many designs were tried.
    pub tried: usize,
    /// Whether the search ended by itself; otherwise the designs that were allowed were used up, and it would go on.
    pub ended: bool,
    /// Of the designs that meet what is required, or of all where none does, those that no other beats in both rise and
    /// disk margin, the fastest first; and what became of each.
    pub front: Vec<(Tried, Standing)>,
    /// What the actuators cannot give, whatever the controller, by the linear model: of the design that is written.
    pub limits: Vec<String>,
}

/// What became of a design that was tried.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Standing {
    /// It is the one that is written.
    Written,
    /// It was judged in full, and why it fell out.
    FellOut(String),
    /// It was not judged in full, since it has less room than that takes: of this key (%).
    TooLittleRoom(&'static str, String),
    /// It was not judged in full.
    NotJudged,
}

/// Searches about the numbers of a design file of this text, with at most so many designs.
///
/// # Errors
/// [`Error::NoDesign`]; [`Error::NotATable`]; those of the model.
pub fn search(inputs: &Inputs, text: &str, designs: usize, progress: &Progress) -> Result<Tuned, Error> {
    let search = Search {
        inputs,
        model: Model::new(&inputs.vehicle, &inputs.design)?,
        knobs: Knob::all(&inputs.design),
        keys: REQUIREMENTS
            .iter()
            .map(|r| r.key)
            .filter(|key| inputs.design.require.limit(key).is_some())
            .collect(),
        shown: Mutex::new((0, f64::INFINITY)),
        progress,
    };
    let what = format!("searching, with at most {designs} designs");
    let (Searched { tried, ended, reason }, _) = progress.timed("tune", &what, || search.run(designs));
    let known: Vec<&Tried> = tried.iter().filter(|t| t.cost < LOST).collect();
    if known.is_empty() {
        return Err(Error::NoDesign { tried: tried.len(), reason: reason.unwrap_or_default() });
    }
    let front = front(&known);
    let file = &inputs.design.file;
    let (judged, chosen) = finals(inputs, text, &search.knobs, known, progress)?;
    let front = front.into_iter().map(|t| (t.clone(), search.standing(&t, &judged))).collect();
    let (text, finished) = chosen;
    let design = DesignFile::parse(&text, file, &inputs.design.name)?;
    let limits = remarks(&inputs.vehicle.actuators, &design, &finished.model);
    Ok(Tuned { text, finished, tried: tried.len(), ended, front, limits })
}

struct Search<'a> {
    inputs: &'a Inputs,
    model: Model,
    knobs: Vec<Knob>,
    keys: Vec<&'static str>,
    /// How many designs were made, and the merit of the best that was told: for the lines of progress alone.
    shown: Mutex<(usize, f64)>,
    progress: &'a Progress<'a>,
}

impl Search<'_> {
    /// Paces first, then rounds of searches, until one gains too little or the designs are used up.
    fn run(&self, designs: usize) -> Searched {
        let mut all = Searched::default();
        let mut left = designs;
        self.paces(&mut all, &mut left);
        let mut starts: Vec<Tried> = all.tried.clone();
        starts.sort_by(|a, b| merit(a).total_cmp(&merit(b)));
        starts.truncate(SEARCHES);
        let mut first = FIRST;
        while first > CLOSE && left > 0 && starts.len() == SEARCHES {
            let before = all.best().map_or(f64::INFINITY, merit);
            let shares: Vec<usize> = (0..SEARCHES).map(|i| (left + SEARCHES - 1 - i) / SEARCHES).collect();
            let found: Vec<Vec<Attempted>> =
                (0..SEARCHES).into_par_iter().map(|i| self.round(i, &starts[i], first, shares[i])).collect();
            left -= found.iter().map(Vec::len).sum::<usize>();
            found.into_iter().for_each(|found| all.add(found));
            let best = all.best().cloned();
            if before - best.as_ref().map_or(f64::INFINITY, merit) < GAIN && left > 0 {
                all.ended = true;
                return all;
            }
            first *= 0.5;
            starts = best.into_iter().cycle().take(SEARCHES).collect();
        }
        all.ended = left > 0;
        all
    }

    /// All models slower together; where none is good enough, also with slow references that count less.
    fn paces(&self, all: &mut Searched, left: &mut usize) {
        for follow in [1.0, LESS] {
            let slowed = |pace: &f64| -> Vec<f64> {
                let factor = |knob: &Knob| match knob {
                    Knob::Frequency(_) | Knob::Bandwidth(_) => *pace,
                    Knob::Follow(_) => follow,
                    _ => 1.0,
                };
                self.knobs.iter().map(|knob| factor(knob).ln()).collect()
            };
            let paces = &PACES[..PACES.len().min(*left)];
            let found: Vec<Attempted> = paces.par_iter().map(|pace| self.attempt(&slowed(pace))).collect();
            *left -= found.len();
            all.add(found);
            let asks_too_much = all.best().is_some_and(|best| best.gamma > 1.0);
            if all.tried.iter().any(Tried::meets_all) || !asks_too_much {
                return;
            }
        }
    }

    /// One search of a round: on keys that are turned together and on each by itself, each from the best before.
    fn round(&self, place: usize, start: &Tried, first: f64, designs: usize) -> Vec<Attempted> {
        let each: Vec<Direction> = (0..self.knobs.len())
            .filter(|i| !matches!(self.knobs[*i], Knob::Follow(_)))
            .map(|i| Direction(vec![i]))
            .collect();
        let together = Direction::together(&self.knobs);
        let order = if place == 0 { [&together, &each] } else { [&each, &together] };
        let (mut best, mut found) = (start.clone(), vec![]);
        for directions in order {
            best = self.around(&best, directions, first, designs - found.len(), &mut found);
        }
        found
    }

    /// The best of a search in some directions about a design, with at most so many designs; all that it tries is added
    /// to what was found.
    fn around(
        &self,
        start: &Tried,
        directions: &[Direction],
        first: f64,
        designs: usize,
        found: &mut Vec<Attempted>,
    ) -> Tried {
        let best = RefCell::new(start.clone());
        let last = RefCell::new((vec![0.0; directions.len()], start.clone()));
        let (found, left) = (RefCell::new(found), Cell::new(designs));
        let evaluate = |y: &[f64]| -> Tried {
            if last.borrow().0 == y {
                return last.borrow().1.clone();
            }
            let mut x = start.x.clone();
            for (direction, step) in directions.iter().zip(y) {
                direction.0.iter().for_each(|i| x[*i] = (x[*i] + step).clamp(-FARTHEST, FARTHEST));
            }
            if left.get() == 0 {
                return self.lost(&x);
            }
            left.set(left.get() - 1);
            let attempted = self.attempt(&x);
            let tried = attempted.tried.clone();
            found.borrow_mut().push(attempted);
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
        if designs > 0 {
            // The evaluation of the start is known, and costs no design.
            let most = designs + 1;
            let _ =
                minimize(objective, &here, &bounds, &constraints, (), most, RhoBeg::All(first), Some(close));
        }
        best.into_inner()
    }

    /// What there is of a design that did not come out.
    fn lost(&self, x: &[f64]) -> Tried {
        Tried {
            x: x.to_vec(),
            cost: LOST,
            gamma: f64::INFINITY,
            rooms: vec![-1.0; self.keys.len()],
            rise: f64::NAN,
            disk: f64::NAN,
        }
    }

    /// One design.
    fn attempt(&self, x: &[f64]) -> Attempted {
        let turned: Vec<(Knob, f64)> = self.knobs.iter().copied().zip(x.iter().map(|x| x.exp())).collect();
        let found = attempt_until_missed(self.inputs, &self.model, &turned);
        let tried = found.as_ref().map_or_else(|_| self.lost(x), |verdict| self.read(x, verdict));
        self.tell(&tried);
        Attempted { tried, failed: found.err().map(|why| why.to_string()) }
    }

    /// A line of progress where a design is better than those before.
    fn tell(&self, tried: &Tried) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.0 += 1;
        if merit(tried) < shown.1 && tried.cost < LOST {
            shown.1 = merit(tried);
            let words = format!(
                "design {}: rise {:.2} s, disk margin {:.1} deg, {}",
                shown.0,
                tried.rise,
                tried.disk,
                self.missed(tried)
            );
            self.progress.done("tune", &words);
        }
    }

    /// What became of a design of the front.
    fn standing(&self, tried: &Tried, judged: &[Final]) -> Standing {
        if let Some(found) = judged.iter().find(|f| f.x == tried.x) {
            return found.fell_out.clone().map_or(Standing::Written, Standing::FellOut);
        }
        let worst = self.keys.iter().zip(&tried.rooms).min_by(|a, b| a.1.total_cmp(b.1));
        match worst {
            Some((key, room)) if (0.0..SPARE).contains(room) => {
                Standing::TooLittleRoom(key, format!("{:.1}", 100.0 * room))
            }
            _ => Standing::NotJudged,
        }
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
