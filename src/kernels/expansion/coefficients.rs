//! Harmonics up to any degree, of maps and of discs.
//!
//! [`super::Harmonics`] are those that a fit differentiates, up to a fixed degree. These serve gloss, comparisons and the nine
//! harmonics of other programs.

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::{Array2, Array3, ArrayView3};
use rayon::prelude::*;

use super::azimuthal::Azimuthal;
use super::{DEGREE, Harmonics, disc_series, visit_degrees};
use crate::error::Result;
use crate::interrupt;
use crate::kernels::disc::Discs;
use crate::kernels::image::{Grid, check_rgb};
use crate::kernels::sampling::gauss_legendre;
use crate::kernels::sphere::{Registration, angles, check_memory};

/// Direction, A and flux of a disc.
pub type DiscOfFlux = (DVec3, f64, [f64; 3]);

/// Coefficients of three channels: cosines, then sines. A list for each order, from the degree of that order on.
#[derive(Clone, Debug)]
pub struct Coefficients(Vec<Vec<[f64; 6]>>);

impl Coefficients {
    /// The coefficients of discs, up to a degree.
    pub fn of_discs(discs: &[DiscOfFlux], degree: usize) -> Self {
        let (theta, phi): (Vec<f64>, Vec<f64>) = discs.iter().map(|disc| angles(disc.0)).unzip();
        let (sines, cosines): (Vec<f64>, Vec<f64>) = theta.iter().map(|theta| theta.sin_cos()).unzip();
        let series: Vec<Vec<f64>> = discs.iter().map(|disc| disc_series(disc.1, degree + 1)).collect();
        // Of each degree, the factors of all discs, because a sum runs over the discs.
        let factors: Vec<Vec<f64>> =
            (0..=degree).map(|l| series.iter().map(|series| series[l]).collect()).collect();
        let order = |m: usize| {
            interrupt::check();
            let wave = |(phi, disc): (&f64, &DiscOfFlux)| {
                let (sine, cosine) = (m as f64 * phi).sin_cos();
                let [r, g, b] = disc.2;
                [r * cosine, g * cosine, b * cosine, r * sine, g * sine, b * sine]
            };
            let waves: Vec<[f64; 6]> = phi.iter().zip(discs).map(wave).collect();
            let mut out = vec![[0.0; 6]; degree + 1 - m];
            visit_degrees(m, degree, &cosines, &sines, &mut |l, values| {
                let mut sum = [0.0; 6];
                for ((value, factor), wave) in values.iter().zip(&factors[l]).zip(&waves) {
                    let weight = value * factor;
                    (0..6).for_each(|i| sum[i] += weight * wave[i]);
                }
                out[l - m] = sum;
            });
            out
        };
        Self((0..=degree).into_par_iter().map(order).collect())
    }

    /// The coefficients of cells of uniform radiance between meridians, up to a degree.
    fn of_cells(radiance: ArrayView3<'_, f32>, phi_edges: &[f64], nodes: &RowNodes, degree: usize) -> Self {
        let azimuthal = Azimuthal::new(radiance, phi_edges, degree + 1);
        let order = |m: usize| {
            interrupt::check();
            let mut out = vec![[0.0; 6]; degree + 1 - m];
            visit_degrees(m, degree, &nodes.heights, &nodes.sines, &mut |l, values| {
                let rows = values.chunks_exact(nodes.each).zip(nodes.weights.chunks_exact(nodes.each));
                for (row, (values, weights)) in rows.enumerate() {
                    let integral: f64 =
                        values.iter().zip(weights).map(|(value, weight)| value * weight).sum();
                    let [r, g, b, _, red, green, blue, _] = azimuthal.at(row, m);
                    let wave = [r, g, b, red, green, blue];
                    (0..6).for_each(|i| out[l - m][i] += integral * wave[i]);
                }
            });
            out
        };
        Self((0..=degree).into_par_iter().map(order).collect())
    }

    /// Add the degrees of the fit.
    pub fn add_harmonics(&mut self, harmonics: &Harmonics) {
        for (order, values) in self.0.iter_mut().zip(harmonics.orders()) {
            for (value, [r, g, b, _, red, green, blue, _]) in order.iter_mut().zip(values) {
                let other = [r, g, b, red, green, blue];
                (0..6).for_each(|i| value[i] += other[i]);
            }
        }
    }

