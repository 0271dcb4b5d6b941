//! Command line: verbs and options, with their help.

use crate::error::Error;
use crate::verbs::lpv::LpvVerb;
use crate::verbs::new::Like;
use crate::verbs::prove::gains::GainsVerb;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use squid_auv::Vehicle;
use squid_base::files::{check_directory, read};
use squid_campaign::starts::Starts;
use squid_design::error::InputError;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{BANDWIDTH, RATE};
use squid_design::store;
use squid_flight::sea::Sea;
use squid_package::kind::Interfaces;
use squid_scheduled::DEFAULT_DESIGN;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Design, prove and simulate gain-scheduled autopilots of underwater vehicles, and pack them as FMUs
///
/// A vehicle is a directory with vehicle.toml (its coefficients) and design.toml (the requirements on the controller).
/// The result is a controller of pitch, depth or heading that is scheduled with speed, as FMUs for any simulation tool
/// and as C source.
#[derive(Debug, Parser)]
#[command(name = "squid", version, after_long_help = FIRST_RUN)]
pub struct Cli {
    #[command(subcommand)]
    /// Verb to run.
    pub verb: Verb,
    /// Print the result as one JSON object and nothing else, also on errors
    #[arg(long, global = true)]
    pub json: bool,
}

/// End of `--help`, with one example per line.
const FIRST_RUN: &str = "A first run:
  squid show vehicles/squid --speed 1
  squid design vehicles/squid
  squid \
simulate vehicles/squid
  squid package vehicles/squid
  squid export vehicles/squid

