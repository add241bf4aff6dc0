//! Bright pixels in another layout: each keeps its flux and the direction of its centroid.
//!
//! A pixel is divided into places, and the flux of each place is distributed bilinearly over the four nearest new
//! pixels. The weights w of all new pixels are then tilted, so that their centroid is that of the old pixel:
//!
//! ```text
//!   w <- w (1 - g . t),   sum of w (1 - g . t) t = 0
//! ```
//!
//! with t the centroid of each new pixel in the tangent plane of the direction. Weights that would become negative stay as
//! they are.

use glam::{DMat2, DMat3, DVec2, DVec3};
use rayon::prelude::*;

use crate::interrupt;
use crate::kernels::projection::{SphereProjection, even_nodes};
use crate::kernels::sphere;

/// Least and largest number of places along the side of a pixel.
const SIDES: (usize, usize) = (4, 64);
/// Places along the side of an old pixel, for each new pixel along it: places must not leave new pixels out.
const PLACES_PER_PIXEL: f64 = 2.0;

/// Pixel whose own flux is preserved.
#[derive(Clone, Copy, Debug)]
pub struct BrightPixel {
    /// Number in the old picture.
    pub pixel: usize,
    /// Radiance times solid angle.
    pub flux: [f64; 3],
}

/// New pixels with the radiance to add to each, in the order of the bright ones.
pub fn splat(
    bright: &[BrightPixel],
    from: &dyn SphereProjection,
    to: &dyn SphereProjection,
    rotation: DMat3,
) -> Vec<(usize, [f64; 3])> {
    let of_one = |bright: &BrightPixel| -> Vec<(usize, [f64; 3])> {
        interrupt::check();
        let weights = weights(bright.pixel, from, to, rotation).into_iter();
        let radiance = |(pixel, weight): (usize, f64)| {
            (pixel, bright.flux.map(|flux| flux * weight / to.solid_angle(pixel)))
        };
        weights.map(radiance).collect()
    };
    let parts: Vec<Vec<_>> = bright.par_iter().map(of_one).collect();
    parts.into_iter().flatten().collect()
}

/// Fraction of a bright pixel's flux in each new pixel, by their numbers.
fn weights(
    pixel: usize,
    from: &dyn SphereProjection,
    to: &dyn SphereProjection,
    rotation: DMat3,
) -> Vec<(usize, f64)> {
    let centroid = rotation * from.moment(pixel).normalize();
    let near = to.place(centroid).map_or(f64::INFINITY, |place| to.solid_angle(pixel_of(to, place)));
    let new_pixels = PLACES_PER_PIXEL * (from.solid_angle(pixel) / near).sqrt();
    let mut shares = Vec::new();
    for node in even_nodes(from, pixel, (new_pixels.ceil() as usize).clamp(SIDES.0, SIDES.1)) {
        if let Some(place) = to.place(rotation * node.direction) {
            bilinear(to, place, node.weight, &mut shares);
        }
    }
    shares.sort_by_key(|&(pixel, _)| pixel);
    let sum = |same: &[(usize, f64)]| (same[0].0, same.iter().map(|&(_, weight)| weight).sum());
    let weights = shares.chunk_by(|a, b| a.0 == b.0).map(sum).collect();
    tilt(weights, to, centroid)
}

/// Number of the pixel around a place.
fn pixel_of(layout: &dyn SphereProjection, place: DVec2) -> usize {
    let [height, width] = layout.size();
    (place.y as usize).min(height - 1) * width + (place.x as usize).min(width - 1)
}

/// Add the four pixels around a place, with the weight of each.
fn bilinear(to: &dyn SphereProjection, place: DVec2, weight: f64, shares: &mut Vec<(usize, f64)>) {
    let own = pixel_of(to, place);
    // Position in the pixel from -0.5 to 0.5.
    let offset = place - DVec2::new((own % to.size()[1]) as f64, (own / to.size()[1]) as f64) - 0.5;
    let step = |offset: f64| if offset < 0.0 { -1 } else { 1 };
    let (right, down) = (step(offset.x), step(offset.y));
    let (across, along) = (offset.x.abs(), offset.y.abs());
    let corners = [
        ([0, 0], (1.0 - across) * (1.0 - along)),
        ([0, right], across * (1.0 - along)),
        ([down, 0], (1.0 - across) * along),
        ([down, right], across * along),
    ];
    for (offset, share) in corners {
        let pixel = to.neighbour(own, offset).filter(|&pixel| to.solid_angle(pixel) > 0.0);
        shares.push((pixel.unwrap_or(own), weight * share));
    }
}

/// Weights whose centroid is `centroid`; the sum is unchanged.
fn tilt(mut weights: Vec<(usize, f64)>, to: &dyn SphereProjection, centroid: DVec3) -> Vec<(usize, f64)> {
    let tangents = sphere::tangents(centroid);
    let offset = |pixel: usize| {
        let mean = to.moment(pixel) / to.solid_angle(pixel);
        DVec2::new(mean.dot(tangents[0]), mean.dot(tangents[1]))
    };
    let offsets: Vec<DVec2> = weights.iter().map(|&(pixel, _)| offset(pixel)).collect();
    // Solve for g with the second and the first moment of the offsets.
    let (mut second, mut first) = (DMat2::ZERO, DVec2::ZERO);
    for (&(_, weight), &t) in weights.iter().zip(&offsets) {
        second += DMat2::from_cols(weight * t.x * t, weight * t.y * t);
        first += weight * t;
    }
    let trace = second.x_axis.x + second.y_axis.y;
    if second.determinant() < 1e-12 * trace * trace {
        return weights;
    }
    let g = second.inverse() * first;
    let factors: Vec<f64> = offsets.iter().map(|t| 1.0 - g.dot(*t)).collect();
    if factors.iter().any(|&factor| factor < 0.0) {
        return weights;
    }
    let total: f64 = weights.iter().map(|&(_, weight)| weight).sum();
    let tilted: f64 = weights.iter().zip(&factors).map(|(&(_, weight), factor)| weight * factor).sum();
    for ((_, weight), factor) in weights.iter_mut().zip(factors) {
        *weight *= factor * total / tilted;
    }
    weights
}
