//! Mean squared images of a shiny ball seen from all sides, as a spectrum over the degrees of its surroundings.
//!
//! The ball reflects towards the camera, at the incidence i, the radiance `integral of L(l) b_i(l)` with
//! `b_i(l) = f(l, v) cos l`. In its image `u = sin^2 i` is uniform on 0..1, and a mean over all orientations leaves one factor for
//! each degree:
//!
//! ```text
//!   <I^2>    = sum over l of lambda_l sum over m of L_lm^2 / (4 pi)
//!   lambda_l = 4 pi / (2l + 1)  integral over u of  sum over m of |b_lm(i)|^2
//! ```
//!
//! `L_lm` and `b_lm` are coefficients of orthonormal harmonics. The poles of the lobe's harmonics lie on its mirror direction.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::expansion::visit_degrees;
use super::sampling::gauss_legendre;
use crate::interrupt;

/// Light that a surface reflects.
#[derive(Clone, Copy, Debug)]
pub struct GlossySurface {
    /// Width of the distribution of microfacet slopes: the square of the roughness.
    pub alpha: f64,
    /// Reflectance of the microfacets at normal incidence. It rises to 1 at grazing incidence (Schlick 1994).
    pub specular: f64,
    /// Reflectance of the Lambertian base, without losses in the coat.
    pub base: f64,
}

impl GlossySurface {
    /// Metal whose microfacets reflect everything.
    pub fn metal(roughness: f64) -> Self {
        Self { alpha: roughness * roughness, specular: 1.0, base: 0.0 }
    }

    /// Lambertian base under a dielectric coat.
    pub fn plastic(roughness: f64, base: f64) -> Self {
        /// Fresnel reflectance at the refractive index 1.5.
        const COAT: f64 = 0.04;
        Self { alpha: roughness * roughness, specular: COAT, base }
    }

    /// Reflectance distribution times the cosine of `light`, towards `view`, at a `normal`.
    ///
    /// The distribution of microfacets and Smith's masking, separable: Walter et al. 2007, equations 33 and 34.
    fn lobe(&self, normal: DVec3, view: DVec3, light: DVec3) -> f64 {
        let (cosine, towards) = (normal.dot(light), normal.dot(view));
        if cosine <= 0.0 {
            return 0.0;
        }
        let half = (light + view).normalize_or(normal);
        let square = self.alpha * self.alpha;
        let spread = 1.0 + (square - 1.0) * normal.dot(half).powi(2);
        let facets = square / (PI * spread * spread);
        // Masking over twice the cosine, which has no pole at grazing incidence.
        let masking = |c: f64| 1.0 / (c + (square + (1.0 - square) * c * c).sqrt());
        let fresnel = self.specular + (1.0 - self.specular) * (1.0 - half.dot(view)).max(0.0).powi(5);
        cosine * (fresnel * facets * masking(cosine) * masking(towards) + self.base / PI)
    }
}

/// lambda of a surface, for the degrees from 0 to `degree`.
pub fn spectrum(surface: &GlossySurface, degree: usize) -> Vec<f64> {
    /// Gauss nodes in u.
    const INCIDENCES: usize = 24;
    let (nodes, weights) = gauss_legendre(INCIDENCES);
    let rings = LobeRings::new(degree);
    let at = |node: &f64| rings.powers(surface, (0.5 * (1.0 + node)).sqrt().asin());
    let powers: Vec<Vec<f64>> = nodes.par_iter().map(at).collect();
    let mean =
        |l: usize| -> f64 { powers.iter().zip(&weights).map(|(powers, weight)| weight * powers[l]).sum() };
    (0..=degree).map(|l| 2.0 * PI / (2 * l + 1) as f64 * mean(l)).collect()
}

/// Circles around the mirror direction on which a lobe is integrated.
struct LobeRings {
    degree: usize,
    sines: Vec<f64>,
    cosines: Vec<f64>,
    /// Solid angle of each ring over its number of points.
    weights: Vec<f64>,
    /// Points on one half of a ring; the other half mirrors it.
    points: usize,
}