Exit codes: 0, success; 1, an \
error in a file or a stage, or a failed proof; 5, a requirement is missed (with `squid design --strict`, `squid \
prove --strict` and `squid tune`); 64, an error on the command line. `squid lpv synth` has further codes.";

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Design a controller: trim, linearise, fit, LFT, augment, synthesise, check, freeze
    ///
    /// Prints each stage with its key figure and writes controller.json, plant.json, manoeuvre.json and design.json. A
    /// controller that fails a check is not written. A controller whose gain bound is not proved is written for
    /// inspection, with exit code 1. The verdict at the end compares the design with `[require]` of the design file;
    /// for each missed requirement it names the weight to change, and in which direction.
    Design {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        options: Design,
    },
    /// Prove a given controller of one axis, such as a PID with scheduled gains, on the weights of a design
    ///
    /// Prints the slowest mode and the largest gain of the frozen loops, the gain proved for any trajectory of the
    /// speed, the gain of the sampled loop, margins, mu, noise, simulations of the declared uncertainty, the gain of a
    /// full-order controller on the same weights, and the verdict on `[require]`. Writes nothing: to get FMUs and C
    /// source, copy the `[controller]` into a design file and use `squid design`. docs/pid.md explains the format.
    /// Rejected are loops that are unstable at a constant speed, gains with wrong units or signs or on signals that are
    /// not measured, and an integrator without gain.
    Prove(Prove),
    /// Convert PID gains between `[controller]` and the files of DUNE, ArduSub, mvp or MSS
    #[command(subcommand)]
    Gains(GainsVerb),
    /// Search the weights for a fast, quiet design that meets `[require]`, and write it as a design file
    ///
    /// Short rise times count most, then low noise on the commands and a large delay margin. The search changes
    /// frequencies and bandwidths of `[[track]]`, noise of `[[measure]]`, and weight and disturbance of `[control]`,
    /// and lowers `follow` once if no design meets the requirements; everything else in the file is preserved,
    /// including comments. A design file that does not exist is created from the vehicle, with a suitable speed range.
    /// The result is the same on any machine. Exit code 5 if the best design misses a requirement; the file is written
    /// nevertheless.
    Tune {
        /// Directory of the vehicle
        vehicle: PathBuf,
        /// Initial design: NAME.toml in the vehicle's directory, created if it does not exist
        #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
        design: String,
        /// Axis to tune, named by the quantity it steers, if the design file has several; by default each in turn
        #[arg(long, value_name = "NAME")]
        axis: Option<String>,
        /// Reference to track in a design file that is created: pitch (with speed) or heading, at the speeds of
        /// design.toml if it exists. By default every quantity that the vehicle can steer, one axis each. To track
        /// depth, add `[[track]]` of depth to a pitch design; see docs/guide.md
        #[arg(long, value_enum, value_name = "OUTPUT", conflicts_with = "controller")]
        track: Option<Track>,
        /// Design to write: NAME.toml in the vehicle's directory; by default `tuned`, or the file that was created
        #[arg(long, value_name = "NAME", value_parser = design_name)]
        to: Option<String>,
        /// Largest number of designs; the search ends earlier once a round improves by less than 1 %
        #[arg(long, value_name = "COUNT", default_value_t = 100, conflicts_with = "controller")]
        designs: usize,
        /// Tune the gains of a PID instead, for the weights of the design, and write the design with `[controller]`
        ///
        /// Minimises the gain of the loop at frozen speeds, then the proved gain for any trajectory of the speed.
        /// `[require]` does not affect the search; the verdict is reported at the end. A `[controller]` in the design
        /// file sets structure and initial gains; see docs/pid.md. The search is local: another start may give other
        /// gains.
        #[arg(long, value_enum, value_name = "KIND")]
        controller: Option<TunedController>,
        /// Degree of the PID gains as polynomials in the speed: 0 or 1
        #[arg(long, value_name = "DEGREE", default_value_t = 0, requires = "controller",
            value_parser = clap::value_parser!(u8).range(0..=1))]
        degree: u8,
    },
    /// Pack a design as FMUs: vehicle, autopilot, and both in closed loop; and an SSP that connects the first two
    ///
    /// Reads the output of `squid design`. Rejects a design whose input files have changed since, or whose gain bound
    /// is not proved. If the design has several axes, each is proved; with a heading axis the vehicle moves in six
    /// degrees of freedom.
    Package {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        options: Packing,
    },
    /// Export the controller of a design as C source for the vehicle's computer
    ///
    /// Reads the output of `squid design`. Writes NAME.h and NAME.c in C99; if there are several axes, also a folder
    /// with the source of each. The source needs the math library (-lm) only if a thruster has `T_nn` or heave is
    /// measured; the header says so. Also writes controller.json and certificate.json, for `squid verify --c`. Rejects
    /// the same designs as `squid package`.
    Export {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        options: Export,
    },
    /// Simulate a design: its manoeuvre, steps over the speed range, and the open-loop vehicle
    ///
    /// Designs first if there is no design yet. Writes records (CSV) and plots (SVG). A design with a heading axis in
    /// addition to pitch or depth is also simulated in six degrees of freedom: turns at six speeds, combined with steps
    /// of pitch or depth.
    Simulate {
        #[command(flatten)]
        which: Which,
        /// Simulate with the waves, current and sensor errors of this file, and in still water for comparison; with
        /// several axes also the turns. vehicles/sea.toml explains each key
        #[arg(long, value_name = "FILE")]
        sea: Option<PathBuf>,
        /// Turn angle, deg, positive to starboard; by default 60
        #[arg(long, value_name = "DEG", allow_negative_numbers = true, conflicts_with = "axis")]
        turn: Option<f64>,
        /// Steady current during the turns, m/s: north (the initial heading of the vehicle) and east; added to that of
        /// --sea
        #[arg(long, value_name = "NORTH,EAST", value_parser = pair, allow_hyphen_values = true,
            conflicts_with = "axis")]
        current: Option<[f64; 2]>,
    },
    /// Simulate a design many times with random vehicles of the declared uncertainty, speeds, steps and seas
    ///
    /// Each flight is the default manoeuvre between two random speeds of the speed range, with a step up or down. The
    /// results are Parquet files with one row per flight, which pandas and polars read as one table, and campaign.html.
    /// If the command is repeated, only missing flights are simulated. A flight depends only on its number and the
    /// seed: neither the number of cores nor interruptions change a bit. Designs first if there is no design yet. A
    /// campaign does not prove anything. `python -m squid_campaign` distributes a campaign over many machines.
    Campaign {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        options: Campaign,
    },
    /// Simulate one flight of a campaign again, and plot it
    ///
    /// Writes flight-N.csv and flight-N.svg next to the results, and prints whether the figures equal those in the
    /// results bit for bit.
    Replay {
        /// Directory of the results
        results: PathBuf,
        /// Number of the flight
        #[arg(long, value_name = "NUMBER")]
        flight: u64,
    },
    /// Write the report on a design: steps, margins, loops, mu and more
    ///
    /// Writes a self-contained page, report.html, and each figure as figures/NAME.svg. Designs first if there is no
    /// design yet.
    Report {
        #[command(flatten)]
        which: Which,
        /// Add sections on the paper by Sutarto and Budiyono (2011): each of its claims, the criterion for it, and
        /// whether this vehicle confirms it
        #[arg(long)]
        paper: bool,
        /// Add simulations with the waves, current and sensor errors of this file; see vehicles/sea.toml
        #[arg(long, value_name = "FILE")]
        sea: Option<PathBuf>,
        /// Compare with another design of the vehicle, NAME.toml in its directory, in a table of sizes, proved gains,
        /// simulations and verdicts; designs it first if necessary. May be repeated
        #[arg(long, value_name = "NAME", value_parser = design_name)]
        beside: Vec<String>,
    },
    /// Show trim, A, B and eigenvalues at a speed; the fit and its residuals; the poles of the controller
    ///
    /// `--speed` alone needs no design file: if design.toml does not exist or does not fit the vehicle, the trim is at
    /// the depth for which the buoyancy is given.
    Show {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        options: Show,
    },
    /// Prove the gain bound of an FMU, a C source or a certificate.json in exact arithmetic
    ///
    /// Every number is read as an exact rational number, nothing is rounded, and no code is shared with the synthesis.
    /// For an FMU it also checks that the proof belongs to the controller in it, and that its resources match its GUID;
    /// if there are two axes, both are proved. With --vehicle it recomputes plant, scales, trims and limits from the
    /// vehicle's files: all that is required before an FMU is packed. Without it, claims are in the certificate's own
    /// units. Binaries are compared with those that this version of squid packs and, with --vehicle, also the
    /// documentation page if the design is stored next to the FMU; files that differ are listed, and not examined.
    Verify(Verify),
    /// Synthesis and analysis of LPV systems in JSON files, without a vehicle
    #[command(subcommand)]
    Lpv(LpvVerb),
    /// Create a commented vehicle to start from: DIRECTORY/vehicle.toml and design.toml
    New {
        /// New directory, which must not exist; its name becomes that of the vehicle
        directory: PathBuf,
        /// Vehicle to start from
        #[arg(long, value_enum, default_value = "squid")]
        like: Like,
    },
    /// Check that this machine has what squid needs, and print how to install the rest
    ///
    /// Exit code 1 if a program is missing without which no FMU can be built.
    Doctor,
    /// Print a shell completion script
    ///
    /// For instance `squid completions bash > ~/.local/share/bash-completion/completions/squid`.
    Completions {
        /// Name of the shell
        shell: Shell,
    },
    /// Write manual pages, one for each verb
    Man {
        /// Directory for squid.1 and the others
        directory: PathBuf,
    },
    /// Plot the record of a simulation, a CSV file such as `fmpy simulate squid.fmu --output-file` writes
    ///
    /// With --json it prints the figures of the simulation in s, rad, m/s and fractions: pitch_steps with overshoot,
    /// rise_time, settling_time (null: never settled) and steady_error, pitch_error, speed_error, actuator_use,
    /// surface; and the same for depth and heading if the record has a reference of them. A reference of depth or
    /// heading that is limited in rate counts as a step to its final value.
    Plot {
        /// Record: a column `time`, then one for each variable
        record: PathBuf,
        /// Directory of the vehicle, to plot its actuators too
        #[arg(long, value_name = "DIR")]
        vehicle: Option<PathBuf>,
        /// SVG file to write; by default next to the record
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Default, Args)]
pub struct Design {
    /// Show gamma also for each assumption about the speed: frozen, slow, arbitrarily fast
    #[arg(long)]
    pub ladder: bool,
    /// Search for a controller that tolerates more of the declared uncertainty, and compare the two (takes a minute;
    /// tens of minutes if it misses a requirement and --no-advise is not given)
    #[arg(long)]
    pub robust: bool,
    /// Prove a gain also for all constant values of the declared uncertain coefficients, while the speed changes
    /// arbitrarily fast or, with `--constant=0.1`, by at most 0.1 m/s^2 (takes half a minute to minutes)
    #[arg(long, value_name = "M/S^2", num_args = 0..=1, require_equals = true, value_parser = rate)]
    pub constant: Option<Option<f64>>,
    /// Do not search for the key to change if a requirement is missed; the search takes one design per key
    #[arg(long)]
    pub no_advise: bool,
    /// Exit with code 5 if a requirement is missed
    #[arg(long)]
    pub strict: bool,
}

