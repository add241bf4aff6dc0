//! Legendre functions and polynomials, and the factors of a disc.
//!
//! A disc of radius a and flux 1, with x = cos a, has in degree k the factor
//!
//! ```text
//!   d_k = (1 + x) P_k'(x) / (k (k + 1))        d_0 = 1
//! ```

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::kernels::lanes::Number;

/// Highest degree of the harmonics. The kernels of the fit fall off as `degree^-5`, so the cells of the working map limit
/// the error, not the harmonics.
pub const DEGREE: usize = 40;
/// Number of degrees, and of orders.
pub const DEGREES: usize = DEGREE + 1;

/// `P_lm` at one height, order by order.
///
/// The recurrence is `x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)` with `a_l^2 = (l^2 - m^2) / (4 l^2 - 1)`.
#[derive(Debug)]
pub struct AssociatedLegendre<T = f64> {
    x: T,
    sine: T,
    sectoral: T,
    column: [T; DEGREES],
}

/// `1 / a_l`, `a_(l-1) / a_l` and `(2l + 1) a_l` for each order and degree.
pub static RECURRENCE: LazyLock<Vec<[[f64; 3]; DEGREES]>> = LazyLock::new(|| {
    let factors = |l: usize, m: usize| {
        let (before, a) = (factor(l.saturating_sub(1), m), factor(l, m));
        [1.0 / a, before / a, (2 * l + 1) as f64 * a]
    };
    (0..DEGREES).map(|m| std::array::from_fn(|l| factors(l, m))).collect()
});

/// `a_l` of the order m; 0 below it.
fn factor(l: usize, m: usize) -> f64 {
    let (l, m) = (l as f64, m as f64);
    ((l * l - m * m) / (4.0 * l * l - 1.0)).max(0.0).sqrt()
}

impl<T: Number> AssociatedLegendre<T> {
    /// Start at the order 0, at the height `x` above the equator.
    #[inline(always)]
    pub fn new(x: T, sine: T) -> Self {
        Self { x, sine, sectoral: x.like((0.25 / PI).sqrt()), column: [x.like(0.0); DEGREES] }
    }

    /// All degrees of the order m, 0 below it. Call it for m = 0, 1, 2, .. in this order.
    #[inline(always)]
    pub fn column(&mut self, m: usize) -> &[T; DEGREES] {
        let of = |value: f64| self.x.like(value);
        if m > 0 {
            let odd = 2.0 * m as f64 + 1.0;
            let factor = if m == 1 { 3.0_f64.sqrt() } else { (odd / (odd - 1.0)).sqrt() };
            self.sectoral = self.sectoral * self.sine * of(factor);
            self.column[m - 1] = of(0.0);
        }
        self.column[m] = self.sectoral;
        let factors = &RECURRENCE[m];
        let (mut before, mut last) = (of(0.0), self.sectoral);
        for l in m + 1..DEGREES {
            let [over, ratio, _] = factors[l];
            (before, last) = (last, (before * of(-ratio)).add_product(self.x * of(over), last));
            self.column[l] = last;
        }
        &self.column
    }
}

/// Call `visit` with each degree from the order `m` to `degree`, and with `P_lm` at all heights.
///
/// It serves more degrees than [`DEGREE`], by the recurrence of [`AssociatedLegendre`].
pub fn visit_degrees(
    m: usize,
    degree: usize,
    heights: &[f64],
    sines: &[f64],
    visit: &mut dyn FnMut(usize, &[f64]),
) {
    let first = if m == 0 { 0.25 / PI } else { 0.5 / PI };
    let sectoral: f64 = (1..=m).map(|k| (2 * k + 1) as f64 / (2 * k) as f64).product::<f64>() * first;
    let mut last: Vec<f64> = sines.iter().map(|sine| sectoral.sqrt() * sine.powi(m as i32)).collect();
    let mut before = vec![0.0; last.len()];
    for l in m..=degree {
        visit(l, &last);
        let next = 1.0 / factor(l + 1, m);
        let back = if l == m { 0.0 } else { factor(l, m) * next };
        for ((before, last), x) in before.iter_mut().zip(&mut last).zip(heights) {
            (*before, *last) = (*last, next * x * *last - back * *before);
        }
    }
}

/// `d_k` of a disc, and its derivatives by A = sin^2(a/2).
pub type DiscFactors<T = f64> = [[T; 3]; DEGREES];

/// The factors of the disc of A = `a`.
#[inline(always)]
pub fn disc_factors<T: Number>(a: T) -> DiscFactors<T> {
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
        // Use dx / dA = -2.
        out[k] = [
            wide * d,
            of(-2.0) * (wide * dd).add_product(scale, d),
            of(4.0) * (wide * ddd).add_product(of(2.0) * scale, dd),
        ];
    }
    out
}

/// `P_k` and its derivatives, by `P_(k+1)^(n) = P_(k-1)^(n) + (2k+1) P_k^(n-1)`.
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

/// `P_k(c)` and its first N - 1 derivatives, of as many degrees as `out` has.
#[inline(always)]
pub fn set_legendre<const N: usize>(c: f64, out: &mut [[f64; N]]) {
    out[0] = [0.0; N];
    out[0][0] = 1.0;
    for k in 1..out.len() {
        out[k] = next(out, k, c);
    }
}

/// `P_k(c)` and its first N - 1 derivatives, of the first `count` degrees.
fn legendre_derivatives<const N: usize>(c: f64, count: usize) -> Vec<[f64; N]> {
    let mut out = vec![[0.0; N]; count];
    set_legendre(c, &mut out);
    out
}

/// `P_k(c)` of the first `count` degrees.
pub fn legendre_values(c: f64, count: usize) -> Vec<f64> {
    legendre_derivatives::<1>(c, count).into_iter().map(|[value]| value).collect()
}

/// `d_k` of the disc of A, of the first `count` degrees.
pub fn disc_series(a: f64, count: usize) -> Vec<f64> {
    let x = 1.0 - 2.0 * a;
    let polynomials = legendre_derivatives::<2>(x, count).into_iter().enumerate();
    polynomials.map(|(k, [_, d])| if k == 0 { 1.0 } else { (1.0 + x) * d / (k * (k + 1)) as f64 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of uniform radiance has the mean of each Legendre polynomial over it.
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
            for (k, [value, ..]) in disc_factors(share).into_iter().enumerate() {
                assert!((value - means[k]).abs() < 1e-6, "{radius} {k}: {value} {}", means[k]);
            }
        }
    }
}
