//! The C symbols of the FMU of the whole loop.

fmi2::export!(fmu_squid::ClosedLoop);
