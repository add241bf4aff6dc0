//! Energy of a map, and of its difference from a rig, in each degree of spherical harmonics.
//!
//! The error of a shiny object is a weighted sum of them, with the weights of `kernels/gloss.rs`. Metal of roughness 0.3 loses
//! 5 % of the energy of a point at degree 40, so bright cells and lights have more degrees here than in `zonal.rs`.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use crate::kernels::expansion::{Coefficients, DEGREE, DiscOfFlux};
use crate::kernels::fit::light_disc::{Disc, of_flux};
use crate::kernels::fit::picture::{Patch, Picture};
use crate::kernels::fit::relative_rms::relative_error;
use crate::kernels::fit::rig::Rig;

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
        let discs: Vec<DiscOfFlux> = picture.patches.iter().map(Patch::disc).collect();
        let mut coefficients = Coefficients::of_discs(&discs, BAND_DEGREE);
        coefficients.add_harmonics(&picture.rest);
        // The sum of l^-2 over l > DEGREE is about 1 / (DEGREE + 1 / 2).
        let whole = picture.fine.iter().sum::<f64>() * (DEGREE as f64 + 0.5);
        let fine = |l: usize| if l > DEGREE { whole / (l * l) as f64 } else { 0.0 };
        Self {
            energies: coefficients.energies(None),
            coefficients,
            fine: (0..=BAND_DEGREE).map(fine).collect(),
        }
    }

    /// Energies of the map and of its difference from a rig, whose lights are these discs.
    pub fn compare(&self, rig: &Rig, discs: &[Disc]) -> Bands {
        let mut lights = of_flux(discs, &rig.irradiance);
        let half_sky = rig.has_floor && rig.ambient.len() == 1;
        if half_sky {
            let flux = (2.0 * PI * rig.ambient[0]).to_array();
            lights.push((DVec3::Y, (0.5 * FRAC_PI_2).sin().powi(2), flux));
        }
        let mut coefficients = Coefficients::of_discs(&lights, BAND_DEGREE);
        if !half_sky {
            coefficients.add_ambient(&rig.ambient);
        }
        let with_fine = |energies: Vec<f64>| energies.iter().zip(&self.fine).map(|(a, b)| a + b).collect();
        Bands {
            map: with_fine(self.energies.clone()),
            difference: with_fine(self.coefficients.energies(Some(&coefficients))),
        }
    }
}
