//! The objective over the whole sphere of normals: the probe under a map, and lights beside it.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;
use pulp::{Arch, Scalar, Simd, WithSimd};

use super::ambient_columns::AmbientColumns;
use super::field::{Field, HIGHEST};
use super::kernel::{Block, LINEAR, outer, second_derivative, spectrum};
use super::lights::{DerivativeProducts, LightProducts};
use super::points::Points;
use crate::kernels::expansion::{DEGREES, Harmonics, PointLight, bright_cells};
use crate::kernels::fit::ambient::Ambient;
use crate::kernels::fit::objective::{
    Constraint, Derivatives, Moments, Objective, PointObjective, Reference, column_weights,
    distinct_channels, turn_by,
};
use crate::kernels::fit::picture::Picture;
use crate::kernels::image::WorkingMap;
use crate::kernels::lanes::LANES;
use crate::kernels::sphere::tangents;

/// The probe under a map, at every normal.
#[derive(Clone, Debug)]
pub struct Sphere {
    pub(super) reference: Reference,
    columns: AmbientColumns,
    points: Points,
    /// Directions of the points, brightest first.
    pub(super) likely: Vec<DVec3>,
    /// `integral of L w dw` of the map without the points, by channel.
    first: [DVec3; 3],
    /// The even part of F under the map without the points.
    pub(super) field: Field,
    /// Widest vectors of this processor.
    pub(super) widest: Arch,
}

impl Sphere {
    /// Expand `map`, to be fitted by lights and an `ambient` term. A floor has no light below the horizon.
    pub fn new(map: &WorkingMap, ambient: Ambient, has_floor: bool) -> Self {
        Self::of(map, &Picture::new(map), ambient, has_floor)
    }

    /// Prepare the fit of a map whose picture is known.
    pub fn of(map: &WorkingMap, picture: &Picture, ambient: Ambient, has_floor: bool) -> Self {
        let (points, others, missing) = Points::of_sources(map);
        let mut rest = picture.cells.clone();
        rest.add_discs(others.iter().chain(&bright_cells(map)).map(PointLight::disc));
        (0..3).for_each(|channel| rest.add_first(channel, missing[channel]));
        let kernel = even_factors();
        let field =
            Field::new(&rest.scaled_sum(&kernel, &Harmonics::zero(), &[0.0; DEGREES]), rest.azimuth());
        let columns = AmbientColumns::new(ambient, has_floor);
        let reference = Reference::nothing(ambient, has_floor);
        let likely = points.iter().map(|point| point.direction).collect();
        let (first, widest) = ([0, 1, 2].map(|channel| rest.moments(channel).1), Arch::new());
        let mut sphere =
            Self { reference, columns, points: Points::new(&points), likely, first, field, widest };
        sphere.reference = sphere.fixed_part(&rest, &points);
        sphere
    }

    /// The part of the cost that lights do not change.
    fn fixed_part(&self, rest: &Harmonics, points: &[PointLight]) -> Reference {
        let moments = [0, 1, 2].map(|channel| moments(rest, points, channel));
        let smooth = rest.product(rest, &even_factors());
        let energy = [0, 1, 2].map(|channel| self.energy(smooth[channel], points, channel));
        let are_same = |a: usize, b: usize| {
            let is_same = |point: &PointLight| point.irradiance[a].to_bits() == point.irradiance[b].to_bits();
            rest.has_equal_channels(a, b) && points.iter().all(is_same)
        };
        let (used, like) = distinct_channels(|channel| moments[channel].0 == 0.0, are_same);
        let ambient = self.columns.ambient.coefficients();
        let ambient_products =
            DMatrix::from_fn(ambient, ambient + used.len(), |i, side| match side.checked_sub(ambient) {
                None => self.columns.gram(i, side),
                Some(channel) => {
                    let (_, first, second) = moments[used[channel]];
                    self.columns.probe(i, first, second)
                }
            });
        let energy = energy.iter().sum();
        Reference { channels: used, like, ambient_products, energy, ..self.reference.clone() }
    }

