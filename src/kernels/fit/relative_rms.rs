//! The relative RMS difference of two probes.

use ndarray::{Array2, ArrayView1, ArrayView2, Axis};

use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::{check_rows, check_values};

/// Relative RMS error, from sums of squares of the difference and of the whole; absolute if the whole is 0.
pub fn relative_error(difference: f64, whole: f64) -> f64 {
    if whole > 0.0 { (difference / whole).sqrt() } else { difference.sqrt() }
}

/// Weighted relative RMS difference of two probes, (n, 3) each.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::LengthMismatch`];
/// [`crate::error::Error::NotFinite`] for any number, and [`crate::error::Error::Negative`] for a weight.
pub fn relative_rms(
    seen: ArrayView2<'_, f64>,
    wanted: ArrayView2<'_, f64>,
    weights: ArrayView1<'_, f64>,
) -> Result<f64> {
    check_rows("wanted", wanted, 3)?;
    check_values("wanted", wanted.nrows(), ("seen", seen), weights)?;
    // Scale all numbers to at most 1, because the square of a number above 1e154 is infinite.
    let (weight, weights) = near_one(weights.insert_axis(Axis(1)).to_owned());
    let (roots, half) = (weights.sqrt(), &wanted / 2.0);
    interrupt::check();
    let (error, errors) = near_one(&roots * (&seen / 2.0 - &half));
    let (size, sizes) = near_one(roots * half);
    // Compare the norms.
    let norm = |rows: &Array2<f64>| {
        interrupt::check();
        (rows * rows).sum().sqrt()
    };
    let (errors, sizes) = (norm(&errors), norm(&sizes));
    Ok(if sizes > 0.0 { error * (errors / sizes) / size } else { 2.0 * error * errors * weight.sqrt() })
}

/// The largest absolute value, or 1 if all are 0, and the numbers divided by it.
fn near_one(numbers: Array2<f64>) -> (f64, Array2<f64>) {
    interrupt::check();
    let largest = numbers.iter().fold(0.0_f64, |largest, number| largest.max(number.abs()));
    let unit = if largest > 0.0 { largest } else { 1.0 };
    interrupt::check();
    (unit, numbers / unit)
}
