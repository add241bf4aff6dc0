//! Sums over the pixels of a light, row by row.
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

use glam::{DMat3, DVec3};

use super::cells::{Columns, Row};
use crate::kernels::detect::tree::dot;

/// `V` of the pixels of a row.
#[inline(always)]
pub fn first<T: Copy + Into<f64>>(values: &[T], row: &Row, columns: &Columns<&[f64]>) -> DVec3 {
    let (sin, cos, width) = (dot(values, columns.sin), dot(values, columns.cos), dot(values, columns.width));
    DVec3::new(row.squares * sin, row.products * width, -row.squares * cos)
}

/// `S` of the pixels of a row.
#[inline(always)]
pub fn second<T: Copy + Into<f64>>(values: &[T], row: &Row, columns: &Columns<&[f64]>) -> DMat3 {
    // One by one: what `map` calls is not inlined.
    let (sin, cos, width) = (dot(values, columns.sin), dot(values, columns.cos), dot(values, columns.width));
    let (sin_sin, sin_cos) = (dot(values, columns.sin_sin), dot(values, columns.sin_cos));
    let cos_cos = dot(values, columns.cos_cos);
    let (s, p) = (row.squares, row.products);
    let [xy, yz, zx] = [s * p * sin, -s * p * cos, -s * s * sin_cos];
    let [xx, yy, zz] = [s * s * sin_sin, p * p * width, s * s * cos_cos];
    DMat3::from_cols_array_2d(&[[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) * row.band.recip()
}
