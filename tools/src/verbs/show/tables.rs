//! Tables of `squid show`.

use crate::error::Error;
use crate::output::COLUMNS;
use nalgebra::Complex;
use squid_auv::readable;
use squid_auv::{Linearisation, Vehicle};
use squid_base::numbers::{above, decimals};
use squid_design::augment::augment;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::Mat;
use squid_scheduled::Gamma;

/// Width of the name of a row.
const HEAD: usize = 8;

/// Returns trim, A, B and eigenvalues at one speed.
pub fn speed(vehicle: &Vehicle, l: &Linearisation) -> String {
    let t = &l.trim;
    let mut out = format!(
        "Level trim at V = {:.3} m/s, {:.1} m deep\n  incidence = pitch  {:>9} deg\n  forward speed u    {:>9} \
            m/s\n  heave w            {:>9} m/s\n",
        t.speed,
        t.depth,
        decimals(t.incidence.to_degrees(), 4),
        decimals(t.forward_speed, 4),
        decimals(t.heave, 4)
    );
    for (actuator, value) in vehicle.actuators.iter().zip(&t.actuators) {
        let (factor, unit) = readable(actuator.unit());
        out += &format!("  {:<18} {:>9} {unit}\n", actuator.name, decimals(factor * value, 4));
    }
    let names: Vec<&str> = vehicle.actuators.iter().map(|a| a.name.as_str()).collect();
    let of_all = |of: fn(&squid_signals::State) -> &'static str| l.states.iter().map(of).collect::<Vec<_>>();
    let states = of_all(|state| state.symbol);
    out += &format!("\nA, x = [{}] in {}\n", states.join(" "), of_all(|state| state.unit).join(", "));
    out += &table(&l.a, &states, &states);
    out += "\nB, in x' per N or rad\n";
    out += &table(&l.b, &states, &names);
    out += &format!("\nEigenvalues of A (1/s)\n{}", modes(&l.eigenvalues()));
    out
}

/// Returns the fit: residuals of each order, and the largest residual of each entry of A and B.
pub fn fit(inputs: &Inputs, model: &Model) -> String {
    let mut out = String::from(
        "Polynomials in rho fitted to [A B]\n                                           largest residual     frequency \
         response\n  order   A: rms      of its variation   of [A B], 2-norm     to outputs   to the angle\n",
    );
    let responses =
        squid_design::fit::frequency::errors(&inputs.vehicle.actuators, &inputs.design.tracked, model);
    let most = squid_design::fit::frequency::turning_actuator(&inputs.vehicle.actuators, model);
    for r in &model.residuals {
        let response = responses.iter().find(|e| e.order == r.order);
        let (whole, pitch) = response.map_or((f64::NAN, f64::NAN), |e| (e.scaled, e.of_angle(most)));
        out += &format!(
            "  {:>5}   {:7.3} %   {:7.3} %          {:9.2e}            {:7.3} %    {:7.3} %\n",
            r.order,
            100.0 * r.a.relative_rms,
            100.0 * r.relative_to_variation,
            r.ab.norms.iter().copied().fold(0.0, f64::max),
            100.0 * whole,
            100.0 * pitch
        );
    }
    out += &format!(
        "  (frequency response: largest relative error over speeds and 0.01..10 rad/s, from all\n  actuators to the \
         tracked outputs in the scales of the design, and from {} to {})\n",
        inputs.vehicle.actuators[most].name,
        squid_design::fit::frequency::angle(inputs.design.states).name
    );
    let states: Vec<&str> = inputs.design.states.iter().map(|state| state.symbol).collect();
    let actuators = inputs.vehicle.actuators.iter().map(|a| a.name.as_str());
    let names: Vec<&str> = states.iter().copied().chain(actuators).collect();
    for r in model.residuals.iter().filter(|r| r.order <= 2 || r.order == inputs.design.order) {
        out += &format!("\nLargest residual of each entry of [A B] over the grid, order {}\n", r.order);
        out += &table(&r.ab.largest, &states, &names);
    }
    out += &format!(
        "\nLFT: {} channels of rho, within {:.1e} of the polynomial of order {} (largest singular value)\n",
        model.lft.size(),
        model.lft_error,
        inputs.design.order
    );
    out
}

/// Returns a controller: its size, and its poles at the ends and the centre of the range.
///
/// # Errors
/// [`ModelError::System`](squid_design::error::ModelError::System), which would be an internal error, and errors of the
/// model.
pub fn controller(inputs: &Inputs, k: &Controller, gamma: &Gamma) -> Result<String, Error> {
    let plant = augment(
        &inputs.vehicle.actuators,
        &inputs.design,
        Model::new(&inputs.axis(), &inputs.design)?.linear(),
    )?;
    let (centre, half_range) = inputs.design.scheduling();
    let built = if gamma.back_off > 0.0 {
        let level = gamma.optimum * (1.0 + gamma.back_off);
        format!("least gamma {:.4}, built at {level:.4}, ", gamma.optimum)
    } else {
        "given; ".to_owned()
    };
    let mut out = format!(
        "Controller: {} states, {} channels of rho, {} measurements, {} commands\n\
         {}bound of the finished loop {}\n",
        k.a().nrows(),
        k.bt().ncols(),
        k.by().ncols(),
        k.cu().nrows(),
        built,
        above(gamma.bound)
    );
    for rho in [-1.0, 0.0, 1.0] {
        let v = centre + half_range * rho;
        out += &format!("\nPoles of the controller at {v:.2} m/s (rho = {rho:+.0}), 1/s\n");
        out += &modes(&k.frozen(&[rho])?.poles());
        out += &format!(
            "Poles of the closed loop at this speed, 1/s\n{}",
            modes(&plant.close(k).frozen(&[rho])?.poles())
        );
    }
    Ok(out)
}

/// Returns a matrix as a table with as many columns side by side as fit, and the others below.
pub fn table(m: &Mat, rows: &[&str], columns: &[&str]) -> String {
    let width = |j: usize| columns[j].len().max(11) + 1;
    let mut out = String::new();
    let mut from = 0;
    while from < m.ncols() {
        let mut to = from + 1;
        let wide = |to: usize| HEAD + (from..to).map(width).sum::<usize>();
        while to < m.ncols() && wide(to + 1) <= COLUMNS {
            to += 1;
        }
        out += &format!("{:HEAD$}", "");
        (from..to).for_each(|j| out += &format!("{:>1$}", columns[j], width(j)));
        out.push('\n');
        for (i, row) in rows.iter().enumerate() {
            out += &format!("  {row:<6}");
            (from..to).for_each(|j| out += &format!("{:>1$}", decimals(m[(i, j)], 6), width(j)));
            out.push('\n');
        }
        from = to;
    }
    out
}

/// Returns real modes, one per line, and complex pairs once, with their damping.
pub fn modes(values: &[Complex<f64>]) -> String {
    let shown = values.iter().filter(|v| v.im >= 0.0);
    shown
        .map(|v| {
            if v.im == 0.0 {
                format!("  {:>11}\n", decimals(v.re, 5))
            } else {
                let (re, im, damping) = (decimals(v.re, 5), v.im, decimals(-v.re / v.norm(), 3));
                format!("  {re:>11} +- {im:.5}i   (damping {damping})\n")
            }
        })
        .collect()
}
