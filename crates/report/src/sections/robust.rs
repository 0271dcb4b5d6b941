//! Comparison of the robust controller with the nominal one, for a robust design.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, Part, Table, percent};
use crate::subject::Subject;
use squid_base::numbers::above;
use squid_design::synthesise::robust::figures::{Frozen, RobustFigures, gain_text};

/// Returns the section on the robust and the nominal controller.
///
/// # Errors
/// Errors of [`squid_design::synthesise::robust::StoredRobust::confirm`]: unproved results are not shown.
pub fn robust(subject: &Subject) -> Result<Vec<Part>, Error> {
    let Some(stored) = &subject.stored.robust else {
        let text = if subject.inputs.is_uncertain() {
            "The controller of this report is the nominal one. `squid design --robust` searches for a controller \
                    that tolerates more of the declared uncertainty; this section then compares the two."
        } else {
            "No uncertainty is declared, so robustness is not analysed."
        };
        return Ok(vec![Part::Text(text.into())]);
    };
    let inputs = subject.inputs;
    stored.check(inputs, &subject.model, &subject.stored.controller.lft)?;
    let figures = &stored.figures;
    Ok(vec![
        Part::Text(about(figures)),
        Part::Table(ladder(figures)),
        Part::Text(proof(figures)),
        Part::Text(constant(figures)),
        Part::Figure(figure(subject, figures)),
        Part::Table(frozen(figures)),
    ])
}

fn about(figures: &RobustFigures) -> String {
    let (parameters, channels, rho) = figures.sizes;
    format!(
        "The controller of this report is the robust one. Coefficients that change arbitrarily fast: at a gain of \
            {:.4}, which is {}, the robust controller tolerates {} of {}, the nominal one {}. Both are analysed with \
            the same inequality, in which {parameters} coefficients ({channels} channels) and the speed ({rho} \
            channels) may change at any rate within their ranges. The table contains upper bounds of the gain for \
            smaller and larger fractions of the declared uncertainty.",
        figures.gamma,
        gain_text(figures.gamma),
        percent(figures.robust_tolerated_fraction, 1),
        figures.declared(),
        percent(figures.nominal_tolerated_fraction, 1)
    )
}

fn proof(figures: &RobustFigures) -> String {
    format!(
        "Proved again for this page, in exact arithmetic (robust_certificate.json): with {} of {} the gain of \
            the robust controller is below {}. {}",
        percent(figures.robust_tolerated_fraction, 1),
        figures.declared(),
        above(figures.proved),
        figures.not_proved()
    )
}

fn constant(figures: &RobustFigures) -> String {
    format!(
        "Constant errors of the coefficients are a milder test. For these the figure and its table show both \
            controllers, frozen at a speed: an upper bound on mu for robust stability (1 is the full declared \
            uncertainty; smaller is better), and the worst-case gain at {} of the declared uncertainty, of which the \
            first number is attained by a perturbation and the second is guaranteed, both for the model, in which \
            the incidence is an independent parameter; 'vehicle' is the gain of a vehicle with the coefficients of \
            the perturbation, trimmed again. Both apply to the loop in continuous time.",
        percent(figures.constant_size, 0)
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "none found".into(), above)
}

fn ladder(figures: &RobustFigures) -> Table {
    let mut table =
        Table::new(["fraction of the declared uncertainty", "gain below: nominal", "gain below: robust"]);
    let row = |(size, nominal, robust): &(f64, Option<f64>, Option<f64>)| {
        vec![percent(*size, 1), number(*nominal), number(*robust)]
    };
    table.rows = figures.ladder.iter().map(row).collect();
    table
}

/// Plots figures of both controllers over speed, the nominal one first.
fn figure(subject: &Subject, figures: &RobustFigures) -> Figure {
    let curve = |which: usize, of: &dyn Fn(&Frozen) -> Option<f64>| Curve {
        key: which,
        points: figures.frozen.iter().filter_map(|f| Some((f.speed, of(f)?))).collect(),
    };
    let gain = format!("worst-case gain at {} (-)", percent(figures.constant_size, 0));
    Figure {
        name: "robust-and-nominal".into(),
        caption: format!(
            "Upper bounds at six frozen speeds for {}, with constant coefficients anywhere in their ranges. Smaller \
                is better.",
            subject.name()
        ),
        keys: vec![Key::nth(1, "nominal controller"), Key::coloured(0, "robust controller")],
        charts: vec![
            Chart::over_speed("mu (-)", [0, 1].map(|i| curve(i, &|f| f.mu[i])).into()),
            Chart::over_speed(gain, [0, 1].map(|i| curve(i, &|f| f.worst[i].map(|(upper, _)| upper))).into()),
        ],
    }
}

fn frozen(figures: &RobustFigures) -> Table {
    let at = percent(figures.constant_size, 0);
    let mut table = Table::new(["speed (m/s)", "mu below: nominal", "mu below: robust"]);
    for which in ["nominal", "robust"] {
        table.head.push(format!("worst-case gain at {at}: {which}"));
        table.head.push(format!("vehicle: {which}"));
    }
    let row = |f: &Frozen| {
        let [nominal, robust] = f.mu.map(number);
        let [nominal_gain, robust_gain] = f.worst.map(between);
        let [nominal_vehicle, robust_vehicle] = f.vehicle.map(vehicle);
        let gains = [nominal_gain, nominal_vehicle, robust_gain, robust_vehicle];
        [format!("{:.2}", f.speed), nominal, robust].into_iter().chain(gains).collect()
    };
    table.rows = figures.frozen.iter().map(row).collect();
    table
}

/// Returns the gain of a vehicle as text.
pub fn vehicle(gain: Option<f64>) -> String {
    gain.map_or_else(|| "none".into(), |gain| format!("{gain:.4}"))
}

/// Returns the bounds of a gain, (upper, lower), as text: one number if they agree to three decimals.
pub fn between(gain: Option<(f64, f64)>) -> String {
    match gain {
        None => "no bound".into(),
        Some((upper, lower)) if format!("{lower:.3}") == format!("{upper:.3}") => above(upper),
        Some((upper, lower)) => format!("{lower:.4} to {}", above(upper)),
    }
}
