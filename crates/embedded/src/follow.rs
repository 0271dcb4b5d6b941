//! What the source does with commands that are not its own, in the order of [`squid_scheduled::Autopilot::follow`].

use crate::inputs::{near, reference, references};
use crate::references::{ends, is_kept, is_speed, keep_references, limit, limit_name, wanted_speed};
use crate::tables::Tables;
use crate::template::fill;
use crate::{failsafe, governor};
use squid_scheduled::{ControllerDesign, OverSpeed, Port};
use squid_signals::{Curve, Law};

/// The functions that follow applied commands, and feed them back.
pub(crate) fn functions(design: &ControllerDesign, tables: &Tables, all_finite: &str) -> String {
    let each = |line: &dyn Fn(usize, &str) -> String, between: &str| {
        let names = design.actuators.iter().map(|actuator| actuator.name.as_str()).enumerate();
        names.map(|(index, name)| line(index, name)).collect::<Vec<_>>().join(between)
    };
    let read = |index: usize, name: &str| {
        let given = match design.actuators[index].curve.as_ref().map(Curve::law) {
            None => format!("applied->{name}"),
            Some(Law::Square(k)) => {
                format!("{} * applied->{name} * magnitude(applied->{name})", tables.real.literal(*k))
            }
            Some(Law::Points(points)) => {
                format!("given_through(CURVE_{index}, {}, applied->{name})", points.len())
            }
        };
        format!("    got[{index}] = {given};")
    };
    let fields = [
        ("applied_finite", each(&|_, name| format!("is_finite(applied->{name})"), " &&\n          ")),
        ("all_finite", all_finite.to_owned()),
        ("read", each(&read, "\n")),
        ("begin", begin(design, tables)),
        (
            "free",
            if governor::is_needed(design) {
                "    for (int j = 0; j < COMMANDS; j++) next.held[j] = 0;".to_owned()
            } else {
                String::new()
            },
        ),
        ("keep", keep_references(design, "next.")),
        ("all_saturated", format!("{:#x}u", governor::all_saturated(design))),
        ("correct", correct(tables)),
        ("wait", if design.delay_ticks == 0 { String::new() } else { WAIT.to_owned() }),
        ("feed_back", feed_back(tables)),
        ("if_failed", failsafe::if_failed(design)),
        ("follow_with_sensors", failsafe::follow(design).to_owned()),
    ];
    fill(include_str!("template/follow.c"), &fields)
}

/// The gains, one below the other.
pub(crate) fn gains(tables: &Tables) -> String {
    let rows =
        |gain: &squid_scheduled::Matrix| (0..gain.rows()).map(|i| gain.row(i).to_vec()).collect::<Vec<_>>();
    let all: Vec<_> = tables.autopilot.follow_gains().iter().flat_map(rows).collect();
    if all.is_empty() { String::new() } else { tables.table("FOLLOW", &all) }
}

