//! FMI 2.0 co-simulation export: C ABI, state table, variable registry
