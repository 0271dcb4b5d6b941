//! Worst-case gain at one speed, for constant coefficient errors.

use squid_lpv::mu::CMat;
use squid_lpv::mu::worst_case::{Perturbable, worst_case_gain};
use squid_lpv::state_space::StateSpace;

/// Fractions of the declared uncertainty for which the gain is bounded.
pub const PARTS: [f64; 2] = [0.25, 1.0];

/// Effect of constant coefficient errors on the gain from w to z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstGain {
    /// Gain without errors.
    pub nominal: f64,
    /// Upper and lower bound at each of [`PARTS`]; `None` if the loop is not shown to stay stable.
    pub at: [Option<(f64, f64)>; PARTS.len()],
    /// Gain of a retrimmed vehicle with the coefficients of the worst perturbation.
    pub vehicle: [Option<f64>; PARTS.len()],
}

impl WorstGain {
    /// Bounds the gain of a loop whose mu for robust stability is below `mu`. `vehicle` returns the gain of a vehicle
    /// with the coefficients of a perturbation.
    pub fn new(uncertain: &Perturbable, mu: f64, vehicle: &dyn Fn(&CMat) -> Option<f64>) -> Self {
        let at = |size: f64| {
            // There is no bound if mu does not exclude an unstable loop.
            let sized = (size * mu < 1.0).then(|| Perturbable { size, ..uncertain.clone() });
            worst_case_gain(&sized?).ok()
        };
        let gains = PARTS.map(at);
        Self {
            nominal: unperturbed(uncertain).hinf_norm().value,
            at: gains.each_ref().map(|g| g.as_ref().map(|g| (g.upper, g.worst.gain))),
            vehicle: gains.each_ref().map(|g| vehicle(&g.as_ref()?.worst.delta)),
        }
    }
}

/// Returns the system from w to z without perturbation.
fn unperturbed(uncertain: &Perturbable) -> StateSpace {
    let (outputs, inputs) = uncertain.system.d.shape();
    uncertain.system.parts(uncertain.structure.cols()..outputs, uncertain.structure.rows()..inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;
    use squid_lpv::matrix::Mat;
    use squid_lpv::mu::{Block, Structure};

    /// The gain of `x' = -x + c delta x + w`, z = x is `1/(1 - c delta)`, and mu is c.
    #[test]
    fn matches_known_gains() {
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
