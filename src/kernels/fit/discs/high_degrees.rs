//! Products of bright parts and lights in the degrees above those of the harmonics, under the kernel of the probe.
//!
//! The irradiance of a lamp has 0.2 % of its RMS there: much of the error of a good fit. For two discs of flux 1 whose
//! centres have the cosine c, the product is
//!
//! ```text
//!   sum over even k > DEGREE of (2k + 1) / (4 pi) G_k d_k(A) d_k(B) P_k(c)
//! ```
//!
//! Between some degrees the product of the factors is interpolated, and a table over |c| holds the sum of all else.

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

use crate::kernels::expansion::{DEGREE, DiscOfFlux, disc_series, legendre_values};
use crate::kernels::fit::sphere::spectrum;

/// Degrees between which factors of discs are interpolated. The ones above the last hold 0.5 % of the sum for two points.
/// Four nodes, at the degrees 42, 54, 76 and 120, made the stated error of 8 lights in a studio 12 % too large.
const NODES: [usize; 16] = [DEGREE + 2, 44, 46, 48, 50, 52, 54, 58, 62, 68, 74, 82, 92, 110, 150, 240];
/// Cells of the table over `sqrt(1 - |c|)`. It ends at 1/4, where the sum is below 2 % of that for one direction.
const CELLS: usize = 2048;

/// Discs with their fluxes, and their factors at [`NODES`].
#[derive(Clone, Debug)]
pub struct HighDegrees {
    discs: Vec<(DVec3, DVec3, [f64; NODES.len()])>,
    /// Product with itself, by channel.
    pub energy: DVec3,
}

impl HighDegrees {
    pub fn new(discs: impl Iterator<Item = DiscOfFlux>) -> Self {
        let with_factors = |(direction, share, flux): DiscOfFlux| {
            let series = disc_series(share, NODES[NODES.len() - 1] + 1);
            (direction, DVec3::from_array(flux), NODES.map(|degree| series[degree]))
        };
        let mut out = Self { discs: discs.map(with_factors).collect(), energy: DVec3::ZERO };
        out.energy = out.product(&out);
        out
    }

    /// Energy of the difference from `others`, by channel.
    pub fn difference(&self, others: &Self) -> DVec3 {
        self.energy + others.energy - 2.0 * self.product(others)
    }

    fn product(&self, others: &Self) -> DVec3 {
        let (table, mut sum) = (&*TABLE, DVec3::ZERO);
        for (direction, flux, own) in &self.discs {
            for (other_direction, other_flux, factors) in &others.discs {
                let cosine = direction.dot(*other_direction).abs().min(1.0);
                let cell = (1.0 - cosine).sqrt() * CELLS as f64;
                if let Some([start, end]) = table.get(cell as usize..).and_then(<[_]>::first_chunk) {
                    let at = |i: usize| start[i] + cell.fract() * (end[i] - start[i]);
                    let product: f64 = (0..NODES.len()).map(|i| own[i] * factors[i] * at(i)).sum();
                    sum += product * *flux * *other_flux;
                }
            }
        }
        sum
    }
}

/// Sums over the degrees by their weights of interpolation, for each |c|.
static TABLE: LazyLock<Vec<[f64; NODES.len()]>> = LazyLock::new(|| {
    let count = NODES[NODES.len() - 1] + 1;
    let kernel = spectrum(count.div_ceil(2));
    let sums = |i: usize| {
        let values = legendre_values(1.0 - (i as f64 / CELLS as f64).powi(2), count);
        let mut out = [0.0; NODES.len()];
        for k in (NODES[0]..count).step_by(2) {
            let term = (2 * k + 1) as f64 / (4.0 * PI) * kernel[k / 2] * values[k];
            let next = NODES.partition_point(|&node| node <= k).min(NODES.len() - 1);
            let [before, after] = [NODES[next - 1], NODES[next]];
            let weight = (k - before) as f64 / (after - before) as f64;
            out[next - 1] += (1.0 - weight) * term;
            out[next] += weight * term;
        }
        out
    };
    (0..=CELLS / 4).map(sums).collect()
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;

    /// Against the series itself, with all its degrees and factors.
    #[test]
    fn products_are_those_of_the_series() {
        let whole = series(1.0, 0.0, 0.0);
        for (a, b, angle) in [
            (0.0, 0.0, 0.0_f64),
            (2e-5, 4e-5, 0.01),
            (5e-5, 5e-5, 0.03),
            (5e-5, 0.0, 0.09),
            (1e-3, 5e-5, 0.04),
            (1e-2, 1e-2, 0.0),
            (0.1, 1e-4, 0.5),
            (5e-5, 5e-5, 3.12),
        ] {
            let disc = |angle, share| {
                HighDegrees::new([(direction(angle, 0.3), share, [2.0, 1.0, 0.0])].into_iter())
            };
            let seen = disc(0.4, a).product(&disc(0.4 + angle, b));
            let off = seen.y - series(angle.cos(), a, b);
            assert!(off.abs() < 0.01 * whole, "{a} {b} {angle}: {} of {}", off / whole, seen.y / whole);
            assert!((seen.x - 4.0 * seen.y).abs() < 1e-18 && seen.z == 0.0, "{seen}");
        }
    }

    fn series(cosine: f64, a: f64, b: f64) -> f64 {
        let count = 1000;
        let (kernel, values) = (spectrum(count / 2), legendre_values(cosine, count));
        let [ones, others] = [a, b].map(|share| disc_series(share, count));
        let term =
            |k: usize| (2 * k + 1) as f64 / (4.0 * PI) * kernel[k / 2] * ones[k] * others[k] * values[k];
        (DEGREE + 2..count).step_by(2).map(term).sum()
    }
}
