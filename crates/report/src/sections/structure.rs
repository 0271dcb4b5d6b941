//! Block diagrams with the sizes of the design: the connections of plant, controller and speed, and the weighted
//! signals.

use crate::error::Error;
use crate::page::{Diagram, Part};
use crate::subject::Subject;
use squid_lpv::partition::Sizes;

/// Returns the section on the structure of the loop.
///
/// # Errors
/// None.
pub fn structure(subject: &Subject) -> Result<Vec<Part>, Error> {
    let (plant, k) = (subject.plant.sizes(), subject.controller.parts.sizes());
    let (centre, half_range) = subject.inputs.design.scheduling();
    let text = format!(
        "Theta = rho I, rho = (V - {})/{}, with the speed V in m/s. In brackets: the number of signals.",
        squid_auv::rounded(centre),
        squid_auv::rounded(half_range)
    );
    Ok(vec![
        Part::Text(text),
        Part::Diagram(scheduled(plant, k)),
        Part::Diagram(augmented(plant, k)),
        Part::Diagram(weighted(subject, k.x)),
    ])
}

fn text<const N: usize>(lines: [&str; N]) -> Vec<String> {
    lines.map(str::to_owned).into()
}

/// Draws plant and controller, each with its copies of the parameter.
fn scheduled(plant: Sizes, k: Sizes) -> Diagram {
    let caption = "The loop: plant and controller are scheduled on the same speed.".into();
    let mut d = Diagram::new("fig1a-structure", caption, (440, 400));
    let x = 220.0;
    d.block((x, 35.0), (130.0, 40.0), &[format!("rho I of size {}", plant.t)]);
    d.block((x, 130.0), (150.0, 70.0), &text(["plant P(s)", &format!("{} states", plant.x)]));
    d.block((x, 260.0), (150.0, 70.0), &text(["controller K(s)", &format!("{} states", k.x)]));
    d.block((x, 360.0), (130.0, 40.0), &[format!("rho I of size {}", k.t)]);
    loop_through(&mut d, (x, 35.0, 130.0), (112.0, 150.0), ("w_theta", "z_theta"), plant.t);
    d.wire(&[(40.0, 130.0), (145.0, 130.0)]);
    d.label((85.0, 124.0), &format!("w ({})", plant.w));
    d.wire(&[(295.0, 130.0), (400.0, 130.0)]);
    d.label((355.0, 124.0), &format!("z ({})", plant.z));
    d.wire(&[(295.0, 150.0), (330.0, 150.0), (330.0, 245.0), (295.0, 245.0)]);
    d.label((360.0, 202.0), &format!("y ({})", plant.y));
    d.wire(&[(145.0, 245.0), (110.0, 245.0), (110.0, 150.0), (145.0, 150.0)]);
    d.label((80.0, 202.0), &format!("u ({})", plant.u));
    loop_through(&mut d, (x, 360.0, 130.0), (280.0, 150.0), ("w_K", "z_K"), k.t);
    d
}

/// Distance of a label from its line, and half the width of a letter, in units of the page.
const LABEL: (f64, f64) = (8.0, 3.8);

/// Draws the lines between a box with centre `(x, y)` and a width, and another box at a height with a width: to the
/// right side of the former, and from its left side.
fn loop_through(
    d: &mut Diagram,
    (x, y, width): (f64, f64, f64),
    (height, other): (f64, f64),
    (from, to): (&str, &str),
    size: usize,
) {
    let (near, far) = (0.5 * width, 0.5 * other);
    let out = far + 35.0;
    let between = 0.5 * (y + height) + 5.0;
    d.wire(&[(x + far, height), (x + out, height), (x + out, y), (x + near, y)]);
    let text = [to, from].map(|name| format!("{name} ({size})"));
    let [right, left] = [&text[0], &text[1]].map(|w| out + LABEL.0 + LABEL.1 * w.len() as f64);
    d.label((x + right, between), &text[0]);
    d.wire(&[(x - near, y), (x - out, y), (x - out, height), (x - far, height)]);
    d.label((x - left, between), &text[1]);
}

