//! From a vehicle file to FMUs: design, package, simulate, show
