//! Scalar variables (section 2.2.7).

/// Variable of the model, with its dependencies.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarVariable {
    /// Unique name.
    pub name: String,
    /// Handle for the C functions.
    pub value_reference: u32,
    /// Meaning of the variable in one sentence.
    pub description: String,
    /// Role in connections.
    pub causality: Causality,
    /// Variability of the value.
    pub variability: Variability,
    /// Initialisation of the value; `None` for the default of the standard.
    pub initial: Option<Initial>,
    /// Type with its attributes.
    pub kind: Kind,
    /// Name of the state whose time derivative this is.
    pub derivative_of: Option<String>,
    /// Direct dependencies of an output or derivative; `None` means all variables.
    pub depends_on: Option<Vec<Dependency>>,
    /// Direct dependencies of the initial value; `None` means all variables.
    pub initially_depends_on: Option<Vec<Dependency>>,
}

/// Type of a variable, with the attributes of this type.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Floating point.
    Real {
        /// Unit of the value.
        unit: Option<String>,
        /// Unit in which a tool should display the value.
        display_unit: Option<String>,
        /// Smallest value.
        min: Option<f64>,
        /// Largest value.
        max: Option<f64>,
        /// Typical magnitude.
        nominal: Option<f64>,
        /// Start value.
        start: Option<f64>,
    },
    /// 32-bit integer.
    Integer {
        /// Smallest value.
        min: Option<i32>,
        /// Largest value.
        max: Option<i32>,
        /// Start value.
        start: Option<i32>,
    },
    /// Boolean.
    Boolean {
        /// Start value.
        start: Option<bool>,
    },
    /// Text.
    String {
        /// Start value.
        start: Option<String>,
    },
    /// Item of a declared type.
    Enumeration {
        /// Name of the declared type.
        declared_type: String,
        /// Start value, counted from 1.
        start: Option<i32>,
    },
}

/// Role of a variable in connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Value set before the simulation.
    Parameter,
    /// Value computed from parameters.
    CalculatedParameter,
    /// Value set by another model.
    Input,
    /// Value used by another model.
    Output,
    /// Internal value, for display.
    Local,
}

/// Variability of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Constant.
    Constant,
    /// Constant after initialisation.
    Fixed,
    /// Changed by the user between communication points.
    Tunable,
    /// Changed at events only.
    Discrete,
    /// Changed at any time.
    Continuous,
}

/// Initialisation of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// Start value.
    Exact,
    /// Start value as a guess.
    Approx,
    /// Value computed from other variables.
    Calculated,
}

/// Entry of `dependencies` and `dependenciesKind`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependency {
    /// Name of the variable on which another one depends.
    pub on: String,
    /// Kind of the dependency.
    pub kind: DependencyKind,
}

/// Kind of a dependency, as far as it is distinguished here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DependencyKind {
    /// No particular structure.
    Dependent,
    /// A constant factor.
    Constant,
}

impl ScalarVariable {
    /// Returns the unit of a Real variable.
    pub fn unit(&self) -> Option<&str> {
        match &self.kind {
            Kind::Real { unit, .. } => unit.as_deref(),
            _ => None,
        }
    }

    /// Returns `true` if the variable has a start value.
    pub fn has_start(&self) -> bool {
        match &self.kind {
            Kind::Real { start, .. } => start.is_some(),
            Kind::Integer { start, .. } | Kind::Enumeration { start, .. } => start.is_some(),
            Kind::Boolean { start } => start.is_some(),
            Kind::String { start } => start.is_some(),
        }
    }

    /// Returns the attribute `initial`, given or by default (table in section 2.2.7); `None` where it has no meaning.
    pub fn initial(&self) -> Option<Initial> {
        self.initial.or(match (self.causality, self.variability) {
            (Causality::Input, _) => None,
            (Causality::Parameter, _) | (_, Variability::Constant) => Some(Initial::Exact),
            _ => Some(Initial::Calculated),
        })
    }

    /// Returns `true` if the standard requires a start value.
    pub fn needs_start(&self) -> bool {
        self.causality == Causality::Input || matches!(self.initial(), Some(Initial::Exact | Initial::Approx))
    }

    /// Returns `true` if the combination of causality, variability and initial is allowed (table in section 2.2.7).
    pub fn is_legal_combination(&self) -> bool {
        use {Causality as C, Variability as V};
        let continuous_or_discrete = matches!(self.variability, V::Discrete | V::Continuous);
        let fixed_or_tunable = matches!(self.variability, V::Fixed | V::Tunable);
        let pair = match self.causality {
            C::Parameter | C::CalculatedParameter => fixed_or_tunable,
            C::Input => continuous_or_discrete,
            C::Output => continuous_or_discrete || self.variability == V::Constant,
            C::Local => true,
        };
        let real = matches!(self.kind, Kind::Real { .. });
        let initial = match (self.causality, self.variability, self.initial) {
            (_, _, None) => true,
            (C::Input, ..) => false,
            (C::Parameter, ..) | (_, V::Constant, _) => self.initial == Some(Initial::Exact),
            (C::CalculatedParameter, ..) | (C::Local, V::Fixed | V::Tunable, _) => {
                self.initial != Some(Initial::Exact)
            }
            _ => true,
        };
        pair && initial && (real || self.variability != V::Continuous)
    }
}
