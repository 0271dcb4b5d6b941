//! `squid report`: the paper's figures for a vehicle, with what the paper claims and whether this vehicle bears it out.
//!
//! ```text
//! inputs, stored design -> Subject -> sections (figures, tables, verdicts) -> page, SVG files
//! ```
//!
//! The paper: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, 275-286. Every verdict is computed by a rule in
//! [`verdict`]; `SECTIONS` is the table of contents, and a further section is a further line in it.

mod alternation;
pub mod axis;
pub mod chart;
mod effort;
pub mod figure;
mod fit;
pub mod frozen_loop;
mod gammas;
mod manoeuvre;
mod mu;
mod open_loop;
mod page;
mod robust;
pub mod section;
mod sensitivity;
pub mod subject;
mod switched;
mod switching;
mod theorem;
mod tuning;
pub mod verdict;

use crate::error::Error;
use crate::inputs::Inputs;
use crate::output::Files;
use crate::store::Stored;
use auv::Status;
use section::{Part, Section};
use std::path::{Path, PathBuf};
use subject::Subject;
use verdict::Verdict;

/// Anchor and title of a section, and what computes it.
type Maker = (&'static str, &'static str, fn(&Subject) -> Result<Vec<Part>, Error>);

/// The sections, in the order in which they are read.
const SECTIONS: [Maker; 12] = [
    ("entries", "Entries of A over speed (the paper's Fig. 3)", fit::entries),
    ("responses", "Frequency responses of the models (Fig. 4)", fit::responses),
    ("tuning", "Pitch responses for three bandwidths of the weight (Fig. 5 a, b, c)", tuning::tuning),
    ("open-loop", "The vehicle alone (Fig. 6)", open_loop::open_loop),
    ("mu", "Robust stability: mu over frequency (Fig. 7 a, b)", mu::mu),
    ("robust", "The robust controller against the nominal one", robust::robust),
    ("sensitivity", "The weights against the achieved sensitivity", sensitivity::sensitivity),
    ("effort", "What the actuators do, and where control is hardest", effort::effort),
    ("gammas", "The ladder of gammas: what each assumption about the speed costs", gammas::gammas),
    ("manoeuvre", "A pitch step while the speed ramps", manoeuvre::manoeuvre),
    ("switching", "Scheduled against switched controllers", switching::switching),
    ("theorem", "The theorem of the certificate", theorem::theorem),
];

/// The report on one design of one vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The page's title.
    pub heading: String,
    /// What must be said before anything else.
    pub warning: Option<String>,
    /// What the page is about.
    pub introduction: Vec<String>,
    /// The vehicle in words.
    pub subject: String,
    /// The sections.
    pub sections: Vec<Section>,
}

/// Computes the report. A section that cannot be computed says why, and leaves the others standing.
///
/// # Errors
/// As [`Subject::new`].
pub fn report(inputs: &Inputs, stored: &Stored) -> Result<Report, Error> {
    let subject = Subject::new(inputs, stored)?;
    let make = |&(id, title, of): &Maker| {
        let failed = |reason| vec![Part::Words(format!("This section could not be computed: {reason}"))];
        Section { id, title, parts: of(&subject).unwrap_or_else(failed) }
    };
    let sections = SECTIONS.iter().map(make).collect();
    let vehicle = &inputs.vehicle;
    let surrogate = (vehicle.status == Status::Surrogate).then(|| {
        format!(
            "SURROGATE: the coefficients of the real vehicle are not published. All numbers on this page are of a surrogate of {} with \
             coefficients derived from geometry; where they differ from the paper's, the vehicle does, too.",
            vehicle.name
        )
    });
    let warnings = [stored.unproved(inputs), surrogate].into_iter().flatten();
    let warning = warnings.reduce(|first, second| format!("{first}. {second}"));
    let introduction = vec![
        format!("Vehicle: {} ({} coefficients). {}", vehicle.name, vehicle.status.word(), vehicle.description),
        format!("Design '{}': {}", inputs.design.name, inputs.design.description),
        "The figures are those of A. Sutarto, A. Budiyono, 'Development of Linear Parameter Varying Control System for Autonomous Underwater \
         Vehicle', Indian J. Geo-Marine Sci. 40(2), 2011, 275-286, for this vehicle, and some that the paper does not have. Next to them stands \
         what the paper claims and whether this vehicle bears it out, by a stated criterion and computed numbers."
            .into(),
    ];
    Ok(Report {
        heading: format!("Report: {}", subject.name()),
        warning,
        introduction,
        subject: subject.name(),
        sections,
    })
}

impl Report {
    /// The page; `about` is put below its heading.
    ///
    /// # Errors
    /// [`Error::Plot`].
    pub fn page(&self, about: &[String]) -> Result<String, Error> {
        page::page(self, about)
    }

    /// All verdicts.
    pub fn verdicts(&self) -> impl Iterator<Item = &Verdict> {
        self.sections.iter().flat_map(Section::verdicts)
    }

    /// Writes `report.html` and each figure as `figures/NAME.svg`, and returns the path of the page.
    ///
    /// # Errors
    /// [`Error::Plot`], [`Error::Unwritable`].
    pub fn save(&self, directory: &Path) -> Result<PathBuf, Error> {
        let mut files = Files::default();
        for figure in self.sections.iter().flat_map(Section::figures) {
            let path = directory.join("figures").join(format!("{}.svg", figure.name));
            files.add(path, figure.file(&figure.caption)?);
        }
        let path = directory.join("report.html");
        files.add(path.clone(), self.page(&[])?);
        files.save(directory)?;
        Ok(path)
    }

    /// The verdicts for a terminal.
    pub fn words(&self) -> String {
        let line = |v: &Verdict| format!("  {:<17} {}\n", v.finding.words(), v.claim);
        format!(
            "What the paper claims, of {}:\n{}",
            self.subject,
            self.verdicts().map(line).collect::<String>()
        )
    }
}
