//! The coefficients of a vehicle, and the one table that describes every one of them.
//!
//! Symbols are those of SNAME (1950) and Fossen (2011): `Z_uw` multiplies the product u w in the heave force,
//! `X_u_dot` is the derivative of the surge force with respect to du/dt. The table drives the reading and the
//! validation of a vehicle file, its documentation, and the parameters of the FMUs.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use nalgebra::{Matrix3, SymmetricEigen};
use thiserror::Error;

use crate::scalar::Scalar;
use crate::vehicle::allowed::Allowed;
use crate::vehicle::hull::Hull;
use crate::vehicle::surge::Surge;
use crate::words::Rounded;

const EIGENVALUE_ITERATIONS: usize = 1000;

/// One row of [`COEFFICIENTS`]: everything about a coefficient but its value.
#[derive(Debug)]
pub struct CoefficientSpec {
    /// Name in the vehicle file, for instance `Z_uw`.
    pub key: &'static str,
    /// Table of the vehicle file that contains it, for instance `lift`.
    pub section: &'static str,
    /// The only unit in which the vehicle file may give it; SI.
    pub unit: &'static str,
    /// The values that it may take.
    pub allowed: Allowed,
    /// The value if the file does not give it; `None` if the file must.
    pub default: Option<f64>,
    /// What it is, in one line.
    pub meaning: &'static str,
    /// Reads it.
    pub get: fn(&Coefficients) -> f64,
    /// Writes it, unchecked: call [`Coefficients::check`] afterwards.
    pub set: fn(&mut Coefficients, f64),
}