/// The references where the measured values lag behind them, and V_r.
fn begin(design: &ControllerDesign, tables: &Tables) -> String {
    let line = |signal: &Port| {
        let name = reference(signal);
        let measured = design.index(&signal.name).is_some_and(|place| design.measures(place));
        let from = if measured { format!("in->{}", signal.name) } else { format!("in->{name}") };
        let from = near(signal, from, &format!("next.last_{name}"));
        let rate = rate_within(design, signal);
        let lag = signal.reference.as_ref().map_or(0.0, |one| one.lag);
        let from = format!("{from} + {} * rate_{name}", tables.real.literal(lag));
        let range = design.envelope.get(&signal.name).and_then(|limits| limits.range.as_ref());
        let used = range.map_or(from.clone(), |[least, most]| {
            format!("clamp({from}, {}, {})", limit("LEAST", signal, least), limit("MOST", signal, most))
        });
        let mut text =
            format!("    const real rate_{name} = {rate};\n    const real from_{name} = {used};\n");
        text += &format!(
            "    next.way_{name} = (@prefix@_transition){{from_{name}, rate_{name}, 1.0@f@, 1.0@f@}};\n"
        );
        if is_kept(design, signal) {
            text += &format!("    next.last_{name} = from_{name};\n");
        }
        text
    };
    let (speed, others): (Vec<_>, Vec<_>) = references(design).partition(|one| is_speed(design, *one));
    let mut text: String = speed.into_iter().map(|(_, signal)| line(signal)).collect();
    let wanted = wanted_speed(design).replacen("t->", "from_", 1);
    if design.reference_filter.is_some() {
        text += &format!("    next.filtered_speed = {wanted};\n");
    }
    let is_table = |(name, end): &(String, &OverSpeed)| {
        let is_needed = |(_, signal): (usize, &Port)| {
            let of_range = ["LEAST", "MOST"].iter().any(|end| *name == limit_name(end, signal));
            let of_rate = ["SLOWEST", "FASTEST"].iter().any(|end| *name == limit_name(end, signal));
            of_range || of_rate && has_source(design, signal)
        };
        matches!(end, OverSpeed::Table(_)) && references(design).any(is_needed)
    };
    if ends(design).iter().any(is_table) {
        text += &format!(
            "    const int row = row_at({wanted});\n    const real part = clamp(way(row, {wanted}), 0.0@f@, 1.0@f@);\n"
        );
    }
    text + &others.into_iter().map(|(_, signal)| line(signal)).collect::<String>()
}

/// Whether the rate of a signal follows from others.
fn has_source(design: &ControllerDesign, signal: &Port) -> bool {
    failsafe::rate(design, signal, |name| format!("in->{name}")).is_some()
}

/// The rate of a measured signal within that of its reference, 0 of one whose rate is not known.
fn rate_within(design: &ControllerDesign, signal: &Port) -> String {
    let Some(rate) = failsafe::rate(design, signal, |name| format!("in->{name}")) else {
        return "0.0@f@".to_owned();
    };
    let limits = design.envelope.get(&signal.name).and_then(|limits| limits.rate.as_ref());
    limits.map_or(rate.clone(), |[least, most]| {
        format!("clamp({rate}, {}, {})", limit("SLOWEST", signal, least), limit("FASTEST", signal, most))
    })
}

/// The state in which the next command is what the actuators got.
fn correct(tables: &Tables) -> String {
    let (place, gain) = match tables.autopilot.follow_gains().len() {
        0 => return String::new(),
        1 => (String::new(), "FOLLOW[i][j]"),
        values => (
            format!(
                "    const real place = 0.5@f@ * (t->scheduling_parameter + 1.0@f@) * {last}.0@f@;
    const int index = place < {before} ? (int)place : {before};
    const real share = place - (real)index;
    const real(*const low)[COMMANDS] = FOLLOW + index * STATES, (*const high)[COMMANDS] = low + STATES;",
                last = values - 1,
                before = values - 2
            ),
            "between(low[i][j], high[i][j], share)",
        ),
    };
    fill(include_str!("template/correct.c"), &[("place", place), ("gain", gain.to_owned())])
}

/// What comes out after the delay is what the actuators got.
const WAIT: &str = "    for (int k = 0; k < @PREFIX@_DELAY_TICKS; k++)
        for (int j = 0; j < COMMANDS; j++) next.waiting[k][j] = got[j];";

fn feed_back(tables: &Tables) -> String {
    if tables.autopilot.anti_windup().is_none() {
        return "    (void)state; /* this design has no anti-windup */".to_owned();
    }
    "    int differs = 0;
    for (int j = 0; j < COMMANDS; j++) {
        got[j] = (state->put_out[j] - got[j]) / SCALE[j];
        differs |= got[j] != 0.0@f@;
    }
    if (differs)
        for (int i = 0; i < STATES; i++) {
            real push = -0.0@f@;
            for (int j = 0; j < COMMANDS; j++) push += ANTI_WINDUP[i][j] * got[j];
            state->x[i] += push;
        }"
    .to_owned()
}
