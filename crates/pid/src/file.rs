//! Reads the table `[controller]`.

use crate::angle::Angle;
use crate::gain::{Given, HIGHEST, Law};
use squid_auv::toml_file::{Document, FileError, Table};
use squid_lpv::weights::ReferenceModel;

/// A PID cascade as given in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Pid {
    /// File name for messages.
    pub file: String,
    /// Line of the table.
    pub line: usize,
    /// Loop of pitch, heading or roll.
    pub turn: TurnLoop,
    /// Depth loop around pitch.
    pub depth: Option<DepthLoop>,
    /// Speed loop.
    pub speed: Option<SpeedLoop>,
    /// Shares of the actuators in the command of the angle, if given.
    pub turn_shares: Option<Shares>,
    /// Shares of the actuators in the speed command, if given.
    pub speed_shares: Option<Shares>,
    /// Tracking time of back-calculation (anti-windup), s; `kp/ki` of each loop if not given.
    pub tracking_time: Option<f64>,
}

impl Pid {
    /// Returns the gains of the command of the angle, of that of speed, and of the depth.
    pub fn gains_mut(&mut self) -> [Vec<&mut Given>; 3] {
        let Self { turn, speed, depth, .. } = self;
        let TurnLoop { kp, ki, kd, feedforward, .. } = turn;
        let turn = [Some(kp), ki.as_mut(), kd.as_mut(), feedforward.as_mut()].into_iter().flatten();
        let speed = speed.iter_mut().flat_map(|one| std::iter::once(&mut one.kp).chain(&mut one.ki));
        let depth = depth.iter_mut().flat_map(|one| std::iter::once(&mut one.kp).chain(&mut one.ki));
        [turn.collect(), speed.collect(), depth.collect()]
    }
}

/// PID loop of an angle.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnLoop {
    /// Controlled angle; it names the signal and the table, and its rate is `ANGLE_rate`.
    pub angle: Angle,
    /// Line of the table.
    pub line: usize,
    /// Gain on the error.
    pub kp: Given,
    /// Gain on the integral of the error.
    pub ki: Option<Given>,
    /// Gain on the measured rate.
    pub kd: Option<Given>,
    /// Setpoint weight b of the reference in the proportional term.
    pub reference_weight: f64,
    /// Reference model whose output the angle follows in place of the reference.
    pub model: Option<ReferenceModel>,
    /// Feedforward gain on the acceleration of the reference model.
    pub feedforward: Option<Given>,
    /// Time constant of the filter of the rate, s; 0 for none.
    pub rolloff: f64,
}

/// P or PI loop of depth, whose output is the pitch reference.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthLoop {
    /// Line of the table.
    pub line: usize,
    /// Gain on the error.
    pub kp: Given,
    /// Gain on the integral of the error.
    pub ki: Option<Given>,
}

/// P or PI loop of speed.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedLoop {
    /// Line of the table.
    pub line: usize,
    /// Gain on the error.
    pub kp: Given,
    /// Gain on the integral of the error.
    pub ki: Option<Given>,
    /// Setpoint weight b in the proportional term, on the speed reference minus its filtered value.
    pub reference_weight: f64,
    /// Time constant of the filter of measured speed in the proportional term, s; 0 for none.
    pub rolloff: f64,
}

/// Shares of the actuators in a command; only their ratios and signs matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Shares {
    /// Line of the table.
    pub line: usize,
    /// Name and share of each actuator.
    pub each: Vec<(String, f64)>,
}

/// Upper limit of time constants and times, s.
const LONGEST: f64 = 1e3;

/// Allowed values of `integrator`: the gain acts after or before the integrator.
const FORMS: [&str; 2] = ["scheduled output", "scheduled input"];

/// Reads a file that contains only `[controller]`.
///
/// # Errors
/// [`FileError`] with file, line, key, value and allowed values of every mistake.
pub fn read_file(text: &str, file: &str) -> Result<Pid, FileError> {
    let document = Document::parse(text, file)?;
    let root = document.root();
    root.allow_only(&["controller"]);
    let table = root.required_table("controller", "the control law and its gains");
    let found = table.and_then(|table| {
        let found = read(&table, file)?;
        if found.is_none() {
            table.not_allowed("kind", "\"full\"", "\"pid\", because this command proves given gains");
        }
        found
    });
    document.finish(found)
}

