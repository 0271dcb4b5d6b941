//! Comparison of the polynomials in speed with the true linearisations.

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Key, Part, Table, extent};
use crate::subject::Subject;
use nalgebra::Complex;
use squid_auv::longitudinal::{STATES, turning};
use squid_auv::readable;
use squid_design::axis::VehicleModel;
use squid_design::fit::frequency;
use squid_design::linearise::stacked;
use squid_lpv::matrix::{Mat, eigenvalues};
use squid_lpv::polynomial::MatrixPolynomial;
use squid_signals::States;

/// Compared orders.
const ORDERS: [usize; 2] = [1, 2];
/// Units of the entries: those of the derivatives of [`STATES`] over those of the columns.
const UNITS: [[&str; STATES.len()]; STATES.len()] = [
    ["1/s", "1/s", "m/s", "m/s^2", "1/s^2"],
    ["1/s", "1/s", "m/s", "m/s^2", "1/s^2"],
    ["1/(m s)", "1/(m s)", "1/s", "1/s^2", "1/(m s^2)"],
    ["1/m", "1/m", "1", "1/s", "1/(m s)"],
    ["1", "1", "m", "m/s", "1/s"],
];
/// Smallest variation of a plotted entry, as a fraction of the largest entry.
const VARIES: f64 = 1e-4;

/// Returns the plotted orders: [`ORDERS`], and that of the design.
fn orders(subject: &Subject) -> Vec<usize> {
    let own = subject.inputs.design.order;
    ORDERS.into_iter().chain((!ORDERS.contains(&own)).then_some(own)).collect()
}

fn keys(subject: &Subject) -> Vec<Key> {
    let own = subject.inputs.design.order;
    let drawn = orders(subject).into_iter().enumerate().map(|(i, order)| {
        let name = format!("order {order}{}", if order == own { ", of this design" } else { "" });
        let (colour, dash) = [(1, "7 3"), (0, ""), (2, "7 3 2 3")][i];
        Key { dash, ..Key::nth(colour, name) }
    });
    std::iter::once(Key::ground("exact linearisation")).chain(drawn).collect()
}

fn fits(subject: &Subject) -> Result<Vec<MatrixPolynomial>, Error> {
    let samples: Vec<(f64, Mat)> =
        subject.model.grid.iter().map(|(rho, l)| (*rho, stacked(&l.a, &l.b))).collect();
    let fit = |order| MatrixPolynomial::fit(&samples, order);
    Ok(orders(subject).into_iter().map(fit).collect::<Result<_, _>>()?)
}

/// Returns the section on the entries of A over speed, linearised and fitted.
///
/// # Errors
/// [`ModelError::System`](squid_design::error::ModelError::System) if there are too few speeds.
pub fn entries(subject: &Subject) -> Result<Vec<Part>, Error> {
    let fits = fits(subject)?;
    let largest = subject.model.grid.iter().map(|(_, l)| l.a.amax()).fold(0.0, f64::max);
    let mut charts = Vec::new();
    let states = subject.inputs.design.states;
    for (i, j) in (0..states.len()).flat_map(|i| (0..states.len()).map(move |j| (i, j))) {
        let (low, high) = extent(subject.model.grid.iter().map(|(_, l)| l.a[(i, j)]));
        if high - low > VARIES * largest {
            charts.push(entry(subject, &fits, i, j));
        }
    }
    let caption = format!(
        "The {} entries of A that vary with speed by more than {} % of the largest entry, for {}: exact at {} \
            speeds, and as polynomials. x = [{}].",
        charts.len(),
        100.0 * VARIES,
        subject.name(),
        subject.model.grid.len(),
        states.iter().map(|state| state.symbol).collect::<Vec<_>>().join(" ")
    );
    let figure = Figure { name: "fig3-entries-of-A".into(), caption, keys: keys(subject), charts };
    Ok(vec![Part::Figure(figure)])
}

