//! Coupling of two axes of one vehicle in a turn.
//!
//! In straight level flight the two planes decouple, and the proof of each axis is sufficient. In a turn they do not.
//! The linear motion about a steady turn at the speed V and the rate Omega of heading is
//!
//! ```text
//! [x1'; y1]   [M11 M12] [x1; T1]     x1 = [u w q theta (z)], without u if the speed is given; x2 = [v p r phi psi]
//! [x2'; y2] = [M21 M22] [x2; T2]     T' = (u - T)/lag, u = K(rho) y, each on its own actuators and measurements y,
//!                                    which are the rates of the angles, theta' and psi'
//! ```
//!
//! as deviations from the turn; at Omega = 0 the blocks M12 and M21 are 0.
//!
//! ```text
//! turn      the matrix M
//! frozen    the eigenvalues of this loop in one turn
//! plant     the part of M of one axis as a function of speed and rate of turn
//! balance   units in which the gains are small, and matrices that bound others
//! gain      the gain of each axis through the coupling terms, proved for every trajectory
//! ```

mod balance;
pub mod frozen;
pub mod gain;
mod plant;
pub mod turn;
