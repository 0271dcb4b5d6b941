//! Several axes as one autopilot: a header and a source that call those of each axis.
//!
//! Inputs and actuators shared by several axes have one name; all other outputs of any axis but the first are prefixed
//! with the name of the axis, as in the FMU.

use crate::Source;
use crate::text::{comment, fill, lines, named, plain};
use squid_scheduled::ControllerDesign;

/// Name, design and source of an axis.
pub type Axis<'a> = (&'a str, &'a ControllerDesign, &'a Source);

/// A struct member of an axis and the corresponding member of the autopilot.
struct Member {
    own: String,
    whole: String,
    /// Lines of the member in the header of the axis.
    lines: String,
}

/// Writes the header and the source of an autopilot `name`. The sources of its axes are in adjacent folders, named
/// after the axes.
pub fn together(name: &str, axes: &[Axis<'_>]) -> Source {
    let vehicle = axes.first().map_or("", |(_, design, _)| &design.vehicle.name);
    let names: Vec<&str> = axes.iter().map(|(called, ..)| *called).collect();
    let each = |of: &dyn Fn(&Axis<'_>) -> String| lines(axes.iter().map(of));
    let call =
        |text: &str| each(&|(called, ..)| format!("    note(&result, {});", text.replace("AXIS", called)));
    let is_safe = axes.iter().all(|(_, design, _)| design.failsafe.is_some());
    let safe = format!(
        "/* Writes the safe commands, which are output after the loss of a sensor without a substitute. */\nvoid \
         {name}_safe({name}_commands *out);"
    );
    let parts: Vec<String> =
        axes.iter().enumerate().map(|(index, axis)| of_axis(name, index, axis)).collect();
    let fields = [
        ("title", plain(&format!("Autopilot of {vehicle}: {}.", names.join(", ")))),
        ("about", about(&names, axes)),
        ("includes", each(&|(called, _, source)| format!("#include \"{called}/{}.h\"", source.name))),
        ("real", axes.first().map_or_else(String::new, |(.., source)| format!("{}_real", source.name))),
        (
            "sample_time",
            axes.first().map_or_else(String::new, |(_, one, _)| format!("{:?}", one.sample_time)),
        ),
        ("inputs", union(name, axes, "inputs")),
        ("outputs", union(name, axes, "outputs")),
        ("commands", union(name, axes, "commands")),
        ("states", each(&|(called, _, source)| format!("    {}_state {called};", source.name))),
        ("parts", parts.join("\n")),
        ("begin", call("begin_AXIS(&fresh.AXIS, in, &first)")),
        ("step", call("step_AXIS(&state->AXIS, in, out)")),
        ("follow", call("follow_AXIS(&state->AXIS, in, applied)")),
        ("feed_back", call("feed_back_AXIS(&state->AXIS, applied)")),
        ("safe", if is_safe { safe } else { String::new() }),
        ("safe_of_each", if is_safe { safe_of_each(name, axes) } else { String::new() }),
    ];
    Source {
        name: name.to_owned(),
        header: fill(&named(include_str!("c/whole.h"), name), &fields),
        source: fill(&named(include_str!("c/whole.c"), name), &fields),
    }
}

/// Returns the comment at the head of the header: the use, and the inputs that the axes share.
fn about(names: &[&str], axes: &[Axis<'_>]) -> String {
    let sources: Vec<String> =
        axes.iter().map(|(called, _, source)| format!("{called}/{}.c", source.name)).collect();
    let headers = sources.iter().map(|one| one.replace(".c", ".h")).collect::<Vec<_>>().join(", ");
    let paragraphs = [
        format!(
            "Use: call init once, reset at the start of a mission, then step at every tick with the latest inputs. \
             Compile it with {}, each of which contains one axis. Rejected inputs, proofs and status bits are \
             described in {headers}.",
            sources.join(", ")
        ),
        format!(
            "The axes of {} share only their inputs: an axis that does not return OK has missed the tick, and its \
             last commands hold; the other axes continue.",
            names.join(", ")
        ),
    ];
    comment(&paragraphs)
}

/// Returns the members of all axes in a struct, without duplicates.
fn union(name: &str, axes: &[Axis<'_>], of: &str) -> String {
    let mut all: Vec<Member> = Vec::new();
    for (index, axis) in axes.iter().enumerate() {
        for member in members(name, index, axis, of) {
            if all.iter().all(|other| other.whole != member.whole) {
                all.push(member);
            }
        }
    }
    lines(
        all.into_iter().map(|Member { own, whole, lines }| {
            lines.replacen(&format!(" {own};"), &format!(" {whole};"), 1)
        }),
    )
}

/// Returns the members of a struct in the header of an axis.
fn members(name: &str, index: usize, (called, design, source): &Axis<'_>, of: &str) -> Vec<Member> {
    let (before, _) = source.header.split_once(&format!("}} {}_{of};", source.name)).unwrap_or_default();
    let (_, inside) = before.rsplit_once("typedef struct {\n").unwrap_or_default();
    let (mut all, mut kept) = (Vec::new(), String::new());
    for line in inside.lines() {
        let line = line
            .replace(&format!("{}_real ", source.name), &format!("{name}_real "))
            .replace("the bits below", &format!("the bits in {called}/{}.h", source.name));
        let Some(own) = line.split_once(';').and_then(|(declared, _)| declared.split_whitespace().last())
        else {
            // A comment precedes its member.
            kept += &format!("{line}\n");
            continue;
        };
        let is_shared = of != "outputs" || design.actuators.iter().any(|one| one.name == own);
        let whole = match own {
            _ if index == 0 || is_shared => own.to_owned(),
            own if own.starts_with(&format!("{called}_")) => own.to_owned(),
            own => format!("{called}_{own}"),
        };
        all.push(Member { own: own.to_owned(), whole, lines: std::mem::take(&mut kept) + &line });
    }
    all
}

/// Writes the functions of an axis.
fn of_axis(name: &str, index: usize, axis: &Axis<'_>) -> String {
    let (called, _, source) = axis;
    let each =
        |of: &str, line: &dyn Fn(&Member) -> String| lines(members(name, index, axis, of).iter().map(line));
    let take = |one: &Member| format!("    to.{} = from->{};", one.own, one.whole);
    let put = |one: &Member| format!("    to->{} = from->{};", one.whole, one.own);
    let fields = [
        ("take", each("inputs", &take)),
        ("apply", each("commands", &take)),
        ("put", each("outputs", &put)),
        ("axis", (*called).to_owned()),
        ("own", source.name.clone()),
        ("OWN", source.name.to_ascii_uppercase()),
    ];
    fill(&named(include_str!("c/whole_axis.c"), name), &fields)
}

/// Writes the function that returns the safe commands of all axes.
fn safe_of_each(name: &str, axes: &[Axis<'_>]) -> String {
    let each = lines(axes.iter().enumerate().map(|(index, axis)| {
        let (called, _, source) = axis;
        let own = members(name, index, axis, "commands");
        let put = lines(own.iter().map(|one| format!("    out->{} = {called}.{};", one.whole, one.own)));
        format!("    {0}_commands {called};\n    {0}_safe(&{called});\n{put}", source.name)
    }));
    format!("\nvoid {name}_safe({name}_commands *out)\n{{\n{each}\n}}\n")
}
