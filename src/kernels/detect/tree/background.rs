//! What is behind a light: the luminance just outside of it, its glare included.
//!
//! From each pixel at the border of a light, straight away from it, the pixel after the next but one:
//! the next is often cut by the light's edge. The median of those is the background, whatever stands
//! on one side of it.

use super::components::Regions;
use super::summary::Summary;
use super::touch::Sheet;

/// Heights of a row from the border to where the surroundings are read.
const DISTANCE: usize = 3;
/// The surroundings are no light: at most this share of the peak.
const MOST_OF_THE_PEAK: f64 = 0.5;

/// Luminance behind each region.
pub fn backgrounds(summary: &Summary, sheet: &Sheet, regions: &Regions, outline: &[u32]) -> Vec<f64> {
    let luminance = &summary.luminance;
    let width = summary.size.1;
    let theta = summary.grid.theta_edges.windows(2);
    let columns = theta.map(|edge| (DISTANCE as f64 / (0.5 * (edge[0] + edge[1])).sin()) as usize);
    let columns: Vec<usize> = columns.map(|columns| columns.min(width / 2)).collect();
    let mut seen: Vec<Vec<f32>> = vec![Vec::new(); regions.pixels.len()];
    for index in outline.iter().map(|&index| index as usize) {
        let label = regions.label[index];
        let beyond = sheet.beyond(index, DISTANCE, columns[index / width]);
        for (side, beyond) in sheet.sides(index).into_iter().zip(beyond) {
            if regions.label[side] != label && regions.label[beyond] != label {
                seen[label as usize - 1].push(luminance[beyond]);
            }
        }
    }
    let most = regions.peaks.iter().map(|&peak| MOST_OF_THE_PEAK * f64::from(peak));
    seen.iter_mut().zip(most).map(|(seen, most)| median(seen).min(most)).collect()
}

fn median(values: &mut [f32]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::drawn::{drawn, regions};
    use super::super::outline::outline;
    use super::*;
    use approx::assert_relative_eq;

    /// Luminance behind a lamp of 9, 5 x 5 pixels, where column x around it looks like `pixel(x)`.
    fn behind(row: usize, column: usize, pixel: impl Fn(usize) -> char) -> f64 {
        let is_lamp = |y: usize, x: usize| y.abs_diff(row) <= 2 && (x + 32 - column + 2) % 32 <= 4;
        let rows: Vec<String> =
            (0..16).map(|y| (0..32).map(|x| if is_lamp(y, x) { '9' } else { pixel(x) }).collect()).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let summary = drawn(&rows);
        let (sheet, mut regions) = (Sheet::of(&summary), regions(&summary, 0.7));
        assert_eq!(regions.pixels.len(), 1);
        regions.pixels[0].retain(|&pixel| regions.label[pixel as usize] != 0);
        assert_eq!(regions.pixels[0].len(), 25);
        backgrounds(&summary, &sheet, &regions, &outline(&sheet, &regions))[0]
    }

    #[test]
    fn it_is_the_luminance_around_the_light_also_on_the_seam() {
        for column in [10, 0, 31] {
            assert_relative_eq!(behind(8, column, |_| '.'), 0.1, max_relative = 1e-5);
            assert_relative_eq!(behind(8, column, |_| '3'), 3.0, max_relative = 1e-5);
        }
    }

    #[test]
    fn what_stands_on_one_side_does_not_matter() {
        assert_relative_eq!(behind(8, 10, |x| if x > 12 { '4' } else { '1' }), 1.0, max_relative = 1e-5);
    }

    #[test]
    fn it_is_at_most_half_of_the_peak() {
        assert_relative_eq!(behind(8, 10, |_| '4'), 4.0, max_relative = 1e-5);
        assert_relative_eq!(behind(8, 10, |_| '5'), 4.5, max_relative = 1e-5);
    }
}
