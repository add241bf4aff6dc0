//! Bright pixels in another layout: each keeps its flux and the direction of its centroid.
//!
//! A pixel is divided into places, and the flux of each place is distributed bilinearly over the four nearest new
//! pixels. The weights w of all new pixels are then tilted, so that their centroid is that of the old pixel:
//!
//! ```text
//!   w <- w exp(g . t),   sum of w exp(g . t) t = 0
//! ```
//!
//! with t the centroid of each new pixel in the tangent plane of the direction. Newton's method finds g, because the
//! sum of w exp(g . t) is convex. All weights stay positive. If the new pixels do not surround the direction, as on the
//! rim of a picture, the weights stay as they are.

use glam::{DMat2, DMat3, DVec2, DVec3};
use rayon::prelude::*;

use crate::interrupt;
use crate::kernels::projection::{SphereProjection, even_nodes};
use crate::kernels::sphere;

/// Least and largest number of places along the side of a pixel.
const SIDES: (usize, usize) = (4, 64);
/// Places along the side of an old pixel, for each new pixel along it: places must not leave new pixels out.
const PLACES_PER_PIXEL: f64 = 2.0;

/// Steps of Newton's method; most pixels need 3.
const NEWTON_STEPS: usize = 30;
/// Accuracy of a centroid, in distances to the farthest new pixel.
const CENTROID_TOLERANCE: f64 = 1e-9;

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
    let near = to.place(centroid).map_or(f64::INFINITY, |place| narrow_side(to, pixel_of(to, place)));
    let new_pixels = PLACES_PER_PIXEL * from.solid_angle(pixel).sqrt() / near;
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

/// Distance of a pixel to the nearer of its neighbours below and to the right.
fn narrow_side(layout: &dyn SphereProjection, pixel: usize) -> f64 {
    if layout.solid_angle(pixel) <= 0.0 {
        return f64::INFINITY;
    }
    let own = layout.moment(pixel).normalize();
    let neighbours = [[0, 1], [1, 0]].into_iter().filter_map(|step| layout.neighbour(pixel, step));
    let visible = neighbours.filter(|&other| other != pixel && layout.solid_angle(other) > 0.0);
    let distances = visible.map(|other| own.distance(layout.moment(other).normalize()));
    distances.fold(layout.solid_angle(pixel).sqrt(), f64::min)
}

/// Number of the pixel around a place.
fn pixel_of(layout: &dyn SphereProjection, place: DVec2) -> usize {
    let [height, width] = layout.size();
    (place.y as usize).min(height - 1) * width + (place.x as usize).min(width - 1)
}

/// Add the four pixels around a place, with the weight of each.
fn bilinear(to: &dyn SphereProjection, place: DVec2, weight: f64, shares: &mut Vec<(usize, f64)>) {
    let own = pixel_of(to, place);
    // The rim of a picture may touch a pixel in one point.
    let visible = largest_near(to, own);
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
        shares.push((pixel.unwrap_or(visible), weight * share));
    }
}

/// The pixel itself, or its largest neighbour if the picture shows nothing of it.
fn largest_near(layout: &dyn SphereProjection, pixel: usize) -> usize {
    if layout.solid_angle(pixel) > 0.0 {
        return pixel;
    }
    let steps = (0..9).map(|i| [i / 3 - 1, i % 3 - 1]);
    let near = steps.filter_map(|step| layout.neighbour(pixel, step));
    near.max_by(|&a, &b| layout.solid_angle(a).total_cmp(&layout.solid_angle(b))).unwrap_or(pixel)
}

/// Weights whose centroid is `centroid`; the sum is unchanged.
fn tilt(mut weights: Vec<(usize, f64)>, to: &dyn SphereProjection, centroid: DVec3) -> Vec<(usize, f64)> {
    let tangents = sphere::tangents(centroid);
    let offset = |&(pixel, weight): &(usize, f64)| {
        let mean = to.moment(pixel) / to.solid_angle(pixel);
        (DVec2::new(mean.dot(tangents[0]), mean.dot(tangents[1])), weight)
    };
    let offsets: Vec<(DVec2, f64)> = weights.iter().map(offset).collect();
    let Some(g) = exponent(&offsets) else { return weights };
    let factor = |t: DVec2| g.dot(t).exp();
    let total: f64 = offsets.iter().map(|&(_, weight)| weight).sum();
    let tilted: f64 = offsets.iter().map(|&(t, weight)| weight * factor(t)).sum();
    for ((_, weight), (t, _)) in weights.iter_mut().zip(&offsets) {
        *weight *= factor(*t) * total / tilted;
    }
    weights
}

/// Vector g with a zero sum of w exp(g . t) t over offsets t and weights w; `None` if Newton's method finds none.
fn exponent(offsets: &[(DVec2, f64)]) -> Option<DVec2> {
    let reach = offsets.iter().map(|(t, _)| t.length()).fold(0.0, f64::max);
    let mut g = DVec2::ZERO;
    for _ in 0..NEWTON_STEPS {
        let (mut sum, mut first, mut second) = (0.0, DVec2::ZERO, DMat2::ZERO);
        for &(t, weight) in offsets {
            let weight = weight * g.dot(t).exp();
            sum += weight;
            first += weight * t;
            second += DMat2::from_cols(weight * t.x * t, weight * t.y * t);
        }
        if first.length() <= CENTROID_TOLERANCE * reach * sum {
            return Some(g);
        }
        let trace = second.x_axis.x + second.y_axis.y;
        if second.determinant() <= 1e-12 * trace * trace {
            return None;
        }
        let step = second.inverse() * first;
        // A long step would overflow the exponentials.
        g -= step * (1.0 / (step.length() * reach)).min(1.0);
    }
    None
}
