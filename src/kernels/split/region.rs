//! The pixels that a light fills: those in which it was found, its rim, its glare and its glow.
//!
//! Detection keeps of a light what is brighter than a tenth of its peak. Around a sun of 10^5 times the sky,
//! that leaves a glare in the map that is brighter than most lamps. So rings of one pixel are added around each
//! light as long as their median luminance falls from ring to ring as that of glare does, and faster than that
//! of a lit wall or of the sky. What is around the last ring closes the hole; what is still bright there is the light's
//! glow, which is closed as well if it is a thing of its own.

use std::f64::consts::PI;

use super::glow::{self, Bright, NONE};
use super::working::Working;
use crate::interrupt;
use crate::kernels::image::luminance_f32;

/// Rings that every light has: the pixels on its rim are partly its own, and so are those into which a lens or
/// a reduction has blurred it.
const LEAST_RINGS: usize = 2;
/// Angle from a light to its last ring, at most, in radians: 15 degrees.
const FARTHEST: f64 = PI / 12.0;
/// Rings from one to the one that it is compared with.
const STRIDE: usize = 2;
/// The rings end where one is less than so many times as bright as the one `STRIDE` further out: a ring that is
/// brighter than the threshold of detection, and one that is not. Glare of suns falls by 1.1 to 3, skies and
/// lit ceilings by less than 1.1.
const FALLS: [f32; 2] = [1.1, 1.25];

/// The pixels of the working image of which something is taken.
pub struct Regions {
    /// Flat indices of the pixels of each light that are closed, in ascending order.
    pub holes: Vec<Vec<u32>>,
    /// Those of its glow, unless it is closed with the light.
    pub glow: Vec<Vec<u32>>,
    /// All pixels that are closed, in ascending order.
    pub all_holes: Vec<usize>,
    /// The light of each pixel, counted from 1.
    light_of: Vec<u32>,
    bright: Bright,
}

/// The pixels of the first `taken` lights of `members`: flat indices, each with its light. The others stay.
pub fn regions(working: &Working<'_>, members: &[(usize, usize)], taken: usize, bright: Bright) -> Regions {
    let lights = members.iter().map(|&(_, light)| light + 1).max().unwrap_or(0);
    let mut light_of = light_of_each(working, members);
    add_rings(working, members, &mut light_of, Rings::new(lights, bright.threshold), taken);
    let mut is_closed: Vec<bool> = light_of.iter().map(|&light| light != NONE).collect();
    for glow in glow::glows(working, &mut light_of, lights, bright.threshold) {
        // A glow that is a thing of its own is closed with its light.
        if glow.is_a_thing() {
            glow.pixels.iter().for_each(|&pixel| is_closed[pixel as usize] = true);
        }
    }
    Regions::new(light_of, &is_closed, taken, bright)
}

/// The light of each pixel, counted from 1; of several, the last one.
fn light_of_each(working: &Working<'_>, members: &[(usize, usize)]) -> Vec<u32> {
    let mut light_of = vec![NONE; working.size.0 * working.size.1];
    for &(index, light) in members {
        light_of[index] = light as u32 + 1;
    }
    light_of
}

/// Grow rings around all lights, and give each that is taken those up to its last one.
fn add_rings(
    working: &Working<'_>,
    members: &[(usize, usize)],
    light_of: &mut [u32],
    mut rings: Rings,
    taken: usize,
) {
    for RingPixel { pixel, light, number } in grown(working, members, light_of, &mut rings) {
        if (light as usize) < taken && number < rings.widths[light as usize] {
            light_of[pixel as usize] = light + 1;
        }
    }
}

impl Regions {
    /// The pixels of the first `taken` lights, each with its light in `light_of`, in the order in which they lie.
    fn new(light_of: Vec<u32>, is_closed: &[bool], taken: usize, bright: Bright) -> Self {
        let (mut holes, mut glow, mut all_holes) =
            (vec![Vec::new(); taken], vec![Vec::new(); taken], Vec::new());
        for (pixel, (&light, &is_closed)) in light_of.iter().zip(is_closed).enumerate() {
            if light == NONE || light as usize > taken {
                continue;
            }
            if is_closed {
                holes[light as usize - 1].push(pixel as u32);
                all_holes.push(pixel);
            } else {
                glow[light as usize - 1].push(pixel as u32);
            }
        }
        Self { holes, glow, all_holes, light_of, bright }
    }

    /// Mean radiance of a pixel that is not closed, after what is taken of a glow.
    pub fn mean_left(&self, working: &Working<'_>, pixel: usize) -> [f32; 3] {
        let mean = working.mean(working.place(pixel));
        let is_glow = (1..=self.glow.len()).contains(&(self.light_of[pixel] as usize));
        let share = if is_glow { self.bright.share_left(luminance_f32(mean)) } else { 1.0 };
        mean.map(|value| share * value)
    }
}

/// A pixel around a light.
struct RingPixel {
    pixel: u32,
    light: u32,
    /// Number of its ring, from 0.
    number: usize,
}

/// The rings around each light, as they grow.
struct Rings {
    threshold: f32,
    /// Luminance of the pixels of the ring that grows.
    growing: Vec<Vec<f32>>,
    /// Median luminance of the rings before it.
    medians: Vec<Vec<f32>>,
    /// How many rings belong to each light; all, as long as it grows.
    widths: Vec<usize>,
}

