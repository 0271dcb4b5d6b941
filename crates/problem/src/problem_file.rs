//! Problem files of `squid lpv`: a generalised plant as JSON.
//!
//! ```json
//! {"kind": "lpvsyn-lft", "data": {"P": {"A": [[..]], "Bt": .., "B1": .., "B2": .., "Ct": .., "C1": .., "C2": ..,
//!  "Dtt": .., "Dt1": .., "Dt2": .., "D1t": .., "D11": .., "D12": .., "D2t": .., "D21": .., "D22": ..},
//!  "blocks": [r_1, ..], "rate": ..}}
//! {"kind": "hinfsyn", "data": {"A": .., "B1": .., "B2": .., "C1": .., "C2": .., "D11": .., "D12": .., "D21": ..}}
//! ```
//!
//! A certificate is also a problem file, with its plant. Matrices are lists of rows; the partition is that of
//! `squid_lpv::plant`. Sizes follow from any matrix that determines them: a plant without states has `"A": []`, and the
//! numbers of inputs and outputs of `D11`, `D12` and `D21`. The text is parsed as strictly as a certificate: duplicate
//! and unknown keys are errors, except for comments: `kind`, `name`, `source`, `tests`, `expected`, `note`, `notes`,
//! `right` and `unit`, and `convention`, `Bt_scale` and `G` of published cases.
//!
//! `rate`, next to `blocks`, is the bound on `|theta'|` of a plant with one parameter, in units of theta per unit of
//! time; without it the rates are arbitrary. `dt`, in either kind, is the sample time \[s\] of a discrete-time plant,
//! with `x+` for `x'`; for the plant of a discrete-time certificate it is 1 by default.
//!
//! Weights are part of the plant, so they must be proper: an improper weight has no state-space form with finite
//! matrices. Its usual forms are refused with a reason: `E` of a descriptor system `E x' = A x + ..` unless it is the
//! identity, and numbers that are not finite. The direct path from u to y, `D22`, is optional and 0 by default.

use crate::discrete::{Discrete, POLES_AT_BOTH_ENDS};
use crate::error::Error;
use crate::object::{Given, Matrices, Matrix, System, checked, object};
use crate::source::Source;
use serde::Deserialize;
use serde::de::IgnoredAny;
use squid_certificate::from_json;
use squid_lpv::matrix::Mat;
use squid_lpv::partition::Group::{U, W, Y, Z};
use squid_lpv::partition::{NamedBlock, PLANT, Sizes, names};
use squid_lpv::plant::GeneralisedPlant;
use squid_proof::claim::parse;

/// Generalised plant in continuous time with a direct path from u to y, and the rate bound of its parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Plant without the direct path.
    pub plant: GeneralisedPlant,
    /// Direct path from u to y.
    pub d22: Mat,
    /// Bound on `|theta'|` of the only parameter; `None` for arbitrary rates.
    pub rate: Option<f64>,
    /// Plant of the file, if it is in discrete time.
    pub discrete: Option<Discrete>,
}

/// Defines the objects with the matrices of a plant.
macro_rules! plant {
    ($($key:literal $field:ident),*) => {
        object! {
            /// Matrices of a plant.
            PlantFile {; $($key $field),* }
        }

        object! {
            file
            /// Content of `data`, or of the file: a plant, its parameters and its controller.
            Data {
                "P" p: PlantFile, "plant" plant: PlantFile, "blocks" blocks: Vec<f64>, "rate" rate: f64, "dt" dt: f64,
                "K" k: System, "sample_time" sample_time: f64, "delay" delay: f64, "held" held: bool; $($key $field),*
            }
        }
    };
}
plant!("A" a, "Bt" bt, "B1" b1, "B2" b2, "Ct" ct, "C1" c1, "C2" c2, "Dtt" dtt, "Dt1" dt1, "Dt2" dt2, "D1t" d1t,
    "D11" d11, "D12" d12, "D2t" d2t, "D21" d21, "D22" d22, "E" e);

/// Keys that only the problem of a sampled loop has.
const OF_SAMPLED_LOOP: [&str; 4] = ["K", "sample_time", "delay", "held"];

