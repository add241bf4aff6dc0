//! The depth of a pixel of the plateau: the angle to the nearest pixel outside of it.
//!
//! Pixels hand on the nearest outer pixel that they know, from neighbour to neighbour, in sweeps over the
//! sphere (Danielsson 1980): a few comparisons for each pixel, however deep it lies. Distances are those
//! between directions, so they hold at the seam and the poles.

use rayon::prelude::*;

use super::super::tree::working_image::WorkingImage;

/// Pixels that one task turns into depths.
const PIXELS_AT_ONCE: usize = 2048;

/// The depth of each of the pixels `plateau` in radians, as an image; 0 outside.
pub fn depths(working: &WorkingImage, plateau: &[u32]) -> Vec<f32> {
    let (height, width) = working.size;
    let sphere = Sphere::new(working);
    let mut nearest = Nearest::new(&sphere, working.size, plateau);
    // Where the plateau crosses the seam or a pole, what one sweep finds must go around once more.
    let rows: Vec<&[u32]> =
        plateau.chunk_by(|&one, &other| one as usize / width == other as usize / width).collect();
    let touches = |row: &[u32]| {
        let first = row[0] as usize / width * width;
        let is_at_seam = row[0] as usize == first || row[row.len() - 1] as usize == first + width - 1;
        is_at_seam || first == 0 || first == (height - 1) * width
    };
    for _ in 0..if rows.iter().any(|row| touches(row)) { 2 } else { 1 } {
        for row in &rows {
            nearest.ask_row(row, Side::Above);
        }
        for row in rows.iter().rev() {
            nearest.ask_row(row, Side::Below);
        }
    }
    // Turn cosines into angles.
    let angle = |&pixel: &u32| {
        let cosine = nearest.cosine[pixel as usize];
        (2.0 * (0.5 * (1.0 - cosine)).max(0.0).sqrt().min(1.0).asin()) as f32
    };
    let angles: Vec<f32> = plateau.par_iter().with_min_len(PIXELS_AT_ONCE).map(angle).collect();
    let mut depth = vec![0.0; height * width];
    for (&pixel, angle) in plateau.iter().zip(angles) {
        depth[pixel as usize] = angle;
    }
    depth
}

/// Row and column of a pixel.
type Place = [u32; 2];

/// In place of the nearest outer pixel: none is known yet.
const UNKNOWN: Place = [u32::MAX; 2];

/// The row that a row asks.
#[derive(Clone, Copy)]
enum Side {
    Above,
    Below,
}

/// The nearest outer pixel that each pixel knows. Outer pixels know themselves.
struct Nearest<'a> {
    sphere: &'a Sphere,
    of: Vec<Place>,
    /// Cosine of the angle to it; -1 where none is known.
    cosine: Vec<f64>,
    height: usize,
    width: usize,
}

impl<'a> Nearest<'a> {
    fn new(sphere: &'a Sphere, (height, width): (usize, usize), plateau: &[u32]) -> Self {
        let columns = 0..width as u32;
        let mut of: Vec<Place> =
            (0..height as u32).flat_map(|row| columns.clone().map(move |column| [row, column])).collect();
        for &pixel in plateau {
            of[pixel as usize] = UNKNOWN;
        }
        Self { sphere, of, cosine: vec![-1.0; height * width], height, width }
    }

    /// Let the pixels of a row ask those of the row beside, then one another, along the row both ways.
    fn ask_row(&mut self, row: &[u32], side: Side) {
        let width = self.width;
        let number = row[0] as usize / width;
        let first = number * width;
        let beside = match side {
            Side::Above => number.saturating_sub(1),
            Side::Below => (number + 1).min(self.height - 1),
        } * width;
        let left = |column: usize| if column == 0 { width - 1 } else { column - 1 };
        let right = |column: usize| if column + 1 == width { 0 } else { column + 1 };
        for &pixel in row {
            let column = pixel as usize - first;
            let others =
                [beside + left(column), beside + column, beside + right(column), first + left(column)];
            self.ask([number, column], others);
        }
        for &pixel in row.iter().rev() {
            let column = pixel as usize - first;
            self.ask([number, column], [first + right(column)]);
        }
    }

    /// Take over the nearest outer pixel that one of the `others` knows or is.
    #[inline]
    fn ask<const N: usize>(&mut self, [row, column]: [usize; 2], others: [usize; N]) {
        let pixel = row * self.width + column;
        let mut best = self.of[pixel];
        let mut tried = best;
        for other in others {
            let outer = self.of[other];
            // Neighbours mostly know the same one.
            if outer == best || outer == tried || outer == UNKNOWN {
                continue;
            }
            tried = outer;
            let cosine = self.sphere.cosine([row, column], outer.map(|index| index as usize));
            if cosine > self.cosine[pixel] {
                (best, self.cosine[pixel]) = (outer, cosine);
            }
        }
        self.of[pixel] = best;
    }
}

