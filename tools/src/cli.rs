//! The command line: verbs and options, with their help.

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

/// From the coefficients of an underwater vehicle to a scheduled controller of pitch or depth and to FMUs for any
/// simulation tool.
///
/// A vehicle is a directory with vehicle.toml (its coefficients) and design.toml (the requirements on the controller).
#[derive(Debug, Parser)]
#[command(name = "squid", version, after_long_help = FIRST_RUN)]
pub struct Cli {
    #[command(subcommand)]
    /// What to do.
    pub verb: Verb,
    /// Print one JSON object and nothing else, also when a file is wrong
    #[arg(long, global = true)]
    pub json: bool,
}

/// The end of `--help`, each example on a separate line.
const FIRST_RUN: &str = "\
A first run:
  squid show vehicles/squid --speed 1
  squid design vehicles/squid
  squid simulate vehicles/squid
  squid package vehicles/squid
  squid export vehicles/squid

Exit codes: 0 for success, 1 when a file is wrong, a stage fails or nothing is proved, 5 when a requirement is \
missed and `squid design --strict`, `squid prove --strict` or `squid tune` asks for it, 64 when the command line is \
wrong; `squid lpv synth` has more.";

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Design a controller: trim, linearise, fit, LFT, augment, synthesise, check, freeze
    ///
    /// Prints each stage with its key figure and writes controller.json, plant.json, manoeuvre.json and design.json. A
    /// controller that fails a check is not written. One whose gain bound is not proved is written for inspection, and
    /// the exit code is 1. The verdict at the end compares it with `[require]` of the design file; for each missed
    /// requirement it names the weight to change, and the direction.
    Design {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Design,
    },
    /// Prove a given controller of an axis, a PID with gains over speed, on the weights of a design
    ///
    /// Prints the growth and the gain of the frozen loops, the gain that is proved for any trajectory of the speed, the
    /// sampled gain, margins, mu, noise, flights of the declared uncertainty, what a controller of full order reaches
    /// on the same weights, and the verdict of `[require]`. Writes nothing: with the same `[controller]` in a design
    /// file `squid design` does, and FMUs and C follow. docs/pid.md explains the file. Refused are a loop that is
    /// unstable at a constant speed, gains in other units, of the wrong sign or on what is not measured, an integrator
    /// without gain, and a design of heading.
    Prove(Prove),
    /// Gains of pitch, depth and speed in the file of an autopilot, DUNE, ArduSub, mvp or MSS, as `[controller]`, and
    /// back; not those of heading
    #[command(subcommand)]
    Gains(GainsVerb),
    /// Search the weights for a fast, quiet design that meets what `[require]` asks, and write it as a design file
    ///
    /// Short rise times count most, then little noise on the commands and a large delay margin. Changes frequencies and
    /// bandwidths of `[[track]]`, noise of `[[measure]]`, weight and disturbance of `[control]`, and lowers `follow`
    /// once if no design meets the requirements; everything else in the file stays, comments too. A design file that
    /// does not exist is created from the vehicle, with a suitable range of speed. The same files give the same design
    /// on any machine. Exit code 5 if the best design misses a requirement; the file is written nevertheless.
    Tune {
        /// The vehicle's directory
        vehicle: PathBuf,
        /// The initial design: NAME.toml in the vehicle's directory, created if it does not exist
        #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
        design: String,
        /// The axis of a design file with several, by what it steers; by default each in turn
        #[arg(long, value_name = "NAME")]
        axis: Option<String>,
        /// What a design file that is created tracks alone: pitch and speed, or heading, at the speeds of design.toml
        /// if there is one. By default all that the vehicle can steer, each as an axis. None is created that tracks
        /// depth: write `[[track]]` of depth into one of pitch, see docs/guide.md
        #[arg(long, value_enum, value_name = "OUTPUT", conflicts_with = "controller")]
        track: Option<Track>,
        /// The design to write: NAME.toml in the vehicle's directory; by default `tuned`, or the created one
        #[arg(long, value_name = "NAME", value_parser = design_name)]
        to: Option<String>,
        /// The largest number of designs; the search ends earlier if a round gains less than 1 %
        #[arg(long, value_name = "COUNT", default_value_t = 100, conflicts_with = "controller")]
        designs: usize,
        /// Tune the gains of a PID for the weights of the design instead, and write the design with `[controller]`
        ///
        /// The gains are those of smallest gain of the loop at frozen speeds, and from there of smallest proved gain
        /// for any trajectory of the speed: `[require]` does not steer them, but the verdict follows. A `[controller]`
        /// in the design file gives form and first gains; docs/pid.md explains it. The search is local: another start
        /// may end in other gains.
        #[arg(long, value_enum, value_name = "KIND")]
        controller: Option<TunedController>,
        /// The gains of the PID as polynomials of this degree in the speed: 0 or 1
        #[arg(long, value_name = "DEGREE", default_value_t = 0, requires = "controller",
            value_parser = clap::value_parser!(u8).range(0..=1))]
        degree: u8,
    },
    /// Pack the three FMUs of a design: the vehicle, the autopilot, and both in one loop; and an SSP that connects the
    /// first two
    ///
    /// Reads the output of `squid design`. Refuses it when a file has changed since, and when the proof of the gain
    /// bound fails. Of a design with several axes each is proved, and with one of heading the vehicle is that in six
    /// degrees of freedom.
    Package {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Packing,
    },
    /// Write the controller of a design as source for the computer of a vehicle
    ///
    /// Reads the output of `squid design`. Writes NAME.h and NAME.c, of several axes beside a folder with those of
    /// each: C99 that needs only the mathematical library (-lm), and that only if a thruster has `T_nn` or heave is
    /// measured; the header says so. Writes controller.json and certificate.json, too, for `squid verify --c`. Refuses
    /// what `squid package` refuses.
    Export {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Export,
    },
    /// Simulate a design: its manoeuvre, steps over the range of speed, the open-loop vehicle
    ///
    /// Designs first if there is no design yet. Writes records (CSV) and plots (SVG). A design with an axis of heading
    /// beside one of pitch or depth also flies in six degrees of freedom: turns at six speeds, while pitch or depth
    /// step.
    Simulate {
        #[command(flatten)]
        which: Which,
        /// Simulate the manoeuvre in the waves, the current and with the sensor errors of this file, and in still
        /// water for comparison; of several axes, the turns in it; vehicles/sea.toml explains each key
        #[arg(long, value_name = "FILE")]
        sea: Option<PathBuf>,
        /// The turn, deg, to starboard; by default 60
        #[arg(long, value_name = "DEG", allow_negative_numbers = true, conflicts_with = "axis")]
        turn: Option<f64>,
        /// The steady current of the turns, m/s: north, the way the vehicle faces at the start, and east; added to
        /// that of --sea
        #[arg(long, value_name = "NORTH,EAST", value_parser = pair, allow_hyphen_values = true,
            conflicts_with = "axis")]
        current: Option<[f64; 2]>,
    },
    /// Simulate a design many times: random vehicles of the declared uncertainty, speeds, steps up and down, seas
    ///
    /// Each flight is the default manoeuvre, between two random speeds of its range. Results are Parquet files with
    /// one row per flight, which pandas and polars read as one table, and campaign.html; if the command is repeated,
    /// only missing flights are simulated. A flight depends only on its number and the seed: neither the number of
    /// cores nor interruptions change a bit. Designs first if there is no design yet. A campaign proves nothing.
    /// `python -m squid_campaign` runs it on many machines.
    Campaign {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Campaign,
    },
    /// Simulate one flight of a campaign again, and plot it
    ///
    /// Writes flight-N.csv and flight-N.svg next to the results, and prints whether the figures equal those in the
    /// results to the bit.
    Replay {
        /// The directory of the results
        results: PathBuf,
        /// The number of the flight
        #[arg(long, value_name = "NUMBER")]
        flight: u64,
    },
    /// Write the report: steps, margins, loops, mu and more of this design
    ///
    /// One page, report.html, that needs no network, and each figure as figures/NAME.svg. Designs first if there is no
    /// design yet.
    Report {
        #[command(flatten)]
        which: Which,
        /// Add sections on the paper by Sutarto and Budiyono (2011) and on its claims: the criterion for each, and
        /// whether this vehicle confirms it
        #[arg(long)]
        paper: bool,
        /// Add simulations in the waves, the current and with the sensor errors of this file; see vehicles/sea.toml
        #[arg(long, value_name = "FILE")]
        sea: Option<PathBuf>,
        /// Add a table with another design of the vehicle beside this one, NAME.toml in its directory: sizes, what is
        /// proved, flights, verdict. Several with one --beside each. Designs it first if it is not designed yet
        #[arg(long, value_name = "NAME", value_parser = design_name)]
        beside: Vec<String>,
    },
    /// Show the trim, A, B and eigenvalues at a speed; the fit and its residuals; the controller's poles
    ///
    /// `--speed` alone needs no design file: if design.toml does not exist or does not fit the vehicle, the trim is at
    /// the depth for which the buoyancy is given.
    Show {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Show,
    },
    /// Prove the gain bound of an FMU, of a source in C, or of a certificate.json, in exact arithmetic
    ///
    /// Every number is read as an exact rational number; nothing is rounded, and no code is shared with the synthesis.
    /// For an FMU it also checks that the proof is about the controller in it, and that its resources belong to its
    /// GUID; of one with two axes it proves both. With --vehicle it computes again that plant, scales, trims and limits
    /// are those of the vehicle's files: all that is required before an FMU is packed. Without it, claims are in the
    /// certificate's own units. Binaries are compared with those that this squid packs, and with --vehicle the page, if
    /// the design is stored beside the FMU; what is not identical is named, and not examined.
    Verify(Verify),
    /// LPV synthesis for any plant in a JSON file, with no vehicle
    #[command(subcommand)]
    Lpv(LpvVerb),
    /// Write a commented vehicle to start from: DIRECTORY/vehicle.toml and design.toml
    New {
        /// The new directory, which must not exist; its name is that of the vehicle
        directory: PathBuf,
        /// The vehicle to start from
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
        /// The shell
        shell: Shell,
    },
    /// Write manual pages, one for each verb
    Man {
        /// The directory for squid.1 and the others
        directory: PathBuf,
    },
    /// Plot the record of a flight, a CSV file such as `fmpy simulate squid.fmu --output-file` writes
    ///
    /// --json prints the figures of the flight, in s, rad, m/s and fractions: pitch_steps with overshoot, rise_time,
    /// settling_time (null: never settled) and steady_error, pitch_error, speed_error, actuator_use, surface; and the
    /// same of depth and heading, of a flight with a reference of them. A reference of these that is limited in rate
    /// counts as a step to where it ends.
    Plot {
        /// The record: a column `time`, then one for each variable
        record: PathBuf,
        /// The vehicle's directory; its actuators are plotted, too
        #[arg(long, value_name = "DIR")]
        vehicle: Option<PathBuf>,
        /// The SVG file to write; by default beside the record
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Default, Args)]
pub struct Design {
    /// Also show gamma under each assumption about the speed: frozen, slow, arbitrarily fast
    #[arg(long)]
    pub ladder: bool,
    /// Look for a controller that tolerates more of the declared uncertainty, and compare the two (a minute; tens
    /// of minutes where it misses a requirement and --no-advise is not given)
    #[arg(long)]
    pub robust: bool,
    /// Also prove a gain for every constant value of the declared uncertain coefficients, for a speed that changes in
    /// any way, or with `--constant=0.1` by at most 0.1 m/s^2 (half a minute to minutes)
    #[arg(long, value_name = "M/S^2", num_args = 0..=1, require_equals = true, value_parser = rate)]
    pub constant: Option<Option<f64>>,
    /// Do not search for the key to change when a requirement is missed; the search takes a design per key
    #[arg(long)]
    pub no_advise: bool,
    /// Exit with code 5 if a requirement is missed
    #[arg(long)]
    pub strict: bool,
}

