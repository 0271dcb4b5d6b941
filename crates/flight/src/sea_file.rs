//! Reads a sea file (TOML); `vehicles/sea.toml` explains every key.

use crate::sea::{Sea, WaveParameters, perfect_sensors, sensed};
use squid_auv::Bottom;
use squid_auv::number;
use squid_auv::toml_file::{Document, FileError, Table};
use squid_sea::{Layers, SeaError, SensorErrors, Spectrum, Wandering, Waves};

const SPECTRA: [&str; 2] = ["jonswap", "pierson-moskowitz"];

/// Allowed depths, for messages.
const DEPTH: &str = "at least 0 (m)";

impl Sea {
    /// Reads and checks the text of a sea file; `file` is its name in messages.
    ///
    /// # Errors
    /// [`FileError`]: every mistake with file, line, key, value and the allowed values.
    pub fn parse(text: &str, file: &str) -> Result<Self, FileError> {
        let document = Document::parse(text, file)?;
        let read = sea(&document.root());
        document.finish(read)
    }
}

fn sea(root: &Table<'_>) -> Option<Sea> {
    root.allow_only(&["seed", "depth", "waves", "current", "gauss_markov", "sensor", "bottom"]);
    let seed = root.whole("seed", |_| true, "at least 0");
    let depth = root.has("depth").then(|| root.number("depth", |depth| depth >= 0.0, DEPTH));
    let waves = root.table("waves").map(|table| WaveParameters::of(&table, &["components"]));
    let current = current(root.table("current").as_ref());
    let gauss_markov = root.table("gauss_markov").map(|table| gauss_markov(&table));
    let sensors = sensors(&root.tables("sensor"));
    let bottom = root.table("bottom").map_or_else(|| Some(Bottom::default()), |table| bottom(&table));
    let (layers, vertical) = current?;
    Some(Sea {
        seed: seed? as u64,
        depth: absent_or_valid(depth)?,
        waves: absent_or_valid(waves)?,
        layers,
        vertical,
        gauss_markov: absent_or_valid(gauss_markov)?,
        sensors: sensors?,
        bottom: bottom?,
    })
}

/// Reads the bottom: its depth at the start, and its slopes.
fn bottom(table: &Table<'_>) -> Option<Bottom> {
    table.allow_only(&["depth", "slope_north", "slope_east"]);
    let depth = required(table, "depth", "the depth of the bottom at the initial position (m)");
    let slope = |key: &str| table.or(key, 0.0, |table, key| table.number(key, |v| v.abs() <= 1.0, SLOPES));
    let (north, east) = (slope("slope_north"), slope("slope_east"));
    Some(Bottom { depth: depth?, north: north?, east: east? })
}

const SLOPES: &str = "a number from -1 to 1, the increase of bottom depth per metre";

/// Returns an optional value, absent or valid; `None` if it is present but invalid.
fn absent_or_valid<T>(found: Option<Option<T>>) -> Option<Option<T>> {
    match found {
        None => Some(None),
        Some(read) => read.map(Some),
    }
}

/// Reads a velocity of the water; 0 by default.
fn velocity(table: &Table<'_>, key: &str) -> Option<f64> {
    table.or(key, 0.0, |table, key| table.number(key, is_current, CURRENTS))
}

fn required(table: &Table<'_>, key: &str, meaning: &str) -> Option<f64> {
    table.requires(key, meaning).then(|| table.float(key, &format!("a number: {meaning}"))).flatten()
}

/// Reports an invalid value of a sea at its key.
fn report_at_key<T>(table: &Table<'_>, result: Result<T, SeaError>) -> Option<T> {
    match result {
        Ok(result) => return Some(result),
        Err(SeaError::NotAllowed { key, found, allowed }) => table.not_allowed(key, number(found), allowed),
        Err(SeaError::TooSteep { height, period, limit, least_period, .. }) => table.not_allowed(
            "period",
            format!("{} s", number(period)),
            format!(
                "at least {least_period:.2} s for a height of {} m (waves break beyond a steepness of {limit:.3})",
                number(height)
            ),
        ),
    }
    None
}

impl WaveParameters {
    /// Reads the wave keys from a table that may also contain the keys `others`; `None` after a mistake.
    pub fn of(table: &Table<'_>, others: &[&str]) -> Option<Self> {
        let own = ["spectrum", "height", "period", "gamma", "heading"];
        table.allow_only(&[&own, others].concat());
        let peaked = table.one_of("spectrum", &SPECTRA).map(|index| index == 0);
        let height = required(table, "height", "significant height Hs (m)");
        let period = required(table, "period", "peak period Tp (s)");
        let heading = required(table, "heading", "direction of the waves (deg; 180 for a head sea)");
        let gamma = match peaked {
            Some(true) => required(table, "gamma", "peak enhancement factor, 3.3 on average"),
            _ => Some(1.0),
        };
        if peaked == Some(false) && table.has("gamma") {
            table.not_allowed(
                "gamma",
                "given",
                "omitted, because the Pierson-Moskowitz spectrum has no peak enhancement",
            );
        }
        let components = table.or("components", Waves::USUAL, |table, key| {
            table.whole(key, |_| true, "the number of wave components")
        });
        let (height, period, gamma) = (height?, period?, gamma?);
        let (heading, components) = (heading?, components?);
        let spectrum = report_at_key(table, Spectrum::jonswap(height, period, gamma))?;
        let heading = heading.to_radians();
        report_at_key(table, Waves::new(&spectrum, heading, components, 0))?;
        Some(Self { spectrum, heading, components })
    }
}

