//! Report on one design: its sections, computed in parallel.

use crate::error::Error;
use crate::page::{Boxed, Figure, Part, Section};
use crate::peers::peers;
use crate::sections::{
    disturbances, envelope, fit, flown, gammas, loops, manoeuvre, mu, robust, sensitivity, steps, structure,
    theorem, verdict,
};
use crate::subject::{Subject, name};
use crate::threads::in_parallel;
use squid_auv::Status;
use squid_base::progress::Progress;
use squid_certificate::Theorem;
use squid_design::inputs::{Inputs, sha256};
use squid_design::store::Stored;
use squid_finding::Finding;
use std::time::Instant;

/// Anchor and title of a section, and the function that computes it.
type Maker = (&'static str, &'static str, fn(&Subject) -> Result<Vec<Part>, Error>);

/// Sections, in reading order.
const SECTIONS: [Maker; 20] = [
    ("verdict", "Requirements and results", verdict::verdict),
    ("steps", "Step responses and actuators", steps::steps),
    ("flown", "Margins over speed", flown::flown),
    ("manoeuvre", "A step during a ramp of speed", manoeuvre::manoeuvre),
    ("envelope", "Reference limits", envelope::envelope),
    ("limits", "Saturated actuators", steps::limits::limits),
    ("held", "Loads beyond the actuators", steps::held::held),
    ("structure", "The loop: structure, weights and sizes", structure::structure),
    ("loops", "Open and closed loop over frequency", loops::loops),
    ("disturbances", "Current and sensor noise", disturbances::disturbances),
    ("sea", "At sea: waves, current, sensor errors", disturbances::sea::sea),
    ("working-sea", "Design for waves", disturbances::working_sea::working_sea),
    ("sensitivity", "Weights and achieved sensitivity", sensitivity::sensitivity),
    ("mu", "Robust stability: mu over frequency", mu::mu),
    ("robust", "Robust and nominal controller", robust::robust),
    ("gammas", "Gamma under each assumption about the speed", gammas::gammas),
    ("theorem", "The theorem of the certificate", theorem::theorem),
    ("peers", "Comparison with a PID and blended controllers", peers),
    ("entries", "The model: entries of A over speed", fit::entries),
    ("responses", "The model: frequency responses", fit::responses),
];

/// Sections that apply only to surge, heave and pitch.
const OF_THE_VERTICAL_PLANE: [&str; 4] = ["envelope", "disturbances", "sea", "working-sea"];

/// Slowest sections, the slowest first.
const LONGEST: [&str; 3] = ["gammas", "peers", "mu"];

/// Sections of the page in the FMUs: results of `squid design`, and steps that are quick to simulate.
const BRIEF: [&str; 4] = ["verdict", "steps", "flown", "theorem"];

/// Report on one design of one vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Title of the page.
    pub heading: String,
    /// Findings on proofs that fail.
    pub unproved: Vec<Finding>,
    /// Part of the warning on the vehicle.
    pub surrogate: Option<String>,
    /// Program and input files.
    pub origin: String,
    /// Introduction of the page.
    pub introduction: Vec<String>,
    /// Name of the vehicle.
    pub subject: String,
    /// Verdict for a terminal; may be empty.
    pub summary: String,
    /// Sections.
    pub sections: Vec<Section>,
}

/// Computes the sections of the report in parallel and reports progress. A section that fails contains the reason; an
/// empty section is omitted.
pub fn report(subject: &Subject) -> Report {
    let mut report = with_sections(subject, &SECTIONS.iter().collect::<Vec<_>>());
    if let Some((_, text)) = &subject.sea {
        report.origin += &format!("; the file of the sea with {}", sha256(text));
    }
    for other in &subject.beside {
        let Inputs { design, hashes, .. } = other.inputs;
        report.origin += &format!("; compared with {} with {}", design.source(), hashes.design_sha256);
    }
    let flown = report.sections.iter().find(|section| section.id == "peers" && !subject.beside.is_empty());
    if let Some(Part::Text(scores)) = flown.and_then(|section| section.parts.last()) {
        report.summary += &format!("\nComparison in simulation: {scores}\n");
    }
    report
}

/// Axis of a report: its files, its stored design, and the result of the repeated proof.
pub type Proved<'a> = (&'a Inputs, &'a Stored, &'a Result<Theorem, String>);

/// Computes the brief report of `squid design`, of one axis or more; `full_command` writes the full report.
///
/// # Errors
/// Errors of [`Subject::new`]; [`Error::NoAxis`].
pub fn brief(axes: &[Proved<'_>], full_command: &str, progress: &Progress) -> Result<Report, Error> {
    let of_axis = |(inputs, stored, proof): &Proved<'_>| {
        let mut subject = Subject::new(inputs, stored, progress)?.proved(proof);
        subject.brief = true;
        let makers: Vec<&Maker> = SECTIONS.iter().filter(|maker| BRIEF.contains(&maker.0)).collect();
        Ok((inputs.design.steered_signal(), with_sections(&subject, &makers)))
    };
    let axes = axes.iter().map(of_axis).collect::<Result<_, Error>>()?;
    let mut report = Report::together(axes, vec![]).ok_or(Error::NoAxis)?;
    report.introduction.push(format!("`{full_command}` writes the full report."));
    Ok(report)
}

