//! Adjacency: neighbours on the sphere of the pixels of an equirectangular image.

use std::iter::once;
use std::ops::Range;

use super::run::Run;
use super::working_image::WorkingImage;

/// Neighbours of each pixel: eight, across the seam too.
///
/// At a pole all pixels of the row touch. Each is a neighbour of the brightest one of its row, the pole's *hub*, and
/// through it connected to the others.
pub struct Adjacency {
    height: usize,
    width: usize,
    /// `2^48 / width`, rounded up.
    per_width: u64,
    hubs: [usize; 2],
}

impl Adjacency {
    /// Neighbours in this image.
    pub fn of(working: &WorkingImage) -> Self {
        let (height, width) = working.size;
        let luminance = &working.luminance;
        let brightest = |row: usize| {
            let pixels = row * width..(row + 1) * width;
            pixels.reduce(|a, b| if luminance[b] > luminance[a] { b } else { a }).unwrap_or(0)
        };
        let per_width = (1 << 48) / width as u64 + 1;
        Self { height, width, per_width, hubs: [brightest(0), brightest(height - 1)] }
    }

    /// Row and column of a flat index, by a multiplication; exact for `height * width^2 < 2^48`.
    ///
    /// A division would need a fifth of the time of [`Self::around`].
    fn row_and_column(&self, index: usize) -> (usize, usize) {
        let row = ((index as u64 * self.per_width) >> 48) as usize;
        (row, index - row * self.width)
    }

    /// Columns of the image.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The pixels of a run.
    pub fn pixels(&self, run: &Run) -> Range<usize> {
        run.pixels(self.width)
    }

    /// The neighbours of a pixel; the pixel itself for a missing one.
    pub fn around(&self, index: usize) -> [usize; 9] {
        let (row, column) = self.row_and_column(index);
        let hub = self.hub(index, row);
        let [left, here, right] = self.columns(column);
        let (up, row, down) = self.rows(row);
        [
            up + left,
            up + here,
            up + right,
            row + left,
            row + right,
            down + left,
            down + here,
            down + right,
            hub,
        ]
    }

