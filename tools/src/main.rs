//! The command `squid`.

use clap::{Args, Parser, Subcommand};
use squid::error::Error;
use squid::inputs::Inputs;
use squid::lpv_command::{self, LpvVerb};
use squid::output::{Files, all_said, check_directory, printed, say};
use squid::package::{Binaries, Kind, Prepared, pack, prepare, require_proof};
use squid::package_platform::Platform;
use squid::report::rendered::rendered;
use squid::stages::Stages;
use squid::store::Stored;
use squid::{design, ladder, model, record, robust, show, simulate, ssp, store, verify};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// From the coefficients of an underwater vehicle to a scheduled pitch controller and to FMUs that any simulation
/// tool flies.
///
/// A vehicle is a directory with vehicle.toml (its coefficients) and design.toml (what is asked of the controller).
#[derive(Parser)]
#[command(version, after_long_help = FIRST_RUN)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

/// The end of `--help`: the examples stand on lines of their own.
const FIRST_RUN: &str = "\
A first run:
  squid show vehicles/squid --speed 1
  squid design vehicles/squid
  squid simulate vehicles/squid
  squid package vehicles/squid

Exit codes: 0 when all is well, 1 when a file is wrong, the work fails or nothing is proved, 64 when the command line is wrong; `squid lpv synth` \
has more.";

