//! The command `squid`, as a library: from a vehicle file to FMUs.
//!
//! ```text
//! vehicle.toml, design.toml -> inputs -> model -> problem -> (lpv) -> check -> freeze -> store -> package -> *.fmu
//!                                                                                    \-> flight -> simulate -> plots
//!                                                                                     \-> report -> page, figures
//! ```
//!
//! [`design::run`] is the main path; each stage is a file.

pub mod actuator_names;
pub mod certify;
pub mod check;
pub mod design;
pub mod design_file;
pub mod error;
pub mod flight;
pub mod fmu_archive;
pub mod freeze;
pub mod frequency;
pub mod inputs;
pub mod ladder;
pub mod lpv_command;
pub mod lpv_mu;
pub mod lpv_synth;
pub mod metrics;
pub mod model;
pub mod model_ball;
pub mod mu_file;
pub mod output;
pub mod package;
pub mod package_platform;
pub mod plot;
pub mod problem;
pub mod problem_file;
pub mod problem_matrices;
pub mod record;
pub mod report;
pub mod robust;
pub mod same_plant;
pub mod sampled;
pub mod show;
pub mod simulate;
pub mod ssp;
mod ssp_units;
pub mod stages;
pub mod store;
mod terminals;
pub mod uncertain;
pub mod uncertain_errors;
pub mod uncertain_gradients;
pub mod uncertain_loop;
pub mod uncertain_pencil;
pub mod uncertain_reduce;
pub mod uncertain_show;
pub mod uncertain_trim;
pub mod uncertain_truncate;
pub mod uncertain_vehicle;
pub mod unedited;
pub mod verify;