/// Draws the loop with all copies of the parameter in one block, and a controller without parameters.
fn augmented(plant: Sizes, k: Sizes) -> Diagram {
    let caption =
        "The same loop as used in the matrix inequalities: all copies of the speed in one block, with the \
        copies of the controller passed through the plant."
            .into();
    let mut d = Diagram::new("fig1b-structure", caption, (560, 310));
    let (x, both) = (280.0, plant.t + k.t);
    d.block((x, 35.0), (190.0, 40.0), &[format!("diag(rho I_{}, rho I_{})", plant.t, k.t)]);
    d.block((x, 140.0), (190.0, 70.0), &text(["augmented plant P_a(s)", &format!("{} states", plant.x)]));
    d.block((x, 265.0), (150.0, 60.0), &text(["K(s)", &format!("{} states", k.x)]));
    loop_through(&mut d, (x, 35.0, 190.0), (118.0, 190.0), ("w_theta, w_K", "z_theta, z_K"), both);
    d.wire(&[(85.0, 140.0), (185.0, 140.0)]);
    d.label((120.0, 134.0), &format!("w ({})", plant.w));
    d.wire(&[(375.0, 140.0), (475.0, 140.0)]);
    d.label((445.0, 134.0), &format!("z ({})", plant.z));
    d.wire(&[(375.0, 162.0), (410.0, 162.0), (410.0, 265.0), (355.0, 265.0)]);
    d.label((445.0, 290.0), &format!("y, z_K ({} + {})", plant.y, k.t));
    d.wire(&[(205.0, 265.0), (150.0, 265.0), (150.0, 162.0), (185.0, 162.0)]);
    d.label((115.0, 290.0), &format!("u, w_K ({} + {})", plant.u, k.t));
    d
}

/// Draws the weighted signals.
fn weighted(subject: &Subject, states: usize) -> Diagram {
    let design = &subject.inputs.design;
    let (tracked, m) = (design.tracked.len(), subject.inputs.vehicle.actuators.len());
    let apart = !design.measured.is_empty();
    let models = design.tracked.iter().filter(|t| t.model.is_some()).count();
    let names = |all: Vec<&str>| all.join(", ");
    let outputs = names(design.tracked.iter().map(|t| t.signal.name).collect());
    let caption = format!(
        "Weights: W_e on the errors of {outputs}, W_u on the commands; w contains the references r, the disturbances \
            d at the actuators{}.",
        if apart { " and the sensor noise n" } else { "" }
    );
    let mut d = Diagram::new("fig2-weights", caption, (760, 270));
    let takes = if apart { format!("r and {} measured", design.measured.len()) } else { "errors".into() };
    d.block((210.0, 150.0), (140.0, 70.0), &text(["controller K", &format!("{states} states"), &takes]));
    let lags = if design.lags { format!("{m} actuators with lags") } else { format!("{m} actuators") };
    let own = format!("{} states", design.states.len());
    d.block((470.0, 150.0), (170.0, 70.0), &text(["vehicle G(rho)", &own, &lags]));
    d.wire(&[(280.0, 150.0), (362.0, 150.0)]);
    d.sum((370.0, 150.0));
    d.wire(&[(378.0, 150.0), (385.0, 150.0)]);
    d.wire(&[(370.0, 225.0), (370.0, 158.0)]);
    d.label((370.0, 242.0), &format!("d ({m})"));
    d.label((318.0, 143.0), &format!("u ({m})"));
    d.wire(&[(325.0, 150.0), (325.0, 215.0), (295.0, 215.0)]);
    d.block((270.0, 215.0), (50.0, 32.0), &text(["W_u"]));
    d.wire(&[(245.0, 215.0), (170.0, 215.0)]);
    d.label((140.0, 220.0), &format!("z_u ({m})"));
    d.wire(&[(20.0, 150.0), (140.0, 150.0)]);
    d.label((55.0, 143.0), &format!("r ({tracked})"));
    let model = if models > 0 { format!("model T_ref of {models}") } else { "1".into() };
    d.wire(&[(100.0, 150.0), (100.0, 45.0), (135.0, 45.0)]);
    d.block((215.0, 45.0), (160.0, 36.0), &[model]);
    d.wire(&[(295.0, 45.0), (592.0, 45.0)]);
    d.sum((600.0, 45.0));
    d.wire(&[(555.0, 150.0), (600.0, 150.0), (600.0, 53.0)]);
    d.label((614.0, 70.0), "-");
    d.label((660.0, 125.0), &outputs);
    d.wire(&[(608.0, 45.0), (640.0, 45.0)]);
    d.block((665.0, 45.0), (50.0, 32.0), &text(["W_e"]));
    d.wire(&[(690.0, 45.0), (725.0, 45.0)]);
    d.label((735.0, 34.0), &format!("z_e ({tracked})"));
    d.wire(&[(585.0, 150.0), (585.0, 260.0), (60.0, 260.0), (60.0, 170.0), (140.0, 170.0)]);
    d.label((505.0, 253.0), if apart { "measurements + n" } else { "fed back, from r" });
    d
}
