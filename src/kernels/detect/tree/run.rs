//! Runs: pixels side by side, in which a row is worked through.

use std::ops::Range;

/// Pixels of the working image side by side in one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    pub row: usize,
    pub columns: Range<usize>,
}

/// Flat indices into an image of `columns` columns as runs, in their order.
pub fn runs(pixels: &[u32], columns: usize) -> Vec<Run> {
    let goes_on = |&one: &u32, &other: &u32| other == one + 1 && !(other as usize).is_multiple_of(columns);
    let run = |run: &[u32]| {
        let (row, first) = (run[0] as usize / columns, run[0] as usize % columns);
        Run { row, columns: first..first + run.len() }
    };
    pixels.chunk_by(goes_on).map(run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_ends_at_a_gap_and_with_its_row() {
        let run = |row, columns| Run { row, columns };
        let found = runs(&[3, 4, 5, 7, 14, 15, 16, 40, 39], 16);
        let wanted = [run(0, 3..6), run(0, 7..8), run(0, 14..16), run(1, 0..1), run(2, 8..9), run(2, 7..8)];
        assert_eq!(found, wanted);
    }
}
