//! Directions on the sphere and their equirectangular image.
//!
//! Conventions, for the whole crate (right-handed, y up):
//!
//! ```text
//!            +y  (row 0, theta = 0)    +z  (into the page: the centre of the image)
//!             |                      /
//!             |                   /        theta: angle from +y,                    0 ..   pi, down the rows
//!   +x -------+ - - - - - - - -            phi:   angle from -z over +x towards +z, 0 .. 2 pi, along the columns
//!
//!   direction = (sin phi sin theta, cos theta, -cos phi sin theta)
//! ```
//!
//! Image coordinates: `u = phi / 2 pi` from the left edge, `v = theta / pi` from the top.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::DVec3;
use ndarray::{Array2, Array3, ArrayView1, ArrayView2, aview1};

use crate::error::{Error, Result};
use crate::interrupt;

/// Registration of the pixels of an equirectangular map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Registration {
    /// Pixel `x` of `width` covers the cell between `x` and `x + 1` widths, as in most files.
    CellCentred,
    /// The first and last columns lie on the seam, the first and last rows on the poles: `OpenEXR`
    /// files with the `envmap` attribute. Their cells are half as wide as the others.
    BorderSampled,
}

impl Registration {
    /// Polar angles between the rows: `height + 1` values from 0 to pi.
    pub fn theta_edges(self, height: usize) -> Vec<f64> {
        self.edges(height, PI)
    }

    /// Azimuths between the columns: `width + 1` values from 0 to 2 pi.
    pub fn phi_edges(self, width: usize) -> Vec<f64> {
        self.edges(width, TAU)
    }

    /// Polar angles of the samples of the rows.
    pub fn thetas(self, height: usize) -> Vec<f64> {
        self.centres(height, PI)
    }

    /// Azimuths of the samples of the columns.
    pub fn phis(self, width: usize) -> Vec<f64> {
        self.centres(width, TAU)
    }

    fn edges(self, cells: usize, range: f64) -> Vec<f64> {
        let edge = |i: usize| match self {
            Self::CellCentred => i as f64 / cells as f64,
            Self::BorderSampled => (i as f64 - 0.5) / (cells - 1) as f64,
        };
        let angle = |i: usize| {
            interrupt::check();
            range * edge(i).clamp(0.0, 1.0)
        };
        (0..=cells).map(angle).collect()
    }

    /// Coordinates of the samples of `cells` pixels in `0 ..= range`.
    fn centres(self, cells: usize, range: f64) -> Vec<f64> {
        let centre = |i: usize| match self {
            Self::CellCentred => (i as f64 + 0.5) / cells as f64,
            Self::BorderSampled => i as f64 / (cells - 1) as f64,
        };
        let angle = |i: usize| {
            interrupt::check();
            range * centre(i)
        };
        (0..cells).map(angle).collect()
    }
}

/// The direction at polar angle `theta` and azimuth `phi`, both in radians.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    direction_of(theta.sin_cos(), phi.sin_cos())
}

/// [`direction`] of sine and cosine of both angles.
pub(crate) fn direction_of((sin_theta, cos_theta): (f64, f64), (sin_phi, cos_phi): (f64, f64)) -> DVec3 {
    DVec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
}

/// Derivatives of [`direction`] by `theta` and by `phi`; the second is 0 on the poles.
pub fn angle_derivatives(theta: f64, phi: f64) -> [DVec3; 2] {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    let by_theta = DVec3::new(sin_phi * cos_theta, -sin_theta, -cos_phi * cos_theta);
    let by_phi = DVec3::new(cos_phi * sin_theta, 0.0, sin_phi * sin_theta);
    [by_theta, by_phi]
}

/// Polar angle and azimuth in `0 .. 2 pi` of `direction`; the inverse of [`direction`].
///
/// `atan2` of the two legs, not `acos` of one: near the poles `acos` keeps half of the digits.
pub fn angles(direction: DVec3) -> (f64, f64) {
    let equatorial = direction.x.hypot(direction.z);
    let theta = equatorial.atan2(direction.y);
    let phi = direction.x.atan2(-direction.z);
    (theta, if phi < 0.0 { phi + TAU } else { phi })
}

