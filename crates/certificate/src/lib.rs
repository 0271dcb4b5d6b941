//! Proves the gain bound of an LPV closed loop from its certificate, in exact arithmetic.
