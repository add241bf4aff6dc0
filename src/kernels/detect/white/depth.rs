//! The depth of a pixel of the plateau: the angle to the nearest pixel outside of it.
//!
//! Pixels hand on the nearest outer pixel that they know, from neighbour to neighbour, in sweeps over the
//! sphere (Danielsson 1980): a few comparisons for each pixel, however deep it lies. Distances are those
//! between directions, so they hold at the seam and the poles.

use super::super::tree::working_image::WorkingImage;

/// The depth of each of the pixels `plateau` in radians, as an image; 0 outside.
pub fn depths(working: &WorkingImage, plateau: &[u32]) -> Vec<f32> {
    let (height, width) = working.size;
    let sphere = Sphere::new(working);
    let (of, cosine) = (vec![OUTSIDE; height * width], vec![-1.0; height * width]);
    let mut nearest = Nearest { sphere: &sphere, of, cosine, height, width };
    for &pixel in plateau {
        nearest.of[pixel as usize] = UNKNOWN;
    }
    // Where the plateau crosses the seam or a pole, what one sweep finds must go around once more.
    let touches = |pixel: u32| {
        let (row, column) = (pixel as usize / width, pixel as usize % width);
        row == 0 || row + 1 == height || column == 0 || column + 1 == width
    };
    for _ in 0..if plateau.iter().any(|&pixel| touches(pixel)) { 2 } else { 1 } {
        nearest.sweep_down(plateau);
        nearest.sweep_up(plateau);
    }
    let mut depth = vec![0.0; height * width];
    for &pixel in plateau {
        let cosine = nearest.cosine[pixel as usize];
        depth[pixel as usize] = (2.0 * (0.5 * (1.0 - cosine)).max(0.0).sqrt().min(1.0).asin()) as f32;
    }
    depth
}

/// In place of the nearest outer pixel: this one is outside itself.
const OUTSIDE: u32 = u32::MAX;
/// In place of the nearest outer pixel: none is known yet.
const UNKNOWN: u32 = u32::MAX - 1;

/// The nearest outer pixel that each pixel knows.
struct Nearest<'a> {
    sphere: &'a Sphere,
    of: Vec<u32>,
    /// Cosine of the angle to it; -1 where none is known.
    cosine: Vec<f64>,
    height: usize,
    width: usize,
}

impl Nearest<'_> {
    /// From above, and along each row both ways.
    fn sweep_down(&mut self, plateau: &[u32]) {
        let width = self.width;
        for row in plateau.chunk_by(|&one, &other| one as usize / width == other as usize / width) {
            self.ask_row(row, (row[0] as usize / width).saturating_sub(1));
        }
    }

    /// From below, and along each row both ways.
    fn sweep_up(&mut self, plateau: &[u32]) {
        let (last, width) = (self.height - 1, self.width);
        let rows: Vec<&[u32]> =
            plateau.chunk_by(|&one, &other| one as usize / width == other as usize / width).collect();
        for row in rows.into_iter().rev() {
            self.ask_row(row, (row[0] as usize / width + 1).min(last));
        }
    }

    /// Let the pixels of a row ask those of the row `beside`, then one another.
    fn ask_row(&mut self, row: &[u32], beside: usize) {
        let width = self.width;
        let first = row[0] as usize / width * width;
        let left = |column: usize| if column == 0 { width - 1 } else { column - 1 };
        let right = |column: usize| if column + 1 == width { 0 } else { column + 1 };
        for &pixel in row {
            let column = pixel as usize - first;
            let others = [left(column), column, right(column)].map(|column| beside * width + column);
            self.ask(pixel, [others[0], others[1], others[2], first + left(column)]);
        }
        for &pixel in row.iter().rev() {
            self.ask(pixel, [first + right(pixel as usize - first)]);
        }
    }

    /// Take over the nearest outer pixel that one of the `others` knows or is.
    fn ask<const N: usize>(&mut self, pixel: u32, others: [usize; N]) {
        let mut best = self.of[pixel as usize];
        let mut largest = self.cosine[pixel as usize];
        let mut tried = best;
        for other in others {
            let outer = match self.of[other] {
                UNKNOWN => continue,
                OUTSIDE => other as u32,
                outer => outer,
            };
            // Neighbours mostly know the same one.
            if outer == best || outer == tried {
                continue;
            }
            tried = outer;
            let cosine = self.sphere.cosine(pixel, outer);
            if cosine > largest {
                (best, largest) = (outer, cosine);
            }
        }
        self.of[pixel as usize] = best;
        self.cosine[pixel as usize] = largest;
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
        let ((sin, cos), (sin_phi, cos_phi)) = self.at(pixel);
        glam::DVec3::new(sin * sin_phi, cos, -sin * cos_phi)
    }

    /// Cosine of the angle between two pixels.
    fn cosine(&self, one: u32, other: u32) -> f64 {
        let ((sin, cos), (sin_phi, cos_phi)) = self.at(one);
        let ((other_sin, other_cos), (other_sin_phi, other_cos_phi)) = self.at(other);
        sin * other_sin * (sin_phi * other_sin_phi + cos_phi * other_cos_phi) + cos * other_cos
    }

    fn at(&self, pixel: u32) -> ((f64, f64), (f64, f64)) {
        let pixel = pixel as usize;
        (self.rows[pixel / self.width], self.columns[pixel % self.width])
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