#[derive(Subcommand)]
enum Verb {
    /// Design a controller: trim, linearise, fit, LFT, augment, synthesise, check, freeze
    ///
    /// Prints each stage with its key figure and writes controller.json, plant.json, manoeuvre.json and design.json.
    /// A controller that fails a check is not written. One whose gain bound is not proved is written, to be looked at, and the exit code is 1.
    Design {
        #[command(flatten)]
        which: Which,
        /// Also show what each assumption about the speed costs: frozen, slow, arbitrarily fast
        #[arg(long)]
        ladder: bool,
        /// Look for a controller that bears more of the declared uncertainty, and show both side by side (minutes)
        #[arg(long)]
        robust: bool,
    },
    /// Pack the three FMUs of a design: the vehicle, the autopilot, and both in one loop; and the first two wired, as SSP
    ///
    /// Takes what `squid design` wrote. Refuses it when a file changed since, and when the certificate of the gain bound does
    /// not prove.
    Package {
        #[command(flatten)]
        which: Which,
        /// Whom the FMUs run for: host, all, or some of linux64, win64, aarch64-linux, with commas between
        #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "host")]
        platforms: Vec<String>,
        /// Where the FMUs' shared libraries lie, if not where cargo puts them; of named platforms, in folders of that name
        #[arg(long, value_name = "DIR")]
        binaries: Option<PathBuf>,
        /// Pack a controller without proof all the same; its FMUs then say that they are uncertified
        #[arg(long)]
        allow_uncertified: bool,
        /// Write the three model descriptions alone, to this directory
        #[arg(long, value_name = "DIR")]
        descriptions: Option<PathBuf>,
    },
    /// Fly a design in this process: its manoeuvre, pitch steps over the range of speed, the vehicle alone
    ///
    /// Designs first if nothing is designed yet. Writes records (CSV) and plots (SVG).
    Simulate(Which),
    /// Write the report: the paper's figures for this vehicle, and whether it bears out what the paper claims
    ///
    /// One page, report.html, that needs no network, and each figure as figures/NAME.svg. Designs first if nothing is designed yet.
    Report(Which),
    /// Show the trim, A, B and eigenvalues at a speed; the fit and its residuals; the controller's poles
    Show {
        #[command(flatten)]
        which: Which,
        /// Trim, A, B and eigenvalues at this speed along the path, m/s
        #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
        speed: Option<f64>,
        /// The polynomial fit and its residuals
        #[arg(long)]
        fit: bool,
        /// The controller and its poles: the stored one, or one designed now if there is none in the default directory
        #[arg(long)]
        controller: bool,
        /// What is uncertain, its channels in the LFT, and how well that holds
        #[arg(long)]
        uncertainty: bool,
    },
    /// Prove the gain bound of an FMU, or of a certificate.json, in exact arithmetic
    ///
    /// Every number is read as the rational number that it is; nothing is rounded, and nothing is shared with the program that
    /// found the controller. Of an FMU it also checks that the proof is of the very controller inside, and that its resources belong to its
    /// GUID. With --vehicle it computes anew that the proof is about that vehicle, and that scales, trims and limits are those of its
    /// files: all that is asked before an FMU is packed.
    Verify {
        /// A controller's FMU, the FMU of the whole loop, or a certificate
        file: PathBuf,
        /// The vehicle's directory: is the file what this vehicle's design makes?
        #[arg(long, value_name = "DIR")]
        vehicle: Option<PathBuf>,
        /// The design: a file NAME.toml in the vehicle's directory
        #[arg(long, value_name = "NAME", default_value = "design", requires = "vehicle")]
        design: String,
        /// The bandwidth that replaced w_b of every tracking weight, rad/s
        #[arg(long, value_name = "RAD/S", requires = "vehicle", allow_negative_numbers = true)]
        bandwidth: Option<f64>,
    },
    /// LPV synthesis for any plant in a JSON file, with no vehicle
    #[command(subcommand)]
    Lpv(LpvVerb),
    /// Plot the record of a flight, a CSV file such as `fmpy simulate squid.fmu --output-file` writes
    Plot {
        /// The record: a column `time`, then one for each variable
        record: PathBuf,
        /// The vehicle that flew; its actuators are plotted, too
        #[arg(long, value_name = "DIR")]
        vehicle: Option<PathBuf>,
        /// The SVG file to write; beside the record if not named
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

#[derive(Args)]
struct Which {
    /// The vehicle's directory, for instance vehicles/squid
    vehicle: PathBuf,
    /// The design: a file NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = "design")]
    design: String,
    /// Replace the bandwidth w_b of every tracking weight, rad/s (the paper tries 0.46, 0.23 and 0.1)
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    bandwidth: Option<f64>,
    /// The directory for all files; build/VEHICLE/DESIGN if not named
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Which {
    fn read(&self) -> Result<(Inputs, PathBuf), Error> {
        let inputs = Inputs::read(&self.vehicle, &self.design, self.bandwidth)?;
        let directory = self.out.clone().unwrap_or_else(|| store::default_directory(&inputs));
        Ok((inputs, directory))
    }

    /// The same for a verb that writes to the directory, which is told at once if it cannot.
    fn read_to_write(&self) -> Result<(Inputs, PathBuf), Error> {
        let (inputs, directory) = self.read()?;
        check_directory(&directory)?;
        Ok((inputs, directory))
    }
}

/// The solver panics where a decomposition does not converge; that is caught and another way tried, so the message
/// would only frighten. All other panics are defects and print theirs.
fn keep_caught_panics_quiet() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !info.location().is_some_and(|l| l.file().contains("clarabel")) {
            print(info);
        }
    }));
}

/// Exit code when the command line is wrong: `EX_USAGE` of BSD's sysexits.h. Clap's own is 2, which means infeasible here.
const WRONG_USAGE: u8 = 64;

fn main() -> ExitCode {
    keep_caught_panics_quiet();
    let outcome = match Cli::try_parse() {
        Ok(cli) => run(cli.verb),
        Err(told) if told.use_stderr() => {
            let _ = told.print();
            return WRONG_USAGE.into();
        }
        Err(help_or_version) => {
            printed(help_or_version.print());
            Ok(ExitCode::SUCCESS)
        }
    };
    match outcome.and_then(|code| all_said().map(|()| code)) {
        Ok(code) => code,
        Err(error) => {
            // Not `eprintln`, which panics where nothing can be written.
            let _ = writeln!(io::stderr(), "squid: {error}");
            if error.is_usage() { WRONG_USAGE.into() } else { ExitCode::FAILURE }
        }
    }
}

fn run(verb: Verb) -> Result<ExitCode, Error> {
    match verb {
        Verb::Lpv(verb) => lpv_command::run(&verb),
        other => run_plain(other).map(|()| ExitCode::SUCCESS),
    }
}

