//! The generalised plant of a tracking problem: model, actuators, references, weights, noise.
//!
//! ```text
//! r --[R]--+-->[T_ref]--(+)--> e --[W_e]--> z_e    W_e = (s/M_s + w_b) / (s + w_b eps)
//!          |             ^-                       R = (s + follow corner) / (s + corner)
//!          |             |<-- C x -----------+
//!          v             v                   |
//!   y = [R r; C x + N n] or e                |
//!    |                                       |
//!   [K]--> u --[delay]--[lag]--(+)--[model]--+
//!          |                    ^         ^
//!        [W_u]                beta d   [coloured]   d: disturbance at the input
//!          v
//!         z_u
//! ```
//!
//! Sources: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, section 3B and Fig. 2 (the tracking errors
//! as the only measurements); S. Skogestad, I. Postlethwaite, Multivariable Feedback Control, 2005, section 9.4.1 and
//! eq. 9.88 (two degrees of freedom and a reference model). The weights are in [`super::weights`].

use crate::error::SystemError;
use crate::matrix::{Mat, block, diagonal};
use crate::system::{
    GeneralisedPlant, Lft, PLANT, Partitioned, ReferenceModel, ReferenceWeight, RisingWeight, Sizes,
    TrackingWeight, assembly::Assembly, assembly::Signal, weights::invertible,
};

/// A trim that moves with the reference of one tracked output, the speed.
///
/// Its level follows `v' = w (r - v)`; the reference model of that output, if any, is the same filter. States, inputs
/// and references are deviations from the trim at v, and `slope` is the derivative of the trim:
///
/// ```text
/// x~ = x - x0(v),   u~ = u - u0(v),   x~' = A x~ + B u~ - x0'(v) v'
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MovingTrim {
    /// The tracked output.
    pub output: usize,
    /// Frequency w, rad/s.
    pub frequency: f64,
    /// `[x0'; u0']` as a function of the parameter, (n + m) x 1, in units of the model per unit of the output.
    pub slope: Lft,
}

/// Two degrees of freedom: the controller measures references and outputs separately.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoDegrees {
    /// C of the measurements, in units of their scales, q x n.
    pub measured: Mat,
    /// N of each measurement, in units of its scale.
    pub noise: Vec<RisingWeight>,
    /// T_ref of each tracked output; `None` for 1.
    pub models: Vec<Option<ReferenceModel>>,
    /// The trim, if it moves with a reference.
    pub trim: Option<MovingTrim>,
}

/// The numbers of states and of inputs of the filter of the coloured disturbance.
const FILTER: (usize, usize) = (2, 1);

/// A tracking problem for a model `x' = A(theta) x + B(theta) v`.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackingProblem {
    /// The LFT of `[A B]`, n x (n + m).
    pub model: Lft,
    /// The rows of C of the tracked outputs, p x n.
    pub outputs: Mat,
    /// The unit of each tracked output and its error.
    pub output_scale: Vec<f64>,
    /// R of each reference.
    pub references: Vec<ReferenceWeight>,
    /// The unit of each input: its limit.
    pub input_scale: Vec<f64>,
    /// Time constant of the lag of each input, s; 0 for none.
    pub lags: Vec<f64>,
    /// The delay T of the commands, before the lags, s; 0 for none. The plant has its first-order Pade approximation,
    /// the all-pass `(2/T - s)/(2/T + s)`, whose phase error is `(omega T)^3/12`.
    pub delay: f64,
    /// W_e of each tracked output.
    pub tracking: Vec<TrackingWeight>,
    /// W_u of each input, in units of its scale.
    pub control: Vec<RisingWeight>,
    /// Size of the disturbance at each input, after its lag, in units of its scale.
    pub disturbance: f64,
    /// A coloured disturbance, such as waves: white noise through a filter with two states, as the LFT of
    /// `[G 0; A_w B_w]`, (n + 2) x 3, with `x_w' = A_w x_w + B_w w` and G x_w added to x'. `None` for none.
    pub coloured: Option<Lft>,
    /// The parts of a controller of two degrees of freedom; `None` if it measures the tracking errors only.
    pub two_degrees: Option<TwoDegrees>,
}