    /// `<E, E>` of a channel, where the `even` degrees of the map without the points have this product.
    fn energy(&self, even: f64, points: &[PointLight], channel: usize) -> f64 {
        let smooth = even + LINEAR * self.first[channel].length_squared();
        points.iter().fold(smooth, |sum, point| {
            let l = point.direction;
            let twice = 2.0 * self.rest_at(l)[channel] + self.points.gradient(Scalar::new(), l)[channel];
            sum + point.irradiance[channel] * twice.dot(l)
        })
    }

    /// The gradient of F under the map without the points, by channel.
    #[inline(always)]
    fn rest_at(&self, l: DVec3) -> [DVec3; 3] {
        let mut gradients = self.field.gradient(l);
        for (gradient, first) in gradients.iter_mut().zip(self.first) {
            *gradient += LINEAR * first;
        }
        gradients
    }

    /// The gradient of F, by channel.
    #[inline(always)]
    fn probe_at<S: Simd>(&self, simd: S, l: DVec3) -> [DVec3; 3] {
        let mut gradients = self.rest_at(l);
        for (gradient, points) in gradients.iter_mut().zip(self.points.gradient(simd, l)) {
            *gradient += points;
        }
        gradients
    }

    /// Append `<v_l, y>` of a light for each side y.
    #[inline(always)]
    fn sides_at<S: Simd>(&self, simd: S, l: DVec3, sides: &mut Vec<DVec3>) {
        let probe = self.probe_at(simd, l);
        self.columns.gradients(l, sides);
        for &channel in &self.reference.channels {
            sides.push(probe[channel]);
        }
    }

    pub(super) fn moments_of(&self, directions: Vec<DVec3>) -> Moments {
        let sides = self.widest.dispatch(Sides { sphere: self, directions: &directions });
        let mut moments = Moments::with_sides(&self.reference, directions, sides);
        self.widest.dispatch(LightProducts { directions: &moments.directions, gram: &mut moments.gram });
        moments
    }

    /// `-<d^2 a_j, r>` along the tangents of each light, for lights with the radiances `x`.
    fn second_derivatives(&self, directions: &[DVec3], x: &DMatrix<f64>) -> Vec<DMat3> {
        let ambient = self.reference.ambient.coefficients();
        let weights = column_weights(&self.reference, x);
        let of_light = |(j, &l): (usize, &DVec3)| {
            let own = weights.column(ambient + j);
            let (columns, lights) = own.as_slice().split_at(ambient);
            let probe = |c: usize| -self.reference.copies(c) * x[(ambient + j, c)];
            let sides: Vec<f64> = columns.iter().copied().chain((0..x.ncols()).map(probe)).collect();
            let second =
                SecondDerivative { sphere: self, l, lights: directions, weights: lights, sides: &sides };
            let (second, [s, t]) = (self.widest.dispatch(second), tangents(l));
            let frame = DMat3::from_cols(s, t, DVec3::ZERO);
            frame.transpose() * second * frame
        };
        directions.iter().enumerate().map(of_light).collect()
    }

    /// True if a light may have this direction.
    pub(super) fn allows(&self, direction: DVec3) -> bool {
        !self.columns.has_floor || direction.y >= 0.0
    }
}

impl Objective for Sphere {
    fn reference(&self) -> &Reference {
        &self.reference
    }

    fn after_step(&self, before: &Moments, step: &[f64]) -> Moments {
        let mut directions = turn_by(&before.directions, step);
        for direction in directions.iter_mut().filter(|direction| !self.allows(**direction)) {
            *direction = direction.with_y(0.0).normalize_or(DVec3::X);
        }
        self.moments_of(directions)
    }

    fn subset(&self, before: &Moments, kept: &[usize]) -> Moments {
        self.exchange(before, kept, &[])
    }

    fn derivatives(&self, moments: &Moments, x: &DMatrix<f64>, is_exact: bool) -> Derivatives {
        let mut derivatives = Derivatives::with_sides(&self.reference, moments);
        let (ambient, directions) = (self.reference.ambient.coefficients(), &moments.directions);
        self.widest.dispatch(DerivativeProducts { directions, ambient, derivatives: &mut derivatives });
        derivatives.second = is_exact.then(|| self.second_derivatives(directions, x));
        derivatives
    }