/// References that a design file created by `squid tune` can track.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Track {
    /// Pitch and speed, by surge, heave and pitch
    Pitch,
    /// Heading, by sway and yaw
    Heading,
}

/// Structures that `squid tune` can tune instead of weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TunedController {
    /// Gains of a PID
    Pid,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Prove {
    /// Directory of the vehicle, for instance vehicles/remus100
    pub vehicle: PathBuf,
    /// Design that provides speed range, weights and measurements: NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
    pub design: String,
    /// Axis of the controller, named by the quantity it steers, if the design file has several
    #[arg(long, value_name = "NAME")]
    pub axis: Option<String>,
    /// File with `[controller]` only; by default that of the design file
    #[arg(long, value_name = "FILE")]
    pub controller: Option<PathBuf>,
    /// Exit with code 5 if a requirement is missed
    #[arg(long)]
    pub strict: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Export {
    /// Programming language
    #[arg(long, value_enum, default_value = "c")]
    pub language: Language,
    /// Type of all numbers
    #[arg(long, value_enum, default_value = "double")]
    pub real: Real,
    /// Directory for the source; by default `c` in the directory of the design
    #[arg(long, value_name = "DIR")]
    pub to: Option<PathBuf>,
    /// Export a controller without proof; the source then says that it is uncertified
    #[arg(long)]
    pub allow_uncertified: bool,
    /// Print the mathematical statement that is proved as well, as in the file
    #[arg(long)]
    pub verbose: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Verify {
    /// FMU of a controller, FMU of the closed loop, or certificate
    #[arg(required_unless_present = "c")]
    pub file: Option<PathBuf>,
    /// Verify a C source written by `squid export` instead of FILE, with the other files in its directory: every number
    /// must follow from the controller of the certificate
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub c: Option<PathBuf>,
    /// Directory of the vehicle, to check that the file belongs to its design
    #[arg(long, value_name = "DIR")]
    pub vehicle: Option<PathBuf>,
    /// Design: NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, requires = "vehicle")]
    #[arg(value_parser = design_name)]
    pub design: String,
    /// Axis to which the file belongs, named by the quantity it steers, if the design file has several
    #[arg(long, value_name = "NAME", requires = "vehicle")]
    pub axis: Option<String>,
    /// Bandwidth that replaced w_b of every tracking weight, rad/s
    #[arg(long, value_name = "RAD/S", requires = "vehicle", allow_negative_numbers = true)]
    pub bandwidth: Option<f64>,
    /// Print the mathematical statement that is proved as well, as in the file
    #[arg(long)]
    pub verbose: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Show {
    /// Show trim, A, B and eigenvalues at this speed along the path, m/s
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// Show the polynomial fit and its residuals
    #[arg(long)]
    pub fit: bool,
    /// Show the controller and its poles: the stored one, or a new design if the default directory has none
    #[arg(long)]
    pub controller: bool,
    /// Show the uncertain parameters, their channels in the LFT, and the errors of the model
    #[arg(long)]
    pub uncertainty: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Campaign {
    /// Number of flights
    #[arg(long, value_name = "COUNT", default_value_t = 1000)]
    pub flights: u64,
    /// Simulate with the waves, current and sensor errors of this file; see vehicles/sea.toml
    #[arg(long, value_name = "FILE")]
    pub sea: Option<PathBuf>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Distribution of the vehicles over the declared uncertainty
    #[arg(long, value_enum, default_value_t = Where::Uniform)]
    pub points: Where,
    /// Largest initial deviations from trim, such as pitch=10deg,heave=0.1m/s; allowed are pitch, speed, depth,
    /// pitch_rate and heave. By default flights start in trim
    #[arg(long, value_name = "LIST")]
    pub starts: Option<Starts>,
    /// Directory of the results; by default `campaign` in the directory of the design
    #[arg(long, value_name = "DIR")]
    pub to: Option<PathBuf>,
    /// Write the trajectory of each flight, not only of the ten worst: trajectories/flight-N.parquet
    #[arg(long)]
    pub trajectories: bool,
    /// Skip the guaranteed gain of the uncertain model and the gains of the first hundred vehicles, which take some
    /// seconds
    #[arg(long)]
    pub no_bound: bool,
    /// Simulate only these flights, regardless of --flights, and write no page: one part of a campaign
    #[arg(long, value_name = "FIRST-LAST", value_parser = flight_range)]
    pub only: Option<RangeInclusive<u64>>,
    /// Simulate nothing, and print which flights are missing; with --only and --json also their random numbers
    #[arg(long)]
    pub dry_run: bool,
    /// Simulate nothing, and evaluate records of the design's FMUs simulated with these random numbers:
    /// DIR/flight-N.csv
    #[arg(long, value_name = "DIR")]
    pub records: Option<PathBuf>,
}

/// Parses a bound on the rate of the speed, m/s^2.
fn rate(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|rate| RATE.allows(*rate)).ok_or_else(|| format!("a number {}", RATE.text))
}

/// Parses the numbers of the first and the last flight.
fn flight_range(text: &str) -> Result<RangeInclusive<u64>, String> {
    let ends = text.split_once('-').and_then(|(first, last)| Some((first.parse().ok()?, last.parse().ok()?)));
    let flights = ends.filter(|(first, last): &(u64, u64)| first <= last && *last < MOST_FLIGHTS);
    flights.map(|(first, last)| first..=last).ok_or_else(|| {
        "the numbers of the first and the last flight, as in \
        64-127"
            .into()
    })
}

/// Largest number of flights; the numbers have at most eight digits.
pub const MOST_FLIGHTS: u64 = 100_000_000;

/// Distribution of the vehicles of a campaign over the declared uncertainty.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Where {
    /// Uniform
    Uniform,
    /// Scrambled Sobol sequence, which also gives speeds and steps
    Sobol,
    /// Random corners
    Corners,
}

/// Languages in which a controller can be exported.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Language {
    /// C99: a header and a source
    C,
}

/// Options of `squid package`.
#[derive(Debug, Args)]
pub struct Packing {
    /// Platforms of the FMUs: host, all, or a comma-separated list of linux64, win64, aarch64-linux, darwin64
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "host")]
    pub platforms: Vec<String>,
    /// FMI interfaces of the FMUs; some tools accept only FMUs with one
    #[arg(long, value_enum, default_value = "both")]
    pub kind: FmuKind,
    /// Directory of the FMUs' shared libraries, if not cargo's; libraries of named platforms are in subdirectories of
    /// the same names
    #[arg(long, value_name = "DIR")]
    pub binaries: Option<PathBuf>,
    /// Pack a controller without proof; its FMUs then say that they are uncertified
    #[arg(long)]
    pub allow_uncertified: bool,
    /// Write only the three model descriptions, to this directory
    #[arg(long, value_name = "DIR")]
    pub descriptions: Option<PathBuf>,
    /// Print the mathematical statement that is proved as well, as in the file
    #[arg(long)]
    pub verbose: bool,
}

