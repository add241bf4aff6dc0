//! Columns of one width all around, on which every normal of a ring finds its horizon at the same place.
//!
//! Most working maps have them: all columns alike, or, where the outer samples lie on the seam, two halves
//! that make one. Other maps (a width that is no multiple of the reduced cells) are laid out anew, at least
//! two new columns to each of theirs: the flux is kept, only what the horizon cuts is smeared.

use std::f64::consts::TAU;

use crate::kernels::image::Grid;

/// Azimuths of a ring: few enough that a ring sees much of a row in one pass, many enough that the
/// steps around are as fine as those between rings of 5120 normals.
const FEWEST_AZIMUTHS: usize = 96;
const MOST_AZIMUTHS: usize = 256;
/// Azimuths of maps whose columns have no such divisor.
const OTHER_AZIMUTHS: usize = 128;

/// Columns of one width all around.
pub struct EvenColumns {
    pub count: usize,
    /// Their width, in radians.
    pub width: f64,
    /// The azimuth of the left edge of the first.
    pub first_edge: f64,
    /// Integrals of cos phi, sin phi and 1 over each.
    pub integrals: Vec<[f64; 3]>,
    /// Azimuths of a ring, a divisor of `count`.
    pub azimuths: usize,
    overlaps: Vec<Overlap>,
}

/// A column of the map within an even one.
struct Overlap {
    from: usize,
    to: usize,
    /// The share of the even column.
    share: f64,
}

impl EvenColumns {
    pub fn new(grid: &Grid) -> Self {
        // Find columns of the map that are as wide as each other, and split them if they are few.
        let columns = grid.columns_per_radian * TAU;
        let whole = columns.round();
        let divided = if (columns - whole).abs() < 1e-6 { divided(whole as usize) } else { None };
        // Otherwise lay out new ones, from the seam.
        let (count, azimuths, seam) = if let Some((count, azimuths)) = divided {
            (count, azimuths, grid.first_column / columns)
        } else {
            let least = 2 * grid.phi_edges.len();
            (least.next_multiple_of(OTHER_AZIMUTHS), OTHER_AZIMUTHS, 0.0)
        };
        let (width, first_edge) = (TAU / count as f64, -seam * TAU);
        // In the product cos phi dphi keeps its digits.
        let chord = 2.0 * (0.5 * width).sin();
        let integrals = (0..count).map(|i| {
            let (sin, cos) = (first_edge + (i as f64 + 0.5) * width).sin_cos();
            [chord * cos, chord * sin, width]
        });
        Self {
            count,
            width,
            first_edge,
            integrals: integrals.collect(),
            azimuths,
            overlaps: overlaps(&grid.phi_edges, count, first_edge),
        }
    }

    /// Radiance of a `row` of the map in these columns.
    pub fn of_row<'a>(&self, row: impl Fn(usize) -> [f32; 3] + 'a, even: &mut Vec<[f64; 3]>) {
        even.clear();
        even.resize(self.count, [0.0; 3]);
        for &Overlap { from, to, share } in &self.overlaps {
            for (sum, value) in even[to].iter_mut().zip(row(from)) {
                *sum += share * f64::from(value);
            }
        }
    }
}

/// A whole multiple of so many columns, and its least divisor that suits a ring.
fn divided(columns: usize) -> Option<(usize, usize)> {
    let count = columns * FEWEST_AZIMUTHS.div_ceil(columns);
    let azimuths = (FEWEST_AZIMUTHS..=MOST_AZIMUTHS).find(|&azimuths| count.is_multiple_of(azimuths));
    azimuths.map(|azimuths| (count, azimuths))
}

fn overlaps(phi_edges: &[f64], count: usize, first_edge: f64) -> Vec<Overlap> {
    /// Less than this of a column is rounding.
    const NOTHING: f64 = 1e-9;
    let place = |phi: f64| (phi - first_edge) / TAU * count as f64;
    let mut overlaps = Vec::with_capacity(phi_edges.len() + count);
    for (from, edges) in phi_edges.windows(2).enumerate() {
        let (left, right) = (place(edges[0]), place(edges[1]));
        for to in left.floor() as usize..right.ceil() as usize {
            let share = right.min((to + 1) as f64) - left.max(to as f64);
            if share > NOTHING {
                overlaps.push(Overlap { from, to: to % count, share });
            }
        }
    }
    overlaps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::Registration;

    fn even(width: usize, registration: Registration, block: usize) -> EvenColumns {
        EvenColumns::new(&Grid::of_pixels(width / 2, width, registration).in_blocks(block))
    }

    #[test]
    fn columns_are_kept_split_or_laid_out_anew() {
        use Registration::{BorderSampled, CellCentred};
        for (width, registration, block, wanted) in [
            (1024, CellCentred, 4, (256, 128)),
            (256, CellCentred, 1, (256, 128)),
            (250, CellCentred, 1, (250, 125)),
            (4, CellCentred, 1, (96, 96)),
            (128, BorderSampled, 1, (127, 127)),
            (16384, CellCentred, 1, (16384, 128)),
            (514, CellCentred, 3, (384, 128)),
            (1024, BorderSampled, 4, (640, 128)),
        ] {
            let columns = even(width, registration, block);
            assert_eq!((columns.count, columns.azimuths), wanted, "{width} columns, {registration:?}");
        }
    }

    #[test]
    fn a_row_keeps_its_flux() {
        for (width, registration, block) in [
            (64, Registration::CellCentred, 1),
            (64, Registration::BorderSampled, 1),
            (514, Registration::CellCentred, 3),
            (514, Registration::BorderSampled, 4),
        ] {
            let grid = Grid::of_pixels(width / 2, width, registration).in_blocks(block);
            let columns = EvenColumns::new(&grid);
            let radiance = |column: usize| [0.0, 1.0, 2.0].map(|c| 1.0 + (column % 7) as f32 + c);
            let mut even = Vec::new();
            columns.of_row(radiance, &mut even);
            for channel in 0..3 {
                let widths = grid.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).enumerate();
                let wanted: f64 = widths.map(|(i, width)| width * f64::from(radiance(i)[channel])).sum();
                let found: f64 = even.iter().map(|value| value[channel] * columns.width).sum();
                assert!(
                    (found / wanted - 1.0).abs() < 1e-8,
                    "{width} columns, {registration:?}: {found} {wanted}"
                );
            }
        }
    }
}
