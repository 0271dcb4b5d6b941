//! From the JSON tree to the certificate, with the path of each error.

use crate::certificate::{
    AnyRate, BoundedRate, Certificate, Controller, Energy, EnergyClaim, FORMAT, Limits, Plant, Residual,
    Rows, Slow, SlowResidual,
};
use crate::error::ReadError;
use crate::json::Json;

const TOP: [&str; 5] = ["format", "blocks", "controller_blocks", "plant", "controller"];
const OPTIONAL: [&str; 5] = ["discrete", "residual", "bounded_rate", "limits", "energy"];
const ANY_RATE: [&str; 4] = ["gamma", "X", "S", "T"];
const ANY_RATE_BY_FACTOR: [&str; 4] = ["gamma", "V", "S", "T"];
const SLOW: [&str; 5] = ["gamma", "inverse", "X", "breakpoints", "N"];

/// An object with every required key and no unknown key.
pub(crate) struct Fields<'a> {
    /// `plant.` for the keys of `plant`, empty at the top.
    prefix: String,
    entries: &'a [(String, Json)],
}

/// A value of the file, from its JSON.
pub(crate) trait Read: Sized {
    /// # Errors
    /// The first problem, with the path of its field.
    fn read(path: &str, json: &Json) -> Result<Self, ReadError>;
}

impl Certificate {
    /// Reads a certificate of format [`FORMAT`].
    ///
    /// # Errors
    /// [`ReadError`], the first problem of the text.
    pub fn from_json(text: &str) -> Result<Self, ReadError> {
        let certificate = certificate(&serde_json::from_str(text)?)?;
        certificate.check()?;
        Ok(certificate)
    }
}

fn certificate(json: &Json) -> Result<Certificate, ReadError> {
    check_format(json, FORMAT)?;
    // A claim of a bounded rate may stand alone.
    let has = |key: &str| matches!(json, Json::Object(entries) if entries.iter().any(|(k, _)| k == key));
    let with_any_rate = !has("bounded_rate") || ANY_RATE.into_iter().chain(["V"]).any(has);
    let claim = if has("V") { &ANY_RATE_BY_FACTOR } else { &ANY_RATE };
    let any_rate: &[&str] = if with_any_rate { claim } else { &[] };
    let required = [&TOP, any_rate].concat();
    let top = Fields::new("", json, &required, &OPTIONAL)?;
    Ok(Certificate {
        discrete: top.read("discrete")?,
        blocks: top.read("blocks")?,
        controller_blocks: top.read("controller_blocks")?,
        plant: top.read("plant")?,
        controller: top.read("controller")?,
        any_rate: with_any_rate.then(|| any_rate_claim(&top)).transpose()?,
        residual: top.read("residual")?,
        bounded_rate: top.read("bounded_rate")?,
        limits: top.read("limits")?,
        energy: top.read("energy")?,
    })
}

fn any_rate_claim(top: &Fields<'_>) -> Result<AnyRate, ReadError> {
    Ok(AnyRate {
        gamma: top.read("gamma")?,
        x: top.read("X")?,
        v: top.read("V")?,
        s: top.read("S")?,
        t: top.read("T")?,
    })
}

/// The format is checked first, because another format has other keys.
pub(crate) fn check_format(json: &Json, allowed: &str) -> Result<(), ReadError> {
    let Json::Object(entries) = json else {
        return Err(ReadError::kind("the certificate", json.describe(), "an object"));
    };
    let found = entries.iter().find(|(key, _)| key == "format").map(|(_, value)| value);
    if matches!(found, Some(Json::Text(text)) if text == allowed) {
        return Ok(());
    }
    let found = found.map_or_else(|| "nothing".into(), Json::describe);
    Err(ReadError::Format { found, allowed: format!("{allowed:?}") })
}

impl Read for BoundedRate {
    fn read(path: &str, json: &Json) -> Result<Self, ReadError> {
        let f = Fields::new(path, json, &[&["rate"], &SLOW[..]].concat(), &["residual"])?;
        Ok(Self { rate: f.read("rate")?, slow: slow(&f)?, residual: f.read("residual")? })
    }
}

impl Read for SlowResidual {
    fn read(path: &str, json: &Json) -> Result<Self, ReadError> {
        let f = Fields::new(path, json, &[&["lambda"], &SLOW[..]].concat(), &[])?;
        Ok(Self { lambda: f.read("lambda")?, slow: slow(&f)? })
    }
}

fn slow(f: &Fields<'_>) -> Result<Slow, ReadError> {
    Ok(Slow {
        gamma: f.read("gamma")?,
        inverse: f.read("inverse")?,
        x: f.read("X")?,
        breakpoints: f.read("breakpoints")?,
        n: f.read("N")?,
    })
}

