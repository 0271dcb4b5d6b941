//! How references move that are not used as they are asked, in the order of the autopilot's reference governor.

use crate::inputs::{near, reference, references};
use crate::tables::Tables;
use crate::template::lines;
use squid_scheduled::{ControllerDesign, HELD, Port};

/// The bit of the status of a command of the first actuator that is at its limit; that of the next is twice as large.
pub(crate) const SATURATED_FIRST: u32 = 0x10000;

/// The actuators for which the status has bits.
pub(crate) const MOST_ACTUATORS: usize = 16;

/// The bits of the status of commands at their limits, a line each.
pub(crate) fn bits(design: &ControllerDesign) -> String {
    let bit = |(index, one): (usize, &squid_scheduled::Actuator)| {
        let (name, bit) = (one.name.to_ascii_uppercase(), SATURATED_FIRST << index);
        format!("#define @PREFIX@_SATURATED_{name} {bit:#x}u")
    };
    lines(design.actuators.iter().enumerate().map(bit))
}

/// The bits of the status of all commands at their limits.
pub(crate) fn all_saturated(design: &ControllerDesign) -> u32 {
    ((1 << design.actuators.len()) - 1) * SATURATED_FIRST
}

/// Whether any reference yields at a limit of an actuator.
pub(crate) fn is_needed(design: &ControllerDesign) -> bool {
    references(design).any(|(place, signal)| steers(design, place, signal).next().is_some())
}

/// The actuators at whose limits a reference yields.
fn steers<'a>(
    design: &'a ControllerDesign,
    place: usize,
    signal: &'a Port,
) -> impl Iterator<Item = usize> + 'a {
    let measured = design.measures(place);
    let all = design.actuators.iter().enumerate();
    all.filter(move |(_, one)| measured && one.steers.contains(&signal.name)).map(|(index, _)| index)
}

/// Whether a reference yields, as an expression; `None` of one that never does.
pub(crate) fn yields(design: &ControllerDesign, signal: &Port) -> Option<String> {
    let place = design.index(&signal.name)?;
    let all: Vec<String> =
        steers(design, place, signal).map(|index| format!("held(state, {index})")).collect();
    (!all.is_empty()).then(|| all.join(" || "))
}

/// The type of a transition.
pub(crate) fn way(design: &ControllerDesign) -> &'static str {
    references(design).next().map_or("", |_| include_str!("template/way.h"))
}

/// Members of the state.
pub(crate) fn members(design: &ControllerDesign) -> String {
    let each = references(design).map(|(_, signal)| {
        let name = reference(signal);
        format!("    @prefix@_transition way_{name}; /* of {name} to what is asked */\n")
    });
    let m = design.actuators.len();
    let at_limit = format!(
        "    int held[{m}]; /* twice the ticks for which each command was beyond its limit, less those since, and 1 if \
         it is */\n"
    );
    each.chain(is_needed(design).then_some(at_limit)).collect()
}

/// What the state has after a reset.
pub(crate) fn reset(design: &ControllerDesign) -> String {
    let each = references(design).map(|(_, signal)| reference(signal));
    lines(each.map(|name| {
        format!("    fresh.way_{name} = (@prefix@_transition){{0.0@f@, 0.0@f@, 0.0@f@, 0.0@f@}};")
    }))
}

/// Notes which commands are beyond their limits after a reset, without counting a tick.
pub(crate) fn note(design: &ControllerDesign) -> &'static str {
    if is_needed(design) {
        "    for (int j = 0; j < COMMANDS; j++) fresh.held[j] = t.excess[j] != 0.0@f@;\n"
    } else {
        ""
    }
}

/// Numbers of the source.
pub(crate) fn numbers(design: &ControllerDesign, tables: &Tables) -> String {
    if !is_needed(design) {
        return String::new();
    }
    let (yielding, held) = tables.autopilot.yielding();
    let yielding = tables.real.literal(yielding);
    let mut text = format!("static const real YIELDING = {yielding};\nenum {{ HELD = {held} }};\n");
    if pushes_one_way(design) {
        let pushes: Vec<f64> = design.actuators.iter().map(squid_scheduled::Actuator::pushes).collect();
        text += &tables.column("PUSHES", &pushes);
    }
    text
}