/// Keys that only the other problems have.
const OF_PLANT: [&str; 2] = ["rate", "dt"];

/// Reads a problem file.
///
/// # Errors
/// [`Error::Problem`] with file and key, also if the sizes of matrices do not match.
pub fn problem(source: &Source) -> Result<Problem, Error> {
    read(source, true)
}

/// Reads the problem file of a sampled-data loop: its continuous-time plant, and the remaining data.
///
/// # Errors
/// Errors of [`problem`].
pub fn sampled_loop(source: &Source) -> Result<(Problem, Data), Error> {
    let (matrices, data) = data(
        source,
        &OF_PLANT,
        "does not apply to a sampled loop, whose plant is in continuous time; remove it",
    )?;
    Ok((built(source, matrices, &data, true)?, data))
}

/// Reads the problem file of a closed loop: a plant without controls and measurements, whose matrices are omitted.
///
/// # Errors
/// Errors of [`problem`]; [`Error::Problem`] if there are controls or measurements.
pub fn finished(source: &Source) -> Result<Problem, Error> {
    let problem = read(source, false)?;
    let sizes = problem.plant.sizes();
    for (key, count, what) in [("B2", sizes.u, "controls"), ("C2", sizes.y, "measurements")] {
        if count > 0 {
            let reason = format!(
                "must be empty, because the gain is that of a closed loop, but the number of {what} is {count}; \
                 close the loop first, or design a controller with `squid lpv synth`"
            );
            return Err(source.wrong(key, reason));
        }
    }
    Ok(problem)
}

/// Key that identifies a file as a certificate.
#[derive(Deserialize)]
struct Format {
    format: Option<IgnoredAny>,
}

fn read(source: &Source, with_control: bool) -> Result<Problem, Error> {
    if from_json::<Format>(&source.text).is_ok_and(|file| file.format.is_some()) {
        let certificate = parse(&source.text, &source.name)?;
        let matrices = certificate.plant.named().into_iter().map(|(key, rows)| (key, Matrix::from(rows)));
        let matrices =
            matrices.chain(certificate.plant.direct_path().map(|rows| ("D22", Matrix::from(rows)))).collect();
        let blocks = certificate.blocks.iter().map(|r| *r as f64).collect();
        let dt = certificate.discrete.then_some(1.0);
        let data = Data { blocks: Some(blocks), dt, ..Data::default() };
        return built(source, matrices, &data, with_control);
    }
    let reason = "applies to sampled loops only; the sample time of a discrete-time plant is 'dt'";
    let (matrices, data) = data(source, &OF_SAMPLED_LOOP, reason)?;
    built(source, matrices, &data, with_control)
}

/// Reads the matrices of the plant, and the remaining data. The keys `others` belong to another kind of problem; they
/// are refused with the reason `text`.
fn data(source: &Source, others: &[&str], text: &str) -> Result<(Given, Data), Error> {
    let mut data = Data::read(source)?;
    if let Some(key) = data.keys().find(|key| others.contains(key)) {
        return Err(source.wrong(key, text));
    }
    if data.p.is_some() && data.plant.is_some() {
        return Err(source.wrong("P", "and 'plant' are both given; remove one of the two"));
    }
    let here = data.take();
    if let Some(mut plant) = data.p.take().or(data.plant.take()) {
        return match here.first() {
            Some((key, _)) => Err(source.misplaced(key, "in 'P'")),
            None => Ok((plant.take(), data)),
        };
    }
    if let Some(key) = data.keys().find(|key| ["blocks", "rate"].contains(key)) {
        return Err(source.misplaced(key, "next to a plant 'P' with parameters"));
    }
    data.blocks = Some(vec![]);
    Ok((here, data))
}

