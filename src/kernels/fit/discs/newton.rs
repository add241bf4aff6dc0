//! The cost around a state, to second order in the coordinates of its discs: two along the tangents, and the logarithm
//! of the radius.
//!
//! With the best fluxes x for every place (variable projection: Golub and Pereyra 1973), the products b of the columns
//! with the map and G with each other, half the gradient and half the second derivative are, summed over channels,
//!
//! ```text
//!   g_i  = -x_j db_ij + sum_k x_j x_k dG_ijk                        j: the light of coordinate i
//!   H_ii' = second derivatives of  x^T G x / 2 - x^T b  for fixed x, less  T G^-1 T^T
//!   T_ik = x_j dG_ijk   and   (-db_i + sum_k x_k dG_ijk) in the column of j itself
//! ```

use std::f64::consts::PI;
use std::ops::AddAssign;

use nalgebra::{DMatrix, DVector};

use super::disc::Disc;
use super::jet::Jet;
use super::state::{GREATEST_RADIUS, LEAST_RADIUS, Problem, State};

/// `cost + 2 gradient.t + t^T hessian t`.
#[derive(Clone, Debug)]
pub struct Quadratic {
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
    /// Coordinates that a bound or the caller holds.
    held: Vec<bool>,
    /// Discs that touch the horizon of a floor: their radius is their elevation.
    touching: Vec<Touching>,
}

/// A radius, in the coordinate `radius`, that follows the polar angle in the coordinate before, by this `slope`.
#[derive(Clone, Copy, Debug)]
struct Touching {
    radius: usize,
    slope: f64,
}

impl Quadratic {
    pub fn around(problem: &Problem<'_>, state: &State) -> Self {
        let given = problem.given;
        let (ambient, channels) = (given.ambient.coefficients(), given.channels.len());
        let (lights, columns) = (state.discs.len(), state.x.nrows());
        let x = |light: usize, channel: usize| state.x[(ambient + light, channel)];
        // Sums over channels of the fluxes of two columns.
        let copies = DVector::from_fn(channels, |c, _| given.copies(c));
        let weighted = DMatrix::from_fn(columns, channels, |i, c| state.x[(i, c)] * copies[c]);
        let both = &weighted * state.x.transpose();
        let mut hessian = DMatrix::zeros(3 * lights, 3 * lights);
        let mut gradient = DVector::zeros(3 * lights);
        // Derivatives of the products with each column of the model, and of what is left of each channel.
        let mut model = DMatrix::zeros(3 * lights, columns);
        let mut left = DMatrix::zeros(3 * lights, channels);
        let mut add = |left: &mut DMatrix<f64>, j: usize, column: usize, first: &[f64; 3]| {
            for i in 0..3 {
                model[(3 * j + i, column)] += first[i];
                (0..channels).for_each(|c| left[(3 * j + i, c)] += first[i] * state.x[(column, c)]);
            }
        };
        let mut bend = |j: usize, k: usize, second: &[[f64; 3]; 3], weight: f64| {
            for i in 0..3 {
                (0..3).for_each(|n| hessian[(3 * j + i, 3 * k + n)] += weight * second[i][n]);
            }
        };
        let shares: Vec<[f64; 3]> = (0..lights)
            .map(|j| {
                let mut shares = [0.0; 3];
                (0..channels).for_each(|c| shares[given.channels[c]] = weighted[(ambient + j, c)]);
                shares
            })
            .collect();
        let sides = problem.target.sides_around(&state.discs, &shares);
        for (j, (disc, sides)) in state.discs.iter().zip(&sides).enumerate() {
            let own = ambient + j;
            for i in 0..3 {
                (0..channels).for_each(|c| left[(3 * j + i, c)] -= sides.first[i][given.channels[c]]);
            }
            bend(j, j, &sides.second, -1.0);
            for (column, product) in problem.target.with_ambient(disc).iter().enumerate() {
                add(&mut left, j, column, &product.first);
                bend(j, j, &product.second, both[(own, column)]);
            }
            // The square counts half: its slope is twice what one of the two discs adds.
            let square = problem.target.square(disc);
            add(&mut left, j, own, &[0.0, 0.0, 0.5 * square.first[0]]);
            let mut second = [[0.0; 3]; 3];
            second[2][2] = 0.5 * square.second[0][0];
            bend(j, j, &second, both[(own, own)]);
            for (k, other) in state.discs[..j].iter().enumerate() {
                let product = Pair::new(&problem.target.pair(disc, other), disc, other);
                add(&mut left, j, ambient + k, &product.first[0]);
                add(&mut left, k, own, &product.first[1]);
                let weight = both[(own, ambient + k)];
                bend(j, j, &product.own[0], weight);
                bend(k, k, &product.own[1], weight);
                bend(j, k, &product.mixed, weight);
            }
        }
        // Mixed derivatives stand below the diagonal so far.
        for i in 0..3 * lights {
            (0..i - i % 3).for_each(|k| hessian[(k, i)] = hessian[(i, k)]);
        }
        for (channel, support) in state.supports.iter().enumerate() {
            let mut products = model.clone();
            for (i, mut row) in products.row_iter_mut().enumerate() {
                let light = i / 3;
                gradient[i] += copies[channel] * x(light, channel) * left[(i, channel)];
                row *= x(light, channel);
                row[ambient + light] += left[(i, channel)];
            }
            let used = products.select_columns(&support.columns);
            let inside = support.orthonormal(used);
            hessian.gemm(-copies[channel], &inside, &inside.transpose(), 1.0);
        }
        let held = vec![false; 3 * lights];
        let mut quadratic = Self { gradient, hessian, held, touching: Vec::new() };
        quadratic.use_logarithms(&state.discs);
        quadratic.hold(problem, &state.discs);
        quadratic
    }