    /// For each pixel of a `run`, the joined values of the pixel and its neighbours; `columns` is scratch memory.
    pub fn around_each<'a, T: Copy>(
        &self,
        run: &Run,
        columns: &'a mut Vec<T>,
        value: impl Fn(usize) -> T,
        join: impl Fn(T, T) -> T + 'a,
    ) -> impl Iterator<Item = T> + 'a {
        // Join the three pixels of each column.
        let (up, row, down) = self.rows(run.row);
        let [left, ..] = self.columns(run.columns.start);
        let [.., right] = self.columns(run.columns.end - 1);
        let in_column = |column| join(value(row + column), join(value(up + column), value(down + column)));
        columns.clear();
        columns.extend(once(left).chain(run.columns.clone()).chain(once(right)).map(in_column));
        // Join the columns three by three, and at a pole the hub.
        let hub = (up == row || down == row).then(|| value(self.hub(row, run.row)));
        columns.windows(3).map(move |three| {
            let joined = join(three[1], join(three[0], three[2]));
            hub.map_or(joined, |hub| join(joined, hub))
        })
    }

    /// The pixels to the left, to the right, above and below; the pixel itself beyond the first and last row.
    pub fn sides(&self, index: usize) -> [usize; 4] {
        let (row, column) = self.row_and_column(index);
        let [left, here, right] = self.columns(column);
        let (up, row, down) = self.rows(row);
        [row + left, row + right, up + here, down + here]
    }

    /// The pixels `columns` to the left and right, `rows` above and below; at a pole the one in the last row.
    pub fn beyond(&self, index: usize, rows: usize, columns: usize) -> [usize; 4] {
        let (row, column) = self.row_and_column(index);
        let at = |row: usize, column: usize| row * self.width + column % self.width;
        let (up, down) = (row.saturating_sub(rows), (row + rows).min(self.height - 1));
        [at(row, column + self.width - columns), at(row, column + columns), at(up, column), at(down, column)]
    }

    fn hub(&self, index: usize, row: usize) -> usize {
        match row {
            0 => self.hubs[0],
            row if row + 1 == self.height => self.hubs[1],
            _ => index,
        }
    }

    fn columns(&self, column: usize) -> [usize; 3] {
        let left = if column == 0 { self.width - 1 } else { column - 1 };
        let right = if column + 1 == self.width { 0 } else { column + 1 };
        [left, column, right]
    }

    /// First pixels of the row above, its own row and the one below.
    fn rows(&self, row: usize) -> (usize, usize, usize) {
        let first = row * self.width;
        let last = (self.height - 1) * self.width;
        (first.saturating_sub(self.width), first, (first + self.width).min(last))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::working_image::WorkingImage;
    use super::*;
    use crate::kernels::sphere::Registration;
    use ndarray::Array3;
    use proptest::prelude::*;

    fn adjacency() -> Adjacency {
        let map = Array3::from_shape_fn((8, 16, 3), |(y, x, _)| ((y * 5 + x * 3) % 7) as f32);
        Adjacency::of(&WorkingImage::of(map.view(), Registration::CellCentred, 16).unwrap())
    }

    proptest! {
        #[test]
        fn adjacency_is_mutual_except_at_the_poles(row in 1_usize..7, column in 0_usize..16) {
            let (adjacency, pixel) = (adjacency(), row * 16 + column);
            for other in adjacency.around(pixel).into_iter().filter(|other| (16..112).contains(other)) {
                prop_assert!(adjacency.around(other).contains(&pixel), "{pixel} {other}");
            }
        }
    }

    /// Columns are a circle, and rows end at the poles.
    #[test]
    fn beyond_a_pixel_are_those_of_its_row_and_column() {
        let adjacency = adjacency();
        for (row, column) in (0..8).flat_map(|row| (0..16).map(move |column| (row, column))) {
            let expected = [
                (row, (column + 11) % 16),
                (row, (column + 5) % 16),
                (row.max(3) - 3, column),
                (row.min(4) + 3, column),
            ];
            let beyond = adjacency.beyond(row * 16 + column, 3, 5);
            assert_eq!(beyond.map(|pixel| (pixel / 16, pixel % 16)), expected);
        }
    }

    proptest! {
        #[test]
        fn around_each_joins_a_pixel_and_its_neighbours(row in 0_usize..8, start in 0_usize..16, length in 1_usize..=16) {
            let adjacency = adjacency();
            let run = Run { row, columns: start..(start + length).min(16) };
            let pixels = run.columns.clone().map(|column| row * 16 + column);
            let bit = |pixel: usize| 1_u128 << pixel;
            let mut columns = Vec::new();
            let joined = adjacency.around_each(&run, &mut columns, bit, |a, b| a | b);
            for (pixel, joined) in pixels.zip(joined) {
                let expected = adjacency.around(pixel).into_iter().fold(bit(pixel), |all, other| all | bit(other));
                prop_assert_eq!(joined, expected);
            }
        }
    }

    proptest! {
        #[test]
        fn row_and_column_are_quotient_and_remainder(height in 1_usize..=1 << 15, width in 1_usize..=1 << 16, at in 0.0..1.0_f64) {
            let adjacency = Adjacency { height, width, per_width: (1 << 48) / width as u64 + 1, hubs: [0; 2] };
            let index = (at * (height * width) as f64) as usize;
            for index in [index, index / width * width, index / width * width + width - 1] {
                prop_assert_eq!(adjacency.row_and_column(index), (index / width, index % width));
            }
        }
    }

    #[test]
    fn columns_meet_at_the_seam() {
        assert!(adjacency().around(3 * 16).contains(&(3 * 16 + 15)));
        assert!(adjacency().sides(3 * 16 + 15).contains(&(3 * 16)));
    }

    #[test]
    fn all_pixels_of_a_pole_row_are_neighbours_of_its_brightest() {
        let adjacency = adjacency();
        for pixel in 0..16 {
            assert!(adjacency.around(pixel).contains(&adjacency.hubs[0]));
        }
        assert!(!adjacency.around(5 * 16).contains(&adjacency.hubs[0]));
    }
}