/// Reads an object of the file: each field and its key, after a plus a key that must be there and is not read; those
/// after the semicolon may be missing.
macro_rules! objects {
    ($(
        $of:ident $(+ $unread:literal)?: $($field:ident $key:literal),*; $($optional:ident $optional_key:literal),*;
    )*) => {
        $(impl $crate::read::Read for $of {
            fn read(path: &str, json: &$crate::Json) -> Result<Self, $crate::ReadError> {
                let f = $crate::read::Fields::new(path, json, &[$($unread,)? $($key),*], &[$($optional_key),*])?;
                Ok(Self { $($field: f.read($key)?,)* $($optional: f.read($optional_key)?),* })
            }
        })*
    };
}

objects! {
    Plant: a "A", bt "Bt", b1 "B1", b2 "B2", ct "Ct", dtt "Dtt", dt1 "Dt1", dt2 "Dt2", c1 "C1", d1t "D1t", d11 "D11",
        d12 "D12", c2 "C2", d2t "D2t", d21 "D21"; d22 "D22";
    Controller: a "A", by "By", bt "Bt", cu "Cu", duy "Duy", dut "Dut", ct "Ct", dty "Dty", dtt "Dtt";;
    Residual: e "E", f "F", fu "Fu", lambda "lambda", gamma "gamma", x "X", s "S", t "T"; fw "Fw";
    Limits: input "input", size "size", limits "limits", e "E", decay "decay", beta "beta", x_held "x_held",
        u_held "u_held", lambda "lambda", x "X", s "S", t "T", u "U", h "H"; delta_rows "delta_rows", rates "rates";
    Energy: limits "limits", e "E", claims "claims";;
    EnergyClaim: gamma "gamma", beta "beta", x "X", s "S", t "T", u "U", h "H";;
}

impl<'a> Fields<'a> {
    pub(crate) fn new(
        name: &str,
        json: &'a Json,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Self, ReadError> {
        let object = if name.is_empty() { "the certificate" } else { name }.to_string();
        let Json::Object(entries) = json else {
            return Err(ReadError::kind(&object, json.describe(), "an object"));
        };
        let prefix = if name.is_empty() { String::new() } else { format!("{name}.") };
        let fields = Self { prefix, entries };
        if let Some(key) = required.iter().find(|key| fields.find(key).is_none()) {
            return Err(ReadError::Missing { field: fields.path(key), object, keys: required.join(", ") });
        }
        let known: Vec<&str> = required.iter().chain(optional).copied().collect();
        if let Some((key, _)) = entries.iter().find(|(key, _)| !known.contains(&key.as_str())) {
            return Err(ReadError::Unknown { field: fields.path(key), object, keys: known.join(", ") });
        }
        Ok(fields)
    }

    fn path(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    fn find(&self, key: &str) -> Option<&'a Json> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, value)| value)
    }

    /// The value of a key; the default where an optional key is missing.
    pub(crate) fn read<T: Read + Default>(&self, key: &str) -> Result<T, ReadError> {
        self.find(key).map_or_else(|| Ok(T::default()), |json| T::read(&self.path(key), json))
    }
}

impl<T: Read> Read for Option<T> {
    fn read(path: &str, json: &Json) -> Result<Self, ReadError> {
        T::read(path, json).map(Some)
    }
}

/// Reads a list of the file, with what messages call it.
macro_rules! lists {
    ($($entry:ty: $allowed:literal),*) => {
        $(impl $crate::read::Read for Vec<$entry> {
            fn read(path: &str, json: &$crate::Json) -> Result<Self, $crate::ReadError> {
                $crate::read::list(path, json, $allowed)
            }
        })*
    };
}

pub(crate) use {lists, objects};

/// The entries of a list, which messages call `allowed`.
pub(crate) fn list<T: Read>(path: &str, json: &Json, allowed: &'static str) -> Result<Vec<T>, ReadError> {
    let Json::List(entries) = json else {
        return Err(ReadError::kind(path, json.describe(), allowed));
    };
    entries.iter().enumerate().map(|(i, json)| T::read(&format!("{path}[{i}]"), json)).collect()
}

lists!(f64: "a list of numbers", Vec<f64>: "a list of rows", Rows: "a list of matrices",
    usize: "a list of whole numbers", EnergyClaim: "a list of claims");

impl Read for bool {
    fn read(path: &str, json: &Json) -> Result<Self, ReadError> {
        match json {
            Json::Bool(truth) => Ok(*truth),
            other => Err(ReadError::kind(path, other.describe(), "true or false")),
        }
    }
}

impl Read for f64 {
    fn read(path: &str, json: &Json) -> Result<Self, ReadError> {
        match json {
            Json::Number(x) => Ok(*x),
            other => Err(ReadError::kind(path, other.describe(), "a finite number")),
        }
    }
}

/// A limit on repetitions, far above those of any file that could be stored.
const MOST_REPETITIONS: f64 = 1e6;

impl Read for usize {
    fn read(path: &str, json: &Json) -> Result<Self, ReadError> {
        match json {
            Json::Number(x) if (0.0..=MOST_REPETITIONS).contains(x) && x.fract() == 0.0 => Ok(*x as usize),
            other => Err(ReadError::kind(path, other.describe(), "a whole number from 0 to 1000000")),
        }
    }
}
