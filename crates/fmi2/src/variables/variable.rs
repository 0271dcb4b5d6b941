//! An entry of a model's table of variables: attributes in the XML, getter and setter.

use std::borrow::Cow;
use std::fmt;

use squid_model_description::{Dependency, DependencyKind, Enumeration, Kind, ScalarVariable, Variability};

use crate::variables::role::{Get, Role, Set};

/// Getter and setter of a value in the model.
pub enum Access<M> {
    /// Floating point.
    Real(Get<M, f64>, Option<Set<M, f64>>),
    /// 32-bit integer.
    Integer(Get<M, i32>, Option<Set<M, i32>>),
    /// Boolean.
    Boolean(Get<M, bool>, Option<Set<M, bool>>),
    /// Text.
    String(Get<M, String>, Option<Set<M, String>>),
    /// One of the items of the type, counted from 1 to the last number.
    Enumeration(Get<M, i32>, Option<Set<M, i32>>, i32),
}

/// Function that combines getter and setter in an [`Access`].
type MakeAccess<'a, M, T> = &'a dyn Fn(Get<M, T>, Option<Set<M, T>>) -> Access<M>;

/// An entry of a model's table of variables.
///
/// A constructor takes the getter and the [`Role`] with the setter; unit, range and dependencies follow. The start
/// value in the XML is that of the newly loaded model.
///
/// ```
/// use squid_fmi2::{Role, Variable};
/// struct Thruster { force: f64, command: f64 }
/// type V = Variable<Thruster>;
/// type R<T> = Role<Thruster, T>;
///
/// let command = V::real("command", "commanded force", |t| t.command, R::input(|t, value| t.command = value))
///     .unit("N")
///     .range(-60.0, 100.0);
/// let force = V::real("force", "force on the vehicle", |t| t.force, R::output()).unit("N").depends_on(&[]);
/// ```
pub struct Variable<M> {
    /// Attributes in the XML; boxed, so that a table is small and fast to iterate over.
    pub(crate) meta: Box<ScalarVariable>,
    pub(crate) access: Access<M>,
    /// Index among the quantities of [`Tangents`](crate::Tangents).
    pub(crate) quantity: Option<usize>,
    /// Setter of the rate at which an input changes.
    pub(crate) slope: Option<Set<M, f64>>,
}

