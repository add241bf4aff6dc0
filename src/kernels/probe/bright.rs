//! Radiance up to which a block may be summed in single precision.
//!
//! A horizon cuts two half blocks in each row, 16 columns of W. Sums in f32 are off by about 1e-7: where no
//! such block is more than W / 4 times as bright as the room, by 4e-7 of the irradiance of the room.
//! Everything brighter is summed in f64, which is slower, but rare.

use glam::Vec4;

use super::rows::Weight;

/// Rows and columns of which pixels are looked at, at most: enough to know the room.
const ROWS: usize = 32;
const COLUMNS: usize = 64;

/// Mean radiance of a block, for each channel, up to which it may be summed in f32.
#[derive(Clone, Copy)]
pub struct Limits(Vec4);

impl Limits {
    /// For a map of `rows`, whose room is the median of what is not black.
    pub fn of(rows: &[&[[f32; 3]]]) -> Self {
        let width = rows[0].len();
        let (row_step, column_step) = (rows.len().div_ceil(ROWS), width.div_ceil(COLUMNS));
        let mut samples = Vec::with_capacity(ROWS * COLUMNS);
        let mut median = |channel: usize| {
            samples.clear();
            let rows = rows.iter().step_by(row_step);
            let seen = rows.flat_map(|row| row.iter().step_by(column_step).map(|pixel| pixel[channel]));
            samples.extend(seen.filter(|&sample| sample > 0.0));
            let middle = samples.len() / 2;
            // Where all is black, whatever shines is bright.
            if samples.is_empty() { 0.0 } else { *samples.select_nth_unstable_by(middle, f32::total_cmp).1 }
        };
        let room = [median(0), median(1), median(2)].map(|median| 0.25 * width as f32 * median);
        Self(Vec4::new(room[0], room[1], room[2], f32::INFINITY))
    }

    /// The sum of `columns` of one block, whose rows have these weights, up to which it is in f32.
    pub fn of_block(self, columns: usize, weights: &[Weight]) -> Vec4 {
        let rows: f64 = weights.iter().map(|weight| weight.equatorial).sum();
        self.0 * (rows * columns as f64) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_is_the_median_of_what_is_not_black() {
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
    fn where_all_is_black_whatever_shines_is_bright() {
        assert_eq!(Limits::of(&[&[[0.0; 3]; 4]]).0.truncate(), glam::Vec3::ZERO);
    }
}
