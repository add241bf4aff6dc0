//! Energy of a map, and of its difference from a rig, in each degree of spherical harmonics.
//!
//! The error of a shiny object is a weighted sum of them, with the weights of `kernels/gloss.rs`. Metal of roughness 0.3 loses
//! 5 % of the energy of a point at degree 40, so bright cells and lights have more degrees here than in `zonal.rs`.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use rayon::prelude::*;

use super::target::Picture;
use crate::kernels::expansion::{DEGREE, disc_series, visit_degrees};
use crate::kernels::fit::light_disc::Disc;
use crate::kernels::fit::relative_rms::relative_error;
use crate::kernels::fit::rig::Rig;
use crate::kernels::sphere::angles;

/// Highest degree of bright cells and of lights.
pub const BAND_DEGREE: usize = 96;

/// Energy in each degree, summed over channels: the squared coefficients of orthonormal harmonics.
#[derive(Clone, Debug, Default)]
pub struct Bands {
    /// Energy of the map.
    pub map: Vec<f64>,
    /// Energy of the difference of the rig from the map.
    pub difference: Vec<f64>,
}

impl Bands {
    /// Relative RMS error under a kernel with these factors; absolute if the map is black.
    pub fn error(&self, factors: &[f64]) -> f64 {
        let sum = |bands: &[f64]| bands.iter().zip(factors).map(|(band, factor)| band * factor).sum();
        relative_error(sum(&self.difference), sum(&self.map))
    }
}

/// Direction, A and flux of a disc.
type DiscOfFlux = (DVec3, f64, [f64; 3]);

/// Coefficients of three channels: cosines, then sines. A list for each order, from the degree of that order on.
#[derive(Clone, Debug)]
struct Coefficients(Vec<Vec<[f64; 6]>>);

impl Coefficients {
    fn of_discs(discs: &[DiscOfFlux]) -> Self {
        let (theta, phi): (Vec<f64>, Vec<f64>) = discs.iter().map(|disc| angles(disc.0)).unzip();
        let (sines, cosines): (Vec<f64>, Vec<f64>) = theta.iter().map(|theta| theta.sin_cos()).unzip();
        let series: Vec<Vec<f64>> = discs.iter().map(|disc| disc_series(disc.1, BAND_DEGREE + 1)).collect();
        // Of each degree, the factors of all discs, because a sum runs over the discs.
        let factors: Vec<Vec<f64>> =
            (0..=BAND_DEGREE).map(|l| series.iter().map(|series| series[l]).collect()).collect();
        let order = |m: usize| {
            let wave = |(phi, disc): (&f64, &DiscOfFlux)| {
                let (sine, cosine) = (m as f64 * phi).sin_cos();
                let [r, g, b] = disc.2;
                [r * cosine, g * cosine, b * cosine, r * sine, g * sine, b * sine]
            };
            let waves: Vec<[f64; 6]> = phi.iter().zip(discs).map(wave).collect();
            let mut out = vec![[0.0; 6]; BAND_DEGREE + 1 - m];
            visit_degrees(m, BAND_DEGREE, &cosines, &sines, &mut |l, values| {
                let mut sum = [0.0; 6];
                for ((value, factor), wave) in values.iter().zip(&factors[l]).zip(&waves) {
                    let weight = value * factor;
                    (0..6).for_each(|i| sum[i] += weight * wave[i]);
                }
                out[l - m] = sum;
            });
            out
        };
        Self((0..=BAND_DEGREE).into_par_iter().map(order).collect())
    }

    fn add(&mut self, l: usize, m: usize, side: usize, rgb: DVec3) {
        let value = &mut self.0[m][l - m];
        (0..3).for_each(|c| value[3 * side + c] += rgb[c]);
    }

    /// Sum of the squares in each degree, of these minus `others`.
    fn energies(&self, others: Option<&Self>) -> Vec<f64> {
        let mut out = vec![0.0; BAND_DEGREE + 1];
        for (m, order) in self.0.iter().enumerate() {
            for (k, value) in order.iter().enumerate() {
                let other = others.map_or([0.0; 6], |others| others.0[m][k]);
                out[m + k] += (0..6).map(|i| (value[i] - other[i]).powi(2)).sum::<f64>();
            }
        }
        out
    }
}

/// The coefficients of a map.
#[derive(Clone, Debug)]
pub struct MapBands {
    coefficients: Coefficients,
    energies: Vec<f64>,
    /// Energy of the dull cells beyond their harmonics, by degree; it falls off with the degree as `l^-2`.
    fine: Vec<f64>,
}