/// Position of the model in the generalised plant: `[A B1 B2]` of the plant is
///
/// ```text
/// left [A B G x0'; 0 0 0 u0'] right + terms that do not depend on the model
/// ```
///
/// at every theta, without G if there is no coloured disturbance, and with `[A B G]` alone if no trim moves.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelPosition {
    /// Left factor, into x': the model's rates, and the motion of the inputs' trim into the states of lags and delays.
    /// states x (n + m), or states x n if no trim moves.
    pub left: Mat,
    /// Right factor, from `[x; w; u]`: the model's states, its inputs, the states of the filter and, as a last row if
    /// the trim moves, minus its rate. In units of the model.
    pub right: Mat,
}

impl TrackingProblem {
    /// Builds the generalised plant.
    ///
    /// States: the model's; the lags; one per delay; one per W_e; two for the coloured disturbance; those of R, the
    /// trim, the reference models, the noise and W_u, if any. `w = [r; d; n; noise of the filter]`, `z = [W_e e; W_u
    /// u]`, y = e or `[R r; C x + N n]`, all in units of their scales. With a moving trim, x, u, R r and the
    /// measurements are deviations from it.
    ///
    /// # Errors
    /// Returns an error for the first part of a wrong size, or the first number that makes a weight improper, unstable
    /// or infinite.
    pub fn augment(&self) -> Result<GeneralisedPlant, SystemError> {
        Ok(self.assembled()?.0)
    }

    /// Returns the position of the model in the plant of [`TrackingProblem::augment`].
    ///
    /// # Errors
    /// Errors of [`TrackingProblem::augment`].
    pub fn model_position(&self) -> Result<ModelPosition, SystemError> {
        Ok(self.assembled()?.1)
    }

    fn assembled(&self) -> Result<(GeneralisedPlant, ModelPosition), SystemError> {
        let n = self.model.constant.nrows();
        let (m, p) = (self.input_scale.len(), self.outputs.nrows());
        self.check(n, m, p)?;
        self.check_numbers()?;
        let noises = self.two_degrees.as_ref().map_or(0, |two| two.noise.len());
        let model = self.augmented_model(n, m);
        let (filter_states, filter_inputs) = self.coloured.as_ref().map_or((0, 0), |_| FILTER);
        let others = p + m + noises;
        let sizes =
            Sizes { x: self.states(n), t: model.size(), w: others + filter_inputs, u: m, ..Sizes::default() };
        let mut all = Assembly::new(sizes.x, sizes.t + sizes.w + sizes.u);
        let (_, x) = all.state(n);
        let actuators = self.actuators(&mut all);
        let (first_weight, weight_states) = all.state(p);
        let (first_filter, coloured) = all.state(filter_states);
        let wt = all.signal(sizes.x, sizes.t);
        let [unit, d, noise, excitation, u] =
            [(0, p), (p, m), (p + m, noises), (others, filter_inputs), (sizes.w, m)]
                .map(|(first, count)| all.signal(sizes.x + sizes.t + first, count));
        let r = self.weighted_references(&mut all, &unit);
        let (references, trim_rate) = self.trim_motion(&mut all, &r);
        let forces = self.actuated(&mut all, &actuators, &u) + d * self.disturbance;
        let inputs = block(&[
            &[&x],
            &[&(diagonal(self.input_scale.iter().copied()) * &forces)],
            &[&coloured],
            &[&excitation],
            &[&-trim_rate],
        ]);
        let mut left = Mat::zeros(sizes.x, model.constant.nrows());
        left.view_mut((0, 0), (n, n)).fill_with_identity();
        if self.trim().is_some() {
            for (state, j) in actuators.states() {
                left[(state, n + j)] = 1.0 / self.input_scale[j];
            }
        }
        let filters = left.ncols() - filter_states;
        left.view_mut((first_filter, filters), (filter_states, filter_states)).fill_with_identity();
        let moved = &model.constant * &inputs + &model.left * &wt;
        let zt = &model.right * &inputs + &model.inner * &wt;

        let outputs = diagonal(self.output_scale.iter().map(|s| 1.0 / s)) * &self.outputs * &x;
        let errors = self.errors(&mut all, &r, &references, &outputs);
        let mut z = self.weighted_errors(&mut all, first_weight, &weight_states, &errors);
        let y = match &self.two_degrees {
            None => r - outputs,
            Some(two) => block(&[&[&references], &[&noisy_measurements(&mut all, two, &x, &noise)]]),
        };
        z.extend((0..m).map(|j| all.weighted(&self.control[j], &row(&u, j))));
        let z = Mat::from_fn(z.len(), x.ncols(), |i, j| z[i][(0, j)]);
        let sizes = Sizes { z: z.nrows(), y: y.nrows(), ..sizes };
        let matrix = block(&[&[&(all.derivatives + &left * moved)], &[&zt], &[&z], &[&y]]);
        let mut blocks = vec![0; model.channels.iter().max().map_or(0, |last| last + 1)];
        model.channels.iter().for_each(|channel| blocks[*channel] += 1);
        let plant = GeneralisedPlant { parts: Partitioned::of(matrix, PLANT, sizes), blocks };
        let right = inputs.remove_rows(n + m + filter_states, filter_inputs).remove_columns(sizes.x, sizes.t);
        Ok((plant, ModelPosition { left: left.columns(0, filters).into_owned(), right }))
    }

