//! The membrane in the pixels of the map, behind some of its pixels side by side.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

use super::level::{Level, after};
use super::planes::Planes;

/// Some columns of a level in three of its rows, stretched along the rows to smaller pixels, channel by channel.
#[derive(Default)]
pub struct Stretched<const CHANNELS: usize> {
    /// The rows above, behind and below the smaller pixels.
    rows: [Planes<CHANNELS>; 3],
    /// Room for a channel of a row, from the column before the first to the one behind the last.
    room: Vec<f32>,
    /// The first row of smaller pixels, and how many lie along the side of a pixel.
    first: usize,
    factor: usize,
}

impl<const CHANNELS: usize> Stretched<CHANNELS> {
    /// Stretch the last channels of a level by a factor: some of its columns to so many `pixels`, in rows from `first` on.
    #[inline(always)]
    pub fn stretch(
        &mut self,
        level: &Level,
        factor: usize,
        behind: &Range<usize>,
        pixels: usize,
        first: usize,
    ) {
        (self.first, self.factor) = (first, factor);
        let (height, width) = level.size;
        let row = first / factor;
        let rows = [row.saturating_sub(1), row, (row + 1).min(height - 1)];
        for (planes, row) in self.rows.iter_mut().zip(rows) {
            planes.start(pixels);
            let values = &level.values[row * width..(row + 1) * width];
            let before = values[if behind.start > 0 { behind.start - 1 } else { width - 1 }];
            let beyond = values[if behind.end < width { behind.end } else { 0 }];
            for (channel, plane) in planes.channels_mut().into_iter().enumerate() {
                let channel = 4 - CHANNELS + channel;
                self.room.clear();
                self.room.push(before[channel]);
                self.room.extend(values[behind.clone()].iter().map(|value| value[channel]));
                self.room.push(beyond[channel]);
                // The usual factors are known when this is compiled.
                match factor {
                    2 => stretch(&self.room, 2, plane),
                    4 => stretch(&self.room, 4, plane),
                    8 => stretch(&self.room, 8, plane),
                    factor => stretch(&self.room, factor, plane),
                }
            }
        }
    }

    /// A row of the smaller pixels.
    #[inline(always)]
    pub fn row(&self, row: usize, planes: &mut Planes<CHANNELS>) {
        let (below, share) = after(row - self.first, self.factor);
        let [above, below] = [&self.rows[below], &self.rows[below + 1]].map(Planes::values);
        let values = planes.values_mut().iter_mut().zip(above.iter().zip(below));
        values.for_each(|(value, (above, below))| *value = above + share * (below - above));
    }
}

/// Stretch pixels by a factor, but for the first and the last one; what lies behind the last of the others may be cut.
#[inline(always)]
fn stretch(pixels: &[f32], factor: usize, smaller: &mut [f32]) {
    let mut three = pixels.windows(3);
    let mut inside = smaller.chunks_exact_mut(factor);
    for (inside, three) in (&mut inside).zip(&mut three) {
        stretch_pixel(three, factor, inside);
    }
    if let Some(three) = three.next() {
        stretch_pixel(three, factor, inside.into_remainder());
    }
}

/// Fill smaller pixels inside the second of three pixels of a row.
#[inline(always)]
fn stretch_pixel(three: &[f32], factor: usize, inside: &mut [f32]) {
    for (place, pixel) in inside.iter_mut().enumerate() {
        let (right, share) = after(place, factor);
        *pixel = three[right] + share * (three[right + 1] - three[right]);
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::kernels::image::Grid;
    use crate::kernels::sphere::Registration;

    /// Linear in the row and in the column, and another in each channel.
    fn ramp(row: f32, column: f32, channel: usize) -> f32 {
        3.0 * row + 5.0 * column + 100.0 * channel as f32
    }

    #[test]
    fn smaller_pixels_lie_on_the_ramp_between_the_larger_ones() {
        let mut level = Level::new(Grid::of_pixels(8, 16, Registration::CellCentred), Vec::new());
        for (at, value) in level.values.iter_mut().enumerate() {
            *value = [0, 1, 2, 3].map(|channel| ramp((at / 16) as f32, (at % 16) as f32, channel));
        }
        for factor in [1, 2, 3, 4, 5, 8] {
            let (mut stretched, mut planes) = (Stretched::<2>::default(), Planes::<2>::default());
            // The last column is cut, but for its first pixel.
            let pixels = 6 * factor + 1;
            planes.start(pixels);
            stretched.stretch(&level, factor, &(4..11), pixels, 3 * factor);
            // A place in larger pixels.
            let place = |place: usize| (place as f32 + 0.5) / factor as f32 - 0.5;
            for row in 3 * factor..4 * factor {
                stretched.row(row, &mut planes);
                for (channel, plane) in planes.channels().into_iter().enumerate() {
                    for (column, &value) in plane.iter().enumerate() {
                        let wanted = ramp(place(row), place(4 * factor + column), channel + 2);
                        assert_relative_eq!(value, wanted, max_relative = 1e-5);
                    }
                }
            }
        }
    }

    #[test]
    fn beside_the_seam_lies_the_other_end_of_the_row() {
        let mut level = Level::new(Grid::of_pixels(8, 16, Registration::CellCentred), Vec::new());
        level.values[..16].fill([1.0; 4]);
        level.values[15] = [9.0; 4];
        let (mut stretched, mut planes) = (Stretched::<1>::default(), Planes::<1>::default());
        planes.start(2);
        stretched.stretch(&level, 2, &(0..1), 2, 0);
        stretched.row(0, &mut planes);
        assert_eq!(planes.values(), [3.0, 1.0]);
    }
}