/// FMI interfaces of an FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FmuKind {
    /// Co-simulation only: the FMU steps itself
    Cs,
    /// Model exchange only, for plant and closed loop: the importer integrates; the sampled controller is left out
    Me,
    /// Both; the controller supports co-simulation only
    Both,
}

impl From<FmuKind> for Interfaces {
    fn from(kind: FmuKind) -> Self {
        match kind {
            FmuKind::Cs => Self::CoSimulation,
            FmuKind::Me => Self::ModelExchange,
            FmuKind::Both => Self::All,
        }
    }
}

/// Type of the numbers of a controller in C.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Real {
    /// 64 bits: the results equal those of the controller's FMU to the last bit
    Double,
    /// 32 bits, for processors without 64-bit arithmetic
    Float,
}

#[allow(missing_docs)] // A doc comment here would take the place of the verbs' own help.
#[derive(Debug, Clone, Args)]
pub struct Which {
    /// Directory of the vehicle, for instance vehicles/squid
    pub vehicle: PathBuf,
    /// Design: NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
    pub design: String,
    /// Axis to use, named by the quantity it steers (pitch, depth or heading), if the design file has several; by
    /// default all
    #[arg(long, value_name = "NAME")]
    pub axis: Option<String>,
    /// Replace the bandwidth w_b of every tracking weight, rad/s; for `--design paper` of Squid, the paper uses 0.46,
    /// 0.23 and 0.1
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    pub bandwidth: Option<f64>,
    /// Directory for all files; by default build/VEHICLE/DESIGN
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Parses two comma-separated numbers.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let both = text.split_once(',').and_then(|(one, other)| Some([number(one)?, number(other)?]));
    both.ok_or_else(|| "it must be two comma-separated numbers, such as 0.4,-0.1".to_owned())
}

