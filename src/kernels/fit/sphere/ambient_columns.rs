//! Inner products of the ambient columns with lights, as functions of degree 1 in the direction l of a light.
//!
//! ```text
//!   constant     A = pi                  <A, a_l> = pi^2 |l|
//!   over a floor A = pi/2 (1 + n_y)      <A, a_l> = pi^2/2 |l| + pi^2/3 l_y
//!   harmonics    A = A_d Y_i             <A, a_l> = A_d^2 |l|^(1 - d) Y_i(l)         A_d: pi, 2 pi/3, pi/4
//! ```
//!
//! A floor hides the lower half of a constant environment. All columns have the form `b.l + l^T B l / |l|`.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::kernels::fit::ambient::Ambient;
use crate::kernels::harmonics::{cosine_lobe, irradiance, irradiance_of_moments};

/// The ambient columns, and their inner products over all normals.
#[derive(Clone, Debug)]
pub struct AmbientColumns {
    pub ambient: Ambient,
    pub has_floor: bool,
    /// b and B of each column.
    forms: Vec<(DVec3, DMat3)>,
}

impl AmbientColumns {
    /// The columns of an `ambient` term.
    pub fn new(ambient: Ambient, has_floor: bool) -> Self {
        let round = |value: f64| DMat3::from_diagonal(DVec3::splat(value));
        let forms = match ambient {
            Ambient::None => Vec::new(),
            Ambient::Constant if has_floor => vec![(PI * PI / 3.0 * DVec3::Y, round(PI * PI / 2.0))],
            Ambient::Constant => vec![(DVec3::ZERO, round(PI * PI))],
            Ambient::Sh2 => (0..9).map(harmonic_form).collect(),
        };
        Self { ambient, has_floor, forms }
    }

    /// Inner product of two ambient columns.
    pub fn gram(&self, i: usize, k: usize) -> f64 {
        match self.ambient {
            _ if i != k => 0.0,
            Ambient::Sh2 => cosine_lobe(i) * cosine_lobe(i),
            _ if self.has_floor => 4.0 / 3.0 * PI.powi(3),
            _ => 4.0 * PI.powi(3),
        }
    }

    /// Inner product with the probe under a map, from the integrals of `L w dw` and `L w w^T dw`.
    pub fn probe(&self, i: usize, first: DVec3, second: DMat3) -> f64 {
        let (b, form) = self.forms[i];
        let products = form.to_cols_array().into_iter().zip(second.to_cols_array());
        b.dot(first) + products.map(|(form, moment)| form * moment).sum::<f64>()
    }

    /// Append the derivatives by l of the inner products with a light.
    pub fn gradients(&self, l: DVec3, out: &mut Vec<DVec3>) {
        out.extend(self.forms.iter().map(|&(b, form)| {
            let along = form * l;
            b + 2.0 * along - along.dot(l) * l
        }));
    }

    /// Second derivative of the weighted sum of the inner products, on the tangent plane of l.
    pub fn second_derivative(&self, l: DVec3, weights: &[f64]) -> DMat3 {
        let sum = self.forms.iter().zip(weights).fold(DMat3::ZERO, |sum, ((_, form), w)| sum + *form * *w);
        sum * 2.0 - DMat3::from_diagonal(DVec3::splat(l.dot(sum * l)))
    }
}

/// b and B of a harmonic; `|l|^2 = 1` makes its constant part a quadratic form.
fn harmonic_form(i: usize) -> (DVec3, DMat3) {
    let linear = DVec3::AXES.map(|axis| 0.5 * (irradiance(axis)[i] - irradiance(-axis)[i]));
    let entry = |j: usize, k: usize| {
        let mut second = DMat3::ZERO;
        second.col_mut(k)[j] = 0.5;
        second.col_mut(j)[k] += 0.5;
        irradiance_of_moments(if j == k { 1.0 } else { 0.0 }, DVec3::ZERO, second)[i]
    };
    let form = DMat3::from_cols_array_2d(&[0, 1, 2].map(|k| [0, 1, 2].map(|j| entry(j, k))));
    (DVec3::from_array(linear) * cosine_lobe(i), form * cosine_lobe(i))
}
