//! Lights that only a narrow dark gap divides: a window and its bars.
//!
//! The distance between two directions is that of their points on the sphere,
//!
//! ```text
//!   chord^2 = (sin theta_1 - sin theta_2)^2 + (cos theta_1 - cos theta_2)^2
//!           + 4 sin theta_1 sin theta_2 sin^2((phi_1 - phi_2) / 2)
//! ```
//!
//! so a gap means the same at the equator, on the seam and around the poles, where many pixels of a
//! row share one place. The middles of the pixels on both sides of a bar are its width and one pixel
//! apart.

use std::f64::consts::PI;

use super::components::{Regions, root};
use super::summary::Summary;
use super::touch::Sheet;

/// Join the regions whose solid pixels are parted by no more than `gap` radians.
///
/// A pixel is solid if its luminance times `prominence` reaches its region's peak. Two lights that
/// prominence keeps apart are darker than that where they meet: they are joined across a bar,
/// however dim, but not along the glow between two lamps.
pub fn bridge(summary: &Summary, sheet: &Sheet, regions: Regions, prominence: f64, gap: f64) -> Regions {
    if regions.pixels.len() < 2 || gap <= 0.0 {
        return regions;
    }
    let solid_label = |pixel: usize| match regions.label[pixel] {
        0 => 0,
        label if prominence as f32 * summary.luminance[pixel] < regions.peaks[label as usize - 1] => 0,
        label => label,
    };
    let reach = Reach::new(summary, gap + summary.pixel());
    let mut parent: Vec<u32> = (0..regions.pixels.len() as u32).collect();
    // Of two regions one that looks is enough: the largest need not.
    let size = |&region: &usize| regions.pixels[region].len();
    let largest = (0..regions.pixels.len()).max_by_key(size);
    let looking = (0..regions.pixels.len()).filter(|&region| Some(region) != largest);
    for pixel in looking.flat_map(|region| &regions.pixels[region]).map(|&pixel| pixel as usize) {
        let own = solid_label(pixel);
        if own == 0 || sheet.sides(pixel).into_iter().all(|side| solid_label(side) == own) {
            continue; // dark, or nearer to its own kind than to any other
        }
        reach.visit(pixel, |other| {
            let other = solid_label(other);
            if other != 0 && other != own {
                let (one, other) = (root(&mut parent, own - 1), root(&mut parent, other - 1));
                parent[one.max(other) as usize] = one.min(other);
            }
        });
    }
    join(regions, &mut parent)
}

/// The regions of each tree of `parent` as one.
fn join(regions: Regions, parent: &mut [u32]) -> Regions {
    let mut place = vec![0; parent.len()];
    let mut joined = Regions { pixels: Vec::new(), peaks: Vec::new(), label: regions.label };
    for ((region, pixels), peak) in (0..).zip(regions.pixels).zip(regions.peaks) {
        let whole = root(parent, region) as usize;
        if place[whole] == 0 {
            joined.pixels.push(Vec::new());
            joined.peaks.push(peak);
            place[whole] = joined.pixels.len();
        }
        let whole = place[whole];
        for &pixel in &pixels {
            let label = &mut joined.label[pixel as usize];
            *label = if *label == 0 { 0 } else { whole as u32 };
        }
        joined.peaks[whole - 1] = joined.peaks[whole - 1].max(peak);
        joined.pixels[whole - 1].extend(pixels);
    }
    joined
}

/// Which pixels lie within an angle of one, middle to middle.
struct Reach {
    /// Square of the chord of the angle.
    chord_squared: f64,
    height: usize,
    width: usize,
    /// Rows to look at on either side.
    rows: usize,
    /// Sine and cosine of the polar angle of each row.
    theta: Vec<(f64, f64)>,
}