    fn trim(&self) -> Option<&MovingTrim> {
        self.two_degrees.as_ref().and_then(|two| two.trim.as_ref())
    }

    /// Adds the states of lags and delays.
    fn actuators(&self, all: &mut Assembly) -> Actuators {
        let m = self.input_scale.len();
        let lagged: Vec<usize> = (0..m).filter(|j| self.lags[*j] > 0.0).collect();
        let (first_lag, lags) = all.state(lagged.len());
        let (first_delay, delays) = all.state(self.delay_states(m));
        Actuators { lagged, first_lag, lags, first_delay, delays }
    }

    /// Returns R r.
    fn weighted_references(&self, all: &mut Assembly, unit: &Signal) -> Signal {
        let mut r = unit.clone();
        for (i, weight) in self.references.iter().enumerate() {
            r.rows_mut(i, 1).copy_from(&all.slow_emphasis(weight, &row(unit, i)));
        }
        r
    }

    /// Returns the references as deviations from the trim, and the rate of the trim in the unit of its output, one row
    /// if it moves.
    fn trim_motion(&self, all: &mut Assembly, r: &Signal) -> (Signal, Signal) {
        let mut references = r.clone();
        let Some(MovingTrim { output, frequency, .. }) = self.trim() else {
            return (references, Mat::zeros(0, r.ncols()));
        };
        let (at, v) = all.state(1);
        let ahead = row(r, *output) - &v;
        all.derivative(at, &(&ahead * *frequency));
        references.rows_mut(*output, 1).copy_from(&ahead);
        (references, &ahead * (*frequency * self.output_scale[*output]))
    }

    /// Returns the commands after delay and lags.
    fn actuated(&self, all: &mut Assembly, actuators: &Actuators, u: &Signal) -> Signal {
        let mut forces = u.clone();
        if self.delay > 0.0 {
            all.derivative(actuators.first_delay, &((u - &actuators.delays) * (2.0 / self.delay)));
            forces = &actuators.delays * 2.0 - u;
        }
        for (i, j) in actuators.lagged.iter().enumerate() {
            let lag = row(&actuators.lags, i);
            all.derivative(actuators.first_lag + i, &((row(&forces, *j) - &lag) / self.lags[*j]));
            forces.rows_mut(*j, 1).copy_from(&lag);
        }
        forces
    }

    /// Returns the tracking errors, relative to the reference models if there are any.
    fn errors(&self, all: &mut Assembly, r: &Signal, references: &Signal, outputs: &Signal) -> Vec<Signal> {
        let two = self.two_degrees.as_ref();
        let target = |i: usize| match two.and_then(|two| two.models[i]) {
            Some(_) if self.trim().is_some_and(|trim| trim.output == i) => row(r, i) * 0.0,
            Some(model) => all.follow(&model, &row(r, i)),
            None => row(references, i),
        };
        (0..outputs.nrows()).map(target).enumerate().map(|(i, target)| target - row(outputs, i)).collect()
    }

    /// Returns W_e e, with the states of W_e from `first`.
    fn weighted_errors(
        &self,
        all: &mut Assembly,
        first: usize,
        states: &Signal,
        errors: &[Signal],
    ) -> Vec<Signal> {
        let mut weighted = Vec::with_capacity(errors.len());
        for (i, error) in errors.iter().enumerate() {
            let [pole, gain, direct] = self.tracking[i].realise();
            let state = row(states, i);
            all.derivative(first + i, &(&state * pole + error * gain));
            weighted.push(state * gain + error * direct);
        }
        weighted
    }

