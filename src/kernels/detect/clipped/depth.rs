//! Depth of the pixels of a clipped region: the angle to the nearest pixel outside of it.
//!
//! The nearest outer pixel of the pixel's own row is one of the two at the ends of its run. In another row, it is the
//! one at the smallest difference D of azimuths:
//!
//! ```text
//!   cos depth = max over rows r of  cos t cos t_r + sin t sin t_r cos D_r
//! ```
//!
//! for a pixel at the polar angle t. Rows are tried from the pixel's own one outwards, up to those that are farther away
//! than the nearest outer pixel so far. Distances are those between directions, so they hold at the seam and the poles.

use std::ops::Range;

use rayon::prelude::*;

use super::super::segment::run::Run;
use super::super::segment::working_image::WorkingImage;
use crate::interrupt;
use crate::kernels::image::CellCentres;

/// An image of the depth of each pixel of `plateau` in radians; other pixels are 0.
///
/// The runs of `plateau` are in ascending order.
pub fn depths(working: &WorkingImage, plateau: &[Run]) -> Vec<f32> {
    let (height, width) = working.size;
    let sphere = CellCentres::new(&working.grid);
    // Find the nearest outer pixel of each row.
    let (mut outer, mut versines) = (vec![0.0; height * width], Vec::new());
    for row in plateau.chunk_by(|one, other| one.row == other.row) {
        for (run, ends) in row.iter().zip(ends(row, width)) {
            fill_versines(&sphere, run.columns.clone(), ends, &mut versines);
            outer[run.pixels(width)].copy_from_slice(&versines);
        }
    }
    // Find that of all rows.
    let mut depth = vec![0.0; height * width];
    depth.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
        interrupt::check();
        for (column, depth) in
            out.iter_mut().enumerate().filter(|(column, _)| outer[row * width + column] > 0.0)
        {
            *depth = angle(nearest(&sphere, &outer, row, column));
        }
    });
    depth
}

/// The columns before and after each run of a row, across the seam; none where the row has no outer pixel.
fn ends(row: &[Run], width: usize) -> impl Iterator<Item = Option<[usize; 2]>> {
    let (first, last) = (&row[0].columns, &row[row.len() - 1].columns);
    let is_whole = first.start == 0 && first.end == width;
    // A run that ends at the seam goes on with the one on its other side.
    let before_seam = if last.end == width { last.start } else { width }.wrapping_sub(1);
    let after_seam = if first.start == 0 { first.end } else { 0 };
    row.iter().map(move |run| {
        let before = if run.columns.start == 0 { before_seam } else { run.columns.start - 1 };
        let after = if run.columns.end == width { after_seam } else { run.columns.end };
        (!is_whole).then_some([before, after])
    })
}

/// The angle of a cosine, to the precision of a depth.
fn angle(cosine: f64) -> f32 {
    2.0 * ((0.5 * (1.0 - cosine)).max(0.0).sqrt() as f32).min(1.0).asin()
}

/// Versine for a row that has no outer pixel.
const NO_OUTER: f32 = f32::INFINITY;

/// Cosine of the angle to the nearest outer pixel; -1 without any.
///
/// `outer` holds for each pixel the versine of the azimuth to the nearest outer pixel in the same row.
fn nearest(sphere: &CellCentres, outer: &[f32], row: usize, column: usize) -> f64 {
    let (sin, cos) = sphere.rows[row];
    let mut largest = -1.0;
    // Try rows until they are farther than the nearest outer pixel so far.
    let mut is_within = |other: usize| {
        let (other_sin, other_cos) = sphere.rows[other];
        let is_within = cos * other_cos + sin * other_sin > largest;
        if is_within {
            let versine = f64::from(outer[other * sphere.columns.len() + column]);
            largest = f64::max(largest, cos * other_cos + sin * other_sin * (1.0 - versine));
        }
        is_within
    };
    (0..=row).rev().all(&mut is_within);
    (row + 1..sphere.rows.len()).all(&mut is_within);
    largest
}

