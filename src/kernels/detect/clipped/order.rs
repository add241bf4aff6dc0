//! Order of the lights of a clipped map, and the lights that are dropped.
//!
//! Clipping makes all lights equal, so their flux says little about which one is the strongest. A small clipped light is
//! more often a lamp, a large one a wall; and light comes from above. With the expanded flux F', the
//! solid angle W and the elevation e,
//!
//! ```text
//!   weight = F' / W^(3/4) exp(1.5 sin e)
//! ```
//!
//! lies between the flux and the mean radiance. The powers are chosen on pictures of HDR maps, by the lights
//! that are found, and by the flux in those that are none.

use std::f64::consts::TAU;

use super::super::segment::components::Segments;
use super::super::segment::light_moments::LightMoments;
use super::super::segment::run::runs;
use super::super::segment::working_image::WorkingImage;
use super::position::LightPosition;

/// The power of the solid angle.
const SMALLNESS: f64 = 0.75;
/// Logarithm of the weight of a light at the zenith over that of one on the horizon.
const UPWARDS: f64 = 1.5;
/// Lights with a smaller share of the sum of all weights are left out.
const LEAST_SHARE: f64 = 0.01;
/// A clipped region of more steradians, below the horizon, is a floor.
const FLOOR: f64 = 0.5;
/// Sine of the elevation below which a floor may lie.
const FLOOR_BELOW: f64 = -0.3;

/// The weight of each segment; 0 for a floor. The segment of larger weight is more likely the stronger light.
pub fn weights(expanded: &WorkingImage, segments: &Segments, places: &[LightPosition]) -> Vec<f64> {
    let width = expanded.size.1;
    let weight = |(pixels, place): (&Vec<u32>, &LightPosition)| {
        // Sum solid angle and expanded flux.
        let (mut solid_angle, mut flux) = (0.0, 0.0);
        for run in runs(pixels, width) {
            let pixel_solid_angle = expanded.bands[run.row] * TAU / width as f64;
            for pixel in run.pixels(width).filter(|&pixel| segments.label[pixel] != 0) {
                solid_angle += pixel_solid_angle;
                flux += f64::from(expanded.luminance[pixel]) * pixel_solid_angle;
            }
        }
        // Weigh them.
        flux / solid_angle.powf(SMALLNESS) * from_above(solid_angle, place.direction.y)
    };
    segments.pixels.iter().zip(places).map(weight).collect()
}

/// Factor of the weight for the `sine` of an elevation: light comes from above, and a floor gives none.
pub fn from_above(solid_angle: f64, sine: f64) -> f64 {
    let is_floor = solid_angle > FLOOR && sine < FLOOR_BELOW;
    if is_floor { 0.0 } else { (UPWARDS * sine).exp() }
}

/// Least weight of a light that is listed; many equal lights all have it.
fn least_weight(weights: &[f64]) -> f64 {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    (LEAST_SHARE * weights.iter().sum::<f64>()).min(largest)
}

/// Segments, positions and weights without those of little weight.
pub fn without_the_least(
    segments: Segments,
    places: Vec<LightPosition>,
    weights: Vec<f64>,
) -> (Segments, Vec<LightPosition>, Vec<f64>) {
    let least = least_weight(&weights);
    let mut kept = Segments { pixels: Vec::new(), peaks: Vec::new(), label: segments.label };
    let (mut kept_places, mut kept_weights) = (Vec::new(), Vec::new());
    let segments = segments.pixels.into_iter().zip(segments.peaks);
    for (((pixels, peak), place), weight) in segments.zip(places).zip(weights) {
        // Give its pixels the label of its new place, or none.
        let label = if weight < least { 0 } else { kept.pixels.len() as u32 + 1 };
        for &pixel in &pixels {
            let own = &mut kept.label[pixel as usize];
            *own = if *own == 0 { 0 } else { label };
        }
        if label != 0 {
            kept.pixels.push(pixels);
            kept.peaks.push(peak);
            kept_places.push(place);
            kept_weights.push(weight);
        }
    }
    (kept, kept_places, kept_weights)
}

/// Join the places and the weights of the `lights` that were joined or merged, of which those are a `part_of`.
pub fn joined(
    lights: &[LightMoments],
    part_of: &[Option<usize>],
    places: &[LightPosition],
    weights: &[f64],
) -> (Vec<LightPosition>, Vec<f64>) {
    let mut joined: Vec<Option<LightPosition>> = vec![None; lights.len()];
    let mut sums = vec![0.0; lights.len()];
    for ((place, weight), light) in places.iter().zip(weights).zip(part_of) {
        let Some(light) = *light else { continue };
        let whole = joined[light].get_or_insert_with(|| place.clone());
        *whole = whole.and(place, lights[light].direction());
        sums[light] += weight;
    }
    (joined.into_iter().flatten().collect(), sums)
}
