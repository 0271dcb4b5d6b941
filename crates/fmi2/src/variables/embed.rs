//! Reuse of the variables of a model in a larger model that contains it.

use crate::Variable;
use crate::variables::role::{Get, Set};
use crate::variables::variable::Access;

impl<M: 'static> Variable<M> {
    /// Converts the variable to one of a model that contains `M`; name, description and dependencies are unchanged.
    ///
    /// ```
    /// use squid_fmi2::{Role, Variable};
    /// struct Thruster { command: f64 }
    /// struct Vehicle { thruster: Thruster }
    ///
    /// let role = Role::input(|t: &mut Thruster, value| t.command = value);
    /// let alone = Variable::real("command", "commanded force", |t: &Thruster| t.command, role).unit("N");
    /// let within: Variable<Vehicle> = alone.embedded(|v: &Vehicle| &v.thruster, |v| &mut v.thruster);
    /// ```
    #[must_use]
    pub fn embedded<N: 'static>(
        self,
        part: impl Fn(&N) -> &M + Copy + Send + Sync + 'static,
        part_mut: impl Fn(&mut N) -> &mut M + Copy + Send + Sync + 'static,
    ) -> Variable<N> {
        let access = match self.access {
            Access::Real(get, set) => Access::Real(read(get, part), write(set, part_mut)),
            Access::Integer(get, set) => Access::Integer(read(get, part), write(set, part_mut)),
            Access::Boolean(get, set) => Access::Boolean(read(get, part), write(set, part_mut)),
            Access::String(get, set) => Access::String(read(get, part), write(set, part_mut)),
            Access::Enumeration(get, set, last) => {
                Access::Enumeration(read(get, part), write(set, part_mut), last)
            }
        };
        Variable { meta: self.meta, access, quantity: self.quantity, slope: write(self.slope, part_mut) }
    }
}

fn read<M: 'static, N: 'static, T: 'static>(
    get: Get<M, T>,
    part: impl Fn(&N) -> &M + Send + Sync + 'static,
) -> Get<N, T> {
    Box::new(move |whole| get(part(whole)))
}

fn write<M: 'static, N: 'static, T: 'static>(
    set: Option<Set<M, T>>,
    part_mut: impl Fn(&mut N) -> &mut M + Send + Sync + 'static,
) -> Option<Set<N, T>> {
    let set = set?;
    Some(Box::new(move |whole, value| set(part_mut(whole), value)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Role;

    struct Part {
        gain: f64,
        mode: i32,
    }

    struct Whole {
        part: Part,
    }

    #[test]
    fn embedded_variable_reads_and_sets_the_part() {
        let gain =
            Variable::real("gain", "gain", |m: &Part| m.gain, Role::parameter(|m: &mut Part, v| m.gain = v))
                .unit("rad")
                .range(-1.0, 1.0);
        let meta = gain.meta.clone();
        let within: Variable<Whole> = gain.embedded(|w: &Whole| &w.part, |w| &mut w.part);
        assert_eq!(within.meta, meta);
        let mut whole = Whole { part: Part { gain: 0.5, mode: 2 } };
        let Access::Real(get, Some(set)) = &within.access else { panic!("still a Real that can be set") };
        assert_eq!(get(&whole), 0.5);
        set(&mut whole, 0.25);
        assert_eq!(whole.part.gain, 0.25);
    }

    #[test]
    fn embedding_keeps_a_missing_setter_and_the_items() {
        let methods = squid_model_description::Enumeration::new("mode", "mode", &[("a", "a"), ("b", "b")]);
        let mode = Variable::enumeration("mode", "mode", &methods, |m: &Part| m.mode, Role::output());
        let within: Variable<Whole> = mode.embedded(|w: &Whole| &w.part, |w| &mut w.part);
        let whole = Whole { part: Part { gain: 0.5, mode: 2 } };
        let Access::Enumeration(get, None, 2) = &within.access else { panic!("two items, no setter") };
        assert_eq!(get(&whole), 2);
    }
}