/// For each of some columns, 1 - cos of the azimuth between it and the nearer one of its run's `ends`.
fn fill_versines(
    sphere: &CellCentres,
    columns: Range<usize>,
    ends: Option<[usize; 2]>,
    versines: &mut Vec<f32>,
) {
    versines.clear();
    let Some(ends) = ends else { return versines.resize(columns.len(), NO_OUTER) };
    let [before, after] = ends.map(|end| sphere.columns[end]);
    versines.extend(sphere.columns[columns].iter().map(|(sin, cos)| {
        let versine = |end: (f64, f64)| 1.0 - (sin * end.0 + cos * end.1);
        versine(before).min(versine(after)) as f32
    }));
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use glam::DVec3;
    use ndarray::Array3;

    use super::super::super::segment::run::runs;
    use super::*;
    use crate::kernels::sphere::Registration;

    const HEIGHT: usize = 64;

    /// The depths of pixels in ascending order.
    fn depths_of(working: &WorkingImage, plateau: &[u32]) -> Vec<f32> {
        depths(working, &runs(plateau, 2 * HEIGHT))
    }

    fn image() -> WorkingImage {
        let map = Array3::zeros((HEIGHT, 2 * HEIGHT, 3));
        WorkingImage::of(map.view(), Registration::CellCentred, 2 * HEIGHT).unwrap()
    }

    /// Pixels within `radius` of `centre`.
    fn cap(sphere: &CellCentres, centre: DVec3, radius: f64) -> Vec<u32> {
        let all = 0..(2 * HEIGHT * HEIGHT) as u32;
        all.filter(|&pixel| sphere.direction(pixel as usize).angle_between(centre) < radius).collect()
    }

    /// The nearest outer pixel of each, by trying all of them.
    #[test]
    fn depths_are_the_angles_to_the_nearest_outer_pixel_across_seam_and_pole_too() {
        let working = image();
        let sphere = CellCentres::new(&working.grid);
        for centre in [DVec3::new(0.3, 0.4, 1.0), DVec3::new(0.05, 0.3, -1.0), DVec3::new(0.1, -1.0, 0.1)] {
            let mut plateau = cap(&sphere, centre.normalize(), 0.35);
            plateau.retain(|pixel| pixel % 41 != 0); // some holes
            let result = depths_of(&working, &plateau);
            let outer: Vec<DVec3> = (0..result.len() as u32)
                .filter(|pixel| plateau.binary_search(pixel).is_err())
                .map(|pixel| sphere.direction(pixel as usize))
                .collect();
            for &pixel in &plateau {
                let own = sphere.direction(pixel as usize);
                let cosine = outer.iter().map(|other| own.dot(*other)).fold(-1.0, f64::max);
                assert_relative_eq!(
                    f64::from(result[pixel as usize]),
                    cosine.min(1.0).acos(),
                    epsilon = 1e-6
                );
            }
        }
    }

    #[test]
    fn the_centre_of_a_cap_is_as_deep_as_its_radius() {
        let working = image();
        let plateau = cap(&CellCentres::new(&working.grid), DVec3::Y, 0.5);
        let deepest = depths_of(&working, &plateau).into_iter().fold(0.0, f32::max);
        assert_relative_eq!(f64::from(deepest), 0.5, epsilon = working.row_height());
    }

    /// Only the rows at the poles are outside of the plateau.
    #[test]
    fn the_depth_of_a_band_is_the_angle_to_its_nearer_rim() {
        let working = image();
        let width = 2 * HEIGHT;
        let band: Vec<u32> = (width as u32..((HEIGHT - 1) * width) as u32).collect();
        for (pixel, depth) in depths_of(&working, &band).into_iter().enumerate() {
            let rows = (pixel / width).min(HEIGHT - 1 - pixel / width);
            assert_relative_eq!(f64::from(depth), rows as f64 * working.row_height(), epsilon = 1e-6);
        }
    }

    #[test]
    fn a_plateau_without_a_rim_is_half_a_turn_deep() {
        let all: Vec<u32> = (0..(2 * HEIGHT * HEIGHT) as u32).collect();
        let depth = depths_of(&image(), &all);
        assert!(depth.iter().all(|&depth| (depth - std::f32::consts::PI).abs() < 1e-5));
    }
}
