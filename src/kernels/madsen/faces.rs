//! The scene radiance sphere: one radiance for each face of an icosphere.

use ndarray::{Array2, ArrayView2, ArrayView3, Axis};
use rayon::prelude::*;

use crate::error::Result;
use crate::interrupt;
use crate::kernels::image::{check_rgb, check_samples};
use crate::kernels::sampling::{self, FaceSearch};
use crate::kernels::sphere::{Registration, band_heights, direction};

/// Rows in one partial sum. The runs do not depend on the number of threads, so the result has the same bits.
const MOST_RUNS: usize = 16;

/// Mean radiance, (faces, 3), of the map in each face of [`sampling::icosphere`].
///
/// ```text
///   L_face = sum of L_p omega_p over the pixels p whose samples lie in the face  /  omega_face
/// ```
///
/// Dividing by the solid angle of the face keeps the flux of the map. The paper does not say how it
/// resamples its map. One sample at each centroid would miss small lamps: the probe of the demo's hall
/// is then off by 20 %.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`],
/// [`crate::error::Error::NoSuchIcosphere`].
pub fn face_radiance(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    faces: usize,
) -> Result<Array2<f64>> {
    check_rgb(radiance)?;
    let (_, areas) = sampling::icosphere(faces)?;
    let search = FaceSearch::new(faces)?;
    let (height, width, _) = radiance.dim();
    let pixels = PixelAxes::new(height, width, registration);
    // Add the flux of each pixel to its face, in runs of rows.
    let runs = height.min(MOST_RUNS);
    let sums: Vec<Array2<f64>> = (0..runs)
        .into_par_iter()
        .map(|run| {
            let mut flux = Array2::zeros((faces, 3));
            for row in run * height / runs..(run + 1) * height / runs {
                interrupt::check();
                pixels.add_row(row, radiance.index_axis(Axis(0), row), &search, &mut flux);
            }
            flux
        })
        .collect();
    // Report the sample that made a sum non-finite.
    if !sums.iter().flatten().all(|flux| flux.is_finite()) {
        check_samples(radiance)?;
    }
    // Add the runs in order and divide by the solid angle.
    let mut mean = sums.into_iter().fold(Array2::zeros((faces, 3)), |sum, flux| sum + flux);
    for (mut face, area) in mean.rows_mut().into_iter().zip(&areas) {
        face /= *area;
    }
    Ok(mean)
}

/// Angles of the samples and sizes of their pixels, along each axis of the image.
struct PixelAxes {
    thetas: Vec<f64>,
    phis: Vec<f64>,
    bands: Vec<f64>,
    widths: Vec<f64>,
}

impl PixelAxes {
    fn new(height: usize, width: usize, registration: Registration) -> Self {
        let phi_edges = registration.phi_edges(width);
        Self {
            thetas: registration.thetas(height),
            phis: registration.phis(width),
            bands: band_heights(&registration.theta_edges(height)),
            widths: phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect(),
        }
    }

    /// Add the flux of each pixel of a row to the face that contains its sample.
    fn add_row(&self, row: usize, samples: ArrayView2<'_, f32>, search: &FaceSearch, flux: &mut Array2<f64>) {
        for (column, sample) in samples.rows().into_iter().enumerate() {
            let face = search.face_of(direction(self.thetas[row], self.phis[column]));
            let solid_angle = self.bands[row] * self.widths[column];
            for channel in 0..3 {
                flux[[face, channel]] += f64::from(sample[channel]) * solid_angle;
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sphere;
    use approx::assert_relative_eq;
    use ndarray::Array3;

    #[test]
    fn faces_hold_the_flux_of_the_map() {
        let map = Array3::from_shape_fn((33, 66, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let solid_angles = sphere::pixel_solid_angles(33, 66, registration).unwrap();
            for faces in [20, 5120] {
                let (_, areas) = sampling::icosphere(faces).unwrap();
                let result = face_radiance(map.view(), registration, faces).unwrap();
                for channel in 0..3 {
                    let pixels = map.index_axis(ndarray::Axis(2), channel).mapv(f64::from);
                    let flux = (&pixels * &solid_angles).sum();
                    assert_relative_eq!(result.column(channel).dot(&areas), flux, max_relative = 1e-12);
                }
            }
        }
    }
}