/// Directions, (n, 3), of the image coordinates `uv`, (n, 2).
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`].
pub fn uv_to_direction(uv: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    check_rows("uv", uv, 2)?;
    Ok(from_vectors(uv.rows().into_iter().map(|row| direction(PI * row[1], TAU * row[0]))))
}

/// Image coordinates, (n, 2), of the unit vectors `directions`, (n, 3); `u` lies in `0 .. 1`.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn direction_to_uv(directions: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    let directions = unit_vectors("direction", directions)?;
    let mut out = Array2::zeros((directions.len(), 2));
    for (mut row, &d) in out.rows_mut().into_iter().zip(&directions) {
        interrupt::check();
        let (theta, phi) = angles(d);
        row[0] = (phi / TAU) % 1.0;
        row[1] = theta / PI;
    }
    Ok(out)
}

/// Direction of every pixel's sample in some `rows`: (number of rows, width, 3).
///
/// # Errors
///
/// [`Error::TooFewPixels`], [`Error::NoMemory`].
pub fn row_directions(
    height: usize,
    width: usize,
    registration: Registration,
    rows: Range<usize>,
) -> Result<Array3<f64>> {
    check_size(height, width)?;
    let rows = rows.start.min(height)..rows.end.min(height);
    check_memory(&[rows.len(), width, 3])?;
    let sin_cos = |angles: Vec<f64>| -> Vec<_> { angles.into_iter().map(f64::sin_cos).collect() };
    let columns = sin_cos(registration.phis(width));
    let lines = sin_cos(registration.thetas(height).drain(rows).collect());
    let mut out = Array3::zeros((lines.len(), width, 3));
    for (mut line, &row) in out.outer_iter_mut().zip(&lines) {
        interrupt::check();
        for (mut pixel, &column) in line.outer_iter_mut().zip(&columns) {
            pixel.assign(&aview1(&direction_of(row, column).to_array()));
        }
    }
    Ok(out)
}

/// Solid angle of every pixel in steradians: (height, width).
///
/// The patch between two parallels and two meridians has the closed form
///
/// ```text
/// omega = (phi_right - phi_left) * (cos theta_top - cos theta_bottom)
/// ```
///
/// The closed form sums to 4 pi over the image; the midpoint rule `sin theta * dtheta * dphi` does so only in
/// the limit.
///
/// # Errors
///
/// [`Error::TooFewPixels`], [`Error::NoMemory`].
pub fn pixel_solid_angles(height: usize, width: usize, registration: Registration) -> Result<Array2<f64>> {
    check_size(height, width)?;
    check_memory(&[height, width])?;
    let bands = band_heights(&registration.theta_edges(height));
    let phi = registration.phi_edges(width);
    let mut out = Array2::zeros((height, width));
    for (mut row, band) in out.outer_iter_mut().zip(bands) {
        interrupt::check();
        row.iter_mut().zip(phi.windows(2)).for_each(|(angle, phi)| *angle = band * (phi[1] - phi[0]));
    }
    Ok(out)
}

/// Solid angle of a triangle on the sphere (van Oosterom and Strackee 1983).
///
/// `tan(omega / 2) = a.(b x c) / (1 + a.b + b.c + c.a)`.
pub(crate) fn spherical_area([a, b, c]: [DVec3; 3]) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// `cos theta_top - cos theta_bottom` of each row, as a product that does not cancel at the poles.
pub fn band_heights(theta_edges: &[f64]) -> Vec<f64> {
    theta_edges
        .windows(2)
        .map(|edge| 2.0 * (0.5 * (edge[0] + edge[1])).sin() * (0.5 * (edge[1] - edge[0])).sin())
        .collect()
}

/// Two unit vectors orthogonal to `axis` and to each other (Duff et al. 2017).
///
/// They are defined for every axis, and discontinuous across the plane z = 0.
pub fn tangents(axis: DVec3) -> [DVec3; 2] {
    let first = axis.any_orthonormal_vector();
    [first, axis.cross(first)]
}

