//! Cost of lights with a size: the products of discs with each other and with the map, under a kernel of shadows.
//!
//! The coordinates of a disc are two along the tangents of its direction, and the logarithm of its radius a. Kernels take
//! `A = sin^2(a/2)` instead.

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::target::Target;
use crate::kernels::expansion::DiscSum;
use crate::kernels::fit::jet::Jet;
use crate::kernels::fit::light_disc::Disc;
use crate::kernels::fit::objective::{
    Constraint, Derivatives, Moments, Objective, Reference, column_weights,
};
use crate::kernels::fit::settings::DISCS;
use crate::kernels::fit::state::State;
use crate::kernels::sphere::exponential_map;

/// The cost of discs under a map.
#[derive(Debug)]
pub struct Shadows<'a> {
    target: &'a Target,
    reference: Reference,
    /// The greatest radius of any light, in radians.
    greatest_radius: f64,
}

impl<'a> Shadows<'a> {
    /// The objective for the channels and the ambient term of a search for points.
    pub fn new(target: &'a Target, reference: &Reference) -> Self {
        let energy: f64 = (0..reference.channels.len())
            .map(|c| reference.copies(c) * target.energy[reference.channels[c]])
            .sum();
        let reference = Reference { energy: (1.0 + DISCS.noise) * energy, ..reference.clone() };
        Self { target, reference, greatest_radius: DISCS.greatest }
    }

    /// This objective for lights of at most this radius.
    pub fn up_to(self, greatest_radius: f64) -> Self {
        Self { greatest_radius, ..self }
    }

    /// True if the bound of all radii holds the radius of a disc.
    pub fn is_at_bound(&self, disc: &Disc) -> bool {
        disc.radius >= self.greatest_radius.max(DISCS.least)
    }

    /// The best fluxes of `discs`.
    pub fn state(&self, discs: Vec<Disc>) -> State {
        State::at(self, self.moments(discs), 0, &[])
    }

    /// Products of discs of flux 1 with the map.
    pub fn with_map(&self, discs: &[Disc]) -> Vec<DiscSum> {
        self.target.values(discs)
    }

    /// Decrease of the cost that each of some discs, alone, adds to a state whose other radiances stay.
    ///
    /// Their `products` with the map are those of [`Self::with_map`].
    pub fn decreases(&self, candidates: &[Disc], products: &[DiscSum], state: &State) -> Vec<f64> {
        let sides = candidates.iter().zip(products);
        self.target.falls(&self.reference, sides, &state.moments.discs, &state.x)
    }

    /// Disc of this direction, with its radius clamped to the allowed range.
    pub fn disc(&self, direction: DVec3, radius: f64) -> Disc {
        Disc::new(direction, radius.clamp(DISCS.least, self.greatest_radius(direction)))
    }

    /// The greatest radius of a light in a direction: over a floor, the whole disc is above the horizon.
    fn greatest_radius(&self, direction: DVec3) -> f64 {
        let elevation = direction.y.clamp(0.0, 1.0).asin();
        let most = self.greatest_radius;
        (if self.reference.has_floor { most.min(elevation) } else { most }).max(DISCS.least)
    }

    fn moments(&self, discs: Vec<Disc>) -> Moments {
        let (gram, rgb) = self.target.products(&discs);
        let channels = &self.reference.channels;
        let rhs = DMatrix::from_fn(rgb.nrows(), channels.len(), |i, c| rgb[(i, channels[c])]);
        let directions = discs.iter().map(|disc| disc.direction).collect();
        Moments { directions, gram, rhs, discs, sides: Vec::new(), pairs: Vec::new(), visible: Vec::new() }
    }

    /// The disc after a step in its three coordinates.
    fn step_disc(&self, disc: &Disc, step: &[f64; 3]) -> Disc {
        let [s, t] = disc.frame();
        let direction = exponential_map(disc.direction, s * step[0] + t * step[1]);
        let is_below = self.reference.has_floor && direction.y < 0.0;
        let direction = if is_below { direction.with_y(0.0).normalize_or(DVec3::X) } else { direction };
        self.disc(direction, disc.radius * step[2].exp())
    }
}

