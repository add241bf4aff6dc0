//! How the pixels of an equirectangular image touch on the sphere.

use std::iter::once;
use std::ops::Range;

use super::run::Run;
use super::summary::Summary;

/// Eight neighbours, columns that meet again behind the seam, and rows at the poles whose pixels all
/// touch: each of them touches the brightest of its row, the pole's *hub*, and through it the others.
pub struct Sheet {
    height: usize,
    width: usize,
    /// `2^48 / width`, rounded up.
    per_width: u64,
    hubs: [usize; 2],
}

impl Sheet {
    pub fn of(summary: &Summary) -> Self {
        let (height, width) = summary.size;
        let luminance = &summary.luminance;
        let brightest = |row: usize| {
            let pixels = row * width..(row + 1) * width;
            pixels.reduce(|a, b| if luminance[b] > luminance[a] { b } else { a }).unwrap_or(0)
        };
        let per_width = (1 << 48) / width as u64 + 1;
        Self { height, width, per_width, hubs: [brightest(0), brightest(height - 1)] }
    }

    /// Row and column, by a multiplication: a division would take a fifth of the time of all that touch.
    /// Exact as long as `height * width^2 < 2^48`.
    fn place(&self, index: usize) -> (usize, usize) {
        let row = ((index as u64 * self.per_width) >> 48) as usize;
        (row, index - row * self.width)
    }

    /// The pixels of a run.
    pub fn pixels(&self, run: &Run) -> Range<usize> {
        let first = run.row * self.width;
        first + run.columns.start..first + run.columns.end
    }

    /// The pixels that touch one; itself where there is none.
    pub fn around(&self, index: usize) -> [usize; 9] {
        let (row, column) = self.place(index);
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

    /// What `value` gives for each pixel of a `run` and for all that touch it, joined: first down each of
    /// the `columns`, a place to work in, then across three of them.
    pub fn around_each<'a, T: Copy>(
        &self,
        run: &Run,
        columns: &'a mut Vec<T>,
        value: impl Fn(usize) -> T,
        join: impl Fn(T, T) -> T + 'a,
    ) -> impl Iterator<Item = T> + 'a {
        let (up, row, down) = self.rows(run.row);
        let [left, ..] = self.columns(run.columns.start);
        let [.., right] = self.columns(run.columns.end - 1);
        let in_column = |column| join(value(row + column), join(value(up + column), value(down + column)));
        columns.clear();
        columns.extend(once(left).chain(run.columns.clone()).chain(once(right)).map(in_column));
        let hub = (up == row || down == row).then(|| value(self.hub(row, run.row)));
        columns.windows(3).map(move |three| {
            let joined = join(three[1], join(three[0], three[2]));
            hub.map_or(joined, |hub| join(joined, hub))
        })
    }

    /// The pixels on the left, on the right, above and below; itself beyond the first and last row.
    pub fn sides(&self, index: usize) -> [usize; 4] {
        let (row, column) = self.place(index);
        let [left, here, right] = self.columns(column);
        let (up, row, down) = self.rows(row);
        [row + left, row + right, up + here, down + here]
    }

    /// The pixels `columns` to the left and right, `rows` above and below; at the poles the last there is.
    pub fn beyond(&self, index: usize, rows: usize, columns: usize) -> [usize; 4] {
        let (row, column) = self.place(index);
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
    use super::super::summary::summarise;
    use super::*;
    use crate::kernels::sphere::Registration;
    use ndarray::Array3;
    use proptest::prelude::*;

    fn sheet() -> Sheet {
        let map = Array3::from_shape_fn((8, 16, 3), |(y, x, _)| ((y * 5 + x * 3) % 7) as f32);
        Sheet::of(&summarise(map.view(), Registration::CellCentred, 16).unwrap())
    }

    proptest! {
        /// Away from the poles, whoever I touch touches me.
        #[test]
        fn touching_is_mutual(row in 1_usize..7, column in 0_usize..16) {
            let (sheet, pixel) = (sheet(), row * 16 + column);
            for other in sheet.around(pixel).into_iter().filter(|other| (16..112).contains(other)) {
                prop_assert!(sheet.around(other).contains(&pixel), "{pixel} {other}");
            }
        }
    }

    proptest! {
        #[test]
        fn around_each_are_those_around_and_itself(row in 0_usize..8, start in 0_usize..16, length in 1_usize..=16) {
            let sheet = sheet();
            let run = Run { row, columns: start..(start + length).min(16) };
            let pixels = run.columns.clone().map(|column| row * 16 + column);
            let bit = |pixel: usize| 1_u128 << pixel;
            let mut columns = Vec::new();
            let seen = sheet.around_each(&run, &mut columns, bit, |a, b| a | b);
            for (pixel, seen) in pixels.zip(seen) {
                let wanted = sheet.around(pixel).into_iter().fold(bit(pixel), |all, other| all | bit(other));
                prop_assert_eq!(seen, wanted);
            }
        }
    }

    proptest! {
        #[test]
        fn a_place_is_a_quotient_and_a_rest(height in 1_usize..=1 << 15, width in 1_usize..=1 << 16, at in 0.0..1.0_f64) {
            let sheet = Sheet { height, width, per_width: (1 << 48) / width as u64 + 1, hubs: [0; 2] };
            let index = (at * (height * width) as f64) as usize;
            for index in [index, index / width * width, index / width * width + width - 1] {
                prop_assert_eq!(sheet.place(index), (index / width, index % width));
            }
        }
    }

    #[test]
    fn columns_meet_behind_the_seam() {
        assert!(sheet().around(3 * 16).contains(&(3 * 16 + 15)));
        assert!(sheet().sides(3 * 16 + 15).contains(&(3 * 16)));
    }

    #[test]
    fn all_pixels_of_a_pole_row_touch_its_brightest() {
        let sheet = sheet();
        for pixel in 0..16 {
            assert!(sheet.around(pixel).contains(&sheet.hubs[0]));
        }
        assert!(!sheet.around(5 * 16).contains(&sheet.hubs[0]));
    }
}
