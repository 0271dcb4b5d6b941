//! Coefficients of a vehicle, and the table that describes every one of them.
//!
//! Symbols follow SNAME (1950) and Fossen (2011): `Z_uw` multiplies the product |u| w in the heave force, `X_u_dot` is
//! the derivative of the surge force with respect to du/dt. The table drives reading and validation of a vehicle file,
//! its documentation, and the parameters of the FMUs.

#![allow(non_snake_case, reason = "the field's symbols keep their capitals: Z is a force, z a length")]

use nalgebra::{Matrix3, SymmetricEigen};
use thiserror::Error;

use crate::scalar::Scalar;
use crate::text::Rounded;
use crate::vehicle::allowed::Allowed;
use crate::vehicle::hull::Hull;
use crate::vehicle::surge::Surge;

use DefaultValue::{Axisymmetric, Number, Required};

const EIGENVALUE_ITERATIONS: usize = 1000;

/// Row of [`COEFFICIENTS`]: everything about a coefficient except its value.
#[derive(Debug)]
pub struct CoefficientSpec {
    /// Name in the vehicle file, for instance `Z_uw`.
    pub key: &'static str,
    /// Table of the vehicle file that contains it, for instance `lift`.
    pub section: &'static str,
    /// Part of the motion affected.
    pub subsystem: Subsystem,
    /// Unit required in the vehicle file; SI.
    pub unit: &'static str,
    /// Allowed values.
    pub allowed: Allowed,
    /// Value if absent in the file.
    pub default: DefaultValue,
    /// Description in one line.
    pub meaning: &'static str,
    /// Reads the coefficient.
    pub get: fn(&Coefficients) -> f64,
    /// Writes the coefficient, unchecked: call [`Coefficients::check`] afterwards.
    pub set: fn(&mut Coefficients, f64),
}

/// Value of a coefficient that is absent in a vehicle file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DefaultValue {
    /// No default: the file must contain it.
    Required,
    /// Number.
    Number(f64),
    /// Value for a hull that is unchanged by a turn of 90 deg about its axis: this factor times another coefficient.
    Axisymmetric(&'static str, f64),
}

impl CoefficientSpec {
    /// Returns `true` if a vehicle file must contain the coefficient.
    pub fn is_required(&self) -> bool {
        self.default == Required
    }

    /// Returns `true` if the coefficient acts in sway, roll and yaw only.
    pub fn acts_out_of_plane(&self) -> bool {
        self.subsystem == Subsystem::Lateral
    }
}

/// Part of the motion affected by a coefficient.
///
/// Source of the terms: Fossen (2011), ch. 7, the longitudinal and the lateral subsystem of a vehicle with
/// port-starboard symmetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subsystem {
    /// Surge, heave and pitch only.
    Longitudinal,
    /// Sway, roll and yaw; no effect on motion in the vertical plane.
    Lateral,
    /// Both subsystems.
    Both,
}

