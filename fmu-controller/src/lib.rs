//! The scheduled controller as an FMU
