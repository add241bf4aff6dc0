//! Gain maps for high dynamic range (ISO 21496-1): a picture of logarithms that raises another picture.

use ndarray::parallel::prelude::*;
use ndarray::{Array3, ArrayView3, ArrayViewMut2, ArrayViewMut3, Axis};

/// A gain map, which is applied at full weight.
///
/// The code `c`, from 0 to 1, is the map's, interpolated to the place of a pixel; `base` is the pixel's linear radiance:
///
/// ```text
/// gain = minimum + (maximum - minimum) c^(1 / gamma)
/// HDR  = (base + base_offset) 2^gain - alternate_offset
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GainMap {
    /// Codes from 0 to 255, (height, width, 1 or 3).
    pub codes: Array3<u8>,
    /// Numbers of the formula.
    pub parameters: Parameters,
}

/// Numbers of a gain map, for red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Logarithm to base 2 of the gain of the code 0.
    pub minimum: [f64; 3],
    /// Logarithm to base 2 of the gain of the code 255.
    pub maximum: [f64; 3],
    /// Exponent of the encoding of codes.
    pub gamma: [f64; 3],
    /// Summand of the base.
    pub base_offset: [f64; 3],
    /// Summand of the result.
    pub alternate_offset: [f64; 3],
}

impl Parameters {
    /// True if all numbers are finite and in a range that a picture can have.
    pub fn are_sound(&self) -> bool {
        /// Most stops of a gain: a sun is 16 stops above white.
        const MOST_STOPS: f64 = 32.0;
        let stops = self.minimum.iter().chain(&self.maximum);
        let offsets = self.base_offset.iter().chain(&self.alternate_offset);
        let is_rising = (0..3).all(|channel| self.minimum[channel] <= self.maximum[channel]);
        is_rising
            && stops.clone().all(|stop| stop.abs() <= MOST_STOPS)
            && self.gamma.iter().all(|gamma| gamma.is_finite() && *gamma > 0.0)
            && offsets.clone().all(|offset| offset.is_finite())
    }
}

/// Raise linear radiance by a gain map, in place: some rows from the row `first` on, of a picture of `height` rows.
///
/// The rows have 1 or 3 channels; a map of one channel raises all of them.
pub fn apply(map: &GainMap, mut base: ArrayViewMut3<'_, f32>, first: usize, height: usize) {
    let (rows, width) = (map.codes.dim().0, base.dim().1);
    let columns: Vec<_> = (0..width).map(|x| Between::new(x, width, map.codes.dim().1)).collect();
    let curves = [0, 1, 2].map(|channel| Curve::new(&map.parameters, channel));
    base.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(y, row)| {
        apply_row(map.codes.view(), &curves, Between::new(first + y, height, rows), &columns, row);
    });
}

fn apply_row(
    codes: ArrayView3<'_, u8>,
    curves: &[Curve; 3],
    row: Between,
    columns: &[Between],
    mut base: ArrayViewMut2<'_, f32>,
) {
    let channels = codes.dim().2;
    let is_grey = channels == 1 && curves[0].has_gain_of(&curves[1]) && curves[0].has_gain_of(&curves[2]);
    for (mut pixel, column) in base.outer_iter_mut().zip(columns) {
        let code = |channel: usize| {
            let at = |y: usize| column.mix(|x| f32::from(codes[[y, x, channel.min(channels - 1)]]));
            row.mix(at) / 255.0
        };
        let common = if is_grey { curves[0].gain(code(0)) } else { 0.0 };
        for (channel, (value, curve)) in pixel.iter_mut().zip(curves).enumerate() {
            let gain = if is_grey { common } else { curve.gain(code(channel)) };
            *value = (*value + curve.base_offset) * gain - curve.alternate_offset;
        }
    }
}

/// Two neighbours in a map, and the weight of the second.
#[derive(Clone, Copy)]
struct Between {
    first: usize,
    second: usize,
    weight: f32,
}

impl Between {
    /// Neighbours of the centre of a pixel, one of `pixels`, in a map of `size`.
    fn new(pixel: usize, pixels: usize, size: usize) -> Self {
        let position = (pixel as f64 + 0.5) * size as f64 / pixels as f64 - 0.5;
        let position = position.clamp(0.0, (size - 1) as f64);
        let first = position.floor() as usize;
        Self { first, second: (first + 1).min(size - 1), weight: (position - first as f64) as f32 }
    }

