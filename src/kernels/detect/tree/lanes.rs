//! Sums of products, side by side.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

/// Sum of products, in lanes that do not wait for one another.
#[inline(always)]
pub fn dot<T: Copy + Into<f64>>(values: &[T], weights: &[f64]) -> f64 {
    let ((values, last_values), (weights, last_weights)) =
        (values.as_chunks::<4>(), weights.as_chunks::<4>());
    let mut lanes = [0.0_f64; 4];
    for (values, weights) in values.iter().zip(weights) {
        for (lane, (&value, weight)) in lanes.iter_mut().zip(values.iter().zip(weights)) {
            *lane += value.into() * weight;
        }
    }
    let last: f64 = last_values.iter().zip(last_weights).map(|(&value, weight)| value.into() * weight).sum();
    lanes.iter().sum::<f64>() + last
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn products_are_summed_to_the_last() {
        let values: Vec<f32> = (0..11).map(|i| i as f32).collect();
        let weights: Vec<f64> = (0..11).map(f64::from).collect();
        assert_relative_eq!(dot(&values, &weights), 385.0);
    }
}
