//! What the header and the source have for sensors that fail, in the order of [`squid_scheduled::Supervisor`].

use crate::inputs::{Input, inputs, near, reference};
use crate::tables::{Tables, column};
use crate::template::{fill, lines};
use squid_scheduled::{
    ControllerDesign, LONGEST, Port, RAMP, REGAINED_AFTER, RETURN, SLOWEST, STEPS, Source, Without,
    returning, ticks,
};

/// A sensor that is judged.
pub(crate) struct Watched {
    input: Input,
    without: Without,
    sensor: squid_scheduled::Sensor,
}

impl Watched {
    /// Its bit of the status.
    fn bit(&self) -> String {
        format!("@PREFIX@_LOST_{}", self.input.name.to_ascii_uppercase())
    }

    fn name(&self) -> &str {
        &self.input.name
    }
}

/// The sensors that are judged, in the order of the signals; none without a failsafe.
pub(crate) fn watched(design: &ControllerDesign) -> Vec<Watched> {
    let measured = inputs(design).into_iter().filter(|input| input.measured);
    let of = |input: Input| {
        let sensor = design.failsafe.as_ref()?.sensors.get(&input.name)?.clone();
        Some(Watched { without: design.without(input.signal), input, sensor })
    };
    measured.filter_map(of).collect()
}

/// Whether the reference of a signal is held while its sensor is lost: it follows from the path alone.
fn holds(design: &ControllerDesign, signal: usize) -> bool {
    matches!(design.source(signal), Some(Source::Path(_))) && design.follows(signal)
}

/// The rate of a signal, from what `value` writes for others; `None` of one whose rate they do not give.
pub(crate) fn rate(
    design: &ControllerDesign,
    signal: &Port,
    value: impl Fn(&str) -> String,
) -> Option<String> {
    match design.source(design.index(&signal.name)?)? {
        Source::Rate(name) => Some(value(name)),
        Source::Path(pitch) => {
            let speed = &design.signals[design.scheduled()?].name;
            Some(format!("along_path({}, {}, {})", value(speed), value(pitch), column(pitch)))
        }
        Source::Commands { .. } => None,
    }
}

/// The function for the rate of depth.
pub(crate) fn path(design: &ControllerDesign) -> &'static str {
    let is_path = |signal| matches!(design.source(signal), Some(Source::Path(_)));
    if (0..design.signals.len()).any(is_path) { include_str!("template/path.c") } else { "" }
}

/// Whether what is used of a reference is needed where a sensor is lost.
pub(crate) fn needs_last(design: &ControllerDesign, signal: usize) -> bool {
    let is_watched = design.failsafe.is_some() && design.measures(signal);
    is_watched
        && match design.without(signal) {
            Without::Speed => design.reference_filter.is_none(),
            Without::Reckoned => holds(design, signal),
            Without::Nothing => false,
        }
}

/// Fields of the header.
pub(crate) fn of_header(design: &ControllerDesign) -> Vec<(&'static str, String)> {
    let all = watched(design);
    let Some(failsafe) = &design.failsafe else {
        let fields = ["include_stdint", "stale_after", "ages", "lost_bits", "sensors", "safe"];
        return fields.map(|name| (name, String::new())).to_vec();
    };
    let of =
        |line: &dyn Fn((usize, &Watched)) -> String| -> String { all.iter().enumerate().map(line).collect() };
    let bit = |(index, one): (usize, &Watched)| {
        let words = match one.without {
            Without::Speed => "it is taken to go to its filtered reference: its loop is open",
            Without::Reckoned if holds(design, one.input.signal) => {
                "it is reckoned from pitch and speed, and its reference is held"
            }
            Without::Reckoned => "it is reckoned from its rate",
            Without::Nothing => "FAILED",
        };
        format!("#define {} {:#x}u /* {} is lost: {words} */\n", one.bit(), 0x10 << index, one.name())
    };
    let sensors = fill(
        include_str!("template/sensors.h"),
        &[
            ("watched", of(&|(_, one)| format!("    @prefix@_watched watched_{};\n", one.name()))),
            ("m", design.actuators.len().to_string()),
        ],
    );
    vec![
        ("include_stdint", "#include <stdint.h>\n\n".to_owned()),
        (
            "stale_after",
            format!(
                "#define @PREFIX@_STALE_AFTER {:?} /* s: a measurement that is older, or the same for so long \
                 where it should have moved, is lost; 0 for never */",
                failsafe.stale_after
            ),
        ),
        (
            "ages",
            of(&|(_, one)| format!("    @prefix@_real {}_age; /* s since it was measured */\n", one.name())),
        ),
        (
            "lost_bits",
            "#define @PREFIX@_FAILED 0x8u /* a sensor that nothing replaces is lost: the commands go to the \
             safe ones, and all else holds */\n"
                .to_owned()
                + &of(&bit),
        ),
        ("sensors", sensors),
        ("safe", include_str!("template/safe.h").to_owned()),
    ]
}

/// The member of the state.
pub(crate) fn member(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_some() { "    @prefix@_sensors sensors;\n" } else { "" }
}

