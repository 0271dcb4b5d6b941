//! The header: signals with units and ranges, what happens when something is wrong, and what is proved.

use crate::error::ExportError;
use crate::governor::MOST_ACTUATORS;
use crate::inputs::{Input, inputs, keeps_commands, origins, reference, references};
use crate::library::{functions, of_library};
use crate::real::Real;
use crate::references::is_kept;
use crate::tables::Tables;
use crate::template::{fill, paragraph};
use crate::{failsafe, governor};
use squid_scheduled::{Actuator, ControllerDesign, Gain, Port};

/// What is proved of a controller, in words for the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Standing {
    /// What is proved, a sentence each, or why nothing is.
    pub claims: Vec<String>,
    /// SHA-256 of the certificate in hexadecimal, if there is one.
    pub certificate_sha256: Option<String>,
}

/// Words that an actuator or a signal cannot be called by: those of C99, C11 and C++20 that consist of small letters,
/// C's others, and the outputs besides the commands.
const KEYWORDS: &str = "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t \
    char32_t class compl concept const const_cast consteval constexpr constinit continue co_await co_return co_yield \
    decltype default delete do double dynamic_cast else enum explicit export extern false float for friend goto if \
    inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public \
    register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct \
    switch template this thread_local throw true try typedef typeid typename union unsigned using virtual void \
    volatile wchar_t while xor xor_eq status";