/// What a design file tracks that `squid tune` creates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Track {
    /// Pitch and speed, by surge, heave and pitch
    Pitch,
    /// Heading, by sway and yaw
    Heading,
}

/// What `squid tune` tunes instead of weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TunedController {
    /// The gains of a PID
    Pid,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Prove {
    /// The vehicle's directory, for instance vehicles/remus100
    pub vehicle: PathBuf,
    /// The design whose range of speed, weights and measurements are used: NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
    pub design: String,
    /// The axis of a design file with several, by what it steers
    #[arg(long, value_name = "NAME")]
    pub axis: Option<String>,
    /// A file with `[controller]` alone; by default that of the design file
    #[arg(long, value_name = "FILE")]
    pub controller: Option<PathBuf>,
    /// Exit with code 5 if a requirement is missed
    #[arg(long)]
    pub strict: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Export {
    /// The language
    #[arg(long, value_enum, default_value = "c")]
    pub language: Language,
    /// The type of all numbers
    #[arg(long, value_enum, default_value = "double")]
    pub real: Real,
    /// The directory for the source; by default `c` in that of the design
    #[arg(long, value_name = "DIR")]
    pub to: Option<PathBuf>,
    /// Write a controller without proof; the source then says that it is uncertified
    #[arg(long)]
    pub allow_uncertified: bool,
    /// Print also what is proved as a mathematical statement, as in the file
    #[arg(long)]
    pub verbose: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Verify {
    /// A controller's FMU, the FMU of the whole loop, or a certificate
    #[arg(required_unless_present = "c")]
    pub file: Option<PathBuf>,
    /// Verify a C source written by `squid export` instead of FILE, with the other files in its directory: every
    /// number must follow from the controller of the certificate
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub c: Option<PathBuf>,
    /// The vehicle's directory, to check that the file is of this vehicle's design
    #[arg(long, value_name = "DIR")]
    pub vehicle: Option<PathBuf>,
    /// The design: a file NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, requires = "vehicle")]
    #[arg(value_parser = design_name)]
    pub design: String,
    /// The axis that the file is of, if it is of one of several: by what it steers
    #[arg(long, value_name = "NAME", requires = "vehicle")]
    pub axis: Option<String>,
    /// The bandwidth that replaced w_b of every tracking weight, rad/s
    #[arg(long, value_name = "RAD/S", requires = "vehicle", allow_negative_numbers = true)]
    pub bandwidth: Option<f64>,
    /// Print also what is proved as a mathematical statement, as in the file
    #[arg(long)]
    pub verbose: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Show {
    /// Trim, A, B and eigenvalues at this speed along the path, m/s
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// The polynomial fit and its residuals
    #[arg(long)]
    pub fit: bool,
    /// The controller and its poles: the stored one, or a new design if the default directory has none
    #[arg(long)]
    pub controller: bool,
    /// The uncertain parameters, their channels in the LFT, and the model's errors
    #[arg(long)]
    pub uncertainty: bool,
}

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Args)]
pub struct Campaign {
    /// The number of flights
    #[arg(long, value_name = "COUNT", default_value_t = 1000)]
    pub flights: u64,
    /// Simulate in the waves, the current and with the sensor errors of this file; see vehicles/sea.toml
    #[arg(long, value_name = "FILE")]
    pub sea: Option<PathBuf>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How vehicles are sampled from the declared uncertainty
    #[arg(long, value_enum, default_value_t = Where::Uniform)]
    pub points: Where,
    /// The largest initial deviations from trim, such as pitch=10deg,heave=0.1m/s; of pitch, speed, depth, pitch_rate
    /// and heave. By default flights start in trim
    #[arg(long, value_name = "LIST")]
    pub starts: Option<Starts>,
    /// The directory of the results; by default `campaign` in that of the design
    #[arg(long, value_name = "DIR")]
    pub to: Option<PathBuf>,
    /// Write the trajectory of each flight, not only of the ten worst: trajectories/flight-N.parquet
    #[arg(long)]
    pub trajectories: bool,
    /// Do not compute the guaranteed gain of the uncertain model and the gains of the first hundred vehicles, which
    /// takes some seconds
    #[arg(long)]
    pub no_bound: bool,
    /// Simulate only these flights, whatever their number is, and write no page: a part of a campaign
    #[arg(long, value_name = "FIRST-LAST", value_parser = neighbours)]
    pub only: Option<RangeInclusive<u64>>,
    /// Simulate nothing, and print which flights are missing; with --only and --json also their random numbers
    #[arg(long)]
    pub dry_run: bool,
    /// Simulate nothing, and evaluate the records of the design's FMUs with these random numbers: DIR/flight-N.csv
    #[arg(long, value_name = "DIR")]
    pub records: Option<PathBuf>,
}

/// A bound on the rate of the speed, m/s^2.
fn rate(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|rate| RATE.allows(*rate)).ok_or_else(|| format!("a number {}", RATE.words))
}

