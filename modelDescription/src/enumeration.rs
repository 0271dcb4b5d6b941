//! Enumerated types (section 2.2.3).

/// Named list of choices, numbered from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type in the variables.
    pub name: String,
    /// Meaning of the choice.
    pub description: String,
    /// Items; the first has the value 1.
    pub items: Vec<Item>,
}

/// Item of an [`Enumeration`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// Short name.
    pub name: String,
    /// Meaning of the item.
    pub description: String,
}

impl Enumeration {
    /// Creates an enumeration of `(name, description)` pairs.
    pub fn new(name: &str, description: &str, items: &[(&str, &str)]) -> Self {
        let item = |&(name, description): &(&str, &str)| Item {
            name: name.to_owned(),
            description: description.to_owned(),
        };
        Self {
            name: name.to_owned(),
            description: description.to_owned(),
            items: items.iter().map(item).collect(),
        }
    }
}
