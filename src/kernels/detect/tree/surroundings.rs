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