/// The verbs that either work or fail.
fn run_plain(verb: Verb) -> Result<(), Error> {
    match verb {
        Verb::Design { which, ladder, robust } => run_design(&which, ladder, robust),
        Verb::Package { which, platforms, binaries, allow_uncertified, descriptions } => {
            let binaries = Binaries { platforms: Platform::named(&platforms)?, directory: binaries };
            run_package(&which, &binaries, allow_uncertified, descriptions)
        }
        Verb::Simulate(which) => run_simulate(&which),
        Verb::Report(which) => run_report(&which),
        Verb::Show { which, speed, fit, controller, uncertainty } => {
            run_show(&which, &Asked { speed, fit, controller, uncertainty })
        }
        Verb::Verify { file, vehicle, design, bandwidth } => {
            let inputs = vehicle.map(|directory| Inputs::read(&directory, &design, bandwidth)).transpose()?;
            let found = verify::verify(&file, inputs.as_ref())?;
            found.about.iter().for_each(|line| say(line));
            say(&format!("PROVED: {}", found.theorem));
            Ok(())
        }
        Verb::Lpv(verb) => lpv_command::run(&verb).map(|_| ()),
        Verb::Plot { record, vehicle, out } => {
            let to = out.unwrap_or_else(|| record.with_extension("svg"));
            let actuators = match vehicle {
                Some(directory) => auv::Vehicle::read(&directory.join("vehicle.toml"))?.actuators,
                None => Vec::new(),
            };
            record::plot(&record, &to, &actuators)?;
            say(&to.display().to_string());
            Ok(())
        }
    }
}

fn run_design(which: &Which, with_ladder: bool, with_robust: bool) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stages = Stages::default();
    let finished = design::run_with(&inputs, &stages, with_robust)?;
    store::save(&directory, &inputs, &finished)?;
    stages.done("freeze", &format!("{}", directory.display()));
    if let Some(found) = &finished.robust {
        say(&format!(
            "\n{}PROVED in exact arithmetic: {}",
            found.figures.words(),
            directory.join(robust::CERTIFICATE).display()
        ));
    }
    if with_ladder {
        let running = stages.begin("ladder", "solving for each assumption about the speed");
        let words = ladder::climb(&inputs, &finished)?;
        drop(running);
        say(&format!("\n{}", words.trim_end()));
    }
    let directory = directory.display().to_string();
    finished.proof.map(|_| ()).map_err(|reason| Error::NotProved { directory, reason })
}

fn run_package(
    which: &Which,
    binaries: &Binaries,
    allow_uncertified: bool,
    descriptions: Option<PathBuf>,
) -> Result<(), Error> {
    let (inputs, directory) = which.read()?;
    let mut stored = store::load(&directory, &inputs)?;
    let folder = descriptions.as_ref().unwrap_or(&directory);
    check_directory(folder)?;
    if descriptions.is_none() {
        binaries.find()?;
    }
    let stages = Stages::default();
    let proving = stages.begin("certify", "proving again, and computing again what the proof is about");
    let standing = require_proof(&inputs, &mut stored, &directory, allow_uncertified)?;
    drop(proving);
    say(&standing);
    // All are made before any is written.
    let files: Vec<(PathBuf, Vec<u8>)> = match &descriptions {
        Some(to) => {
            let described = Kind::ALL.into_iter().map(|kind| prepare(kind, &inputs, &stored));
            let file = |p: Prepared| (to.join(format!("{}.xml", p.identifier)), p.xml.into_bytes());
            described.map(|made| made.map(file)).collect::<Result<_, _>>()?
        }
        None => {
            let report = rendered(&inputs, &stored, &directory, &stages)?;
            let packing = stages.begin("package", "compressing");
            let packed = |kind| pack(kind, &inputs, &stored, &report, binaries, &directory);
            let [plant, controller, whole] =
                [packed(Kind::Plant)?, packed(Kind::Controller)?, packed(Kind::Squid)?];
            let name = &whole.description.model_identifier;
            let system = ssp::pack(name, &plant, &controller, &stored, &directory)?;
            drop(packing);
            let fmus = [plant, controller, whole].map(|packed| (packed.path, packed.bytes));
            fmus.into_iter().chain([system]).collect()
        }
    };
    let size =
        |path: &Path, bytes: &[u8]| format!("{} ({:.0} kB)", path.display(), bytes.len() as f64 / 1000.0);
    let told: Vec<String> = files.iter().map(|(path, bytes)| size(path, bytes)).collect();
    let mut set = Files::default();
    files.into_iter().for_each(|(path, bytes)| set.add(path, bytes));
    set.save(folder)?;
    told.iter().for_each(|line| say(line));
    Ok(())
}