/// Builds the problem of a file.
fn built(source: &Source, given: Given, data: &Data, with_control: bool) -> Result<Problem, Error> {
    let blocks = blocks(source, data)?;
    let parts = partition(&Matrices { source, given }, &blocks, with_control)?;
    let mut plant = GeneralisedPlant::new(blocks, &parts).map_err(|shape| source.wrong("", shape))?;
    let d22 = plant.parts.block(Y, U);
    plant.parts.block_mut(Y, U).fill(0.0);
    if with_control && plant.parts.join(&[Z], PLANT.1).amax() == 0.0 {
        return Err(source.wrong("C1", NOTHING_IN_Z));
    }
    if with_control && plant.parts.join(PLANT.0, &[W]).amax() == 0.0 {
        return Err(source.wrong("B1", NOTHING_FROM_W));
    }
    let rate = rate(source, data, &plant, &d22)?;
    let Some(sample_time) = sample_time(source, data.dt)? else {
        return Ok(Problem { plant, d22, rate, discrete: None });
    };
    if rate.is_some() {
        let text =
            "and 'rate' exclude each other, because 'rate' applies to continuous time; remove one of the two";
        return Err(source.wrong("dt", text));
    }
    let (discrete, plant, d22) =
        Discrete::new(plant, d22, sample_time).ok_or_else(|| source.wrong("A", POLES_AT_BOTH_ENDS))?;
    Ok(Problem { plant, d22, rate, discrete: Some(discrete) })
}

const NOTHING_IN_Z: &str = "and all other matrices of z are zero, so that there is nothing to minimise; include in z \
    the signals that should be small";

const NOTHING_FROM_W: &str = "and all other matrices of w are zero, so that there is nothing to minimise; include in \
    w the disturbances of the plant or its measurements";

/// Returns the repetitions of the parameters.
fn blocks(source: &Source, data: &Data) -> Result<Vec<usize>, Error> {
    let list = data.blocks.as_ref().ok_or_else(|| source.wrong("blocks", "is missing"))?;
    let repetitions = |(i, r): (usize, &f64)| {
        if (1.0..=1000.0).contains(r) && r.fract() == 0.0 {
            return Ok(*r as usize);
        }
        let allowed = "every entry must be an integer from 1 to 1000";
        Err(source.wrong("blocks", format!("has the entry {r:?} (number {}); {allowed}", i + 1)))
    };
    list.iter().enumerate().map(repetitions).collect()
}

/// Checks the sample time of a discrete-time plant.
///
/// # Errors
/// [`Error::Problem`] if it is out of range.
pub fn sample_time(source: &Source, dt: Option<f64>) -> Result<Option<f64>, Error> {
    let (least, most) = SAMPLE_TIMES;
    let allowed = format!("a sample time from {least:e} to {most:e} s");
    checked(source, "dt", dt, &allowed, |time| (least..=most).contains(&time))
}

/// Range of sample times, s; outside it the transform to continuous time overflows.
const SAMPLE_TIMES: (f64, f64) = (1e-9, 1e9);

/// Returns the bound on the rate of the parameter.
fn rate(source: &Source, data: &Data, plant: &GeneralisedPlant, d22: &Mat) -> Result<Option<f64>, Error> {
    let allowed = format!("a number from 0 to {FASTEST:e}");
    let rate = checked(source, "rate", data.rate, &allowed, |rate| (0.0..=FASTEST).contains(&rate))?;
    if rate.is_none() {
        return Ok(None);
    }
    if plant.blocks.len() != 1 {
        let count = plant.blocks.len();
        let text = format!("bounds the rate of a single parameter, but 'blocks' has {count}; remove it");
        return Err(source.wrong("rate", text));
    }
    if d22.iter().any(|entry| *entry != 0.0) {
        let text = "and a direct path 'D22' exclude each other; design for y - D22 u, without 'D22', or remove 'rate'";
        return Err(source.wrong("rate", text));
    }
    Ok(rate)
}

/// Largest bound on a rate; beyond it the rate is practically arbitrary.
const FASTEST: f64 = 1e6;

fn no_performance(part: &str, missing: &str) -> String {
    format!(
        "has no {part}, so there is {missing}; a problem requires a performance channel from w (B1, D11, D21) to z \
            (C1, D11, D12), whose gain is minimised"
    )
}