/// Numbers of the source.
pub(crate) fn numbers(design: &ControllerDesign, tables: &Tables) -> String {
    let Some(failsafe) = &design.failsafe else { return String::new() };
    let counts = [
        ("NEVER", squid_scheduled::NEVER),
        ("REGAINED_TICKS", ticks(REGAINED_AFTER, design.sample_time)),
        ("RAMP_TICKS", ticks(RAMP, design.sample_time)),
        ("LONGEST_TICKS", ticks(LONGEST, design.sample_time)),
        ("RETURN_TICKS", ticks(RETURN, design.sample_time)),
    ];
    let counts: String =
        counts.iter().map(|(name, count)| format!("static const uint32_t {name} = {count}u;\n")).collect();
    let literal = |name: &str, value| format!("static const real {name} = {};\n", tables.real.literal(value));
    let gains = watched(design).into_iter().filter_map(|one| match design.source(one.input.signal)? {
        Source::Commands { gains, .. } => {
            Some(tables.column(&format!("GAINS_{}", one.name().to_ascii_uppercase()), gains))
        }
        _ => None,
    });
    tables.column("SAFE", &failsafe.safe)
        + &counts
        + &literal("RETURNING", returning(design))
        + &literal("STEPS", STEPS)
        + &gains.collect::<String>()
}

/// The functions that judge the sensors.
pub(crate) fn functions(design: &ControllerDesign, tables: &Tables) -> String {
    let all = watched(design);
    let Some(failsafe) = &design.failsafe else { return String::new() };
    let largest = if tables.real == crate::Real::Double { "DBL_MAX" } else { "FLT_MAX" };
    let constants = all.iter().map(|one| {
        let numbers = [one.sensor.error, one.sensor.rate, one.sensor.drift, one.sensor.resolution]
            .map(|v| tables.real.literal(v));
        let ends = design.signals[one.input.signal].range.map_or_else(
            || [format!("-{largest}"), largest.to_owned()],
            |ends| ends.map(|end| tables.real.literal(end)),
        );
        let name = one.name().to_ascii_uppercase();
        let slowest = ticks(SLOWEST.max(one.sensor.period), design.sample_time);
        let stale = match failsafe.stale_after {
            0.0 => u32::MAX,
            after => ticks(after + one.sensor.period, design.sample_time),
        };
        let has_rate = matches!(design.source(one.input.signal), Some(Source::Rate(_)));
        let are = [one.without == Without::Speed, one.without == Without::Reckoned, has_rate].map(u8::from);
        format!(
            "static const sensor SENSOR_{name} = {{{}, {}, {slowest}u, {stale}u, {}, {}, {}}};",
            numbers.join(", "),
            ends.join(", "),
            are[0],
            are[1],
            are[2]
        )
    });
    let valid = |one: &Watched| match failsafe.stale_after {
        0.0 => "1".to_owned(),
        after => {
            let (name, most) = (one.name(), tables.real.literal(after + one.sensor.period));
            format!("in->{name}_age >= 0.0@f@ && in->{name}_age <= {most}")
        }
    };
    let force = |one: &Watched| match design.source(one.input.signal) {
        Some(Source::Commands { .. }) => format!("force(GAINS_{}, state)", one.name().to_ascii_uppercase()),
        _ => "0.0@f@".to_owned(),
    };
    let judge = all.iter().map(|one| {
        let (name, upper) = (one.name(), one.name().to_ascii_uppercase());
        let signal = &design.signals[one.input.signal];
        let value = near(signal, format!("in->{name}"), &format!("all->watched_{name}.believed"));
        format!(
            "        all->changed |= judge(&all->watched_{name}, &SENSOR_{upper}, {value},\n            {}, {}, {});",
            force(one),
            valid(one),
            is_expected(design, one)
        )
    });
    let believe = all.iter().map(|one| {
        let (name, bit) = (one.name(), one.bit());
        let lost = match one.without {
            Without::Speed => format!("lost |= {bit};"),
            Without::Nothing => format!("lost |= {bit} | @PREFIX@_FAILED;"),
            Without::Reckoned if holds(design, one.input.signal) => {
                let wanted = reference(&design.signals[one.input.signal]);
                format!(
                    "{{\n        /* the target for which the reference stays where it is */\n        \
                     const real share = state->way_{wanted}.share, last = state->last_{wanted};\n        \
                     lost |= {bit};\n        used->{wanted} = share < 1.0@f@ ? \
                     (last - share * state->way_{wanted}.start) / (1.0@f@ - share) : last;\n    }}"
                )
            }
            Without::Reckoned => format!("lost |= {bit};"),
        };
        format!(
            "    used->{name} = all->watched_{name}.believed;\n    if (all->watched_{name}.lost_for > 0u) {lost}"
        )
    });
    let has_force = |one: &Watched| matches!(design.source(one.input.signal), Some(Source::Commands { .. }));
    let with_force = if all.iter().any(has_force) { include_str!("template/force.c") } else { "" };
    let expect = all.iter().filter_map(|one| expected(design, one));
    let fields = [
        ("force", with_force.to_owned()),
        ("sensors", lines(constants)),
        ("expect", lines(expect)),
        ("judge", lines(judge)),
        ("believe", lines(believe)),
    ];
    fill(include_str!("template/sensors.c"), &fields)
}

