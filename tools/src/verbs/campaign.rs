//! `squid campaign` and `squid replay`: many flights of a design, and one of them again.

use crate::cli::Which;
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::{Counter, show};
use crate::verbs::design::load_or_design;
use auv::read_text;
use serde::{Deserialize, Serialize};
use serde_json::json;
use squid_campaign::flight::Row;
use squid_campaign::plan::{Plan, Points};
use squid_campaign::run::{results, run as fly_missing};
use squid_campaign::summary::{Share, Spread, shares, spreads};
use squid_design::error::StoreError;
use squid_design::numbers::decimals;
use squid_design::progress::Progress;
use squid_design::store::files::{check_directory, read, write};
use squid_flight::sea::Sea;
use squid_report::campaign::{STRONG, page};
use squid_report::page::plot::draw;
use squid_report::record::Record;
use std::path::{Path, PathBuf};

/// The file beside the results that says what `replay` reads.
const ABOUT: &str = "campaign.json";

/// How a campaign was called.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct About {
    vehicle: PathBuf,
    design: String,
    bandwidth: Option<f64>,
    out: Option<PathBuf>,
    sea: Option<String>,
    seed: u64,
    points: Points,
}

/// Flies what is missing of a campaign, and prints what all its rows say.
///
/// # Errors
/// Those of the files and of the design; [`Error::Campaign`]; [`Error::Argument`] where there is nothing to fly.
pub fn run(
    which: &Which,
    flights: u64,
    sea: Option<&Path>,
    (seed, corners): (u64, bool),
    to: Option<PathBuf>,
) -> Result<(), Error> {
    if flights == 0 {
        return Err(Error::Argument { name: "--flights", found: "0".into(), allowed: "at least 1".into() });
    }
    let (inputs, directory) = which.read_to_write()?;
    let to = to.unwrap_or_else(|| directory.join("campaign"));
    check_directory(&to)?;
    let sea = sea.map(|path| Ok::<_, Error>((Sea::read(path)?, read_text(path)?))).transpose()?;
    sea.iter().try_for_each(|(sea, _)| sea.check(&inputs.vehicle))?;
    let stored = load_or_design(&inputs, &directory)?;
    stored.unproved(&inputs).iter().for_each(|words| say(words));
    let points = if corners { Points::Corners } else { Points::Uniform };
    let plan = Plan::new(&inputs, &stored, sea, seed, points)?;
    results(&plan, &to)?;
    let full = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let about = About {
        vehicle: inputs.directory.clone(),
        design: which.design.clone(),
        bandwidth: which.bandwidth,
        out: which.out.as_deref().map(full),
        sea: plan.identity.sea.clone(),
        seed,
        points,
    };
    write(&to.join(ABOUT), squid_design::store::files::json(&about)?.as_bytes())?;
    let counter = Counter::new("campaign", flights);
    fly_missing(&plan, flights, &to, &|done| counter.at(done))?;
    drop(counter);
    let rows: Vec<Row> = results(&plan, &to)?.into_iter().filter(|row| row.flight < flights).collect();
    let names: Vec<String> = plan.drawn().into_iter().map(|(name, _)| name).collect();
    let (shares, spreads) = (shares(&rows), spreads(&rows, &names));
    say(&words(&plan, rows.len(), &shares, &spreads));
    let path = to.join("campaign.html");
    write(&path, page(&plan, &rows, &shares, &spreads).as_bytes())?;
    say(&format!("\nResults: {}\nPage: {}", to.join("*.parquet").display(), path.display()));
    Ok(answer(
        &json!({ "directory": to, "page": path, "flights": rows.len(), "outcomes": shares, "figures": spreads }),
    )?)
}

