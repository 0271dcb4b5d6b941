//! From the JSON tree to the certificate, with the path of each error.

use crate::certificate::{
    BoundedRate, Certificate, Controller, Energy, EnergyClaim, FORMAT, FORMAT_DISCRETE, FORMAT_WITH_ENERGY,
    FORMAT_WITH_LIMITS, Limits, Plant, Residual, Rows, Slow, SlowResidual,
};
use crate::error::ReadError;
use crate::json::Json;

const TOP: [&str; 9] =
    ["format", "blocks", "controller_blocks", "plant", "controller", "gamma", "X", "S", "T"];
const SLOW: [&str; 5] = ["gamma", "inverse", "X", "breakpoints", "N"];
const LIMITS: [&str; 14] =
    ["input", "size", "limits", "E", "decay", "beta", "x_held", "u_held", "lambda", "X", "S", "T", "U", "H"];
const ENERGY: [&str; 3] = ["limits", "E", "claims"];
const ENERGY_CLAIM: [&str; 7] = ["gamma", "beta", "X", "S", "T", "U", "H"];
const RESIDUAL: [&str; 8] = ["E", "F", "Fu", "lambda", "gamma", "X", "S", "T"];

/// An object with every required key and no unknown key.
pub(crate) struct Fields<'a> {
    /// `plant.` for the keys of `plant`, empty at the top.
    prefix: String,
    entries: &'a [(String, Json)],
}

impl Certificate {
    /// Reads a certificate of format [`FORMAT`], [`FORMAT_WITH_LIMITS`], [`FORMAT_DISCRETE`] or [`FORMAT_WITH_ENERGY`].
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
    let format = check_format(json, &[FORMAT, FORMAT_WITH_LIMITS, FORMAT_DISCRETE, FORMAT_WITH_ENERGY])?;
    let (required, optional): (&[&str], &[&str]) = match format {
        FORMAT_WITH_LIMITS => (&["limits"], &[]),
        FORMAT_WITH_ENERGY => (&["energy"], &["limits"]),
        _ => (&[], &[]),
    };
    let required: Vec<&str> = TOP.iter().chain(required).copied().collect();
    let optional: Vec<&str> = ["residual", "bounded_rate"].iter().chain(optional).copied().collect();
    let top = Fields::new("", json, &required, &optional)?;
    Ok(Certificate {
        discrete: format == FORMAT_DISCRETE,
        blocks: top.sizes("blocks")?,
        controller_blocks: top.sizes("controller_blocks")?,
        plant: plant(top.get("plant")?)?,
        controller: controller(top.get("controller")?)?,
        gamma: top.number("gamma")?,
        x: top.matrix("X")?,
        s: top.matrix("S")?,
        t: top.matrix("T")?,
        residual: match top.find("residual") {
            Some(json) => Some(residual(&Fields::new("residual", json, &RESIDUAL, &["Fw"])?)?),
            None => None,
        },
        bounded_rate: top.find("bounded_rate").map(bounded_rate).transpose()?,
        limits: top.find("limits").map(limits).transpose()?,
        energy: top.find("energy").map(energy).transpose()?,
    })
}