/// Numbers of flights, the first and the last.
fn neighbours(text: &str) -> Result<RangeInclusive<u64>, String> {
    let ends = text.split_once('-').and_then(|(first, last)| Some((first.parse().ok()?, last.parse().ok()?)));
    let flights = ends.filter(|(first, last): &(u64, u64)| first <= last && *last < MOST_FLIGHTS);
    flights.map(|(first, last)| first..=last).ok_or_else(|| "two numbers of flights, as in 64-127".into())
}

/// The largest number of flights; the numbers have at most eight digits.
pub const MOST_FLIGHTS: u64 = 100_000_000;

/// The distribution of the vehicles of a campaign over the declared uncertainty.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Where {
    /// Uniform
    Uniform,
    /// A scrambled Sobol sequence, which also gives speeds and steps
    Sobol,
    /// Random corners
    Corners,
}

/// A language in which a controller can be written.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Language {
    /// C99: a header and a source
    C,
}

/// The options of `squid package`.
#[derive(Debug, Args)]
pub struct Packing {
    /// Platforms of the FMUs: host, all, or some of linux64, win64, aarch64-linux, darwin64, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "host")]
    pub platforms: Vec<String>,
    /// The interfaces of FMI in the FMUs; some tools accept only FMUs with one
    #[arg(long, value_enum, default_value = "both")]
    pub kind: FmuKind,
    /// The directory of the FMUs' shared libraries, if not that of cargo; those of named platforms are in
    /// subdirectories of that name
    #[arg(long, value_name = "DIR")]
    pub binaries: Option<PathBuf>,
    /// Pack a controller without proof; its FMUs then say that they are uncertified
    #[arg(long)]
    pub allow_uncertified: bool,
    /// Write only the three model descriptions, to this directory
    #[arg(long, value_name = "DIR")]
    pub descriptions: Option<PathBuf>,
    /// Print also what is proved as a mathematical statement, as in the file
    #[arg(long)]
    pub verbose: bool,
}