/// Writes the struct and the table from one list, so that they always agree.
macro_rules! coefficients {
    ($($section:literal { $($key:ident [$unit:literal] $allowed:ident $default:expr, $meaning:literal;)* })*) => {
        /// Every coefficient of the longitudinal model, in SI units; see [`COEFFICIENTS`] for their table.
        ///
        /// Over a [`Scalar`] with derivatives, the coefficients carry derivatives, too.
        ///
        /// `Z_uw`, `Z_uq`, `M_uw` and `M_uq` are the lift and viscous parts alone: added-mass cross terms and the Munk
        /// moment come from the added masses.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Coefficients<D = f64> {
            $($(#[doc = concat!($meaning, " \\[", $unit, "\\].")] pub $key: D,)*)*
            /// The sections of the hull, if its cross-flow drag is integrated over them.
            pub hull: Hull,
            /// Where the surge velocity comes from.
            pub surge: Surge,
        }

        impl<C: Copy> Coefficients<C> {
            /// Turns every coefficient into `f(key, value)`.
            pub fn map<D>(&self, f: impl Fn(&'static str, C) -> D) -> Coefficients<D> {
                Coefficients {
                    $($($key: f(stringify!($key), self.$key),)*)*
                    hull: self.hull.clone(),
                    surge: self.surge,
                }
            }
        }

        /// Every coefficient: key, section, unit, allowed values, default, meaning.
        pub static COEFFICIENTS: &[CoefficientSpec] = &[$($(CoefficientSpec {
            key: stringify!($key),
            section: $section,
            unit: $unit,
            allowed: Allowed::$allowed,
            default: $default,
            meaning: $meaning,
            get: |c| c.$key,
            set: |c, value| c.$key = value,
        },)*)*];

        impl Default for Coefficients {
            /// Takes the default of every coefficient, and zero where the file must give a value.
            fn default() -> Self {
                Self {
                    $($($key: { const DEFAULT: Option<f64> = $default; DEFAULT.unwrap_or(0.0) },)*)*
                    hull: Hull::default(),
                    surge: Surge::Free,
                }
            }
        }
    };
}

coefficients! {
    "mass" {
        mass ["kg"] Positive None, "Mass in air, with the water that it encloses";
        weight ["N"] Positive None, "Weight W = mass times gravity";
        x_G ["m"] Any Some(0.0), "Centre of gravity forward of the origin";
        z_G ["m"] Any None, "Centre of gravity below the origin";
        I_yy ["kg.m2"] Positive None, "Moment of inertia in pitch about the origin";
    }
    "buoyancy" {
        buoyancy ["N"] Positive None, "Buoyancy B at the reference depth";
        reference_depth ["m"] NonNegative Some(0.0), "Depth at which the buoyancy is given";
        buoyancy_gradient ["N/m"] Any Some(0.0), "Change of buoyancy per metre of depth, dB/dz";
        x_B ["m"] Any Some(0.0), "Centre of buoyancy forward of the origin";
        z_B ["m"] Any Some(0.0), "Centre of buoyancy below the origin";
    }
    "water" {
        density ["kg/m3"] Positive None, "Density of the water";
        kinematic_viscosity ["m2/s"] Positive Some(1.19e-6), "Kinematic viscosity of the water (sea water at 15 \
            degC: 1.19e-6)";
    }
    "added_mass" {
        X_u_dot ["kg"] NonPositive None, "Surge force per surge acceleration";
        Z_w_dot ["kg"] NonPositive None, "Heave force per heave acceleration";
        Z_q_dot ["kg.m"] Any None, "Heave force per pitch acceleration";
        M_w_dot ["kg.m"] Any None, "Pitch moment per heave acceleration";
        M_q_dot ["kg.m2"] NonPositive None, "Pitch moment per pitch acceleration";
    }
    "lift" {
        Z_uw ["kg/m"] Any None, "Heave force per u w: lift of hull and fixed fins";
        Z_uq ["kg"] Any None, "Heave force per u q";
        M_uw ["kg"] Any None, "Pitch moment per u w, beyond the Munk moment";
        M_uq ["kg.m"] Any None, "Pitch moment per u q: damping by the fixed fins";
    }
    "damping" {
        X_u ["kg/s"] NonPositive Some(0.0), "Surge force per u: linear damping";
        Z_w ["kg/s"] NonPositive Some(0.0), "Heave force per w: linear damping";
        Z_q ["kg.m/s"] Any Some(0.0), "Heave force per q: linear damping";
        M_w ["kg.m/s"] Any Some(0.0), "Pitch moment per w: linear damping";
        M_q ["kg.m2/s"] NonPositive Some(0.0), "Pitch moment per q: linear damping";
        Z_ww ["kg/m"] NonPositive Some(0.0), "Heave force per w|w|: cross-flow drag";
        Z_qq ["kg.m"] Any Some(0.0), "Heave force per q|q|: cross-flow drag";
        M_ww ["kg"] Any Some(0.0), "Pitch moment per w|w|: cross-flow drag";
        M_qq ["kg.m2"] NonPositive Some(0.0), "Pitch moment per q|q|: cross-flow drag";
        M_uu ["kg"] Any Some(0.0), "Pitch moment per u|u|: asymmetry of the hull";
    }
    "hull" {
        C_d ["1"] NonNegative Some(0.0), "Drag coefficient of the hull's sections in cross flow";
    }
    "drag" {
        X_uu ["kg/m"] NonPositive Some(0.0), "Surge force per u|u|: a constant drag coefficient";
        length ["m"] Positive Some(1.0), "Length L of the hull in the Reynolds number";
        wetted_area ["m2"] NonNegative Some(0.0), "Wetted area S_w of the hull, for friction by ITTC-57";
        form_factor ["1"] NonNegative Some(1.0), "Form factor on the friction of a flat plate";
        drag_area ["m2"] NonNegative Some(0.0), "Drag area C_d A of appendages and base";
    }
}

/// Why a set of coefficients is not allowed.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum CoefficientError {
    /// A coefficient is outside its allowed values.
    #[error("{key} is {} {unit}, and must be {}", Rounded(*found), allowed.describe())]
    NotAllowed { key: &'static str, found: f64, unit: &'static str, allowed: Allowed },
    /// The mass matrix, added mass included, is not positive definite.
    #[error(
        "the mass matrix (mass, I_yy, x_G, z_G and the added masses) is not positive definite: \
         its least eigenvalue is {}, and must be above zero",
        Rounded(*least_eigenvalue)
    )]
    MassMatrixNotPositiveDefinite { least_eigenvalue: f64 },
}

