//! Random calls, resource files and states through the C ABI of each FMU.

mod calls;
mod fuzz;
mod resources;
mod states;
