//! Order of the lights of a clipped map, and the lights that are dropped.
//!
//! Clipping makes all lights equal, so their flux says little about which one is the strongest. A small clipped light is
//! more often a lamp, a large one a wall; and light comes from above. With the expanded flux F', the
//! solid angle W and the elevation e, the weight
//!
//! ```text
//!   weight = F' / W^(3/4) exp(1.5 sin e)
//! ```
//!
//! lies between the flux and the mean radiance. The powers are chosen on pictures of HDR maps: by the lights that are
//! found, and by the flux in wrong lights.

use std::f64::consts::TAU;

use super::super::segment::components::Segments;
use super::super::segment::light_moments::LightMoments;
use super::super::segment::run::runs;
use super::super::segment::working_image::WorkingImage;
use super::position::LightPosition;

/// Settings of the weights, chosen on pictures of HDR maps.
struct WeightSettings {
    /// The power of the solid angle.
    smallness: f64,
    /// Logarithm of the weight of a light at the zenith over that of one on the horizon.
    upwards: f64,
    /// Lights with a smaller fraction of the sum of all weights are left out.
    least_fraction: f64,
    /// A clipped region of more steradians, below the horizon, is a floor.
    floor: f64,
    /// Sine of the elevation below which a floor may lie.
    floor_below: f64,
}

const WEIGHTS: WeightSettings =
    WeightSettings { smallness: 0.75, upwards: 1.5, least_fraction: 0.01, floor: 0.5, floor_below: -0.3 };

/// The weight of each segment; 0 for a floor. A larger weight means that the light is more likely the strongest.
pub fn weights(expanded: &WorkingImage, segments: &Segments, positions: &[LightPosition]) -> Vec<f64> {
    let width = expanded.size.1;
    let weight = |(pixels, position): (&Vec<u32>, &LightPosition)| {
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
        flux / solid_angle.powf(WEIGHTS.smallness) * from_above(solid_angle, position.direction.y)
    };
    segments.pixels.iter().zip(positions).map(weight).collect()
}

/// Factor of the weight for the `sine` of an elevation: light comes from above, and a floor emits none.
pub fn from_above(solid_angle: f64, sine: f64) -> f64 {
    let is_floor = solid_angle > WEIGHTS.floor && sine < WEIGHTS.floor_below;
    if is_floor { 0.0 } else { (WEIGHTS.upwards * sine).exp() }
}

/// Least weight of a light that is listed; many equal lights all have it.
fn least_weight(weights: &[f64]) -> f64 {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    (WEIGHTS.least_fraction * weights.iter().sum::<f64>()).min(largest)
}

/// Drop segments of little weight, with their positions.
pub fn drop_least(
    segments: Segments,
    positions: Vec<LightPosition>,
    weights: Vec<f64>,
) -> (Segments, Vec<LightPosition>, Vec<f64>) {
    let least = least_weight(&weights);
    let mut listed = Segments::empty(segments.label);
    let (mut listed_positions, mut listed_weights) = (Vec::new(), Vec::new());
    let segments = segments.pixels.into_iter().zip(segments.peaks);
    for (((pixels, peak), position), weight) in segments.zip(positions).zip(weights) {
        if weight < least {
            listed.relabel(&pixels, 0);
        } else {
            listed.push(pixels, peak);
            listed_positions.push(position);
            listed_weights.push(weight);
        }
    }
    (listed, listed_positions, listed_weights)
}

/// Join the positions and add the weights of segments; `part_of` holds the light of each segment.
pub fn join(
    lights: &[LightMoments],
    part_of: &[Option<usize>],
    positions: &[LightPosition],
    weights: &[f64],
) -> (Vec<LightPosition>, Vec<f64>) {
    let mut joined: Vec<Option<LightPosition>> = vec![None; lights.len()];
    let mut sums = vec![0.0; lights.len()];
    for ((position, weight), light) in positions.iter().zip(weights).zip(part_of) {
        let Some(light) = *light else { continue };
        let whole = joined[light].get_or_insert_with(|| position.clone());
        *whole = whole.and(position, lights[light].direction());
        sums[light] += weight;
    }
    (joined.into_iter().flatten().collect(), sums)
}
