//! Messages from the model to the importer.

use squid_model_description::LogCategory;

/// Receiver of the messages of a model.
pub trait Log {
    /// Logs a warning of one sentence: the result may be inaccurate, and the call returns `fmi2Warning`.
    fn warn(&mut self, message: &str);
}

/// Log categories, with the names proposed by the standard (section 2.2.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// Undefined values.
    Discard,
    /// Warnings.
    Warning,
    /// Refused calls and failed computations.
    Error,
    /// Panics.
    Fatal,
}

impl Category {
    /// All categories, in the order of the model description.
    pub const ALL: [Self; 4] = [Self::Discard, Self::Warning, Self::Error, Self::Fatal];

    /// Returns the name in the model description.
    pub fn name(self) -> &'static str {
        match self {
            Self::Discard => "logStatusDiscard",
            Self::Warning => "logStatusWarning",
            Self::Error => "logStatusError",
            Self::Fatal => "logStatusFatal",
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::Discard => {
                "results that could not be computed; an integrator may retry with a shorter step"
            }
            Self::Warning => "warnings: results may be inaccurate",
            Self::Error => "rejected calls and failed computations, always logged",
            Self::Fatal => "defects in the FMU, always logged",
        }
    }

    pub(crate) fn described(self) -> LogCategory {
        LogCategory { name: self.name().to_owned(), description: self.description().to_owned() }
    }
}

/// Filter of the logged categories (section 2.1.5).
///
/// Errors are always logged. The other categories are logged unless a list of categories excludes them, because the
/// standard requires a message with every such status (section 2.1.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Filter {
    discards: bool,
    warnings: bool,
}

impl Filter {
    /// All categories.
    pub(crate) const ALL: Self = Self { discards: true, warnings: true };

    /// Enables the listed categories and errors.
    pub(crate) fn listed(categories: &[Category]) -> Self {
        Self {
            discards: categories.contains(&Category::Discard),
            warnings: categories.contains(&Category::Warning),
        }
    }

    pub(crate) fn shows(self, category: Category) -> bool {
        match category {
            Category::Discard => self.discards,
            Category::Warning => self.warnings,
            Category::Error | Category::Fatal => true,
        }
    }
}

/// A log that discards every message.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Log for Silent {
    fn warn(&mut self, _: &str) {}
}
