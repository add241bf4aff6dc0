//! The dot product in wide vectors: sums in lanes that do not wait for one another.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

/// Sum of products.
#[inline(always)]
pub fn dot<T: Copy + Into<f64>>(values: &[T], weights: &[f64]) -> f64 {
    let (most, values, weights) = in_lanes::<16, T>(values, weights);
    let (more, values, weights) = in_lanes::<4, T>(values, weights);
    let last: f64 = values.iter().zip(weights).map(|(&value, weight)| value.into() * weight).sum();
    most + more + last
}

/// Sum of products in `LANES` lanes, and the remainders of both slices.
#[inline(always)]
fn in_lanes<'a, const LANES: usize, T: Copy + Into<f64>>(
    values: &'a [T],
    weights: &'a [f64],
) -> (f64, &'a [T], &'a [f64]) {
    let (values, last_values) = values.as_chunks::<LANES>();
    let (weights, last_weights) = weights.as_chunks::<LANES>();
    let mut lanes = [0.0_f64; LANES];
    for (values, weights) in values.iter().zip(weights) {
        for (lane, (&value, weight)) in lanes.iter_mut().zip(values.iter().zip(weights)) {
            *lane += value.into() * weight;
        }
    }
    (total(lanes), last_values, last_weights)
}

/// Sum of the lanes: add the upper half to the lower one until one lane is left.
#[inline(always)]
fn total<const LANES: usize>(mut lanes: [f64; LANES]) -> f64 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            lanes[i] += lanes[i + half];
        }
        half /= 2;
    }
    lanes[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_last_products_are_summed_too() {
        let values: Vec<f32> = (0..39).map(|i| i as f32).collect();
        let weights: Vec<f64> = (0..39).map(f64::from).collect();
        assert_relative_eq!(dot(&values, &weights), 19019.0);
    }
}
