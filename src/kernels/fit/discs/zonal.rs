//! Zonal functions in Legendre polynomials: the kernels that compare two distributions of light, and discs.
//!
//! Two distributions of radiance have the inner product `<L, L'> = integral of L(w) K(w.w') L'(w')`. At the angle g,
//!
//! ```text
//!   probe      G = 2/3 (sin g + (pi - g) cos g)       products of irradiance, over all normals
//!   shadows    K = G (1 - g/pi) / 2                   the same, over all planes that hide their far side as well
//! ```
//!
//! (two directions at the angle g are in front of a plane with the probability `(pi - g) / 2 pi`; the factor pi is
//! left out). K has a cone at g = 0, of the slope -1/3. With the chord `q = 2 sin(g/2)`, K + q/3 has none, and its
//! series ends as fast as that of G: the cone is done apart, in `chord.rs`.
//!
//! A disc of radius a and flux 1, with x = cos a, has in degree k the factor
//!
//! ```text
//!   d_k = (1 + x) P_k'(x) / (k (k + 1))        d_0 = 1
//! ```

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::array::from_fn;
use std::f64::consts::PI;
use std::sync::LazyLock;

use super::jet::Jet;
use crate::kernels::fit::lanes::Number;
use crate::kernels::sampling::gauss_legendre;

/// The highest degree of the map, and of what is left of a kernel without its cone.
pub const DEGREE: usize = 40;
/// Degrees from 0 on.
pub const DEGREES: usize = DEGREE + 1;

/// How lights are compared with the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// A white probe with nothing in the way.
    Probe,
    /// A white probe behind every plane.
    Shadows,
    /// A weighted mean of both, each over its own mean.
    Mixed,
}

/// Share of the probe in [`Comparison::Mixed`]. Shadows err several times as much as the probe, and errors count
/// squared: with this share, on 21 real maps, hardly any has a worse probe than without sizes, and shadows are nearly
/// as good as they can be.
const PROBE_SHARE: f64 = 0.973;

/// A kernel.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// What it multiplies harmonics of each degree by.
    pub whole: [f64; DEGREES],
    /// The same without its cone.
    pub smooth: [f64; DEGREES],
    /// Its cone is this times the chord, taken away.
    pub cone: f64,
}

impl Kernel {
    pub fn new(comparison: Comparison) -> Self {
        let [probe, shadows] = &*SPECTRA;
        // Over its mean over the sphere, which is its factor of degree 0.
        let mixed =
            |k: usize| PROBE_SHARE * probe[k] / probe[0] + (1.0 - PROBE_SHARE) * shadows[k] / shadows[0];
        let (whole, cone) = match comparison {
            Comparison::Probe => (*probe, 0.0),
            Comparison::Shadows => (*shadows, 1.0 / 3.0),
            Comparison::Mixed => (from_fn(mixed), (1.0 - PROBE_SHARE) / (3.0 * shadows[0])),
        };
        Self { whole, smooth: from_fn(|k| whole[k] + cone * chord_factor(k)), cone }
    }

    /// The value of the next alone.
    pub fn smooth_value(&self, cosine: f64, a: &Factors, b: &Factors) -> f64 {
        let (mut before, mut last, mut sum) = (0.0, 1.0, 0.0);
        for k in 0..DEGREES {
            let degree = k as f64;
            sum += (2.0 * degree + 1.0) * self.smooth[k] * a[k][0] * b[k][0] * last;
            (before, last) =
                (last, ((2.0 * degree + 1.0) * cosine * last - degree * before) / (degree + 1.0));
        }
        sum / (4.0 * PI)
    }

    /// The smooth part between two discs, from the cosine of their centres and their A.
    pub fn smooth_product(&self, cosine: f64, a: &Factors, b: &Factors) -> Jet<3> {
        let legendre = legendre(cosine);
        let mut out = Jet::constant(0.0);
        for k in 0..DEGREES {
            let weight = (2 * k + 1) as f64 / (4.0 * PI) * self.smooth[k];
            let ([p, pc, pcc], [a, aa, aaa], [b, bb, bbb]) = (legendre[k].map(|p| p * weight), a[k], b[k]);
            out.value += p * a * b;
            out.first[0] += pc * a * b;
            out.first[1] += p * aa * b;
            out.first[2] += p * a * bb;
            out.second[0][0] += pcc * a * b;
            out.second[0][1] += pc * aa * b;
            out.second[0][2] += pc * a * bb;
            out.second[1][1] += p * aaa * b;
            out.second[1][2] += p * aa * bb;
            out.second[2][2] += p * a * bbb;
        }
        for (i, k) in [(1, 0), (2, 0), (2, 1)] {
            out.second[i][k] = out.second[k][i];
        }
        out
    }
}

/// `d_k` of a disc, and its derivatives by A = sin^2(a/2).
pub type Factors<T = f64> = [[T; 3]; DEGREES];

