//! The header: signals with units and ranges, the behaviour on errors, and the proof.

use crate::about::{Standing, about};
use crate::error::ExportError;
use crate::inputs::{inputs, measurements, origins, reference, references};
use crate::numbers::Numbers;
use crate::text::{fill, lines, named, title};
use squid_scheduled::{Actuator, ControllerDesign, Source, Without};

/// Status bit for the first actuator at its limit; the bit of the next actuator is twice as large.
const SATURATED_FIRST: u32 = 0x10000;

/// Status bit for the loss of the first measurement.
const LOST_FIRST: u32 = 0x10;

/// Number of actuators for which the status has bits.
const MOST_ACTUATORS: usize = 16;

/// Names that an actuator or a signal cannot have: the lower-case keywords of C99, C11 and C++20 and the outputs
/// besides the commands.
const KEYWORDS: &str = "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t \
    char32_t class compl concept const const_cast consteval constexpr constinit continue co_await co_return co_yield \
    decltype default delete do double dynamic_cast else enum explicit export extern false float for friend goto if \
    inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public \
    register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct \
    switch template this thread_local throw true try typedef typeid typename union unsigned using virtual void \
    volatile wchar_t while xor xor_eq status";

/// Writes the header.
pub(crate) fn header(
    design: &ControllerDesign,
    numbers: &Numbers,
    standing: &Standing,
    name: &str,
) -> Result<String, ExportError> {
    let inputs = inputs(design);
    let actuators = &design.actuators;
    let mut names = actuators.iter().map(|one| &one.name).chain(inputs.iter().map(|input| &input.name));
    if let Some(name) = names.find(|name| KEYWORDS.split_whitespace().any(|word| word == *name)) {
        return Err(ExportError::Keyword { name: name.clone() });
    }
    let (found, most) = (actuators.len(), MOST_ACTUATORS);
    if found > most {
        return Err(ExportError::Actuators { found, most });
    }
    let (real, upper) = (format!("    {name}_real"), name.to_ascii_uppercase());
    let members = |all: &mut dyn Iterator<Item = (String, String)>| {
        lines(all.map(|(member, text)| format!("{real} {member}; /* {text} */")))
    };
    let signals = |all: Vec<usize>| all.into_iter().map(|index| &design.signals[index]);
    let ages = signals(measurements(design)).filter(|_| design.failsafe.is_some());
    let trims = signals(design.trimmed().collect());
    let saturated = |(index, one): (usize, &Actuator)| {
        format!(
            "#define {upper}_SATURATED_{} {:#x}u",
            one.name.to_ascii_uppercase(),
            SATURATED_FIRST << index
        )
    };
    let kept = match origins(design).len() {
        0 => String::new(),
        count => format!(
            "{real} origin[{count}]; /* measurements at the reset, from which the deviations of signals are taken */"
        ),
    };
    let fields = [
        ("title", title(design)),
        ("about", about(design, standing, numbers.real)),
        ("real", numbers.real.name().to_owned()),
        ("sample_time", format!("{:?}", design.sample_time)),
        ("late", design.delay_ticks.to_string()),
        ("minimum", format!("{:?}", design.scheduling.minimum)),
        ("maximum", format!("{:?}", design.scheduling.maximum)),
        ("gamma", format!("{:?}", design.gamma.bound)),
        ("certified", u8::from(design.gamma.certified).to_string()),
        ("sha256", standing.certificate_sha256.clone().unwrap_or_default()),
        ("stale_after", stale_after(design, &upper)),
        ("inputs", members(&mut inputs.iter().map(|one| (one.name.clone(), one.comment.clone())))),
        (
            "ages",
            members(&mut ages.map(|one| (format!("{}_age", one.name), "s since the measurement".into()))),
        ),
        ("outputs", lines(actuators.iter().map(|one| output(one, &real)))),
        (
            "trims",
            members(&mut trims.map(|one| {
                let text = format!("{}: {} in level trim at the speed V_r", one.unit, one.measured);
                (format!("trim_{}", one.name), text)
            })),
        ),
        (
            "used",
            members(&mut signals(references(design)).map(|one| {
                let name = reference(one);
                (format!("{name}_used"), format!("{}: {name}, limited to the envelope", one.unit))
            })),
        ),
        (
            "applied",
            members(&mut actuators.iter().map(|one| (one.name.clone(), one.input_unit().to_owned()))),
        ),
        ("saturated_bits", lines(actuators.iter().enumerate().map(saturated))),
        ("lost_bits", lost_bits(design, &upper)),
        ("states", numbers.sizes().states.to_string()),
        ("commands", found.to_string()),
        ("measurements", measurements(design).len().to_string()),
        // C has no arrays of length 0.
        ("references", references(design).len().max(1).to_string()),
        ("origins", kept),
    ];
    Ok(fill(&named(include_str!("c/autopilot.h"), name), &fields))
}

/// Returns the member of the outputs for an actuator.
fn output(actuator: &Actuator, real: &str) -> String {
    let [least, most] = [actuator.minimum, actuator.maximum].map(|end| actuator.input_for(end).0);
    let of = match actuator.curve {
        Some(_) => {
            format!("command for {:?} to {:?} {}", actuator.minimum, actuator.maximum, actuator.unit)
        }
        None => "trim and K(rho) y, limited".to_owned(),
    };
    let sign = actuator.effect_of_sign().map_or(String::new(), |text| format!("    /* {text} */\n"));
    format!("{sign}{real} {}; /* {}, {least:?} to {most:?}: {of} */", actuator.name, actuator.input_unit())
}

fn stale_after(design: &ControllerDesign, upper: &str) -> String {
    let Some(failsafe) = &design.failsafe else { return String::new() };
    format!(
        "#define {upper}_STALE_AFTER {:?} /* s: an older measurement, or one constant for this time although it \
         should have changed, is lost; 0: never */",
        failsafe.stale_after
    )
}

/// Returns the status bits of lost sensors.
fn lost_bits(design: &ControllerDesign, upper: &str) -> String {
    if design.failsafe.is_none() {
        return String::new();
    }
    let bit = |(index, signal): (usize, usize)| {
        let name = &design.signals[signal].name;
        let holds = matches!(design.source(signal), Some(Source::Path(_))) && design.follows(signal);
        let text = match design.without(signal) {
            Without::Speed => "the filtered reference replaces it: its loop is open",
            Without::Reckoned if holds => "it is estimated from pitch and speed, and its reference is held",
            Without::Reckoned => "it is estimated from its rate",
            Without::Nothing => "FAILED",
        };
        let bit = LOST_FIRST << index;
        format!("#define {upper}_LOST_{} {bit:#x}u /* {name} is lost: {text} */", name.to_ascii_uppercase())
    };
    let failed = format!(
        "#define {upper}_FAILED 0x8u /* a sensor without a substitute is lost: the commands ramp to the safe ones, \
         and all else holds */"
    );
    lines(std::iter::once(failed).chain(measurements(design).into_iter().enumerate().map(bit)))
}
