//! Pixels of a map near a direction, their parts inside a card, and interpolation between their centres.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use super::card_matrix;
use crate::kernels::image::{CellCentres, Grid};
use crate::kernels::sphere::{self, Registration};

/// Samples along each side of a pixel for its part inside a card.
const SAMPLES: usize = 6;

/// Cells of the pixels of a map.
pub struct CardPixels {
    pub height: usize,
    pub width: usize,
    grid: Grid,
    centres: CellCentres,
    bands: Vec<f64>,
    registration: Registration,
}

impl CardPixels {
    pub fn new(height: usize, width: usize, registration: Registration) -> Self {
        let grid = Grid::of_pixels(height, width, registration);
        let (centres, bands) = (CellCentres::new(&grid), sphere::band_heights(&grid.theta_edges));
        Self { height, width, grid, centres, bands, registration }
    }

    /// Cells of the pixels.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Height of a row in radians.
    pub fn step(&self) -> f64 {
        PI / self.height as f64
    }

    /// Direction of the centre of a pixel.
    pub fn direction(&self, pixel: usize) -> DVec3 {
        self.centres.direction(pixel)
    }

    /// Polar angle and azimuth of the centre of a pixel.
    pub fn angles(&self, pixel: usize) -> (f64, f64) {
        let middle = |edges: &[f64], at: usize| 0.5 * (edges[at] + edges[at + 1]);
        (middle(&self.grid.theta_edges, pixel / self.width), middle(&self.grid.phi_edges, pixel % self.width))
    }

    /// Solid angle of a pixel.
    pub fn solid_angle(&self, pixel: usize) -> f64 {
        let column = pixel % self.width;
        self.bands[pixel / self.width] * (self.grid.phi_edges[column + 1] - self.grid.phi_edges[column])
    }

    /// Flat indices of the pixels whose centres lie within an angle of a direction, row after row.
    pub fn near(&self, direction: DVec3, reach: f64) -> Vec<usize> {
        let (theta, phi) = sphere::angles(direction);
        let mut pixels = Vec::new();
        for row in 0..self.height {
            let middle = 0.5 * (self.grid.theta_edges[row] + self.grid.theta_edges[row + 1]);
            if (middle - theta).abs() > reach {
                continue;
            }
            let below = middle.sin() * theta.sin();
            let cosine = (reach.cos() - middle.cos() * theta.cos()) / below.max(1e-12);
            let half = cosine.clamp(-1.0, 1.0).acos() * self.width as f64 / TAU;
            let first = (phi * self.width as f64 / TAU - half).floor() as i64;
            let count = ((2.0 * half).ceil() as usize + 1).min(self.width);
            let column = |i: usize| (first + i as i64).rem_euclid(self.width as i64) as usize;
            pixels.extend((0..count).map(|i| row * self.width + column(i)));
        }
        pixels
    }

    /// Pixels with a part inside a card, and the value of `sum` over the samples of that part, divided by all samples.
    pub fn inside<T>(
        &self,
        matrix: &DMat3,
        is_ellipse: bool,
        mut sum: impl FnMut(&mut T, glam::DVec2),
        start: impl Fn() -> T,
    ) -> Vec<(usize, f64, T)> {
        let inverse = matrix.inverse();
        let reach = card_matrix::reach(matrix) + 2.0 * self.step();
        let mut parts = Vec::new();
        for pixel in self.near(card_matrix::centre(matrix), reach) {
            let (mut total, mut hits) = (start(), 0);
            for direction in self.samples(pixel) {
                let place = card_matrix::place_of(&inverse, direction);
                if let Some(place) = place.filter(|&place| card_matrix::is_inside(place, is_ellipse)) {
                    hits += 1;
                    sum(&mut total, place);
                }
            }
            if hits > 0 {
                parts.push((pixel, f64::from(hits) / (SAMPLES * SAMPLES) as f64, total));
            }
        }
        parts
    }

    /// Directions spread evenly over a pixel.
    fn samples(&self, pixel: usize) -> impl Iterator<Item = DVec3> {
        let (row, column) = (pixel / self.width, pixel % self.width);
        let at = |edges: &[f64], cell: usize, i: usize| {
            let part = (i as f64 + 0.5) / SAMPLES as f64;
            (edges[cell] + part * (edges[cell + 1] - edges[cell])).sin_cos()
        };
        let columns: [_; SAMPLES] = std::array::from_fn(|i| at(&self.grid.phi_edges, column, i));
        let rows: [_; SAMPLES] = std::array::from_fn(|i| at(&self.grid.theta_edges, row, i));
        rows.into_iter()
            .flat_map(move |row| columns.into_iter().map(move |column| sphere::direction_of(row, column)))
    }

