//! Certificates for the tests: the golden ones, and small ones to check by hand.

use serde_json::{Value, json};
use squid_certificate::{Certificate, Claim, Failure, Gain, JsonError, Theorem};

/// Names of the golden certificates in `tests/certificates`.
pub const GOLDEN: [&str; 5] = ["hs04", "lpv01", "lpv03", "remus100", "squid_surrogate"];

/// Returns the text of a golden certificate.
pub fn golden_text(name: &str) -> String {
    let path = format!("{}/../../tests/certificates/{name}.json", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Returns a golden certificate.
pub fn golden(name: &str) -> Certificate {
    Certificate::from_json(&golden_text(name)).unwrap()
}

/// Returns the certificate of `x' = u + w`, `z = y = x`, `u = -y`: the gain is 1. With X = 1 the inequality
/// `[-2 1 1; 1 -gamma 0; 1 0 -gamma] < 0` requires `2 gamma > 2`.
pub fn integrator(gamma: f64) -> Value {
    json!({
        "format": "lpv-certificate/1", "blocks": [], "controller_blocks": [],
        "plant": {
            "A": [[0.0]], "Bt": [[]], "B1": [[1.0]], "B2": [[1.0]], "Ct": [], "C1": [[1.0]], "C2": [[1.0]],
            "Dtt": [], "Dt1": [], "Dt2": [], "D1t": [[]], "D11": [[0.0]], "D12": [[0.0]], "D2t": [[]], "D21": [[0.0]]
        },
        "controller": {
            "A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[-1.0]], "Dut": [[]], "Ct": [], "Dty": [], "Dtt": []
        },
        "claims": [{"gain": {"gamma": gamma, "X": [[1.0]], "S": [], "T": []}}]
    })
}

/// Returns the certificate of `x' = -2 x + theta x + u + w`, `z = y = x`, `u = -y + theta y/2`, hence
/// `x' = (-3 + 1.5 theta) x + w`: the gain is largest at frozen theta = 1, 1/1.5.
///
/// The channels are `zt = x` and `zk = y = x`. With X = 1, S = blkdiag(s, sk), T = 0 the inequality, after its Schur
/// complements, is `[-6 + s + sk + 1/gamma, 1, 1/2, 1; 1, -s, 0, 0; 1/2, 0, -sk, 0; 1, 0, 0, -gamma] < 0`, that is
/// `-6 + (s + 1/s) + (sk + 1/(4 sk)) + 2/gamma < 0`: with s = 1 and sk = 1/2, `gamma > 2/3`.
pub fn scheduled(gamma: f64) -> Value {
    json!({
        "format": "lpv-certificate/1", "blocks": [1], "controller_blocks": [1],
        "plant": {
            "A": [[-2.0]], "Bt": [[1.0]], "B1": [[1.0]], "B2": [[1.0]], "Ct": [[1.0]], "C1": [[1.0]], "C2": [[1.0]],
            "Dtt": [[0.0]], "Dt1": [[0.0]], "Dt2": [[0.0]], "D1t": [[0.0]], "D11": [[0.0]], "D12": [[0.0]],
            "D2t": [[0.0]], "D21": [[0.0]]
        },
        "controller": {
            "A": [], "By": [], "Bt": [], "Cu": [[]], "Duy": [[-1.0]], "Dut": [[0.5]], "Ct": [[]], "Dty": [[1.0]],
            "Dtt": [[0.0]]
        },
        "claims": [{"gain": {
            "gamma": gamma, "X": [[1.0]], "S": [[1.0, 0.0], [0.0, 0.5]], "T": [[0.0, 0.0], [0.0, 0.0]]
        }}]
    })
}

/// Returns the last claim of a kind.
pub fn claim<'a>(c: &'a mut Value, kind: &str) -> &'a mut Value {
    let claims = c["claims"].as_array_mut().unwrap();
    claims.iter_mut().rev().find_map(|claim| claim.get_mut(kind)).unwrap()
}

/// Adds a claim.
pub fn add(c: &mut Value, kind: &str, claim: Value) {
    c["claims"].as_array_mut().unwrap().push(json!({ kind: claim }));
}

/// Removes the claims of a kind.
pub fn remove(c: &mut Value, kind: &str) {
    c["claims"].as_array_mut().unwrap().retain(|claim| claim.get(kind).is_none());
}

/// Adds a model error with the keys `E`, `F`, `Fw`, `Fu` of `values`, and the claim `gain` that covers it, with the
/// other keys.
pub fn add_model_error(c: &mut Value, mut values: Value) {
    let keys = values.as_object_mut().unwrap();
    let error =
        ["E", "F", "Fw", "Fu"].into_iter().filter_map(|key| Some((key.to_owned(), keys.remove(key)?)));
    c["errors"] = json!([error.collect::<serde_json::Map<_, _>>()]);
    add(c, "gain", values);
}

/// Returns the claim about the gain without model error, mutable.
pub fn gain(c: &mut Certificate) -> &mut Gain {
    let mut gains =
        c.claims.iter_mut().filter_map(|claim| if let Claim::Gain(gain) = claim { Some(gain) } else { None });
    gains.find(|gain| gain.lambda.is_none()).unwrap()
}

/// Proves a JSON value.
pub fn prove(value: &Value) -> Result<Theorem, Failure> {
    Certificate::from_json(&value.to_string())?.prove()
}

/// Returns `true` if a failure is at a path of the file, or of a claim and a part with a word in its name, such as
/// `Gain gamma`.
pub fn is_at(failure: &Failure, place: &str) -> bool {
    match failure {
        Failure::Json(JsonError { path, .. }) | Failure::Malformed { path, .. } => path == place,
        Failure::NotWellPosed => false,
        Failure::Condition { claim, part, .. }
        | Failure::Structure { claim, part, .. }
        | Failure::NotDefinite { claim, part, .. } => {
            part.split(' ').any(|word| format!("{claim:?} {word}") == place)
        }
    }
}

/// Messages of refused certificates, each once.
#[derive(Default)]
pub struct Refused(pub String);

impl Refused {
    /// Asserts the place at which a certificate fails, see [`is_at`].
    pub fn at(&mut self, place: &str, file: &Value) {
        self.add(place, &prove(file).unwrap_err());
    }

    /// Asserts the place of a failure.
    pub fn add(&mut self, place: &str, failure: &Failure) {
        assert!(is_at(failure, place), "{place}: {failure}");
        let message = format!("{failure}\n\n");
        if !self.0.contains(&message) {
            self.0 += &message;
        }
    }
}