impl LobeRings {
    /// Rings that are dense near the mirror direction: `theta = pi t^2` with Gauss's nodes t.
    fn new(degree: usize) -> Self {
        let count = 128 + degree;
        let points = 64 + degree / 2;
        let (nodes, gauss) = gauss_legendre(count);
        let places: Vec<f64> = nodes.iter().map(|node| 0.5 * (1.0 + node)).collect();
        let (sines, cosines): (Vec<f64>, Vec<f64>) = places.iter().map(|t| (PI * t * t).sin_cos()).unzip();
        let solid_angle = |((weight, t), sine): ((&f64, &f64), &f64)| {
            0.5 * weight * 2.0 * PI * t * sine * 2.0 * PI / points as f64
        };
        let weights = gauss.iter().zip(&places).zip(&sines).map(solid_angle).collect();
        Self { degree, sines, cosines, weights, points }
    }

    /// Sum of the squared coefficients of each degree of the lobe at an incidence.
    fn powers(&self, surface: &GlossySurface, incidence: f64) -> Vec<f64> {
        let waves = self.waves(surface, incidence);
        let count = self.sines.len();
        let mut out = vec![0.0; self.degree + 1];
        for m in 0..=self.degree {
            interrupt::check();
            let wave = &waves[m * count..][..count];
            visit_degrees(m, self.degree, &self.cosines, &self.sines, &mut |l, values| {
                let coefficient: f64 = values.iter().zip(wave).map(|(value, wave)| value * wave).sum();
                out[l] += coefficient * coefficient;
            });
        }
        out
    }

    /// Integrals of a lobe over each ring times `cos m phi`, order by order, times the weights of the rings.
    fn waves(&self, surface: &GlossySurface, incidence: f64) -> Vec<f64> {
        let count = self.sines.len();
        let normal = DVec3::new(incidence.sin(), incidence.cos(), 0.0);
        let view = DVec3::new((2.0 * incidence).sin(), (2.0 * incidence).cos(), 0.0);
        let mut out = vec![0.0; (self.degree + 1) * count];
        for point in 0..self.points {
            let azimuth = PI * (point as f64 + 0.5) / self.points as f64;
            let (sine, cosine) = azimuth.sin_cos();
            let towards = |ring: usize| {
                DVec3::new(self.sines[ring] * cosine, self.cosines[ring], self.sines[ring] * sine)
            };
            let value = |ring: usize| self.weights[ring] * surface.lobe(normal, view, towards(ring));
            let values: Vec<f64> = (0..count).map(value).collect();
            for (m, wave) in out.chunks_exact_mut(count).enumerate() {
                let factor = (m as f64 * azimuth).cos();
                wave.iter_mut().zip(&values).for_each(|(sum, value)| *sum += factor * value);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_passes_every_degree() {
        let off = |alpha: f64| {
            let surface = GlossySurface { alpha, ..GlossySurface::metal(1.0) };
            spectrum(&surface, 24).into_iter().map(|factor| (factor - 1.0).abs()).fold(0.0, f64::max)
        };
        assert!(off(1e-3) < 0.01 && off(1e-4) < 3e-4, "{} {}", off(1e-3), off(1e-4));
    }

    /// Walter's lobe at roughness 0.2, 0.33 and 0.5: smooth surfaces keep fine patterns, and more of the light.
    #[test]
    fn rougher_metal_passes_less_of_every_degree() {
        let [fine, middle, rough] =
            [0.2, 0.33, 0.5].map(|roughness| spectrum(&GlossySurface::metal(roughness), 40));
        for l in 0..=40 {
            assert!(1.0 > fine[l] && fine[l] > middle[l] && middle[l] > rough[l], "{l}");
        }
    }

    #[test]
    fn a_spectrum_does_not_depend_on_its_length() {
        let [short, long] = [8, 100].map(|degree| spectrum(&GlossySurface::metal(0.2), degree));
        for (one, other) in short.iter().zip(&long) {
            assert!((one - other).abs() < 1e-3, "{one} {other}");
        }
    }
}
