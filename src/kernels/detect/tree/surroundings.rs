//! What is behind a light: the luminance just outside of it, its glare included.
//!
//! From each pixel at the border of a light, straight away from it, the pixel after the next but one:
//! the next is often cut by the light's edge. The median of those is the background, whatever stands
//! on one side of it.

use super::components::Regions;
use super::summary::Summary;

/// Pixels of a row's height from the border to where the surroundings are read.
const DISTANCE: usize = 3;
/// The surroundings are no light: at most this share of the peak.
const MOST_OF_THE_PEAK: f64 = 0.5;

/// Luminance behind each region, whose pixels count from the `edge` of its peak on.
pub fn backgrounds(summary: &Summary, regions: &Regions, edge: impl Fn(f64) -> f64) -> Vec<f64> {
    let luminance = summary.luminance.as_slice().expect("an owned array");
    let surroundings = Surroundings::new(summary, regions, luminance);
    let background = |(region, pixels): (u32, &Vec<u32>)| {
        let peak = pixels.iter().map(|&pixel| luminance[pixel as usize]).fold(0.0, f32::max);
        let least = edge(f64::from(peak)) as f32;
        let mut seen = surroundings.of(region, least);
        median(&mut seen).min(MOST_OF_THE_PEAK * f64::from(peak))
    };
    (0..).zip(&regions.pixels).map(background).collect()
}

fn median(values: &mut [f32]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1) }
}

struct Surroundings<'a> {
    regions: &'a Regions,
    luminance: &'a [f32],
    height: usize,
    width: usize,
    /// Columns of each row that make up `DISTANCE` heights of it.
    columns: Vec<usize>,
}

impl<'a> Surroundings<'a> {
    fn new(summary: &Summary, regions: &'a Regions, luminance: &'a [f32]) -> Self {
        let (height, width) = summary.luminance.dim();
        let sines = summary.grid.theta_edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin());
        let columns = sines.map(|sine| ((DISTANCE as f64 / sine) as usize).min(width / 2)).collect();
        Self { regions, luminance, height, width, columns }
    }

    /// Luminance around the pixels of `region` that are at least as bright as `least`.
    fn of(&self, region: u32, least: f32) -> Vec<f32> {
        let mut seen = Vec::new();
        let is_inside =
            |index: usize| self.regions.label[index] == region + 1 && self.luminance[index] >= least;
        for &index in &self.regions.pixels[region as usize] {
            let (row, column) = (index as usize / self.width, index as usize % self.width);
            if !is_inside(index as usize) {
                continue;
            }
            let at = |row: usize, column: usize| row * self.width + column % self.width;
            let far = self.columns[row];
            let sides = [
                (at(row, column + 1), at(row, column + far)),
                (at(row, column + self.width - 1), at(row, column + self.width - far)),
                (at(row.saturating_sub(1), column), at(row.saturating_sub(DISTANCE), column)),
                (
                    at((row + 1).min(self.height - 1), column),
                    at((row + DISTANCE).min(self.height - 1), column),
                ),
            ];
            let outside = sides.iter().filter(|(next, far)| !is_inside(*next) && !is_inside(*far));
            seen.extend(outside.map(|&(_, far)| self.luminance[far]));
        }
        seen
    }
}
