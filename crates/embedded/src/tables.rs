//! The tables of a source: sizes, numbers, and the indices of named inputs and outputs.

use crate::inputs::{inputs, measurements, origins, reference, references, steered_by, trims};
use crate::numbers::Numbers;
use crate::real::Real;
use crate::text::{has_curve, lines, named};
use squid_scheduled::{
    Actuator, ControllerDesign, ControllerInput, FARTHEST, Kind, LONGEST, Level, OverSpeed, Port, RAMP,
    REGAINED_AFTER, RETURN, RETURNING, ROUNDING_OF_RHO, ReferenceLimits, SLOWEST, STEPS, Source, Without,
    returning, ticks,
};
use squid_signals::{Curve, Law};
use std::f64::consts::TAU;

/// Substitutes for [`FARTHEST`] and [`ROUNDING_OF_RHO`] in single precision, which cannot represent the former and
/// rounds by more than the latter.
const FARTHEST_FLOAT: f64 = 1e30;
const ROUNDING_OF_RHO_FLOAT: f64 = 1e-6;

/// C index of an item that the design does not have.
const NONE: &str = "NONE";

/// Writes the tables of a design.
pub(crate) fn tables(design: &ControllerDesign, numbers: &Numbers, name: &str) -> String {
    Tables {
        design,
        numbers,
        real: numbers.real,
        measured: measurements(design),
        followed: references(design),
        trimmed: trims(design),
        origins: origins(design),
    }
    .text(name)
}

struct Tables<'a> {
    design: &'a ControllerDesign,
    numbers: &'a Numbers,
    real: Real,
    /// The signals that are measured, whose references are followed, whose trim is needed, and whose value measured at
    /// the reset is needed.
    measured: Vec<usize>,
    followed: Vec<usize>,
    trimmed: Vec<usize>,
    origins: Vec<usize>,
}

