//! Lift, damping and added mass that feed energy to the motion, which is physically impossible.

use crate::text::rounded;
use crate::vehicle::Vehicle;
use crate::vehicle::coefficients::Coefficients;
use squid_finding::Finding;

/// Tolerance of the inequality for rounded numbers of a source.
const ROUNDING: f64 = 0.1;
/// Relative tolerance within which ratios of linear damping to lift count as one speed.
const ALIKE: f64 = 0.01;
/// Largest difference of coefficients that are equal in theory, relative to the larger one.
const UNEQUAL: f64 = 0.5;

/// Force and moment of a motion across the hull and a rotation, `[F_w w + F_q q, M_w w + M_q q]` for one axis: they
/// dissipate energy in every such motion if `F_w <= 0`, `M_q <= 0` and `(F_q + M_w)^2/4 <= F_w M_q`.
struct Form {
    keys: [&'static str; 4],
    force: f64,
    cross: f64,
    damping: f64,
    /// Terms that splitting combined lift adds to `cross` and `damping`.
    split: [f64; 2],
}

impl Form {
    /// Returns the two sides of the inequality, with combined lift split `split` more times than in the file.
    fn sides(&self, split: f64) -> [f64; 2] {
        let [cross, damping] = [self.cross + split * self.split[0], self.damping + split * self.split[1]];
        [0.25 * cross * cross, self.force * damping]
    }

    fn dissipates(&self, split: f64) -> bool {
        let [left, right] = self.sides(split);
        left <= (1.0 + ROUNDING) * right
    }

    /// Returns a finding if the form feeds energy to the motion; a wrong sign of the force or the damping alone is a
    /// finding of its own.
    fn finding(&self) -> Option<Finding> {
        if self.dissipates(0.0) || self.force > 0.0 || self.damping > 0.0 {
            return None;
        }
        let ([force, by_turn, moment, damping], [left, right]) = (self.keys, self.sides(0.0));
        let advice = match [1.0, -1.0].map(|split| self.split != [0.0; 2] && self.dissipates(split)) {
            [true, _] => "they would oppose the motion with 'lift.convention' \"combined\"",
            [_, true] => "they would oppose the motion with 'lift.convention' \"viscous\"",
            _ if self.split == [0.0; 2] => "give lift and the Munk moment in [lift]",
            _ => "check their signs and units",
        };
        let why = format!(
            "'{by_turn}' and '{moment}' drive the hull: without the terms of added mass ({by_turn} + {moment})^2/4 is \
             {}, and more than {force} {damping}, {}; {advice}",
            rounded(left),
            rounded(right)
        );
        Some(Finding::new("feeds_energy", moment, why).value(left, "").limit(right))
    }
}

impl Vehicle {
    /// Returns findings on lift and damping that feed energy to the motion, on lift given twice, and on asymmetric
    /// added mass.
    pub(super) fn lift(&self) -> Vec<Finding> {
        let c = &self.coefficients;
        let given = |keys: &[&str]| keys.iter().any(|key| self.sources.contains_key(*key));
        let form = |keys, [force, by_turn, moment, damping]: [f64; 4], split| Form {
            keys,
            force,
            cross: by_turn + moment,
            damping,
            split,
        };
        let forms = [
            form(LIFT, [c.Z_uw, c.Z_uq, c.M_uw, c.M_uq], [c.Z_w_dot, c.Z_q_dot]),
            form(
                ["Y_uv", "Y_ur", "N_uv", "N_ur"],
                [c.Y_uv, c.Y_ur, c.N_uv, c.N_ur],
                [-c.Y_v_dot, -c.Y_r_dot],
            ),
            form(DAMPING, [c.Z_w, c.Z_q, c.M_w, c.M_q], [0.0; 2]),
            form(["Y_v", "Y_r", "N_v", "N_r"], [c.Y_v, c.Y_r, c.N_v, c.N_r], [0.0; 2]),
        ];
        let driving = forms.iter().filter(|form| given(&form.keys)).filter_map(Form::finding);
        let difference = (c.Z_q_dot - c.M_w_dot).abs();
        let unequal = (difference > UNEQUAL * c.Z_q_dot.abs().max(c.M_w_dot.abs())).then(|| {
            let why = format!(
                "'Z_q_dot' is {} kg.m and 'M_w_dot' {} kg.m; the matrix of added mass is symmetric, so they should be \
                 equal: check their signs and units",
                rounded(c.Z_q_dot),
                rounded(c.M_w_dot)
            );
            Finding::new("asymmetric_added_mass", "Z_q_dot", why).value(c.Z_q_dot, "kg.m").limit(c.M_w_dot)
        });
        driving.chain(given_twice(c)).chain(unequal).collect()
    }
}

const LIFT: [&str; 4] = ["Z_uw", "Z_uq", "M_uw", "M_uq"];
const DAMPING: [&str; 4] = ["Z_w", "Z_q", "M_w", "M_q"];

/// Returns a finding on linear damping that equals the lift, combined or not, at one speed.
fn given_twice(c: &Coefficients) -> Option<Finding> {
    let linear = [c.Z_w, c.Z_q, c.M_w, c.M_q];
    let speed = |added: f64| {
        let munk = c.Z_w_dot - c.X_u_dot;
        let lift = [c.Z_uw, c.Z_uq - added * c.X_u_dot, c.M_uw - added * munk, c.M_uq - added * c.Z_q_dot];
        let pairs = || linear.into_iter().zip(lift).filter(|(linear, _)| *linear != 0.0);
        let (first, lift) = pairs().next()?;
        let speed = first / lift;
        let agrees = |(linear, lift): (f64, f64)| (linear - speed * lift).abs() <= ALIKE * linear.abs();
        (speed.is_finite() && pairs().count() > 1 && pairs().all(agrees)).then_some(speed)
    };
    let speed = speed(0.0).or_else(|| speed(1.0))?;
    let named = |keys: [&str; 4]| {
        let given = keys.into_iter().zip(linear).filter(|(_, linear)| *linear != 0.0);
        given.map(|(key, _)| format!("'{key}'")).collect::<Vec<_>>().join(", ")
    };
    let why = format!(
        "{} are {} times {} m/s: the same forces are given twice; [damping] is for forces that also act at rest",
        named(DAMPING),
        named(LIFT),
        rounded(speed)
    );
    Some(Finding::new("lift_given_twice", "damping", why).speed(speed))
}
