//! Irradiance of a light that is a disc of uniform radiance, at any normal.
//!
//! A disc of the angular radius a around the direction l, with the irradiance E at normal incidence, has the
//! radiance `E / (pi sin^2 a)`. A normal n at the angle t to l sees all of it, a part, or nothing:
//!
//! ```text
//!   cos t >=  sin a     the whole disc is above the horizon: as if it were a point
//!   cos t <= -sin a     the whole disc is below it
//!   else                the horizon cuts the disc
//! ```
//!
//! For the last case, Lambert's formula adds up the boundary of the part in front (Snyder 1996, "Area light
//! sources for real-time graphics", MSR-TR-96-11; Lagarde and de Rousiers 2014, "Moving Frostbite to physically
//! based rendering", listing 7). With `q = cos t / sin a` and `s = sqrt(1 - q^2)`,
//!
//! ```text
//!   pi E(n) / E = cos t atan2(s, -q cos a)  +  atan2(s sin a, cos a) / sin^2 a  -  s cos a / sin a
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayView2};
use rayon::prelude::*;

use super::sphere::{check_lengths, from_vectors, unit_vectors, vectors};
use crate::error::{Error, Result};
use crate::interrupt;

/// Radius below which the last two terms of the formula cancel: each is `s / a`, and their sum `s a`.
const SMALL: f64 = 1e-2;

/// Irradiance of a disc at a normal, over its irradiance at normal incidence.
///
/// `cosine` is that of the angle between the normal and the centre of the disc, `radius` the angular radius in
/// 0 ..= pi / 2. A radius of 0 is a point: `max(0, cosine)`.
pub fn irradiance_share(cosine: f64, radius: f64) -> f64 {
    let (sin_radius, cos_radius) = radius.sin_cos();
    if cosine.abs() >= sin_radius {
        return cosine.max(0.0);
    }
    let q = cosine / sin_radius;
    let s = ((1.0 - q) * (1.0 + q)).sqrt();
    (cosine * s.atan2(-q * cos_radius) + along_horizon(s, radius)) / PI
}

/// Last two terms of the formula, which the edges of the visible part add.
///
/// For `u = s tan a`, they are `u - (u - atan u) / sin^2 a`; a small radius uses a series.
fn along_horizon(s: f64, radius: f64) -> f64 {
    let (sin_radius, cos_radius) = radius.sin_cos();
    if radius < SMALL {
        let u = s * radius.tan();
        let v = u * u;
        return u - u * (s / cos_radius).powi(2) * (1.0 / 3.0 - v * (1.0 / 5.0 - v * (1.0 / 7.0 - v / 9.0)));
    }
    (s * sin_radius).atan2(cos_radius) / sin_radius.powi(2) - s * cos_radius / sin_radius
}

/// Discs of uniform radiance, each with a direction, an irradiance at normal incidence and a radius.
#[derive(Clone, Debug)]
pub struct Discs {
    /// Towards the centre of each.
    pub directions: Vec<DVec3>,
    /// RGB.
    pub irradiance: Vec<DVec3>,
    /// Angular radii, in 0 ..= pi / 2.
    pub radii: Vec<f64>,
}

impl Discs {
    /// Discs of (m, 3) `directions`, (m, 3) `irradiance` and (m,) `radii`.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`], [`Error::LengthMismatch`],
    /// [`Error::OutOfRange`] for a radius.
    pub fn new(
        directions: ArrayView2<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
        radii: ArrayView1<'_, f64>,
    ) -> Result<Self> {
        let (directions, irradiance) =
            (unit_vectors("direction", directions)?, vectors("irradiance", irradiance)?);
        let lengths = [("irradiance", irradiance.len()), ("angular_radius", radii.len())];
        check_lengths("directions", directions.len(), lengths)?;
        let radii = radii.to_vec();
        match radii.iter().find(|radius| !(0.0..=FRAC_PI_2).contains(*radius)) {
            None => Ok(Self { directions, irradiance, radii }),
            Some(&value) => {
                Err(Error::OutOfRange { what: "angular_radius", value, least: 0.0, most: FRAC_PI_2 })
            }
        }
    }

    /// Irradiance of all discs at `normal`, plus that of the `sky`.
    fn add_at(&self, normal: DVec3, sky: DVec3) -> DVec3 {
        let positions = self.directions.iter().zip(&self.radii);
        positions.zip(&self.irradiance).fold(sky, |sum, ((direction, &radius), irradiance)| {
            sum + irradiance * irradiance_share(normal.dot(*direction), radius)
        })
    }
}