impl<M> Variable<M> {
    /// Creates a floating-point variable.
    pub fn real<'a>(
        name: impl Into<Cow<'a, str>>,
        description: impl Into<Cow<'a, str>>,
        get: impl Fn(&M) -> f64 + Send + Sync + 'static,
        role: Role<M, f64>,
    ) -> Self {
        Self::of_real(name.into(), description.into(), Box::new(get), role)
    }

    /// Creates a Real from a boxed getter; compiled once, not for each variable, to keep an FMU small.
    #[inline(never)]
    fn of_real(name: Cow<'_, str>, description: Cow<'_, str>, get: Get<M, f64>, role: Role<M, f64>) -> Self {
        let kind =
            Kind::Real { unit: None, display_unit: None, min: None, max: None, nominal: None, start: None };
        Self::of(name, description, Variability::Continuous, kind, get, role, &Access::Real)
    }

    /// Creates a variable of any type, compiled once for all getters; `usual` is the variability if the role has
    /// none.
    fn of<T>(
        name: Cow<'_, str>,
        description: Cow<'_, str>,
        usual: Variability,
        kind: Kind,
        get: Get<M, T>,
        role: Role<M, T>,
        access: MakeAccess<'_, M, T>,
    ) -> Self {
        let meta = ScalarVariable {
            name: name.into_owned(),
            value_reference: 0,
            description: description.into_owned(),
            causality: role.causality,
            variability: role.variability.unwrap_or(usual),
            initial: None,
            kind,
            derivative_of: None,
            depends_on: None,
            initially_depends_on: None,
        };
        Self { meta: Box::new(meta), access: access(get, role.set), quantity: None, slope: None }
    }

    /// Creates an integer variable.
    pub fn integer<'a>(
        name: impl Into<Cow<'a, str>>,
        description: impl Into<Cow<'a, str>>,
        get: impl Fn(&M) -> i32 + Send + Sync + 'static,
        role: Role<M, i32>,
    ) -> Self {
        let kind = Kind::Integer { min: None, max: None, start: None };
        let usual = Variability::Discrete;
        Self::of(name.into(), description.into(), usual, kind, Box::new(get), role, &Access::Integer)
    }

    /// Creates a Boolean variable.
    pub fn boolean<'a>(
        name: impl Into<Cow<'a, str>>,
        description: impl Into<Cow<'a, str>>,
        get: impl Fn(&M) -> bool + Send + Sync + 'static,
        role: Role<M, bool>,
    ) -> Self {
        let (usual, kind) = (Variability::Discrete, Kind::Boolean { start: None });
        Self::of(name.into(), description.into(), usual, kind, Box::new(get), role, &Access::Boolean)
    }

    /// Creates a text variable.
    pub fn string<'a>(
        name: impl Into<Cow<'a, str>>,
        description: impl Into<Cow<'a, str>>,
        get: impl Fn(&M) -> String + Send + Sync + 'static,
        role: Role<M, String>,
    ) -> Self {
        let (usual, kind) = (Variability::Discrete, Kind::String { start: None });
        Self::of(name.into(), description.into(), usual, kind, Box::new(get), role, &Access::String)
    }

    /// Creates a choice among the items of `of_type`, counted from 1; other numbers are refused before the setter.
    pub fn enumeration<'a>(
        name: impl Into<Cow<'a, str>>,
        description: impl Into<Cow<'a, str>>,
        of_type: &Enumeration,
        get: impl Fn(&M) -> i32 + Send + Sync + 'static,
        role: Role<M, i32>,
    ) -> Self {
        let kind = Kind::Enumeration { declared_type: of_type.name.clone(), start: None };
        let last = i32::try_from(of_type.items.len()).unwrap_or(i32::MAX);
        let (usual, access) = (Variability::Discrete, |get, set| Access::Enumeration(get, set, last));
        Self::of(name.into(), description.into(), usual, kind, Box::new(get), role, &access)
    }

    /// Sets the unit of a Real variable; the display unit of radians to the first power is degrees.
    #[must_use]
    pub fn unit(mut self, name: &str) -> Self {
        if let Kind::Real { unit, display_unit, .. } = &mut self.meta.kind {
            let read = squid_model_description::Unit::parse(name).ok();
            *display_unit = read.and_then(|unit| unit.display_units.into_iter().next()).map(|unit| unit.name);
            *unit = Some(name.to_owned());
        }
        self
    }

    /// Sets minimum and maximum of a Real variable.
    #[must_use]
    pub fn range(self, least: f64, greatest: f64) -> Self {
        self.at_least(least).at_most(greatest)
    }

    /// Sets the minimum of a Real variable, or of an Integer: an integer.
    #[must_use]
    pub fn at_least(mut self, least: f64) -> Self {
        match &mut self.meta.kind {
            Kind::Real { min, .. } => *min = Some(least),
            Kind::Integer { min, .. } => *min = Some(least as i32),
            _ => {}
        }
        self
    }

    /// Sets the maximum of a Real variable.
    #[must_use]
    pub fn at_most(mut self, greatest: f64) -> Self {
        if let Kind::Real { max, .. } = &mut self.meta.kind {
            *max = Some(greatest);
        }
        self
    }

    /// Sets the nominal magnitude of a Real variable.
    #[must_use]
    pub fn nominal(mut self, value: f64) -> Self {
        if let Kind::Real { nominal, .. } = &mut self.meta.kind {
            *nominal = Some(value);
        }
        self
    }

    /// Marks a variable that changes at events only, such as the ticks of a sampled system.
    #[must_use]
    pub fn discrete(mut self) -> Self {
        self.meta.variability = Variability::Discrete;
        self
    }

    /// Marks the time derivative of the state of the given name; the order of the derivatives is that of the states.
    #[must_use]
    pub fn derivative_of(mut self, state: &str) -> Self {
        self.meta.derivative_of = Some(state.to_owned());
        self
    }

    /// Sets the index of the variable among the quantities of the model's [`Tangents`](crate::Tangents).
    #[must_use]
    pub fn quantity(mut self, number: usize) -> Self {
        self.quantity = Some(number);
        self
    }

    /// Offsets the index among the quantities, for a model that is one of several in another.
    #[must_use]
    pub fn quantity_from(mut self, first: usize) -> Self {
        self.quantity = self.quantity.map(|number| first + number);
        self
    }

    /// Sets the setter of the rate at which a Real input changes during the next step (`fmi2SetRealInputDerivatives`);
    /// the model advances the input, and the rate is set to zero after the step.
    #[must_use]
    pub fn slope(mut self, set: impl Fn(&mut M, f64) + Send + Sync + 'static) -> Self {
        self.slope = Some(Box::new(set));
        self
    }

    /// Sets the inputs and states on which an output or derivative depends instantaneously; by default all of them.
    #[must_use]
    pub fn depends_on(mut self, names: &[&str]) -> Self {
        self.meta.depends_on = Some(dependencies(names));
        self
    }

    /// Adds a dependency with a constant factor to those of [`depends_on`](Self::depends_on).
    #[must_use]
    pub fn depends_linearly_on(mut self, name: &str) -> Self {
        let one = Dependency { on: name.to_owned(), kind: DependencyKind::Constant };
        self.meta.depends_on.get_or_insert_default().push(one);
        self
    }

    /// Removes dependencies on variables that are not inputs or states of a larger model.
    #[must_use]
    pub fn depends_only_where(mut self, known: impl Fn(&str) -> bool) -> Self {
        if let Some(list) = &mut self.meta.depends_on {
            list.retain(|dependency| known(&dependency.on));
        }
        self
    }

    /// Sets the knowns on which the initial value of an output depends; by default all of them.
    #[must_use]
    pub fn initially_depends_on(mut self, names: &[&str]) -> Self {
        self.meta.initially_depends_on = Some(dependencies(names));
        self
    }

    /// Returns the name of the variable.
    pub fn name(&self) -> &str {
        &self.meta.name
    }

    /// Returns the attributes with the start value of the newly loaded model, if the standard requires one.
    pub(crate) fn described(&self, value_reference: u32, model: &M) -> ScalarVariable {
        let mut meta = (*self.meta).clone();
        meta.value_reference = value_reference;
        if !meta.needs_start() {
            return meta;
        }
        match (&mut meta.kind, &self.access) {
            (Kind::Real { start, .. }, Access::Real(get, _)) => *start = Some(get(model)),
            (Kind::Integer { start, .. }, Access::Integer(get, _))
            | (Kind::Enumeration { start, .. }, Access::Enumeration(get, _, _)) => *start = Some(get(model)),
            (Kind::Boolean { start }, Access::Boolean(get, _)) => *start = Some(get(model)),
            (Kind::String { start }, Access::String(get, _)) => *start = Some(get(model)),
            _ => {}
        }
        meta
    }
}

fn dependencies(names: &[&str]) -> Vec<Dependency> {
    let dependent = |name: &&str| Dependency { on: (*name).to_owned(), kind: DependencyKind::Dependent };
    names.iter().map(dependent).collect()
}

impl<M> fmt::Debug for Variable<M> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.meta.fmt(formatter)
    }
}
