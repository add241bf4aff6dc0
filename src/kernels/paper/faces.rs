//! The scene radiance sphere: one radiance for each face of an icosphere.

use ndarray::{Array2, ArrayView3};
use rayon::prelude::*;

use crate::error::Result;
use crate::kernels::image::check_rgb;
use crate::kernels::sampling;
use crate::kernels::sphere::{self, Registration};

/// Mean radiance, (faces, 3), of the map in each face of [`sampling::icosphere`].
///
/// ```text
///   L_face = sum of L_p omega_p over the pixels p whose samples lie in the face  /  omega_face
/// ```
///
/// over the face's own solid angle, so that faces and pixels hold the same flux, however few the
/// pixels. The paper does not say how it brings its map to the faces. One sample at each centroid
/// would miss lamps, or take their bars for them: on the demo's hall the probe is then 20 % off.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::NoSuchIcosphere`].
pub fn face_radiance(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    faces: usize,
) -> Result<Array2<f64>> {
    check_rgb(radiance)?;
    let (_, areas) = sampling::icosphere(faces)?;
    let (height, width, _) = radiance.dim();
    let directions = sphere::pixel_directions(height, width, registration)?;
    let solid_angles = sphere::pixel_solid_angles(height, width, registration)?;
    let search = sampling::FaceSearch::new(faces)?;
    let rows: Vec<Vec<usize>> = directions
        .outer_iter()
        .into_par_iter()
        .map(|row| row.rows().into_iter().map(|d| search.face_of(sphere::vector(d))).collect())
        .collect();
    let mut out = Array2::zeros((faces, 3));
    // One by one, so that the sums do not depend on the threads.
    for ((row, column), solid_angle) in solid_angles.indexed_iter() {
        let face = rows[row][column];
        for channel in 0..3 {
            out[[face, channel]] += f64::from(radiance[[row, column, channel]]) * solid_angle / areas[face];
        }
    }
    Ok(out)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use ndarray::Array3;

    #[test]
    fn faces_hold_the_flux_of_the_map() {
        let map = Array3::from_shape_fn((33, 66, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let solid_angles = sphere::pixel_solid_angles(33, 66, registration).unwrap();
            for faces in [20, 5120] {
                let (_, areas) = sampling::icosphere(faces).unwrap();
                let seen = face_radiance(map.view(), registration, faces).unwrap();
                for channel in 0..3 {
                    let pixels = map.index_axis(ndarray::Axis(2), channel).mapv(f64::from);
                    let flux = (&pixels * &solid_angles).sum();
                    assert_relative_eq!(seen.column(channel).dot(&areas), flux, max_relative = 1e-12);
                }
            }
        }
    }
}