/// Reads the current over depth and the vertical current; zero without the table.
fn current(table: Option<&Table<'_>>) -> Option<(Layers, f64)> {
    let Some(table) = table else { return Some((Layers::new(&[[0.0, 0.0]]).ok()?, 0.0)) };
    table.allow_only(&["horizontal", "layers", "vertical"]);
    let vertical = velocity(table, "vertical");
    let layers = if table.has("layers") {
        if table.has("horizontal") {
            table.not_allowed("horizontal", "given", "omitted if 'layers' are given");
        }
        table.pairs("layers", Layers::ALLOWED)
    } else {
        velocity(table, "horizontal").map(|velocity| vec![[0.0, velocity]])
    };
    let (layers, vertical) = (layers?, vertical?);
    if let Some([_, velocity]) = layers.iter().find(|[_, velocity]| !is_current(*velocity)) {
        table.not_allowed(
            "layers",
            format!("{velocity} m/s at a depth"),
            format!("{CURRENTS} at each depth"),
        );
        return None;
    }
    if let Some(found) = misplaced_depth(&layers) {
        table.not_allowed("layers", found, Layers::ALLOWED);
        return None;
    }
    Some((report_at_key(table, Layers::new(&layers))?, vertical))
}

/// Describes the first depth of the layers that is negative or does not increase.
fn misplaced_depth(layers: &[[f64; 2]]) -> Option<String> {
    let negative = layers.first().filter(|[depth, _]| *depth < 0.0);
    let negative = negative.map(|[depth, _]| format!("a depth of {} m", number(*depth)));
    negative.or_else(|| {
        let pair = layers.windows(2).find(|pair| pair[1][0] <= pair[0][0])?;
        Some(format!("a depth of {} m after {} m", number(pair[1][0]), number(pair[0][0])))
    })
}

/// Returns `true` if a velocity of the water is plausible: the fastest tidal streams stay below 11 m/s.
fn is_current(velocity: f64) -> bool {
    velocity.abs() <= 12.0
}

const CURRENTS: &str = "a number from -12 to 12 (m/s)";

fn gauss_markov(table: &Table<'_>) -> Option<Wandering> {
    table.allow_only(&["mu", "noise", "min", "max"]);
    let mu = required(table, "mu", "inverse of the correlation time (1/s)");
    let noise = required(table, "noise", "density of the driving noise (m/s per sqrt(s))");
    let min = required(table, "min", "lower bound of the random part of the current (m/s)");
    let max = required(table, "max", "upper bound of the random part of the current (m/s)");
    let parameters = Wandering { mu: mu?, noise: noise?, min: min?, max: max? };
    report_at_key(table, parameters.check())?;
    Some(parameters)
}

/// Reads the errors of each sensor; zero without a table.
fn sensors(tables: &[Table<'_>]) -> Option<Vec<SensorErrors>> {
    let (mut all, mut valid, mut seen) = (perfect_sensors(), true, Vec::new());
    for table in tables {
        table.allow_only(&["signal", "unit", "noise", "bias", "quantum", "rate", "delay"]);
        match sensor(table) {
            Some((index, _)) if seen.contains(&index) => {
                table.not_allowed(
                    "signal",
                    "already listed",
                    "a signal without a sensor so far, because each signal \
                    has one sensor",
                );
            }
            Some((index, errors)) => {
                seen.push(index);
                all[index] = errors;
            }
            None => valid = false,
        }
    }
    valid.then_some(all)
}

/// Limit of sensor errors, in SI for any signal; larger ones are treated as a mistake.
const LARGEST_ERROR: f64 = 10.0;

/// Lowest sampling rate of a sensor \[Hz\].
const SLOWEST: f64 = 1e-3;

/// Reads the index of a signal, and the errors of its sensor in SI.
fn sensor(table: &Table<'_>) -> Option<(usize, SensorErrors)> {
    let signals: Vec<_> = sensed().collect();
    let names: Vec<&str> = signals.iter().map(|signal| signal.name).collect();
    let index = table.one_of("signal", &names);
    let number = |key: &str, default: f64| table.or(key, default, |table, key| table.float(key, "a number"));
    let [noise, bias, quantum, delay] = ["noise", "bias", "quantum", "delay"].map(|key| number(key, 0.0));
    let rate = number("rate", f64::INFINITY);
    let signal = signals[index?];
    let names: Vec<&str> = signal.units.iter().map(|unit| unit.name).collect();
    let unit = signal.units[table.one_of("unit", &names)?];
    let factor = unit.factor;
    let errors = SensorErrors { noise: noise?, bias: bias?, quantum: quantum?, rate: rate?, delay: delay? };
    report_at_key(table, errors.check())?;
    let SensorErrors { noise, bias, quantum, .. } = errors;
    for (key, found) in [("noise", noise), ("bias", bias), ("quantum", quantum)] {
        if found.abs() * factor > LARGEST_ERROR {
            let most = LARGEST_ERROR / factor;
            table.not_allowed(
                key,
                found.to_string(),
                format!("at most {} {}", squid_auv::number(most), unit.name),
            );
            return None;
        }
    }
    if errors.rate < SLOWEST {
        table.not_allowed("rate", errors.rate.to_string(), format!("a number of at least {SLOWEST} (Hz)"));
        return None;
    }
    let si = SensorErrors { noise: noise * factor, bias: bias * factor, quantum: quantum * factor, ..errors };
    Some((index?, si))
}
