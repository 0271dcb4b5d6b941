//! `squid campaign` and `squid replay`: many simulations of a design, and one of them again.

mod fmus;

use crate::cli::{Campaign, MOST_FLIGHTS, Selected, Where, Which, read_sea};
use crate::error::Error;
use crate::output::{answer, json, say, say_path, warn};
use crate::progress::{counter, show};
use crate::verbs::design::load_or_design;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use squid_auv::longitudinal::{DEPTH, PITCH};
use squid_auv::readable;
use squid_base::files::{self, check_directory, read, write};
use squid_base::numbers::{above, decimals};
use squid_base::numbers::{known, percent};
use squid_base::progress::Progress;
use squid_campaign::bound::{Gains, gains};
use squid_campaign::flight::Row;
use squid_campaign::plan::{Plan, Points};
use squid_campaign::run::{missing, results, run as fly_missing};
use squid_campaign::starts::Starts;
use squid_campaign::summary::{Share, Spread, shares, spreads, worst};
use squid_campaign::table::{Column, Values, file};
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_flight::sea::Sea;
use squid_report::campaign::{STRONG, page};
use squid_report::page::draw;
use squid_report::record::panels;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};

/// File with the options of the campaign, for `replay`.
const ABOUT: &str = "campaign.json";

/// Folder of trajectories in the directory of the results.
const TRAJECTORIES: &str = "trajectories";

/// Number of the worst flights whose trajectories are written.
const WORST: usize = 10;

/// Number of vehicles, from the first on, whose gains are computed.
const GAINS: usize = 100;

/// Options with which a campaign was run.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct About {
    vehicle: PathBuf,
    design: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    axis: Option<String>,
    bandwidth: Option<f64>,
    out: Option<PathBuf>,
    sea: Option<String>,
    seed: u64,
    points: Points,
    #[serde(default, skip_serializing_if = "Starts::in_trim")]
    starts: Starts,
    fmus: bool,
}

/// Refuses initial deviations larger than the speed range, the depth, or an upright pitch.
fn check_starts(starts: &Starts, inputs: &Inputs) -> Result<(), Error> {
    let design = &inputs.design;
    if design.view().is_level_held && !starts.in_trim() {
        let allowed = "omitted, because flights of a heading design start straight".to_owned();
        return Err(Error::Argument { name: "--starts", found: starts.to_string(), allowed });
    }
    let range = design.speed_max - design.speed_min;
    for (index, signal) in starts.off() {
        let most = match index {
            PITCH => FRAC_PI_2,
            DEPTH => design.depth,
            _ if signal.name == "pitch_rate" => PI,
            _ => range,
        };
        if starts.0[index] > most {
            let (factor, unit) = readable(signal.unit);
            let found = format!("{}={}{unit}", signal.name, squid_auv::number(starts.0[index] * factor));
            let allowed = format!("at most {} {unit} in {}", squid_auv::number(most * factor), signal.name);
            return Err(Error::Argument { name: "--starts", found, allowed });
        }
    }
    Ok(())
}