/// Whether a sensor is expected to say something: not while the one of its rate is lost.
fn is_expected(design: &ControllerDesign, one: &Watched) -> String {
    match design.source(one.input.signal) {
        Some(Source::Rate(rate)) => format!("all->watched_{rate}.lost_for == 0u"),
        _ => "1".to_owned(),
    }
}

/// What moves what is expected of a sensor that is lost, and by how much it should have moved.
fn expected(design: &ControllerDesign, one: &Watched) -> Option<String> {
    let (name, signal) = (one.name(), &design.signals[one.input.signal]);
    let watched = format!("all->watched_{name}");
    let mut text = String::new();
    let source = design.source(one.input.signal);
    let rate = match source {
        Some(Source::Commands { time, .. }) => {
            let upper = name.to_ascii_uppercase();
            Some(format!("force(GAINS_{upper}, state) - {watched}.anchor - {watched}.moved / {time:?}@f@"))
        }
        Some(Source::Rate(other)) => {
            let is_expected = is_expected(design, one);
            Some(format!("{is_expected} ? all->watched_{other}.believed : 0.0@f@"))
        }
        _ => rate(design, signal, |other| format!("all->watched_{other}.believed")),
    };
    if let Some(rate) = rate {
        text += &format!(
            "        const real step_{name} = TICK * ({rate});\n        {watched}.moved += step_{name};\n"
        );
    }
    let next = match one.without {
        Without::Speed if !design.speed_given => {
            let last = format!("last_{}", reference(signal));
            let wanted = if design.reference_filter.is_some() { "filtered_speed" } else { &last };
            format!("RETURNING * (state->{wanted} - {watched}.believed)")
        }
        Without::Reckoned => format!("step_{name}"),
        _ => return (!text.is_empty()).then(|| text.trim_end().to_owned()),
    };
    Some(format!("{text}        if ({watched}.lost_for > 0u) {watched}.believed += {next};"))
}

/// What a step begins with: the sensors that are believed, or the safe commands.
pub(crate) fn look(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_some() { include_str!("template/look.c") } else { "" }
}

/// What the state has of the sensors after a reset.
pub(crate) fn reset(design: &ControllerDesign) -> String {
    let all = watched(design);
    let each = all.iter().map(|one| {
        let name = one.name();
        let value = format!("in->{name}");
        format!(
            "    fresh.sensors.watched_{name} =\n        \
             (@prefix@_watched){{{value}, {value}, {value}, 0.0@f@, 0.0@f@, NEVER, 0u, 0u, 0u}};\n"
        )
    });
    let first = "    for (int j = 0; j < COMMANDS; j++) fresh.sensors.from[j] = t.commands[j];\n    \
                 fresh.sensors.failed_for = 0u;\n    fresh.sensors.changed = 0;\n    fresh.sensors.judged = 0;\n";
    if all.is_empty() { String::new() } else { first.to_owned() + &each.collect::<String>() }
}

/// What a step ends with.
pub(crate) fn keep(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_none() {
        return "";
    }
    "    all.failed_for = 0u;
    all.changed = 0;
    all.judged = 0;
    state->sensors = all;
    t.status |= lost;
"
}

/// How what follows others takes the sensors.
pub(crate) fn follow(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_some() {
        include_str!("template/follow_with_sensors.c")
    } else {
        "    return follow(state, in, got);\n"
    }
}

/// That nothing is fed back while the commands go to the safe ones.
pub(crate) fn if_failed(design: &ControllerDesign) -> String {
    let fails = watched(design).into_iter().filter(|one| one.without == Without::Nothing);
    let each: Vec<String> =
        fails.map(|one| format!("state->sensors.watched_{}.lost_for > 0u", one.name())).collect();
    if each.is_empty() {
        String::new()
    } else {
        format!("    if ({}) return @PREFIX@_OK;\n", each.join(" || "))
    }
}

/// What a reader of the header has to know.
pub(crate) fn about(design: &ControllerDesign) -> &'static str {
    if design.failsafe.is_none() {
        return "Measurements are taken as they come: this design has no limits to what its sensors may say.";
    }
    "Sensors: each measurement has an age, 0 if it is not given. A sensor is lost if its value is older than \
     STALE_AFTER and its period or of the future, is the same for so long and should have moved by several of its \
     steps, is not finite or out of its range, or moves faster than the vehicle can; the status has its bit. It is \
     believed again after half a second in which it was plausible; one that was stuck or elsewhere, and whose rate is \
     measured, has to agree while the vehicle moves by more than its error. Without the speed its loop is open; \
     without the depth it is reckoned from pitch and speed, and its reference held; pitch and heading are reckoned \
     from their measured rates; without anything else the commands go to the safe ones in half a second, FAILED, \
     whatever the references are. When a sensor comes back the first command is the last one. Nothing is proved of a \
     loop without a sensor."
}