fn entry(subject: &Subject, fits: &[MatrixPolynomial], i: usize, j: usize) -> Chart {
    let (centre, half_range) = subject.inputs.design.scheduling();
    let exact = subject.model.grid.iter().map(|(rho, l)| (centre + half_range * rho, l.a[(i, j)])).collect();
    let mut curves = vec![Curve { key: 0, points: exact }];
    let states = subject.inputs.design.states;
    let first = STATES.iter().position(|state| *state == states[0]).unwrap_or(0);
    let [rate, state] = [i, j].map(|index| states[index].symbol);
    for (k, fit) in fits.iter().enumerate() {
        let fine = (0..=60).map(|n| f64::from(n) / 30.0 - 1.0);
        let points = fine.map(|rho| (centre + half_range * rho, fit.evaluate(rho)[(i, j)])).collect();
        curves.push(Curve { key: k + 1, points });
    }
    Chart::over_speed(format!("{rate}' per {state} ({})", UNITS[first + i][first + j]), curves)
}

/// Returns the section on frequency responses from an actuator to pitch or heading, linearised and fitted.
///
/// # Errors
/// Errors of [`entries`].
pub fn responses(subject: &Subject) -> Result<Vec<Part>, Error> {
    let fits = fits(subject)?;
    let (input, actuator) = subject.turning_actuator();
    let angle = frequency::angle(subject.inputs.design.states).name;
    // The unit is degrees of the angle per newton or per degree of deflection.
    let per_unit = if actuator.unit() == "rad" { 1f64.to_radians() } else { 1.0 };
    let (mut charts, mut phases) = (Vec::new(), Vec::new());
    for at in [0, subject.truth.len() / 2, subject.truth.len() - 1] {
        let (speed, exact) = (subject.speeds[at], stacked(&subject.truth[at].a, &subject.truth[at].b));
        let models: Vec<Mat> =
            std::iter::once(exact).chain(fits.iter().map(|fit| fit.evaluate(subject.rho(speed)))).collect();
        let title = Subject::speed_name(speed);
        let magnitude = Axis::logarithmic(format!("|{angle}| (deg per {})", readable(actuator.unit()).1));
        charts.push(response(&title, &models, (input, subject.inputs.design.states), magnitude, &|g| {
            g.norm().to_degrees() * per_unit
        }));
        let phase = Axis::linear("phase (deg)");
        phases.push(response(&title, &models, (input, subject.inputs.design.states), phase, &|g| {
            g.arg().to_degrees()
        }));
    }
    // Charts are in rows of three, with the phase below the magnitude.
    charts.append(&mut phases);
    let errors =
        frequency::errors(&subject.inputs.vehicle.actuators, &subject.inputs.design.tracked, &subject.model);
    let error = |order: usize, of: &dyn Fn(&frequency::Errors) -> f64| {
        errors.iter().find(|e| e.order == order).map_or(f64::NAN, |e| 100.0 * of(e))
    };
    let shown = |e: &frequency::Errors| e.of_angle(input);
    let scaled = |e: &frequency::Errors| e.scaled;
    let figure = Figure {
        name: "fig4-frequency-responses".into(),
        caption: format!(
            "Response from {} (the actuator with the largest effect on pitch) to pitch, of {}, at three speeds. \
                Where the curves coincide, the error of the polynomials is negligible.",
            actuator.name,
            subject.name()
        ),
        keys: keys(subject),
        charts,
    };
    let mut table = Table::new(["order", "rms residual of A, % of its variation"]);
    table.head.push(format!("largest error of the response from {} to pitch, %", actuator.name));
    table.head.push("from all actuators to the tracked outputs, in the scales of the design, %".into());
    for r in &subject.model.residuals {
        table.rows.push(vec![
            r.order.to_string(),
            format!("{:.3}", 100.0 * r.relative_to_variation),
            format!("{:.3}", error(r.order, &shown)),
            format!("{:.3}", error(r.order, &scaled)),
        ]);
    }
    let mut parts = vec![Part::Figure(figure), Part::Table(table), Part::Table(channels(subject, &errors))];
    parts.extend(published(subject)?);
    Ok(parts)
}

