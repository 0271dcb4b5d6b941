//! What the sign of a command means, in words.

/// A force or moment this small beside the largest of its actuator comes from rounding.
const LEAST_SHARE: f64 = 1e-6;

/// Surge force, heave force and pitch moment \[N, N, N m\] per output of an actuator about zero; those of a control
/// surface at a surge velocity of 1 m/s.
pub type Force = [f64; 3];

/// Returns what a positive output does, by the signs of its force (SNAME: z down, so that a positive pitch moment turns
/// the bow up); `None` where it does nothing.
///
/// `unit` is that of the output: `N` of a thrust, `rad` of a deflection, whose force changes its sign astern.
///
/// ```
/// let of_stern_planes = [0.0, -9.64, -6.15];
/// let words = "positive deflection, ahead, pushes up and turns the bow down";
/// assert_eq!(signals::sign_in_words(of_stern_planes, "rad").as_deref(), Some(words));
/// ```
pub fn sign_in_words(force: Force, unit: &str) -> Option<String> {
    let largest = force.iter().fold(0.0, |largest: f64, part| largest.max(part.abs()));
    let word = |part: f64, positive: &'static str, negative: &'static str| {
        (part.abs() > LEAST_SHARE * largest).then_some(if part > 0.0 { positive } else { negative })
    };
    let [surge, heave, pitch] = force;
    let push: Vec<_> =
        [word(surge, "forward", "astern"), word(heave, "down", "up")].into_iter().flatten().collect();
    let pushes = (!push.is_empty()).then(|| format!("pushes {}", push.join(" and ")));
    let turns = word(pitch, "turns the bow up", "turns the bow down").map(str::to_owned);
    let effects: Vec<_> = [pushes, turns].into_iter().flatten().collect();
    let output = if unit == "rad" { "deflection, ahead," } else { "thrust" };
    (!effects.is_empty()).then(|| format!("positive {output} {}", effects.join(" and ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signs_are_those_of_the_force() {
        for (force, unit, words) in [
            ([1.0, 0.0, 0.2], "N", "thrust pushes forward and turns the bow up"),
            ([1.0, 1e-17, 0.0], "N", "thrust pushes forward"),
            ([-0.6, 0.8, -0.1], "N", "thrust pushes astern and down and turns the bow down"),
            ([0.0, 0.0, 1.4], "N", "thrust turns the bow up"),
            ([0.0, -5.0, 7.0], "rad", "deflection, ahead, pushes up and turns the bow up"),
        ] {
            assert_eq!(sign_in_words(force, unit), Some(format!("positive {words}")));
        }
        assert_eq!(sign_in_words([0.0; 3], "N"), None);
    }
}