    /// From A = sin^2(a/2) to the logarithm of a: `dA = a sin(a) / 2`.
    fn use_logarithms(&mut self, discs: &[Disc]) {
        for (j, disc) in discs.iter().enumerate() {
            let (i, (sine, cosine)) = (3 * j + 2, disc.radius.sin_cos());
            let slope = 0.5 * disc.radius * sine;
            let bend = slope + 0.5 * disc.radius * disc.radius * cosine;
            self.hessian.row_mut(i).scale_mut(slope);
            self.hessian.column_mut(i).scale_mut(slope);
            self.hessian[(i, i)] += self.gradient[i] * bend;
            self.gradient[i] *= slope;
        }
    }

    /// Hold what may not move: directions of fixed lights, and radii at a bound that they press against.
    fn hold(&mut self, problem: &Problem<'_>, discs: &[Disc]) {
        for (j, disc) in discs.iter().enumerate() {
            let (radius, is_fixed) = (3 * j + 2, j < problem.fixed);
            let slope = self.gradient[radius];
            let is_least = disc.radius <= LEAST_RADIUS && slope >= 0.0;
            let is_greatest = disc.radius >= problem.greatest_radius(disc.direction) && slope <= 0.0;
            self.held[radius] = is_least || is_greatest;
            (self.held[3 * j], self.held[3 * j + 1]) = (is_fixed, is_fixed);
            if is_greatest && disc.radius < GREATEST_RADIUS && !is_fixed {
                self.touch(Touching { radius, slope: -1.0 / disc.radius });
            }
        }
    }

    /// Let the polar angle take the radius with it.
    fn touch(&mut self, touching: Touching) {
        let Touching { radius, slope } = touching;
        let angle = radius - 2;
        let row = self.hessian.row(radius) * slope;
        self.hessian.row_mut(angle).add_assign(&row);
        let column = self.hessian.column(radius) * slope;
        self.hessian.column_mut(angle).add_assign(&column);
        self.gradient[angle] += slope * self.gradient[radius];
        self.touching.push(touching);
    }

    /// What the cost falls by with `step`.
    pub fn fall(&self, step: &DVector<f64>) -> f64 {
        let mut step = step.clone();
        // What a radius adds that follows its polar angle is in the slopes of that already.
        self.touching.iter().for_each(|touching| step[touching.radius] = 0.0);
        -(2.0 * self.gradient.dot(&step) + step.dot(&(&self.hessian * &step)))
    }

    /// How far each light may be turned before the cost has grown by `growth`, all else fitted anew, in radians: 0
    /// where it is held, pi where nothing holds it.
    pub fn tolerances(&self, growth: f64) -> Vec<f64> {
        let (hessian, _) = self.free();
        let lights = 0..hessian.nrows() / 3;
        let Some(factor) = hessian.cholesky() else { return vec![PI; lights.len()] };
        let inverse = factor.inverse();
        let tolerance = |light: usize| {
            let own = inverse.view((3 * light, 3 * light), (2, 2)).into_owned();
            (growth * own.symmetric_eigenvalues().max()).sqrt().min(PI)
        };
        lights.map(|light| if self.held[3 * light] { 0.0 } else { tolerance(light) }).collect()
    }

    /// Hessian and gradient, of which the held coordinates know nothing.
    fn free(&self) -> (DMatrix<f64>, DVector<f64>) {
        let (mut hessian, mut gradient) = (self.hessian.clone(), self.gradient.clone());
        for i in (0..gradient.len()).filter(|&i| self.held[i]) {
            hessian.row_mut(i).fill(0.0);
            hessian.column_mut(i).fill(0.0);
            (hessian[(i, i)], gradient[i]) = (1.0, 0.0);
        }
        (hessian, gradient)
    }