/// What the rows say, as tables.
fn words(plan: &Plan<'_>, flights: usize, shares: &[Share], spreads: &[Spread]) -> String {
    let what = match plan.identity.points {
        Points::Uniform => "all over the declared uncertainty",
        Points::Corners => "at corners of the declared uncertainty",
    };
    let at_sea = if plan.sea.is_some() { ", at sea" } else { "" };
    let mut out = format!(
        "{flights} flights of vehicles {what}{at_sea}: {} uncertain numbers\n\n\
         outcome      flights     share   95 % interval\n",
        plan.uncertain.len()
    );
    for Share { outcome, flights, share, interval: [low, high] } in shares {
        let part = |v: f64| format!("{} %", decimals(100.0 * v, 2));
        out +=
            &format!("{outcome:<10} {flights:>9}  {:>7}  {} to {}\n", part(*share), part(*low), part(*high));
    }
    out += "\nfigure                      median      95 %      99 %   largest   in flight   \
            pushed by (rank correlation)\n";
    for Spread { figure, unit, quantiles, largest, flight, pushed_by } in spreads {
        let cells: String = quantiles
            .iter()
            .chain([largest])
            .map(|v| format!("{:>10}", if v.is_finite() { decimals(*v, 4) } else { "never".into() }))
            .collect();
        let strong = pushed_by.iter().filter(|(_, r)| r.abs() >= STRONG).take(3);
        let pushed: Vec<String> = strong.map(|(name, r)| format!("{name} ({r:+.2})")).collect();
        let heading = if *unit == "1" { (*figure).to_owned() } else { format!("{figure} ({unit})") };
        out += &format!("{heading:<24}{cells}{flight:>12}   {}\n", pushed.join(", "));
    }
    out.trim_end().to_owned()
}

/// Flies a flight of a campaign again, and writes its record and plot beside the results.
///
/// # Errors
/// As [`run`]; [`squid_campaign::error::Error::NoFlight`].
pub fn replay(directory: &Path, flight: u64) -> Result<(), Error> {
    let path = directory.join(ABOUT);
    let unreadable = |reason| StoreError::Json { path: path.display().to_string(), reason };
    let about: About = serde_json::from_str(&read(&path)?).map_err(unreadable)?;
    let About { vehicle, design, bandwidth, out, sea, seed, points } = about;
    let (inputs, designed) = Which { vehicle, design, bandwidth, out }.read()?;
    let stored = squid_design::store::load(&designed, &inputs)?;
    let parsed = sea.map(|text| Ok::<_, Error>((Sea::parse(&text, ABOUT)?, text))).transpose()?;
    let plan = Plan::new(&inputs, &stored, parsed, seed, points)?;
    let rows = results(&plan, directory)?;
    let no_flight = || squid_campaign::error::Error::NoFlight {
        path: directory.display().to_string(),
        flight,
        last: rows.last().map_or(0, |row| row.flight),
    };
    let known = rows.iter().find(|row| row.flight == flight).ok_or_else(no_flight)?;
    let running = Progress::new(&show).begin("replay", "flying");
    let (row, flown) = plan.fly(flight)?;
    drop(running);
    let bits = |row: &Row| row.drawn.iter().chain(&row.figures).map(|v| v.to_bits()).collect::<Vec<_>>();
    let same = row.outcome == known.outcome && bits(&row) == bits(known);
    let outcome = row.outcome.word();
    let mut written = Vec::new();
    if let Some(flown) = flown {
        let actuators = &inputs.vehicle.actuators;
        let at_sea = !flown.sea.is_empty();
        let record =
            if at_sea { Record::at_sea(&flown, actuators) } else { Record::of(&flown.rows, actuators) };
        let to = |kind: &str| directory.join(format!("flight-{flight}.{kind}"));
        let title = format!("{}, flight {flight} of the campaign: {outcome}", inputs.vehicle.name);
        let svg = draw(&to("svg"), &title, &record.panels(actuators))?;
        write(&to("svg"), svg.as_bytes())?;
        write(&to("csv"), record.csv().as_bytes())?;
        written = vec![to("csv"), to("svg")];
    }
    say(&format!(
        "flight {flight}: {outcome}; figures {} to the bit",
        if same { "the same" } else { "NOT the same" }
    ));
    written.iter().for_each(|path| say(&path.display().to_string()));
    Ok(answer(&json!({ "flight": flight, "outcome": outcome, "same": same, "files": written }))?)
}
