//! Terminals (`terminalsAndIcons/terminalsAndIcons.xml`): plant and controller have one matching plug each, so that
//! tools connect them in one operation. The format is that of FMI 3.0 (schema `fmi3TerminalsAndIcons.xsd`), which tools
//! also read in FMUs of FMI 2.0.

use crate::kind::Kind;
use squid_model_description::ModelDescription;
use squid_model_description::element::{NONE, Xml, document, leaf, parent};
use squid_scheduled::ControllerDesign;
use std::io;

/// Returns the members of the plug, in the order of the designs: measurements in one direction, commands in the other.
fn members<'a>(of: &ModelDescription, designs: &[&'a ControllerDesign]) -> Vec<&'a str> {
    let measured = designs.iter().flat_map(|design| {
        let signals = design.signals.iter().enumerate().filter(|(index, _)| design.measures(*index));
        signals.map(|(_, signal)| signal.name.as_str())
    });
    let commands = designs.iter().flat_map(|design| design.actuators.iter().map(|one| one.name.as_str()));
    let mut members = vec![];
    for name in measured.chain(commands).filter(|name| of.position(name).is_some()) {
        // Every axis measures the speed.
        if !members.contains(&name) {
            members.push(name);
        }
    }
    members
}

/// Returns the terminals of an FMU; the closed loop, in which everything is connected, has none.
pub(crate) fn terminals(
    kind: Kind,
    of: &ModelDescription,
    designs: &[&ControllerDesign],
) -> io::Result<Option<Vec<u8>>> {
    let (name, about) = match kind {
        Kind::Plant => ("autopilot", "to the terminal 'vehicle' of the controller"),
        Kind::Controller => ("vehicle", "to the terminal 'autopilot' of the plant"),
        Kind::Squid => return Ok(None),
    };
    let plug = [("name", name), ("matchingRule", "plug"), ("description", about)];
    let text = document(|xml| {
        parent(xml, "fmiTerminalsAndIcons", &[("fmiVersion", "3.0")], |xml| {
            parent(xml, "Terminals", NONE, |xml| {
                parent(xml, "Terminal", &plug, |xml| {
                    members(of, designs).into_iter().try_for_each(|member| signal(xml, member))
                })
            })
        })
    })?;
    Ok(Some(text))
}

fn signal(xml: &mut Xml, name: &str) -> io::Result<()> {
    let member = [("variableName", name), ("memberName", name), ("variableKind", "signal")];
    leaf(xml, "TerminalMemberVariable", &member)
}
