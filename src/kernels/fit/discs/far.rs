//! The number rho of `chord.rs` for discs that are far apart for their sizes.
//!
//! With d = |x - y| between the centres and the Laplacian D, the mean over a disc is `1 + A/2 D + A^2/12 D (D + 2) + ..`:
//! its factors of degree k, as a series in A, with `k (k + 1) = -D`. Both discs' together, on
//!
//! ```text
//!   D d = 1/d - 3 d/4        D^2 d = 1/d^3 - 1/(2 d) + 9 d/16
//! ```
//!
//! give M to second order, and so rho to first:
//!
//! ```text
//!   rho = p ((r/2 - 3/4) c + (1 - r/2) / 6 (1/d^2 + 3/2 - 15 d^2/16) + r/8 (1/d^2 - 1/2 + 9 d^2/16))
//! ```

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use crate::kernels::fit::jet::Jet;
use crate::kernels::lanes::Number;

/// True if [`far`] is accurate to 5e-8 of the distance.
#[inline(always)]
pub fn are_far([w, _, p]: [f64; 3]) -> bool {
    w < 0.02 && p < 0.01
}

/// rho, the formula above.
#[inline(always)]
pub fn far<const N: usize, T: Number>([w, r, p]: [Jet<N, T>; 3]) -> Jet<N, T> {
    let cosine = (w * (p * 2.0 + 1.0) - p) * (p + w).recip();
    let square = cosine * -2.0 + 2.0;
    let over = square.recip();
    let alike = (r * -0.5 + 1.0) * (over + square * (-15.0 / 16.0) + 1.5) * (1.0 / 6.0);
    let mixed = r * (over + square * (9.0 / 16.0) + -0.5) * (1.0 / 8.0);
    p * (cosine * (r * 0.5 + -0.75) + alike + mixed)
}

/// Derivatives of rho along w, r and p, up to two together.
#[inline(always)]
pub fn far_orders<const ORDERS: usize>(at: [f64; 3]) -> [[[f64; ORDERS]; ORDERS]; ORDERS] {
    let mut out = [[[0.0; ORDERS]; ORDERS]; ORDERS];
    if ORDERS < 3 {
        out[0][0][0] = far(at.map(Jet::<0>::constant)).value;
        return out;
    }
    let rho = far([0, 1, 2].map(|i| Jet::<3>::variable(at[i], i)));
    out[0][0][0] = rho.value;
    for i in 0..3 {
        let order = |axis: usize| usize::from(i == axis);
        out[order(0)][order(1)][order(2)] = rho.first[i];
        for k in 0..=i {
            let order = |axis: usize| usize::from(i == axis) + usize::from(k == axis);
            out[order(0)][order(1)][order(2)] = rho.second[i][k];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::are_far;
    use crate::kernels::expansion::{disc_series, legendre_values};
    use crate::kernels::fit::discs::chord::mean_distance;
    use crate::kernels::fit::discs::zonal::chord_factor;
    use crate::kernels::fit::jet::Jet;

    /// Against the series itself, that of the whole chord.
    #[test]
    fn far_apart_the_mean_is_that_of_the_series() {
        const TERMS: usize = 1500;
        for (a, b, c) in [
            (2e-3, 3e-3, -0.99),
            (5e-3, 1e-4, 0.0),
            (5e-4, 5e-4, 0.899),
            (8e-4, 1e-4, 0.89),
            (4e-3, 4e-3, 0.25),
            (9e-3, 5e-4, -0.2),
        ] {
            let p = a + b;
            assert!(are_far([p * (1.0 + c) / (1.0 - c + 2.0 * p), 0.0, p]));
            let [ones, others] = [a, b].map(|share| disc_series(share, TERMS));
            let values = legendre_values(c, TERMS);
            let term = |k: usize| {
                let fade = (5.0 * (1.0 - k as f64 / TERMS as f64)).min(1.0);
                let factors = chord_factor(k) * ones[k] * others[k] * fade * fade * (3.0 - 2.0 * fade);
                (2 * k + 1) as f64 / (4.0 * PI) * factors * values[k]
            };
            let wanted: f64 = (0..TERMS).map(term).sum();
            let seen = mean_distance(Jet::<0>::constant(c), Jet::constant(a), Jet::constant(b));
            assert!((seen.value / wanted - 1.0).abs() < 1e-7, "{a} {b} {c}: {} {wanted}", seen.value);
        }
    }
}
