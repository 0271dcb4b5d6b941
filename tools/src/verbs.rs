//! Verbs of the command, one file each.

pub mod campaign;
pub mod design;
pub mod doctor;
pub mod export;
pub mod lpv;
pub mod new;
pub mod package;
pub mod plot;
pub mod prove;
pub mod report;
pub mod shell;
pub mod show;
pub mod simulate;
pub mod tune;
pub mod verify;