/// Returns the blocks of the plant; a matrix without rows or columns may be omitted, unless it determines sizes.
fn partition(m: &Matrices<'_>, blocks: &[usize], with_control: bool) -> Result<Vec<NamedBlock>, Error> {
    let n = m.shape(&["A"]).0;
    let a = m.get("A", (n, n), false)?;
    m.only_identity("E", IMPROPER)?;
    let (w, u) = (m.shape(&["B1", "D11", "D21", "Dt1"]).1, m.shape(&["B2", "D12", "Dt2"]).1);
    let (z, y) = (m.shape(&["C1", "D11", "D12", "D1t"]).0, m.shape(&["C2", "D21", "D2t"]).0);
    let sizes = Sizes { x: n, t: blocks.iter().sum(), w, u, z, y };
    for (key, size, part, missing) in
        [("B1", w, "columns", "no disturbance w"), ("C1", z, "rows", "no output z")]
    {
        if size == 0 && (n == 0 || m.rows(key).is_some()) {
            return Err(m.source.wrong(key, no_performance(part, missing)));
        }
    }
    let part = |(key, row, column)| {
        let shape = (sizes.of(row), sizes.of(column));
        let required = n > 0 && (matches!(key, "B1" | "C1") || with_control && matches!(key, "B2" | "C2"));
        let is_zero = key == "D22" && m.rows(key).is_none();
        let optional = is_zero || !required && (shape.0 == 0 || shape.1 == 0);
        Ok((row, column, if key == "A" { a.clone() } else { m.get(key, shape, optional)? }))
    };
    names(PLANT).map(part).collect()
}

const IMPROPER: &str = "the identity or omitted: with a singular E the plant, or a weight in it, is improper (its \
    gain grows without limit with frequency), and no least gamma exists; add a pole well above the bandwidth to such \
    a weight";

#[cfg(test)]
mod tests {
    use super::*;

    fn plant_of(text: &str) -> Result<GeneralisedPlant, Error> {
        let source = Source { name: "p.json".into(), text: text.into() };
        problem(&source).map(|problem| problem.plant)
    }

    /// Messages of texts that are refused.
    #[derive(Default)]
    struct Refused(String);

    impl Refused {
        /// Asserts the line, 0 if none is known, and the key.
        #[track_caller]
        fn at(&mut self, (line, key): (usize, &str), text: &str) {
            let error = plant_of(text).unwrap_err();
            match &error {
                Error::Problem { line: found, key: found_key, .. } => {
                    assert_eq!((found.unwrap_or(0), found_key.as_str()), (line, key), "{error}")
                }
                other => panic!("{other}"),
            }
            self.0 += &format!("{error}\n\n");
        }
    }

