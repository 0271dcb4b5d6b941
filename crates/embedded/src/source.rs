//! The source: tables of numbers, and the operations of a tick in the order of [`scheduled::Autopilot`].

use crate::header::{Input, has_depth, inputs, stuck_bit};
use crate::library::{functions, of_library};
use crate::real::Real;
use crate::tables::Tables;
use crate::template::fill;
use scheduled::{Actuator, ControllerDesign, FARTHEST, Kind, ROUNDING_OF_RHO};
use signals::{Law, SIGNALS, STATES, place};

/// What stands in for [`FARTHEST`] and [`ROUNDING_OF_RHO`] where a float cannot hold the one, or rounds by more than
/// the other.
const FARTHEST_FLOAT: f64 = 1e30;
const ROUNDING_OF_RHO_FLOAT: f64 = 1e-6;

type Fields = [(&'static str, String)];

pub(crate) fn source(design: &ControllerDesign, tables: &Tables, fields: &Fields) -> String {
    let sizes = tables.sizes();
    let rows = design.trim.speed.len();
    let math = functions(design, tables.real);
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
        ("solvers", solvers(tables)),
        ("curves", curves(design)),
        (
            "all_finite",
            join(&inputs(design), " &&\n          ", |input| format!("is_finite(in->{})", input.name)),
        ),
        ("y", y(design, tables.real)),
        ("close_loop", close_loop(tables)),
        ("put_out", put_out(design, tables.real)),
        ("level", level(design, tables)),
        (
            "depth_zero",
            if has_depth(design) { "    fresh.depth_zero = in->depth;".to_owned() } else { String::new() },
        ),
        ("wanted", if design.speed_given { "speed" } else { "speed_reference" }.to_owned()),
        ("reset", reset(design)),
        (
            "filtered_speed",
            match (design.reference_filter, design.speed_given) {
                (Some(_), _) => "state->filtered_speed",
                (None, true) => "in->speed",
                (None, false) => "in->speed_reference",
            }
            .to_owned(),
        ),
        ("anti_windup", anti_windup(tables)),
        ("delay", if design.delay_ticks == 0 { String::new() } else { DELAY.to_owned() }),
        (
            "filter",
            match tables.autopilot.filter() {
                None => String::new(),
                Some(_) => {
                    "    state->filtered_speed += FILTER * (in->speed_reference - state->filtered_speed);"
                        .to_owned()
                }
            },
        ),
        ("watch", watch(design)),
    ];
    fill(&fill(include_str!("template/autopilot.c"), &own), fields)
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
    text += &tables.column("PITCH", &trim.pitch);
    text += &tables.table("TRIM", &trim.actuators);
    text += &tables.column("SCALE", &of(|actuator| actuator.scale));
    text += &tables.column("MINIMUM", &of(|actuator| actuator.minimum));
    text += &tables.column("MAXIMUM", &of(|actuator| actuator.maximum));
    for (index, actuator) in design.actuators.iter().enumerate() {
        if let Some(Law::Points(points)) = actuator.curve.as_ref().map(signals::Curve::law) {
            let points: Vec<Vec<f64>> = points.iter().map(|point| point.to_vec()).collect();
            text += &tables.table(&format!("CURVE_{index}"), &points);
        }
    }
    let double = tables.real == Real::Double;
    let scalars = [
        ("CENTRE", Some(design.scheduling.centre)),
        ("HALF_RANGE", Some(design.scheduling.half_range)),
        ("FILTER", tables.autopilot.filter()),
        ("FARTHEST", Some(if double { FARTHEST } else { FARTHEST_FLOAT })),
        ("ROUNDING_OF_RHO", Some(if double { ROUNDING_OF_RHO } else { ROUNDING_OF_RHO_FLOAT })),
        ("PRECISION", precision(tables)),
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
        (laws.iter().any(|law| matches!(law, Law::Square(_))), include_str!("template/square.c")),
    ];
    parts.iter().filter(|(needed, _)| *needed).map(|(_, text)| *text).collect()
}

/// The lines that compute y.
fn y(design: &ControllerDesign, real: Real) -> String {
    let line = |(index, input): (usize, &scheduled::ControllerInput)| {
        let name = &input.signal;
        let taken = match input.kind {
            Kind::Error => {
                return format!(
                    "    y[{index}] = (in->{name}_reference - in->{name}) / {};\n",
                    real.literal(input.scale)
                );
            }
            Kind::Reference => format!("in->{name}_reference"),
            Kind::Measurement => format!("in->{name}"),
        };
        let level = match place(name).map_or("", |place| STATES[SIGNALS[place].state].symbol) {
            "theta" => format!("({taken} - t->trim_pitch)"),
            "u" => format!("({taken} - filtered_speed)"),
            "w" => format!("({taken} - filtered_speed * tan@f@(t->trim_pitch))"),
            "z" if has_depth(design) => format!("({taken} - state->depth_zero)"),
            "z" => format!("({taken} - {})", real.literal(design.depth)),
            _ => taken,
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

fn put_out(design: &ControllerDesign, real: Real) -> String {
    let line = |(index, actuator): (usize, &Actuator)| {
        let command = format!("t->commands[{index}]");
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
    let trim = tables.autopilot.trim();
    let signals = trim.signals(trim.forward_speed(design.scheduling.centre), design.depth);
    tables.real.list(inputs(design).iter().map(|input| signals[input.signal]))
}

fn measured(design: &ControllerDesign) -> Vec<Input> {
    inputs(design).into_iter().filter(|input| input.measured).collect()
}

fn reset(design: &ControllerDesign) -> String {
    let mut text = String::new();
    if design.reference_filter.is_some() {
        text += "    fresh.filtered_speed = in->speed_reference;\n";
    }
    if design.delay_ticks > 0 {
        text += "    fresh.next = 0;\n\
                 \x20   for (int k = 0; k < @PREFIX@_DELAY_TICKS; k++)\n\
                 \x20       for (int j = 0; j < COMMANDS; j++) fresh.waiting[k][j] = t.commands[j];\n";
    }
    for Input { name, .. } in measured(design) {
        text += &format!("    fresh.{name}.last = in->{name};\n    fresh.{name}.ticks = 0u;\n");
    }
    text
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
    "    if ((t.status & @PREFIX@_LIMITED) != 0u)
        for (int i = 0; i < STATES; i++) {
            real push = -0.0@f@;
            for (int j = 0; j < COMMANDS; j++) push += ANTI_WINDUP[i][j] * t.excess[j];
            state->x[i] += push;
        }
"
    .to_owned()
}

fn watch(design: &ControllerDesign) -> String {
    let line = |input: &Input| {
        let Input { name, .. } = input;
        format!("    t.status |= watch(&state->{name}, in->{name}, {});\n", stuck_bit(input))
    };
    measured(design).iter().map(line).collect()
}
