//! A candidate design of a search, and the order of two.

/// The margin required of a candidate, for more speeds and the rounding to three digits.
pub(crate) const REQUIRED_MARGIN: f64 = 0.02;
/// The cost of a failed design.
pub(crate) const FAILED_COST: f64 = 10.0;

/// A candidate design.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The logarithms of the factors.
    pub(crate) x: Vec<f64>,
    /// The objective of the search.
    pub(crate) cost: f64,
    /// The gain of the weighted loop: above 1 the weights are not met.
    pub(crate) gamma: f64,
    /// The smallest margin of each key with a limit.
    pub(crate) margins: Vec<f64>,
    /// The rise time of the first tracked output, s.
    pub rise: f64,
    /// The smallest disk margin, as a phase, deg.
    pub disk: f64,
}

impl Candidate {
    /// A failed design, with a number of keys.
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

    /// The smallest margin.
    fn worst(&self) -> f64 {
        self.margins.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Whether it meets all requirements at the few speeds at which it was evaluated.
    pub fn meets_all(&self) -> bool {
        self.worst() >= 0.0
    }
}

/// The candidates of a search, in an order that does not depend on the machine.
#[derive(Default)]
pub(crate) struct SearchRecord {
    pub tried: Vec<Candidate>,
    /// Whether it ended before the designs were used up.
    pub ended: bool,
    /// The reason of the first failure.
    pub reason: Option<String>,
}

impl SearchRecord {
    /// Adds some attempts.
    pub fn add(&mut self, found: impl IntoIterator<Item = Attempt>) {
        for Attempt { tried, failed } in found {
            self.reason = self.reason.take().or(failed);
            self.tried.push(tried);
        }
    }

    /// The best candidate.
    pub fn best(&self) -> Option<&Candidate> {
        self.tried.iter().min_by(|a, b| merit(a).total_cmp(&merit(b)))
    }
}

/// A candidate, and the reason if its design failed.
pub(crate) struct Attempt {
    pub tried: Candidate,
    pub failed: Option<String>,
}

/// The merit of a candidate, lower is better: its cost if it meets the requirements, else a larger number that grows
/// with the worst miss.
pub(crate) fn merit(tried: &Candidate) -> f64 {
    if tried.worst() >= REQUIRED_MARGIN { tried.cost } else { FAILED_COST + REQUIRED_MARGIN - tried.worst() }
}

/// The Pareto front of rise time and disk margin, the fastest first: of the candidates that meet the requirements, or
/// of all if none does.
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
