//! Proof of the sampled loop, compared with lifting.

use crate::designs::{Made, made};
use squid_design::augment::augment;
use squid_design::certify::sampled::sampled;
use squid_design::check::sampled::trapezoidal;
use squid_lpv::analysis::{Exogenous, sampled_gain};
use squid_lpv::direct_path::around;

/// Sampling increases the proved gain by less than 3 %. At constant speeds the plant of the proof, discretised by the
/// trapezoidal rule, has the gain of the plant itself under a hold, including between the ticks.
#[test]
fn proved_gain_covers_lifted_gain() {
    for (name, delay) in [("squid", 0.0), ("remus100", 0.0), ("remus100", 0.04)] {
        let with_delay;
        let Made { inputs, model, design, .. } = if delay > 0.0 {
            with_delay = Made::with_delay(name, delay);
            &with_delay
        } else {
            made(name)
        };
        let (file, time) = (&inputs.design, inputs.design.sample_time);
        let proved = sampled(&inputs.axis(), file, model, design).unwrap().theorem.gamma.unwrap();
        let continuous = design.certified.gamma;
        println!("{name}, {delay} s late: {continuous:.4} in continuous time, {proved:.4} sampled");
        assert!(proved < 1.03 * continuous);
        let undelayed = squid_design::inputs::design_file::DesignFile { delay: 0.0, ..file.clone() };
        let plant = augment(&inputs.vehicle.actuators, &undelayed, model.linear()).unwrap();
        let ticks = plant.at_ticks(time).unwrap();
        let controller = &design.controller;
        let delayed = controller.delayed_at_ticks(file.delay_ticks(), time);
        let closed = ticks.plant.close(&around(&delayed, &-&ticks.d22).unwrap());
        for rho in [-1.0, -0.4, 0.3, 1.0] {
            let k =
                trapezoidal(&controller.frozen(&[rho]).unwrap(), time).unwrap().delayed(file.delay_ticks());
            let lifted = sampled_gain(&plant.frozen(&[rho]).unwrap(), &k, time, Exogenous::Held).unwrap();
            let found = closed.frozen(&[rho]).unwrap().hinf_norm().value;
            println!("  rho = {rho}: {:.5} by lifting, {found:.5} by the trapezoidal rule", lifted.upper);
            // The fastest filters have corners of 10 rad/s: (10 T)^2/12 is 3.3e-3.
            assert!((found / lifted.upper - 1.0).abs() < 3.4e-3);
            assert!(found < proved && lifted.upper < proved);
        }
    }
}
