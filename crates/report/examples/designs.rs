//! The figures of docs/benchmarks.md for several designs of one vehicle side by side:
//! `cargo run --release -p squid-report --example designs VEHICLE DESIGN...` prints a column for each, below it the
//! rows of their verdicts.
#![allow(clippy::print_stdout)]

use base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::run::run;
use squid_design::store::Stored;
use squid_design::verdict::row::{Outcome, Row};
use squid_report::peers::side_by_side;
use squid_report::subject::Subject;
use std::collections::BTreeMap;

/// Random points of the box, in addition to its vertices.
const POINTS: usize = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let vehicle = words.next().ok_or("VEHICLE DESIGN...")?;
    let progress = Progress::default();
    let mut designs = vec![];
    for name in words {
        let inputs = Inputs::read(vehicle.as_ref(), &name)?;
        let finished = match run(&inputs, &progress) {
            Ok(finished) => finished,
            Err(reason) => {
                println!("{name}: {reason}");
                continue;
            }
        };
        let stored = Stored::of(&finished.frozen, &inputs);
        let sizes = finished.design.controller.parts.sizes();
        let proofs =
            [finished.proof.is_ok(), finished.sampled.is_ok()].map(|held| if held { "yes" } else { "NO" });
        let head = [
            ("states, channels".to_owned(), format!("{}, {}", sizes.x, sizes.t)),
            ("proved, sampled".to_owned(), proofs.join(", ")),
        ];
        let mark = |row: &Row| if row.outcome == Outcome::Missed { " MISSED" } else { "" };
        let rows = finished.verdict.rows.iter().map(|row| {
            (format!("{} ({})", row.what, row.required()), format!("{}{}", row.found(), mark(row)))
        });
        let rows: Vec<(String, String)> = head.into_iter().chain(rows).collect();
        designs.push((name, inputs, stored, rows));
    }
    let subjects = designs
        .iter()
        .map(|(name, inputs, stored, _)| Ok((name.as_str(), Subject::new(inputs, stored, &progress)?)));
    let subjects = subjects.collect::<Result<Vec<_>, Box<dyn std::error::Error>>>()?;
    let subjects: Vec<(&str, &Subject)> = subjects.iter().map(|(name, subject)| (*name, subject)).collect();
    let table = side_by_side(&subjects, POINTS)?;
    println!("| {} |\n|{}", table.head.join(" | "), "---|".repeat(table.head.len()));
    table.rows.iter().for_each(|row| println!("| {} |", row.join(" | ")));
    let mut order = vec![];
    let mut verdicts: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (place, (.., rows)) in designs.iter().enumerate() {
        for (what, found) in rows {
            let cells = verdicts.entry(what).or_insert_with(|| {
                order.push(what.as_str());
                vec![]
            });
            cells.resize(place, "");
            cells.push(found);
        }
    }
    for what in order {
        println!("| {what} | | {} |", verdicts[what].join(" | "));
    }
    Ok(())
}
