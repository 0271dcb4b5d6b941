//! Reads a design file, table by table.

use crate::inputs::design_file::manoeuvre::Limits;
use crate::inputs::design_file::relative_weight::RelativeWeight;
use crate::inputs::design_file::tracked::{measured, tracked};
use crate::inputs::design_file::values::{ROUNDING, angle, rising, within};
use crate::inputs::design_file::{
    CONTROL_WEIGHT, DEFAULT_REDUCE, DISTURBANCE, DesignFile, Envelope, Failsafe, RATE, REDUCE, Require,
    SAMPLE_TIME, WAVE_WEIGHT, WorkingSea, relative_weight, uncertainty,
};
use squid_auv::toml_file::{Document, FileError, FileProblem, Table};
use squid_auv::{LONGITUDINAL, Pitch, VIEWS, View};
use squid_flight::sea::WaveParameters;
use squid_lpv::weights::RisingWeight;
use squid_scheduled::MAX_DELAY_TICKS;
use squid_signals::{Interface, Level, Signal};

/// Largest number of ticks of a flight: its record is kept in memory, some 200 bytes each.
const MOST_TICKS: f64 = 1e6;

/// Text for a pitch of zero, and for the pitch of least effort.
const LEVEL: &str = "level";
const FREE: &str = "free";

/// Largest pitch held in level trim, deg: beyond it the trim is not level flight at an incidence.
const STEEPEST: f64 = 60.0;

const SECTIONS: [&str; 16] = [
    AXIS,
    "description",
    "model",
    "trim",
    "track",
    "measure",
    "control",
    "controller",
    "sea",
    "synthesis",
    "autopilot",
    "envelope",
    "failsafe",
    "manoeuvre",
    "uncertainty",
    "require",
];

/// Key of the list of axes.
const AXIS: &str = "axis";

impl DesignFile {
    /// Checks the text of a design file with one axis; `file` is for messages.
    ///
    /// # Errors
    /// [`FileError`]: every mistake with file, line, key, its value and the allowed values; a file of several axes.
    pub fn parse(text: &str, file: &str, name: &str) -> Result<Self, FileError> {
        let mut axes = Self::parse_each(text, file, name)?;
        if axes.len() > 1 {
            return Err(mistake_at_axis(
                (text, file),
                1,
                "a second one",
                "only one, because a single axis was \
                selected",
            ));
        }
        Ok(axes.remove(0))
    }

    /// Checks the text of a design file: one axis for each `[[axis]]`, with the keys outside of these for all; without
    /// any, the file is one axis.
    ///
    /// # Errors
    /// The errors of [`parse`](Self::parse); two axes that steer the same signal.
    pub fn parse_each(text: &str, file: &str, name: &str) -> Result<Vec<Self>, FileError> {
        let documents = Document::parse_each(text, file, AXIS)?;
        let read = documents
            .iter()
            .map(|document| document.finish(design(document, interface(document), file, name)));
        let mut axes: Vec<Self> = FileError::collect(read)?;
        if axes.len() > 1 {
            for (index, axis) in axes.iter_mut().enumerate() {
                (axis.name, axis.axis) = (axis.steered_signal().to_owned(), Some(index));
            }
        }
        let is_known = |index: &usize| axes[..*index].iter().any(|other| other.name == axes[*index].name);
        match (0..axes.len()).find(is_known) {
            Some(index) => {
                let (found, allowed) = (
                    format!("of {} a second time", axes[index].name),
                    "of an output that is not tracked yet",
                );
                Err(mistake_at_axis((text, file), index, &found, allowed))
            }
            None => Ok(axes),
        }
    }

    /// Checks the text of a design file for a vehicle with other states and signals; see [`parse`](Self::parse).
    ///
    /// # Errors
    /// The errors of [`parse`](Self::parse).
    pub fn parse_for(
        interface: &'static Interface,
        text: &str,
        file: &str,
        name: &str,
    ) -> Result<Self, FileError> {
        let document = Document::parse(text, file)?;
        if document.root().has(AXIS) {
            document.root().not_allowed(AXIS, "a list", "omitted, because a single axis was selected");
        }
        document.finish(design(&document, interface, file, name))
    }

    /// Checks another text of the same file, and returns the same axis of it.
    ///
    /// # Errors
    /// The errors of [`parse`](Self::parse).
    pub fn parse_again(&self, text: &str) -> Result<Self, FileError> {
        let axes = Self::parse_each(text, &self.file, &self.autopilot)?;
        let own = axes.into_iter().find(|other| other.axis == self.axis);
        own.ok_or_else(|| FileError { file: self.file.clone(), mistakes: Vec::new() })
    }
}