    /// `(H + damping D) step = -gradient` (Levenberg 1944, Marquardt 1963), where D holds the curvature of each
    /// coordinate. Where H bends down, it counts with the size of each eigenvalue over D instead (Nocedal and Wright
    /// 2006, section 3.4): that leads along valleys which are bent downwards as fast as along others.
    pub fn step(&self, damping: f64) -> Option<DVector<f64>> {
        /// The least curvature that damping assumes, over the greatest. A weak light beside a sun has little. With 1e-4
        /// it hardly moved: of 168 fits of real maps six ended 6 to 28 % above those with 1e-6, two 1 and 6 % below.
        const FLATTEST: f64 = 1e-6;
        let scale = self.hessian.diagonal().abs();
        let highest = scale.max();
        if highest <= 0.0 {
            return None;
        }
        let (hessian, gradient) = self.free();
        let scale = DVector::from_fn(scale.len(), |i, _| {
            if self.held[i] { 1.0 } else { scale[i].max(FLATTEST * highest).sqrt() }
        });
        let scaled =
            DMatrix::from_fn(scale.len(), scale.len(), |i, k| hessian[(i, k)] / (scale[i] * scale[k]));
        let mut step = down(scaled, damping, &gradient.component_div(&scale));
        step.component_div_assign(&scale);
        // Rounding must not free what is held.
        (0..step.len()).filter(|&i| self.held[i]).for_each(|i| step[i] = 0.0);
        self.touching.iter().for_each(|Touching { radius, slope }| step[*radius] = slope * step[radius - 2]);
        Some(step)
    }
}

/// The step down against a `gradient`: each eigenvalue counts with its size plus `damping`. Cholesky does the same
/// sooner where the undamped Hessian has none below 0; the two ways meet at 0.
fn down(hessian: DMatrix<f64>, damping: f64, gradient: &DVector<f64>) -> DVector<f64> {
    if hessian.clone().cholesky().is_some() {
        let damped = &hessian + DMatrix::from_diagonal_element(gradient.len(), gradient.len(), damping);
        if let Some(factor) = damped.cholesky() {
            return -factor.solve(gradient);
        }
    }
    let eigen = hessian.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(gradient);
    let sizes = eigen.eigenvalues.map(|value| value.abs() + damping);
    -(&eigen.eigenvectors * along.component_div(&sizes))
}

/// A product of two discs by the coordinates of both.
struct Pair {
    first: [[f64; 3]; 2],
    own: [[[f64; 3]; 3]; 2],
    mixed: [[f64; 3]; 3],
}

