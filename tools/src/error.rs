//! What can stop the command, one variant a cause.

use thiserror::Error;

/// An error that ends the command with one message.
#[derive(Debug, Error)]
pub enum Error {
    /// The vehicle's directory is not there.
    #[error("{directory}: there is no such directory; name one that holds vehicle.toml and design.toml")]
    NoVehicle {
        /// As given.
        directory: String,
    },
    /// The vehicle file or the design file is wrong, or a file is no text.
    #[error(transparent)]
    File(#[from] auv::FileError),
    /// A bandwidth on the command line.
    #[error("--bandwidth is {}; it must be {}", auv::number(*found), crate::design_file::BANDWIDTH.words)]
    Bandwidth {
        /// As given.
        found: f64,
    },
    /// A file cannot be read.
    #[error("{path}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        path: String,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{path}: cannot be written: {reason}")]
    Unwritable {
        /// The file.
        path: String,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// The vehicle does not trim somewhere in the range.
    #[error("{reason}")]
    Trim {
        /// Where.
        speed: f64,
        /// Why.
        reason: auv::TrimError,
    },
    /// There is no uncertain model.
    #[error(transparent)]
    Uncertain(#[from] crate::uncertain::UncertainError),
    /// There is no robust controller.
    #[error(transparent)]
    Robust(#[from] crate::robust::RobustError),
    /// A coefficient is not allowed.
    #[error(transparent)]
    Coefficient(#[from] auv::CoefficientError),
    /// The polynomial fit failed.
    #[error(transparent)]
    Fit(#[from] lpv::error::FitError),
    /// An LFT has no value at some parameter.
    #[error(transparent)]
    Lft(#[from] lpv::error::LftError),
    /// The matrices of a problem file do not fit together.
    #[error(transparent)]
    Shape(#[from] lpv::error::ShapeError),
    /// Model and weights make no generalised plant.
    #[error(transparent)]
    Augment(#[from] lpv::error::AugmentError),
    /// No controller.
    #[error(transparent)]
    Synthesis(#[from] lpv::error::SynthesisError),
    /// No controller for a vehicle, with what about the problem may be the cause.
    #[error("{reason}{}", remarks.iter().map(|r| format!("\n  remark: {r}")).collect::<String>())]
    NoController {
        /// Why.
        reason: lpv::error::SynthesisError,
        /// Remarks on the problem.
        remarks: Vec<String>,
    },
    /// The finished controller failed a check.
    #[error("the controller is refused: {0}")]
    Refused(#[from] crate::check::Refusal),
    /// An actuator's name belongs to another variable of the FMUs.
    #[error(
        "{file}: an actuator cannot be called '{actuator}', because '{name}' is the name of another variable of the FMUs"
    )]
    ActuatorName {
        /// The vehicle file.
        file: String,
        /// The actuator.
        actuator: String,
        /// The name that is there twice.
        name: String,
    },
    /// A frozen controller makes no sense.
    #[error("{path}: {reason}")]
    BadController {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: scheduled::DesignError,
    },
    /// A frozen LPV model makes no sense.
    #[error("{path}: {reason}")]
    BadPlant {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: auv::LpvModelError,
    },
    /// A frozen file says something else than vehicle and design file.
    #[error(
        "{file}: `{key}` is {found}, but {expected} follows from vehicle and design file; `squid design` makes it anew"
    )]
    Edited {
        /// The file.
        file: &'static str,
        /// The first key that differs.
        key: String,
        /// Its value.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// The resources of an FMU are not those that it was packed with.
    #[error(
        "{path}: its resources were changed after it was packed, or another version of squid packed it (the GUID differs)"
    )]
    WrongGuid {
        /// The FMU.
        path: String,
    },
    /// The model description of an FMU is not the one that it was packed with.
    #[error("{path}: its modelDescription.xml was changed after it was packed")]
    WrongDescription {
        /// The FMU.
        path: String,
    },
    /// What was said of a file that does not name it.
    #[error("{path}: {reason}")]
    Of {
        /// The file.
        path: String,
        /// What was said.
        reason: Box<Error>,
    },
    /// An FMU is not what vehicle and design file make.
    #[error("{path}: it is not what these vehicle and design files make: {reason}")]
    NotOfInputs {
        /// The FMU.
        path: String,
        /// The first thing that differs.
        reason: String,
    },
    /// The plant's LPV model cannot be frozen or read.
    #[error(transparent)]
    LpvModel(#[from] auv::LpvModelError),
    /// A vehicle has no JSON.
    #[error(transparent)]
    VehicleJson(#[from] auv::VehicleJsonError),
    /// The frozen controller is wrong.
    #[error(transparent)]
    ControllerDesign(#[from] scheduled::DesignError),
    /// The autopilot could not compute a tick.
    #[error(transparent)]
    Tick(#[from] scheduled::TickError),
    /// The vehicle could not be simulated.
    #[error(transparent)]
    Simulation(#[from] auv::SimulationError),
    /// JSON could not be written.
    #[error("{path}: {reason}")]
    Json {
        /// The file.
        path: String,
        /// Why.
        reason: serde_json::Error,
    },
    /// A plot could not be drawn.
    #[error("{path}: the plot cannot be drawn: {reason}")]
    Plot {
        /// The file.
        path: String,
        /// Why.
        reason: String,
    },
    /// A number on the command line is outside what is allowed.
    #[error("{name} is {found}; it must be {allowed}")]
    Argument {
        /// The option.
        name: &'static str,
        /// As given.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// There is no frozen design yet.
    #[error("{directory}: there is no design yet; run `squid design` first")]
    NotDesigned {
        /// Where it was looked for.
        directory: String,
    },
    /// The frozen design belongs to other inputs.
    #[error("{directory}: {what} changed since this was designed; run `squid design` again")]
    Stale {
        /// The directory.
        directory: String,
        /// What changed.
        what: &'static str,
    },
    /// A frozen design makes no legal FMU.
    #[error(transparent)]
    Describe(#[from] fmi2::DescribeError),
    /// The manoeuvre is wrong.
    #[error(transparent)]
    Manoeuvre(#[from] fmu_squid::ManoeuvreError),
    /// A shared library is missing.
    #[error("{library} is not in {places}; build it with `{how}`, or name its directory with --binaries")]
    NoBinary {
        /// The file.
        library: String,
        /// The command that builds it.
        how: String,
        /// Where it was looked for.
        places: String,
    },
    /// FMI 2.0 has no name for this platform.
    #[error("FMI 2.0 has no name for the platform {os} on {arch}")]
    Platform {
        /// Operating system.
        os: &'static str,
        /// Processor.
        arch: &'static str,
    },
    /// A file is no FMU that every tool unpacks alike.
    #[error("{path}: {reason}")]
    Archive {
        /// The FMU.
        path: String,
        /// Why.
        reason: crate::fmu_archive::ArchiveError,
    },
    /// The zip could not be made.
    #[error("{path}: {reason}")]
    Zip {
        /// The file.
        path: String,
        /// Why.
        reason: zip::result::ZipError,
    },
    /// The system of plant and controller could not be described.
    #[error("{path}: {reason}")]
    Ssp {
        /// The file.
        path: String,
        /// Why.
        reason: std::io::Error,
    },
    /// A record of a flight cannot be plotted.
    #[error("{path}: {reason}")]
    Record {
        /// The file.
        path: String,
        /// Why.
        reason: String,
    },
    /// A problem file is wrong.
    #[error("{file}: {reason}")]
    Problem {
        /// The file.
        file: String,
        /// Key, what was found, what is allowed.
        reason: String,
    },
    /// A certificate does not prove its claim.
    #[error(transparent)]
    Unproved(#[from] certificate::Failure),
    /// A certificate cannot be read.
    #[error("{file}: {reason}")]
    Certificate {
        /// The file.
        file: String,
        /// What is wrong.
        reason: certificate::ReadError,
    },
    /// There is no certificate where one was looked for.
    #[error("{path}: it holds no resources/{name}, so there is nothing to verify")]
    NoCertificate {
        /// The FMU.
        path: String,
        /// The resource.
        name: String,
    },
    /// A design came to its end without a proof.
    #[error(
        "NOT PROVED: {reason}\nThe design is in {directory}, to be looked at; it proves nothing, and `squid package` refuses it"
    )]
    NotProved {
        /// Where the design lies.
        directory: String,
        /// Why.
        reason: String,
    },
    /// A certificate speaks of less than the design claims.
    #[error(
        "the certificate has no section 'residual', but the design is marked as certified for the vehicle: what is left is of the fit \
         alone, and proves nothing about the residual between the fit and the true linearisations"
    )]
    NoResidual,
    /// A certificate speaks of another controller.
    #[error("the certificate is not of this controller: {what} differs")]
    Mismatch {
        /// The first part that differs.
        what: String,
    },
    /// A controller without proof is not packed.
    #[error(
        "the controller in {directory} is not certified: {reason}\nThe FMUs are not written. With --allow-uncertified \
         they are, and say that they are uncertified"
    )]
    Uncertified {
        /// Where the design lies.
        directory: String,
        /// Why.
        reason: String,
    },
    /// A report's figure is of pitch.
    #[error("the design tracks no pitch, so that there is no response of pitch to show")]
    PitchNotTracked,
    /// A certificate speaks of another plant.
    #[error("the certificate is not of this plant: {what} differs")]
    WrongPlant {
        /// The first part that differs.
        what: String,
    },
    /// The ball of models that a certificate speaks of leaves the vehicle out.
    #[error(
        "the certificate's section 'residual' does not cover this vehicle: {}",
        .reach.map_or_else(
            || "E, F and Fu make no ball around the fit".to_owned(),
            |r| format!("the true linearisations reach {r:.4} times as far from the fit as the ball does")
        )
    )]
    Ball {
        /// How far the residual reaches, the ball's radius being 1.
        reach: Option<f64>,
    },
    /// mu has no bound.
    #[error("{file}: {reason}")]
    Mu {
        /// The problem file.
        file: String,
        /// Why.
        reason: lpv::mu::sweep::SweepError,
    },
    /// mu at a speed has no bound.
    #[error("mu at {speed} m/s: {reason}")]
    MuAtSpeed {
        /// Speed along the path, m/s.
        speed: f64,
        /// Why.
        reason: lpv::mu::sweep::SweepError,
    },
    /// The ladder of gammas could not be climbed.
    #[error(transparent)]
    Ladder(#[from] lpv::ladder::LadderError),
}

impl Error {
    /// Whether the command line is wrong, and no file.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Argument { .. } | Self::Bandwidth { .. })
    }
}
