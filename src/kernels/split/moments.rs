//! Sums over the pixels of a light, strip by strip of a few rows.
//!
//! With the integral `c` of the direction over a cell and its solid angle `dw`:
//!
//! ```text
//!   V = sum T c           S = sum M c c^T / dw
//! ```
//!
//! The factors of `c = (x s, w p, -y s)` and `dw = w b` are of the row (s, p, b) or of the column (x, y, w). So samples
//! are summed down the rows first, times two factors for `V` and three for `S`, and then along the columns.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::array;

use glam::{DMat3, DVec3};

use super::cells::{Columns, Row};
use super::planes::Planes;
use crate::kernels::detect::segment::dot_product::dot;

/// Sums down the rows, for `V`.
#[derive(Default)]
pub struct First {
    squares: Vec<f64>,
    products: Vec<f64>,
}

/// Sums down the rows, for `S`, in single precision: a tilt changes hundredths of `V`.
#[derive(Default)]
pub struct Second {
    squares: Vec<f32>,
    mixed: Vec<f32>,
    products: Vec<f32>,
}

impl First {
    /// Forget all sums, and make room for so many pixels of a row.
    pub fn start(&mut self, pixels: usize) {
        for sums in [&mut self.squares, &mut self.products] {
            empty(sums, 3 * pixels);
        }
    }

    /// Add what is taken from a row.
    #[inline(always)]
    pub fn add(&mut self, given: &Planes<3>, left: &Planes<3>, row: &Row) {
        let sums = self.squares.iter_mut().zip(&mut self.products);
        let samples = given.values().iter().zip(left.values());
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
    /// Forget all sums, and make room for so many pixels of a row.
    pub fn start(&mut self, pixels: usize) {
        for sums in [&mut self.squares, &mut self.mixed, &mut self.products] {
            empty(sums, 3 * pixels);
        }
    }

    /// Add what is left in a row, times the bump.
    #[inline(always)]
    pub fn add(&mut self, bumped: &Planes<3>, row: &Row) {
        let [squares, mixed, products] =
            [row.squares * row.squares, row.squares * row.products, row.products * row.products]
                .map(|factor| (factor / row.band) as f32);
        let sums = self.squares.iter_mut().zip(&mut self.mixed).zip(&mut self.products);
        for (((of_squares, of_mixed), of_products), &sample) in sums.zip(bumped.values()) {
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

/// Luminance that is taken from the pixels of a row, and sums of it and of its square down the rows.
#[derive(Default)]
pub struct Luminances {
    row: Vec<f32>,
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl Luminances {
    /// Forget all sums, and make room for so many pixels of a row.
    pub fn start(&mut self, pixels: usize) {
        self.row.resize(pixels, 0.0);
        for sums in [&mut self.sums, &mut self.squares] {
            empty(sums, pixels);
        }
    }

    /// The pixels of a row, to be filled.
    pub fn row(&mut self) -> &mut [f32] {
        &mut self.row
    }

    /// Add what the row was filled with.
    #[inline(always)]
    pub fn add(&mut self, row: &Row) {
        for ((sum, squares), &luminance) in self.sums.iter_mut().zip(&mut self.squares).zip(&self.row) {
            let luminance = f64::from(luminance);
            *sum += row.band * luminance;
            *squares += row.band * luminance * luminance;
        }
    }

    /// Integrals over the pixels of the luminance and of its square.
    #[inline(always)]
    pub fn integrals(&self, columns: &Columns<&[f64]>) -> (f64, f64) {
        (dot(&self.sums, columns.width), dot(&self.squares, columns.width))
    }
}

fn empty<T: Clone + Default>(sums: &mut Vec<T>, samples: usize) {
    sums.clear();
    sums.resize(samples, T::default());
}

/// Sum of the products of samples with weights, for each channel. What `array::from_fn` calls is not inlined.
#[inline(always)]
fn sum<T: Copy + Into<f64>>(samples: &[T], weights: &[f64]) -> [f64; 3] {
    let (red, more) = samples.split_at(weights.len());
    let (green, blue) = more.split_at(weights.len());
    [dot(red, weights), dot(green, weights), dot(blue, weights)]
}
