//! A design that was tried, and how it compares with others.

/// The room that an attempt must have, for what is found at more speeds and to three digits.
pub(crate) const SPARE: f64 = 0.02;
/// What a design that does not come out counts as.
pub(crate) const LOST: f64 = 10.0;

/// A design that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// The logarithms of the factors.
    pub(crate) x: Vec<f64>,
    /// The mean of the logarithms of the rise times.
    pub(crate) cost: f64,
    /// The gain of the weighted loop: above 1 the weights ask for more than the design has.
    pub(crate) gamma: f64,
    /// The least room of each key with a limit.
    pub(crate) rooms: Vec<f64>,
    /// The slowest rise of what steps, s.
    pub rise: f64,
    /// The least disk margin, as a phase, deg.
    pub disk: f64,
}

impl Tried {
    /// The least room of all.
    fn worst(&self) -> f64 {
        self.rooms.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Whether it meets all that is required, at the few speeds at which it was judged.
    pub fn meets_all(&self) -> bool {
        self.worst() >= 0.0
    }
}

/// What a search tried, in an order that does not depend on the machine.
#[derive(Default)]
pub(crate) struct Searched {
    pub tried: Vec<Tried>,
    /// Whether it ended before the designs were used up.
    pub ended: bool,
    /// Why the first that failed did.
    pub reason: Option<String>,
}

impl Searched {
    /// Adds what was found.
    pub fn add(&mut self, found: impl IntoIterator<Item = Attempted>) {
        for Attempted { tried, failed } in found {
            self.reason = self.reason.take().or(failed);
            self.tried.push(tried);
        }
    }

    /// The best of all.
    pub fn best(&self) -> Option<&Tried> {
        self.tried.iter().min_by(|a, b| merit(a).total_cmp(&merit(b)))
    }
}

/// A design that was tried, and why there is none.
pub(crate) struct Attempted {
    pub tried: Tried,
    pub failed: Option<String>,
}

/// Less is better: what meets the requirements by its speed, and before what does not by how much that misses.
pub(crate) fn merit(tried: &Tried) -> f64 {
    if tried.worst() >= SPARE { tried.cost } else { LOST + SPARE - tried.worst() }
}

/// Of those that meet what is required, or of all where none does, those that no other beats in both rise and disk
/// margin, the fastest first.
pub(crate) fn front(tried: &[&Tried]) -> Vec<Tried> {
    let any = tried.iter().any(|t| t.meets_all());
    let mut sorted: Vec<&Tried> = tried
        .iter()
        .copied()
        .filter(|t| t.rise.is_finite() && t.disk.is_finite() && (t.meets_all() || !any))
        .collect();
    sorted.sort_by(|a, b| a.rise.total_cmp(&b.rise).then(b.disk.total_cmp(&a.disk)));
    let mut best = f64::NEG_INFINITY;
    let beats = |t: &&Tried| {
        let better = t.disk > best;
        best = best.max(t.disk);
        better
    };
    sorted.into_iter().filter(beats).cloned().collect()
}
