//! Reads the tables of a design file.

use crate::inputs::design_file::{
    BANDWIDTH, CONTROL_WEIGHT, DAMPING, DesignFile, FOLLOW, FREQUENCY, Measured, NOISE, PEAK, RATE, RISE,
    Range, Require, SAMPLE_TIME, SCALE, Tracked,
};
use auv::toml_file::{Document, FileError, Table};
use auv::{Pitch, number, rounded};
use lpv::tracking::{ReferenceModel, ReferenceWeight, RisingWeight, TrackingWeight};
use scheduled::{MANOEUVRE_FORMAT, MOST_DELAY_TICKS, Manoeuvre};
use signals::{PITCH, SIGNALS, SPEED, STATES};
use std::f64::consts::FRAC_PI_2;

/// How long after the end of the flight the step of the default manoeuvre lasts, s.
const NEVER: f64 = 1e6;

/// Ticks of a flight: its record is kept in memory, some 200 bytes each.
const MOST_TICKS: f64 = 1e6;

/// A part of a step, a speed or a tick by which it may exceed what is allowed, for the rounding of units.
const ROUNDING: f64 = 1e-9;

/// The words for a pitch of zero, and for that of least effort.
const LEVEL: &str = "level";
const FREE: &str = "free";

/// The largest pitch that can be held in level trim, deg: steeper flight is not level flight with an incidence.
const STEEPEST: f64 = 60.0;

const SECTIONS: [&str; 11] = [
    "description",
    "model",
    "trim",
    "track",
    "measure",
    "control",
    "synthesis",
    "autopilot",
    "manoeuvre",
    "uncertainty",
    "require",
];

impl DesignFile {
    /// Checks the text of a design file; `file` is for messages.
    ///
    /// # Errors
    /// [`FileError`]: every mistake with file, line, key, its value and what is allowed.
    pub fn parse(text: &str, file: &str, name: &str) -> Result<Self, FileError> {
        let document = Document::parse(text, file)?;
        document.finish(design(&document, name))
    }
}

/// The whole file; `None` if a mistake was taken down that leaves no value.
fn design(document: &Document<'_>, name: &str) -> Option<DesignFile> {
    let root = document.root();
    root.allow_only(&SECTIONS);
    let description = root.text("description");
    let model = root.required_table("model", "range of speed, depth, and the fit").map(|t| Model::of(&t));
    let pitch = root.table("trim").map_or(Some(None), |table| pitch(&table).map(Some));
    let measured = measured(&root);
    let tracked = tracked(&root, measured.as_ref().is_none_or(|all| !all.is_empty()));
    let control = section(&root, "control", "the weight on each actuator, and a disturbance there");
    let control = control.as_ref().map(Control::of);
    let synthesis = section(&root, "synthesis", "back_off, how far from the least gamma");
    let back_off = synthesis.as_ref().and_then(|table| {
        table.allow_only(&["back_off", "rate"]);
        table.number("back_off", |v| (0.001..=1.0).contains(&v), "from 0.001 to 1")
    });
    let bounded = synthesis.filter(|table| table.has("rate"));
    let rate =
        bounded.map_or(Some(None), |table| table.number("rate", |v| RATE.allows(v), RATE.words).map(Some));
    let autopilot = section(&root, "autopilot", "sample_time, one tick each (s)");
    let autopilot = autopilot.as_ref().map(Autopilot::of);
    let sample_time = autopilot.as_ref().and_then(|autopilot| autopilot.sample_time);
    let limits = Limits {
        speeds: model.as_ref().and_then(|m| m.speed_min.zip(m.speed_max)),
        pitch: tracked.iter().flatten().find(|t| t.place == PITCH).map(|t| t.scale),
        duration: sample_time.map(|time| MOST_TICKS * time),
    };
    let manoeuvre = section(&root, "manoeuvre", "what the FMU of the whole loop flies");
    let manoeuvre = manoeuvre.and_then(|table| limits.manoeuvre(&table));
    let uncertainty = root
        .table("uncertainty")
        .map(|table| crate::inputs::design_file::uncertainty::read(document, &table));
    let require = root.table("require").map_or_else(|| Some(Require::default()), |table| Require::of(&table));
    let (model, control) = (model?, control?);
    Some(DesignFile {
        name: name.into(),
        description: description?,
        speed_min: model.speed_min?,
        speed_max: model.speed_max?,
        speeds: model.speeds?,
        depth: model.depth?,
        pitch: pitch.clone()?.unwrap_or_default(),
        pitch_asked: pitch?,
        states: &STATES,
        order: model.order?,
        drop: model.drop?,
        tracked: tracked?,
        measured: measured?,
        control_weight: control.weight?,
        disturbance: control.disturbance?,
        lags: control.lags?,
        back_off: back_off?,
        judged: false,
        rate: rate?,
        sample_time: sample_time?,
        delay: autopilot.as_ref()?.delay?,
        anti_windup: autopilot?.anti_windup?,
        manoeuvre: manoeuvre?,
        uncertainty,
        require: require?,
    })
}

