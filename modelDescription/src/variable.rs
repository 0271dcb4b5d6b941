//! Scalar variables (section 2.2.7).

/// One variable of the model, with its dependencies.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarVariable {
    /// Unique name.
    pub name: String,
    /// Handle that the C functions use.
    pub value_reference: u32,
    /// What the variable means, in a sentence.
    pub description: String,
    /// Role in connections.
    pub causality: Causality,
    /// When the value may change.
    pub variability: Variability,
    /// How the value is initialised; `None` takes the default of the standard.
    pub initial: Option<Initial>,
    /// Type with its attributes.
    pub kind: Kind,
    /// Name of the state of which this is the time derivative.
    pub derivative_of: Option<String>,
    /// Names of the variables that an output or derivative depends on directly; `None` means all of them.
    pub depends_on: Option<Vec<Dependency>>,
    /// The same for the initial value; `None` means all of them.
    pub initially_depends_on: Option<Vec<Dependency>>,
}

/// Type of a variable and the attributes that this type has.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Floating point.
    Real {
        /// Unit of the value.
        unit: Option<String>,
        /// Unit in which a tool should show the value.
        display_unit: Option<String>,
        /// Least value.
        min: Option<f64>,
        /// Greatest value.
        max: Option<f64>,
        /// Typical magnitude.
        nominal: Option<f64>,
        /// Start value.
        start: Option<f64>,
    },
    /// 32-bit integer.
    Integer {
        /// Least value.
        min: Option<i32>,
        /// Greatest value.
        max: Option<i32>,
        /// Start value.
        start: Option<i32>,
    },
    /// Truth value.
    Boolean {
        /// Start value.
        start: Option<bool>,
    },
    /// Text.
    String {
        /// Start value.
        start: Option<String>,
    },
    /// One of the items of a declared type.
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
    /// Set before the simulation.
    Parameter,
    /// Computed from parameters.
    CalculatedParameter,
    /// Set by another model.
    Input,
    /// Used by another model.
    Output,
    /// Internal, to be displayed.
    Local,
}

/// When a value may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never.
    Constant,
    /// Not after initialisation.
    Fixed,
    /// Between communication points, by the user.
    Tunable,
    /// At events only.
    Discrete,
    /// At any time.
    Continuous,
}

/// How a variable gets its first value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// The start value.
    Exact,
    /// The start value is a guess.
    Approx,
    /// Computed from other variables.
    Calculated,
}

/// One entry of `dependencies` and `dependenciesKind`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependency {
    /// Name of the variable on which another one depends.
    pub on: String,
    /// In which way.
    pub kind: DependencyKind,
}

/// Way in which one variable depends on another, as far as it is told apart here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DependencyKind {
    /// No particular structure.
    Dependent,
    /// A constant factor.
    Constant,
}

impl ScalarVariable {
    /// Unit of a Real variable.
    pub fn unit(&self) -> Option<&str> {
        match &self.kind {
            Kind::Real { unit, .. } => unit.as_deref(),
            _ => None,
        }
    }

    /// Whether the variable has a start value.
    pub fn has_start(&self) -> bool {
        match &self.kind {
            Kind::Real { start, .. } => start.is_some(),
            Kind::Integer { start, .. } | Kind::Enumeration { start, .. } => start.is_some(),
            Kind::Boolean { start } => start.is_some(),
            Kind::String { start } => start.is_some(),
        }
    }

    /// The attribute `initial`, given or by default (table in section 2.2.7); `None` where it has no meaning.
    pub fn initial(&self) -> Option<Initial> {
        self.initial.or(match (self.causality, self.variability) {
            (Causality::Input, _) => None,
            (Causality::Parameter, _) | (_, Variability::Constant) => Some(Initial::Exact),
            _ => Some(Initial::Calculated),
        })
    }

    /// Whether the standard requires a start value.
    pub fn needs_start(&self) -> bool {
        self.causality == Causality::Input || matches!(self.initial(), Some(Initial::Exact | Initial::Approx))
    }

    /// Whether the combination of causality, variability and initial is allowed (table in section 2.2.7).
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