pub(crate) fn header(
    design: &ControllerDesign,
    tables: &Tables,
    standing: &Standing,
    fields: &[(&'static str, String)],
) -> Result<String, ExportError> {
    let inputs = inputs(design);
    let names =
        design.actuators.iter().map(|actuator| &actuator.name).chain(inputs.iter().map(|input| &input.name));
    if let Some(name) = names.into_iter().find(|name| KEYWORDS.split_whitespace().any(|word| word == *name)) {
        return Err(ExportError::Keyword { name: name.clone() });
    }
    let found = design.actuators.len();
    if found > MOST_ACTUATORS {
        return Err(ExportError::Actuators { found, most: MOST_ACTUATORS });
    }
    let mut own = vec![
        ("about", about(design, standing, tables.real)),
        ("sample_time", format!("{:?}", design.sample_time)),
        ("late", design.delay_ticks.to_string()),
        ("minimum", format!("{:?}", design.scheduling.minimum)),
        ("maximum", format!("{:?}", design.scheduling.maximum)),
        ("gamma", format!("{:?}", design.gamma.bound)),
        ("certified", u8::from(design.gamma.certified).to_string()),
        ("sha256", standing.certificate_sha256.clone().unwrap_or_default()),
        ("inputs", inputs.iter().map(Input::member).collect()),
        ("applied", design.actuators.iter().map(applied).collect()),
        ("outputs", design.actuators.iter().map(output).collect()),
        ("trims", design.trimmed().map(|index| trim(&design.signals[index])).collect::<Vec<_>>().join("\n")),
        ("used", references(design).map(|(_, one)| used(one)).collect::<Vec<_>>().join("\n")),
        ("state", state(design, tables)),
        ("saturated_bits", governor::bits(design)),
    ];
    own.push(("way", governor::way(design).to_owned()));
    own.extend(failsafe::of_header(design));
    // What the parts bring is filled in last.
    Ok(fill(&fill(include_str!("template/autopilot.h"), &own), fields))
}

fn output(actuator: &Actuator) -> String {
    let (least, most) = (actuator.taken(actuator.minimum).0, actuator.taken(actuator.maximum).0);
    let of = match actuator.curve {
        Some(_) => {
            format!("what it takes for {:?} to {:?} {}", actuator.minimum, actuator.maximum, actuator.unit)
        }
        None => "trim and K(rho) y, limited".to_owned(),
    };
    let unit = actuator.taken_unit();
    let sign = actuator.sign_in_words().map_or(String::new(), |words| format!("    /* {words} */\n"));
    format!("{sign}    @prefix@_real {}; /* {unit}, {least:?} to {most:?}: {of} */\n", actuator.name)
}

/// A member of what the actuators get.
fn applied(actuator: &Actuator) -> String {
    format!("    @prefix@_real {}; /* {} */\n", actuator.name, actuator.taken_unit())
}

/// The output of a trim.
fn trim(signal: &Port) -> String {
    let Port { name, unit, measured, .. } = signal;
    format!("    @prefix@_real trim_{name}; /* {unit}: {measured} of level trim at the speed V_r */")
}

/// The output of a reference as it is used.
fn used(signal: &Port) -> String {
    let (name, unit) = (reference(signal), &signal.unit);
    format!("    @prefix@_real {name}_used; /* {unit}: {name} within the envelope */")
}

fn state(design: &ControllerDesign, tables: &Tables) -> String {
    let mut members =
        format!("    @prefix@_real x[{}]; /* state of the controller */\n", tables.sizes().states);
    let m = design.actuators.len();
    members += &format!("    @prefix@_real anchor[{m}]; /* what was applied when it followed last */\n");
    members += "    int followed_for; /* ticks since then */\n";
    if design.reference_filter.is_some() {
        members += "    @prefix@_real filtered_speed; /* m/s: V_r, the filtered reference of the speed */\n";
    }
    for Port { name, unit, .. } in origins(design) {
        members += &format!("    @prefix@_real origin_{name}; /* {unit}: {name} at the reset */\n");
    }
    for (_, signal) in references(design) {
        let (name, unit) = (reference(signal), &signal.unit);
        if !is_kept(design, signal) {
            continue;
        }
        members += &format!("    @prefix@_real last_{name}; /* {unit}: {name} as it was used last */\n");
    }
    members += &governor::members(design);
    if keeps_commands(design) {
        members +=
            &format!("    @prefix@_real put_out[{m}]; /* commands that came out last, before curves */\n");
    }
    if design.delay_ticks > 0 {
        let late = design.delay_ticks;
        members +=
            &format!("    @prefix@_real waiting[{late}][{m}]; /* commands that are still to come out */\n");
        members += "    int next; /* which of them comes out at the next tick */\n";
    }
    members + failsafe::member(design)
}

/// What the source needs of a library.
fn linked(design: &ControllerDesign, real: Real) -> String {
    let math = functions(design, real);
    if math.is_empty() {
        "The source needs no library.".to_owned()
    } else {
        of_library(&math).replacen("it calls", "the source calls", 1)
    }
}

/// What a reader of the header has to know.
/// A gain as a polynomial in rho.
fn gain(Gain { name, unit, coefficients }: &Gain) -> String {
    let powers = ["", " rho", " rho^2"];
    let terms: Vec<String> =
        coefficients.iter().zip(powers).map(|(value, power)| format!("{value:?}{power}")).collect();
    format!("{name} = {} ({unit})", terms.join(" + "))
}

fn about(design: &ControllerDesign, standing: &Standing, real: Real) -> String {
    let [ts, from, to] = [design.sample_time, design.scheduling.minimum, design.scheduling.maximum];
    let mut paragraphs = vec![
        format!(
            "Use: init once, reset where a flight begins, then step each {ts} s with the newest inputs. No function \
             allocates memory, waits, or keeps anything outside of the state that it is given; several states may be \
             stepped at once. How long a step takes does not depend on the numbers but for the branches of a few \
             comparisons. {}",
            linked(design, real)
        ),
        "A reference that is infinite or not a number: refused with BAD_INPUT, as is anything at a reset, and there an \
         angle beyond 2 pi rad, a rate beyond 2 pi rad/s, a depth above -5 m or below 12 km. Nothing is changed, and \
         the last commands hold, as if the tick were missed."
            .to_owned(),
        format!(
            "A measured speed outside {from} to {to} m/s along the path: rho is held at the end of its range, and the \
             status has OUT_OF_RANGE. For a wanted speed beyond the trim table the trim is that of its end. What is \
             proved does not hold there."
        ),
        "Taking over: while a pilot, another design or anything else commands the actuators, call follow with what \
         they get, and then step, each tick; call follow once more before the first step whose outputs are used. \
         The state is then such that the command is what was applied, as nearly as the controller can, and \
         references go on with the rate of the vehicle, and to what is asked through two lags of 1 s. An applied \
         command beyond its limits is taken to be at its limit, and one beyond ten times that is BAD_INPUT. To take \
         over after a reset: reset, follow, step. Where something limits the commands further while they are used, \
         call feed_back with what the actuators got before each step, and the anti-windup knows of it. What is proved \
         does not cover a loop that follows, nor limits that are not those of the outputs."
            .to_owned(),
        governor::about(design),
        failsafe::about(design).to_owned(),
        "A missed tick: nothing runs by itself. The last commands hold, and the state stays as it is. To make up for k \
         missed ticks step k + 1 times with the newest inputs, as the FMU does in a long step; after a longer gap \
         reset. What is proved does not cover ticks that are missed."
            .to_owned(),
        "What is proved:".to_owned(),
    ];
    paragraphs.extend(standing.claims.iter().cloned());
    if !design.gains.is_empty() {
        let words = "The gains of the control law, from which the matrices in the source follow; rho is -1 at the \
                     lowest and 1 at the highest speed:";
        paragraphs.push(words.to_owned());
        paragraphs.extend(design.gains.iter().map(gain));
    }
    paragraphs.push(format!(
        "The SHA-256 of certificate.json is {}.",
        standing.certificate_sha256.as_deref().unwrap_or("not there: there is no certificate")
    ));
    let lines: Vec<String> = paragraphs.iter().map(|words| paragraph(words)).collect();
    lines.join(" *\n")
}