    const PLAIN: &str = r#"{"A": [[-1.0]], "B1": [[1.0]], "B2": [[1.0]], "C1": [[1.0], [0.0]], "C2": [[1.0]],
        "D11": [[0.0], [0.0]], "D12": [[0.0], [1.0]], "D21": [[1.0]]}"#;

    #[test]
    fn sizes_of_static_plants_follow_from_direct_paths() {
        let text = r#"{"A": [], "B1": [], "B2": [], "C1": [[]], "C2": [[]],
            "D11": [[1, 2]], "D12": [[1]], "D21": [[1, 0]]}"#;
        let p = plant_of(text).unwrap();
        assert_eq!(
            (p.b1().shape(), p.b2().shape(), p.c1().shape(), p.c2().shape()),
            ((0, 2), (0, 1), (1, 0), (1, 0))
        );
        let without = r#"{"A": [], "D11": [[1, 2]], "D12": [[1]], "D21": [[1, 0]]}"#;
        assert_eq!(plant_of(without).unwrap(), p);
        let scheduled = r#"{"P": {"A": [], "Dtt": [[0.5]], "Dt1": [[1]], "Dt2": [[0]], "D1t": [[1]], "D11": [[0]],
            "D12": [[0.1]], "D2t": [[0]], "D21": [[1]]}, "blocks": [1]}"#;
        let p = plant_of(scheduled).unwrap();
        assert_eq!((p.bt().shape(), p.ct().shape(), p.blocks), ((0, 1), (1, 0), vec![1]));
    }

    #[test]
    fn errors_of_syntax_name_the_line() {
        let mut refused = Refused::default();
        refused.at((2, "B1"), "{\"A\": [[1]],\n \"B1\": [[1],]}");
        refused.at((3, "B1[0][0]"), "{\"A\": [[1]],\n\n \"B1\": [[Infinity]]}");
        insta::assert_snapshot!(refused.0);
    }

    #[test]
    fn refuses_unknown_and_misplaced_keys() {
        let matrices = PLAIN.trim().trim_start_matches('{').trim_end_matches('}');
        let nested = |beside: &str, inside: &str, above: &str| {
            format!(r#"{{"data": {{"P": {{{matrices}{inside}}}, "blocks": []{beside}}}{above}}}"#)
        };
        assert_eq!(plant_of(&nested("", "", "")).unwrap(), plant_of(PLAIN).unwrap());
        plant_of(&nested(r#", "notes": 1, "convention": 2"#, "", r#", "source": 3"#)).unwrap();
        let mut refused = Refused::default();
        for (beside, inside, above, line, key) in [
            (r#", "Rate": 0.5"#, "", "", 2, "data.Rate"),
            (r#", "sample_time": 0.1"#, "", "", 0, "sample_time"),
            ("", r#", "d22": [[5]]"#, "", 2, "data.P.d22"),
            (r#", "speed": 1"#, "", "", 2, "data.speed"),
            ("", r#", "unit": "m""#, "", 2, "data.P.unit"),
            ("", "", r#", "speed": 1"#, 2, "speed"),
            ("", r#", "dt": 0.1"#, "", 2, "data.P.dt"),
        ] {
            refused.at((line, key), &nested(beside, inside, above));
        }
        insta::assert_snapshot!(refused.0);
    }

    #[test]
    fn requires_performance_channel() {
        let no_w = r#"{"A": [[1]], "B1": [[]], "B2": [[1]], "C1": [[1]], "C2": [[1]],
            "D11": [[]], "D12": [[1]], "D21": [[]]}"#;
        let no_z = r#"{"A": [[1]], "B1": [[1]], "B2": [[1]], "C1": [], "C2": [[1]],
            "D11": [], "D12": [], "D21": [[1]]}"#;
        let mut refused = Refused::default();
        refused.at((0, "B1"), no_w);
        refused.at((0, "C1"), no_z);
        insta::assert_snapshot!(refused.0);
    }

    #[test]
    fn errors_name_file_and_key() {
        assert!(plant_of(PLAIN).is_ok());
        let mut refused = Refused::default();
        for (old, new, line, key) in [
            (r#""A": [[-1.0]]"#, r#""A": [["x"]]"#, 1, "A[0][0]"),
            (r#""A": [[-1.0]]"#, r#""A": [[null]]"#, 1, "A[0][0]"),
            (r#""A": [[-1.0]]"#, r#""A": [-1.0]"#, 1, "A[0]"),
            (r#""A": [[-1.0]]"#, r#""A": -1.0"#, 1, "A"),
            (r#""A": [[-1.0]]"#, r#""A": [[-1e101]]"#, 1, "A[0][0]"),
            (r#""A": [[-1.0]]"#, r#""A": [[Infinity]]"#, 1, "A[0][0]"),
            (r#""A": [[-1.0]]"#, r#""A": [[1e999]]"#, 1, "A[0][0]"),
            (r#""D21": [[1.0]]"#, r#""D21": [[1.0, 2.0]]"#, 0, "D21"),
            (r#""D21": [[1.0]]"#, r#""D21": [[1.0, 2.0], [1.0]]"#, 2, "D21"),
            (r#""D21": [[1.0]]"#, r#""D21": [[1.0]], "A": [[0.0]]"#, 2, ""),
            (r#""D21": [[1.0]]"#, r#""note": "inf", "D21": [[1.0]]]"#, 2, ""),
        ] {
            refused.at((line, key), &PLAIN.replacen(old, new, 1));
        }
        insta::assert_snapshot!(refused.0);
    }
}
