//! Zonal functions in Legendre polynomials: the kernels that compare two distributions of light, and discs.
//!
//! Two distributions of radiance have the inner product `<L, L'> = integral of L(w) K(w.w') L'(w')`. At the angle g,
//!
//! ```text
//!   probe      G = 2/3 (sin g + (pi - g) cos g)       products of irradiance, over all normals
//!   shadows    K = G (1 - g/pi) / 2                   products of shadowed irradiance, over all normals and all blocking planes
//! ```
//!
//! Two directions at the angle g lie in front of a random plane with the probability `(pi - g) / 2 pi`, the
//! factor of G in K. K has a cone at g = 0, with the slope -1/3, so its series converges slowly. With the chord `q = 2 sin(g/2)`, the
//! sum K + q/3 has no cone, and its series converges as fast as that of G. `chord.rs` integrates the chord.

use std::array::from_fn;
use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::kernels::expansion::{DEGREES, DiscFactors, legendre_values, set_legendre};
use crate::kernels::fit::comparison::Comparison;
use crate::kernels::fit::jet::Jet;
use crate::kernels::fit::settings::DISCS;
use crate::kernels::sampling::gauss_legendre;

/// A kernel.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// Factor of each degree.
    pub whole: [f64; DEGREES],
    /// Factor of each degree without the cone.
    pub smooth: [f64; DEGREES],
    /// Weights of the Legendre polynomials in the smooth part.
    weights: [f64; DEGREES],
    /// Factor of the chord: the kernel is its smooth part minus this factor times the chord.
    pub cone: f64,
}

impl Kernel {
    pub fn new(comparison: Comparison) -> Self {
        static SPECTRA: LazyLock<[Vec<f64>; 2]> = LazyLock::new(|| kernel_spectra(DEGREES));
        let [probe, shadows] = &*SPECTRA;
        // Divide each kernel by its factor of degree 0, its integral over the sphere.
        let mixed =
            |k: usize| DISCS.probe * probe[k] / probe[0] + (1.0 - DISCS.probe) * shadows[k] / shadows[0];
        let (whole, cone) = match comparison {
            Comparison::Probe => (from_fn(|k| probe[k]), 0.0),
            Comparison::Shadows => (from_fn(|k| shadows[k]), 1.0 / 3.0),
            Comparison::Mixed => (from_fn(mixed), (1.0 - DISCS.probe) / (3.0 * shadows[0])),
        };
        let smooth: [f64; DEGREES] = from_fn(|k| whole[k] + cone * chord_factor(k));
        let weights = from_fn(|k| (2 * k + 1) as f64 / (4.0 * PI) * smooth[k]);
        Self { whole, smooth, weights, cone }
    }

    /// The smooth part between two discs, from the cosine between their centres and their factors.
    ///
    /// If N is 3, the result has derivatives by the cosine and by `sin^2(a/2)` of each disc of angular radius a.
    pub fn smooth_product<const N: usize>(&self, cosine: f64, a: &DiscFactors, b: &DiscFactors) -> Jet<N> {
        if N == 0 {
            return Jet::constant(self.smooth_value(cosine, a, b));
        }
        let mut legendre = [[0.0; 3]; DEGREES];
        set_legendre(cosine, &mut legendre);
        let mut out = Jet::constant(0.0);
        for k in 0..DEGREES {
            let weight = self.weights[k];
            let ([p, pc, pcc], [a, aa, aaa], [b, bb, bbb]) = (legendre[k].map(|p| p * weight), a[k], b[k]);
            out.value += p * a * b;
            let first = [pc * a * b, p * aa * b, p * a * bb];
            let second = [
                [pcc * a * b, pc * aa * b, pc * a * bb],
                [pc * aa * b, p * aaa * b, p * aa * bb],
                [pc * a * bb, p * aa * bb, p * a * bbb],
            ];
            for i in 0..N {
                out.first[i] += first[i];
                (0..N).for_each(|k| out.second[i][k] += second[i][k]);
            }
        }
        out
    }

    /// The value of [`Self::smooth_product`] alone.
    fn smooth_value(&self, cosine: f64, a: &DiscFactors, b: &DiscFactors) -> f64 {
        let mut legendre = [[0.0]; DEGREES];
        set_legendre(cosine, &mut legendre);
        (0..DEGREES).map(|k| legendre[k][0] * self.weights[k] * a[k][0] * b[k][0]).sum()
    }
}

/// Factor of degree k when harmonics are convolved with |x - y|.
pub fn chord_factor(k: usize) -> f64 {
    let k = 2.0 * k as f64;
    -16.0 * PI / ((k - 1.0) * (k + 1.0) * (k + 3.0))
}

/// Factors of the kernels of the probe and of shadows, for this many degrees.
///
/// Each is `2 pi` times the integral of `K(g) P_k(cos g) sin g`, smooth in g, so Gauss's quadrature is exact to rounding.
pub fn kernel_spectra(degrees: usize) -> [Vec<f64>; 2] {
    let (nodes, weights) = gauss_legendre(8 * degrees);
    let mut out = [vec![0.0; degrees], vec![0.0; degrees]];
    for (node, weight) in nodes.iter().zip(&weights) {
        let g = 0.5 * PI * (1.0 + node);
        let (sine, cosine) = g.sin_cos();
        let probe = 2.0 / 3.0 * (sine + (PI - g) * cosine);
        let shadows = probe * 0.5 * (1.0 - g / PI);
        for (k, value) in legendre_values(cosine, degrees).into_iter().enumerate() {
            let share = PI * PI * weight * sine * value;
            out[0][k] += share * probe;
            out[1][k] += share * shadows;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::expansion::{DEGREE, disc_factors};
    use approx::assert_relative_eq;

    /// The squares of the factors of a clamped cosine (Ramamoorthi and Hanrahan 2001, equation 8).
    #[test]
    fn the_kernel_of_the_probe_has_the_spectrum_of_two_clamped_cosines() {
        let whole = Kernel::new(Comparison::Probe).whole;
        for (k, factor) in [(0, PI), (1, 2.0 * PI / 3.0), (2, PI / 4.0), (3, 0.0), (4, PI / 24.0)] {
            assert!((whole[k] - factor * factor).abs() < 1e-12, "{k}: {}", whole[k]);
        }
    }

    /// Without its cone the kernel of shadows falls off like that of the probe, so that few degrees are enough.
    #[test]
    fn the_smooth_part_of_shadows_ends_soon() {
        let kernel = Kernel::new(Comparison::Shadows);
        let last = [&kernel.whole, &kernel.smooth].map(|factors| factors[DEGREE]);
        assert!(last[0] > 1e-5 && last[1].abs() < 2e-7, "{last:?}");
        // At g = 0 the cone is 0, and the sum of the smooth part is K(0) = pi / 3.
        let disc = disc_factors(0.0);
        assert_relative_eq!(
            kernel.smooth_product::<0>(1.0, &disc, &disc).value,
            PI / 3.0,
            max_relative = 2e-5
        );
    }
}