    fn bounds(&self, moments: &Moments, gradient: &[f64], fixed: usize) -> Vec<Constraint> {
        let lights = moments.directions.iter().enumerate().skip(fixed);
        let on_floor = lights.filter(|(_, l)| self.columns.has_floor && l.y <= 0.0);
        let pressing = on_floor.filter_map(|(light, &l)| {
            let horizon = Constraint::horizon(light, l, DVec3::Y);
            let up = horizon.across.x * gradient[2 * light] + horizon.across.y * gradient[2 * light + 1];
            (up >= 0.0).then_some(horizon)
        });
        pressing.collect()
    }
}

/// `<v_l, y>` of each light and side.
pub(super) struct Sides<'a> {
    pub(super) sphere: &'a Sphere,
    pub(super) directions: &'a [DVec3],
}

impl WithSimd for Sides<'_> {
    type Output = Vec<DVec3>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut sides = Vec::with_capacity(self.directions.len() * self.sphere.reference.sides());
        for &l in self.directions {
            self.sphere.sides_at(simd, l, &mut sides);
        }
        sides
    }
}

/// Second derivative by `l` of `sum_k w_k <a_l, a_k> + sum_y w_y <a_l, y>`, on the tangent plane of l.
///
/// The sum is a function of degree 1 in l.
struct SecondDerivative<'a> {
    sphere: &'a Sphere,
    l: DVec3,
    lights: &'a [DVec3],
    /// Weights of the lights.
    weights: &'a [f64],
    /// Weights of the sides.
    sides: &'a [f64],
}

impl WithSimd for SecondDerivative<'_> {
    type Output = DMat3;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DMat3 {
        let Self { sphere: Sphere { reference, columns, points, field, .. }, l, lights, weights, sides } =
            self;
        let (ambient, channels) = sides.split_at(reference.ambient.coefficients());
        let mut by_channel = [0.0; 3];
        reference.channels.iter().zip(channels).for_each(|(&channel, weight)| by_channel[channel] = *weight);
        let map = field.second_derivative(l, by_channel) + points.second_derivative(simd, l, by_channel);
        let sides = columns.second_derivative(l, ambient) + map;
        lights.chunks(LANES).zip(weights.chunks(LANES)).fold(sides, |sum, (lights, weights)| {
            let mut padded = [0.0; LANES];
            padded[..weights.len()].copy_from_slice(weights);
            sum + second_derivative(simd, l, &padded, &Block::new(lights.iter().copied()))
        })
    }
}

/// Integrals of `L dw`, `L w dw` and `L w w^T dw` over the whole map, in one channel.
fn moments(rest: &Harmonics, points: &[PointLight], channel: usize) -> (f64, DVec3, DMat3) {
    points.iter().fold(rest.moments(channel), |(whole, first, second), point| {
        let (l, e) = (point.direction, point.irradiance[channel]);
        (whole + e, first + l * e, second + outer(l, l) * e)
    })
}

