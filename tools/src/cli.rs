//! The command line: verbs and options, with their help.

use crate::error::Error;
use crate::verbs::lpv::LpvVerb;
use crate::verbs::new::Like;
use auv::Vehicle;
use base::files::{check_directory, read};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use squid_campaign::starts::Starts;
use squid_design::error::InputError;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::{BANDWIDTH, RATE};
use squid_design::store;
use squid_flight::sea::Sea;
use squid_package::kind::Interfaces;
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

/// The design that is meant where none is named.
pub const DEFAULT_DESIGN: &str = "design";

/// The end of `--help`, each example on a separate line.
const FIRST_RUN: &str = "\
A first run:
  squid show vehicles/squid --speed 1
  squid design vehicles/squid
  squid simulate vehicles/squid
  squid package vehicles/squid
  squid export vehicles/squid

Exit codes: 0 for success, 1 when a file is wrong, a stage fails or nothing is proved, 5 when a requirement is \
missed and `squid design --strict` or `squid tune` asks for it, 64 when the command line is wrong; `squid lpv synth` \
has more.";

#[allow(missing_docs)] // Doc comments here are the help.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Design a controller: trim, linearise, fit, LFT, augment, synthesise, check, freeze
    ///
    /// Prints each stage with its key figure and writes controller.json, plant.json, manoeuvre.json and design.json.
    /// A controller that fails a check is not written. One whose gain bound is not proved is written for inspection,
    /// and the exit code is 1. The verdict at the end is on what `[require]` of the design file asks; for each
    /// requirement that is missed it names the key of the weights to turn, and the direction.
    Design {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Design,
    },
    /// Search the weights for the fastest design that meets what `[require]` asks, and write it as a design file
    ///
    /// Turns frequencies and bandwidths of `[[track]]`, noise of `[[measure]]`, weight and disturbance of
    /// `[control]`, and lowers `follow` once where nothing meets what is required; all else stays as it is written,
    /// comments too. A design of a name that is not there is begun from
    /// the vehicle alone, with the range of speed that suits it. The same files give the same design on any machine,
    /// however busy it is. Exit code 5 where what it found misses a requirement; the file is written all the same.
    Tune {
        /// The vehicle's directory
        vehicle: PathBuf,
        /// The design to begin with: NAME.toml in the vehicle's directory, begun if it is not there
        #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
        design: String,
        /// The design to write: NAME.toml in the vehicle's directory; by default `tuned`, or the one that was begun
        #[arg(long, value_name = "NAME", value_parser = design_name)]
        to: Option<String>,
        /// Search with at most this many designs; the search ends sooner where a round of it gains less than 1 %
        #[arg(long, value_name = "COUNT", default_value_t = 100)]
        designs: usize,
    },
    /// Pack the three FMUs of a design: the vehicle, the autopilot, and both in one loop; and an SSP that connects the
    /// first two
    ///
    /// Reads the output of `squid design`. Refuses it when a file has changed since, and when the proof of the gain
    /// bound fails.
    Package {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Packing,
    },
    /// Write the controller of a design as source for the computer of a vehicle
    ///
    /// Reads the output of `squid design`. Writes NAME.h and NAME.c, C99 that needs no library but that of
    /// mathematics (-lm), and that only where a thruster has `T_nn` or heave is measured; the header says so. Beside
    /// them is what `squid verify --c` reads: controller.json and certificate.json. Refuses what `squid package`
    /// refuses.
    Export {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Export,
    },
    /// Fly a design in this process: its manoeuvre, steps over the range of speed, the vehicle alone
    ///
    /// Designs first if there is no design yet. Writes records (CSV) and plots (SVG).
    Simulate {
        #[command(flatten)]
        which: Which,
        /// Fly the manoeuvre in the waves and the current of this file, with its sensors, and beside it in still water;
        /// vehicles/sea.toml explains each key
        #[arg(long, value_name = "FILE")]
        sea: Option<PathBuf>,
    },
    /// Fly a design many times: vehicles all over the declared uncertainty, speeds, steps up and down, a sea drawn anew
    ///
    /// Each flight has the default manoeuvre, between two speeds drawn from its range. Results are Parquet files, a row
    /// a flight, which pandas and polars read as one, and campaign.html; what is missing is flown when the command is
    /// run again. A flight depends on its number and the seed alone: neither cores nor interruptions change a bit.
    /// Designs first if there is no design yet. A campaign proves nothing. `python -m squid_campaign` flies it on many
    /// machines.
    Campaign {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Campaign,
    },
    /// Fly one flight of a campaign again, and plot it
    ///
    /// Writes flight-N.csv and flight-N.svg beside the results, and says whether the figures are those in the results
    /// to the bit.
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
        /// Add the sections of the paper that squid began with (Sutarto and Budiyono, 2011), and its claims: by what
        /// criterion each is judged, and whether this vehicle confirms it
        #[arg(long)]
        paper: bool,
        /// Add flights in the waves and the current of this file, with its sensors; see vehicles/sea.toml
        #[arg(long, value_name = "FILE")]
        sea: Option<PathBuf>,
    },
    /// Show the trim, A, B and eigenvalues at a speed; the fit and its residuals; the controller's poles
    ///
    /// `--speed` alone needs no design file: where design.toml is not there or does not fit the vehicle, the trim is
    /// that at the depth at which the buoyancy is given.
    Show {
        #[command(flatten)]
        which: Which,
        #[command(flatten)]
        asked: Show,
    },
    /// Prove the gain bound of an FMU, of a source in C, or of a certificate.json, in exact arithmetic
    ///
    /// Every number is read as the rational number that it is; nothing is rounded, and no code is shared with the
    /// synthesis. For an FMU it also checks that the proof is of the controller inside, and that its resources belong
    /// to its GUID. With --vehicle it computes again that the proof is about that vehicle, and that scales, trims and
    /// limits are those of its files: all that is required before an FMU is packed.
    Verify(Verify),
    /// LPV synthesis for any plant in a JSON file, with no vehicle
    #[command(subcommand)]
    Lpv(LpvVerb),
    /// Write a commented vehicle to start from: DIRECTORY/vehicle.toml and design.toml
    New {
        /// The directory, which must not be there; its name is that of the vehicle
        directory: PathBuf,
        /// The vehicle to start from
        #[arg(long, value_enum, default_value = "squid")]
        like: Like,
    },
    /// Check that this machine has what squid needs, and say how to get the rest
    ///
    /// Exit code 1 where something is missing without which no FMU can be made.
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
    /// settling_time (null: never settled) and steady_error, pitch_error, speed_error, actuator_use, surface; and
    /// depth_steps and depth_error of a flight with a reference of the depth.
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
    /// Verify a C source written by `squid export` instead of FILE, with the other files beside it: every number
    /// must follow from the controller of the certificate
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub c: Option<PathBuf>,
    /// The vehicle's directory, to check that the file is of this vehicle's design
    #[arg(long, value_name = "DIR")]
    pub vehicle: Option<PathBuf>,
    /// The design: a file NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, requires = "vehicle")]
    #[arg(value_parser = design_name)]
    pub design: String,
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
    /// How many flights
    #[arg(long, value_name = "COUNT", default_value_t = 1000)]
    pub flights: u64,
    /// Fly in the waves and the current of this file, with its sensors; see vehicles/sea.toml
    #[arg(long, value_name = "FILE")]
    pub sea: Option<PathBuf>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How vehicles are sampled from the declared uncertainty
    #[arg(long, value_enum, default_value_t = Where::Uniform)]
    pub points: Where,
    /// Begin each flight off the trim of its vehicle, by up to so much, such as pitch=10deg,heave=0.1m/s; of pitch,
    /// speed, depth, pitch_rate and heave. Without it flights begin in trim
    #[arg(long, value_name = "LIST")]
    pub starts: Option<Starts>,
    /// The directory of the results; by default `campaign` in that of the design
    #[arg(long, value_name = "DIR")]
    pub to: Option<PathBuf>,
    /// Write what happened in each flight, not in the ten worst alone: trajectories/flight-N.parquet
    #[arg(long)]
    pub trajectories: bool,
    /// Leave out the gain that is guaranteed for the uncertain model, beside those of the first hundred vehicles; it
    /// takes some seconds
    #[arg(long)]
    pub no_bound: bool,
    /// Fly these flights alone, however many are asked for, and write no page: a part of a campaign
    #[arg(long, value_name = "FIRST-LAST", value_parser = neighbours)]
    pub only: Option<RangeInclusive<u64>>,
    /// Fly nothing, and say which flights are missing; with --only and --json also what is drawn for them
    #[arg(long)]
    pub dry_run: bool,
    /// Fly nothing, and judge what the FMUs of the design flew with what is drawn: DIR/flight-N.csv
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

