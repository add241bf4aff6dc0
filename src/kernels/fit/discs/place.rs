//! A place on the sphere, and the Legendre functions at its height.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

use super::zonal::DEGREES;
use crate::kernels::fit::lanes::Number;
use crate::kernels::sphere::{angle_derivatives, angles};

/// A place on the sphere, and its frame: towards growing theta, and growing phi.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub frame: [DVec3; 2],
    pub azimuth: f64,
    pub cosine: f64,
    pub sine: f64,
}

impl Place {
    /// That of a direction, at least a little beside the poles.
    pub fn new(direction: DVec3) -> Self {
        /// Formulas divide by the sine.
        const LEAST_SINE: f64 = 1e-5;
        let (theta, azimuth) = angles(direction);
        let (sine, cosine) = theta.clamp(LEAST_SINE, PI - LEAST_SINE).sin_cos();
        let frame = [angle_derivatives(theta, azimuth)[0], angle_derivatives(0.5 * PI, azimuth)[1]];
        Self { frame, azimuth, cosine, sine }
    }
}

/// `P_lm` at one height, order by order.
///
/// From `x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)`, `a_l^2 = (l^2 - m^2) / (4 l^2 - 1)`.
#[derive(Debug)]
pub struct Legendre<T = f64> {
    x: T,
    sine: T,
    sectoral: T,
    column: [T; DEGREES],
}

/// `1 / a_l`, `a_(l-1) / a_l` and `(2l + 1) a_l` for each order and degree.
pub static RECURRENCE: LazyLock<Vec<[[f64; 3]; DEGREES]>> = LazyLock::new(|| {
    let factor = |l: usize, m: usize| {
        let (l, m) = (l as f64, m as f64);
        ((l * l - m * m) / (4.0 * l * l - 1.0)).max(0.0).sqrt()
    };
    let factors = |l: usize, m: usize| {
        let (before, a) = (factor(l.saturating_sub(1), m), factor(l, m));
        [1.0 / a, before / a, (2 * l + 1) as f64 * a]
    };
    (0..DEGREES).map(|m| std::array::from_fn(|l| factors(l, m))).collect()
});

impl<T: Number> Legendre<T> {
    pub fn new(x: T, sine: T) -> Self {
        Self { x, sine, sectoral: x.like((0.25 / PI).sqrt()), column: [x.like(0.0); DEGREES] }
    }

    /// All degrees of the order m, 0 below it; call it for m = 0, 1, 2, ..
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
