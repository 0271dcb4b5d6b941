//! C symbols of the closed-loop FMU.

squid_fmi2::export!(squid_fmu_loop::ClosedLoop);