/// Generates the struct and the table from one list, so that they always agree.
macro_rules! coefficients {
    ($($section:literal {
        $($key:ident $subsystem:ident [$unit:literal] $allowed:ident $default:expr, $meaning:literal;)*
    })*) => {
        /// Coefficients of the model, in SI units; see [`COEFFICIENTS`] for their table.
        ///
        /// Over a [`Scalar`] with derivatives, the coefficients carry derivatives, too.
        ///
        /// `Z_uw`, `M_uq`, `N_uv` and the like are the lift and viscous parts only: added-mass cross terms and the
        /// Munk moment follow from the added masses. With I_xx = 0 the vehicle moves in the vertical plane only.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Coefficients<D = f64> {
            $($(#[doc = concat!($meaning, " \\[", $unit, "\\].")] pub $key: D,)*)*
            /// Sections of the hull, if its cross-flow drag is integrated over them.
            pub hull: Hull,
            /// Source of the surge velocity.
            pub surge: Surge,
        }

        impl<C: Copy> Coefficients<C> {
            /// Returns the coefficients with every one replaced by `f(key, value)`.
            pub fn map<D>(&self, f: impl Fn(&'static str, C) -> D) -> Coefficients<D> {
                Coefficients {
                    $($($key: f(stringify!($key), self.$key),)*)*
                    hull: self.hull.clone(),
                    surge: self.surge,
                }
            }
        }

        /// All coefficients: key, section, unit, allowed values, default, meaning.
        pub static COEFFICIENTS: &[CoefficientSpec] = &[$($(CoefficientSpec {
            key: stringify!($key),
            section: $section,
            subsystem: Subsystem::$subsystem,
            unit: $unit,
            allowed: Allowed::$allowed,
            default: $default,
            meaning: $meaning,
            get: |c| c.$key,
            set: |c, value| c.$key = value,
        },)*)*];

        impl Default for Coefficients {
            /// Returns the default number of each coefficient, and zero for those without.
            fn default() -> Self {
                Self {
                    $($($key: { if let Number(value) = $default { value } else { 0.0 } },)*)*
                    hull: Hull::default(),
                    surge: Surge::Free,
                }
            }
        }
    };
}

coefficients! {
    "mass" {
        mass Both ["kg"] Positive Required, "mass in air, including enclosed water";
        weight Both ["N"] Positive Required, "weight W = mass times gravity";
        x_G Both ["m"] Any Number(0.0), "centre of gravity forward of the origin";
        z_G Both ["m"] Any Required, "centre of gravity below the origin";
        I_yy Both ["kg.m2"] Positive Required, "moment of inertia in pitch about the origin";
        I_xx Lateral ["kg.m2"] NonNegative Number(0.0), "moment of inertia in roll about the origin; 0 for motion in \
            the vertical plane only";
        I_zz Lateral ["kg.m2"] NonNegative Axisymmetric("I_yy", 1.0), "moment of inertia in yaw about the origin";
    }
    "buoyancy" {
        buoyancy Both ["N"] Positive Required, "buoyancy B at the reference depth";
        reference_depth Both ["m"] NonNegative Number(0.0), "reference depth of the buoyancy";
        buoyancy_gradient Both ["N/m"] Any Number(0.0), "change of buoyancy per metre of depth, dB/dz";
        x_B Both ["m"] Any Number(0.0), "centre of buoyancy forward of the origin";
        z_B Both ["m"] Any Number(0.0), "centre of buoyancy below the origin";
    }
    "water" {
        density Both ["kg/m3"] Positive Required, "density of the water";
        kinematic_viscosity Longitudinal ["m2/s"] Positive Number(1.19e-6), "kinematic viscosity of the water (sea \
            water at 15 degC: 1.19e-6)";
    }
    "added_mass" {
        X_u_dot Both ["kg"] NonPositive Required, "surge force per surge acceleration";
        Z_w_dot Both ["kg"] NonPositive Required, "heave force per heave acceleration";
        Z_q_dot Both ["kg.m"] Any Required, "heave force per pitch acceleration";
        M_w_dot Both ["kg.m"] Any Required, "pitch moment per heave acceleration";
        M_q_dot Both ["kg.m2"] NonPositive Required, "pitch moment per pitch acceleration";
        Y_v_dot Lateral ["kg"] NonPositive Axisymmetric("Z_w_dot", 1.0), "sway force per sway acceleration";
        Y_p_dot Lateral ["kg.m"] Any Number(0.0), "sway force per roll acceleration, and roll moment per sway \
            acceleration";
        Y_r_dot Lateral ["kg.m"] Any Axisymmetric("Z_q_dot", -1.0), "sway force per yaw acceleration, and yaw moment \
            per sway acceleration";
        K_p_dot Lateral ["kg.m2"] NonPositive Number(0.0), "roll moment per roll acceleration";
        K_r_dot Lateral ["kg.m2"] Any Number(0.0), "roll moment per yaw acceleration, and yaw moment per roll \
            acceleration";
        N_r_dot Lateral ["kg.m2"] NonPositive Axisymmetric("M_q_dot", 1.0), "yaw moment per yaw acceleration";
    }
    "lift" {
        Z_uw Longitudinal ["kg/m"] Any Required, "heave force per |u| w: lift of hull and fixed fins";
        Z_uq Longitudinal ["kg"] Any Required, "heave force per |u| q";
        M_uw Longitudinal ["kg"] Any Required, "pitch moment per |u| w, beyond the Munk moment";
        M_uq Longitudinal ["kg.m"] Any Required, "pitch moment per |u| q: damping by the fixed fins";
        Y_uv Lateral ["kg/m"] Any Axisymmetric("Z_uw", 1.0), "sway force per |u| v: lift of hull and fixed fins";
        Y_up Lateral ["kg"] Any Number(0.0), "sway force per |u| p";
        Y_ur Lateral ["kg"] Any Axisymmetric("Z_uq", -1.0), "sway force per |u| r";
        K_uv Lateral ["kg"] Any Number(0.0), "roll moment per |u| v";
        K_up Lateral ["kg.m"] Any Number(0.0), "roll moment per |u| p: damping by the fixed fins";
        K_ur Lateral ["kg.m"] Any Number(0.0), "roll moment per |u| r";
        N_uv Lateral ["kg"] Any Axisymmetric("M_uw", -1.0), "yaw moment per |u| v, beyond the Munk moment";
        N_up Lateral ["kg.m"] Any Number(0.0), "yaw moment per |u| p";
        N_ur Lateral ["kg.m"] Any Axisymmetric("M_uq", 1.0), "yaw moment per |u| r: damping by the fixed fins";
    }
    "damping" {
        X_u Longitudinal ["kg/s"] NonPositive Number(0.0), "surge force per u: linear damping";
        Z_w Longitudinal ["kg/s"] NonPositive Number(0.0), "heave force per w: linear damping";
        Z_q Longitudinal ["kg.m/s"] Any Number(0.0), "heave force per q: linear damping";
        M_w Longitudinal ["kg.m/s"] Any Number(0.0), "pitch moment per w: linear damping";
        M_q Longitudinal ["kg.m2/s"] NonPositive Number(0.0), "pitch moment per q: linear damping";
        Z_ww Longitudinal ["kg/m"] NonPositive Number(0.0), "heave force per w|w|: cross-flow drag";
        Z_qq Longitudinal ["kg.m"] Any Number(0.0), "heave force per q|q|: cross-flow drag";
        M_ww Longitudinal ["kg"] Any Number(0.0), "pitch moment per w|w|: cross-flow drag";
        M_qq Longitudinal ["kg.m2"] NonPositive Number(0.0), "pitch moment per q|q|: cross-flow drag";
        M_uu Longitudinal ["kg"] Any Number(0.0), "pitch moment per u|u|: asymmetry of the hull";
        Y_v Lateral ["kg/s"] NonPositive Axisymmetric("Z_w", 1.0), "sway force per v: linear damping";
        Y_r Lateral ["kg.m/s"] Any Axisymmetric("Z_q", -1.0), "sway force per r: linear damping";
        Y_vv Lateral ["kg/m"] NonPositive Axisymmetric("Z_ww", 1.0), "sway force per v|v|: cross-flow drag";
        Y_rr Lateral ["kg.m"] Any Axisymmetric("Z_qq", -1.0), "sway force per r|r|: cross-flow drag";
        K_p Lateral ["kg.m2/s"] NonPositive Number(0.0), "roll moment per p: linear damping";
        K_pp Lateral ["kg.m2"] NonPositive Number(0.0), "roll moment per p|p|: damping of the hull and its fins";
        N_v Lateral ["kg.m/s"] Any Axisymmetric("M_w", -1.0), "yaw moment per v: linear damping";
        N_r Lateral ["kg.m2/s"] NonPositive Axisymmetric("M_q", 1.0), "yaw moment per r: linear damping";
        N_vv Lateral ["kg"] Any Axisymmetric("M_ww", -1.0), "yaw moment per v|v|: cross-flow drag";
        N_rr Lateral ["kg.m2"] NonPositive Axisymmetric("M_qq", 1.0), "yaw moment per r|r|: cross-flow drag";
    }
    "hull" {
        C_d Both ["1"] NonNegative Number(0.0), "drag coefficient of the hull's sections in cross flow";
    }
    "drag" {
        X_uu Longitudinal ["kg/m"] NonPositive Number(0.0), "surge force per u|u|: a constant drag coefficient";
        length Longitudinal ["m"] Positive Number(1.0), "length L of the hull in the Reynolds number";
        wetted_area Longitudinal ["m2"] NonNegative Number(0.0), "wetted area S_w of the hull, for friction by ITTC-57";
        form_factor Longitudinal ["1"] NonNegative Number(1.0), "form factor on the friction of a flat plate";
        drag_area Longitudinal ["m2"] NonNegative Number(0.0), "drag area C_d A of appendages and base";
    }
}

/// Reason why a set of coefficients is not allowed.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum CoefficientError {
    /// A coefficient outside its allowed values.
    #[error("{key} is {} {unit}; it must be {}", Rounded(*found), allowed.describe())]
    NotAllowed { key: &'static str, found: f64, unit: &'static str, allowed: Allowed },
    /// A mass matrix, added mass included, that is not positive definite.
    #[error(
        "the mass matrix ({numbers}, x_G, z_G and the added masses) is not positive definite: its least eigenvalue \
         is {}; it must be above zero",
        Rounded(*least_eigenvalue)
    )]
    MassMatrixNotPositiveDefinite { numbers: &'static str, least_eigenvalue: f64 },
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
    /// If the speed is given, the first row is that of `u' = u'`.
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

    /// Returns the mass matrix of sway, roll and yaw, added mass included; port-starboard symmetry decouples it from
    /// that of surge, heave and pitch.
    ///
    /// ```text
    /// [ m - Y_v'          -(m z_G + Y_p')   m x_G - Y_r' ]
    /// [ -(m z_G + Y_p')   I_xx - K_p'       -K_r'        ]
    /// [ m x_G - Y_r'      -K_r'             I_zz - N_r'  ]
    /// ```
    ///
    /// Source: see [`Coefficients::mass_matrix`].
    pub fn lateral_mass_matrix(&self) -> Matrix3<D> {
        let m = self.mass;
        let (by_roll, by_yaw, roll_yaw) =
            (-(m * self.z_G + self.Y_p_dot), m * self.x_G - self.Y_r_dot, -self.K_r_dot);
        Matrix3::new(
            m - self.Y_v_dot,
            by_roll,
            by_yaw,
            by_roll,
            self.I_xx - self.K_p_dot,
            roll_yaw,
            by_yaw,
            roll_yaw,
            self.I_zz - self.N_r_dot,
        )
    }
}

