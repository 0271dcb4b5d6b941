//! C symbols of the controller FMU.

squid_fmi2::export!(squid_fmu_controller::Controller);