/// The directions of pixels, by row and column.
pub struct Sphere {
    width: usize,
    /// Sine and cosine of the polar angle of each row.
    rows: Vec<(f64, f64)>,
    /// Sine and cosine of the azimuth of each column.
    columns: Vec<(f64, f64)>,
}

impl Sphere {
    /// The centres of the pixels of an image.
    pub fn new(working: &WorkingImage) -> Self {
        let centres =
            |edges: &[f64]| edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos()).collect();
        let grid = &working.grid;
        Self { width: working.size.1, rows: centres(&grid.theta_edges), columns: centres(&grid.phi_edges) }
    }

    /// Unit vector towards a pixel, in the frame of [`crate::kernels::sphere`].
    pub fn direction(&self, pixel: u32) -> glam::DVec3 {
        let pixel = pixel as usize;
        let ((sin, cos), (sin_phi, cos_phi)) = self.at([pixel / self.width, pixel % self.width]);
        glam::DVec3::new(sin * sin_phi, cos, -sin * cos_phi)
    }

    /// Cosine of the angle between two pixels.
    fn cosine(&self, one: [usize; 2], other: [usize; 2]) -> f64 {
        let ((sin, cos), (sin_phi, cos_phi)) = self.at(one);
        let ((other_sin, other_cos), (other_sin_phi, other_cos_phi)) = self.at(other);
        sin * other_sin * (sin_phi * other_sin_phi + cos_phi * other_cos_phi) + cos * other_cos
    }

    fn at(&self, [row, column]: [usize; 2]) -> ((f64, f64), (f64, f64)) {
        (self.rows[row], self.columns[column])
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use glam::DVec3;
    use ndarray::Array3;

    use super::*;
    use crate::kernels::sphere::Registration;

    const HEIGHT: usize = 64;

    fn image() -> WorkingImage {
        let map = Array3::zeros((HEIGHT, 2 * HEIGHT, 3));
        WorkingImage::of(map.view(), Registration::CellCentred, 2 * HEIGHT).unwrap()
    }

    /// Pixels within `radius` of `centre`.
    fn cap(sphere: &Sphere, centre: DVec3, radius: f64) -> Vec<u32> {
        let all = 0..(2 * HEIGHT * HEIGHT) as u32;
        all.filter(|&pixel| sphere.direction(pixel).angle_between(centre) < radius).collect()
    }

    /// The nearest outer pixel of each, by trying all of them.
    #[test]
    fn depths_are_the_angles_to_the_nearest_outer_pixel_across_seam_and_pole_too() {
        let working = image();
        let sphere = Sphere::new(&working);
        for centre in [DVec3::new(0.3, 0.4, 1.0), DVec3::new(0.05, 0.3, -1.0), DVec3::new(0.1, -1.0, 0.1)] {
            let mut plateau = cap(&sphere, centre.normalize(), 0.35);
            plateau.retain(|pixel| pixel % 41 != 0); // some holes
            let found = depths(&working, &plateau);
            let outer: Vec<DVec3> = (0..found.len() as u32)
                .filter(|pixel| plateau.binary_search(pixel).is_err())
                .map(|pixel| sphere.direction(pixel))
                .collect();
            for &pixel in &plateau {
                let own = sphere.direction(pixel);
                let cosine = outer.iter().map(|other| own.dot(*other)).fold(-1.0, f64::max);
                // A sweep may miss the nearest one where the plateau's rim turns, by less than a pixel.
                let wanted = cosine.min(1.0).acos();
                let depth = f64::from(found[pixel as usize]);
                assert!(depth >= wanted - 1e-5 && depth <= wanted + 0.01, "{pixel}: {depth} {wanted}");
            }
        }
    }

    #[test]
    fn the_centre_of_a_cap_is_as_deep_as_its_radius() {
        let working = image();
        let plateau = cap(&Sphere::new(&working), DVec3::Y, 0.5);
        let deepest = depths(&working, &plateau).into_iter().fold(0.0, f32::max);
        assert_relative_eq!(f64::from(deepest), 0.5, epsilon = working.row_height());
    }

    #[test]
    fn a_plateau_without_a_rim_is_half_a_turn_deep() {
        let all: Vec<u32> = (0..(2 * HEIGHT * HEIGHT) as u32).collect();
        let depth = depths(&image(), &all);
        assert!(depth.iter().all(|&depth| (depth - std::f32::consts::PI).abs() < 1e-5));
    }
}
