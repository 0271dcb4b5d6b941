//! An underwater vehicle: coefficients, nonlinear longitudinal dynamics, trim, linearisation