    /// Returns the number of states of the delays of m inputs.
    fn delay_states(&self, m: usize) -> usize {
        if self.delay > 0.0 { m } else { 0 }
    }

    /// Returns the number of states.
    fn states(&self, n: usize) -> usize {
        let lags = self.lags.iter().filter(|lag| **lag > 0.0).count();
        let weights = self.control.iter().filter(|weight| weight.rises()).count();
        let two = self.two_degrees.as_ref().map_or(0, |two| {
            let follows = |(i, model): (usize, &Option<ReferenceModel>)| match (&two.trim, model) {
                (Some(trim), _) if trim.output == i => 1,
                (_, Some(model)) => 1 + usize::from(model.damping.is_some()),
                (_, None) => 0,
            };
            let models: usize = two.models.iter().enumerate().map(follows).sum();
            models + two.noise.iter().filter(|noise| noise.rises()).count()
        });
        let references = self.references.iter().filter(|weight| weight.follow > 1.0).count();
        let coloured = self.coloured.as_ref().map_or(0, |_| FILTER.0);
        n + self.outputs.nrows()
            + references
            + lags
            + self.delay_states(self.input_scale.len())
            + coloured
            + two
            + weights
    }

    /// Returns the model augmented by the coloured disturbance, and by the slope of the trim if that moves: `[A B G 0
    /// x0'; 0 0 0 0 u0'; 0 0 A_w B_w 0]`.
    fn augmented_model(&self, n: usize, m: usize) -> Lft {
        let trim = self.trim();
        let moved = trim.map_or(0, |_| m);
        let padded =
            |lft: &Lft, rows: usize| lft.stacked(&Lft::constant(Mat::zeros(rows, lft.constant.ncols())));
        let mut model = self.model.clone();
        if let Some(coloured) = &self.coloured {
            let (states, _) = FILTER;
            let mut below = Mat::zeros(n + moved + states, n + states);
            below.view_mut((0, 0), (n, n)).fill_with_identity();
            below.view_mut((n + moved, n), (states, states)).fill_with_identity();
            model = padded(&model, moved + states)
                .concatenated(&Lft::constant(below).multiply(coloured))
                .in_order();
        } else if moved > 0 {
            model = padded(&model, moved);
        }
        match trim {
            Some(trim) => {
                let rows = model.constant.nrows() - trim.slope.constant.nrows();
                model.concatenated(&padded(&trim.slope, rows)).in_order()
            }
            None => model,
        }
    }

    /// Rejects the first number, in the order of the fields, that is not allowed.
    fn check_numbers(&self) -> Result<(), SystemError> {
        let positive = |name, v: f64| (name, v, invertible(v), "finite and above 0");
        let not_negative = |name, v: f64| (name, v, v == 0.0 || invertible(v), "finite and at least 0");
        let mut checks = vec![];
        for (i, weight) in self.tracking.iter().enumerate() {
            checks.extend(weight.checks().map(|check| (i, check)));
        }
        checks.extend(self.output_scale.iter().map(|v| positive("the scale of output", *v)).enumerate());
        for (i, ReferenceWeight { follow, corner }) in self.references.iter().enumerate() {
            let good = *follow >= 1.0 && follow.is_finite();
            checks.push((i, ("the weight of slow references", *follow, good, "finite and at least 1")));
            checks.push((i, positive("the corner of the weight of the references", *corner)));
        }
        checks.extend(self.input_scale.iter().map(|v| positive("the scale of input", *v)).enumerate());
        checks.extend(self.lags.iter().map(|v| not_negative("the lag of input", *v)).enumerate());
        checks.push((0, not_negative("the delay before input", self.delay)));
        checks.extend(self.control.iter().map(|weight| weight.check("W_u of input")).enumerate());
        if let Some(two) = &self.two_degrees {
            checks.extend(two.noise.iter().map(|noise| noise.check("the noise of measurement")).enumerate());
            for (i, model) in two.models.iter().enumerate() {
                let (w, damping) = model.map_or((1.0, None), |model| (model.frequency, model.damping));
                checks.push((i, positive("the frequency of the reference model of output", w)));
                let damping = damping.unwrap_or(1.0);
                checks.push((i, positive("the damping of the reference model of output", damping)));
            }
            if let Some(MovingTrim { output, frequency, .. }) = two.trim {
                let name = "the frequency of the trim that moves with output";
                checks.push((output, positive(name, frequency)));
                let name = "the reference model (by its frequency) of output";
                let allowed = "of first order and as fast as the trim that moves with this output";
                let other = |m: &ReferenceModel| m.damping.is_some() || m.frequency != frequency;
                let model = two.models[output].filter(other);
                checks.extend(model.map(|model| (output, (name, model.frequency, false, allowed))));
            }
        }
        checks.push((
            0,
            ("the disturbance at input", self.disturbance, self.disturbance.is_finite(), "finite"),
        ));
        match checks.into_iter().find(|(_, (_, _, good, _))| !good) {
            Some((index, (name, found, _, allowed))) => {
                Err(SystemError::Number { name, index: index + 1, found, allowed })
            }
            None => Ok(()),
        }
    }

