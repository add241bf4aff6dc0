//! Sums over the pixels of a light, strip by strip of a few rows.
//!
//! With the integral `c` of the direction over a cell and its solid angle `dw`:
//!
//! ```text
//!   V = sum T c           S = sum M c c^T / dw
//! ```
//!
//! The factors of `c = (x s, w p, -y s)` and `dw = w b` are of the row (s, p, b) or of the column (x, y, w). So samples
//! are summed down the rows first, times two factors for `V` and three for `S`, red, green and blue alike, side by side
//! as they stand in the map; and then along the columns.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::array;

use glam::{DMat3, DVec3};

use super::cells::{Columns, Row};

/// Sums down the rows, for `V`.
#[derive(Default)]
pub struct First {
    squares: Vec<f64>,
    products: Vec<f64>,
}

/// Sums down the rows, for `S`.
#[derive(Default)]
pub struct Second {
    squares: Vec<f64>,
    mixed: Vec<f64>,
    products: Vec<f64>,
}

impl First {
    /// Forget all sums, and make room for so many samples of a row.
    pub fn start(&mut self, samples: usize) {
        for sums in [&mut self.squares, &mut self.products] {
            empty(sums, samples);
        }
    }

    /// Add what is taken from a row.
    #[inline(always)]
    pub fn add(&mut self, given: &[[f32; 3]], left: &[[f32; 3]], row: &Row) {
        let sums = self.squares.iter_mut().zip(&mut self.products);
        let samples = given.as_flattened().iter().zip(left.as_flattened());
        for ((squares, products), (&given, &left)) in sums.zip(samples) {
            let taken = f64::from(given) - f64::from(left);
            *squares += row.squares * taken;
            *products += row.products * taken;
        }
    }

    /// `V` of each channel.
    #[inline(always)]
    pub fn vectors(&self, columns: &Columns<&[f64]>) -> [DVec3; 3] {
        let (sin, cos) = (sum(&self.squares, columns.sin), sum(&self.squares, columns.cos));
        let width = sum(&self.products, columns.width);
        array::from_fn(|channel| DVec3::new(sin[channel], width[channel], -cos[channel]))
    }
}

impl Second {
    /// Forget all sums, and make room for so many samples of a row.
    pub fn start(&mut self, samples: usize) {
        for sums in [&mut self.squares, &mut self.mixed, &mut self.products] {
            empty(sums, samples);
        }
    }

    /// Add the samples of a row.
    #[inline(always)]
    pub fn add(&mut self, samples: &[[f32; 3]], row: &Row) {
        let [squares, mixed, products] =
            [row.squares * row.squares, row.squares * row.products, row.products * row.products]
                .map(|factor| factor / row.band);
        let sums = self.squares.iter_mut().zip(&mut self.mixed).zip(&mut self.products);
        for (((of_squares, of_mixed), of_products), &sample) in sums.zip(samples.as_flattened()) {
            let sample = f64::from(sample);
            *of_squares += squares * sample;
            *of_mixed += mixed * sample;
            *of_products += products * sample;
        }
    }

    /// `S` of each channel.
    #[inline(always)]
    pub fn tensors(&self, columns: &Columns<&[f64]>) -> [DMat3; 3] {
        let (xx, xz) = (sum(&self.squares, columns.sin_sin), sum(&self.squares, columns.sin_cos));
        let zz = sum(&self.squares, columns.cos_cos);
        let (xy, yz) = (sum(&self.mixed, columns.sin), sum(&self.mixed, columns.cos));
        let yy = sum(&self.products, columns.width);
        array::from_fn(|i| {
            DMat3::from_cols_array_2d(&[
                [xx[i], xy[i], -xz[i]],
                [xy[i], yy[i], -yz[i]],
                [-xz[i], -yz[i], zz[i]],
            ])
        })
    }
}

fn empty(sums: &mut Vec<f64>, samples: usize) {
    sums.clear();
    sums.resize(samples, 0.0);
}

/// Sum of the products of samples with weights, for each channel.
#[inline(always)]
fn sum(samples: &[f64], weights: &[f64]) -> [f64; 3] {
    // Four pixels are three wide vectors.
    const LANES: usize = 12;
    let mut lanes = [0.0; LANES];
    let (samples, last_samples) = samples.as_chunks::<LANES>();
    let (weights, last_weights) = weights.as_chunks::<LANES>();
    for (samples, weights) in samples.iter().zip(weights) {
        for (lane, (sample, weight)) in lanes.iter_mut().zip(samples.iter().zip(weights)) {
            *lane += sample * weight;
        }
    }
    for (lane, (sample, weight)) in lanes.iter_mut().zip(last_samples.iter().zip(last_weights)) {
        *lane += sample * weight;
    }
    array::from_fn(|i| (lanes[i] + lanes[i + 3]) + (lanes[i + 6] + lanes[i + 9]))
}