impl Objective for Shadows<'_> {
    fn reference(&self) -> &Reference {
        &self.reference
    }

    fn coordinates(&self) -> usize {
        3
    }

    fn after_step(&self, before: &Moments, step: &[f64]) -> Moments {
        let moved = before.discs.iter().zip(step.as_chunks::<3>().0);
        self.moments(moved.map(|(disc, step)| self.step_disc(disc, step)).collect())
    }

    fn subset(&self, before: &Moments, kept: &[usize]) -> Moments {
        self.moments(kept.iter().map(|&light| before.discs[light]).collect())
    }

    fn derivatives(&self, Moments { discs, .. }: &Moments, x: &DMatrix<f64>, _: bool) -> Derivatives {
        let mut sums = Sums::new(&self.reference, discs, x);
        sums.add_map(self.target, discs, x);
        for (j, disc) in discs.iter().enumerate() {
            sums.add_ambient(self.target, disc, j);
            sums.add_square(self.target, disc, j);
            for (k, other) in discs[..j].iter().enumerate() {
                sums.add_pair(&DiscPair::new(&self.target.pair(disc, other), disc, other), j, k);
            }
        }
        Derivatives { second: Some(sums.second), ..sums.first }
    }

    /// Radii at a bound; over a floor, that of a disc that touches the horizon follows its polar angle.
    fn bounds(&self, moments: &Moments, gradient: &[f64], fixed: usize) -> Vec<Constraint> {
        let bound = |(light, disc): (usize, &Disc)| {
            let slope = gradient[3 * light + 2];
            let is_least = disc.radius <= DISCS.least && slope >= 0.0;
            let is_greatest = disc.radius >= self.greatest_radius(disc.direction) && slope <= 0.0;
            if is_greatest && !self.is_at_bound(disc) && light >= fixed {
                // The first tangent points to growing polar angles.
                return Some(Constraint {
                    light,
                    across: DVec3::new(1.0 / disc.radius, 0.0, 1.0),
                    ahead: 0.0,
                });
            }
            (is_least || is_greatest).then(|| Constraint::hold(light, 2))
        };
        moments.discs.iter().enumerate().filter_map(bound).collect()
    }
}

/// Derivatives by the coordinates of all discs.
struct Sums<'a> {
    reference: &'a Reference,
    first: Derivatives,
    second: Vec<DMat3>,
    /// Weight of the product of two columns.
    weights: DMatrix<f64>,
}

impl<'a> Sums<'a> {
    fn new(reference: &'a Reference, discs: &[Disc], x: &DMatrix<f64>) -> Self {
        let first = Derivatives::zeros(reference, discs.len(), 3);
        Self {
            reference,
            first,
            second: vec![DMat3::ZERO; discs.len()],
            weights: column_weights(reference, x),
        }
    }

    fn column(&self, light: usize) -> usize {
        self.reference.ambient.coefficients() + light
    }

    /// Products with the map.
    fn add_map(&mut self, target: &Target, discs: &[Disc], x: &DMatrix<f64>) {
        let weights = |light: usize| {
            let mut weights = [0.0; 3];
            for (c, &channel) in self.reference.channels.iter().enumerate() {
                weights[channel] = self.reference.copies(c) * x[(self.column(light), c)];
            }
            weights
        };
        let weights: Vec<[f64; 3]> = (0..discs.len()).map(weights).collect();
        for (j, sum) in target.sides_around(discs, &weights).iter().enumerate() {
            let first = sum.first.map(|by_channel| (0..3).map(|c| weights[j][c] * by_channel[c]).sum());
            let by_radius = radius_derivatives(&discs[j]);
            self.second[j] -= by_logarithm(Jet { value: 0.0, first, second: sum.second }, by_radius).1;
            for i in 0..3 {
                let scale = if i == 2 { by_radius[0] } else { 1.0 };
                for (c, &channel) in self.reference.channels.iter().enumerate() {
                    self.first.rhs[(3 * j + i, c)] = scale * sum.first[i][channel];
                }
            }
        }
    }