fn section<'d>(root: &Table<'d>, key: &str, meaning: &str) -> Option<Table<'d>> {
    root.required_table(key, meaning)
}

fn within(table: &Table<'_>, key: &str, range: Range) -> Option<f64> {
    table.number(key, |v| range.allows(v), range.words)
}

/// The section `[trim]`: "level", "free", or an angle.
fn pitch(table: &Table<'_>) -> Option<Pitch> {
    table.allow_only(&["pitch"]);
    if !table.holds_table("pitch") {
        let words = [LEVEL, FREE];
        return table.one_of("pitch", &words).map(|place| [Pitch::Held(0.0), Pitch::Free][place].clone());
    }
    let held = table.table("pitch")?;
    held.allow_only(&["angle", "unit"]);
    let factor = angle(&held);
    let allowed = |v: f64| factor.is_none_or(|factor| (v * factor).abs() <= STEEPEST.to_radians());
    let angle = held.number("angle", allowed, "at most 60 deg in size");
    Some(Pitch::Held(factor? * angle?))
}

/// The section `[control]`.
struct Control {
    weight: Option<RisingWeight>,
    disturbance: Option<f64>,
    lags: Option<bool>,
}

impl Control {
    fn of(table: &Table<'_>) -> Self {
        table.allow_only(&["weight", "rise", "corner", "disturbance", "lags"]);
        Self {
            weight: rising(table, "weight", CONTROL_WEIGHT, 1.0),
            disturbance: table.number("disturbance", |v| (0.0..=1e6).contains(&v), "from 0 to 1e6"),
            lags: if table.has("lags") { table.truth("lags") } else { Some(false) },
        }
    }
}

/// The section `[autopilot]`.
struct Autopilot {
    sample_time: Option<f64>,
    delay: Option<f64>,
    anti_windup: Option<bool>,
}

impl Autopilot {
    fn of(table: &Table<'_>) -> Self {
        table.allow_only(&["sample_time", "delay", "anti_windup"]);
        let sample_time = within(table, "sample_time", SAMPLE_TIME);
        let in_ticks = |ticks: f64| {
            (0.0..=MOST_DELAY_TICKS as f64 + 0.5).contains(&ticks) && (ticks - ticks.round()).abs() < ROUNDING
        };
        let in_ticks = |delay: f64| sample_time.is_none_or(|time| in_ticks(delay / time));
        let delay = match table.has("delay") {
            true => {
                table.number("delay", in_ticks, "a multiple of the sample time, from 0 to 10 of them (s)")
            }
            false => Some(0.0),
        };
        let anti_windup = if table.has("anti_windup") { table.truth("anti_windup") } else { Some(true) };
        Self { sample_time, delay, anti_windup }
    }
}