impl MapBands {
    pub fn new(picture: &Picture) -> Self {
        let discs: Vec<DiscOfFlux> = picture.discs().collect();
        let mut coefficients = Coefficients::of_discs(&discs);
        for m in 0..=DEGREE {
            for l in m..=DEGREE {
                let [r, g, b, _, red, green, blue, _] = *picture.rest().at(l, m);
                coefficients.add(l, m, 0, DVec3::new(r, g, b));
                coefficients.add(l, m, 1, DVec3::new(red, green, blue));
            }
        }
        // The sum of l^-2 over l > DEGREE is about 1 / (DEGREE + 1 / 2).
        let whole = picture.fine().iter().sum::<f64>() * (DEGREE as f64 + 0.5);
        let fine = |l: usize| if l > DEGREE { whole / (l * l) as f64 } else { 0.0 };
        Self {
            energies: coefficients.energies(None),
            coefficients,
            fine: (0..=BAND_DEGREE).map(fine).collect(),
        }
    }

    /// Energies of the map and of its difference from a rig, whose lights are these discs.
    pub fn compare(&self, rig: &Rig, discs: &[Disc]) -> Bands {
        let light = |(irradiance, disc): (&DVec3, &Disc)| {
            (disc.direction, disc.share, (*irradiance / (1.0 - disc.share)).to_array())
        };
        let mut lights: Vec<DiscOfFlux> = rig.irradiance.iter().zip(discs).map(light).collect();
        let half_sky = rig.has_floor && rig.ambient.len() == 1;
        if half_sky {
            let flux = (2.0 * PI * rig.ambient[0]).to_array();
            lights.push((DVec3::Y, (0.5 * FRAC_PI_2).sin().powi(2), flux));
        }
        let mut coefficients = Coefficients::of_discs(&lights);
        if !half_sky {
            add_ambient(&mut coefficients, &rig.ambient);
        }
        let with_fine = |energies: Vec<f64>| energies.iter().zip(&self.fine).map(|(a, b)| a + b).collect();
        Bands {
            map: with_fine(self.energies.clone()),
            difference: with_fine(self.coefficients.energies(Some(&coefficients))),
        }
    }
}

/// Add an ambient term: the radiance of a constant one, or nine coefficients of harmonics around +z.
fn add_ambient(out: &mut Coefficients, ambient: &[DVec3]) {
    match *ambient {
        [constant] => out.add(0, 0, 0, constant * (4.0 * PI).sqrt()),
        [whole, y, z, x, xy, yz, zz, xz, xx_yy] => {
            out.add(0, 0, 0, whole);
            for (side, m, value) in [(0, 0, y), (0, 1, -z), (1, 1, x)] {
                out.add(1, m, side, value);
            }
            // Around +z, 3 z^2 - 1 and x^2 - y^2 are sums of 3 y^2 - 1 and z^2 - x^2.
            let (half, rest) = (0.5, 0.75_f64.sqrt());
            let (yy, zz_xx) = (-half * zz - rest * xx_yy, rest * zz - half * xx_yy);
            for (side, m, value) in [(0, 0, yy), (0, 1, -yz), (1, 1, xy), (0, 2, zz_xx), (1, 2, -xz)] {
                out.add(2, m, side, value);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::expansion::legendre_values;
    use crate::kernels::harmonics::radiance;

    /// The addition theorem, and the factors of both discs.
    #[test]
    fn the_bands_of_two_discs_are_their_products() {
        let (one, other) = (DVec3::new(2.0, 3.0, -6.0) / 7.0, DVec3::new(-0.6, 0.0, 0.8));
        let flux = [1.0, 0.0, 2.0];
        let ours = Coefficients::of_discs(&[(one, 0.01, flux)]);
        let theirs = Coefficients::of_discs(&[(other, 0.02, flux)]);
        let (energies, legendre) = (ours.energies(Some(&theirs)), legendre_values(one.dot(other), 97));
        let [a, b] = [0.01, 0.02].map(|share| disc_series(share, 97));
        for l in [0, 1, 2, 17, 40, 96] {
            let expected = a[l] * a[l] + b[l] * b[l] - 2.0 * a[l] * b[l] * legendre[l];
            let expected = 5.0 * expected * (2 * l + 1) as f64 / (4.0 * PI);
            assert!((energies[l] - expected).abs() < 1e-11, "{l}: {} {expected}", energies[l]);
        }
    }

    /// A point in the degrees 0 to 2 is its nine harmonics.
    #[test]
    fn nine_harmonics_are_those_of_a_point() {
        let towards = DVec3::new(2.0, 3.0, -6.0) / 7.0;
        let point = Coefficients::of_discs(&[(towards, 0.0, [1.0, 2.0, 3.0])]);
        let mut nine = Coefficients::of_discs(&[]);
        let rgb = DVec3::new(1.0, 2.0, 3.0);
        add_ambient(&mut nine, &radiance(towards).map(|value| rgb * value));
        assert!(point.energies(Some(&nine))[..3].iter().all(|energy| *energy < 1e-24));
    }
}
