//! Candidate design of a search, and the order of candidates.

/// Margin required of a candidate, as reserve for more speeds and for rounding to three digits.
pub(crate) const REQUIRED_MARGIN: f64 = 0.02;
/// Cost of a failed design.
pub(crate) const FAILED_COST: f64 = 10.0;

/// Candidate design.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Logarithms of the factors.
    pub(crate) x: Vec<f64>,
    /// Objective of the search.
    pub(crate) cost: f64,
    /// Gain of the weighted loop; above 1 the weights are not met.
    pub(crate) gamma: f64,
    /// Smallest margin of each key with a limit.
    pub(crate) margins: Vec<f64>,
    /// Rise time of the first tracked output, s.
    pub rise: f64,
    /// Smallest disk margin, as a phase, deg.
    pub disk: f64,
}

impl Candidate {
    /// Returns a failed design with `keys` margins.
    pub(crate) fn failed(x: &[f64], keys: usize) -> Self {
        Self {
            x: x.to_vec(),
            cost: FAILED_COST,
            gamma: f64::INFINITY,
            margins: vec![-1.0; keys],
            rise: f64::NAN,
            disk: f64::NAN,
        }
    }

    /// Returns the smallest margin.
    fn worst(&self) -> f64 {
        self.margins.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Returns `true` if it meets all requirements at the few speeds at which it was evaluated.
    pub fn meets_all(&self) -> bool {
        self.worst() >= 0.0
    }
}

/// Candidates of a search, in an order that does not depend on the machine.
#[derive(Default)]
pub(crate) struct SearchRecord {
    pub tried: Vec<Candidate>,
    /// `true` if the search ended before it used all designs.
    pub ended: bool,
    /// Reason of the first failure.
    pub reason: Option<String>,
}

impl SearchRecord {
    /// Adds attempts.
    pub fn add(&mut self, found: impl IntoIterator<Item = Attempt>) {
        for Attempt { tried, failed } in found {
            self.reason = self.reason.take().or(failed);
            self.tried.push(tried);
        }
    }

    /// Returns the best candidate.
    pub fn best(&self) -> Option<&Candidate> {
        self.tried.iter().min_by(|a, b| merit(a).total_cmp(&merit(b)))
    }
}

/// Candidate, with the reason if its design failed.
pub(crate) struct Attempt {
    pub tried: Candidate,
    pub failed: Option<String>,
}

/// Returns the merit of a candidate, lower is better: its cost if it meets the requirements, otherwise a larger number
/// that grows with the worst violation.
pub(crate) fn merit(tried: &Candidate) -> f64 {
    if tried.worst() >= REQUIRED_MARGIN { tried.cost } else { FAILED_COST + REQUIRED_MARGIN - tried.worst() }
}

/// Returns the Pareto front of rise time and disk margin, the fastest first, of the candidates that meet the
/// requirements, or of all if none does.
pub(crate) fn front(tried: &[&Candidate]) -> Vec<Candidate> {
    let any = tried.iter().any(|t| t.meets_all());
    let mut sorted: Vec<&Candidate> = tried
        .iter()
        .copied()
        .filter(|t| t.rise.is_finite() && t.disk.is_finite() && (t.meets_all() || !any))
        .collect();
    sorted.sort_by(|a, b| a.rise.total_cmp(&b.rise).then(b.disk.total_cmp(&a.disk)));
    let mut best = f64::NEG_INFINITY;
    let beats = |t: &&Candidate| {
        let better = t.disk > best;
        best = best.max(t.disk);
        better
    };
    sorted.into_iter().filter(beats).cloned().collect()
}