    fn check(&self, n: usize, m: usize, p: usize) -> Result<(), SystemError> {
        let lists: [(&'static str, usize, usize); 5] = [
            ("output_scale", self.output_scale.len(), p),
            ("references", self.references.len(), p),
            ("tracking weights", self.tracking.len(), p),
            ("control weights", self.control.len(), m),
            ("lags", self.lags.len(), m),
        ];
        for (name, found, expected) in lists {
            if found != expected {
                return Err(SystemError::Shape { name, found: (found, 1), expected: (expected, 1) });
            }
        }
        let mut shapes = vec![
            ("model [A B]", self.model.constant.shape(), (n, n + m)),
            ("outputs", self.outputs.shape(), (p, n)),
        ];
        if let Some(coloured) = &self.coloured {
            shapes.push((
                "coloured disturbance [G 0; A_w B_w]",
                coloured.constant.shape(),
                (n + FILTER.0, FILTER.0 + FILTER.1),
            ));
        }
        if let Some(TwoDegrees { measured, noise, models, trim }) = &self.two_degrees {
            shapes.push(("measured", measured.shape(), (noise.len(), n)));
            shapes.push(("reference models", (models.len(), 1), (p, 1)));
            if let Some(MovingTrim { slope, .. }) = trim {
                shapes.push(("slope of the trim", slope.constant.shape(), (n + m, 1)));
            }
        }
        match shapes.into_iter().find(|(_, found, expected)| found != expected) {
            Some((name, found, expected)) => Err(SystemError::Shape { name, found, expected }),
            None => Ok(()),
        }
    }
}

/// The states of the actuators of a plant under assembly.
struct Actuators {
    /// The inputs with a lag.
    lagged: Vec<usize>,
    first_lag: usize,
    lags: Signal,
    first_delay: usize,
    delays: Signal,
}

impl Actuators {
    /// Returns each state with its input.
    fn states(&self) -> impl Iterator<Item = (usize, usize)> {
        let lags = self.lagged.iter().enumerate().map(|(i, j)| (self.first_lag + i, *j));
        lags.chain((0..self.delays.nrows()).map(|j| (self.first_delay + j, j)))
    }
}

fn row(s: &Signal, i: usize) -> Signal {
    s.rows(i, 1).into_owned()
}

/// Returns C x + N n.
fn noisy_measurements(all: &mut Assembly, two: &TwoDegrees, x: &Signal, noise: &Signal) -> Signal {
    let mut measured = &two.measured * x;
    for (i, weight) in two.noise.iter().enumerate() {
        let noise = all.weighted(weight, &row(noise, i));
        let noisy = row(&measured, i) + noise;
        measured.rows_mut(i, 1).copy_from(&noisy);
    }
    measured
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::partition::Group::{U, W, Y, Z};
    use crate::system::polynomial::MatrixPolynomial;
    use nalgebra::{Complex, dmatrix};

    /// Returns a model with one state, one input and no parameter.
    fn problem() -> TrackingProblem {
        let none = |rows, columns| Mat::zeros(rows, columns);
        TrackingProblem {
            model: Lft {
                constant: dmatrix![-1.0, 1.0],
                left: none(1, 0),
                inner: none(0, 0),
                right: none(0, 2),
                channels: vec![],
            },
            outputs: dmatrix![1.0],
            output_scale: vec![1.0],
            references: vec![ReferenceWeight { follow: 1.0, corner: 1.0 }],
            input_scale: vec![1.0],
            tracking: vec![TrackingWeight { peak: 2.0, steady_error: 0.01, bandwidth: 0.46 }],
            lags: vec![0.0],
            delay: 0.0,
            control: vec![RisingWeight::constant(0.5)],
            disturbance: 0.1,
            coloured: None,
            two_degrees: None,
        }
    }

    #[test]
    fn an_improper_weight_is_rejected_by_name() {
        assert!(problem().augment().is_ok());
        type Spoil = fn(&mut TrackingProblem);
        let cases: [(Spoil, &str); 10] = [
            (|p| p.references[0].follow = 0.5, "the weight of slow references 1 is 0.5"),
            (|p| p.delay = -0.1, "the delay before input 1 is -0.1"),
            (|p| p.tracking[0].peak = 0.0, "the peak of W_e 1 is 0"),
            (|p| p.tracking[0].steady_error = 3.0, "the steady error of W_e 1 is 3"),
            (|p| p.tracking[0].bandwidth = f64::INFINITY, "the bandwidth of W_e 1 is inf"),
            (|p| p.output_scale[0] = 0.0, "the scale of output 1 is 0"),
            (|p| p.control[0].low = f64::NAN, "W_u of input 1 is NaN"),
            (|p| p.disturbance = f64::INFINITY, "the disturbance at input 1 is inf"),
            (|p| p.lags[0] = -0.1, "the lag of input 1 is -0.1"),
            (|p| p.control[0].high = 0.1, "W_u of input 1 is 0.5"),
        ];
        for (spoil, expected) in cases {
            let mut problem = problem();
            spoil(&mut problem);
            let message = problem.augment().unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    /// The open plant of `x' = -x + force` with a lag of 0.5 s, a delay of 0.2 s, a reference model and rising noise
    /// has the responses of its transfer functions.
    #[test]
    fn two_degrees_of_freedom_have_their_transfer_functions() {
        let noise = RisingWeight { low: 0.01, high: 2.0, corner: 3.0 };
        let model = ReferenceModel { frequency: 1.3, damping: Some(0.7) };
        let problem = TrackingProblem {
            references: vec![ReferenceWeight { follow: 6.0, corner: 0.4 }],
            lags: vec![0.5],
            delay: 0.2,
            control: vec![RisingWeight { low: 0.5, high: 4.0, corner: 10.0 }],
            two_degrees: Some(TwoDegrees {
                measured: dmatrix![2.0],
                noise: vec![noise],
                models: vec![Some(model)],
                trim: None,
            }),
            ..problem()
        };
        let plant = problem.augment().unwrap();
        let sizes = plant.sizes();
        assert_eq!((sizes.x, sizes.w, sizes.z, sizes.y, sizes.u), (9, 3, 2, 2, 1));
        let system = plant.parts.state_space(&[Z, Y], &[W, U]);
        for omega in [0.01, 0.7, 5.0, 80.0] {
            let s = Complex::new(0.0, omega);
            let g = system.response(s).unwrap();
            let weight = (s / 2.0 + 0.46) / (s + 0.0046);
            let zero = Complex::new(0.0, 0.0);
            let (plant, lag) = ((s + 1.0).inv(), (s * 0.5 + 1.0).inv() * (10.0 - s) / (s + 10.0));
            let slow = problem.references[0].response(omega);
            assert!((slow - (s + 2.4) / (s + 0.4)).norm() < 1e-12);
            let rising = |w: RisingWeight| s / (s + w.corner) * (w.high - w.low) + w.low;
            let expected = [
                [weight * model.response(omega) * slow, -weight * plant * 0.1, zero, -weight * plant * lag],
                [zero, zero, zero, rising(problem.control[0])],
                [slow, zero, zero, zero],
                [zero, plant * 0.2, rising(noise), plant * lag * 2.0],
            ];
            for (i, row) in expected.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    assert!((g[(i, j)] - entry).norm() < 1e-12 * (1.0 + entry.norm()), "{omega}: {i} {j}");
                }
            }
        }
    }

    /// The filter of the coloured disturbance and the slope of the trim depend on the parameter.
    #[test]
    fn a_coloured_disturbance_has_its_transfer_function() {
        let at = |theta: f64| {
            dmatrix![0.3 - 0.1 * theta, -0.2 + 0.4 * theta, 0.0;
            -0.2 - 0.1 * theta, -1.1 - 0.3 * theta, 0.2 + 0.1 * theta;
            1.1 + 0.3 * theta, 0.0, 0.0]
        };
        let affine = MatrixPolynomial { coefficients: vec![at(0.0), at(1.0) - at(0.0)] };
        let slope = Lft::parameter(0, 1.0, 0.5).stacked(&Lft::constant(dmatrix![0.5]));
        let with = |coloured| TrackingProblem {
            lags: vec![0.5],
            coloured: Some(coloured),
            two_degrees: Some(TwoDegrees {
                measured: dmatrix![2.0],
                noise: vec![RisingWeight::constant(0.1)],
                models: vec![None],
                trim: Some(MovingTrim { output: 0, frequency: 0.9, slope: slope.clone() }),
            }),
            ..problem()
        };
        let scheduled = with(Lft::from_polynomial(&affine, 1e-12));
        let plant = scheduled.augment().unwrap();
        let sizes = plant.sizes();
        assert_eq!((sizes.x, sizes.w, sizes.t), (6, 4, 4));
        assert_eq!(scheduled.model_position().unwrap().right.shape(), (1 + 1 + 2 + 1, sizes.x + sizes.w + 1));
        for theta in [-1.0, 0.4] {
            let system = plant.frozen(&[theta]).unwrap().parts.state_space(&[Z, Y], &[W, U]);
            let m = at(theta);
            for omega in [0.3, 1.1, 4.0] {
                let s = Complex::new(0.0, omega);
                let g = system.response(s).unwrap();
                let (b, w) = (0.5 * m[(1, 2)], m[(2, 0)]);
                let crest = s * (2.0 * b) / (s * s + s * (2.0 * b) + w * w);
                let moved = (crest * m[(0, 0)] + crest * w / s * m[(0, 1)]) / (s + 1.0);
                let weight = (s / 2.0 + 0.46) / (s + 0.0046);
                assert!((g[(0, 3)] + weight * moved).norm() < 1e-12);
                assert!((g[(3, 3)] - moved * 2.0).norm() < 1e-12);
            }
        }
        let error = with(Lft::constant(Mat::zeros(2, 3))).augment().unwrap_err();
        assert!(matches!(error, SystemError::Shape { found: (2, 3), .. }), "{error}");
    }

    #[test]
    fn a_trim_follows_a_model_of_first_order() {
        let slope = Lft::constant(dmatrix![1.0; 0.5]);
        let with = |model| TrackingProblem {
            two_degrees: Some(TwoDegrees {
                measured: dmatrix![1.0],
                noise: vec![RisingWeight::constant(0.1)],
                models: vec![model],
                trim: Some(MovingTrim { output: 0, frequency: 0.9, slope: slope.clone() }),
            }),
            ..problem()
        };
        let model = |frequency, damping| Some(ReferenceModel { frequency, damping });
        let followed = with(model(0.9, None)).augment().unwrap();
        for (frequency, damping) in [(0.9, Some(0.9)), (0.8, None)] {
            let message = with(model(frequency, damping)).augment().unwrap_err().to_string();
            let expected =
                format!("the reference model (by its frequency) of output 1 is {frequency}; it must be");
            assert!(message.starts_with(&expected), "{message}");
        }
        // Without a model the error is that of the reference itself: larger by `(1 - 0.9/(s + 0.9)) r`.
        let itself = with(None).augment().unwrap();
        let response =
            |plant: &GeneralisedPlant, s| plant.parts.state_space(&[Z, Y], &[W, U]).response(s).unwrap();
        for omega in [0.02, 0.6, 7.0] {
            let s = Complex::new(0.0, omega);
            let mut difference = response(&itself, s) - response(&followed, s);
            difference[(0, 0)] -= (s / 2.0 + 0.46) / (s + 0.0046) * s / (s + 0.9);
            assert!(difference.norm() < 1e-12, "{omega}: {difference}");
        }
    }
}