/// The interfaces of FMI in an FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FmuKind {
    /// Co-simulation only: the FMU steps itself
    Cs,
    /// Model exchange only, of plant and loop: the importer integrates; the controller is sampled
    Me,
    /// Both; of the controller co-simulation only
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

/// The type of the numbers of a controller in C.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Real {
    /// 64 bits: the results are those of the controller's FMU to the last bit
    Double,
    /// 32 bits, for processors that have no others
    Float,
}

#[allow(missing_docs)] // A doc comment here would take the place of the verbs' own help.
#[derive(Debug, Clone, Args)]
pub struct Which {
    /// The vehicle's directory, for instance vehicles/squid
    pub vehicle: PathBuf,
    /// The design: a file NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
    pub design: String,
    /// One axis of a design file with several, by what it steers: pitch, depth or heading; by default all of them
    #[arg(long, value_name = "NAME")]
    pub axis: Option<String>,
    /// Replace the bandwidth w_b of every tracking weight, rad/s; with `--design paper` of Squid, 0.46, 0.23 and 0.1
    /// are those of the paper
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    pub bandwidth: Option<f64>,
    /// The directory for all files; by default build/VEHICLE/DESIGN
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Two numbers with a comma between.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let both = text.split_once(',').and_then(|(one, other)| Some([number(one)?, number(other)?]));
    both.ok_or_else(|| "it must be two numbers with a comma between, such as 0.4,-0.1".to_owned())
}

