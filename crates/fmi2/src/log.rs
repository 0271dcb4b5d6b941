//! Messages from the model to the importer.

use model_description::LogCategory;

/// Takes the messages of a model.
pub trait Log {
    /// Hands over one message, a sentence.
    fn record(&mut self, level: Level, message: &str);
}

/// How serious a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For the curious; shown with debug logging only.
    Event,
    /// The result may be doubtful; the call returns `fmi2Warning`.
    Warning,
}

/// Log categories, with the names that the standard proposes (section 2.2.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// Events of the model.
    Events,
    /// Warnings.
    Warning,
    /// Refused calls and failed computations.
    Error,
    /// Panics.
    Fatal,
}

impl Category {
    /// All categories, in the order of the model description.
    pub const ALL: [Self; 4] = [Self::Events, Self::Warning, Self::Error, Self::Fatal];

    /// Name in the model description.
    pub fn name(self) -> &'static str {
        match self {
            Self::Events => "logEvents",
            Self::Warning => "logStatusWarning",
            Self::Error => "logStatusError",
            Self::Fatal => "logStatusFatal",
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::Events => "events of the model, with debug logging only",
            Self::Warning => "warnings: the result may be doubtful",
            Self::Error => "refused calls and failed computations, always logged",
            Self::Fatal => "defects of the FMU, always logged",
        }
    }

    pub(crate) fn described(self) -> LogCategory {
        LogCategory { name: self.name().to_owned(), description: self.description().to_owned() }
    }
}

/// Which categories are shown (section 2.1.5).
///
/// Errors are shown always: a refusal without a sentence helps nobody. Warnings are shown unless a list of
/// categories leaves them out, events only while debug logging is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Filter {
    events: bool,
    warnings: bool,
}

impl Filter {
    /// All categories, or all but debugging.
    pub(crate) fn all(logging_on: bool) -> Self {
        Self { events: logging_on, warnings: true }
    }

    /// Only the listed ones (and errors).
    pub(crate) fn listed(categories: &[Category]) -> Self {
        Self {
            events: categories.contains(&Category::Events),
            warnings: categories.contains(&Category::Warning),
        }
    }

    pub(crate) fn shows(self, category: Category) -> bool {
        match category {
            Category::Events => self.events,
            Category::Warning => self.warnings,
            Category::Error | Category::Fatal => true,
        }
    }
}

/// Drops every message.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Log for Silent {
    fn record(&mut self, _: Level, _: &str) {}
}
