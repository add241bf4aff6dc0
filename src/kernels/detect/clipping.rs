//! Clipped lights: lights that a camera or a file format has cut off.
//!
//! If the largest value that a map can hold is known, a light is clipped if one of its samples reaches it. Otherwise a
//! light is clipped if several of its pixels hold the map's largest sample, a flat top. In an evenly lit window, only one
//! pixel is the brightest. A rendered lamp of uniform radiance has a flat top of one colour, while the channels of a
//! clipped light reach the ceiling in different pixels; so a top of one colour counts only at a usual ceiling.

use crate::kernels::image::LEAST_WHITE;

/// A top of this many pixels or more is flat.
const FLAT_TOP_PIXELS: usize = 4;

/// Largest samples of formats and programs: of pictures, bytes, some renderers, Blender, squared bytes and half floats.
const USUAL_CEILINGS: [f32; 6] = [1.0, 255.0, 4096.0, 32000.0, 65025.0, 65504.0];

/// Largest sample that a map holds or can hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ceiling {
    /// Known largest value that the map can hold.
    White(f32),
    /// Largest sample of the map.
    Maximum(f32),
}

/// The largest sample of some pixels, and the number of pixels that hold it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Top {
    /// The largest of red, green and blue.
    pub sample: f32,
    /// Number of pixels that hold it, up to that of a flat top.
    pixels: usize,
    /// Colour of one of them, as bits.
    colour: [u32; 3],
    /// True if they differ in colour.
    is_coloured: bool,
}

impl Top {
    /// The top of some pixels.
    pub fn of(pixels: &[[f32; 3]]) -> Self {
        Self::default().and_of(pixels)
    }

    /// The top of these pixels and some more.
    #[must_use]
    pub fn and_of(self, pixels: &[[f32; 3]]) -> Self {
        let sample = largest(pixels.as_flattened());
        if sample < self.sample {
            return self;
        }
        let is_top = |pixel: &&[f32; 3]| pixel[0] >= sample || pixel[1] >= sample || pixel[2] >= sample;
        let tops = || pixels.iter().filter(is_top);
        let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
        let colour = tops().next().map(bits).unwrap_or_default();
        let is_coloured = tops().any(|pixel| bits(pixel) != colour);
        let count = tops().take(FLAT_TOP_PIXELS).count();
        self.and(Self { sample, pixels: count, colour, is_coloured })
    }

    /// The top of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let (higher, lower) = if self.sample >= other.sample { (self, other) } else { (other, self) };
        if lower.sample < higher.sample || lower.pixels == 0 {
            return higher;
        }
        let is_coloured = higher.is_coloured || lower.is_coloured || higher.colour != lower.colour;
        Self { pixels: higher.pixels + lower.pixels, is_coloured, ..higher }
    }

    /// True if the samples are cut off at this ceiling.
    pub fn is_clipped(self, ceiling: Ceiling) -> bool {
        match ceiling {
            Ceiling::White(clip_level) => f64::from(self.sample) >= LEAST_WHITE * f64::from(clip_level),
            Ceiling::Maximum(maximum) => {
                let is_flat = self.sample >= maximum && self.pixels >= FLAT_TOP_PIXELS;
                is_flat && (self.is_coloured || USUAL_CEILINGS.contains(&self.sample))
            }
        }
    }
}

/// The largest of some samples or levels, in lanes that do not wait for one another; 0 of none.
pub fn largest(samples: &[f32]) -> f32 {
    let higher = |a: f32, b: f32| if b > a { b } else { a };
    let (most, rest) = samples.as_chunks::<16>();
    let mut lanes = [0.0; 16];
    for samples in most {
        lanes.iter_mut().zip(samples).for_each(|(lane, &sample)| *lane = higher(*lane, sample));
    }
    lanes.iter().chain(rest).copied().fold(0.0, higher)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn top(samples: &[f32]) -> Top {
        let pixels: Vec<[f32; 3]> = samples.iter().map(|&sample| [0.1, sample, 0.2]).collect();
        Top::of(&pixels)
    }

    #[test]
    fn four_pixels_at_the_maximum_are_a_flat_top() {
        let ceiling = Ceiling::Maximum(4096.0);
        assert!(top(&[4096.0, 3.0, 4096.0, 4096.0, 4096.0]).is_clipped(ceiling));
        assert!(!top(&[4096.0, 4096.0, 4096.0]).is_clipped(ceiling));
        assert!(!top(&[4000.0; 9]).is_clipped(ceiling), "the map is brighter elsewhere");
    }

    #[test]
    fn a_top_of_one_colour_is_a_lamp_unless_it_lies_at_a_usual_ceiling() {
        assert!(!top(&[50.0; 9]).is_clipped(Ceiling::Maximum(50.0)));
        assert!(top(&[1.0; 9]).is_clipped(Ceiling::Maximum(1.0)));
        let coloured: Vec<[f32; 3]> = (0..9).map(|i| [50.0, 40.0 + i as f32, 9.0]).collect();
        assert!(Top::of(&coloured).is_clipped(Ceiling::Maximum(50.0)));
        let by_parts = Top::of(&coloured[..3]).and_of(&coloured[3..]);
        assert!(by_parts.is_clipped(Ceiling::Maximum(50.0)));
    }

    #[test]
    fn an_evenly_lit_window_is_not_clipped() {
        let window: Vec<f32> = (0..100).map(|i| 9.0 + 1e-3 * i as f32).collect();
        assert!(!top(&window).is_clipped(Ceiling::Maximum(window[99])));
    }

    #[test]
    fn one_sample_at_a_known_white_is_clipped() {
        assert!(top(&[0.2, 0.99]).is_clipped(Ceiling::White(1.0)));
        assert!(!top(&[0.2, 0.98]).is_clipped(Ceiling::White(1.0)));
    }
}
