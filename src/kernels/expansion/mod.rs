//! A map in spherical harmonics, except for its bright parts. It is computed once for all objectives of a fit.
//!
//! | step                                           | file                     |
//! |------------------------------------------------|--------------------------|
//! | integrals of each row over azimuth             | `azimuthal.rs`           |
//! | integrals over polar angle                     | `polar.rs`               |
//! | coefficients, their products and moments       | `spherical_harmonics.rs` |
//! | Legendre functions, factors of a disc          | `legendre.rs`            |
//! | discs added to the coefficients                | `addition.rs`            |
//! | the harmonics under discs, with derivatives    | `synthesis.rs`           |
//! | harmonics up to any degree, of maps and discs  | `coefficients.rs`        |
//! | bright cells of a map                          | `bright_parts.rs`        |
//!
//! Real harmonics around +y, orthonormal on the sphere, in the angles of [`crate::kernels::sphere`]:
//!
//! ```text
//!   P_lm(cos theta) cos(m phi)      P_lm(cos theta) sin(m phi)
//! ```

mod addition;
mod azimuthal;
mod bright_parts;
mod coefficients;
mod legendre;
mod polar;
mod spherical_harmonics;
mod synthesis;

pub use addition::Cap;
pub use bright_parts::{PointLight, bright_cells};
pub use coefficients::{Coefficients, DiscOfFlux, expand_discs, expand_map, nine_harmonics};
pub use legendre::{
    AssociatedLegendre, DEGREE, DEGREES, DiscFactors, disc_factors, disc_series, legendre_values,
    set_legendre, visit_degrees,
};
pub use spherical_harmonics::{Harmonics, Rgb2};
pub use synthesis::DiscSum;

use ndarray::{Array3, s};

use self::azimuthal::Azimuthal;
use crate::kernels::image::WorkingMap;

/// The cells of a working map without its bright ones, in harmonics.
#[derive(Clone, Debug)]
pub struct Expansion {
    pub rest: Harmonics,
    /// Integral over the sphere of the squared radiance that the harmonics leave out, by channel.
    pub fine: [f64; 3],
}

impl Expansion {
    /// Expand a map.
    pub fn new(map: &WorkingMap) -> Self {
        let mut radiance = map.radiance.clone();
        for &(row, column) in &map.bright {
            radiance.slice_mut(s![row, column, ..]).fill(0.0);
        }
        let azimuthal = Azimuthal::new(radiance.view(), &map.grid.phi_edges, DEGREES);
        let rest = Harmonics::of_cells(&azimuthal, &map.grid);
        let (whole, known) = (integral_of_squares(&radiance, map), rest.product(&rest, &[1.0; DEGREES]));
        Self { rest, fine: [0, 1, 2].map(|c| (whole[c] - known[c]).max(0.0)) }
    }
}

/// Integral over the sphere of the squared radiance, by channel.
fn integral_of_squares(radiance: &Array3<f32>, map: &WorkingMap) -> [f64; 3] {
    let mut whole = [0.0; 3];
    for (edges, row) in map.rows(radiance) {
        let band = edges[0].cos() - edges[1].cos();
        for (cell, edges) in row.iter().zip(map.grid.phi_edges.windows(2)) {
            let solid_angle = band * (edges[1] - edges[0]);
            (0..3).for_each(|c| whole[c] += solid_angle * f64::from(cell[c]).powi(2));
        }
    }
    whole
}