/// The name of a design: that of a file NAME.toml in the vehicle's directory.
fn design_name(text: &str) -> Result<String, String> {
    let allowed = "it must be the name of a file beside vehicle.toml, without '.toml'";
    match text {
        "vehicle" => Err(format!("vehicle.toml is the vehicle itself; {allowed}")),
        "" | "." | ".." => Err(allowed.to_owned()),
        _ if text.contains(['/', '\\']) || text.ends_with(".toml") => Err(allowed.to_owned()),
        _ => Ok(text.to_owned()),
    }
}

/// The axes of a vehicle's autopilot that a command line asks for.
#[derive(Debug)]
pub struct Asked {
    /// The files of each axis, and the directory of its design.
    pub axes: Vec<(Inputs, PathBuf)>,
    /// The directory of what is of all of them; of one axis, that of its design.
    pub directory: PathBuf,
}

impl Which {
    /// Reads the vehicle and design files.
    ///
    /// # Errors
    /// [`Error::Argument`], those of the files.
    pub fn read(&self) -> Result<Asked, Error> {
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
        Ok(Asked { axes, directory })
    }

    /// The command that writes the report of this design.
    pub fn report(&self) -> String {
        let out = self.out.iter().map(|out| format!(" --out {}", shown(out)));
        out.fold(self.report_of(&shown(&self.vehicle)), |command, out| command + &out)
    }