/// The format is checked first, because another format has other keys.
pub(crate) fn check_format(json: &Json, allowed: &[&'static str]) -> Result<&'static str, ReadError> {
    let Json::Object(entries) = json else {
        return Err(ReadError::Kind {
            field: "the certificate".into(),
            found: json.describe(),
            allowed: "an object",
        });
    };
    let found = entries.iter().find(|(key, _)| key == "format").map(|(_, value)| value);
    let known = allowed.iter().find(|format| matches!(found, Some(Json::Text(text)) if text == **format));
    known.copied().ok_or_else(|| ReadError::Format {
        found: found.map_or_else(|| "nothing".into(), Json::describe),
        allowed: allowed.iter().map(|format| format!("{format:?}")).collect::<Vec<_>>().join(" or "),
    })
}

pub(crate) fn plant(json: &Json) -> Result<Plant, ReadError> {
    let mut plant = Plant::default();
    let fields = Fields::new("plant", json, &plant.named().map(|(key, _)| key), &["D22"])?;
    fields.fill(&mut plant.named_mut())?;
    if fields.find("D22").is_some() {
        plant.d22 = fields.matrix("D22")?;
    }
    Ok(plant)
}

pub(crate) fn controller(json: &Json) -> Result<Controller, ReadError> {
    let mut controller = Controller::default();
    let fields = Fields::new("controller", json, &controller.named().map(|(key, _)| key), &[])?;
    fields.fill(&mut controller.named_mut())?;
    Ok(controller)
}

fn residual(f: &Fields<'_>) -> Result<Residual, ReadError> {
    Ok(Residual {
        e: f.matrix("E")?,
        f: f.matrix("F")?,
        fw: f.find("Fw").map_or(Ok(vec![]), |_| f.matrix("Fw"))?,
        fu: f.matrix("Fu")?,
        lambda: f.number("lambda")?,
        gamma: f.number("gamma")?,
        x: f.matrix("X")?,
        s: f.matrix("S")?,
        t: f.matrix("T")?,
    })
}

fn bounded_rate(json: &Json) -> Result<BoundedRate, ReadError> {
    let fields = Fields::new("bounded_rate", json, &with_slow("rate"), &["residual"])?;
    let residual = |json: &Json| -> Result<SlowResidual, ReadError> {
        let fields = Fields::new("bounded_rate.residual", json, &with_slow("lambda"), &[])?;
        Ok(SlowResidual { lambda: fields.number("lambda")?, slow: slow(&fields)? })
    };
    Ok(BoundedRate {
        rate: fields.number("rate")?,
        slow: slow(&fields)?,
        residual: fields.find("residual").map(residual).transpose()?,
    })
}

fn limits(json: &Json) -> Result<Limits, ReadError> {
    let f = Fields::new("limits", json, &LIMITS, &["delta_rows", "rates"])?;
    Ok(Limits {
        input: size(&f.path("input"), f.get("input")?)?,
        size: f.number("size")?,
        limits: f.numbers("limits")?,
        rates: f.find("rates").map_or(Ok(vec![]), |_| f.sizes("rates"))?,
        e: f.matrix("E")?,
        decay: f.number("decay")?,
        beta: f.number("beta")?,
        x_held: f.numbers("x_held")?,
        u_held: f.numbers("u_held")?,
        delta_rows: f.find("delta_rows").map(|rows| size(&f.path("delta_rows"), rows)).transpose()?,
        lambda: f.number("lambda")?,
        x: f.matrix("X")?,
        s: f.matrix("S")?,
        t: f.matrix("T")?,
        u: f.numbers("U")?,
        h: f.matrix("H")?,
    })
}

fn energy(json: &Json) -> Result<Energy, ReadError> {
    let f = Fields::new("energy", json, &ENERGY, &[])?;
    let claim = |(k, json): (usize, &Json)| -> Result<EnergyClaim, ReadError> {
        let f = Fields::new(&format!("energy.claims[{k}]"), json, &ENERGY_CLAIM, &[])?;
        Ok(EnergyClaim {
            gamma: f.number("gamma")?,
            beta: f.number("beta")?,
            x: f.matrix("X")?,
            s: f.matrix("S")?,
            t: f.matrix("T")?,
            u: f.numbers("U")?,
            h: f.matrix("H")?,
        })
    };
    let claims = list("energy.claims", f.get("claims")?, "a list of claims")?;
    Ok(Energy {
        limits: f.numbers("limits")?,
        e: f.matrix("E")?,
        claims: claims.iter().enumerate().map(claim).collect::<Result<_, _>>()?,
    })
}

fn with_slow(key: &'static str) -> Vec<&'static str> {
    std::iter::once(key).chain(SLOW).collect()
}

fn slow(f: &Fields<'_>) -> Result<Slow, ReadError> {
    Ok(Slow {
        gamma: f.number("gamma")?,
        inverse: f.truth("inverse")?,
        x: f.matrices("X")?,
        breakpoints: f.numbers("breakpoints")?,
        n: f.matrices("N")?,
    })
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
            return Err(ReadError::Kind { field: object, found: json.describe(), allowed: "an object" });
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

    pub(crate) fn path(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    pub(crate) fn find(&self, key: &str) -> Option<&'a Json> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, value)| value)
    }

    pub(crate) fn get(&self, key: &str) -> Result<&'a Json, ReadError> {
        self.find(key).ok_or_else(|| ReadError::Missing {
            field: self.path(key),
            object: "the certificate".into(),
            keys: key.into(),
        })
    }

    pub(crate) fn number(&self, key: &str) -> Result<f64, ReadError> {
        number(&self.path(key), self.get(key)?)
    }

    fn truth(&self, key: &str) -> Result<bool, ReadError> {
        match self.get(key)? {
            Json::Bool(truth) => Ok(*truth),
            other => Err(ReadError::Kind {
                field: self.path(key),
                found: other.describe(),
                allowed: "true or false",
            }),
        }
    }

    fn numbers(&self, key: &str) -> Result<Vec<f64>, ReadError> {
        numbers(&self.path(key), self.get(key)?)
    }

    pub(crate) fn matrix(&self, key: &str) -> Result<Rows, ReadError> {
        matrix(&self.path(key), self.get(key)?)
    }

    fn matrices(&self, key: &str) -> Result<Vec<Rows>, ReadError> {
        let path = self.path(key);
        let all = list(&path, self.get(key)?, "a list of matrices")?;
        all.iter().enumerate().map(|(k, m)| matrix(&format!("{path}[{k}]"), m)).collect()
    }

    fn fill(&self, matrices: &mut [(&str, &mut Rows)]) -> Result<(), ReadError> {
        for (key, rows) in matrices {
            **rows = self.matrix(key)?;
        }
        Ok(())
    }

    pub(crate) fn sizes(&self, key: &str) -> Result<Vec<usize>, ReadError> {
        let path = self.path(key);
        let entries = list(&path, self.get(key)?, "a list of whole numbers")?;
        entries.iter().enumerate().map(|(i, n)| size(&format!("{path}[{i}]"), n)).collect()
    }
}

pub(crate) fn list<'a>(field: &str, json: &'a Json, allowed: &'static str) -> Result<&'a [Json], ReadError> {
    match json {
        Json::List(items) => Ok(items),
        other => Err(ReadError::Kind { field: field.into(), found: other.describe(), allowed }),
    }
}

fn matrix(path: &str, json: &Json) -> Result<Rows, ReadError> {
    let rows = list(path, json, "a list of rows")?;
    rows.iter().enumerate().map(|(i, row)| numbers(&format!("{path}[{i}]"), row)).collect()
}

fn numbers(path: &str, json: &Json) -> Result<Vec<f64>, ReadError> {
    let entries = list(path, json, "a list of numbers")?;
    entries.iter().enumerate().map(|(j, x)| number(&format!("{path}[{j}]"), x)).collect()
}

fn number(field: &str, json: &Json) -> Result<f64, ReadError> {
    match json {
        Json::Number(x) => Ok(*x),
        other => {
            Err(ReadError::Kind { field: field.into(), found: other.describe(), allowed: "a finite number" })
        }
    }
}

/// A limit on repetitions, far above those of any file that could be stored.
const MOST_REPETITIONS: f64 = 1e6;

pub(crate) fn size(field: &str, json: &Json) -> Result<usize, ReadError> {
    match json {
        Json::Number(x) if (0.0..=MOST_REPETITIONS).contains(x) && x.fract() == 0.0 => Ok(*x as usize),
        other => Err(ReadError::Kind {
            field: field.into(),
            found: other.describe(),
            allowed: "a whole number from 0 to 1000000",
        }),
    }
}
