//! References: what V_r follows from, their limits, and what the state keeps of them.

use crate::failsafe::needs_last;
use crate::governor;
use crate::inputs::{has_rate, near, reference, references};
use crate::template::lines;
use squid_scheduled::{ControllerDesign, Level, OverSpeed, Port, ReferenceLimits};

/// The signal that is scheduled on.
pub(crate) fn scheduled(design: &ControllerDesign) -> &Port {
    &design.signals[design.scheduled().unwrap_or_default()]
}

/// What is filtered to V_r: the reference of the speed as it is used, or the measured speed if that is imposed.
pub(crate) fn wanted_speed(design: &ControllerDesign) -> String {
    let signal = scheduled(design);
    if design.speed_given { format!("in->{}", signal.name) } else { format!("t->{}", reference(signal)) }
}

/// Whether a signal is the one that is scheduled on, whose reference gives V_r.
pub(crate) fn is_speed(design: &ControllerDesign, (index, _): (usize, &Port)) -> bool {
    Some(index) == design.scheduled()
}

/// The references as they were used, where the state keeps them.
pub(crate) fn keep_references(design: &ControllerDesign, state: &str) -> String {
    lines(kept(design).map(|one| format!("    {state}last_{0} = t.{0};", reference(one))))
}

/// The signals whose references the state keeps.
pub(crate) fn kept(design: &ControllerDesign) -> impl Iterator<Item = &Port> {
    references(design).map(|(_, signal)| signal).filter(|signal| is_kept(design, signal))
}

/// Whether the state keeps the reference of a signal.
pub(crate) fn is_kept(design: &ControllerDesign, signal: &Port) -> bool {
    signal.circular
        || has_rate(design, signal)
        || governor::yields(design, signal).is_some()
        || design.index(&signal.name).is_some_and(|place| needs_last(design, place))
}

/// The limits of the references that are followed, by their names in the source.
pub(crate) fn ends(design: &ControllerDesign) -> Vec<(String, &OverSpeed)> {
    let mut all = vec![];
    for (_, signal) in references(design) {
        let of = design.envelope.get(&signal.name);
        let range = of.and_then(|limits| limits.range.as_ref()).map(|ends| (["LEAST", "MOST"], ends));
        let rate = of.and_then(|limits| limits.rate.as_ref()).map(|ends| (["SLOWEST", "FASTEST"], ends));
        for (names, ends) in range.into_iter().chain(rate) {
            let named = names.iter().zip(ends);
            all.extend(named.map(|(name, end)| (limit_name(name, signal), end)));
        }
    }
    all
}

/// The name of a limit of a reference.
pub(crate) fn limit_name(end: &str, signal: &Port) -> String {
    format!("{end}_{}", reference(signal).to_ascii_uppercase())
}

/// A limit of a reference at V_r.
pub(crate) fn limit(name: &str, signal: &Port, end: &OverSpeed) -> String {
    let name = limit_name(name, signal);
    match end {
        OverSpeed::Constant(_) => name,
        OverSpeed::Table(_) => format!("limit({name}, row, part)"),
    }
}

/// The lines that limit a reference.
pub(crate) fn limited(design: &ControllerDesign, signal: &Port) -> String {
    let name = reference(signal);
    let none = ReferenceLimits::default();
    let limits = design.envelope.get(&signal.name).unwrap_or(&none);
    let measured = design.index(&signal.name).is_some_and(|place| design.measures(place));
    let begins = signal.level == Level::Start && measured && limits.rate.is_some();
    let asked =
        if begins { format!("(is_reset ? in->{} : in->{name})", signal.name) } else { format!("in->{name}") };
    let last = format!("is_reset ? in->{} : state->last_{name}", signal.name);
    let asked = near(signal, asked, &last);
    let within = |value: String| match &limits.range {
        None => value,
        Some([least, most]) => {
            let [least, most] = [limit("LEAST", signal, least), limit("MOST", signal, most)];
            format!("clamp({value}, {least}, {most})")
        }
    };
    let (target, on_the_way) = (
        within(asked),
        within(format!("between(t->target_{name}, state->way_{name}.start, state->way_{name}.share)")),
    );
    let mut text = format!(
        "    t->target_{name} = {target};\n    t->{name} = state->way_{name}.share == 0.0@f@ ? t->target_{name} :\n    \
                      {on_the_way};\n"
    );
    if let Some([least, most]) = &limits.rate {
        let [slowest, fastest] = [limit("SLOWEST", signal, least), limit("FASTEST", signal, most)];
        let end = |end: &str| format!("state->last_{name} + TICK * {end}");
        let (slowest, fastest) = (end(&slowest), end(&fastest));
        text += &format!(
            "    if (!is_reset)\n        t->{name} = clamp(t->{name}, {slowest},\n            {fastest});\n"
        );
    }
    if let Some(yields) = governor::yields(design, signal) {
        let yielded = within(governor::yielded(signal));
        text += &format!("    if (!is_reset && ({yields})) t->{name} = {yielded};\n");
    }
    let wanted = near(signal, format!("in->{name}"), &format!("t->{name}"));
    text + &format!("    if (t->{name} != {wanted}) t->status |= @PREFIX@_REFERENCE_LIMITED;\n")
}
