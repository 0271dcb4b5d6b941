//! Random cases with a stored corpus:
//!
//! ```text
//! replay tests/corpus/NAME.jsonl -> random cases, half of them derived from the corpus
//!                                -> more of them for SQUID_FUZZ_MINUTES
//! ```
//!
//! A property returns the outcomes of its case as texts ("fmi2SetReal: variable may not be set in state"). A run with
//! `SQUID_FUZZ_MINUTES` simplifies the first case with a new outcome as far as possible and adds it to the corpus, from
//! which every later run replays it; a case whose simplification is not finished in time is left to another run. Every
//! run adds failing cases.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::env;
use std::fmt::Debug;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::test_runner::{TestError, TestRunner};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Outcomes of a case.
pub type Seen = BTreeSet<String>;

/// Time limit of a case; exceeding it is a failure, because the host would hang.
const PATIENCE: Duration = Duration::from_secs(60);

/// Number of cases between two checks of the time.
const BATCH: u32 = 200;

/// Number of words of a sentence that identify its reason.
const WORDS: usize = 10;

/// A random case that can be derived from stored cases and be simplified.
pub trait Case: Serialize + DeserializeOwned + Clone + Debug + 'static {
    /// Returns the strategy for arbitrary cases.
    fn fresh() -> BoxedStrategy<Self>;

    /// Returns a stored case that continues differently from `at` on.
    fn grown(self, by: Self, at: usize) -> Self;

    /// Returns simpler cases, the simplest first.
    fn simpler(&self) -> Vec<Self>;
}

/// Replays the stored cases, then tries random ones.
pub fn run<T: Case>(name: &str, property: impl Fn(&T) -> Seen) {
    let watch = Watch::new(name);
    let watched = |case: &T| {
        watch.over(format!("{case:?}"));
        let seen = property(case);
        watch.off();
        seen
    };
    let mut corpus = Corpus::read(name);
    for case in &corpus.cases {
        corpus.seen.extend(watched(case));
    }
    let minutes: Option<f64> =
        env::var("SQUID_FUZZ_MINUTES").ok().map(|text| text.parse().expect("SQUID_FUZZ_MINUTES is a number"));
    let end = Instant::now() + Duration::from_secs_f64(60.0 * minutes.unwrap_or(0.0));
    let mut tried: u64 = 0;
    loop {
        tried += u64::from(corpus.batch(minutes.map(|_| end), &watched));
        if Instant::now() >= end {
            break;
        }
    }
    println!(
        "{name}: {} kept cases, {tried} random ones, {} things seen",
        corpus.cases.len(),
        corpus.seen.len()
    );
}

/// Stored cases of one property.
struct Corpus<T> {
    path: PathBuf,
    cases: Vec<T>,
    seen: Seen,
}

impl<T: Case> Corpus<T> {
    fn read(name: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
        let path = folder.join(format!("{name}.jsonl"));
        let text = fs::read_to_string(&path).unwrap_or_default();
        let case =
            |line: &str| serde_json::from_str(line).unwrap_or_else(|error| panic!("{path:?}: {error}"));
        let cases = text.lines().map(case).collect();
        Self { path, cases, seen: Seen::new() }
    }

    fn strategy(&self) -> BoxedStrategy<T> {
        if self.cases.is_empty() {
            return T::fresh();
        }
        let kept = prop::sample::select(self.cases.clone());
        let grown = (kept, T::fresh(), any::<prop::sample::Index>());
        let grown = grown.prop_map(|(kept, by, at)| kept.grown(by, at.index(1 << 16)));
        prop_oneof![T::fresh(), grown].boxed()
    }

    /// Tries `PROPTEST_CASES` cases, or one batch of a run with an end time.
    fn batch(&mut self, end: Option<Instant>, property: &impl Fn(&T) -> Seen) -> u32 {
        let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
        let config = if end.is_some() { ProptestConfig { cases: BATCH, ..config } } else { config };
        let cases = config.cases;
        let new = RefCell::new(Vec::new());
        let seen = &self.seen;
        let outcome = TestRunner::new(config).run(&self.strategy(), |case| {
            if !property(&case).is_subset(seen) {
                new.borrow_mut().push(case);
            }
            Ok(())
        });
        if let Err(TestError::Fail(reason, case)) = outcome {
            self.keep(case.clone());
            panic!("{reason}\nadded to {:?}: {case:?}", self.path);
        }
        if let Some(end) = end {
            new.into_inner().into_iter().for_each(|case| self.consider(case, end, property));
        }
        cases
    }

    /// Adds a case, simplified as far as possible, if it still has a new outcome.
    fn consider(&mut self, mut case: T, end: Instant, property: &impl Fn(&T) -> Seen) {
        let over = || Instant::now() >= end;
        if over() {
            return;
        }
        let new: Seen = property(&case).difference(&self.seen).cloned().collect();
        if new.is_empty() {
            return;
        }
        while let Some(simpler) =
            case.simpler().into_iter().find(|one| !over() && new.is_subset(&property(one)))
        {
            case = simpler;
        }
        if over() {
            return;
        }
        self.seen.extend(property(&case));
        self.keep(case);
    }

    fn keep(&mut self, case: T) {
        let line = serde_json::to_string(&case).unwrap();
        let mut file = OpenOptions::new().create(true).append(true).open(&self.path).unwrap();
        writeln!(file, "{line}").unwrap();
        self.cases.push(case);
    }
}

/// Watchdog that ends the process if a case takes too long, since a call that never returns cannot be caught.
struct Watch {
    tell: Mutex<Sender<Option<String>>>,
}

impl Watch {
    fn new(name: &str) -> Self {
        let (tell, hear) = channel::<Option<String>>();
        let name = name.to_owned();
        std::thread::spawn(move || {
            let mut case = None;
            loop {
                let heard = match &case {
                    Some(_) => hear.recv_timeout(PATIENCE),
                    None => hear.recv().map_err(|_| RecvTimeoutError::Disconnected),
                };
                case = match (heard, case) {
                    (Ok(next), _) => next,
                    (Err(RecvTimeoutError::Timeout), Some(case)) => {
                        // Output of print macros would be captured until the test ends, which this one does not.
                        let _ = writeln!(std::io::stderr(), "{name}: longer than {PATIENCE:?}: {case}");
                        std::process::abort();
                    }
                    _ => return,
                };
            }
        });
        Self { tell: Mutex::new(tell) }
    }

    fn over(&self, case: String) {
        self.tell.lock().unwrap().send(Some(case)).unwrap();
    }

    fn off(&self) {
        self.tell.lock().unwrap().send(None).unwrap();
    }
}

/// Returns the start of a sentence without numbers, names and quotations, so that sentences with the same reason agree.
pub fn kind_of(sentence: &str) -> String {
    let quotes = |c: char| "'`\"".contains(c);
    let spoken = sentence.split(quotes).step_by(2).flat_map(str::split_whitespace);
    let is_word = |word: &&str| word.bytes().all(|byte| byte.is_ascii_alphabetic() || b",:;".contains(&byte));
    spoken.filter(is_word).take(WORDS).collect::<Vec<_>>().join(" ")
}

/// Real numbers as text, since JSON has neither infinities nor NaN.
#[allow(dead_code, reason = "not every case has real numbers")]
pub mod reals {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        let texts: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        texts.serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        let texts = Vec::<String>::deserialize(deserializer)?;
        texts.iter().map(|text| text.parse().map_err(serde::de::Error::custom)).collect()
    }
}
