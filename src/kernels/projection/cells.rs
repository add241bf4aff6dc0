//! The cell of an equirectangular map that holds a direction, without an arc function.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{PI, TAU};

use crate::kernels::sphere::{Registration, band_heights};

/// Cells of a map, and a search for the one that holds a direction.
pub(super) struct Cells {
    pub height: usize,
    pub width: usize,
    /// Solid angle of a cell of each row.
    pub areas: Vec<f64>,
    /// Cosines of the polar angles between the rows.
    pub cosines: Vec<f64>,
    rows: Sectors,
    columns: Sectors,
}

impl Cells {
    pub fn new(height: usize, width: usize) -> Self {
        let theta_edges = Registration::CellCentred.theta_edges(height);
        let column = TAU / width as f64;
        Self {
            height,
            width,
            areas: band_heights(&theta_edges).iter().map(|band| band * column).collect(),
            cosines: theta_edges.iter().map(|theta| theta.cos()).collect(),
            rows: Sectors::new(&theta_edges),
            columns: Sectors::new(&Registration::CellCentred.phi_edges(width)),
        }
    }

    /// The cell of a direction with these [`diamonds`].
    #[inline(always)]
    pub fn at(&self, [polar, azimuth]: [f64; 2]) -> usize {
        self.rows.at(polar) * self.width + self.columns.at(azimuth)
    }
}

/// Parts of a circle or of a half circle, and a search for the one that holds an angle.
///
/// The diamond angle is measured along the square with its corners on the axes, instead of the circle. It grows with the
/// angle, and needs neither arc cosine nor arc tangent.
struct Sectors {
    /// Diamond angles between the parts.
    edges: Vec<f64>,
    /// The part at the start of each interval. The intervals divide the diamond angle evenly.
    first: Vec<u32>,
    intervals_per_unit: f64,
}

impl Sectors {
    /// Parts between `angles`, from 0 to pi or 2 pi.
    fn new(angles: &[f64]) -> Self {
        let parts = angles.len() - 1;
        let mut edges: Vec<f64> = angles.iter().map(|angle| diamond(angle.cos(), angle.sin())).collect();
        (edges[0], edges[parts]) = (0.0, f64::INFINITY);
        // A half circle has the diamond angle 2. Its derivative varies by at most a factor of 2, so each part has at
        // least two thirds of the mean diamond angle, and no interval contains two edges.
        let intervals_per_unit = (2 * parts) as f64 / (2.0 * (angles[parts] / PI).round());
        let part_at = |angle: f64| edges.partition_point(|&edge| edge <= angle).clamp(1, parts) - 1;
        let first = (0..=2 * parts).map(|i| part_at(i as f64 / intervals_per_unit) as u32).collect();
        Self { edges, first, intervals_per_unit }
    }

    /// The part that holds a diamond angle; on the axis itself the angle is NaN, which becomes 0.
    #[inline(always)]
    fn at(&self, angle: f64) -> usize {
        let interval = (angle * self.intervals_per_unit) as u32 as usize;
        let part = self.first[interval.min(self.first.len() - 1)] as usize;
        part + usize::from(angle >= self.edges[part + 1])
    }
}

/// The diamond angle, from 0 to 4 for a full turn; `cosine` and `sine` may have a common factor.
#[inline(always)]
fn diamond(cosine: f64, sine: f64) -> f64 {
    let along = cosine / (cosine.abs() + sine.abs());
    if sine >= 0.0 { 1.0 - along } else { 3.0 + along }
}

/// The diamond angles of a direction: from the pole, and around it.
#[inline(always)]
pub(super) fn diamonds([x, y, z]: [f64; 3]) -> [f64; 2] {
    [diamond(y, (x * x + z * z).sqrt()), diamond(-z, x)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::kernels::sphere::direction;

    proptest! {
        /// The cell agrees with the arc functions, except within rounding of an edge.
        #[test]
        fn a_direction_is_in_its_cell(
            theta in 0.0..PI, phi in 0.0..TAU, height in 2_usize..80, width in 2_usize..160,
        ) {
            let (down, across) = (theta / PI * height as f64, phi / TAU * width as f64);
            let is_clear = |at: f64| (at - at.round()).abs() > 1e-9;
            prop_assume!(is_clear(down) && is_clear(across));
            let cell = Cells::new(height, width).at(diamonds(direction(theta, phi).to_array()));
            prop_assert_eq!(cell, down as usize * width + across as usize);
        }
    }

    #[test]
    fn poles_and_seam_are_in_cells() {
        let cells = Cells::new(4, 8);
        let at = |x: f64, y: f64, z: f64| cells.at(diamonds([x, y, z]));
        assert_eq!(at(0.0, 1.0, 0.0), 0);
        assert_eq!(at(0.0, -1.0, 0.0) / 8, 3);
        assert_eq!(at(-1e-300, 0.5, -0.5), 8 + 7);
        assert_eq!(at(-0.0, 0.5, -0.5), 8);
    }
}