/// Exponential map: `axis` moved along the great circle with the initial tangent vector `step` (radians).
pub fn exponential_map(axis: DVec3, step: DVec3) -> DVec3 {
    let angle = step.length();
    if angle < f64::MIN_POSITIVE {
        return axis;
    }
    (axis * angle.cos() + step * (angle.sin() / angle)).normalize()
}

/// Convert `rows` to unit vectors.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn unit_vectors(what: &'static str, rows: ArrayView2<'_, f64>) -> Result<Vec<DVec3>> {
    // Accept vectors that were normalised in f32; refuse vectors that were never normalised.
    const TOLERANCE: f64 = 1e-5;
    let vectors = vectors(what, rows)?;
    let is_unit = |vector: &DVec3| (vector.length() - 1.0).abs() <= TOLERANCE;
    match vectors.iter().position(|vector| !is_unit(vector)) {
        Some(index) => Err(Error::NotUnit { what, index, length: vectors[index].length() }),
        None => Ok(vectors),
    }
}

/// Row and column.
pub(crate) type Pixel = [usize; 2];

/// Rows and columns, (n, 2), each inside an image of `(height, width)`.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::OutsideImage`].
pub(crate) fn pixels_inside(
    pixels: ArrayView2<'_, i64>,
    (height, width): (usize, usize),
) -> Result<Vec<Pixel>> {
    if pixels.ncols() != 2 {
        return Err(Error::WrongColumns { what: "pixels", columns: 2, shape: pixels.shape().to_vec() });
    }
    let inside = |(index, row): (usize, ArrayView1<'_, i64>)| {
        let pixel = [usize::try_from(row[0]), usize::try_from(row[1])];
        match pixel {
            [Ok(y), Ok(x)] if y < height && x < width => Ok([y, x]),
            _ => Err(Error::OutsideImage { index, row: row[0], column: row[1], height, width }),
        }
    };
    pixels.rows().into_iter().enumerate().map(inside).collect()
}

/// Flat indices of pixels, (n, 2), of an image, each with its light, (n,).
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::OutsideImage`], [`Error::LengthMismatch`], [`Error::Negative`].
pub(crate) fn pixels_of_lights(
    pixels: ArrayView2<'_, i64>,
    light_of_pixel: ArrayView1<'_, i64>,
    (height, width): (usize, usize),
) -> Result<Vec<(usize, usize)>> {
    check_lengths("pixels", pixels.nrows(), [("light_of_pixel", light_of_pixel.len())])?;
    check_not_negative("light_of_pixel", light_of_pixel.iter().map(|&light| light as f64))?;
    let pixels =
        pixels_inside(pixels, (height, width))?.into_iter().map(|[row, column]| row * width + column);
    Ok(pixels.zip(light_of_pixel.iter().map(|&light| light as usize)).collect())
}

/// Convert `rows` to vectors.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NoMemory`].
pub fn vectors(what: &'static str, rows: ArrayView2<'_, f64>) -> Result<Vec<DVec3>> {
    check_rows(what, rows, 3)?;
    check_memory(&[rows.nrows(), 4])?; // and a weight
    Ok(to_vectors(rows))
}

/// Refuse an array that is not (n, `columns`) or holds a number that is not finite.
pub(crate) fn check_rows(what: &'static str, rows: ArrayView2<'_, f64>, columns: usize) -> Result<()> {
    if rows.ncols() != columns {
        return Err(Error::WrongColumns { what, columns, shape: rows.shape().to_vec() });
    }
    for (index, row) in rows.rows().into_iter().enumerate() {
        interrupt::check();
        if let Some(&value) = row.iter().find(|value| !value.is_finite()) {
            return Err(Error::NotFinite { what, index, value });
        }
    }
    Ok(())
}