/// Checks the name of a design, which is that of a file NAME.toml in the vehicle's directory.
fn design_name(text: &str) -> Result<String, String> {
    let allowed = "it must be the name of a file next to vehicle.toml, without '.toml'";
    match text {
        "vehicle" => Err(format!("vehicle.toml is the vehicle itself; {allowed}")),
        "" | "." | ".." => Err(allowed.to_owned()),
        _ if text.contains(['/', '\\']) || text.ends_with(".toml") => Err(allowed.to_owned()),
        _ => Ok(text.to_owned()),
    }
}

/// Axes of a vehicle's autopilot that a command line selects.
#[derive(Debug)]
pub struct Selected {
    /// Files of each axis, and the directory of its design.
    pub axes: Vec<(Inputs, PathBuf)>,
    /// Directory of the files for all axes; for a single axis the directory of its design.
    pub directory: PathBuf,
}

impl Which {
    /// Reads the vehicle and design files.
    ///
    /// # Errors
    /// [`Error::Argument`], and errors of the files.
    pub fn read(&self) -> Result<Selected, Error> {
        let (vehicle, design) = (&self.vehicle, &self.design);
        let read = match &self.axis {
            Some(_) => vec![Inputs::read_axis(vehicle, design, self.axis.as_deref())?],
            None => Inputs::read_axes(vehicle, design)?,
        };
        let read = read.into_iter().map(|one| with_bandwidth(one, self.bandwidth));
        let read: Vec<Inputs> = read.collect::<Result<_, _>>()?;
        let all = self.out.clone().unwrap_or_else(|| store::default_directory(&read[0]));
        let of = |inputs: Inputs| {
            let directory = store::axis_directory(&all, &inputs);
            (inputs, directory)
        };
        let axes: Vec<(Inputs, PathBuf)> = read.into_iter().map(of).collect();
        let directory = if let [(_, own)] = &axes[..] { own.clone() } else { all };
        Ok(Selected { axes, directory })
    }