/// Members of a struct: name and value.
type Record = Vec<(&'static str, String)>;

/// Returns the C index of a signal in a list.
fn index_in(all: &[usize], signal: usize) -> String {
    all.iter().position(|one| *one == signal).map_or(NONE.to_owned(), |index| index.to_string())
}

fn flag(is_so: bool) -> String {
    u8::from(is_so).to_string()
}

/// Writes a table of named structs; one struct without members for an empty table, because C has no empty arrays.
fn records(of: &str, name: &str, all: Vec<(&str, Record)>) -> String {
    let record = |(name, members): &(&str, Record)| {
        let members = lines(members.iter().map(|(name, value)| format!("        .{name} = {value},")));
        format!("    {{\n        /* {name} */\n{members}\n    }}")
    };
    let records: Vec<String> = all.iter().map(record).collect();
    let text = if all.is_empty() { "    {0}".to_owned() } else { records.join(",\n") };
    format!("static const {of} {name}[{}] = {{\n{text}\n}};\n", all.len().max(1))
}

impl Tables<'_> {
    fn text(&self, name: &str) -> String {
        let Self { design, numbers, .. } = self;
        let actuators = &design.actuators;
        let column = |name: &str, of: fn(&Actuator) -> f64| {
            numbers.column(name, &actuators.iter().map(of).collect::<Vec<_>>())
        };
        let trim = |row: usize| {
            let signals = self.trimmed.iter().map(|index| &design.trim.signals[&design.signals[*index].name]);
            design.trim.actuators[row].iter().copied().chain(signals.map(|column| column[row])).collect()
        };
        let rows: Vec<Vec<f64>> = (0..design.trim.speed.len()).map(trim).collect();
        let level = numbers.autopilot.level(design.scheduling.centre);
        let level: Vec<f64> = inputs(design).iter().map(|input| level.measured[input.signal]).collect();
        [
            self.sizes(),
            numbers.matrices(),
            numbers.column("FORWARD_SPEED", &design.trim.forward_speed),
            numbers.column("PATH_SPEED", &design.trim.speed),
            numbers.table("TRIM", &rows),
            numbers.column("LEVEL", &level),
            self.first(),
            column("SCALE", |one| one.scale),
            column("MINIMUM", |one| one.minimum),
            column("MAXIMUM", |one| one.maximum),
            column("PUSHES", Actuator::pushes),
            column("LARGEST_APPLIED", Actuator::largest_applied),
            numbers.column("OPENING", numbers.autopilot.opening().0),
            design.failsafe.as_ref().map_or_else(String::new, |one| numbers.column("SAFE", &one.safe)),
            self.curves(),
            self.inputs(),
            self.references(),
            self.measurements(),
            self.scalars(),
            self.names(name),
        ]
        .concat()
    }

    fn sizes(&self) -> String {
        let Self { design, numbers, .. } = self;
        let (sizes, rows) = (numbers.sizes(), design.trim.speed.len());
        let speed = design.scheduled().unwrap_or_default();
        let tick = design.sample_time;
        let steers = self.followed.iter().fold(0, |all, index| all | steered_by(design, *index));
        let is_path = |index| matches!(design.source(index), Some(Source::Path(_)));
        let counts = [
            ("STATES", sizes.states),
            ("INPUTS", sizes.inputs),
            ("CHANNELS", sizes.channels),
            ("COMMANDS", sizes.outputs),
            ("MEASUREMENTS", self.measured.len()),
            ("REFERENCES", self.followed.len()),
            ("TRIMS", self.trimmed.len()),
            ("ORIGINS", self.origins.len()),
            ("NUMBERS", self.numbers_of_inputs().len()),
            ("ROWS", rows),
            // Largest power of two in the search for a row; the last row that starts an interval is ROWS - 2.
            ("FIRST_STRIDE", (rows - 2).checked_ilog2().map_or(0, |power| 1 << power)),
            ("FOLLOW_GAINS", numbers.autopilot.follow_gains().len()),
            ("OPEN_TICKS", numbers.autopilot.opening().1 as usize),
            ("HELD_TICKS", numbers.autopilot.yielding().1 as usize),
            ("HAS_FILTER", design.reference_filter.is_some().into()),
            ("HAS_ANTI_WINDUP", design.anti_windup.is_some().into()),
            ("CIRCULAR_SIGNALS", design.signals.iter().any(|signal| signal.circular).into()),
            ("SQUARE_LAWS", has_curve(design, |law| matches!(law, Law::Square(_))).into()),
            ("POINT_CURVES", has_curve(design, |law| matches!(law, Law::Points(_))).into()),
            ("ONE_WAY", (steers != 0 && design.actuators.iter().any(|one| one.pushes() != 0.0)).into()),
            ("PATH_SOURCES", (0..design.signals.len()).any(is_path).into()),
            ("FAILSAFE", design.failsafe.is_some().into()),
        ];
        let times = [
            ("REGAINED_TICKS", REGAINED_AFTER),
            ("RAMP_TICKS", RAMP),
            ("LONGEST_TICKS", LONGEST),
            ("RETURN_TICKS", RETURN),
        ];
        let largest = if self.real == Real::Double { "DBL_MAX" } else { "FLT_MAX" };
        let others = [
            ("SPEED", index_in(&self.measured, speed)),
            ("SPEED_REFERENCE", index_in(&self.followed, speed)),
            ("STEERS", format!("{steers:#x}u")),
            ("LARGEST", largest.to_owned()),
            ("SQRT", format!("sqrt{}", self.real.suffix())),
            ("COPYSIGN", format!("copysign{}", self.real.suffix())),
        ];
        let counts = counts.map(|(name, value)| (name, value.to_string()));
        let times = times.map(|(name, time)| (name, format!("{}u", ticks(time, tick))));
        let all = counts.into_iter().chain(times).chain(others);
        all.map(|(name, value)| format!("#define {name} {value}\n")).collect()
    }

    fn scalars(&self) -> String {
        let Self { design, numbers, .. } = self;
        let is_double = self.real == Real::Double;
        let channels = numbers.sizes().channels;
        let fade = self.followed.first().map_or(0.0, |index| numbers.autopilot.returning(*index).0);
        let scalars = [
            ("TICK", Some(design.sample_time)),
            ("TURN", Some(TAU)),
            ("CENTRE", Some(design.scheduling.centre)),
            ("HALF_RANGE", Some(design.scheduling.half_range)),
            ("FARTHEST", Some(if is_double { FARTHEST } else { FARTHEST_FLOAT })),
            ("ROUNDING_OF_RHO", Some(if is_double { ROUNDING_OF_RHO } else { ROUNDING_OF_RHO_FLOAT })),
            ("PRECISION", (channels > 0).then_some(channels as f64 * self.real.epsilon())),
            ("FILTER", Some(numbers.autopilot.filter().unwrap_or_default())),
            ("YIELDING", Some(numbers.autopilot.yielding().0)),
            ("FADE", Some(fade)),
            ("FADE_STEP", Some(design.sample_time / RETURNING)),
            ("FADE_TIME", Some(RETURNING)),
            ("RETURNING", design.failsafe.as_ref().map(|_| returning(design))),
            ("STEPS", design.failsafe.as_ref().map(|_| STEPS)),
        ];
        let all = scalars.into_iter().filter_map(|(name, value)| Some((name, value?)));
        all.map(|(name, value)| format!("static const real {name} = {};\n", self.real.literal(value)))
            .collect()
    }

    /// Writes the ranges of the inputs at a reset.
    fn first(&self) -> String {
        let range = |input: &crate::inputs::Input| {
            let ends = self.design.signals[input.signal].first(!input.measured);
            let [least, most] = self.ends(ends);
            format!("    {{{least}, {most}}}")
        };
        let all: Vec<String> = inputs(self.design).iter().map(range).collect();
        format!("static const real FIRST[{}][2] = {{\n{}\n}};\n", all.len(), all.join(",\n"))
    }

    /// Formats the bounds of a range; without a range, the largest numbers.
    fn ends(&self, ends: Option<[f64; 2]>) -> [String; 2] {
        ends.map_or(["-LARGEST", "LARGEST"].map(str::to_owned), |ends| ends.map(|end| self.real.literal(end)))
    }

    fn curves(&self) -> String {
        let mut text = String::new();
        let mut curve = |(index, actuator): (usize, &Actuator)| match actuator.curve.as_ref().map(Curve::law)
        {
            None => vec![("square", "0".to_owned())],
            Some(Law::Square(k)) => vec![("square", self.real.literal(*k))],
            Some(Law::Points(points)) => {
                let name = format!("POINTS_{index}");
                text +=
                    &self.numbers.table(&name, &points.iter().map(|one| one.to_vec()).collect::<Vec<_>>());
                let at_rest = self.real.literal(actuator.input_for(0.0).0);
                vec![("points", name), ("count", points.len().to_string()), ("at_rest", at_rest)]
            }
        };
        let all = self.design.actuators.iter().enumerate();
        let all = all.map(|(index, one)| (one.name.as_str(), curve((index, one)))).collect();
        let curves = records("curve", "CURVE", all);
        text + &curves
    }

    /// Returns the constants from which inputs of the controller are deviations.
    fn numbers_of_inputs(&self) -> Vec<f64> {
        let signals = self.design.signals.iter().enumerate();
        let is_number =
            |(index, one): &(usize, &Port)| one.level == Level::Start && !self.origins.contains(index);
        std::iter::once(0.0).chain(signals.filter(is_number).map(|(_, one)| one.start)).collect()
    }

    fn inputs(&self) -> String {
        let numbers = self.numbers_of_inputs();
        let record = |input: &ControllerInput| {
            let signal = self.design.index(&input.signal).unwrap_or_default();
            let Port { level, start, .. } = self.design.signals[signal];
            let number = |value: f64| {
                let index = numbers.iter().position(|one| one.to_bits() == value.to_bits());
                format!("NUMBER + {}", index.unwrap_or_default())
            };
            let [measured, used] = [&self.measured, &self.followed].map(|all| index_in(all, signal));
            let used = format!("USED + {used}");
            let level = match level {
                Level::Trim => format!("TRIMMED + COMMANDS + {}", index_in(&self.trimmed, signal)),
                Level::Scheduled => "FILTERED_SPEED".to_owned(),
                Level::Start if self.origins.contains(&signal) => {
                    format!("ORIGIN + {}", index_in(&self.origins, signal))
                }
                Level::Start => number(start),
                Level::Zero => number(0.0),
            };
            let (plus, minus) = match input.kind {
                Kind::Error => (used, measured),
                Kind::Reference => (used, level),
                Kind::Measurement => (measured, level),
            };
            vec![("plus", plus), ("minus", minus), ("scale", self.real.literal(input.scale))]
        };
        let all = self.design.controller_inputs.iter().map(|one| (one.signal.as_str(), record(one)));
        let origins: Vec<String> = self.origins.iter().map(|one| index_in(&self.measured, *one)).collect();
        let text = records("controller_input", "INPUT", all.collect())
            + &self.numbers.column("NUMBERS_OF", &numbers);
        if origins.is_empty() {
            return text;
        }
        text + &format!("static const int ORIGIN_OF[{}] = {{{}}};\n", origins.len(), origins.join(", "))
    }

    fn references(&self) -> String {
        let none = ReferenceLimits::default();
        let mut text = String::new();
        let mut record = |signal: usize| {
            let port = &self.design.signals[signal];
            let limits = self.design.envelope.get(&port.name).unwrap_or(&none);
            let is_measured = self.design.measures(signal);
            let lag = port.reference.as_ref().map_or(0.0, |one| one.lag);
            let mut members = vec![
                ("measured", index_in(&self.measured, signal)),
                ("is_circular", flag(port.circular)),
                (
                    "begins_as_measured",
                    flag(port.level == Level::Start && is_measured && limits.rate.is_some()),
                ),
                (
                    "is_limited",
                    format!("{{{}, {}}}", flag(limits.range.is_some()), flag(limits.rate.is_some())),
                ),
                ("steered_by", format!("{:#x}u", steered_by(self.design, signal))),
                ("lag", self.real.literal(lag)),
                ("negligible", self.real.literal(self.numbers.autopilot.returning(signal).1)),
            ];
            let (mut constants, mut columns) = (vec![], vec![]);
            for (names, ends) in [(["LEAST", "MOST"], &limits.range), (["SLOWEST", "FASTEST"], &limits.rate)]
            {
                let none = [OverSpeed::Constant(0.0), OverSpeed::Constant(0.0)];
                let each = ends.as_ref().unwrap_or(&none).iter().zip(names).map(|(end, name)| match end {
                    OverSpeed::Constant(value) => (self.real.literal(*value), "NULL".to_owned()),
                    OverSpeed::Table(column) => {
                        let table = format!("{name}_{}", reference(port).to_ascii_uppercase());
                        text += &self.numbers.column(&table, column);
                        ("0.0".to_owned(), table)
                    }
                });
                let (limit, column): (Vec<_>, Vec<_>) = each.unzip();
                constants.push(format!("{{{}}}", limit.join(", ")));
                columns.push(format!("{{{}}}", column.join(", ")));
            }
            members.push(("limit", format!("{{{}}}", constants.join(", "))));
            members.push(("column", format!("{{{}}}", columns.join(", "))));
            members
        };
        let all = self.followed.iter().map(|&one| (reference(&self.design.signals[one]), record(one)));
        let records = records("reference", "REFERENCE", all.collect());
        text + &records
    }

    fn measurements(&self) -> String {
        let mut text = String::new();
        let mut record = |signal: usize| {
            let Port { name, circular, range, .. } = &self.design.signals[signal];
            let mut members =
                vec![("reference", index_in(&self.followed, signal)), ("is_circular", flag(*circular))];
            let Some(failsafe) = &self.design.failsafe else { return members };
            let index =
                |name: &str, all: &[usize]| index_in(all, self.design.index(name).unwrap_or_default());
            match self.design.source(signal) {
                None => {}
                Some(Source::Rate(other)) => {
                    members.extend([("source", "BY_RATE".into()), ("other", index(other, &self.measured))]);
                }
                Some(Source::Path(pitch)) => members.extend([
                    ("source", "BY_PATH".to_owned()),
                    ("other", index(pitch, &self.measured)),
                    ("pitch_trim", format!("COMMANDS + {}", index(pitch, &self.trimmed))),
                ]),
                Some(Source::Commands { gains, time }) => {
                    let table = format!("GAINS_{}", name.to_ascii_uppercase());
                    text += &self.numbers.column(&table, gains);
                    let time = self.real.literal(*time);
                    members.extend([("source", "BY_FORCE".into()), ("gains", table), ("time", time)]);
                }
            }
            let without = match self.design.without(signal) {
                Without::Speed => "OPEN_LOOP",
                Without::Reckoned => "RECKONED",
                Without::Nothing => "SAFE_COMMANDS",
            };
            let sensor = failsafe.sensors.get(name).cloned().unwrap_or_default();
            let [least, most] = self.ends(*range);
            let oldest = failsafe.stale_after + sensor.period;
            let tick = self.design.sample_time;
            let stale = if failsafe.stale_after == 0.0 { u32::MAX } else { ticks(oldest, tick) };
            members.extend([
                ("without", without.to_owned()),
                ("error", self.real.literal(sensor.error)),
                ("rate", self.real.literal(sensor.rate)),
                ("drift", self.real.literal(sensor.drift)),
                ("resolution", self.real.literal(sensor.resolution)),
                ("least", least),
                ("most", most),
                ("oldest", self.real.literal(oldest)),
                ("slowest", format!("{}u", ticks(SLOWEST.max(sensor.period), tick))),
                ("stale", format!("{stale}u")),
            ]);
            members
        };
        let all = self.measured.iter().map(|&one| (self.design.signals[one].name.as_str(), record(one)));
        let records = records("measurement", "MEASUREMENT", all.collect());
        text + &records
    }

    /// Writes the functions that map the struct members of the header to indices.
    fn names(&self, name: &str) -> String {
        let design = self.design;
        let function = |signature: &str, body: String| {
            let signature = named(signature, name);
            format!("\nstatic void {signature}\n{{\n{body}\n}}\n")
        };
        let actuators = |line: &dyn Fn(usize, &str) -> String| {
            lines(design.actuators.iter().enumerate().map(|(index, one)| line(index, &one.name)))
        };
        let ages = design.failsafe.iter().flat_map(|_| &self.measured);
        let ages = ages.map(|index| format!("{}_age", design.signals[*index].name));
        let inputs = inputs(design).into_iter().map(|input| input.name).chain(ages);
        let inputs = inputs.enumerate().map(|(index, name)| format!("    to[{index}] = from->{name};"));
        let trims = design.trimmed().map(|signal| {
            let (name, index) = (&design.signals[signal].name, index_in(&self.trimmed, signal));
            format!("    to->trim_{name} = value[TRIMMED + COMMANDS + {index}];")
        });
        let used = self.followed.iter().enumerate();
        let used = used.map(|(index, signal)| {
            format!("    to->{}_used = value[USED + {index}];", reference(&design.signals[*signal]))
        });
        let monitors = ["    (void)value, (void)to; /* unused in some designs */".to_owned()];
        let put = actuators(&|index, name| format!("    to->{name} = from[{index}];"));
        let mut functions = vec![
            ("get_inputs(const autopilot_inputs *from, real *to)", lines(inputs)),
            (
                "get_applied(const autopilot_commands *from, real *to)",
                actuators(&|index, name| format!("    to[{index}] = from->{name};")),
            ),
            ("put_commands(const real *from, autopilot_outputs *to)", put.clone()),
            (
                "put_monitors(const real *value, autopilot_outputs *to)",
                lines(monitors.into_iter().chain(trims).chain(used)),
            ),
        ];
        if design.failsafe.is_some() {
            functions.push(("put_safe(const real *from, autopilot_commands *to)", put));
        }
        functions.into_iter().map(|(signature, body)| function(signature, body)).collect()
    }
}