fn run_simulate(which: &Which) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stored = load_or_design(&inputs, &directory)?;
    let running = Stages::default().begin("simulate", "flying");
    let found = simulate::run(&inputs, &stored, &directory)?;
    drop(running);
    say(found.trim_end());
    Ok(())
}

fn run_report(which: &Which) -> Result<(), Error> {
    let (inputs, directory) = which.read_to_write()?;
    let stored = load_or_design(&inputs, &directory)?;
    let found = rendered(&inputs, &stored, &directory, &Stages::default())?;
    say(&format!("\n{}", found.words));
    say(&found.save(&directory)?.display().to_string());
    Ok(())
}

/// The stored design, made now if there is none for these files.
fn load_or_design(inputs: &Inputs, directory: &Path) -> Result<Stored, Error> {
    let stored = match store::load(directory, inputs) {
        Err(Error::NotDesigned { .. } | Error::Stale { .. }) => {
            store::save(directory, inputs, &design::run(inputs, &Stages::default())?)?;
            say("");
            store::load(directory, inputs)
        }
        other => other,
    }?;
    stored.unproved(inputs).iter().for_each(|words| say(words));
    Ok(stored)
}

/// What `squid show` is asked for; nothing is all of it but what is uncertain.
struct Asked {
    speed: Option<f64>,
    fit: bool,
    controller: bool,
    uncertainty: bool,
}

fn run_show(which: &Which, asked: &Asked) -> Result<(), Error> {
    let (inputs, directory) = which.read()?;
    let all = asked.speed.is_none() && !asked.fit && !asked.controller && !asked.uncertainty;
    let speed = asked.speed.or(all.then(|| inputs.design.scheduling().0));
    if let Some(v) = speed.filter(|v| !(v.is_finite() && *v > 0.0)) {
        return Err(Error::Argument {
            name: "--speed",
            found: auv::number(v),
            allowed: "above 0 (m/s)".into(),
        });
    }
    let stored = match (store::load(&directory, &inputs), &which.out) {
        (Err(Error::NotDesigned { .. } | Error::Stale { .. }), None) => None,
        (found, _) => Some(found?),
    };
    let controller =
        (asked.controller || all).then(|| shown_controller(&inputs, stored.as_ref(), &directory));
    let controller = controller.transpose()?;
    let unproved = stored.and_then(|stored| stored.unproved(&inputs));
    unproved.iter().for_each(|words| say(words));
    if let Some(v) = speed {
        say(&show::speed(&inputs, v)?);
    }
    if asked.fit || all {
        say(&show::fit(&inputs, &model::Model::new(&inputs)?));
    }
    controller.iter().for_each(|words| say(words.trim_end()));
    if asked.uncertainty {
        say(squid::uncertain_show::uncertainty(&inputs)?.trim_end());
    }
    Ok(())
}

/// The stored controller, or one that is designed to be shown.
fn shown_controller(inputs: &Inputs, stored: Option<&Stored>, directory: &Path) -> Result<String, Error> {
    let directory = directory.display();
    if let Some(stored) = stored {
        let robust = if stored.robust.is_some() { ", made with --robust" } else { "" };
        let words = show::controller(inputs, &stored.lpv_controller()?, &stored.controller.gamma)?;
        return Ok(format!("The design in {directory}{robust}\n{words}"));
    }
    let running = Stages::default().begin("design", "solving the matrix inequalities");
    let finished = design::run(inputs, &Stages::quiet())?;
    drop(running);
    let words = show::controller(inputs, &finished.design.controller, &finished.frozen.controller.gamma)?;
    Ok(format!("No design of these files is in {directory}; this is what `squid design` finds\n{words}"))
}