    /// Returns the command that writes the report of this design.
    pub fn report(&self) -> String {
        let out = self.out.iter().map(|out| format!(" --out {}", shell_path(out)));
        out.fold(self.report_of(&shell_path(&self.vehicle)), |command, out| command + &out)
    }

    /// Returns the command for a vehicle in the given directory, with output to the default directory.
    pub fn report_of(&self, vehicle: &str) -> String {
        let design = (self.design != DEFAULT_DESIGN).then(|| format!(" --design {}", self.design));
        let axis = self.axis.as_ref().map(|axis| format!(" --axis {axis}"));
        let bandwidth = self.bandwidth.map(|bandwidth| format!(" --bandwidth {bandwidth}"));
        [Some(format!("squid report {vehicle}")), design, axis, bandwidth].into_iter().flatten().collect()
    }

    /// Reads the files as [`Which::read`] does, for a verb that writes; refuses directories that are not writable.
    ///
    /// # Errors
    /// Errors of [`Which::read`], and those of a directory that is not writable.
    pub fn read_to_write(&self) -> Result<Selected, Error> {
        let selected = self.read()?;
        let all = selected.axes.iter().map(|(_, directory)| directory).chain([&selected.directory]);
        all.into_iter().try_for_each(|directory| check_directory(directory))?;
        Ok(selected)
    }
}

/// Returns a path as typed in a shell.
fn shell_path(path: &Path) -> String {
    let path = path.display().to_string();
    if path.contains(char::is_whitespace) { format!("'{path}'") } else { path }
}

/// Replaces the bandwidth of the inputs if one is given.
fn with_bandwidth(read: Inputs, bandwidth: Option<f64>) -> Result<Inputs, Error> {
    bandwidth.map_or(Ok(read.clone()), |bandwidth| read.with_bandwidth(bandwidth)).map_err(|reason| {
        match reason {
            InputError::Bandwidth { found } => {
                let (found, allowed) = (squid_auv::number(found), BANDWIDTH.text.into());
                Error::Argument { name: "--bandwidth", found, allowed }
            }
            reason => reason.into(),
        }
    })
}

/// Reads a vehicle from a file.
///
/// # Errors
/// Errors of the file.
pub fn read_vehicle(path: &Path) -> Result<Vehicle, Error> {
    Ok(Vehicle::parse(&read(path)?, &path.display().to_string())?)
}

/// Reads a sea file and checks it for a vehicle; returns the sea and the text of the file.
///
/// # Errors
/// Errors of the file; waves for a vehicle of unknown dimensions.
pub fn read_sea(path: &Path, inputs: &Inputs) -> Result<(Sea, String), Error> {
    let text = read(path)?;
    let sea = Sea::parse(&text, &path.display().to_string())?;
    sea.check(&inputs.vehicle)?;
    Ok((sea, text))
}
