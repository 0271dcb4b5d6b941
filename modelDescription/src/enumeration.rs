//! Enumerated types (section 2.2.3).

/// A named list of choices, numbered from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Enumeration {
    /// Name that the variables refer to.
    pub name: String,
    /// What the choice decides.
    pub description: String,
    /// The choices; the first one has value 1.
    pub items: Vec<Item>,
}

/// One choice of an [`Enumeration`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// Short name.
    pub name: String,
    /// What the choice means.
    pub description: String,
}

impl Enumeration {
    /// An enumeration of `(name, description)` pairs.
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
