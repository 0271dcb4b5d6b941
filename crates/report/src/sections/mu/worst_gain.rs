//! The worst-case gain at one speed, for constant coefficient errors.

use squid_lpv::mu::CMat;
use squid_lpv::mu::worst_case::{Perturbable, worst_case_gain};
use squid_lpv::state_space::StateSpace;

/// The fractions of the declared uncertainty for which the gain is bounded.
pub const PARTS: [f64; 2] = [0.25, 1.0];

/// The effect of constant coefficient errors on the gain from w to z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstGain {
    /// The gain without errors.
    pub nominal: f64,
    /// Upper and lower bound at each of [`PARTS`]; `None` if the loop is not shown to stay stable.
    pub at: [Option<(f64, f64)>; PARTS.len()],
    /// The gain of a retrimmed vehicle with the coefficients of the worst perturbation.
    pub vehicle: [Option<f64>; PARTS.len()],
}

impl WorstGain {
    /// Bounds the gain of a loop with mu for robust stability below `mu`. `vehicle` gives the gain of a vehicle with
    /// the coefficients of a perturbation.
    pub fn new(whole: &Perturbable, mu: f64, vehicle: &dyn Fn(&CMat) -> Option<f64>) -> Self {
        let at = |size: f64| {
            // If mu does not exclude an unstable loop, there is no bound.
            let sized = (size * mu < 1.0).then(|| Perturbable { size, ..whole.clone() });
            worst_case_gain(&sized?).ok()
        };
        let gains = PARTS.map(at);
        Self {
            nominal: unperturbed(whole).hinf_norm().value,
            at: gains.each_ref().map(|g| g.as_ref().map(|g| (g.upper, g.worst.gain))),
            vehicle: gains.each_ref().map(|g| vehicle(&g.as_ref()?.worst.delta)),
        }
    }
}

/// The gain from w to z without perturbation.
fn unperturbed(whole: &Perturbable) -> StateSpace {
    let (outputs, inputs) = whole.system.d.shape();
    whole.system.parts(whole.structure.cols()..outputs, whole.structure.rows()..inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;
    use squid_lpv::matrix::Mat;
    use squid_lpv::mu::{Block, Structure};

    /// `x' = -x + c delta x + w`, z = x: the gain is `1/(1 - c delta)`, and mu is c.
    #[test]
    fn gains_that_are_known() {
        let of = |c: f64| {
            let system = StateSpace {
                a: dmatrix![-1.0],
                b: dmatrix![c, 1.0],
                c: dmatrix![1.0; 1.0],
                d: Mat::zeros(2, 2),
            };
            let gain = |delta: &CMat| Some(1.0 / (1.0 - c * delta[(0, 0)].re));
            let structure = Structure::new(vec![Block::Real(1)]).unwrap();
            WorstGain::new(&Perturbable { system, structure, size: 1.0 }, c, &gain)
        };
        let found = of(0.8);
        assert!((found.nominal - 1.0).abs() < 1e-9);
        for ((part, at), vehicle) in PARTS.iter().zip(found.at).zip(found.vehicle) {
            assert!((vehicle.unwrap() / (1.0 / (1.0 - 0.8 * part)) - 1.0).abs() < 1e-9);
            let (exact, (upper, lower)) = (1.0 / (1.0 - 0.8 * part), at.unwrap());
            assert!(upper >= exact && upper < 1.001 * exact, "{upper} {exact}");
            assert!((lower / exact - 1.0).abs() < 1e-9, "{lower} {exact}");
        }
        let found = of(2.0);
        assert!(found.at[0].is_some() && found.at[1].is_none(), "{found:?}");
        assert_eq!(of(5.0).at, [None; 2]);
    }
}