/// More flights than anybody flies; their numbers fit into eight digits.
pub const MOST_FLIGHTS: u64 = 100_000_000;

/// Where in the declared uncertainty the vehicles of a campaign are.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Where {
    /// All over it, at random
    Uniform,
    /// All over it, more evenly: on a scrambled Sobol sequence, from which speeds and steps are drawn, too
    Sobol,
    /// At its corners alone
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
    /// The interface of FMI that the FMUs offer; some tools take only FMUs with one
    #[arg(long, value_enum, default_value = "both")]
    pub kind: FmuKind,
    /// Where the FMUs' shared libraries are, if not where cargo puts them; those of named platforms in folders of
    /// that name
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

/// The interfaces of FMI that an FMU offers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FmuKind {
    /// Co-simulation alone: the FMU steps itself
    Cs,
    /// Model exchange alone: the importer integrates; of plant and loop, because the controller is sampled
    Me,
    /// Both; of the controller co-simulation
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
#[derive(Debug, Args)]
pub struct Which {
    /// The vehicle's directory, for instance vehicles/squid
    pub vehicle: PathBuf,
    /// The design: a file NAME.toml in the vehicle's directory
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DESIGN, value_parser = design_name)]
    pub design: String,
    /// Replace the bandwidth w_b of every tracking weight, rad/s; with `--design paper` of Squid, 0.46, 0.23 and 0.1
    /// are those of the paper
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    pub bandwidth: Option<f64>,
    /// The directory for all files; by default build/VEHICLE/DESIGN
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
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