/// Computes a report with some of the sections. Empty sections are omitted.
fn with_sections(subject: &Subject, makers: &[&Maker]) -> Report {
    let progress = subject.progress;
    let make = |&(id, title, of): &Maker| section(progress, (id, title), || of(subject));
    // The finding on the proof comes first, so that it is read before any figure.
    let unproved: Vec<Finding> = subject.stored.unproved_by(subject.proof()).into_iter().collect();
    unproved.iter().for_each(|found| progress.warn(found));
    // The slowest sections start first, so that the others run in parallel.
    let lateral = subject.inputs.design.view().is_level_held;
    let applies = |maker: &&Maker| !(lateral && OF_THE_VERTICAL_PLANE.contains(&maker.0));
    let mut order: Vec<&Maker> = makers.iter().copied().filter(applies).collect();
    let rank = |maker: &&Maker| LONGEST.iter().position(|id| *id == maker.0).unwrap_or(LONGEST.len());
    order.sort_by_key(rank);
    let mut sections = in_parallel(order.into_iter(), make);
    sections.retain(|section| !section.parts.is_empty());
    sections.sort_by_key(|section| makers.iter().position(|maker| maker.0 == section.id));
    let verdict =
        subject.verdict().map_or_else(|_| String::new(), |v| format!("Of {}: {v}\n", subject.name()));
    Report { sections, summary: verdict, ..Report::without_sections(subject.inputs, unproved) }
}

/// Computes a section and reports progress; a section that fails contains the reason.
pub fn section(
    progress: &Progress,
    (id, title): (&'static str, &'static str),
    make: impl FnOnce() -> Result<Vec<Part>, Error>,
) -> Section {
    let failed = |reason| {
        let text = format!("This section could not be computed: {reason}");
        vec![Part::Boxed(Boxed { mark: "failed", paragraphs: vec![(String::new(), text)] })]
    };
    let started = Instant::now();
    let parts = make().unwrap_or_else(failed);
    progress.done("report", &format!("{title} ({:.1} s)", started.elapsed().as_secs_f64()));
    Section::new(id, title, parts)
}

/// Returns version, input files and their hashes.
fn origin(inputs: &Inputs) -> String {
    let hashes = &inputs.hashes;
    format!(
        "squid {}; vehicle.toml of {} with SHA-256 {}, {} with {}",
        env!("CARGO_PKG_VERSION"),
        inputs.vehicle.name,
        hashes.vehicle_sha256,
        inputs.design.source_of_all(),
        hashes.design_sha256
    )
}

impl Report {
    /// Returns the report before any computation: vehicle, design and warnings.
    pub(crate) fn without_sections(inputs: &Inputs, unproved: Vec<Finding>) -> Self {
        let vehicle = &inputs.vehicle;
        let surrogate = (vehicle.status == Status::Surrogate).then(|| {
            format!(
                "SURROGATE: according to its status in vehicle.toml, the coefficients are not those of the real {}. \
                 All numbers on this page apply to the vehicle in this file.",
                vehicle.name
            )
        });
        let subject = name(vehicle);
        let introduction = vec![
            format!(
                "Vehicle: {} ({} coefficients). {}",
                vehicle.name,
                vehicle.status.word(),
                vehicle.description
            ),
            format!("Design '{}': {}", inputs.design.autopilot, inputs.design.description),
        ];
        Self {
            heading: format!("Report: {subject}"),
            unproved,
            surrogate,
            origin: origin(inputs),
            introduction,
            subject,
            summary: String::new(),
            sections: Vec::new(),
        }
    }

    /// Joins the reports of the axes of one autopilot on one page, with the sections `of_all` first; `axes` contains
    /// the controlled quantity and the report of each axis. `None` without an axis.
    pub fn together(axes: Vec<(&str, Self)>, of_all: Vec<Section>) -> Option<Self> {
        let several = axes.len() > 1;
        let mut all: Option<Self> = None;
        for (axis, report) in axes {
            let own = |section: Section| if several { section.of_axis(axis) } else { section };
            let named = |found: Finding| {
                let why = if several { format!("{axis}: {}", found.why) } else { found.why };
                Finding { key: if several { axis.into() } else { found.key }, why, ..found }
            };
            let sections: Vec<Section> = report.sections.into_iter().map(own).collect();
            let unproved = report.unproved.into_iter().map(named).collect();
            match &mut all {
                None => all = Some(Self { sections, unproved, ..report }),
                Some(all) => {
                    all.sections.extend(sections);
                    all.summary += &report.summary;
                    all.unproved.extend(unproved);
                }
            }
        }
        let mut all = all?;
        all.sections.splice(0..0, of_all);
        Some(all)
    }

    /// Returns the warnings that are shown first, in one paragraph.
    pub fn warning(&self) -> Option<String> {
        let unproved = self.unproved.iter().map(ToString::to_string);
        unproved.chain(self.surrogate.clone()).reduce(|first, second| format!("{first}. {second}"))
    }

    /// Returns all figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        let parts = self.sections.iter().flat_map(|section| &section.parts);
        parts.filter_map(|part| if let Part::Figure(figure) = part { Some(figure) } else { None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The warning depends only on the status and the name in the vehicle file.
    #[test]
    fn surrogate_warning_names_the_vehicle() {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles");
        let mut inputs = Inputs::read(&vehicles.join("squid"), "design").unwrap();
        let warning = |inputs: &Inputs| Report::without_sections(inputs, vec![]).warning();
        "otter".clone_into(&mut inputs.vehicle.name);
        insta::assert_snapshot!(warning(&inputs).unwrap());
        inputs.vehicle.status = Status::Published;
        assert_eq!(warning(&inputs), None);
    }
}
