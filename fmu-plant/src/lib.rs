//! The vehicle as an FMU