    /// Distance of an azimuth from the middle of the first column, in columns.
    fn columns(&self, azimuth: f64) -> f64 {
        match self.registration {
            Registration::CellCentred => azimuth / TAU * self.width as f64 - 0.5,
            Registration::BorderSampled => azimuth / TAU * (self.width - 1) as f64,
        }
    }

    /// Distance of a polar angle from the middle of the first row, in rows.
    fn rows(&self, theta: f64) -> f64 {
        match self.registration {
            Registration::CellCentred => theta / PI * self.height as f64 - 0.5,
            Registration::BorderSampled => theta / PI * (self.height - 1) as f64,
        }
    }

    /// Column whose middle is nearest to an azimuth.
    pub fn column(&self, azimuth: f64) -> usize {
        let column = self.columns(azimuth.rem_euclid(TAU)).round();
        (column as i64).rem_euclid(self.width as i64) as usize
    }

    /// Row whose middle is nearest to a polar angle.
    pub fn row(&self, theta: f64) -> usize {
        (self.rows(theta).round() as usize).min(self.height - 1)
    }

    /// The four pixels around a direction with their bilinear weights; across the seam and the poles.
    pub fn around(&self, direction: DVec3) -> [(usize, f64); 4] {
        let (theta, phi) = sphere::angles(direction);
        let (rows, columns) = (self.rows(theta), self.columns(phi));
        let (row, column) = (rows.floor(), columns.floor());
        let (down, right) = (rows - row, columns - column);
        let pixel = |rows: i64, columns: i64| self.pixel(row as i64 + rows, column as i64 + columns);
        [
            (pixel(0, 0), (1.0 - down) * (1.0 - right)),
            (pixel(0, 1), (1.0 - down) * right),
            (pixel(1, 0), down * (1.0 - right)),
            (pixel(1, 1), down * right),
        ]
    }

    /// Flat index of a row and a column that may lie beyond a pole or the seam.
    fn pixel(&self, row: i64, column: i64) -> usize {
        let (height, width) = (self.height as i64, self.width as i64);
        let is_beyond = row < 0 || row >= height;
        let column = if is_beyond { column + width / 2 } else { column };
        row.clamp(0, height - 1) as usize * self.width + column.rem_euclid(width) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::cards::card_matrix::square_towards;

    #[test]
    fn parts_inside_a_card_sum_to_its_solid_angle_at_a_pole_and_the_seam_and_in_border_samples() {
        // A facing square of half-width t has the solid angle 4 asin(t^2 / (1 + t^2)).
        let side = 0.3_f64.tan().powi(2);
        let exact = 4.0 * (side / (1.0 + side)).asin();
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = CardPixels::new(128, 256, registration);
            for towards in [DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
                let parts = pixels.inside(&square_towards(towards, 0.3), false, |(), _| (), || ());
                let sum: f64 = parts.iter().map(|(pixel, part, ())| part * pixels.solid_angle(*pixel)).sum();
                // Six samples place an edge along pixels within 1/12 of one, and the card is 24 pixels wide.
                assert!((sum / exact - 1.0).abs() < 1.4e-2, "{towards} {sum} {exact}");
            }
        }
    }

    #[test]
    fn the_row_and_column_of_the_middle_of_a_pixel_are_its_own() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = CardPixels::new(16, 32, registration);
            for pixel in 33..16 * 32 - 33 {
                let (theta, phi) = sphere::angles(pixels.direction(pixel));
                // A border column lies on the seam, and its middle beside it.
                let is_border =
                    registration == Registration::BorderSampled && [0, 31].contains(&(pixel % 32));
                assert!(is_border || pixels.row(theta) * 32 + pixels.column(phi) == pixel, "{pixel}");
            }
        }
    }

    #[test]
    fn bilinear_weights_reproduce_the_direction() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = CardPixels::new(64, 128, registration);
            // Border cells at the seam are half as wide, so their middles are no samples.
            for i in 1..40 {
                let towards = sphere::direction(0.3 + 0.05 * f64::from(i), 0.13 * f64::from(i));
                let mean: DVec3 =
                    pixels.around(towards).iter().map(|&(pixel, w)| w * pixels.direction(pixel)).sum();
                assert!(mean.angle_between(towards) < 2e-3, "{i} {mean} {towards}");
            }
        }
    }
}
