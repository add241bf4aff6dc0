//! Radiance up to which a block may be summed in single precision.
//!
//! A horizon cuts two half blocks in each row, 16 columns of W. Sums in f32 are off by about 1e-7: where no
//! such block is more than W / 4 times as bright as the room, by 4e-7 of the irradiance of the room.
//! Everything brighter is summed in f64, which is slower, but rare.

use glam::Vec4;

use super::rows::Weight;

/// Rows and columns of the pixels that determine the room.
const SAMPLED: (usize, usize) = (32, 64);

/// Mean radiance of a block, for each channel, up to which it may be summed in f32.
#[derive(Clone, Copy)]
pub struct Limits(Vec4);

impl Limits {
    /// Limits for a map of `rows`; its room is the median of the pixels that are not black.
    pub fn of(rows: &[&[[f32; 3]]]) -> Self {
        let width = rows[0].len();
        let (row_step, column_step) = (rows.len().div_ceil(SAMPLED.0), width.div_ceil(SAMPLED.1));
        let mut samples = Vec::with_capacity(SAMPLED.0 * SAMPLED.1);
        let mut median = |channel: usize| {
            samples.clear();
            let rows = rows.iter().step_by(row_step);
            let sampled = rows.flat_map(|row| row.iter().step_by(column_step).map(|pixel| pixel[channel]));
            samples.extend(sampled.filter(|&sample| sample > 0.0));
            let middle = samples.len() / 2;
            // In a black map, every light is bright.
            if samples.is_empty() { 0.0 } else { *samples.select_nth_unstable_by(middle, f32::total_cmp).1 }
        };
        let room = [median(0), median(1), median(2)].map(|median| 0.25 * width as f32 * median);
        Self(Vec4::new(room[0], room[1], room[2], f32::INFINITY))
    }

    /// Largest sum of `columns` of one block, with these weights of its rows, that may be in f32.
    pub fn of_block(self, columns: usize, weights: &[Weight]) -> Vec4 {
        let rows: f64 = weights.iter().map(|weight| weight.equatorial).sum();
        self.0 * (rows * columns as f64) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_is_the_median_of_the_pixels_that_are_not_black() {
        let mut row = vec![[0.0, 1.0, 3.0]; 16];
        row[3] = [1e9, 1e9, 1e9];
        row[4] = [2.0, 0.0, 3.0];
        row[5] = [2.0, 0.0, 3.0];
        let limits = Limits::of(&[&row, &row]);
        assert_eq!(limits.0, Vec4::new(8.0, 4.0, 12.0, f32::INFINITY));
        let weights = [Weight { equatorial: 0.5, polar: -1.0 }; 2];
        assert_eq!(limits.of_block(4, &weights).truncate(), glam::Vec3::new(32.0, 16.0, 48.0));
    }

    #[test]
    fn every_light_is_bright_in_a_black_map() {
        assert_eq!(Limits::of(&[&[[0.0; 3]; 4]]).0.truncate(), glam::Vec3::ZERO);
    }
}
