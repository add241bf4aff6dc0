//! Sums over the pixels of a light, row by row, with the channels side by side.
//!
//! With the integral `c` of the direction over a cell and its solid angle `dw`:
//!
//! ```text
//!   V = sum T c           S = sum M c c^T / dw
//! ```
//!
//! The row's factors of `c = (x s, w p, -y s)` and `dw = w b` are taken out of the sums over its columns, which are
//! three for `V` and six for `S`.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::array;

use glam::{DMat3, DVec3};

use super::cells::{Column, Row};

/// Red, green and blue; the fourth is of no use but makes a whole vector.
pub type Lanes = [f64; 4];

/// Sums over the columns of a row, for `V`.
#[derive(Default)]
pub struct First {
    sin: Lanes,
    cos: Lanes,
    width: Lanes,
}

/// Sums over the columns of a row, for `S`.
#[derive(Default)]
pub struct Second {
    first: First,
    sin_sin: Lanes,
    sin_cos: Lanes,
    cos_cos: Lanes,
}

impl First {
    #[inline(always)]
    pub fn add(&mut self, values: &Lanes, column: &Column) {
        add(&mut self.sin, values, column.sin);
        add(&mut self.cos, values, column.cos);
        add(&mut self.width, values, column.width);
    }

    /// `V` of each channel, over a row.
    #[inline(always)]
    pub fn vectors(&self, row: &Row) -> [DVec3; 3] {
        array::from_fn(|channel| {
            let (sin, cos, width) = (self.sin[channel], self.cos[channel], self.width[channel]);
            DVec3::new(row.squares * sin, row.products * width, -row.squares * cos)
        })
    }

    /// The integral of each channel, over a row.
    #[inline(always)]
    pub fn integrals(&self, row: &Row) -> DVec3 {
        row.band * DVec3::new(self.width[0], self.width[1], self.width[2])
    }
}

impl Second {
    #[inline(always)]
    pub fn add(&mut self, values: &Lanes, column: &Column) {
        self.first.add(values, column);
        add(&mut self.sin_sin, values, column.sin_sin);
        add(&mut self.sin_cos, values, column.sin_cos);
        add(&mut self.cos_cos, values, column.cos_cos);
    }

    /// The integral of the direction times each channel, over a row.
    #[inline(always)]
    pub fn vectors(&self, row: &Row) -> [DVec3; 3] {
        self.first.vectors(row)
    }

    /// `S` of each channel, over a row.
    #[inline(always)]
    pub fn tensors(&self, row: &Row) -> [DMat3; 3] {
        let (s, p) = (row.squares, row.products);
        array::from_fn(|channel| {
            let First { sin, cos, width } = &self.first;
            let [xy, yz, zx] =
                [s * p * sin[channel], -s * p * cos[channel], -s * s * self.sin_cos[channel]];
            let [xx, yy, zz] =
                [s * s * self.sin_sin[channel], p * p * width[channel], s * s * self.cos_cos[channel]];
            DMat3::from_cols_array_2d(&[[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) * row.band.recip()
        })
    }
}

#[inline(always)]
fn add(sums: &mut Lanes, values: &Lanes, weight: f64) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * weight);
}