/// Irradiance at `normals`, (n, 3), of `discs` and of a `sky`: a function of the normal.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn irradiance(
    discs: &Discs,
    normals: ArrayView2<'_, f64>,
    sky: impl Fn(DVec3) -> DVec3 + Sync,
) -> Result<Array2<f64>> {
    let normals = unit_vectors("normal", normals)?;
    let at = |&normal: &DVec3| {
        interrupt::check();
        discs.add_at(normal, sky(normal))
    };
    let min_len = interrupt::min_task_len(normals.len());
    let received: Vec<DVec3> = normals.par_iter().with_min_len(min_len).map(at).collect();
    Ok(from_vectors(received.into_iter()))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    /// The sum of the cosine over a disc, in rings of the same solid angle around its centre.
    ///
    /// Each ring is rotated by a golden section of a sector, so that the horizon crosses sectors at all positions.
    fn brute_force(cosine: f64, radius: f64) -> f64 {
        let (rings, sectors) = (1500, 3000);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        // 1 - cos a, without the cancellation for a small radius.
        let cap = 2.0 * (radius / 2.0).sin().powi(2);
        let (mut visible, mut whole) = (0.0, 0.0);
        for ring in 0..rings {
            let depth = cap * (f64::from(ring) + 0.5) / f64::from(rings);
            let (along, across) = (1.0 - depth, (depth * (2.0 - depth)).sqrt());
            whole += along * f64::from(sectors);
            let turn = (f64::from(ring) * 0.618_033_988_749_894_9).fract();
            for sector in 0..sectors {
                let azimuth = TAU * (f64::from(sector) + turn) / f64::from(sectors);
                visible += (along * cosine + across * sine * azimuth.cos()).max(0.0);
            }
        }
        visible / whole
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn the_share_is_the_integral_over_the_disc(cosine in -1.0..=1.0_f64, radius in 1e-3..=FRAC_PI_2) {
            let (measured, expected) = (irradiance_share(cosine, radius), brute_force(cosine, radius));
            prop_assert!((measured - expected).abs() < 1e-6, "{measured} {expected}");
        }

        /// The horizon cuts most of these discs, but rarely a random small one.
        #[test]
        fn a_disc_on_the_horizon_is_integrated_too(q in -1.2..=1.2_f64, radius in -16.0..=0.4_f64) {
            let radius = radius.exp();
            let cosine = (q * radius.sin()).clamp(-1.0, 1.0);
            let (measured, expected) = (irradiance_share(cosine, radius), brute_force(cosine, radius));
            prop_assert!((measured - expected).abs() < 1e-6 * radius.max(1e-3), "{measured} {expected}");
        }
    }

    #[test]
    fn a_disc_of_radius_zero_is_a_point() {
        for cosine in [-1.0, -0.3, -1e-300, -0.0, 0.0, 1e-300, 0.3, 1.0] {
            assert_eq!(irradiance_share(cosine, 0.0).to_bits(), f64::max(cosine, 0.0).to_bits());
        }
    }

    #[test]
    fn half_the_sky_has_an_irradiance_of_its_visible_part() {
        for step in -100..=100 {
            let cosine = f64::from(step) / 100.0;
            let measured = irradiance_share(cosine, FRAC_PI_2);
            assert!((measured - f64::midpoint(1.0, cosine)).abs() < 1e-15, "{cosine}: {measured}");
        }
    }

    /// A tiny disc on the horizon is a flat one: `pi E = a (q acos(-q) + s - s^3 / 3)`.
    #[test]
    fn a_tiny_disc_is_flat() {
        for radius in [1e-12, 1e-9, 1e-6, 1e-4] {
            for step in -9..=9 {
                let q = f64::from(step) / 10.0;
                let s = (1.0 - q * q).sqrt();
                let flat = radius * (q * (-q).acos() + s - s.powi(3) / 3.0) / PI;
                let measured = irradiance_share(q * radius.sin(), radius);
                assert!(
                    (measured / flat - 1.0).abs() < 10.0 * radius * radius + 1e-12,
                    "{radius} {q}: {measured} {flat}"
                );
            }
        }
    }

    /// Both sides agree at the borders of the horizon, and at that of the series.
    #[test]
    fn the_cases_agree_at_their_borders() {
        for step in 1..=900 {
            let radius = (f64::from(step) / 10.0).to_radians();
            let sine = radius.sin();
            for (border, inside) in [(sine, sine.next_down()), (-sine, (-sine).next_up())] {
                let measured = irradiance_share(inside, radius);
                assert!((measured - border.max(0.0)).abs() < 1e-14, "{radius} {border}: {measured}");
            }
        }
        for step in 0..=100 {
            let s = f64::from(step) / 100.0;
            let (below, above) = (along_horizon(s, SMALL * (1.0 - 1e-15)), along_horizon(s, SMALL));
            assert!((below - above).abs() < 1e-13, "{s}: {below} {above}");
        }
    }

    /// Each direction of the disc contributes pi to the integral over all normals, so the integral is the solid angle.
    #[test]
    fn all_normals_together_receive_the_solid_angle() {
        let normals = 200_000;
        for degrees in [0.01_f64, 0.27, 5.0, 30.0, 75.0, 90.0] {
            let radius = degrees.to_radians();
            let sum: f64 = (0..normals)
                .map(|k| irradiance_share(2.0 * (f64::from(k) + 0.5) / f64::from(normals) - 1.0, radius))
                .sum();
            let expected = TAU / (1.0 + radius.cos());
            let measured = 2.0 * TAU * sum / f64::from(normals);
            assert!((measured / expected - 1.0).abs() < 1e-9, "{degrees}: {measured} {expected}");
        }
    }
}