impl Coefficients {
    /// Returns the rows of [`COEFFICIENTS`] that affect motion in the vertical plane; for a given speed those along the
    /// hull do not.
    pub fn acting(&self) -> impl Iterator<Item = &'static CoefficientSpec> + use<> {
        let surge = self.surge;
        COEFFICIENTS.iter().filter(move |spec| !spec.acts_out_of_plane() && surge.uses(spec.key))
    }

    /// Returns `true` if the vehicle moves out of the vertical plane: I_xx is above zero.
    pub fn leaves_plane(&self) -> bool {
        self.I_xx > 0.0
    }

    /// Sets the lateral coefficients that are not `given` to their values for an axisymmetric hull, and returns their
    /// keys; returns none for a vehicle that stays in the vertical plane.
    pub fn complete(&mut self, given: impl Fn(&str) -> bool) -> Vec<&'static str> {
        if !self.leaves_plane() {
            return vec![];
        }
        let missing = COEFFICIENTS.iter().filter(|spec| spec.acts_out_of_plane() && !given(spec.key));
        let missing: Vec<&CoefficientSpec> = missing.collect();
        for spec in &missing {
            if let Axisymmetric(key, factor) = spec.default {
                let of = COEFFICIENTS.iter().find(|other| other.key == key);
                (spec.set)(self, of.map_or(0.0, |other| factor * (other.get)(self)));
            }
        }
        missing.into_iter().map(|spec| spec.key).collect()
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
            // Pitch is coupled to a given surge, but not surge to pitch.
            mass[(2, 0)] = 0.0;
        }
        check_positive_definite("mass, I_yy", mass)?;
        if self.leaves_plane() {
            check_positive_definite("mass, I_xx, I_zz", self.lateral_mass_matrix())
        } else {
            Ok(())
        }
    }

    /// Splits combined lift coefficients, as printed in many theses, and keeps the lift and viscous parts.
    ///
    /// Kirchhoff's equations put `-X_u' u q` into the heave force, and `(X_u' - Z_w') u w` (the Munk moment) and `-Z_q'
    /// u q` into the pitch moment. Printed coefficients that include these terms are reduced by them:
    ///
    /// ```text
    /// Z_uq += X_u',   M_uw += Z_w' - X_u',   M_uq += Z_q'
    /// Y_ur -= X_u',   N_uv -= Y_v' - X_u',   N_ur -= Y_r',   N_up -= Y_p'
    /// ```
    ///
    /// Source: Prestero (2001) prints the combined form; Lamb, Hydrodynamics (1932), ch. VI, has the subtracted terms.
    pub fn split_combined_lift(&mut self) {
        self.Z_uq += self.X_u_dot;
        self.M_uw += self.Z_w_dot - self.X_u_dot;
        self.M_uq += self.Z_q_dot;
        if !self.leaves_plane() {
            return;
        }
        self.Y_ur -= self.X_u_dot;
        self.N_uv -= self.Y_v_dot - self.X_u_dot;
        self.N_ur -= self.Y_r_dot;
        self.N_up -= self.Y_p_dot;
    }
}

/// Refuses a mass matrix whose symmetric part is not positive definite.
fn check_positive_definite(numbers: &'static str, mass: Matrix3<f64>) -> Result<(), CoefficientError> {
    let symmetric = (mass + mass.transpose()) * 0.5;
    // Without a limit the decomposition never ends for entries that are not finite.
    let eigenvalues = SymmetricEigen::try_new(symmetric, f64::EPSILON, EIGENVALUE_ITERATIONS);
    let least_eigenvalue = eigenvalues.map_or(f64::NAN, |decomposition| decomposition.eigenvalues.min());
    if least_eigenvalue > 0.0 {
        Ok(())
    } else {
        Err(CoefficientError::MassMatrixNotPositiveDefinite { numbers, least_eigenvalue })
    }
}
