//! Runs: adjacent pixels of one row.

use std::ops::Range;

/// Runs of one parallel task. Another number changes the order of sums, and the last bits of a measured light.
pub const RUNS_OF_A_TASK: usize = 64;

/// Adjacent pixels of one row of the working image.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Its row.
    pub row: usize,
    /// Its columns.
    pub columns: Range<usize>,
}

impl Run {
    /// Flat indices into an image of `width` columns.
    pub fn pixels(&self, width: usize) -> Range<usize> {
        self.row * width + self.columns.start..self.row * width + self.columns.end
    }
}

/// Runs of flat indices into an image of `columns` columns, in their order.
pub fn runs(pixels: &[u32], columns: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    for adjacent in pixels.chunk_by(|&one, &other| other == one + 1) {
        // Cut them where a row ends.
        let (mut first, end) = (adjacent[0] as usize, adjacent[0] as usize + adjacent.len());
        while first < end {
            let row = first / columns;
            let own = first - row * columns..end.min((row + 1) * columns) - row * columns;
            first += own.len();
            runs.push(Run { row, columns: own });
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_ends_at_a_gap_and_with_its_row() {
        let run = |row, columns| Run { row, columns };
        let result = runs(&[3, 4, 5, 7, 14, 15, 16, 40, 39], 16);
        let expected = [run(0, 3..6), run(0, 7..8), run(0, 14..16), run(1, 0..1), run(2, 8..9), run(2, 7..8)];
        assert_eq!(result, expected);
    }
}