    /// The same for a vehicle in this directory, into the default directory.
    pub fn report_of(&self, vehicle: &str) -> String {
        let design = (self.design != DEFAULT_DESIGN).then(|| format!(" --design {}", self.design));
        let axis = self.axis.as_ref().map(|axis| format!(" --axis {axis}"));
        let bandwidth = self.bandwidth.map(|bandwidth| format!(" --bandwidth {bandwidth}"));
        [Some(format!("squid report {vehicle}")), design, axis, bandwidth].into_iter().flatten().collect()
    }

    /// As [`Which::read`], for a verb that writes to the directories; refuses at once one that cannot be written to.
    ///
    /// # Errors
    /// As [`Which::read`], and that of a directory.
    pub fn read_to_write(&self) -> Result<Asked, Error> {
        let asked = self.read()?;
        let all = asked.axes.iter().map(|(_, directory)| directory).chain([&asked.directory]);
        all.into_iter().try_for_each(|directory| check_directory(directory))?;
        Ok(asked)
    }
}

/// A path as typed in a shell.
fn shown(path: &Path) -> String {
    let path = path.display().to_string();
    if path.contains(char::is_whitespace) { format!("'{path}'") } else { path }
}

/// The inputs with another bandwidth, if one is given.
fn with_bandwidth(read: Inputs, bandwidth: Option<f64>) -> Result<Inputs, Error> {
    bandwidth.map_or(Ok(read.clone()), |bandwidth| read.with_bandwidth(bandwidth)).map_err(|reason| {
        match reason {
            InputError::Bandwidth { found } => {
                let (found, allowed) = (squid_auv::number(found), BANDWIDTH.words.into());
                Error::Argument { name: "--bandwidth", found, allowed }
            }
            reason => reason.into(),
        }
    })
}

/// The vehicle of a file.
///
/// # Errors
/// Those of the file.
pub fn read_vehicle(path: &Path) -> Result<Vehicle, Error> {
    Ok(Vehicle::parse(&read(path)?, &path.display().to_string())?)
}

/// The sea of a file, checked for a vehicle, and the text of the file.
///
/// # Errors
/// That of the file; waves, and a vehicle without size.
pub fn read_sea(path: &Path, inputs: &Inputs) -> Result<(Sea, String), Error> {
    let text = read(path)?;
    let sea = Sea::parse(&text, &path.display().to_string())?;
    sea.check(&inputs.vehicle)?;
    Ok((sea, text))
}