/// Those of the disc of `A`.
#[inline(always)]
pub fn factors<T: Number>(a: T) -> Factors<T> {
    let of = |value: f64| a.like(value);
    let x = of(1.0) - of(2.0) * a;
    let mut polynomials = [[of(0.0); 4]; DEGREES];
    polynomials[0][0] = of(1.0);
    let mut out = [[of(0.0); 3]; DEGREES];
    out[0][0] = of(1.0);
    for k in 1..DEGREES {
        polynomials[k] = next(&polynomials, k, x);
        let [_, d, dd, ddd] = polynomials[k];
        let scale = of(1.0 / (k * (k + 1)) as f64);
        let wide = (of(1.0) + x) * scale;
        // x falls twice as fast as A grows.
        out[k] = [
            wide * d,
            of(-2.0) * (wide * dd).add_product(scale, d),
            of(4.0) * (wide * ddd).add_product(of(2.0) * scale, dd),
        ];
    }
    out
}

/// `P_k` and its first derivatives, from those before: `P_(k+1)^(n) = P_(k-1)^(n) + (2k+1) P_k^(n-1)`.
#[inline(always)]
fn next<const N: usize, T: Number>(before: &[[T; N]], k: usize, x: T) -> [T; N] {
    let last = before[k - 1];
    let but_one = if k > 1 { before[k - 2] } else { [x.like(0.0); N] };
    let (odd, degree) = ((2 * k - 1) as f64, k as f64);
    let mut out = but_one;
    out[0] = (but_one[0] * x.like((1.0 - degree) / degree)).add_product(x * x.like(odd / degree), last[0]);
    for n in 1..N {
        out[n] = but_one[n].add_product(x.like(odd), last[n - 1]);
    }
    out
}

/// `P_k(c)` and its first two derivatives.
fn legendre(c: f64) -> [[f64; 3]; DEGREES] {
    let mut out = [[0.0; 3]; DEGREES];
    out[0][0] = 1.0;
    for k in 1..DEGREES {
        out[k] = next(&out, k, c);
    }
    out
}

/// `P_k(c)` of that many degrees.
pub fn legendre_values(c: f64, count: usize) -> Vec<f64> {
    let mut out = vec![[1.0]];
    for k in 1..count {
        out.push(next(&out, k, c));
    }
    out.into_iter().map(|[value]| value).collect()
}

/// `d_k` of the disc of A, of that many degrees.
pub fn disc_factors(a: f64, count: usize) -> Vec<f64> {
    let x = 1.0 - 2.0 * a;
    let mut polynomials = vec![[1.0, 0.0]];
    for k in 1..count {
        polynomials.push(next(&polynomials, k, x));
    }
    let factor = |k: usize| (1.0 + x) * polynomials[k][1] / (k * (k + 1)) as f64;
    (0..count).map(|k| if k == 0 { 1.0 } else { factor(k) }).collect()
}

/// What |x - y| multiplies harmonics of degree k by when it is convolved with them.
pub fn chord_factor(k: usize) -> f64 {
    let k = 2.0 * k as f64;
    -16.0 * PI / ((k - 1.0) * (k + 1.0) * (k + 3.0))
}

/// What the kernels of the probe and of shadows multiply harmonics of each degree by: `2 pi` times the integral of
/// `K(g) P_k(cos g) sin g`. It is smooth in g, so that Gauss's quadrature is exact to rounding.
static SPECTRA: LazyLock<[[f64; DEGREES]; 2]> = LazyLock::new(|| {
    let (nodes, weights) = gauss_legendre(8 * DEGREES);
    let mut out = [[0.0; DEGREES]; 2];
    for (node, weight) in nodes.iter().zip(&weights) {
        let g = 0.5 * PI * (1.0 + node);
        let (sine, cosine) = g.sin_cos();
        let probe = 2.0 / 3.0 * (sine + (PI - g) * cosine);
        let shadows = probe * 0.5 * (1.0 - g / PI);
        for (k, value) in legendre_values(cosine, DEGREES).into_iter().enumerate() {
            let share = PI * PI * weight * sine * value;
            out[0][k] += share * probe;
            out[1][k] += share * shadows;
        }
    }
    out
});

#[cfg(test)]
mod tests {
    use super::*;
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
        let disc = factors(0.0);
        assert_relative_eq!(kernel.smooth_product(1.0, &disc, &disc).value, PI / 3.0, max_relative = 2e-5);
    }

    /// A cap of uniform radiance has the mean of the Legendre polynomial over it.
    #[test]
    fn factors_of_a_disc_are_means_over_it() {
        for radius in [0.02, 0.4, 1.2_f64] {
            let share = (0.5 * radius).sin().powi(2);
            let nodes = (0..20_000).map(|i| 1.0 - 2.0 * share * (f64::from(i) + 0.5) / 20_000.0);
            let mut means = vec![0.0; DEGREES];
            for x in nodes {
                let values = legendre_values(x, DEGREES);
                means.iter_mut().zip(values).for_each(|(mean, value)| *mean += value / 20_000.0);
            }
            for (k, [value, ..]) in factors(share).into_iter().enumerate() {
                assert!((value - means[k]).abs() < 1e-6, "{radius} {k}: {value} {}", means[k]);
            }
        }
    }
}