/// Factors of the kernel for the even degrees of the table, 0 for others.
fn even_factors() -> [f64; DEGREES] {
    let factors = spectrum(HIGHEST / 2 + 1);
    std::array::from_fn(|degree| match degree % 2 {
        0 if degree <= HIGHEST => factors[degree / 2],
        _ => 0.0,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Probe, Samples};
    use crate::kernels::sphere::{Registration, exponential_map};
    use crate::kernels::{image, probe, sampling};
    use ndarray::Array3;

    /// A map of waves and one hot pixel, and its probe at many normals.
    fn waves(registration: Registration) -> (WorkingMap, Samples) {
        let map = Array3::from_shape_fn((128, 256, 3), |(y, x, c)| {
            let wave = 2.0 + (0.1 * x as f64).sin() + (0.17 * y as f64 + c as f64).cos();
            let hot = if (y, x) == (20, 37) { 3000.0 } else { 0.0 };
            (wave + hot) as f32
        });
        let working = image::reduce(map.view(), registration, 256, 2e-3, false).unwrap();
        let (normals, weights) = sampling::icosphere(20480).unwrap();
        let irradiance = probe::working_irradiance(&working, normals.view()).unwrap();
        (working, Samples::new(normals.view(), weights.view(), irradiance.view()).unwrap())
    }

    fn directions() -> Vec<DVec3> {
        [DVec3::Y, DVec3::new(2.0, 3.0, -6.0) / 7.0, DVec3::new(2.0, -6.0, 3.0) / 7.0].to_vec()
    }

    /// Compare within a fraction of the greatest value of `whole`.
    fn assert_near(a: &DMatrix<f64>, b: &DMatrix<f64>, whole: &DMatrix<f64>, fraction: f64) {
        let difference = (a - b).amax() / whole.amax();
        assert!(difference < fraction, "{difference:e}\n{a}{b}");
    }

    #[test]
    fn the_closed_form_is_the_sum_over_many_normals() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let (map, samples) = waves(registration);
            for ambient in [Ambient::None, Ambient::Constant, Ambient::Sh2] {
                let (closed, summed) =
                    (Sphere::new(&map, ambient, false), Probe::new(samples.clone(), ambient));
                let energy = closed.reference.energy / summed.reference().energy - 1.0;
                assert!(energy.abs() < 1e-4, "{energy:e}");
                let [a, b] = [&closed as &dyn PointObjective, &summed].map(|o| o.moments(&directions()));
                assert_near(&a.gram, &b.gram, &b.gram, 1e-4);
                assert_near(&a.rhs, &b.rhs, &b.rhs, 1e-4);
                // Allow for the jump of derivatives at a light's horizon between 20480 normals.
                let x = DMatrix::zeros(a.gram.nrows(), a.rhs.ncols());
                let [da, db] = [closed.derivatives(&a, &x, false), summed.derivatives(&b, &x, false)];
                assert_near(&da.gram, &db.gram, &b.gram, 2e-3);
                assert_near(&da.rhs, &db.rhs, &b.rhs, 2e-3);
                assert_near(&da.model, &db.model, &b.gram, 2e-3);
            }
        }
    }

    #[test]
    fn second_derivatives_are_central_differences() {
        const STEP: f64 = 1e-4;
        let (map, _) = waves(Registration::CellCentred);
        for (ambient, has_floor) in [
            (Ambient::None, false),
            (Ambient::Constant, false),
            (Ambient::Constant, true),
            (Ambient::Sh2, false),
        ] {
            let sphere = Sphere::new(&map, ambient, has_floor);
            let others = [DVec3::new(2.0, 3.0, 6.0) / 7.0, DVec3::NEG_Z];
            let light_weights = [0.7, -0.4];
            let weights: Vec<f64> = (0..sphere.reference.sides()).map(|i| 0.3 + 0.1 * i as f64).collect();
            let value = |l: DVec3| -> f64 {
                let at = sphere.directions(vec![l]);
                let (sides, lights) = (sphere.side_products(&at), sphere.light_products(&at, &others));
                let products = sides.iter().zip(&weights).chain(lights.iter().zip(&light_weights));
                products.map(|(value, weight)| weight * value).sum()
            };
            for l in directions() {
                let [s, t] = tangents(l);
                let second = SecondDerivative {
                    sphere: &sphere,
                    l,
                    lights: &others,
                    weights: &light_weights,
                    sides: &weights,
                };
                let second = sphere.widest.dispatch(second);
                for along in [s, t, (s + t) / 2.0_f64.sqrt()] {
                    let [ahead, behind] = [STEP, -STEP].map(|step| value(exponential_map(l, along * step)));
                    // Subtract the value itself, by which the arc curves away from the tangent.
                    let expected = along.dot(second * along) - value(l);
                    let difference = (ahead - 2.0 * value(l) + behind) / (STEP * STEP);
                    let error = (difference - expected).abs();
                    assert!(error < 1e-4 * value(l), "{ambient:?} {l}: {difference} {expected}");
                }
            }
        }
    }
}