impl Rings {
    fn new(lights: usize, threshold: f32) -> Self {
        let (growing, medians) = (vec![Vec::new(); lights], vec![Vec::new(); lights]);
        Self { threshold, growing, medians, widths: vec![usize::MAX; lights] }
    }

    fn grows(&self, light: u32) -> bool {
        self.widths[light as usize] == usize::MAX
    }

    /// Close the ring that grows, and end each light at the first ring from which luminance falls no more.
    fn close(&mut self) {
        for (light, values) in self.growing.iter_mut().enumerate() {
            let medians = &mut self.medians[light];
            medians.push(median(values));
            values.clear();
            let Some(ring) = medians.len().checked_sub(1 + STRIDE) else { continue };
            let (inner, outer) = (medians[ring], medians[ring + STRIDE]);
            let fall = FALLS[usize::from(inner <= self.threshold)];
            let has_ended = self.widths[light] != usize::MAX;
            if !has_ended && ring >= LEAST_RINGS && (inner <= fall * outer || inner <= 0.0) {
                self.widths[light] = ring;
            }
        }
    }
}

/// The pixels around all lights, ring by ring, each with the light that is nearest on the sphere.
fn grown(
    working: &Working<'_>,
    members: &[(usize, usize)],
    light_of: &[u32],
    rings: &mut Rings,
) -> Vec<RingPixel> {
    let mut front = Front::new(working, members);
    for &(pixel, _) in members {
        if !working.is_inside(pixel, |other| front.reached[other].source == DONE) {
            front.visit_around(pixel, pixel, 0);
        }
    }
    let mut grown = Vec::new();
    for ring in 0..front.rings.len() {
        interrupt::check();
        if ring > 0 {
            rings.close();
        }
        // Let each pixel be reached from the pixel of a light that is nearest.
        let (mut found, mut next) = (Vec::new(), 0);
        while let Some(&(pixel, source)) = front.rings[ring].get(next) {
            next += 1;
            let is_nearest = front.reached[pixel as usize].source == source + 1;
            if is_nearest && rings.grows(light_of[source as usize] - 1) {
                found.push(pixel);
                front.visit_around(pixel as usize, source as usize, ring);
            }
        }
        for pixel in found {
            let Reached { source, square } = front.reached[pixel as usize];
            if source != DONE {
                let light = light_of[source as usize - 1] - 1;
                grown.push(RingPixel { pixel, light, number: front.ring_of(square) });
                rings.growing[light as usize].push(working.luminance(working.place(pixel as usize)));
                front.reached[pixel as usize].source = DONE;
            }
        }
    }
    grown
}

/// What is known of a pixel around a light.
#[derive(Clone, Copy)]
struct Reached {
    /// The pixel of a light that is nearest so far, counted from 1.
    source: u32,
    /// Square of its distance.
    square: f32,
}

/// In place of a source: the pixel is in a light, or in a ring.
const DONE: u32 = u32::MAX;

/// The pixels that the rings have reached.
struct Front<'a> {
    working: &'a Working<'a>,
    reached: Vec<Reached>,
    /// Steps to the pixels of each ring: the pixel, and the pixel of a light from which it was reached.
    rings: Vec<Vec<(u32, u32)>>,
    /// Height of a row, and the square of the largest distance.
    height: f64,
    farthest: f64,
}

impl<'a> Front<'a> {
    fn new(working: &'a Working<'a>, members: &[(usize, usize)]) -> Self {
        let height = PI / working.size.0 as f64;
        let farthest = FARTHEST.max((LEAST_RINGS + STRIDE) as f64 * height);
        let mut reached = vec![Reached { source: NONE, square: 0.0 }; working.size.0 * working.size.1];
        for &(pixel, _) in members {
            reached[pixel].source = DONE;
        }
        let mut front = Self { working, reached, rings: Vec::new(), height, farthest: farthest * farthest };
        front.rings.resize(front.ring_of(front.farthest as f32) + 1, Vec::new());
        front
    }

    /// The ring of pixels at a distance from a light of which this is the square.
    fn ring_of(&self, square: f32) -> usize {
        (f64::from(square).sqrt() / self.height - 0.5).max(0.0) as usize
    }

    /// Step from a pixel, while this ring grows, to those around it that know of no light's pixel nearer than `source`.
    fn visit_around(&mut self, pixel: usize, source: usize, ring: usize) {
        let counted = source as u32 + 1;
        let middle = self.working.centre(self.working.place(source));
        for other in self.working.around(self.working.place(pixel)) {
            let known = self.reached[other.index];
            if known.source == DONE || known.source == counted {
                continue;
            }
            let square = self.working.centre(other).distance_squared(middle);
            let is_nearer = known.source == NONE || (square as f32) < known.square;
            if square < self.farthest && is_nearer {
                self.reached[other.index] = Reached { source: counted, square: square as f32 };
                let number = self.ring_of(square as f32);
                self.rings[number.max(ring)].push((other.index as u32, source as u32));
            }
        }
    }
}

/// The median, 0 of no values: a light without room for a ring ends before it.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