/// Whether any thruster pushes one way only while another actuator steers at its limit.
fn pushes_one_way(design: &ControllerDesign) -> bool {
    is_needed(design) && design.actuators.iter().any(|one| one.pushes() != 0.0)
}

/// The speed against which no thruster pushes.
pub(crate) fn ahead(design: &ControllerDesign) -> String {
    if !pushes_one_way(design) {
        return String::new();
    }
    let steers = |index: &usize| {
        references(design).any(|(place, signal)| steers(design, place, signal).any(|one| one == *index))
    };
    let steering = (0..design.actuators.len()).filter(steers);
    let steering: Vec<String> =
        steering.map(|index| format!("is_beyond(is_reset ? 0 : state, t->commands, {index})")).collect();
    format!(
        "    /* While one steers at its limit, a thruster that does not steer pushes V_r's way only. */\n    \
         const real ahead = {} ? filtered_speed : 0.0@f@;",
        steering.join(" || ")
    )
}

/// The limits of command j.
pub(crate) fn limits(design: &ControllerDesign) -> String {
    if !pushes_one_way(design) {
        return "        const real low = MINIMUM[j], high = MAXIMUM[j];".to_owned();
    }
    "        const real way = ahead * PUSHES[j];
        const real low = way > 0.0@f@ ? greater(MINIMUM[j], lesser(level[j], 0.0@f@)) : MINIMUM[j];
        const real high = way < 0.0@f@ ? lesser(MAXIMUM[j], greater(level[j], 0.0@f@)) : MAXIMUM[j];"
        .to_owned()
}

/// The functions.
pub(crate) fn functions(design: &ControllerDesign) -> String {
    let parts = [
        (is_needed(design), include_str!("template/held.c")),
        (pushes_one_way(design), include_str!("template/one_way.c")),
    ];
    parts.iter().filter(|(needed, _)| *needed).map(|(_, text)| *text).collect()
}

/// The lines that move references on, and count saturated ticks, at the end of a tick.
pub(crate) fn govern(design: &ControllerDesign, tables: &Tables) -> String {
    let each = references(design).map(|(place, signal)| {
        let name = reference(signal);
        let negligible = tables.real.literal(tables.autopilot.returning(place).1);
        let fade = format!("fade(&state->way_{name}, t.target_{name}, {negligible});");
        match yields(design, signal) {
            None => format!("    {fade}"),
            Some(yields) => format!(
                "    if ({yields})\n        \
                 state->way_{name} = (@prefix@_transition){{t.{name}, 0.0@f@, 1.0@f@, 1.0@f@}};\n    \
                 else\n        {fade}"
            ),
        }
    });
    let count = is_needed(design).then(|| "    count(state, t.excess);".to_owned());
    lines(each.chain(count))
}

/// The value to which a reference yields, before its range.
pub(crate) fn yielded(signal: &Port) -> String {
    let last = format!("state->last_{}", reference(signal));
    let measured = near(signal, format!("in->{}", signal.name), &last);
    format!("{last} + YIELDING * ({measured} - {last})")
}

/// What a reader of the header has to know.
pub(crate) fn about(design: &ControllerDesign) -> String {
    let signals: Vec<&str> = references(design)
        .filter(|(place, signal)| steers(design, *place, signal).next().is_some())
        .map(|(_, signal)| signal.name.as_str())
        .collect();
    if signals.is_empty() {
        return "Commands are cut off at their limits, and the status has SATURATED and the bit of the actuator."
            .to_owned();
    }
    format!(
        "Commands are cut off at their limits, and the status has SATURATED and the bit of the actuator. While an \
         actuator that steers stays at its limit for longer than {HELD} s, the reference of {} yields to what is \
         measured, so that the speed is kept and nothing winds up; after that it returns to what is asked through \
         two lags of 1 s, within its rate. What is proved is of references as they are used.",
        signals.join(" and ")
    )
}
