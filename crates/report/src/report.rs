//! The report on one design: its sections, computed side by side.

use crate::error::Error;
use crate::page::figure::Figure;
use crate::page::section::{Part, Section};
use crate::peers::peers;
use crate::sections::{
    effort, fit, flown, gammas, manoeuvre, mu, open_loop, robust, sensitivity, switching, theorem, tuning,
};
use crate::subject::{Subject, name};
use crate::threads::side_by_side;
use crate::verdict::Verdict;
use auv::Status;
use squid_design::inputs::Inputs;
use squid_design::progress::Progress;
use squid_design::store::Stored;
use std::time::Instant;

/// Anchor and title of a section, and what computes it.
type Maker = (&'static str, &'static str, fn(&Subject) -> Result<Vec<Part>, Error>);

/// The sections, in the order in which they are read.
const SECTIONS: [Maker; 14] = [
    ("entries", "Entries of A over speed (the paper's Fig. 3)", fit::entries),
    ("responses", "Frequency responses of the models (Fig. 4)", fit::responses),
    ("tuning", "Pitch responses for three bandwidths of the weight (Fig. 5 a, b, c)", tuning::tuning),
    ("open-loop", "The vehicle alone (Fig. 6)", open_loop::open_loop),
    ("mu", "Robust stability: mu over frequency (Fig. 7 a, b)", mu::mu),
    ("robust", "The robust controller against the nominal one", robust::robust),
    ("sensitivity", "The weights against the achieved sensitivity", sensitivity::sensitivity),
    ("flown", "The loop as it flies: margins, steps, a gust and noise", flown::flown),
    ("effort", "What the actuators do, and where control is hardest", effort::effort),
    ("gammas", "The ladder of gammas: what each assumption about the speed costs", gammas::gammas),
    ("manoeuvre", "A pitch step while the speed ramps", manoeuvre::manoeuvre),
    ("switching", "Scheduled against switched controllers", switching::switching),
    ("peers", "Against a PID and blended controllers", peers),
    ("theorem", "The theorem of the certificate", theorem::theorem),
];

/// The section that takes longest.
const LONGEST: &str = "mu";

/// The report on one design of one vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The page's title.
    pub heading: String,
    /// Warnings, shown first.
    pub warning: Option<String>,
    /// Of that, what there is to say of the proof.
    pub unproved: Option<String>,
    /// What the page is about.
    pub introduction: Vec<String>,
    /// The vehicle in words.
    pub subject: String,
    /// The sections.
    pub sections: Vec<Section>,
}

/// Computes the sections of the report in parallel and reports the progress. A section that fails contains the reason.
///
/// # Errors
/// As [`Subject::new`].
pub fn report(inputs: &Inputs, stored: &Stored, progress: &Progress) -> Result<Report, Error> {
    let subject = Subject::new(inputs, stored, progress)?;
    let make = |&(id, title, of): &Maker| {
        let failed = |reason| vec![Part::Words(format!("This section could not be computed: {reason}"))];
        let started = Instant::now();
        let parts = of(&subject).unwrap_or_else(failed);
        progress.done("report", &format!("{title} ({:.1} s)", started.elapsed().as_secs_f64()));
        Section { id, title, parts }
    };
    // First, so that it is read before any figure.
    let unproved = stored.remark(subject.proof());
    unproved.iter().for_each(|words| progress.warn(words));
    // The longest first, so that the others fill the time beside it.
    let (first, rest): (Vec<&Maker>, Vec<&Maker>) = SECTIONS.iter().partition(|maker| maker.0 == LONGEST);
    let mut sections = side_by_side(first.into_iter().chain(rest), make);
    sections.sort_by_key(|section| SECTIONS.iter().position(|maker| maker.0 == section.id));
    let mut report = Report { sections, ..Report::without_sections(inputs, unproved) };
    report.introduction.push(
        "The figures are those of A. Sutarto, A. Budiyono, 'Development of Linear Parameter Varying Control \
            System for Autonomous Underwater Vehicle', Indian J. Geo-Marine Sci. 40(2), 2011, 275-286, for \
            this vehicle, and some that the paper does not have. Next to them is what the paper claims and \
            whether this vehicle confirms it, by a stated criterion and computed numbers."
            .into(),
    );
    if !inputs.design.measured.is_empty() {
        report.introduction.push(
            "The controller is not of the paper's set-up: the paper's takes in the tracking error alone, this one \
                references and measurements apart, and each tracked output has a model to follow. Errors are those \
                to that model."
                .into(),
        );
    }
    Ok(report)
}

impl Report {
    /// What there is to say before anything is computed: vehicle, design, warnings.
    pub(crate) fn without_sections(inputs: &Inputs, unproved: Option<String>) -> Self {
        let vehicle = &inputs.vehicle;
        let surrogate = (vehicle.status == Status::Surrogate).then(|| {
            format!(
                "SURROGATE: the coefficients of the real vehicle are not published. All numbers on this page are \
                    of a surrogate of {} with coefficients derived from geometry; where they differ from the \
                    paper's, the vehicle does, too.",
                vehicle.name
            )
        });
        let warnings = [unproved.clone(), surrogate].into_iter().flatten();
        let subject = name(vehicle);
        let introduction = vec![
            format!(
                "Vehicle: {} ({} coefficients). {}",
                vehicle.name,
                vehicle.status.word(),
                vehicle.description
            ),
            format!("Design '{}': {}", inputs.design.name, inputs.design.description),
        ];
        Self {
            heading: format!("Report: {subject}"),
            warning: warnings.reduce(|first, second| format!("{first}. {second}")),
            unproved,
            introduction,
            subject,
            sections: Vec::new(),
        }
    }

    /// All verdicts.
    pub fn verdicts(&self) -> impl Iterator<Item = &Verdict> {
        self.sections.iter().flat_map(Section::verdicts)
    }

    /// All figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.sections.iter().flat_map(Section::figures)
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
