//! The C symbols of the FMU of the whole loop.

squid_fmi2::export!(squid_fmu_loop::ClosedLoop);
