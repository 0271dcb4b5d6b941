//! The comparison of docs/benchmarks.md: `cargo run --release -p squid-report --example peers VEHICLE...` prints a
//! table for each vehicle, with more flights than the report.
#![allow(clippy::print_stdout)]

use squid_base::progress::{Event, Progress};
use squid_design::inputs::Inputs;
use squid_design::run::run;
use squid_design::store::Stored;
use squid_report::page::Part;
use squid_report::peers::{Effort, compare};
use squid_report::subject::Subject;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let effort = Effort { evaluations: 300, points: 100 };
    for name in std::env::args().skip(1) {
        // REMUS 100 has a design of pitch beside its default one.
        let design = if Path::new(&name).join("pitch.toml").exists() { "pitch" } else { "design" };
        let inputs = Inputs::read(name.as_ref(), design)?;
        let finished = run(&inputs, &Progress::default())?;
        let stored = Stored::of(&finished.frozen, &inputs);
        let show = |event: Event| {
            if let Event::Done { figures, .. } = event {
                eprintln!("{figures}");
            }
        };
        let progress = Progress::new(&show);
        let subject = Subject::new(&inputs, &stored, &progress)?;
        for part in compare(&subject, effort)? {
            match part {
                Part::Words(words) => println!("{words}\n"),
                Part::Table(table) => {
                    println!("| {} |\n|{}", table.head.join(" | "), "---|".repeat(table.head.len()));
                    for row in &table.rows {
                        let cells: Vec<String> = row.iter().map(|words| words.replace('|', "\\|")).collect();
                        println!("| {} |", cells.join(" | "));
                    }
                    println!();
                }
                _ => {}
            }
        }
    }
    Ok(())
}