    /// Add an ambient term: the radiance of a constant one, or nine coefficients of harmonics around +z.
    pub fn add_ambient(&mut self, ambient: &[DVec3]) {
        match *ambient {
            [constant] => self.add(0, 0, 0, constant * (4.0 * PI).sqrt()),
            [whole, y, z, x, xy, yz, zz, xz, xx_yy] => {
                self.add(0, 0, 0, whole);
                for (side, m, value) in [(0, 0, y), (0, 1, -z), (1, 1, x)] {
                    self.add(1, m, side, value);
                }
                let [yy, zz_xx] = AROUND_Y.map(|[a, b]| a * zz + b * xx_yy);
                for (side, m, value) in [(0, 0, yy), (0, 1, -yz), (1, 1, xy), (0, 2, zz_xx), (1, 2, -xz)] {
                    self.add(2, m, side, value);
                }
            }
            _ => {}
        }
    }

    /// Coefficients of nine harmonics around +z, the inverse of [`Self::add_ambient`].
    fn nine(&self) -> [DVec3; 9] {
        let at = |l: usize, m: usize, side: usize| DVec3::from_slice(&self.0[m][l - m][3 * side..]);
        let (yy, zz_xx) = (at(2, 0, 0), at(2, 2, 0));
        let [[yy_of_zz, yy_of_xx], [zz_xx_of_zz, zz_xx_of_xx]] = AROUND_Y;
        [
            at(0, 0, 0),
            at(1, 0, 0),
            -at(1, 1, 0),
            at(1, 1, 1),
            at(2, 1, 1),
            -at(2, 1, 0),
            yy_of_zz * yy + zz_xx_of_zz * zz_xx,
            -at(2, 2, 1),
            yy_of_xx * yy + zz_xx_of_xx * zz_xx,
        ]
    }

    fn add(&mut self, l: usize, m: usize, side: usize, rgb: DVec3) {
        let value = &mut self.0[m][l - m];
        (0..3).for_each(|c| value[3 * side + c] += rgb[c]);
    }

    /// Sum of the squares in each degree, of these minus `others`.
    pub fn energies(&self, others: Option<&Self>) -> Vec<f64> {
        let mut out = vec![0.0; self.0.len()];
        for (m, order) in self.0.iter().enumerate() {
            for (k, value) in order.iter().enumerate() {
                let other = others.map_or([0.0; 6], |others| others.0[m][k]);
                out[m + k] += (0..6).map(|i| (value[i] - other[i]).powi(2)).sum::<f64>();
            }
        }
        out
    }

    /// Cosines and sines of each order and degree, (order, degree, 6); 0 below the degree of the order.
    fn to_array(&self) -> Array3<f64> {
        let mut out = Array3::zeros((self.0.len(), self.0.len(), 6));
        for ((m, k, i), value) in out.indexed_iter_mut() {
            *value = if k < m { 0.0 } else { self.0[m][k - m][i] };
        }
        out
    }
}

impl Harmonics {
    /// Cosines and sines of each order and degree, (order, degree, 6); 0 below the degree of the order.
    pub fn to_array(&self) -> Array3<f64> {
        let mut out = Coefficients::of_discs(&[], DEGREE);
        out.add_harmonics(self);
        out.to_array()
    }
}

/// Harmonics `3 y^2 - 1` and `z^2 - x^2` around +y, as sums of `3 z^2 - 1` and `x^2 - y^2` around +z.
const AROUND_Y: [[f64; 2]; 2] = [[-0.5, -0.866_025_403_784_438_6], [0.866_025_403_784_438_6, -0.5]];

/// Gauss nodes in each row of cells, row after row.
struct RowNodes {
    /// Nodes of one row.
    each: usize,
    heights: Vec<f64>,
    sines: Vec<f64>,
    weights: Vec<f64>,
}

impl RowNodes {
    /// Some nodes in each row between `edges`; `place` returns the height and the sine of a node, and its weight.
    fn new(edges: &[f64], each: usize, place: fn(f64) -> [f64; 3]) -> Self {
        let (nodes, gauss) = gauss_legendre(each);
        let mut out = Self { each, heights: Vec::new(), sines: Vec::new(), weights: Vec::new() };
        for edges in edges.windows(2) {
            let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]).abs());
            for (node, gauss) in nodes.iter().zip(&gauss) {
                let [height, sine, weight] = place(middle + node * half);
                out.heights.push(height);
                out.sines.push(sine);
                out.weights.push(weight * gauss * half);
            }
        }
        out
    }

    /// Nodes in the height: at least two in each row, and `least` in all.
    fn in_height(theta_edges: &[f64], least: usize) -> Self {
        let edges: Vec<f64> = theta_edges.iter().map(|theta| theta.cos()).collect();
        Self::new(&edges, least.div_ceil(edges.len() - 1).max(2), |x| [x, (1.0 - x * x).max(0.0).sqrt(), 1.0])
    }

    /// Nodes in the polar angle, in which harmonics of odd order are smooth at the poles, too.
    fn in_angle(theta_edges: &[f64], each: usize) -> Self {
        Self::new(theta_edges, each, |theta| [theta.cos(), theta.sin(), theta.sin()])
    }
}