impl Which {
    /// The directory for all files.
    pub fn directory(&self, inputs: &Inputs) -> PathBuf {
        self.out.clone().unwrap_or_else(|| store::default_directory(inputs))
    }

    /// The vehicle and design files, and the directory of the design.
    ///
    /// # Errors
    /// [`Error::Argument`], those of the files.
    pub fn read(&self) -> Result<(Inputs, PathBuf), Error> {
        let inputs = inputs(&self.vehicle, &self.design, self.bandwidth)?;
        let directory = self.directory(&inputs);
        Ok((inputs, directory))
    }

    /// The command that writes the report of this design.
    pub fn report(&self) -> String {
        let out = self.out.iter().map(|out| format!(" --out {}", shown(out)));
        out.fold(self.report_of(&shown(&self.vehicle)), |command, out| command + &out)
    }

    /// The same for a vehicle in this directory, into the default directory.
    pub fn report_of(&self, vehicle: &str) -> String {
        let design = (self.design != DEFAULT_DESIGN).then(|| format!(" --design {}", self.design));
        let bandwidth = self.bandwidth.map(|bandwidth| format!(" --bandwidth {bandwidth}"));
        [Some(format!("squid report {vehicle}")), design, bandwidth].into_iter().flatten().collect()
    }

    /// As [`Which::read`], for a verb that writes to the directory; refuses at once a directory that cannot be written
    /// to.
    ///
    /// # Errors
    /// As [`Which::read`], and that of the directory.
    pub fn read_to_write(&self) -> Result<(Inputs, PathBuf), Error> {
        let (inputs, directory) = self.read()?;
        check_directory(&directory)?;
        Ok((inputs, directory))
    }
}

/// A path as it is typed.
fn shown(path: &Path) -> String {
    let path = path.display().to_string();
    if path.contains(char::is_whitespace) { format!("'{path}'") } else { path }
}

/// The files of a design.
///
/// # Errors
/// [`Error::Argument`] of `--bandwidth`, those of the files.
pub fn inputs(vehicle: &Path, design: &str, bandwidth: Option<f64>) -> Result<Inputs, Error> {
    let read = Inputs::read(vehicle, design)?;
    bandwidth.map_or(Ok(read.clone()), |bandwidth| read.with_bandwidth(bandwidth)).map_err(|reason| {
        match reason {
            InputError::Bandwidth { found } => {
                let (found, allowed) = (auv::number(found), BANDWIDTH.words.into());
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

/// The sea of a file in which a vehicle can be flown, and the text of the file.
///
/// # Errors
/// That of the file; waves, and a vehicle without size.
pub fn read_sea(path: &Path, inputs: &Inputs) -> Result<(Sea, String), Error> {
    let text = read(path)?;
    let sea = Sea::parse(&text, &path.display().to_string())?;
    sea.check(&inputs.vehicle)?;
    Ok((sea, text))
}