impl Pair {
    /// From its derivatives by the cosine between them and by the A of each. Along a tangent t of the one, the cosine
    /// changes by `t.other`, and by `-cosine / 2` to second order; along tangents of both, by their product.
    fn new(product: &Jet<3>, one: &Disc, other: &Disc) -> Self {
        let cosine = one.direction.dot(other.direction);
        let along = [(one, other), (other, one)].map(|(a, b)| a.frame().map(|t| t.dot(b.direction)));
        // Of each disc, by its coordinates: the cosine and its A.
        let slopes = [0, 1].map(|disc| [[along[disc][0], 0.0], [along[disc][1], 0.0], [0.0, 1.0]]);
        let variable = [[0, 1], [0, 2]];
        let second = |m: usize, n: usize, i: usize, k: usize| {
            let mut sum = 0.0;
            for (a, slope) in slopes[m][i].iter().enumerate() {
                for (b, other) in slopes[n][k].iter().enumerate() {
                    sum += slope * other * product.second[variable[m][a]][variable[n][b]];
                }
            }
            sum
        };
        let square = |m: usize, n: usize| [0, 1, 2].map(|i| [0, 1, 2].map(|k| second(m, n, i, k)));
        let mut own = [square(0, 0), square(1, 1)];
        let mut mixed = square(0, 1);
        for i in 0..2 {
            for own in &mut own {
                own[i][i] -= product.first[0] * cosine;
            }
            (0..2).for_each(|k| mixed[i][k] += product.first[0] * one.frame()[i].dot(other.frame()[k]));
        }
        let first = [0, 1].map(|m| {
            [0, 1, 2]
                .map(|i| slopes[m][i][0] * product.first[0] + slopes[m][i][1] * product.first[variable[m][1]])
        });
        Self { first, own, mixed }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::expansion::Expansion;
    use crate::kernels::fit::Sphere;
    use crate::kernels::fit::ambient::Ambient;
    use crate::kernels::fit::discs::target::{Picture, Target};
    use crate::kernels::fit::discs::zonal::Comparison;
    use crate::kernels::fit::objective::Objective;
    use crate::kernels::image;
    use crate::kernels::sphere::{Registration, direction};
    use ndarray::Array3;

    /// Two broad lights and a hot pixel in a coloured sky.
    fn world() -> Array3<f32> {
        Array3::from_shape_fn((64, 128, 3), |(y, x, c)| {
            let near = |row: f64, column: f64, width: f64| {
                (-((y as f64 - row).powi(2) + (x as f64 - column).powi(2)) / (width * width)).exp()
            };
            let hot = if (y, x) == (20, 37) { 900.0 } else { 0.0 };
            (0.3 + 0.1 * c as f64 + 5.0 * near(18.0, 90.0, 9.0) + 3.0 * near(40.0, 30.0, 14.0) + hot) as f32
        })
    }

    /// Where the hessian bends down, a held coordinate must not take what rounding leaves, for its scale is not that of
    /// the map: a radius would come off its bound under one map, and not under the same one brighter.
    #[test]
    fn a_brighter_map_has_the_same_steps_to_the_bit() {
        let steps = |scale: f32| {
            let map = world() * scale;
            let map = image::reduce(map.view(), Registration::CellCentred, 256, 2e-3, false).unwrap();
            let sphere = Sphere::new(&map, Ambient::Constant, false);
            let target = Target::new(
                &Picture::new(&map, &Expansion::new(&map)),
                Comparison::Mixed,
                Ambient::Constant,
                false,
            );
            let problem = Problem { target: &target, given: sphere.given(), fixed: 0, max_steps: 10 };
            let of_turned = |turn: i32| {
                let turn = 0.8 * f64::from(turn);
                let discs =
                    [(1.0, 1.8, 0.3), (0.8, 4.4 + turn, 0.1), (1.1, 2.5 + turn, 1.0), (2.0, turn, 0.5)];
                let discs = discs.map(|(theta, phi, radius)| problem.disc(direction(theta, phi), radius));
                let mut model = Quadratic::around(&problem, &State::new(&problem, discs.to_vec(), &[]));
                (model.held[5], model.held[7]) = (true, true);
                (model.step(1e-4).unwrap(), model.free().0.symmetric_eigenvalues().min() < 0.0)
            };
            (0..8).map(of_turned).collect::<Vec<_>>()
        };
        let wanted = steps(1.0);
        assert!(wanted.iter().filter(|(_, bends)| *bends).count() > 2);
        assert!(wanted.iter().all(|(step, _)| step[5] == 0.0 && step[7] == 0.0));
        assert_eq!(wanted, steps(32.0));
    }

    /// Every slope and every curvature of the cost with the best fluxes, of lights that all channels use.
    #[test]
    fn the_quadratic_is_that_of_the_cost() {
        let map = world();
        let map = image::reduce(map.view(), Registration::CellCentred, 256, 2e-3, false).unwrap();
        assert!(!map.parts.is_empty());
        for (ambient, has_floor) in [
            (Ambient::None, false),
            (Ambient::Constant, false),
            (Ambient::Constant, true),
            (Ambient::Sh2, false),
        ] {
            for comparison in [Comparison::Probe, Comparison::Shadows, Comparison::Mixed] {
                let sphere = Sphere::new(&map, ambient, has_floor);
                let target =
                    Target::new(&Picture::new(&map, &Expansion::new(&map)), comparison, ambient, has_floor);
                let problem = Problem { target: &target, given: sphere.given(), fixed: 0, max_steps: 10 };
                let discs = [(1.0, 1.8, 0.05), (0.8, 4.4, 0.3), (1.1, 2.5, 0.4)];
                let discs = discs.map(|(theta, phi, radius)| problem.disc(direction(theta, phi), radius));
                assert_slopes_are_measured(&problem, &State::new(&problem, discs.to_vec(), &[]));
            }
        }
    }

    fn assert_slopes_are_measured(problem: &Problem<'_>, state: &State) {
        const STEP: f64 = 1e-3;
        let model = Quadratic::around(problem, state);
        let size = model.gradient.len();
        let cost = |moves: &[(usize, f64)]| {
            let mut step = vec![0.0; size];
            for (i, by) in moves {
                step[*i] += by;
            }
            state.moved(problem, &step).cost
        };
        let scale = model.hessian.amax();
        for i in 0..size {
            let slope = (cost(&[(i, STEP)]) - cost(&[(i, -STEP)])) / (2.0 * STEP);
            let error = (slope - 2.0 * model.gradient[i]).abs();
            assert!(error < 1e-4 * scale, "{i}: {slope} {}", 2.0 * model.gradient[i]);
            for k in 0..size {
                let corner = |a: f64, b: f64| cost(&[(i, a * STEP), (k, b * STEP)]);
                let corners = corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0);
                let bend = corners / (4.0 * STEP * STEP);
                let error = (bend - 2.0 * model.hessian[(i, k)]).abs();
                assert!(error < 3e-3 * scale, "{i} {k}: {bend} {}", 2.0 * model.hessian[(i, k)]);
            }
        }
    }
}