/// Coefficients of the cells of a map, (order, degree, 6), up to `degree`.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::NoMemory`].
pub fn expand_map(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    degree: usize,
) -> Result<Array3<f64>> {
    /// Nodes from pole to pole; fewer sample the rows of small maps instead of integrating over them.
    const NODES: usize = 256;
    let grid = grid_of(radiance, registration, degree)?;
    let nodes = RowNodes::in_height(&grid.theta_edges, NODES);
    Ok(Coefficients::of_cells(radiance, &grid.phi_edges, &nodes, degree).to_array())
}

/// Coefficients of discs, (order, degree, 6), up to `degree`.
///
/// # Errors
///
/// [`crate::error::Error::NoMemory`].
pub fn expand_discs(discs: &Discs, degree: usize) -> Result<Array3<f64>> {
    check_memory(&[degree + 1, degree + discs.radii.len(), 6])?;
    let disc = |((&direction, irradiance), radius): ((&DVec3, &DVec3), &f64)| {
        let share = (0.5 * radius).sin().powi(2);
        (direction, share, (*irradiance / (1.0 - share)).to_array())
    };
    let discs: Vec<DiscOfFlux> =
        discs.directions.iter().zip(&discs.irradiance).zip(&discs.radii).map(disc).collect();
    Ok(Coefficients::of_discs(&discs, degree).to_array())
}

/// Coefficients of the nine harmonics of [`crate::kernels::harmonics`] in a map, (9, 3).
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::NoMemory`].
pub fn nine_harmonics(radiance: ArrayView3<'_, f32>, registration: Registration) -> Result<Array2<f64>> {
    /// Nodes in each row, exact to rounding even for two rows.
    const NODES: usize = 10;
    let grid = grid_of(radiance, registration, 2)?;
    let nodes = RowNodes::in_angle(&grid.theta_edges, NODES);
    let nine = Coefficients::of_cells(radiance, &grid.phi_edges, &nodes, 2).nine();
    Ok(Array2::from(nine.map(|rgb| rgb.to_array()).to_vec()))
}

/// Grid of the pixels of a map, unless it is none or its integrals do not fit in memory.
fn grid_of(radiance: ArrayView3<'_, f32>, registration: Registration, degree: usize) -> Result<Grid> {
    check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    check_memory(&[degree + 1, 8, height + width + degree])?;
    Ok(Grid::of_pixels(height, width, registration))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::expansion::legendre_values;
    use crate::kernels::harmonics::radiance;

    /// The addition theorem, and the factors of both discs.
    #[test]
    fn the_energies_of_two_discs_are_their_products() {
        let (one, other) = (DVec3::new(2.0, 3.0, -6.0) / 7.0, DVec3::new(-0.6, 0.0, 0.8));
        let flux = [1.0, 0.0, 2.0];
        let ours = Coefficients::of_discs(&[(one, 0.01, flux)], 96);
        let theirs = Coefficients::of_discs(&[(other, 0.02, flux)], 96);
        let (energies, legendre) = (ours.energies(Some(&theirs)), legendre_values(one.dot(other), 97));
        let [a, b] = [0.01, 0.02].map(|share| disc_series(share, 97));
        for l in [0, 1, 2, 17, 40, 96] {
            let expected = a[l] * a[l] + b[l] * b[l] - 2.0 * a[l] * b[l] * legendre[l];
            let expected = 5.0 * expected * (2 * l + 1) as f64 / (4.0 * PI);
            assert!((energies[l] - expected).abs() < 1e-11, "{l}: {} {expected}", energies[l]);
        }
    }

    /// A point in the degrees 0 to 2 is its nine harmonics.
    #[test]
    fn nine_harmonics_are_those_of_a_point() {
        let (towards, rgb) = (DVec3::new(2.0, 3.0, -6.0) / 7.0, DVec3::new(1.0, 2.0, 3.0));
        let point = Coefficients::of_discs(&[(towards, 0.0, rgb.to_array())], 2);
        let mut nine = Coefficients::of_discs(&[], 2);
        nine.add_ambient(&radiance(towards).map(|value| rgb * value));
        assert!(point.energies(Some(&nine)).iter().all(|energy| *energy < 1e-24));
        let pairs = point.nine().into_iter().zip(radiance(towards));
        assert!(pairs.into_iter().all(|(found, value)| (found - rgb * value).length() < 1e-12));
    }
}