/// Interface of an axis: that of the first view with the most of its tracked and measured signals, besides the speed.
fn interface(document: &Document<'_>) -> &'static Interface {
    let root = document.root();
    let count = |view: &View| {
        let own = || view.interface.signals.iter().filter(|one| one.level != Level::Scheduled);
        let tracked =
            |signal: &&Signal| signal.reference.is_some() && root.has_among("track", "output", signal.name);
        let measured = |signal: &&Signal| root.has_among("measure", "signal", signal.name);
        own().filter(tracked).count() + own().filter(measured).count()
    };
    VIEWS.iter().rev().max_by_key(|view| count(view)).map_or(LONGITUDINAL.interface, |view| view.interface)
}

/// Mistake at an axis of a file.
fn mistake_at_axis((text, file): (&str, &str), index: usize, found: &str, allowed: &str) -> FileError {
    let recorded = Document::parse(text, file).and_then(|document| {
        if let Some(table) = document.root().tables(AXIS).get(index) {
            let (key, found, allowed) = (AXIS.to_owned(), found.to_owned(), allowed.to_owned());
            table.problem(FileProblem::NotAllowed { key, found, allowed });
        }
        document.finish(None::<()>)
    });
    recorded.err().unwrap_or_else(|| FileError { file: file.to_owned(), mistakes: Vec::new() })
}

/// Rise of gamma for fewer states and channels, if any; with `rate` all are kept.
fn reduce(table: &Table<'_>) -> Option<Option<f64>> {
    match (table.has("reduce"), table.has("rate")) {
        (false, rate) => Some((!rate).then_some(DEFAULT_REDUCE)),
        (true, false) => within(table, "reduce", REDUCE).map(|share| (share > 0.0).then_some(share)),
        (true, true) => {
            table.not_allowed("reduce", "given", "omitted if 'rate' is given");
            None
        }
    }
}

/// Design of a file; `None` if a recorded mistake leaves a value undefined.
fn design(
    document: &Document<'_>,
    interface: &'static Interface,
    file: &str,
    name: &str,
) -> Option<DesignFile> {
    let root = document.root();
    root.allow_only(&SECTIONS);
    let description = root.text("description");
    let model = root.required_table("model", "the speed range, the depth and the fit").map(|t| Model::of(&t));
    let pitch = root.table("trim").map_or(Some(None), |table| pitch(&table).map(Some));
    let measured = measured(&root, interface);
    let tracked = tracked(&root, interface, measured.as_ref().is_none_or(|all| !all.is_empty()));
    let control =
        root.required_table("control", "the weights of the actuators, and the disturbance at their inputs");
    let control = control.as_ref().map(|table| Control::of(document, table));
    let controller = root.table("controller").map_or(Some(None), |table| squid_pid::read(&table, file));
    let speeds = model.as_ref().and_then(|m| m.speed_min.zip(m.speed_max));
    let sea = root.table("sea").map_or(Some(None), |table| working_sea(&table, speeds).map(Some));
    let synthesis = root.required_table("synthesis", "back_off, the relative distance from the least gamma");
    let back_off = synthesis.as_ref().and_then(|table| {
        table.allow_only(&["back_off", "rate", "reduce"]);
        table.number("back_off", |v| (0.001..=1.0).contains(&v), "from 0.001 to 1")
    });
    let reduce = synthesis.as_ref().map_or(Some(None), reduce);
    let bounded = synthesis.filter(|table| table.has("rate"));
    let rate =
        bounded.map_or(Some(None), |table| table.number("rate", |v| RATE.allows(v), RATE.text).map(Some));
    let autopilot = root.required_table("autopilot", "sample_time (s)");
    let autopilot = autopilot.as_ref().map(Autopilot::of);
    let sample_time = autopilot.as_ref().and_then(|autopilot| autopilot.sample_time);
    let view = View::of_states(interface.states);
    if view.is_level_held && root.has("sea") {
        let only = format!("omitted in an axis of {}: it applies to {}", view.name, LONGITUDINAL.name);
        root.not_allowed("sea", "given", only);
    }
    let turns = interface.index("heading").is_some();
    if view.is_level_held && !turns && root.has("envelope") {
        root.not_allowed("envelope", "given", format!("omitted in an axis of {}", view.name));
    }
    let read = |table| if turns { Envelope::of_heading(&table) } else { Envelope::of(&table) };
    let envelope = root.table("envelope").map_or_else(|| Some(Envelope::default()), read);
    let is_measured = |signal: &Signal| match (&tracked, &measured) {
        (Some(tracked), Some(measured)) => {
            let is = |index: usize| interface.signals[index].name == signal.name;
            let by_itself = measured.iter().any(|one| is(one.index));
            let by_error = measured.is_empty() && tracked.iter().any(|one| is(one.index));
            signal.level == Level::Scheduled || by_itself || by_error
        }
        _ => true,
    };
    let failsafe = root.table("failsafe").map_or_else(
        || Some(Failsafe::default()),
        |table| Failsafe::of(&table, interface.signals, is_measured),
    );
    let limits = Limits {
        speeds,
        interface,
        tracked: tracked.as_deref().unwrap_or_default(),
        duration: sample_time.map(|time| MOST_TICKS * time),
    };
    let manoeuvre = root.required_table("manoeuvre", "the default manoeuvre of the closed-loop FMU");
    let manoeuvre = manoeuvre.and_then(|table| limits.manoeuvre(&table));
    let uncertainty = root.table("uncertainty").map(|table| uncertainty::read(document, &table));
    let require = root.table("require").map_or_else(|| Some(Require::default()), |table| Require::of(&table));
    let (model, control) = (model?, control?);
    Some(DesignFile {
        name: name.into(),
        file: format!("{name}.toml"),
        autopilot: name.into(),
        axis: None,
        description: description?,
        speed_min: model.speed_min?,
        speed_max: model.speed_max?,
        speeds: model.speeds?,
        depth: model.depth?,
        pitch: pitch.clone()?.unwrap_or_default(),
        pitch_asked: pitch?,
        states: interface.states,
        interface,
        order: model.order?,
        drop: model.drop?,
        tracked: tracked?,
        measured: measured?,
        control_weight: control.weight?,
        relative_weights: control.relative,
        disturbance: control.disturbance?,
        sea: sea?,
        lags: control.lags?,
        controller: controller?,
        back_off: back_off?,
        reduce: reduce?,
        judged: false,
        rate: rate?,
        sample_time: sample_time?,
        delay: autopilot.as_ref()?.delay?,
        anti_windup: autopilot?.anti_windup?,
        envelope: envelope?,
        failsafe: failsafe?,
        manoeuvre: manoeuvre?,
        uncertainty,
        require: require?,
    })
}

/// Section `[trim]`: "level", "free", or an angle.
fn pitch(table: &Table<'_>) -> Option<Pitch> {
    table.allow_only(&["pitch"]);
    if !table.holds_table("pitch") {
        let allowed = [LEVEL, FREE];
        return table.one_of("pitch", &allowed).map(|index| [Pitch::Held(0.0), Pitch::Free][index].clone());
    }
    let held = table.table("pitch")?;
    held.allow_only(&["angle", "unit"]);
    let factor = angle(&held);
    let allowed = |v: f64| factor.is_none_or(|factor| (v * factor).abs() <= STEEPEST.to_radians());
    let angle = held.number("angle", allowed, "of a magnitude of at most 60 deg");
    Some(Pitch::Held(factor? * angle?))
}

/// Section `[sea]`; the range of speed \[m/s\] is `None` if it could not be read.
fn working_sea(table: &Table<'_>, speeds: Option<(f64, f64)>) -> Option<WorkingSea> {
    let waves = WaveParameters::of(table, &["depth", "weight"]);
    let depth = table.number("depth", |depth| depth > 0.0, "above 0 (m), the working depth in waves");
    let weight = table.or("weight", 1.0, |table, key| within(table, key, WAVE_WEIGHT));
    let sea = WorkingSea { waves: waves?, depth: depth?, weight: weight? };
    if sea.depth < 0.5 * sea.waves.spectrum.height() {
        let allowed =
            "at least half the significant height (m), because wave troughs uncover a shallower hull";
        table.not_allowed("depth", squid_auv::number(sea.depth), allowed);
        return None;
    }
    if let Some((low, high)) = speeds
        && [low, high].iter().any(|speed| sea.filter(*speed).is_none())
    {
        let allowed = "such that every speed of the vehicle is below half of the phase velocity of the waves along \
                     its path";
        table.not_allowed("heading", squid_auv::number(sea.waves.heading.to_degrees()), allowed);
        return None;
    }
    Some(sea)
}

/// Section `[control]`.
struct Control {
    weight: Option<RisingWeight>,
    relative: Vec<RelativeWeight>,
    disturbance: Option<f64>,
    lags: Option<bool>,
}

impl Control {
    fn of(document: &Document<'_>, table: &Table<'_>) -> Self {
        table.allow_only(&["weight", "rise", "corner", "disturbance", "lags", "actuators"]);
        Self {
            weight: rising(table, "weight", CONTROL_WEIGHT, 1.0),
            relative: relative_weight::read(document, table),
            disturbance: within(table, "disturbance", DISTURBANCE),
            lags: table.or("lags", false, Table::truth),
        }
    }
}

/// Section `[autopilot]`.
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
            (0.0..=MAX_DELAY_TICKS as f64 + 0.5).contains(&ticks) && (ticks - ticks.round()).abs() < ROUNDING
        };
        let in_ticks = |delay: f64| sample_time.is_none_or(|time| in_ticks(delay / time));
        let delay = table.or("delay", 0.0, |table, key| {
            table.number(key, in_ticks, "from 0 to 10 sample times, as a multiple of the sample time (s)")
        });
        let anti_windup = table.or("anti_windup", true, Table::truth);
        Self { sample_time, delay, anti_windup }
    }
}

/// Section `[model]`.
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
        let speed_min = table.number("speed_min", |_| true, "a finite number (m/s), negative astern");
        let above = speed_min.unwrap_or(f64::NEG_INFINITY);
        let enough = |v| v > order.unwrap_or(1) && v <= 1000;
        Self {
            speed_min,
            speed_max: table.number("speed_max", |v| v > above, "above 'speed_min' (m/s)"),
            speeds: table.whole("speeds", enough, "above the order, at most 1000"),
            depth: table.number("depth", |v| v >= 0.0, "at least 0 (m)"),
            order,
            drop: table.number("drop", |v| (0.0..0.5).contains(&v), "at least 0 and below 0.5"),
        }
    }
}