/// Compares the poles published by the source of the coefficients with those computed from the coefficients.
///
/// # Errors
/// Errors of trim and linearisation.
fn published(subject: &Subject) -> Result<Vec<Part>, Error> {
    let Some(printed) = &subject.inputs.vehicle.published_linear_model else { return Ok(vec![]) };
    let computed = subject.inputs.axis().linearise(printed.speed)?;
    let heave = turning(computed.states)[0];
    let size = computed.a.nrows() - heave;
    let without_surge = computed.a.view((heave, heave), (size, size)).into_owned();
    let mut table = Table::new(["linear model", "poles (rad/s)"]);
    for (model, found) in [
        (format!("published: {}", printed.source), &printed.poles),
        ("computed from the coefficients, about the trim".into(), &computed.eigenvalues()),
        ("the same without surge".into(), &eigenvalues(&without_surge)),
    ] {
        table.rows.push(vec![model, poles(found)]);
    }
    let caption = format!(
        "The linear model published with the coefficients, at {} m/s. {}",
        printed.speed, printed.note
    );
    Ok(vec![Part::Text(caption), Part::Table(table)])
}

/// Returns poles as text; a complex pair is listed once.
fn poles(all: &[Complex<f64>]) -> String {
    let one = |p: &Complex<f64>| match p.im {
        0.0 => format!("{:.3}", p.re),
        im => format!("{:.3} +- {im:.3}j", p.re),
    };
    let mut upper: Vec<&Complex<f64>> = all.iter().filter(|p| p.im >= 0.0).collect();
    upper.sort_by(|p, q| p.re.total_cmp(&q.re));
    upper.into_iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Returns the table of the errors of each channel.
fn channels(subject: &Subject, errors: &[frequency::Errors]) -> Table {
    let mut table = Table::new(["channel"]);
    table.head.extend(errors.iter().map(|e| format!("largest error of the response, order {}, %", e.order)));
    let outputs = frequency::outputs(subject.inputs.design.states).into_iter().enumerate();
    for (i, output) in outputs.filter(|(_, output)| output.is_among(subject.inputs.design.states)) {
        for (j, actuator) in subject.inputs.vehicle.actuators.iter().enumerate() {
            let mut row = vec![format!("{} to {}", actuator.name, output.name)];
            row.extend(errors.iter().map(|e| format!("{:.3}", 100.0 * e.channels[(i, j)])));
            table.rows.push(row);
        }
    }
    table
}

fn response(
    title: &str,
    models: &[Mat],
    (input, states): (usize, States),
    y: Axis,
    of: &dyn Fn(Complex<f64>) -> f64,
) -> Chart {
    let axis: Vec<f64> = (0..=150).map(|i| 10f64.powf(-2.0 + f64::from(i) / 50.0)).collect();
    let curve = |(key, ab): (usize, &Mat)| {
        let system = frequency::system(ab, states);
        let last = system.c.nrows() - 1;
        let at = |omega: f64| Some((omega, of(system.response(Complex::new(0.0, omega))?[(last, input)])));
        let mut points: Vec<(f64, f64)> = axis.iter().filter_map(|omega| at(*omega)).collect();
        if y.label.starts_with("phase") {
            unwrap(&mut points);
        }
        Curve { key, points }
    };
    Chart::over_frequency(title, y.clone(), models.iter().enumerate().map(curve).collect())
}

/// Removes jumps by 360 from a phase in degrees.
pub fn unwrap(points: &mut [(f64, f64)]) {
    for i in 1..points.len() {
        let turns = ((points[i].1 - points[i - 1].1) / 360.0).round();
        points[i].1 -= 360.0 * turns;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A complex pair of poles is one entry.
    #[test]
    fn poles_are_listed_in_pairs() {
        let c = Complex::new;
        assert_eq!(poles(&[c(0.174, 0.509), c(0.174, -0.509), c(-2.44, 0.0)]), "-2.440, 0.174 +- 0.509j");
    }
}