/// A weight `key` at low frequencies that rises by the factor `rise` beyond `corner`: both or neither is given.
fn rising(table: &Table<'_>, key: &str, range: Range, unit: f64) -> Option<RisingWeight> {
    let low = within(table, key, range).map(|low| low * unit);
    if !table.has("rise") && !table.has("corner") {
        return low.map(RisingWeight::constant);
    }
    let (rise, corner) = (within(table, "rise", RISE), within(table, "corner", FREQUENCY));
    let (low, corner) = (low?, corner?);
    Some(RisingWeight { low, high: low * rise?, corner })
}

/// What is measured; none where there is no such table.
fn measured(root: &Table<'_>) -> Option<Vec<Measured>> {
    let mut taken: Vec<usize> = Vec::new();
    let each: Vec<Option<Measured>> =
        root.tables("measure").iter().map(|table| measure(table, &mut taken)).collect();
    each.into_iter().collect()
}

fn measure(table: &Table<'_>, taken: &mut Vec<usize>) -> Option<Measured> {
    table.allow_only(&["signal", "scale", "unit", "noise", "rise", "corner"]);
    let (place, unit) = signal(table, "signal", SIGNALS.len(), taken)?;
    let scale = within(table, "scale", SCALE);
    let noise = scale.and_then(|scale| rising(table, "noise", NOISE, 1.0 / scale));
    Some(Measured { place, scale: unit * scale?, noise: noise? })
}

/// The place of a signal among the first `count`, and the SI value of its unit; each may be named once.
fn signal(table: &Table<'_>, key: &str, count: usize, taken: &mut Vec<usize>) -> Option<(usize, f64)> {
    let names: Vec<&str> = SIGNALS[..count].iter().map(|signal| signal.name).collect();
    let place = table.one_of(key, &names);
    if let Some(place) = place.filter(|place| taken.contains(place)) {
        table.not_allowed(key, format!("\"{}\" a second time", SIGNALS[place].name), "named once");
        return None;
    }
    taken.extend(place);
    let units = SIGNALS[place?].units;
    let names: Vec<&str> = units.iter().map(|unit| unit.name).collect();
    Some((place?, table.one_of("unit", &names).map(|unit| units[unit].factor)?))
}

/// A factor from the unit that is named to SI.
fn angle(table: &Table<'_>) -> Option<f64> {
    table.one_of("unit", &["deg", "rad"]).map(|place| [1f64.to_radians(), 1.0][place])
}

/// The section `[model]`.
struct Model {
    speed_min: Option<f64>,
    speed_max: Option<f64>,
    speeds: Option<usize>,
    depth: Option<f64>,
    order: Option<usize>,
    drop: Option<f64>,
}

impl Model {
    fn of(table: &Table<'_>) -> Self {
        table.allow_only(&["speed_min", "speed_max", "speeds", "depth", "order", "drop"]);
        let order = table.whole("order", |v| (1..=5).contains(&v), "from 1 to 5");
        let speed_min = table.number("speed_min", |_| true, "a finite number, negative astern (m/s)");
        let above = speed_min.unwrap_or(f64::NEG_INFINITY);
        let enough = |v| v > order.unwrap_or(1) && v <= 1000;
        Self {
            speed_min,
            speed_max: table.number("speed_max", |v| v > above, "above speed_min (m/s)"),
            speeds: table.whole("speeds", enough, "more than the order and at most 1000"),
            depth: table.number("depth", |v| v >= 0.0, "0 or more (m)"),
            order,
            drop: table.number("drop", |v| (0.0..0.5).contains(&v), "from 0 to below 0.5"),
        }
    }
}

/// The tracked outputs; with references apart from measurements they may have a model to follow.
fn tracked(root: &Table<'_>, apart: bool) -> Option<Vec<Tracked>> {
    if !root.requires("track", "what is tracked, each output in a table [[track]]") {
        return None;
    }
    let tables = root.tables("track");
    let mut taken: Vec<usize> = Vec::new();
    let each: Vec<Option<Tracked>> = tables.iter().map(|table| track(table, apart, &mut taken)).collect();
    each.into_iter().collect()
}