impl Reach {
    fn new(summary: &Summary, angle: f64) -> Self {
        let (height, width) = summary.size;
        let theta = summary.grid.theta_edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos());
        // One more than fit, as the last row may be lower than the others.
        let rows = (angle / PI * height as f64) as usize + 1;
        // Beyond half a turn there is nothing; and no chord fails for its last digits.
        let chord_squared = (2.0 * (0.5 * angle.min(PI)).sin()).powi(2) * (1.0 + 1e-12);
        Self { chord_squared, height, width, rows, theta: theta.collect() }
    }

    /// Call `see` with the flat index of each pixel within the angle.
    fn visit(&self, pixel: usize, mut see: impl FnMut(usize)) {
        let (row, column) = (pixel / self.width, pixel % self.width);
        for other in row.saturating_sub(self.rows)..(row + self.rows + 1).min(self.height) {
            let Some(columns) = self.columns_within(row, other) else { continue };
            // Around a pole a row's pixels lie closer than its height: a quarter of it apart will do.
            let step = ((0.25 / self.theta[other].0) as usize).max(1);
            for offset in (0..=columns).step_by(step) {
                for column in [column + offset, column + self.width - offset] {
                    see(other * self.width + column % self.width);
                }
            }
        }
    }

    /// How many columns a row reaches into another before the chord is too long, if any.
    fn columns_within(&self, row: usize, other: usize) -> Option<usize> {
        let ((sin, cos), (other_sin, other_cos)) = (self.theta[row], self.theta[other]);
        let along = (sin - other_sin).powi(2) + (cos - other_cos).powi(2);
        let left = self.chord_squared - along;
        let half_sine = || (left / (4.0 * sin * other_sin)).sqrt().min(1.0);
        (left >= 0.0).then(|| (half_sine().asin() / PI * self.width as f64) as usize)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::drawn::{drawn, drawn_from, regions, sizes};
    use super::super::summary::summarise;
    use super::*;
    use crate::kernels::sphere::{Registration, direction};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// Pixels of each light of a drawing after gaps of so many pixel heights are bridged.
    fn bridged(summary: &Summary, gap_px: f64) -> Vec<usize> {
        let gap = gap_px * PI / summary.size.0 as f64;
        sizes(&bridge(summary, &Sheet::of(summary), regions(summary, 0.0), 4.0, gap))
    }

    #[test]
    fn a_bar_of_one_pixel_joins_and_one_of_three_does_not() {
        assert_eq!(bridged(&drawn_from(4, &["...99.99........"]), 1.2), [4]);
        assert_eq!(bridged(&drawn_from(4, &["...99...99......"]), 1.2), [2, 2]);
        assert_eq!(
            bridged(&drawn_from(2, &["....99..........", "................", "....99.........."]), 1.2),
            [4]
        );
    }

    #[test]
    fn a_bar_on_the_seam_joins() {
        assert_eq!(bridged(&drawn_from(4, &["9..............9"]), 1.2), [2]);
        assert_eq!(bridged(&drawn_from(4, &[".9.............9"]), 1.2), [2]);
        assert_eq!(bridged(&drawn_from(4, &["9.............9."]), 1.2), [2]);
        assert_eq!(bridged(&drawn_from(4, &[".9............9."]), 1.2), [1, 1]);
    }

    #[test]
    fn no_gap_no_bridge() {
        assert_eq!(bridged(&drawn_from(4, &["...99.99........"]), 0.0), [2, 2]);
    }

    #[test]
    fn a_glow_between_two_lamps_is_no_bridge() {
        assert_eq!(bridged(&drawn_from(4, &["...921298......."]), 1.2), [3, 3]);
        // A third of the peak is solid.
        assert_eq!(bridged(&drawn_from(4, &["...93.39........"]), 1.2), [4]);
    }

    /// Over the pole, half a turn apart in row 1: 3 heights from middle to middle; in row 7 of 16 nearly a half circle.
    #[test]
    fn around_a_pole_a_gap_is_an_angle() {
        let row = "9...............9...............";
        let dark = ".".repeat(32);
        for (y, wanted) in [(1, vec![2]), (14, vec![2]), (2, vec![1, 1]), (7, vec![1, 1])] {
            let mut rows = vec![dark.as_str(); 16];
            rows[y] = row;
            assert_eq!(bridged(&drawn(&rows), 2.2), wanted, "row {y}");
        }
    }

    #[test]
    fn a_chain_of_panes_is_one_light_with_all_pixels_and_the_highest_peak() {
        let summary = drawn_from(4, &["..5.9.7.6......."]);
        let gap = 1.2 * PI / 8.0;
        let joined = bridge(&summary, &Sheet::of(&summary), regions(&summary, 0.0), 4.0, gap);
        assert_eq!(sizes(&joined), [4]);
        assert!((joined.peaks[0] - 9.0).abs() < 1e-5);
        for &pixel in &joined.pixels[0] {
            assert_eq!(joined.label[pixel as usize], 1);
        }
        assert_eq!(joined.label.iter().filter(|&&label| label != 0).count(), 4);
    }

    proptest! {
        /// All pixels that lie within an angle, and none that lies farther, also where the last row is
        /// lower than the others.
        #[test]
        fn what_is_within_reach_is_seen(row in 0_usize..23, column in 0_usize..46, angle in 0.1..3.0) {
            let map = ndarray::Array3::zeros((45, 92, 3));
            let summary = summarise(map.view(), Registration::CellCentred, 46).unwrap();
            let pixel = row * 46 + column;
            let mut is_seen = vec![false; 23 * 46];
            Reach::new(&summary, angle).visit(pixel, |other| is_seen[other] = true);
            let edges = &summary.grid.theta_edges;
            let towards = |pixel: usize| {
                let (row, column) = (pixel / 46, pixel % 46);
                direction(0.5 * (edges[row] + edges[row + 1]), TAU * (column as f64 + 0.5) / 46.0)
            };
            for (other, seen) in is_seen.into_iter().enumerate() {
                let apart = towards(pixel).angle_between(towards(other));
                prop_assert!(!seen || apart <= angle + 1e-7, "{pixel} {other} {apart}");
                // The rows at the poles are seen in steps.
                let is_polar = [0, 22].contains(&(other / 46));
                prop_assert!(seen || is_polar || apart >= angle - 1e-7, "{pixel} {other} {apart}");
            }
        }
    }
}
