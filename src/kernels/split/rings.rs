//! Rings of glare around lights.
//!
//! Detection assigns to a light the pixels above a tenth of its peak. Around a sun of 10^5 times the sky, the remaining
//! glare is brighter than most lamps. So each light gets rings of one pixel as long as their median luminance falls from
//! ring to ring faster than that of a lit wall or of the sky.

use std::f64::consts::PI;

use super::coarse_map::CoarseMap;
use super::light_pixels::NO_LIGHT;
use crate::interrupt;

/// Settings of the rings.
struct RingSettings {
    /// Rings of every light. Its rim belongs partly to the light, and a lens or a reduction has blurred light into it.
    least: usize,
    /// Largest angle from a light to its last ring, in radians.
    farthest: f64,
    /// Distance between rings that are compared, in rings.
    stride: usize,
    /// Least ratios of the medians of compared rings, above and below the detection threshold. Glare of suns falls by
    /// 1.1 to 3, skies and lit ceilings by less than 1.1.
    least_falls: [f32; 2],
}

const RINGS: RingSettings =
    RingSettings { least: 2, farthest: PI / 12.0, stride: 2, least_falls: [1.1, 1.25] };

/// Ring pixels around all lights, each with its light as in `light_of`: counted from 1.
pub fn ring_pixels(
    map: &CoarseMap<'_>,
    members: &[(usize, usize)],
    light_of: &[u32],
    threshold: f32,
) -> Vec<(usize, u32)> {
    let lights = members.iter().map(|&(_, light)| light + 1).max().unwrap_or(0);
    let mut profiles = vec![RingProfile::default(); lights];
    let mut front = Front::new(map, members);
    let mut pixels: Vec<(usize, u32, usize)> = Vec::new();
    for ring in 0..front.rings.len() {
        interrupt::check();
        if ring > 0 {
            for profile in &mut profiles {
                profile.close_ring(threshold);
            }
        }
        let grows = |source: usize| profiles[light_of[source] as usize - 1].width.is_none();
        for (pixel, source, number) in front.grow(ring, grows) {
            let light = light_of[source];
            pixels.push((pixel, light, number));
            if map.is_known(pixel) {
                profiles[light as usize - 1].growing.push(map.luminance(pixel));
            }
        }
    }
    let is_in_width = |&(_, light, number): &(usize, u32, usize)| {
        profiles[light as usize - 1].width.is_none_or(|width| number < width)
    };
    pixels.into_iter().filter(is_in_width).map(|(pixel, light, _)| (pixel, light)).collect()
}

/// Luminance of the rings of one light, from the inside out.
#[derive(Clone, Default)]
struct RingProfile {
    /// Luminance of the pixels of the growing ring.
    growing: Vec<f32>,
    /// Median luminance of the closed rings.
    medians: Vec<f32>,
    /// Number of rings; none while they grow.
    width: Option<usize>,
}

impl RingProfile {
    /// Close the growing ring, and end the light at the first ring after which luminance no longer falls.
    fn close_ring(&mut self, threshold: f32) {
        self.medians.push(median(&mut self.growing));
        self.growing.clear();
        let Some(ring) = self.medians.len().checked_sub(1 + RINGS.stride) else { return };
        let (inner, outer) = (self.medians[ring], self.medians[ring + RINGS.stride]);
        let fall = RINGS.least_falls[usize::from(inner <= threshold)];
        if self.width.is_none() && ring >= RINGS.least && (inner <= fall * outer || inner <= 0.0) {
            self.width = Some(ring);
        }
    }
}

/// Member of a light from which a pixel was reached, and the square of its distance.
#[derive(Clone, Copy)]
struct Step {
    /// Counted from 1; [`UNREACHED`] or [`DONE`].
    source: u32,
    square: f32,
}

const UNREACHED: u32 = NO_LIGHT;
/// Source of pixels in a light or in a finished ring.
const DONE: u32 = u32::MAX;

/// Pixels that the rings have reached, each from the nearest member of a light.
struct Front<'a> {
    map: &'a CoarseMap<'a>,
    reached: Vec<Step>,
    /// Steps to the pixels of each ring: the pixel, and the member from which it was reached.
    rings: Vec<Vec<(u32, u32)>>,
    /// Height of a row in radians, and the square of the largest distance.
    height: f64,
    farthest: f64,
}

impl<'a> Front<'a> {
    fn new(map: &'a CoarseMap<'a>, members: &[(usize, usize)]) -> Self {
        let height = PI / map.size.0 as f64;
        let farthest = RINGS.farthest.max((RINGS.least + RINGS.stride) as f64 * height);
        let mut reached = vec![Step { source: UNREACHED, square: 0.0 }; map.size.0 * map.size.1];
        for &(pixel, _) in members {
            reached[pixel].source = DONE;
        }
        let mut front = Self { map, reached, rings: Vec::new(), height, farthest: farthest * farthest };
        front.rings.resize(front.ring_of(front.farthest as f32) + 1, Vec::new());
        for &(pixel, _) in members {
            if !map.is_interior(pixel, |other| front.reached[other].source == DONE) {
                front.visit_neighbours(pixel, pixel, 0);
            }
        }
        front
    }

    /// Number of the ring at a distance with this square.
    fn ring_of(&self, square: f32) -> usize {
        (f64::from(square).sqrt() / self.height - 0.5).max(0.0) as usize
    }

    /// Finish a ring around the members that still grow: its pixels, their members, and the rings of their distances.
    fn grow(&mut self, ring: usize, grows: impl Fn(usize) -> bool) -> Vec<(usize, usize, usize)> {
        let (mut visited, mut next) = (Vec::new(), 0);
        while let Some(&(pixel, source)) = self.rings[ring].get(next) {
            next += 1;
            if self.reached[pixel as usize].source == source + 1 && grows(source as usize) {
                visited.push(pixel as usize);
                self.visit_neighbours(pixel as usize, source as usize, ring);
            }
        }
        let mut pixels = Vec::with_capacity(visited.len());
        for pixel in visited {
            let Step { source, square } = self.reached[pixel];
            if source != DONE {
                self.reached[pixel].source = DONE;
                pixels.push((pixel, source as usize - 1, self.ring_of(square)));
            }
        }
        pixels
    }

    /// Step from a pixel to the neighbours that have no member nearer than `source`.
    fn visit_neighbours(&mut self, pixel: usize, source: usize, ring: usize) {
        let counted = source as u32 + 1;
        let middle = self.map.centre(source);
        for other in self.map.neighbours(pixel) {
            let known = self.reached[other];
            if known.source == DONE || known.source == counted {
                continue;
            }
            let square = self.map.centre(other).distance_squared(middle);
            let is_nearer = known.source == UNREACHED || (square as f32) < known.square;
            if square < self.farthest && is_nearer {
                self.reached[other] = Step { source: counted, square: square as f32 };
                let number = self.ring_of(square as f32);
                self.rings[number.max(ring)].push((other as u32, source as u32));
            }
        }
    }
}

/// The median; 0 without values, so that a light without room for a ring ends before it.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