fn track(table: &Table<'_>, apart: bool, taken: &mut Vec<usize>) -> Option<Tracked> {
    let mut keys = vec!["output", "scale", "unit", "follow", "corner", "peak", "steady_error", "bandwidth"];
    keys.extend(apart.then_some(["frequency", "damping"]).into_iter().flatten());
    table.allow_only(&keys);
    let (place, unit) = signal(table, "output", signals::TRACKED, taken)?;
    let scale = within(table, "scale", SCALE);
    let peak = within(table, "peak", PEAK);
    let steady_error = table.number("steady_error", |v| v > 0.0 && v < 1.0, "above 0 and below 1");
    let bandwidth = within(table, "bandwidth", BANDWIDTH);
    let references = references(table);
    let model = if apart { reference_model(table, place) } else { Some(None) };
    Some(Tracked {
        place,
        scale: unit * scale?,
        references: references?,
        weight: TrackingWeight { peak: peak?, steady_error: steady_error?, bandwidth: bandwidth? },
        model: model?,
    })
}

/// How much more slow references count; the same at all frequencies where it is not given.
fn references(table: &Table<'_>) -> Option<ReferenceWeight> {
    if !table.has("follow") && !table.has("corner") {
        return Some(ReferenceWeight { follow: 1.0, corner: 1.0 });
    }
    let (follow, corner) = (within(table, "follow", FOLLOW), within(table, "corner", FREQUENCY));
    Some(ReferenceWeight { follow: follow?, corner: corner? })
}

/// The model that an output follows. That of the speed is of first order, since the trim moves with it.
fn reference_model(table: &Table<'_>, place: usize) -> Option<Option<ReferenceModel>> {
    if place == SPEED {
        let frequency = within(table, "frequency", FREQUENCY);
        if table.has("damping") {
            table.not_allowed("damping", "given", "left out for the speed, whose model is of first order");
            return None;
        }
        return Some(Some(ReferenceModel { frequency: frequency?, damping: None }));
    }
    if !table.has("frequency") && !table.has("damping") {
        return Some(None);
    }
    let frequency = within(table, "frequency", FREQUENCY);
    let damping = if table.has("damping") { within(table, "damping", DAMPING).map(Some) } else { Some(None) };
    Some(Some(ReferenceModel { frequency: frequency?, damping: damping? }))
}

/// What the design allows a manoeuvre; `None` where that could not be read.
struct Limits {
    /// The range of speed, m/s.
    speeds: Option<(f64, f64)>,
    /// The largest pitch reference that the design is made for, rad.
    pitch: Option<f64>,
    /// Of the flight, s.
    duration: Option<f64>,
}

impl Limits {
    /// The default manoeuvre: a step that counts as 1 at most, at speeds for which there is a controller.
    fn manoeuvre(&self, table: &Table<'_>) -> Option<Manoeuvre> {
        table.allow_only(&[
            "pitch_step",
            "unit",
            "step_time",
            "speed_from",
            "speed_to",
            "ramp_start",
            "ramp_duration",
            "duration",
        ]);
        let factor = angle(table);
        let pitch_step = factor.and_then(|factor| self.pitch_step(table, factor));
        let most = self.duration.unwrap_or(f64::INFINITY);
        let words = format!("above 0 and at most {} (s), a million sample times", number(most));
        let duration = table.number("duration", |v| v > 0.0 && v <= most, &words);
        let end = duration.unwrap_or(f64::INFINITY);
        let before = "0 or more, and before the end of the flight (s)";
        let step_time = table.number("step_time", |v| v >= 0.0 && v < end, before);
        let (speed_from, speed_to) = (self.speed(table, "speed_from"), self.speed(table, "speed_to"));
        let ramp_start = table.number("ramp_start", |v| v >= 0.0, "0 or more (s)");
        let ramp_duration = table.number("ramp_duration", |v| v > 0.0, "above 0 (s)");
        Some(Manoeuvre {
            format: MANOEUVRE_FORMAT.into(),
            pitch_step: pitch_step?,
            step_time: step_time?,
            step_end: duration? + NEVER,
            speed_from: speed_from?,
            speed_to: speed_to?,
            ramp_start: ramp_start?,
            ramp_duration: ramp_duration?,
            duration: duration?,
        })
    }

