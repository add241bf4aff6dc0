//! Step 9 of Loghin (2021): the weighted mean of the samples of each light.

use ndarray::{Array2, ArrayView1, ArrayView2, Axis};

use crate::error::Result;
use crate::kernels::sphere::{check_lengths, check_not_negative, check_rows};

/// Weighted mean `sum(w p) / sum(w)` of the `points` of each light.
///
/// `points` is (n, d). The result, (m, d), has a row for each distinct number in `light`, in rising order.
///
/// If all `weights` of a light are 0, its points count equally.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`],
/// [`crate::error::Error::LengthMismatch`]; [`crate::error::Error::Negative`] for a weight.
pub fn weighted_means(
    points: ArrayView2<'_, f64>,
    weights: ArrayView1<'_, f64>,
    light: ArrayView1<'_, i64>,
) -> Result<Array2<f64>> {
    check_rows("points", points, points.ncols())?;
    check_rows("weights", weights.insert_axis(Axis(1)), 1)?;
    check_lengths("points", points.nrows(), [("weights", weights.len()), ("light", light.len())])?;
    check_not_negative("weights", weights.iter().copied())?;
    // Number the lights in rising order.
    let mut lights = light.to_vec();
    lights.sort_unstable();
    lights.dedup();
    let rank: Vec<usize> = light.iter().map(|light| lights.partition_point(|other| other < light)).collect();
    // Sum the weights of each; give equal weights to the points of a light without any.
    let weight_of = sums(&rank, weights, lights.len());
    let weights: Vec<f64> = rank
        .iter()
        .zip(weights)
        .map(|(&rank, &weight)| if weight_of[rank] > 0.0 { weight } else { 1.0 })
        .collect();
    let total = sums(&rank, &weights, lights.len());
    // Divide the weighted sum of each light's points by its total weight.
    let mut means = Array2::zeros((lights.len(), points.ncols()));
    for ((point, &rank), weight) in points.outer_iter().zip(&rank).zip(&weights) {
        means.row_mut(rank).scaled_add(*weight, &point);
    }
    for (mut mean, total) in means.outer_iter_mut().zip(total) {
        mean /= total;
    }
    Ok(means)
}

/// Sum of the `values` of each rank.
fn sums<'a>(rank: &[usize], values: impl IntoIterator<Item = &'a f64>, ranks: usize) -> Vec<f64> {
    let mut sums = vec![0.0; ranks];
    for (&rank, value) in rank.iter().zip(values) {
        sums[rank] += value;
    }
    sums
}
