//! Drawing of cards into a black map.

use glam::{DMat3, DVec2, DVec3};

use super::card_matrix;
use super::card_pixels::CardPixels;
use crate::kernels::sphere::Registration;

/// Card to draw.
pub struct DrawnCard<'a> {
    /// Columns U, V, O.
    pub matrix: DMat3,
    /// True for the inscribed ellipse.
    pub is_disc: bool,
    /// Irradiance of each channel at normal incidence, which the drawn pixels have exactly.
    pub irradiance: DVec3,
    /// Rows and columns of the texture.
    pub size: [usize; 2],
    /// Radiance, row after row.
    pub texels: &'a [[f32; 3]],
}

/// Add cards to a map of this height and width.
pub fn draw(
    cards: &[DrawnCard<'_>],
    (height, width): (usize, usize),
    registration: Registration,
    map: &mut [[f32; 3]],
) {
    let pixels = CardPixels::new(height, width, registration);
    for card in cards {
        crate::interrupt::check();
        let drawn = parts_or_pixel(&pixels, card);
        let centre = card_matrix::centre(&card.matrix);
        let vector = |(pixel, radiance): &(usize, DVec3)| {
            pixels.solid_angle(*pixel) * pixels.direction(*pixel).dot(centre) * *radiance
        };
        let seen: DVec3 = drawn.iter().map(vector).sum();
        let gain = DVec3::from_array(
            [0, 1, 2].map(|c| if seen[c] > 0.0 { card.irradiance[c] / seen[c] } else { 0.0 }),
        );
        for (pixel, radiance) in drawn {
            let added = radiance * gain;
            for (channel, value) in map[pixel].iter_mut().enumerate() {
                *value = (f64::from(*value) + added[channel]) as f32;
            }
        }
    }
}

/// Radiance of the pixels of a card; a card between all samples colours the pixel of its centre.
fn parts_or_pixel(pixels: &CardPixels, card: &DrawnCard<'_>) -> Vec<(usize, DVec3)> {
    let sample = |sum: &mut DVec3, place| *sum += texel(card, place);
    let parts = pixels.inside(
        &card.matrix,
        card.is_disc,
        |(sum, hits): &mut (DVec3, f64), place| {
            sample(sum, place);
            *hits += 1.0;
        },
        || (DVec3::ZERO, 0.0),
    );
    if parts.is_empty() {
        let centre = card_matrix::centre(&card.matrix);
        let [pixel, ..] = pixels.around(centre);
        return vec![(pixel.0, DVec3::ONE)];
    }
    parts.into_iter().map(|(pixel, part, (sum, hits))| (pixel, sum * (part / hits))).collect()
}

/// Texel at a place of a card, interpolated; a disc has no dark texels to interpolate with, so it uses the nearest.
fn texel(card: &DrawnCard<'_>, place: DVec2) -> DVec3 {
    let [rows, columns] = card.size;
    let at = |row: f64, column: f64| {
        let row = row.clamp(0.0, rows as f64 - 1.0) as usize;
        let column = column.clamp(0.0, columns as f64 - 1.0) as usize;
        glam::Vec3::from_array(card.texels[row * columns + column]).as_dvec3()
    };
    let (row, column) = (place.y * rows as f64 - 0.5, place.x * columns as f64 - 0.5);
    if card.is_disc {
        return at(row.round(), column.round());
    }
    let (down, right) = (row - row.floor(), column - column.floor());
    let line = |row: f64| at(row, column.floor()) * (1.0 - right) + at(row, column.floor() + 1.0) * right;
    line(row.floor()) * (1.0 - down) + line(row.floor() + 1.0) * down
}