    /// Products of a disc with the ambient columns.
    fn add_ambient(&mut self, target: &Target, disc: &Disc, j: usize) {
        for (column, product) in target.with_ambient(disc).into_iter().enumerate() {
            let (first, second) = by_logarithm(product, radius_derivatives(disc));
            let weight = self.weights[(self.column(j), column)];
            (0..3).for_each(|i| self.first.model[(3 * j + i, column)] = first[i]);
            self.second[j] += second * weight;
        }
    }

    /// The product of a disc with itself: its derivative is twice that by one of the two.
    fn add_square(&mut self, target: &Target, disc: &Disc, j: usize) {
        let (square, [slope, bend]) = (target.square(disc), radius_derivatives(disc));
        let own = self.column(j);
        self.first.model[(3 * j + 2, own)] = 0.5 * square.first[0] * slope;
        let second = square.second[0][0] * slope * slope + square.first[0] * bend;
        self.second[j].z_axis.z += 0.5 * second * self.weights[(own, own)];
    }

    /// The product of the discs j and k.
    fn add_pair(&mut self, pair: &DiscPair, j: usize, k: usize) {
        let weight = self.weights[(self.column(j), self.column(k))];
        for (light, other, side) in [(j, k, 0), (k, j, 1)] {
            let column = self.column(other);
            (0..3).for_each(|i| self.first.model[(3 * light + i, column)] = pair.first[side][i]);
            self.second[light] += DMat3::from_cols_array_2d(&pair.own[side]) * weight;
        }
        for i in 0..3 {
            for n in 0..3 {
                self.first.gram[(3 * j + i, 3 * k + n)] = pair.mixed[i][n];
                self.first.gram[(3 * k + n, 3 * j + i)] = pair.mixed[i][n];
            }
        }
    }
}

/// First and second derivative of `A = sin^2(a/2)` by the logarithm of a.
fn radius_derivatives(disc: &Disc) -> [f64; 2] {
    let (sine, cosine) = disc.radius.sin_cos();
    let slope = 0.5 * disc.radius * sine;
    [slope, slope + 0.5 * disc.radius * disc.radius * cosine]
}

/// Derivatives of a product by the coordinates of a disc, from those by its tangents and A.
fn by_logarithm(product: Jet<3>, [slope, bend]: [f64; 2]) -> ([f64; 3], DMat3) {
    let Jet { mut first, mut second, .. } = product;
    for row in &mut second {
        row[2] *= slope;
    }
    second[2] = second[2].map(|derivative| derivative * slope);
    second[2][2] += first[2] * bend;
    first[2] *= slope;
    (first, DMat3::from_cols_array_2d(&second))
}

/// A product of two discs by the coordinates of both.
struct DiscPair {
    first: [[f64; 3]; 2],
    own: [[[f64; 3]; 3]; 2],
    mixed: [[f64; 3]; 3],
}

impl DiscPair {
    /// From its derivatives by the cosine between them and by the A of each. Along a tangent t of the one, the cosine
    /// changes by `t.other`, and by `-cosine / 2` to second order; along tangents of both, by their product.
    fn new(product: &Jet<3>, one: &Disc, other: &Disc) -> Self {
        let cosine = one.direction.dot(other.direction);
        let along = [(one, other), (other, one)].map(|(a, b)| a.frame().map(|t| t.dot(b.direction)));
        // Of each disc, by its coordinates: the cosine and its A.
        let radius = [one, other].map(radius_derivatives);
        let slopes = [0, 1].map(|m| [[along[m][0], 0.0], [along[m][1], 0.0], [0.0, radius[m][0]]]);
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
        for (m, own) in own.iter_mut().enumerate() {
            own[2][2] += product.first[variable[m][1]] * radius[m][1];
        }
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
