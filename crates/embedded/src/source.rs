//! The source: tables of numbers, and the operations of a tick in the order of [`squid_scheduled::Autopilot`].

use crate::inputs::{Input, has_rate, inputs, keeps_commands, near, origins, reference, references};
use crate::library::{functions, of_library};
use crate::real::Real;
use crate::references::{ends, is_speed, keep_references, limited, scheduled, wanted_speed};
use crate::tables::{Tables, column};
use crate::template::{fill, lines};
use crate::{failsafe, follow, governor};
use squid_scheduled::{
    Actuator, ControllerDesign, FARTHEST, Kind, Level, OverSpeed, Port, RETURNING, ROUNDING_OF_RHO,
};
use squid_signals::Law;
use std::f64::consts::TAU;

/// What stands in for [`FARTHEST`] and [`ROUNDING_OF_RHO`] where a float cannot hold the one, or rounds by more than
/// the other.
const FARTHEST_FLOAT: f64 = 1e30;
const ROUNDING_OF_RHO_FLOAT: f64 = 1e-6;

type Fields = [(&'static str, String)];

pub(crate) fn source(design: &ControllerDesign, tables: &Tables, fields: &Fields) -> String {
    let sizes = tables.sizes();
    let rows = design.trim.speed.len();
    let math = functions(design, tables.real);
    let all_finite =
        join(&inputs(design), " &&\n          ", |input| format!("is_finite(in->{})", input.name));
    let own = vec![
        (
            "libm",
            if math.is_empty() {
                " * No function of a library is called.".to_owned()
            } else {
                format!(" * {}", of_library(&math))
            },
        ),
        ("include_math", if math.is_empty() { String::new() } else { "#include <math.h>".to_owned() }),
        ("n", sizes.states.to_string()),
        ("p", sizes.inputs.to_string()),
        ("r", sizes.channels.to_string()),
        ("m", sizes.outputs.to_string()),
        (
            "channel_panels",
            match sizes.channels {
                0 => String::new(),
                _ => "enum { CHANNEL_PANELS = (CHANNELS + 3) / HEIGHT };".to_owned(),
            },
        ),
        ("rows", rows.to_string()),
        // The last row that begins a piece of the table is ROWS - 2.
        ("stride", (rows - 2).checked_ilog2().map_or(0, |power| 1usize << power).to_string()),
        ("tables", numbers(design, tables)),
        (
            "limit",
            if ends(design).iter().any(|(_, end)| matches!(end, OverSpeed::Table(_))) {
                include_str!("template/limit.c").to_owned()
            } else {
                String::new()
            },
        ),
        (
            "nearest",
            if design.signals.iter().any(|signal| signal.circular) {
                include_str!("template/nearest.c").to_owned()
            } else {
                String::new()
            },
        ),
        ("solvers", solvers(tables)),
        ("curves", curves(design)),
        ("all_finite", all_finite.clone()),
        ("first", first(design, tables.real)),
        ("follow", follow::functions(design, tables, &all_finite)),
        ("end_of_transitions", governor::govern(design, tables)),
        (
            "fade",
            references(design)
                .next()
                .map_or_else(String::new, |_| include_str!("template/fade.c").to_owned())
                + failsafe::path(design),
        ),
        ("keep_commands", keep_commands(design, "state->")),
        ("y", y(design, tables.real)),
        ("close_loop", close_loop(tables)),
        ("put_out", put_out(design, tables.real, "commands")),
        ("level", level(design, tables)),
        (
            "origins",
            lines(
                origins(design)
                    .map(|Port { name, .. }| format!("    fresh.origin_{name} = in->{name};"))
                    .chain([governor::reset(design)]),
            ),
        ),
        ("trim_members", lines(trims(design).map(|name| format!("    real trim_{name};")))),
        (
            "trims",
            lines(trims(design).map(|name| {
                let column = column(name);
                format!("    t->trim_{name} = between({column}[row], {column}[row + 1], part);")
            })),
        ),
        (
            "put_out_trims",
            lines(design.trimmed().map(|index| {
                let name = &design.signals[index].name;
                format!("    out->trim_{name} = t->trim_{name};")
            })),
        ),
        ("speed", scheduled(design).name.clone()),
        ("reset", reset(design)),
        (
            "filtered_speed",
            match design.reference_filter {
                Some(_) => format!("is_reset ? {} : state->filtered_speed", wanted_speed(design)),
                None => wanted_speed(design),
            },
        ),
        (
            "wanted_speed",
            references(design)
                .filter(|one| is_speed(design, *one))
                .map(|(_, one)| limited(design, one))
                .collect(),
        ),
        (
            "references",
            references(design)
                .filter(|one| !is_speed(design, *one))
                .map(|(_, one)| limited(design, one))
                .collect(),
        ),
        (
            "used_members",
            lines(references(design).map(|(_, one)| format!("    real {0}, target_{0};", reference(one)))),
        ),
        ("held", governor::functions(design)),
        ("ahead", governor::ahead(design)),
        ("limits", governor::limits(design)),
        ("saturated_first", format!("{:#x}u", governor::SATURATED_FIRST)),
        (
            "put_out_references",
            lines(references(design).map(|(_, one)| format!("    out->{0}_used = t->{0};", reference(one)))),
        ),
        ("keep_references", keep_references(design, "state->")),
        ("anti_windup", anti_windup(tables)),
        ("delay", if design.delay_ticks == 0 { String::new() } else { DELAY.to_owned() }),
        (
            "filter",
            match tables.autopilot.filter() {
                None => String::new(),
                Some(_) => {
                    let wanted = wanted_speed(design).replacen("t->", "t.", 1);
                    format!("    state->filtered_speed += FILTER * ({wanted} - state->filtered_speed);")
                }
            },
        ),
        ("functions_of_sensors", failsafe::functions(design, tables)),
        ("look", failsafe::look(design).to_owned()),
        ("keep_sensors", failsafe::keep(design).to_owned()),
        ("safe", safe(design, tables.real)),
    ];
    fill(&fill(include_str!("template/autopilot.c"), &own), fields)
}

/// The signals whose trim is needed: those that are put out, and those from whose trim an input is a deviation.
fn trims(design: &ControllerDesign) -> impl Iterator<Item = &String> {
    let used = |name: &String| {
        let inputs = design.controller_inputs.iter().filter(|input| input.kind != Kind::Error);
        inputs.into_iter().any(|input| input.signal == *name)
    };
    let needed = move |(place, signal): &(usize, &Port)| {
        signal.level == Level::Trim && (design.trimmed().any(|one| one == *place) || used(&signal.name))
    };
    design.signals.iter().enumerate().filter(needed).map(|(_, signal)| &signal.name)
}

/// The condition that an input has a value that it cannot have at a reset.
fn first(design: &ControllerDesign, real: Real) -> String {
    let beyond = |input: &Input| {
        let [least, most] = design.signals[input.signal].first(!input.measured)?.map(|end| real.literal(end));
        Some(format!("!(in->{0} >= {least} && in->{0} <= {most})", input.name))
    };
    let all: Vec<String> = inputs(design).iter().filter_map(beyond).collect();
    if all.is_empty() {
        return String::new();
    }
    format!("    if ({}) return @PREFIX@_BAD_INPUT;\n", all.join(" ||\n        "))
}

fn join<T>(items: &[T], between: &str, each: impl Fn(&T) -> String) -> String {
    items.iter().map(each).collect::<Vec<_>>().join(between)
}

fn numbers(design: &ControllerDesign, tables: &Tables) -> String {
    let trim = &design.trim;
    let of = |part: fn(&Actuator) -> f64| design.actuators.iter().map(part).collect::<Vec<_>>();
    let mut text = tables.matrices();
    text += &tables.column("FORWARD_SPEED", &trim.forward_speed);
    text += &tables.column("SPEED", &trim.speed);
    for name in trims(design) {
        text += &tables.column(&column(name), &trim.signals[name]);
    }
    for (name, end) in ends(design) {
        text += &match end {
            OverSpeed::Constant(value) => {
                format!("static const real {name} = {};\n", tables.real.literal(*value))
            }
            OverSpeed::Table(column) => tables.column(&name, column),
        };
    }
    text += &follow::gains(tables);
    text += &failsafe::numbers(design, tables);
    text += &governor::numbers(design, tables);
    text += &tables.table("TRIM", &trim.actuators);
    text += &tables.column("SCALE", &of(|actuator| actuator.scale));
    text += &tables.column("MINIMUM", &of(|actuator| actuator.minimum));
    text += &tables.column("MAXIMUM", &of(|actuator| actuator.maximum));
    let (steps, open) = tables.autopilot.opening();
    text += &tables.column("OPENING", steps);
    text += &format!("enum {{ OPEN = {open} }};\n");
    text += &tables.column("LARGEST_APPLIED", &of(Actuator::largest_applied));
    for (index, actuator) in design.actuators.iter().enumerate() {
        if let Some(Law::Points(points)) = actuator.curve.as_ref().map(squid_signals::Curve::law) {
            let points: Vec<Vec<f64>> = points.iter().map(|point| point.to_vec()).collect();
            text += &tables.table(&format!("CURVE_{index}"), &points);
        }
    }
    let double = tables.real == Real::Double;
    let turns = design.signals.iter().any(|signal| signal.circular);
    let is_timed = references(design).any(|(_, signal)| has_rate(design, signal));
    let returning = references(design).next().map(|(place, _)| tables.autopilot.returning(place));
    let scalars = [
        ("TURN", turns.then_some(TAU)),
        ("CENTRE", Some(design.scheduling.centre)),
        ("HALF_RANGE", Some(design.scheduling.half_range)),
        ("FILTER", tables.autopilot.filter()),
        ("FARTHEST", Some(if double { FARTHEST } else { FARTHEST_FLOAT })),
        ("ROUNDING_OF_RHO", Some(if double { ROUNDING_OF_RHO } else { ROUNDING_OF_RHO_FLOAT })),
        ("PRECISION", precision(tables)),
        ("FADE", returning.map(|all| all.0)),
        ("FADE_STEP", returning.map(|_| design.sample_time / RETURNING)),
        ("FADE_TIME", returning.map(|_| RETURNING)),
        (
            "TICK",
            (design.failsafe.is_some() || is_timed || returning.is_some()).then_some(design.sample_time),
        ),
    ];
    for (name, value) in scalars {
        let line = |value| format!("static const real {name} = {};\n", tables.real.literal(value));
        text += &value.map_or_else(String::new, line);
    }
    text + &format!("static const real LARGEST = {};\n", if double { "DBL_MAX" } else { "FLT_MAX" })
}

/// The relative precision of the solution of the loop, if there is one.
fn precision(tables: &Tables) -> Option<f64> {
    let channels = tables.sizes().channels;
    (channels > 0).then_some(channels as f64 * tables.real.epsilon())
}

fn solvers(tables: &Tables) -> String {
    let blocks = tables.blocks();
    let parts = [
        (!blocks.is_empty(), include_str!("template/solve.c")),
        (blocks.iter().any(|(_, two)| !two), include_str!("template/solve_one.c")),
        (blocks.iter().any(|(_, two)| *two), include_str!("template/solve_two.c")),
    ];
    let text: String = parts.iter().filter(|(needed, _)| *needed).map(|(_, text)| *text).collect();
    text
}

fn curves(design: &ControllerDesign) -> String {
    let laws: Vec<&Law> = design.actuators.iter().filter_map(|a| a.curve.as_ref()).map(|c| c.law()).collect();
    let parts = [
        (laws.iter().any(|law| matches!(law, Law::Points(_))), include_str!("template/points.c")),
        (laws.iter().any(|law| matches!(law, Law::Points(_))), include_str!("template/given.c")),
        (laws.iter().any(|law| matches!(law, Law::Square(_))), include_str!("template/square.c")),
    ];
    parts.iter().filter(|(needed, _)| *needed).map(|(_, text)| *text).collect()
}

/// The lines that compute y.
fn y(design: &ControllerDesign, real: Real) -> String {
    let line = |(index, input): (usize, &squid_scheduled::ControllerInput)| {
        let name = &input.signal;
        let signal = design.signals.iter().find(|signal| signal.name == *name);
        let reference =
            signal.and_then(|signal| signal.reference.as_ref()).map_or("", |reference| &reference.name);
        let measured = format!("in->{name}");
        let measured = match signal {
            Some(signal) => near(signal, measured, &format!("t->{reference}")),
            None => measured,
        };
        let taken = match input.kind {
            Kind::Error => {
                let scale = real.literal(input.scale);
                return format!("    y[{index}] = (t->{reference} - {measured}) / {scale};\n");
            }
            Kind::Reference => format!("t->{reference}"),
            Kind::Measurement => measured,
        };
        let level = match signal.map(|signal| (signal.level, signal.start)) {
            Some((Level::Trim, _)) => format!("({taken} - t->trim_{name})"),
            Some((Level::Scheduled, _)) => format!("({taken} - filtered_speed)"),
            Some((Level::Start, _)) if origins(design).any(|one| one.name == *name) => {
                format!("({taken} - state->origin_{name})")
            }
            Some((Level::Start, start)) => format!("({taken} - {})", real.literal(start)),
            Some((Level::Zero, _)) | None => taken,
        };
        format!("    y[{index}] = {level} / {};\n", real.literal(input.scale))
    };
    design.controller_inputs.iter().enumerate().map(line).collect()
}

fn close_loop(tables: &Tables) -> String {
    let blocks = tables.blocks();
    if blocks.is_empty() {
        return String::new();
    }
    let solved = join(&blocks, " ||\n        ", |(row, two)| {
        format!("!{}({row}, theta, z)", if *two { "solve_two" } else { "solve_one" })
    });
    format!(
        "    real z[HEIGHT * CHANNEL_PANELS];\n\
         \x20   multiply(INTO_LOOP, CHANNEL_PANELS, STATES + INPUTS, t->signals, z);\n\
         \x20   if ({solved}) return @PREFIX@_SINGULAR;\n\
         \x20   for (int i = 0; i < CHANNELS; i++) y[INPUTS + i] = theta * z[i];\n"
    )
}

/// The lines that put out commands.
fn put_out(design: &ControllerDesign, real: Real, commands: &str) -> String {
    let line = |(index, actuator): (usize, &Actuator)| {
        let command = format!("{commands}[{index}]");
        let taken = match actuator.curve.as_ref().map(|curve| (curve, curve.law())) {
            None => command,
            Some((_, Law::Square(k))) => format!("square({}, {command})", real.literal(*k)),
            Some((curve, Law::Points(points))) => {
                let at_rest = real.literal(curve.command(0.0).0);
                format!("through(CURVE_{index}, {}, {at_rest}, {command})", points.len())
            }
        };
        format!("    out->{} = {taken};\n", actuator.name)
    };
    design.actuators.iter().enumerate().map(line).collect()
}

/// The inputs in level flight at the middle of the speeds, in the order of the struct.
fn level(design: &ControllerDesign, tables: &Tables) -> String {
    let level = tables.autopilot.level(design.scheduling.centre);
    let ages = failsafe::watched(design).into_iter().map(|_| 0.0);
    tables.real.list(inputs(design).iter().map(|input| level.measured[input.signal]).chain(ages))
}

/// The commands as they were put out, for what feeds back what the actuators got.
fn keep_commands(design: &ControllerDesign, state: &str) -> String {
    if keeps_commands(design) {
        format!("    for (int j = 0; j < COMMANDS; j++) {state}put_out[j] = t.commands[j];")
    } else {
        String::new()
    }
}

/// The function that says what the safe commands are.
fn safe(design: &ControllerDesign, real: Real) -> String {
    if design.failsafe.is_none() {
        return String::new();
    }
    let lines = put_out(design, real, "SAFE");
    format!("void @prefix@_safe(@prefix@_commands *out)\n{{\n{lines}}}\n")
}

fn reset(design: &ControllerDesign) -> String {
    let mut text = keep_commands(design, "fresh.") + "\n";
    if design.reference_filter.is_some() {
        text += &format!("    fresh.filtered_speed = {};\n", wanted_speed(design).replacen("t->", "t.", 1));
    }
    text += &(keep_references(design, "fresh.") + "\n");
    text += governor::note(design);
    if design.delay_ticks > 0 {
        text += "    fresh.next = 0;\n\
                 \x20   for (int k = 0; k < @PREFIX@_DELAY_TICKS; k++)\n\
                 \x20       for (int j = 0; j < COMMANDS; j++) fresh.waiting[k][j] = t.commands[j];\n";
    }
    text + &failsafe::reset(design)
}

/// The commands of this tick wait, and those of as many ticks ago as the delay says come out.
const DELAY: &str = "    for (int j = 0; j < COMMANDS; j++) {
        const real due = state->waiting[state->next][j];
        state->waiting[state->next][j] = t.commands[j];
        t.commands[j] = due;
    }
    state->next = state->next + 1 == @PREFIX@_DELAY_TICKS ? 0 : state->next + 1;
";

fn anti_windup(tables: &Tables) -> String {
    if tables.autopilot.anti_windup().is_none() {
        return String::new();
    }
    "    if ((t.status & @PREFIX@_SATURATED) != 0u)
        for (int i = 0; i < STATES; i++) {
            real push = -0.0@f@;
            for (int j = 0; j < COMMANDS; j++) push += ANTI_WINDUP[i][j] * t.excess[j];
            state->x[i] += push;
        }
"
    .to_owned()
}
