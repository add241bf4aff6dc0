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
//! row share one place.

use std::f64::consts::PI;

use super::components::{Regions, root};
use super::summary::Summary;

/// Join the regions that come closer than `gap` radians, from pixel to pixel; a pixel counts from the
/// `edge` of its region's peak on.
pub fn bridge(summary: &Summary, regions: Regions, gap: f64, edge: impl Fn(f64) -> f64) -> Regions {
    let count = regions.pixels.len() as u32;
    if count < 2 || gap <= 0.0 {
        return regions;
    }
    let neighbourhood = Neighbourhood::new(summary, &regions, gap, edge);
    let mut parent: Vec<u32> = (0..count).collect();
    for (region, pixels) in (0..).zip(&regions.pixels) {
        for &pixel in pixels.iter().take_while(|&&pixel| neighbourhood.is_solid(pixel)) {
            neighbourhood.visit(pixel, region, |other| {
                let (one, other) = (root(&mut parent, region), root(&mut parent, other));
                parent[one.max(other) as usize] = one.min(other);
            });
        }
    }
    join(regions, &mut parent)
}

/// The regions of each tree of `parent` as one.
fn join(mut regions: Regions, parent: &mut [u32]) -> Regions {
    let mut joined: Vec<Vec<u32>> = vec![Vec::new(); parent.len()];
    for (region, pixels) in (0..).zip(regions.pixels) {
        joined[root(parent, region) as usize].extend(pixels);
    }
    joined.retain(|pixels| !pixels.is_empty());
    for (label, pixels) in (1..).zip(&joined) {
        pixels.iter().for_each(|&pixel| regions.label[pixel as usize] = label);
    }
    Regions { pixels: joined, label: regions.label }
}

/// How many of `width` columns a row reaches into another before the chord exceeds `gap`; sine and
/// cosine of both polar angles.
fn columns_within(gap: f64, one: (f64, f64), other: (f64, f64), width: usize) -> usize {
    let along = (one.0 - other.0).powi(2) + (one.1 - other.1).powi(2);
    let half_sine = ((gap * gap - along).max(0.0) / (4.0 * one.0 * other.0)).sqrt();
    (half_sine.min(1.0).asin() / PI * width as f64) as usize
}

/// What lies how near to a pixel.
struct Neighbourhood<'a> {
    regions: &'a Regions,
    luminance: &'a [f32],
    /// Luminance from which on a pixel of each region counts.
    least: Vec<f32>,
    height: usize,
    width: usize,
    /// Rows within the gap.
    rows: usize,
    /// Columns within the gap: of the row `r + d`, seen from the row `r`, at `r * (rows + 1) + d`.
    columns: Vec<usize>,
    /// Columns of each row that lie about half a row's height apart: all of them but around the poles.
    steps: Vec<usize>,
}

impl<'a> Neighbourhood<'a> {
    fn new(summary: &'a Summary, regions: &'a Regions, gap: f64, edge: impl Fn(f64) -> f64) -> Self {
        let luminance = summary.luminance.as_slice().expect("an owned array");
        let (height, width) = summary.luminance.dim();
        let least = |pixels: &Vec<u32>| edge(f64::from(luminance[pixels[0] as usize])) as f32;
        let theta = summary.grid.theta_edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos());
        let theta: Vec<(f64, f64)> = theta.collect();
        let rows = (gap / PI * height as f64) as usize;
        let columns = (0..height).flat_map(|row| (0..=rows).map(move |d| (row, (row + d).min(height - 1))));
        Self {
            regions,
            luminance,
            least: regions.pixels.iter().map(least).collect(),
            height,
            width,
            rows,
            columns: columns
                .map(|(row, other)| columns_within(gap, theta[row], theta[other], width))
                .collect(),
            steps: theta.iter().map(|(sin, _)| ((0.25 / sin) as usize).max(1)).collect(),
        }
    }

    /// The region of a pixel that counts.
    fn region(&self, pixel: usize) -> Option<u32> {
        let region = self.regions.label[pixel].checked_sub(1)?;
        (self.luminance[pixel] >= self.least[region as usize]).then_some(region)
    }

    fn is_solid(&self, pixel: u32) -> bool {
        self.region(pixel as usize).is_some()
    }

    /// Call `meet` with the other regions within the gap of a pixel of `region`.
    fn visit(&self, pixel: u32, region: u32, mut meet: impl FnMut(u32)) {
        let (row, column) = (pixel as usize / self.width, pixel as usize % self.width);
        if self.is_inside(row, column, region) {
            return;
        }
        for other in row.saturating_sub(self.rows)..(row + self.rows + 1).min(self.height) {
            let columns = self.columns[row.min(other) * (self.rows + 1) + row.abs_diff(other)];
            for offset in (0..=columns.min(self.width / 2)).step_by(self.steps[other]) {
                for column in [column + offset, column + self.width - offset] {
                    let column = if column >= self.width { column - self.width } else { column };
                    self.region(other * self.width + column).filter(|&other| other != region).map(&mut meet);
                }
            }
        }
    }

    /// Whether the pixel's four neighbours are of its own region: nothing else is nearer to it than to them.
    fn is_inside(&self, row: usize, column: usize, region: u32) -> bool {
        let left = if column == 0 { self.width - 1 } else { column - 1 };
        let right = if column + 1 == self.width { 0 } else { column + 1 };
        let (up, down) = (row.saturating_sub(1), (row + 1).min(self.height - 1));
        let around = [(row, left), (row, right), (up, column), (down, column)];
        around.iter().all(|(row, column)| self.region(row * self.width + column) == Some(region))
    }
}
