//! Additions of the paper to a report: its parameter study, its figures of the vehicle alone, and its claims, each with
//! its criterion and finding.
//!
//! Source: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, 275-286.

mod alternation;
mod claims;
mod difficulty;
mod fit;
mod mu;
mod open_loop;
mod sensitivity;
mod switched;
mod switching;
mod tuning;

use claims::{Claim, Found};
use squid_report::error::Error;
use squid_report::page::{Boxed, Part, Section, Table, capital};
use squid_report::report::{self, Report, section};
use squid_report::subject::Subject;
use squid_report::threads::in_parallel;

/// Anchor and title of a section, and the function that computes it.
type SectionSource = (&'static str, &'static str, fn(&Subject) -> Result<Found, Error>);

/// Sections after those of every report and before the claims.
const SECTIONS: [SectionSource; 4] = [
    ("tuning", "The paper's Fig. 5: pitch responses for three bandwidths of the weight", tuning::tuning),
    ("open-loop", "The paper's Fig. 6: the open-loop vehicle", open_loop::open_loop),
    ("difficulty", "Speeds at which control is most difficult", difficulty::difficulty),
    ("switching", "Scheduled against switched controllers", switching::switching),
];

/// Returns the report with the paper's sections and claims.
pub fn report(subject: &Subject) -> Report {
    // The report comes first, because the claims on mu use the results of its section.
    let mut report = report::report(subject);
    let claims_of = [sensitivity::claims, mu::claims, fit::claims];
    let mut claims: Vec<Claim> = claims_of.iter().flat_map(|of| of(subject)).collect();
    for (section, found) in in_parallel(SECTIONS.iter(), |source| computed(subject, source)) {
        report.sections.push(section);
        claims.extend(found);
    }
    report.introduction.extend(introduction(subject));
    report.summary += &summary(&claims, &report.subject);
    report.sections.push(claims_section(claims, &report.subject));
    report
}

fn computed(subject: &Subject, &(id, title, of): &SectionSource) -> (Section, Vec<Claim>) {
    let mut claims = Vec::new();
    let parts = || {
        let (parts, found) = of(subject)?;
        claims = found;
        Ok(parts)
    };
    (section(subject.progress, (id, title), parts), claims)
}

/// Notes on the paper's figures, and on differences of the controller from the paper's set-up.
fn introduction(subject: &Subject) -> impl Iterator<Item = String> {
    let figures = "The figures of the paper: Fig. 1 and 2 are in the section on the structure of the loop, Fig. 3 \
        and 4 in those on the model, Fig. 7 in that on mu; Fig. 5 and 6 have sections of their own.";
    let measured = "The configuration differs from that of the paper, whose controller receives the tracking error \
        only: this controller receives references and measurements separately, and each tracked output has a \
        reference model. Errors are relative to this model.";
    let robust = "The controller is a robust one; those of Fig. 5, with different W_e, and the switched ones are \
        from the nominal synthesis.";
    let measured = (!subject.inputs.design.measured.is_empty()).then_some(measured);
    let robust = subject.stored.robust.is_some().then_some(robust);
    [Some(figures), measured, robust].into_iter().flatten().map(str::to_owned)
}

/// Claims as text for a terminal.
fn summary(claims: &[Claim], subject: &str) -> String {
    let line = |c: &Claim| format!("  {:<17} {}\n", c.finding.text(), c.claim);
    let lines: String = claims.iter().map(line).collect();
    format!("\nClaims of the paper, for {subject}:\n{lines}")
}

/// Last section: the claims in one table, then each with its criterion and the numbers.
fn claims_section(claims: Vec<Claim>, subject: &str) -> Section {
    let summary = "A. Sutarto, A. Budiyono, 'Development of Linear Parameter Varying Control System for Autonomous \
        Underwater Vehicle', Indian J. Geo-Marine Sci. 40(2), 2011, 275-286: each claim, and whether this vehicle \
        confirms it according to a stated criterion and the numbers in the sections above.";
    let mut table = Table::new(["Claims of the paper", &format!("For {subject}")]);
    table.rows = claims.iter().map(|claim| vec![capital(claim.claim), claim.finding.text().into()]).collect();
    let boxed = |claim: Claim| {
        let found = format!("For {subject}: {}.", claim.finding.text());
        let paragraphs = vec![
            (String::new(), format!("The paper: {}", claim.claim)),
            (found, claim.because),
            (String::new(), format!("Criterion: {}", claim.criterion)),
        ];
        Part::Boxed(Boxed { mark: claim.finding.class(), paragraphs })
    };
    let head = [Part::Text(summary.into()), Part::Table(table)];
    let parts = head.into_iter().chain(claims.into_iter().map(boxed)).collect();
    Section::new("claims", "Claims of the paper", parts)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