/// Refuse an array whose number of rows is not `wanted`, that of `other`.
pub(crate) fn check_lengths<const N: usize>(
    other: &'static str,
    wanted: usize,
    lengths: [(&'static str, usize); N],
) -> Result<()> {
    match lengths.into_iter().find(|&(_, seen)| seen != wanted) {
        Some((what, seen)) => Err(Error::LengthMismatch { what, other, wanted, seen }),
        None => Ok(()),
    }
}

/// Check unit normals, values and non-negative weights of the same length.
pub(crate) fn check_weighted(
    normals: ArrayView2<'_, f64>,
    (what, values): (&'static str, ArrayView2<'_, f64>),
    weights: ArrayView1<'_, f64>,
) -> Result<Vec<DVec3>> {
    let normals = unit_vectors("normal", normals)?;
    check_values("normals", normals.len(), (what, values), weights)?;
    Ok(normals)
}

/// Check RGB values and non-negative weights, as many as the rows of `other`.
pub(crate) fn check_values(
    other: &'static str,
    wanted: usize,
    (what, values): (&'static str, ArrayView2<'_, f64>),
    weights: ArrayView1<'_, f64>,
) -> Result<()> {
    check_rows(what, values, 3)?;
    check_rows("weights", weights.insert_axis(ndarray::Axis(1)), 1)?;
    check_lengths(other, wanted, [(what, values.nrows()), ("weights", weights.len())])?;
    check_not_negative("weights", weights.iter().copied())
}

/// Refuse a negative number.
pub(crate) fn check_not_negative(what: &'static str, numbers: impl Iterator<Item = f64>) -> Result<()> {
    match numbers.enumerate().find(|&(_, number)| number < 0.0) {
        Some((index, value)) => Err(Error::Negative { what, index, value }),
        None => Ok(()),
    }
}

pub(crate) fn check_size(height: usize, width: usize) -> Result<()> {
    if height < 2 || width < 2 {
        return Err(Error::TooFewPixels { height, width });
    }
    Ok(())
}

/// Refuse an array that does not fit in memory: running out of memory would end the process.
pub(crate) fn check_memory(shape: &[usize]) -> Result<()> {
    let numbers = shape.iter().fold(1_usize, |product, &side| product.saturating_mul(side));
    let reserved = Vec::<f64>::new().try_reserve_exact(numbers);
    reserved.map_err(|_| Error::NoMemory { shape: shape.to_vec() })
}

/// Rows of an array, (n, 3), as vectors.
pub(crate) fn to_vectors(rows: ArrayView2<'_, f64>) -> Vec<DVec3> {
    let vector = |row: ArrayView1<'_, f64>| {
        interrupt::check();
        DVec3::new(row[0], row[1], row[2])
    };
    rows.rows().into_iter().map(vector).collect()
}

/// Array with the vectors as rows.
pub(crate) fn from_vectors(vectors: impl Iterator<Item = DVec3>) -> Array2<f64> {
    let row = |vector: DVec3| {
        interrupt::check();
        vector.to_array()
    };
    let rows: Vec<[f64; 3]> = vectors.map(row).collect();
    Array2::from(rows)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn border_samples_lie_on_seam_and_poles() {
        let directions = row_directions(5, 9, Registration::BorderSampled, 0..5).unwrap();
        assert_relative_eq!(directions[[0, 3, 1]], 1.0);
        assert_relative_eq!(directions[[2, 0, 2]], -1.0, epsilon = 1e-15);
        assert_relative_eq!(directions[[2, 8, 2]], -1.0, epsilon = 1e-15);
    }

    proptest! {
        #[test]
        fn exponential_map_turns_by_the_length_of_its_step(
            theta in 0.0..PI, phi in 0.0..TAU, a in -1.0..1.0_f64, b in -1.0..1.0_f64,
        ) {
            let axis = direction(theta, phi);
            let [s, t] = tangents(axis);
            let step = s * a + t * b;
            let turned = exponential_map(axis, step);
            prop_assert!((turned.length() - 1.0).abs() < 1e-14);
            prop_assert!((axis.angle_between(turned) - step.length()).abs() < 1e-7);
        }
    }
}