    fn pitch_step(&self, table: &Table<'_>, factor: f64) -> Option<f64> {
        let Some(scale) = self.pitch.filter(|scale| *scale < FRAC_PI_2) else {
            let words = "other than 0 and below a right angle";
            let step = table.number("pitch_step", |v| v != 0.0 && (v * factor).abs() < FRAC_PI_2, words);
            return step.map(|step| factor * step);
        };
        let unit = if factor == 1.0 { "rad" } else { "deg" };
        let words = format!(
            "other than 0 and at most {} {unit} in size, the 'scale' of pitch: the largest reference that the \
                design is made for",
            rounded(scale / factor)
        );
        let allowed = |v: f64| v != 0.0 && (v * factor).abs() <= scale * (1.0 + ROUNDING);
        table.number("pitch_step", allowed, &words).map(|step| factor * step)
    }

    fn speed(&self, table: &Table<'_>, key: &str) -> Option<f64> {
        let (low, high) = self.speeds.unwrap_or((f64::MIN, f64::MAX));
        let words = match self.speeds {
            Some(_) => format!("from {} to {} (m/s), the range of the design", number(low), number(high)),
            None => "within the range of the design (m/s)".into(),
        };
        table.number(key, |v| (low..=high).contains(&v), &words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn squid() -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/design.toml");
        auv::read_text(&path).unwrap()
    }

    /// The words for the design of Squid with texts replaced, and the lines on which these stand.
    fn refused(edits: &[(&str, &str)]) -> (Vec<String>, Vec<usize>) {
        let (original, mut text) = (squid(), squid());
        let mut lines = Vec::new();
        for (old, new) in edits {
            let (before, _) = original.split_once(old).expect(old);
            lines.push(before.matches('\n').count() + 1);
            text = text.replacen(old, new, 1);
        }
        let words = DesignFile::parse(&text, "design.toml", "design").unwrap_err().to_string();
        (words.lines().map(str::to_owned).collect(), lines)
    }

    #[test]
    fn wrong_types_are_told_in_one_sentence() {
        for (old, new, words) in [
            (
                "speeds = 26",
                "speeds = 26.5",
                "'model.speeds' is the number 26.5; it must be a whole number, more than",
            ),
            (
                "order = 2",
                "order = -2",
                "'model.order' is the number -2; it must be a whole number, from 1 to 5",
            ),
            (
                "depth = 50.0",
                "depth = \"50 m\"",
                "'model.depth' is the text \"50 m\"; it must be a number, 0 or more (m)",
            ),
            (
                "back_off = 0.1",
                "back_off = true",
                "'synthesis.back_off' is true; it must be a number, from 0.001 to 1",
            ),
            (
                "weight = 0.04",
                "weight = { value = 1 }",
                "'control.weight' is a table; it must be a number, from 1e-6 to 1e6",
            ),
            (
                "weight = 0.04",
                "weight = [0.5]",
                "'control.weight' is a list; it must be a number, from 1e-6 to 1e6",
            ),
            (
                "weight = 0.04",
                "weight = 2026-01-01",
                "'control.weight' is the date or time 2026-01-01; it must be a number",
            ),
            ("unit = \"m/s\"", "unit = 7", "'track.unit' is the number 7; it must be \"m/s\""),
            (
                "output = \"pitch\"",
                "output = \"picth\"",
                "'track.output' is \"picth\" (did you mean \"pitch\"?); it must be \"pitch\" or \"speed\"",
            ),
            (
                "back_off = 0.1",
                "back_off = 0.1\nrate = -0.1",
                "'synthesis.rate' is -0.1; it must be from 1e-6 to 1e3 (m/s^2)",
            ),
            ("back_off = 0.1", "back_off = 1e17", "'synthesis.back_off' is 1e17; it must be from 0.001 to 1"),
            ("depth = 50.0", "depth = 1e300", "'model.depth' is 1e300; it must be at most 1e18 in size"),
            ("depth = 50.0", "depth = 50.0\ndepth = 50.0", "'depth' stands here a second time"),
        ] {
            let (found, lines) = refused(&[(old, new)]);
            let line = lines[0] + usize::from(new.contains("\ndepth") || new.contains("\nrate"));
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].starts_with(&format!("design.toml:{line}: {words}")), "{found:?}");
        }
    }

    #[test]
    fn what_is_measured_is_checked() {
        for (old, new, words) in [
            (
                "signal = \"pitch_rate\"",
                "signal = \"pitchrate\"",
                "'measure.signal' is \"pitchrate\" (did you mean",
            ),
            ("signal = \"pitch_rate\"", "signal = \"pitch\"", "'measure.signal' is \"pitch\" a second time"),
            ("unit = \"deg/s\"", "unit = \"deg\"", "'measure.unit' is \"deg\""),
            (
                "noise = 2.0",
                "noise = 0.0",
                "'measure.noise' is 0; it must be from 1e-9 to 1e6; without noise",
            ),
            ("rise = 1200.0", "rise = 0.5", "'measure.rise' is 0.5; it must be from 1, no less than"),
            ("damping = 1.0", "damping = 0.0", "'track.damping' is 0; it must be from 0.3 to 3"),
            (
                "follow = 6.0",
                "follow = 0.5",
                "'track.follow' is 0.5; it must be from 1, as much as fast ones",
            ),
            ("lags = true", "lags = 1", "'control.lags' is the number 1; it must be true or false"),
            (
                "sample_time = 0.02",
                "delay = 0.03\nsample_time = 0.02",
                "'autopilot.delay' is 0.03; it must be a multiple of the sample time, from 0 to 10 of them (s)",
            ),
            (
                "sample_time = 0.02",
                "delay = 0.22\nsample_time = 0.02",
                "'autopilot.delay' is 0.22; it must be",
            ),
        ] {
            let (found, lines) = refused(&[(old, new)]);
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].starts_with(&format!("design.toml:{}: {words}", lines[0])), "{found:?}");
        }
        let (half, _) = refused(&[("corner = 10.0\n", "")]);
        assert!(half[0].contains("missing key 'control.corner'"), "{half:?}");
        let (half, _) = refused(&[("follow = 6.0\n", "")]);
        assert!(half[0].contains("missing key 'track.follow'"), "{half:?}");
        let (missing, _) = refused(&[("frequency = 1.7\n", "")]);
        assert!(missing[0].contains("missing key 'track.frequency'"), "{missing:?}");
        let (second_order, _) = refused(&[("frequency = 1.7\n", "frequency = 1.7\ndamping = 0.7\n")]);
        assert!(second_order[0].contains("left out for the speed"), "{second_order:?}");
        // Without [[measure]] the controller sees the errors: there is no model to follow.
        let text = squid();
        let (start, rest) = text.split_once("[[measure]]").unwrap();
        let (_, end) = rest.split_once("[control]").unwrap();
        let errors = format!("{start}[control]{end}");
        let words = DesignFile::parse(&errors, "design.toml", "design").unwrap_err().to_string();
        assert!(words.contains("unknown key 'track.frequency'"), "{words}");
    }

    /// One line each, in the order of the file; a misspelt key is not missing as well.
    #[test]
    fn all_mistakes_are_told_at_once() {
        let (found, lines) = refused(&[
            ("sample_time =", "sampletime ="),
            ("speed_min =", "speedmin ="),
            ("peak = 2.0", "peak = \"two\""),
            ("depth = 50.0", "depth = -50.0"),
            ("ramp_start = 5.0", "ramp_start = nan"),
        ]);
        let mut lines = lines;
        lines.sort_unstable();
        assert_eq!(found.len(), lines.len(), "{found:?}");
        for (words, line) in found.iter().zip(lines) {
            assert!(words.starts_with(&format!("design.toml:{line}: ")), "{words}");
        }
        assert!(found[0].contains("unknown key 'model.speedmin' (did you mean 'speed_min'?)"), "{found:?}");
    }

    #[test]
    fn the_pitch_of_a_trim_is_a_word_or_an_angle() {
        let with = |lines: &str| squid().replacen("[control]", &format!("[trim]\n{lines}\n[control]"), 1);
        let read = |lines: &str| DesignFile::parse(&with(lines), "design.toml", "design");
        let line = squid().split_once("[control]").unwrap().0.matches('\n').count() + 2;
        for (lines, pitch) in [
            ("pitch = \"level\"", Pitch::Held(0.0)),
            ("pitch = \"free\"", Pitch::Free),
            ("pitch = { angle = -60.0, unit = \"deg\" }", Pitch::Held(-60f64.to_radians())),
            ("pitch = { angle = 0.5, unit = \"rad\" }", Pitch::Held(0.5)),
        ] {
            assert_eq!(read(lines).unwrap().pitch_asked, Some(pitch), "{lines}");
        }
        for (lines, words) in [
            (
                "pitch = \"lvel\"",
                "'trim.pitch' is \"lvel\" (did you mean \"level\"?); it must be \"level\" or \"free\"",
            ),
            ("pitch = 3.0", "'trim.pitch' is the number 3.0; it must be \"level\" or \"free\""),
            (
                "pitch = { angle = 61.0, unit = \"deg\" }",
                "'trim.pitch.angle' is 61; it must be at most 60 deg in size",
            ),
            (
                "pitch = { angle = -1.1, unit = \"rad\" }",
                "'trim.pitch.angle' is -1.1; it must be at most 60 deg in size",
            ),
            ("pitch = { angle = 2.0, unit = \"m\" }", "'trim.pitch.unit' is \"m\"; it must be"),
            ("pitch = { angle = 2.0 }", "missing key 'trim.pitch.unit'"),
            ("pitch = { unit = \"deg\" }", "missing key 'trim.pitch.angle'"),
            ("pitch = { angle = 2.0, unit = \"deg\", x = 1 }", "unknown key 'trim.pitch.x'"),
        ] {
            let message = read(lines).unwrap_err().to_string();
            assert!(message.starts_with(&format!("design.toml:{line}: {words}")), "{message}");
        }
        let message = read("angle = 2.0").unwrap_err().to_string();
        assert!(
            message.contains("missing key 'trim.pitch'") && message.contains("unknown key 'trim.angle'"),
            "{message}"
        );
    }

    #[test]
    fn a_manoeuvre_stays_within_the_design() {
        for (old, new, words) in [
            (
                "speed_to = 2.9",
                "speed_to = 3.1",
                "'manoeuvre.speed_to' is 3.1; it must be from 0.5 to 3 (m/s), the range",
            ),
            (
                "speed_from = 0.6",
                "speed_from = 0.4",
                "'manoeuvre.speed_from' is 0.4; it must be from 0.5 to 3 (m/s)",
            ),
            (
                "pitch_step = 10.0",
                "pitch_step = -10.1",
                "'manoeuvre.pitch_step' is -10.1; it must be other than 0 and at most 10 deg",
            ),
            (
                "step_time = 10.0",
                "step_time = 60.0",
                "'manoeuvre.step_time' is 60; it must be 0 or more, and before the end",
            ),
            (
                "duration = 60.0",
                "duration = 20001",
                "'manoeuvre.duration' is 20001; it must be above 0 and at most 20000 (s)",
            ),
        ] {
            let (found, lines) = refused(&[(old, new)]);
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].starts_with(&format!("design.toml:{}: {words}", lines[0])), "{found:?}");
        }
        let whole = squid().replacen("speed_to = 2.9", "speed_to = 3", 1).replacen(
            "pitch_step = 10.0",
            "pitch_step = -10",
            1,
        );
        let design = DesignFile::parse(&whole, "design.toml", "design").unwrap();
        assert_eq!((design.manoeuvre.speed_to, design.manoeuvre.pitch_step), (3.0, -10f64.to_radians()));
    }
}