/// Simulates the missing flights of a campaign, and prints the statistics of all.
///
/// # Errors
/// Errors of the files and of the design; [`Error::Campaign`]; [`Error::Argument`] if there is nothing to simulate.
pub fn run(which: &Which, options: &Campaign) -> Result<(), Error> {
    let flights = match &options.only {
        Some(part) => *part.start()..part.end() + 1,
        None => 0..options.flights,
    };
    if !(1..=MOST_FLIGHTS).contains(&flights.end) {
        let (found, allowed) =
            (options.flights.to_string(), format!("at least 1 and at most {MOST_FLIGHTS}"));
        return Err(Error::Argument { name: "--flights", found, allowed });
    }
    let Selected { axes, directory } = which.read_to_write()?;
    let first = &axes[0].0;
    let starts = options.starts.unwrap_or_default();
    check_starts(&starts, first)?;
    let to = options.to.clone().unwrap_or_else(|| directory.join("campaign"));
    check_directory(&to)?;
    let sea = options.sea.as_ref().map(|path| read_sea(path, first)).transpose()?;
    let stored = load_or_design(&axes)?;
    let designs: Vec<_> = axes.iter().map(|(inputs, _)| inputs).zip(&stored).collect();
    let points = match options.points {
        Where::Uniform => Points::Uniform,
        Where::Sobol => Points::Sobol,
        Where::Corners => Points::Corners,
    };
    let plan = Plan::of_axes(&designs, sea, options.seed, points)?;
    let plan = plan.with_starts(starts);
    let plan = if options.records.is_some() { plan.with_fmus()? } else { plan };
    let parts = missing(&plan, flights.clone(), &to)?;
    let left: u64 = parts.iter().map(|part| part.end() + 1 - part.start()).sum();
    let full = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let about = About {
        vehicle: first.directory.clone(),
        design: which.design.clone(),
        axis: which.axis.clone(),
        bandwidth: which.bandwidth,
        out: which.out.as_deref().map(full),
        sea: plan.identity.sea.clone(),
        seed: options.seed,
        points,
        starts: plan.identity.starts,
        fmus: plan.identity.fmus,
    };
    if options.dry_run {
        say(&format!("{left} of {} flights are missing in {}", flights.end - flights.start, to.display()));
        let listed = options.only.iter().flat_map(|_| parts.iter().cloned().flatten());
        let drawn: Vec<Value> = listed.map(|flight| fmus::drawn(&plan, flight)).collect();
        let (about, to, design) = (json!(about), full(&to), full(&directory));
        let parts: Vec<[u64; 2]> = parts.iter().map(|part| [*part.start(), *part.end()]).collect();
        return Ok(answer(
            &json!({ "campaign": about, "design": design, "to": to, "missing": parts, "drawn": drawn }),
        )?);
    }
    if options.only.is_none() {
        designs.iter().filter_map(|(inputs, stored)| stored.unproved(inputs)).for_each(|found| warn(&found));
    }
    write(&to.join(ABOUT), json(&about)?.as_bytes())?;
    let flown = flights.end - flights.start - left;
    let counter = counter("campaign", flights.end - flights.start);
    counter.set_position(flown);
    let on_progress = |done| counter.set_position(flown + done);
    match &options.records {
        None => fly_missing(&plan, &parts, &to, &|flight| plan.row(flight), &on_progress)?,
        Some(records) => fly_missing(
            &plan,
            &parts,
            &to,
            &|flight| fmus::evaluate_record(&plan, records, flight),
            &on_progress,
        )?,
    }
    counter.finish_and_clear();
    if options.only.is_some() {
        say(&format!("{left} flights simulated, in {}", to.display()));
        return Ok(answer(&json!({ "directory": to, "flights": left }))?);
    }
    let rows: Vec<Row> =
        results(&plan, &to)?.into_iter().filter(|row| flights.contains(&row.flight)).collect();
    let (shares, spreads) = (shares(&rows), spreads(&plan, &rows));
    let worst = worst(&rows, WORST);
    let all = if options.trajectories { rows.iter().collect() } else { worst.clone() };
    all.par_iter().try_for_each(|row| trajectory(&plan, &to, row.flight))?;
    let first: Vec<u64> = rows.iter().map(|row| row.flight).take(GAINS).collect();
    let gains = if options.no_bound { Ok(Vec::new()) } else { gains(&plan, &first) };
    say(&statistics(&plan, rows.len(), &shares, &spreads));
    // A failure to build the uncertain model does not invalidate the simulations.
    say(&gains
        .as_ref()
        .map_or_else(|reason| format!("\nNo guaranteed gain: {reason}\n"), |at| gains_table(at)));
    let gains = gains.unwrap_or_default();
    let path = to.join("campaign.html");
    write(&path, page(&plan, &rows, &shares, &spreads, &gains).as_bytes())?;
    let worst: Vec<u64> = worst.iter().map(|row| row.flight).collect();
    say(&format!("Worst flights: {}", worst.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")));
    let files = |part: &str| to.join(part).display().to_string();
    say(&format!("Trajectories: {}", files(&format!("{TRAJECTORIES}/flight-*.parquet"))));
    say(&format!("Results: {}\nPage: {}", files("*.parquet"), path.display()));
    Ok(answer(&json!({
        "directory": to,
        "page": path,
        "flights": rows.len(),
        "outcomes": shares,
        "figures": spreads,
        "gains": gains.iter().map(|at| json!({
            "axis": at.axis,
            "speed": at.speed,
            "largest": at.largest().map(|(_, gain)| gain),
            "flight": at.largest().map(|(flight, _)| flight),
            "vehicles": at.drawn.len(),
            "outside": at.outside,
            "guaranteed": at.guaranteed,
        })).collect::<Vec<_>>(),
        "worst": worst,
    }))?)
}

/// Returns the gains of the sampled vehicles, and the guaranteed gains, as a table.
fn gains_table(gains: &[Gains]) -> String {
    let Some(first) = gains.first() else { return String::new() };
    let vehicles = first.drawn.len() + first.outside;
    let mut out =
        format!("\nspeed (m/s)   worst gain of {vehicles} vehicles   in flight   guaranteed for the model\n");
    let several = gains.iter().any(|at| at.axis != first.axis);
    for at in gains {
        let speed = decimals(at.speed, 2);
        let speed = if several { format!("{} {speed}", at.axis) } else { speed };
        let (gain, flight) = at.largest().map_or_else(Default::default, |(flight, gain)| {
            (if gain.is_finite() { decimals(gain, 4) } else { "unstable".into() }, flight.to_string())
        });
        let bound =
            at.guaranteed.map_or_else(|| "no bound".into(), |bound| format!("below {}", above(bound)));
        out += &format!("{:<14}{gain:<28}{flight:<12}{bound}\n", speed);
    }
    out
}

/// Writes the trajectory of a flight, which is simulated again, unless the file exists.
fn trajectory(plan: &Plan<'_>, to: &Path, flight: u64) -> Result<(), Error> {
    let path = to.join(TRAJECTORIES).join(format!("flight-{flight:08}.parquet"));
    if path.is_file() {
        return Ok(());
    }
    let Some(flown) = plan.fly(flight)?.1 else { return Ok(()) };
    let record = plan.record(&flown);
    let number = |(name, unit, values): (&str, &str, &[f64])| {
        let values = Values::Numbers(values.to_vec());
        Column { name: name.into(), unit: unit.into(), values }
    };
    let ticks = flown.axes.first().map_or(0, |flight| flight.rows.len());
    let which = Values::Whole(vec![flight as i64; ticks]);
    let first = Column { name: "flight".into(), unit: String::new(), values: which };
    let columns: Vec<Column> = [first].into_iter().chain(record.columns().map(number)).collect();
    Ok(write(&path, &file(plan, &columns)?)?)
}

/// Returns the statistics as tables.
fn statistics(plan: &Plan<'_>, flights: usize, shares: &[Share], spreads: &[Spread]) -> String {
    let what = match plan.identity.points {
        Points::Uniform => "from the whole declared uncertainty",
        Points::Sobol => "from a Sobol sequence over the declared uncertainty",
        Points::Corners => "at corners of the declared uncertainty",
    };
    let at_sea = if plan.sea.is_some() { ", at sea" } else { "" };
    let flown = if plan.axes.len() > 1 { ", in six degrees of freedom" } else { "" };
    let mut out = format!(
        "{flights} flights of vehicles {what}{at_sea}{flown}{}; uncertain numbers: {}\n\n\
         outcome      flights     share   95 % interval\n",
        plan.identity.starts.text(),
        plan.uncertain.len()
    );
    for Share { outcome, flights, share, interval: [low, high] } in shares {
        let [share, low, high] = [share, low, high].map(|part| percent(*part, 2));
        out += &format!("{outcome:<10} {flights:>9}  {share:>7}  {low} to {high}\n");
    }
    out += "\nfigure                      median      95 %      99 %   largest   in flight   \
            correlated with (rank correlation)\n";
    for Spread { figure, unit, quantiles, largest, flight, pushed_by } in spreads {
        let cells: String =
            quantiles.iter().chain([largest]).map(|v| format!("{:>10}", known(*v, 4))).collect();
        let strong = pushed_by.iter().filter(|(_, r)| r.abs() >= STRONG).take(3);
        let pushed: Vec<String> = strong.map(|(name, r)| format!("{name} ({r:+.2})")).collect();
        let heading = if *unit == "1" { figure.clone() } else { format!("{figure} ({unit})") };
        out += &format!("{heading:<24}{cells}{flight:>12}   {}\n", pushed.join(", "));
    }
    out.trim_end().to_owned()
}

/// Simulates a flight of a campaign again, and writes its record and plot next to the results.
///
/// # Errors
/// Errors of [`run`]; [`squid_campaign::error::Error::NoFlight`].
pub fn replay(directory: &Path, flight: u64) -> Result<(), Error> {
    let path = directory.join(ABOUT);
    if !path.exists() {
        return Err(squid_campaign::error::Error::NoCampaign { path: path.display().to_string() }.into());
    }
    let unreadable = |reason| files::Error::Json { path: path.display().to_string(), reason };
    let about: About = serde_json::from_str(&read(&path)?).map_err(unreadable)?;
    let About { vehicle, design, axis, bandwidth, out, sea, seed, points, starts, fmus } = about;
    let Selected { axes, .. } = Which { vehicle, design, axis, bandwidth, out }.read()?;
    let load = |(inputs, directory): &(Inputs, PathBuf)| squid_design::store::load(directory, inputs);
    let stored: Vec<Stored> = axes.iter().map(load).collect::<Result<_, _>>()?;
    let designs: Vec<_> = axes.iter().map(|(inputs, _)| inputs).zip(&stored).collect();
    let parsed = sea.map(|text| Ok::<_, Error>((Sea::parse(&text, ABOUT)?, text))).transpose()?;
    let plan = Plan::of_axes(&designs, parsed, seed, points)?.with_starts(starts);
    let plan = if fmus { plan.with_fmus()? } else { plan };
    let rows = results(&plan, directory)?;
    let no_flight = || squid_campaign::error::Error::NoFlight {
        path: directory.display().to_string(),
        flight,
        last: rows.last().map_or(0, |row| row.flight),
    };
    let known = rows.iter().find(|row| row.flight == flight).ok_or_else(no_flight)?;
    let (row, flown) = Progress::new(&show).timed("replay", "flying", || plan.fly(flight)).0?;
    let diff = row.differs_from(known);
    let outcome = row.outcome.word();
    let mut written = Vec::new();
    if let Some(flown) = flown {
        let (actuators, record) = (&plan.vehicle.actuators, plan.record(&flown));
        let to = |kind: &str| directory.join(format!("flight-{flight}.{kind}"));
        let title = format!("{}, flight {flight} of the campaign: {outcome}", plan.vehicle.name);
        let svg = draw(&to("svg"), &title, &panels(&record, actuators))?;
        write(&to("svg"), svg.as_bytes())?;
        write(&to("csv"), record.csv().as_bytes())?;
        written = vec![to("csv"), to("svg")];
    }
    let compared = match (fmus, diff == 0.0) {
        (false, true) => "figures identical to the bit".to_owned(),
        (false, false) => "figures NOT identical to the bit".to_owned(),
        (true, _) => format!(
            "simulated by the FMUs; without FMUs the figures differ by at most {diff:.1e}, relative to the larger of \
                1 and the figure"
        ),
    };
    say(&format!("flight {flight}: {outcome}; {compared}"));
    written.iter().for_each(|path| say_path(path));
    Ok(answer(&json!({
        "flight": flight, "outcome": outcome, "same": diff == 0.0, "difference": diff, "fmus": fmus, "files": written
    }))?)
}