/// Reads the table; `Some(None)` for `kind = "full"`, the synthesised controller.
///
/// The other keys depend on the kind, so that only the kind is reported if it is wrong.
pub fn read(table: &Table<'_>, file: &str) -> Option<Option<Pid>> {
    let kind = table.one_of("kind", &["full", "pid"]);
    if kind.is_none() && table.has("kind") {
        return None;
    }
    if kind == Some(0) {
        if let Some((_, gains)) = table.keys().into_iter().find(|(_, key)| is_of_pid(key)) {
            let allowed =
                format!("\"pid\" beside '{gains}': the controller of kind \"full\" is computed, not given");
            table.not_allowed("kind", "\"full\"", allowed);
            return None;
        }
        table.allow_only(&["kind"]);
        return Some(None);
    }
    let angle = Angle::ALL.into_iter().find(|angle| table.has(angle.name())).unwrap_or(Angle::Pitch);
    let steered = if angle == Angle::Pitch { vec!["depth", "speed"] } else { vec![] };
    table.allow_only(&[&["kind"], &KEYS[..], &[angle.name()], &steered].concat());
    let form = table.or("integrator", 0, |table, key| table.one_of(key, &FORMS));
    if form == Some(1) {
        table.not_allowed(
            "integrator",
            "\"scheduled input\"",
            "\"scheduled output\" (the default) with the same gains, ki(V) times the integral of the error: with a \
             gain before the integrator, a speed that varies in phase with the error leaves a mean error, which \
             increases the proved gain a hundredfold",
        );
    }
    let turn = table
        .required_table(angle.name(), "kp, ki and kd of the angle, each { value = ..., unit = \"...\" }")
        .and_then(|table| turn(&table, angle));
    let depth = optional(table, "depth", depth);
    let speed = optional(table, "speed", speed);
    let shares = table.table("allocation");
    if let Some(shares) = &shares {
        let own = [angle.name(), "speed"];
        shares.allow_only(if steered.is_empty() { &own[..1] } else { &own });
    }
    let of = |key: &str| match &shares {
        Some(table) => optional(table, key, self::shares),
        None => Some(None),
    };
    let (turn_shares, speed_shares) = (of(angle.name()), of("speed"));
    let tracking_time = table.or("tracking_time", None, |table, key| {
        table.number(key, |v| v > 0.0 && v <= LONGEST, "above 0, at most 1000 (s)").map(Some)
    });
    kind?;
    Some(Some(Pid {
        file: file.to_owned(),
        line: table.line(),
        turn: turn?,
        depth: depth?,
        speed: speed?,
        turn_shares: turn_shares?,
        speed_shares: speed_shares?,
        tracking_time: tracking_time?,
    }))
}

/// Keys of every PID except its loops.
const KEYS: [&str; 3] = ["allocation", "integrator", "tracking_time"];

/// Returns `true` for a key that a controller of kind "pid" can have.
fn is_of_pid(key: &str) -> bool {
    KEYS.contains(&key)
        || ["depth", "speed"].contains(&key)
        || Angle::ALL.iter().any(|angle| angle.name() == key)
}

