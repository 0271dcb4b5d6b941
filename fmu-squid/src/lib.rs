//! Vehicle and controller in one loop as an FMU
