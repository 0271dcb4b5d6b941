//! The FMI 2.0 model description: types, checks and XML writer