fn optional<T>(
    table: &Table<'_>,
    key: &str,
    read: impl FnOnce(&Table<'_>) -> Option<T>,
) -> Option<Option<T>> {
    table.or(key, None, |table, key| read(&table.table(key)?).map(Some))
}

fn turn(table: &Table<'_>, angle: Angle) -> Option<TurnLoop> {
    let mut keys = vec!["kp", "ki", "kd", "rolloff", "model", "reference_weight"];
    let model = optional(table, "model", model);
    let follows = table.has("model");
    keys.extend(follows.then_some("feedforward"));
    table.allow_only(&keys);
    if follows && table.has("reference_weight") {
        table.not_allowed(
            "reference_weight",
            "given",
            "omitted if 'model' is given, because the model shapes the \
            reference",
        );
    }
    let (kp, ki, kd) = (gain(table, "kp"), optional_gain(table, "ki"), optional_gain(table, "kd"));
    let feedforward = if follows { optional_gain(table, "feedforward") } else { Some(None) };
    let (weight, rolloff) = (reference_weight(table, 1.0), rolloff(table));
    Some(TurnLoop {
        angle,
        line: table.line(),
        kp: kp?,
        ki: ki?,
        kd: kd?,
        reference_weight: weight?,
        model: model?,
        feedforward: feedforward?,
        rolloff: rolloff?,
    })
}

fn model(table: &Table<'_>) -> Option<ReferenceModel> {
    table.allow_only(&["frequency", "damping"]);
    let frequency = table.number("frequency", |v| (1e-4..=1e4).contains(&v), "from 1e-4 to 1e4 (rad/s)");
    let damping = table.number("damping", |v| (0.3..=3.0).contains(&v), "from 0.3 to 3");
    Some(ReferenceModel { frequency: frequency?, damping: Some(damping?) })
}

fn depth(table: &Table<'_>) -> Option<DepthLoop> {
    table.allow_only(&["kp", "ki"]);
    let (kp, ki) = (gain(table, "kp"), optional_gain(table, "ki"));
    let constant = |gain: &Option<Given>, key: &str| {
        let scheduled = gain.as_ref().is_some_and(|gain| match &gain.law {
            Law::Polynomial(all) => all.len() > 1,
            Law::Table { .. } => true,
        });
        if scheduled {
            let allowed = "one number, because it multiplies the pitch gains, which may depend on speed";
            table.not_allowed(key, "a function of speed", allowed);
        }
    };
    constant(&kp, "kp");
    constant(ki.as_ref().unwrap_or(&None), "ki");
    Some(DepthLoop { line: table.line(), kp: kp?, ki: ki? })
}

fn speed(table: &Table<'_>) -> Option<SpeedLoop> {
    table.allow_only(&["kp", "ki", "reference_weight", "rolloff"]);
    let (kp, ki) = (gain(table, "kp"), optional_gain(table, "ki"));
    let (weight, rolloff) = (reference_weight(table, 0.0), rolloff(table));
    Some(SpeedLoop { line: table.line(), kp: kp?, ki: ki?, reference_weight: weight?, rolloff: rolloff? })
}

fn reference_weight(table: &Table<'_>, default: f64) -> Option<f64> {
    table.or("reference_weight", default, |table, key| {
        table.number(key, |v| (0.0..=10.0).contains(&v), "from 0 to 10 (1: the error itself)")
    })
}

fn rolloff(table: &Table<'_>) -> Option<f64> {
    table.or("rolloff", 0.0, |table, key| {
        table.number(key, |v| v > 0.0 && v <= LONGEST, "above 0, at most 1000 (s), or omitted")
    })
}

fn shares(table: &Table<'_>) -> Option<Shares> {
    let keys = table.keys();
    let share = |(_, name): &(usize, &str)| {
        let share = table.number(name, |v| v != 0.0, "a number other than 0, the share of the actuator")?;
        Some(((*name).to_owned(), share))
    };
    let each: Vec<Option<(String, f64)>> = keys.iter().map(share).collect();
    Some(Shares { line: table.line(), each: each.into_iter().collect::<Option<_>>()? })
}

fn optional_gain(table: &Table<'_>, key: &str) -> Option<Option<Given>> {
    table.or(key, None, |table, key| gain(table, key).map(Some))
}

fn gain(table: &Table<'_>, key: &str) -> Option<Given> {
    let what = "{ value = ..., unit = \"...\" }, or { table = [[speed, gain], ...], unit = \"...\" }";
    let gain = table.required_table(key, what)?;
    gain.allow_only(&["value", "table", "degree", "unit"]);
    let law = match (gain.has("value"), gain.has("table")) {
        (true, true) => {
            gain.not_allowed("table", "given", "omitted if 'value' is given");
            None
        }
        (false, true) => over_speed(&gain),
        _ => polynomial(&gain),
    };
    let unit = gain.text("unit");
    Some(Given { key: gain.name().to_owned(), line: gain.line(), unit: unit?, law: law? })
}

fn polynomial(gain: &Table<'_>) -> Option<Law> {
    if gain.has("degree") {
        gain.not_allowed(
            "degree",
            "given",
            "omitted if 'value' is given, whose length determines the degree",
        );
    }
    let allowed = "a number, or up to three coefficients of 1, rho and rho^2, where rho is -1 at the lowest and 1 at \
                 the highest speed";
    let all = gain.numbers("value", allowed)?;
    if all.len() > HIGHEST + 1 || all.is_empty() {
        gain.not_allowed("value", format!("a list of length {}", all.len()), allowed);
        return None;
    }
    Some(Law::Polynomial(all))
}

fn over_speed(gain: &Table<'_>) -> Option<Law> {
    let points = gain.pairs("table", "a list of pairs [speed in m/s, gain], with increasing speeds")?;
    if points.windows(2).any(|two| two[1][0] <= two[0][0]) {
        gain.not_allowed("table", "not in order", "pairs [speed in m/s, gain] with increasing speeds");
        return None;
    }
    let most = HIGHEST.min(points.len() - 1);
    let degree = gain.or("degree", most, |gain, key| gain.whole(key, |v| v <= HIGHEST, "from 0 to 2"))?;
    if degree >= points.len() {
        let allowed = format!("at least {} points for a polynomial of degree {degree}", degree + 1);
        gain.not_allowed("table", format!("{} points", points.len()), allowed);
        return None;
    }
    Some(Law::Table { points, degree })
}