impl<D: Scalar> Coefficients<D> {
    /// Returns the mass matrix M of surge, heave and pitch, added mass included.
    ///
    /// ```text
    /// [ m - X_u'      0                 m z_G           ]
    /// [ 0             m - Z_w'         -(m x_G + Z_q')  ]
    /// [ m z_G        -(m x_G + M_w')    I_yy - M_q'     ]
    /// ```
    ///
    /// Where the speed is given, the first row is that of `u' = u'`.
    ///
    /// Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), ch. 6, in the x-z plane.
    pub fn mass_matrix(&self) -> Matrix3<D> {
        let (m, none) = (self.mass, D::from(0.0));
        let [surge, by_pitch] = match self.surge {
            Surge::Free => [m - self.X_u_dot, m * self.z_G],
            Surge::Given { .. } => [D::from(1.0), none],
        };
        Matrix3::new(
            surge,
            none,
            by_pitch,
            none,
            m - self.Z_w_dot,
            -(m * self.x_G + self.Z_q_dot),
            m * self.z_G,
            -(m * self.x_G + self.M_w_dot),
            self.I_yy - self.M_q_dot,
        )
    }
}

impl Coefficients {
    /// Returns the rows of [`COEFFICIENTS`] that act on the motion: at a given speed those along the hull do not.
    pub fn acting(&self) -> impl Iterator<Item = &'static CoefficientSpec> + use<> {
        let surge = self.surge;
        COEFFICIENTS.iter().filter(move |spec| surge.uses(spec.key))
    }

    /// Returns the buoyancy at a depth \[m\]: B(z) = B + dB/dz (z - z_ref).
    pub fn buoyancy_at(&self, depth: f64) -> f64 {
        self.buoyancy + self.buoyancy_gradient * (depth - self.reference_depth)
    }

    /// Checks every coefficient against the table, and that the mass matrix is positive definite.
    ///
    /// # Errors
    /// The first [`CoefficientError`] in the order of the table.
    pub fn check(&self) -> Result<(), CoefficientError> {
        for spec in COEFFICIENTS {
            let found = (spec.get)(self);
            if !spec.allowed.contains(found) {
                let (key, unit, allowed) = (spec.key, spec.unit, spec.allowed);
                return Err(CoefficientError::NotAllowed { key, found, unit, allowed });
            }
        }
        let mut mass = self.mass_matrix();
        if self.surge.is_given() {
            // Pitch is moved by a given surge, and does not move it.
            mass[(2, 0)] = 0.0;
        }
        let symmetric = (mass + mass.transpose()) * 0.5;
        // Without a limit the decomposition would never end for entries that are not finite.
        let eigenvalues = SymmetricEigen::try_new(symmetric, f64::EPSILON, EIGENVALUE_ITERATIONS);
        let least_eigenvalue = eigenvalues.map_or(f64::NAN, |decomposition| decomposition.eigenvalues.min());
        if least_eigenvalue > 0.0 {
            Ok(())
        } else {
            Err(CoefficientError::MassMatrixNotPositiveDefinite { least_eigenvalue })
        }
    }

    /// Splits combined lift coefficients, as many theses print them, and keeps the lift and viscous parts.
    ///
    /// Kirchhoff's equations put `-X_u' u q` into the heave force, and `(X_u' - Z_w') u w` (the Munk moment) and
    /// `-Z_q' u q` into the pitch moment. Where the printed coefficients include these, they are subtracted:
    ///
    /// ```text
    /// Z_uq += X_u',   M_uw += Z_w' - X_u',   M_uq += Z_q'
    /// ```
    ///
    /// Source: Prestero (2001) prints the combined form; Lamb, Hydrodynamics (1932), ch. VI, has the subtracted terms.
    pub fn split_combined_lift(&mut self) {
        self.Z_uq += self.X_u_dot;
        self.M_uw += self.Z_w_dot - self.X_u_dot;
        self.M_uq += self.Z_q_dot;
    }
}