    fn mix(self, value: impl Fn(usize) -> f32) -> f32 {
        let first = value(self.first);
        first + self.weight * (value(self.second) - first)
    }
}

/// Numbers of one channel.
struct Curve {
    minimum: f32,
    range: f32,
    exponent: f32,
    base_offset: f32,
    alternate_offset: f32,
}

impl Curve {
    fn new(parameters: &Parameters, channel: usize) -> Self {
        Self {
            minimum: parameters.minimum[channel] as f32,
            range: (parameters.maximum[channel] - parameters.minimum[channel]) as f32,
            exponent: parameters.gamma[channel].recip() as f32,
            base_offset: parameters.base_offset[channel] as f32,
            alternate_offset: parameters.alternate_offset[channel] as f32,
        }
    }

    fn has_gain_of(&self, other: &Self) -> bool {
        let numbers = |curve: &Self| [curve.minimum, curve.range, curve.exponent].map(f32::to_bits);
        numbers(self) == numbers(other)
    }

    /// Gain of a code from 0 to 1.
    fn gain(&self, code: f32) -> f32 {
        let is_linear = (self.exponent - 1.0).abs() < f32::EPSILON;
        let code = if is_linear { code } else { code.powf(self.exponent) };
        (self.minimum + self.range * code).exp2()
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use ndarray::s;

    use super::*;

    const PARAMETERS: Parameters = Parameters {
        minimum: [0.0, -1.0, 0.5],
        maximum: [3.0, 2.0, 4.5],
        gamma: [1.0, 2.2, 0.7],
        base_offset: [1.0 / 64.0, 0.0, 0.1],
        alternate_offset: [1.0 / 64.0, 0.2, 0.0],
    };

    /// A map of one code raises all pixels by the formula; its largest value is that of white at 255.
    #[test]
    fn gain_of_one_code_is_the_closed_form() {
        for code in [0, 100, 255] {
            let codes = Array3::from_elem((2, 3, 3), code);
            let map = GainMap { codes, parameters: PARAMETERS };
            let mut rows = Array3::from_elem((5, 7, 3), 1.0_f32);
            apply(&map, rows.view_mut(), 2, 9);
            for channel in 0..3 {
                let part = (f64::from(code) / 255.0).powf(1.0 / PARAMETERS.gamma[channel]);
                let stops = PARAMETERS.minimum[channel]
                    + part * (PARAMETERS.maximum[channel] - PARAMETERS.minimum[channel]);
                let wanted = (1.0 + PARAMETERS.base_offset[channel]) * stops.exp2()
                    - PARAMETERS.alternate_offset[channel];
                for &value in rows.slice(s![.., .., channel]) {
                    assert_relative_eq!(f64::from(value), wanted, max_relative = 1e-5);
                }
            }
        }
    }

    /// Codes that rise evenly give stops that rise evenly, up to half a code from the edges; blocks are rows of the whole.
    #[test]
    fn codes_are_interpolated_between_their_centres() {
        let ramp = Parameters {
            minimum: [0.0; 3],
            maximum: [2.55; 3],
            gamma: [1.0; 3],
            base_offset: [0.0; 3],
            alternate_offset: [0.0; 3],
        };
        let codes = Array3::from_shape_fn((2, 4, 1), |(y, x, _)| (40 * y + 20 * x) as u8);
        let map = GainMap { codes, parameters: ramp };
        let mut whole = Array3::from_elem((8, 16, 1), 1.0_f32);
        apply(&map, whole.view_mut(), 0, 8);
        let stops = whole[[3, 6, 0]].log2();
        assert_relative_eq!(stops, 0.4 * (3.5 / 4.0 - 0.5) + 0.2 * (6.5 / 4.0 - 0.5), max_relative = 1e-5);
        assert_relative_eq!(whole[[0, 0, 0]], 1.0);
        let mut block = Array3::from_elem((3, 16, 1), 1.0_f32);
        apply(&map, block.view_mut(), 4, 8);
        assert_eq!(block, whole.slice(s![4..7, .., ..]));
    }
}
