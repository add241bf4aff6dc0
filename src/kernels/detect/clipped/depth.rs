//! The depth of a pixel of the plateau: the angle to the nearest pixel outside of it.
//!
//! Along a row, the nearest outer pixel is one of the two at the ends of the pixel's run. Down a column, each row
//! hands on its nearest one, at the difference D of azimuths:
//!
//! ```text
//!   cos depth = max over rows r of  (cos t, sin t) . (cos t_r, sin t_r cos D_r)
//! ```
//!
//! for a pixel at the polar angle t. Only rows of the pixel's own run down the column, and the two outer pixels at its
//! ends, can hold the nearest: what lies beyond an end is farther than the end. The points on the right form a convex
//! hull, and the pixels of a run, whose vectors on the left turn, meet its corners in order: a few operations for each
//! pixel, however deep it lies. Distances are those between directions, so they hold at the seam and the poles.

use std::ops::Range;

use super::super::segment::run::Run;
use super::super::segment::working_image::WorkingImage;
use crate::interrupt;

/// The depth of each pixel of a `plateau`, in ascending order, in radians, as an image; 0 outside.
pub fn depths(working: &WorkingImage, plateau: &[Run]) -> Vec<f32> {
    let (height, width) = working.size;
    let sphere = PixelDirections::new(working);
    // Find the nearest outer pixel of each row, and turn rows into columns.
    let mut outer = vec![0.0; height * width];
    let (mut is_covered, mut turns) = (vec![false; width], Vec::new());
    for row in plateau.chunk_by(|one, other| one.row == other.row) {
        interrupt::check();
        for (run, ends) in row.iter().zip(ends(row, width)) {
            is_covered[run.columns.clone()].fill(true);
            sphere.fill_turns(run.columns.clone(), ends, &mut turns);
            for (column, &turn) in run.columns.clone().zip(&turns) {
                outer[column * height + run.row] = turn;
            }
        }
    }
    // Find that of all rows, column by column.
    let mut depth = vec![0.0; height * width];
    let mut hull = Hull::default();
    for (column, outer) in outer.chunks_exact(height).enumerate().filter(|(column, _)| is_covered[*column]) {
        interrupt::check();
        let mut top = 0;
        for run in outer.chunk_by(|one, other| (*one > 0.0) == (*other > 0.0)) {
            let bottom = top + run.len();
            if run[0] > 0.0 {
                hull.refill(&sphere, outer, top.saturating_sub(1)..(bottom + 1).min(height));
                for (row, cosine) in (top..bottom).zip(hull.cosines(&sphere.rows[top..bottom])) {
                    depth[row * width + column] = angle(cosine);
                }
            }
            top = bottom;
        }
    }
    depth
}

/// The columns before and after each run of a row, across the seam; none where the row has no outer pixel.
fn ends(row: &[Run], width: usize) -> impl Iterator<Item = Option<[usize; 2]>> {
    let (first, last) = (&row[0].columns, &row[row.len() - 1].columns);
    let is_whole = first.start == 0 && first.end == width;
    // A run that ends at the seam goes on with the one on its other side.
    let before_seam = if last.end == width { last.start } else { width }.wrapping_sub(1);
    let after_seam = if first.start == 0 { first.end } else { 0 };
    row.iter().map(move |run| {
        let before = if run.columns.start == 0 { before_seam } else { run.columns.start - 1 };
        let after = if run.columns.end == width { after_seam } else { run.columns.end };
        (!is_whole).then_some([before, after])
    })
}

/// The angle of a cosine, to the precision of a depth.
fn angle(cosine: f64) -> f32 {
    2.0 * ((0.5 * (1.0 - cosine)).max(0.0).sqrt() as f32).min(1.0).asin()
}

/// The upper convex hull of the points that stand for outer pixels.
#[derive(Default)]
struct Hull {
    corners: Vec<[f64; 2]>,
}

impl Hull {
    /// The hull of the outer pixels of some rows of a column; `outer` are the turns to them.
    fn refill(&mut self, sphere: &PixelDirections, outer: &[f32], rows: Range<usize>) {
        self.corners.clear();
        for row in rows.filter(|&row| outer[row] < NO_OUTER) {
            let (sin, cos) = sphere.rows[row];
            let point = [cos, sin * (1.0 - f64::from(outer[row]))];
            while let [.., one, other] = self.corners[..]
                && !turns_left(one, other, point)
            {
                self.corners.pop();
            }
            self.corners.push(point);
        }
    }

    /// The largest cosine between each of some rows, downwards, and a point; -1 where there is none.
    fn cosines(&self, rows: &[(f64, f64)]) -> impl Iterator<Item = f64> {
        let mut corner = 0;
        rows.iter().map(move |&(sin, cos)| {
            let cosine = |corner: usize| self.corners.get(corner).map(|[x, y]| cos * x + sin * y);
            while cosine(corner + 1) > cosine(corner) {
                corner += 1;
            }
            cosine(corner).unwrap_or(-1.0)
        })
    }
}

/// Whether the way over three points turns to the left at the second.
fn turns_left(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
}

/// In place of the turn to an outer pixel: the row has none.
const NO_OUTER: f32 = f32::INFINITY;

/// The directions of pixels, by row and column.
pub struct PixelDirections {
    width: usize,
    /// Sine and cosine of the polar angle of each row.
    rows: Vec<(f64, f64)>,
    /// Sine and cosine of the azimuth of each column.
    columns: Vec<(f64, f64)>,
}

impl PixelDirections {
    /// The centres of the pixels of an image.
    pub fn new(working: &WorkingImage) -> Self {
        let centres =
            |edges: &[f64]| edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos()).collect();
        let grid = &working.grid;
        Self { width: working.size.1, rows: centres(&grid.theta_edges), columns: centres(&grid.phi_edges) }
    }

    /// Unit vector towards a pixel, in the frame of [`crate::kernels::sphere`].
    pub fn direction(&self, pixel: u32) -> glam::DVec3 {
        let pixel = pixel as usize;
        self.at(pixel / self.width, pixel % self.width)
    }

    /// Unit vector towards a pixel.
    pub fn at(&self, row: usize, column: usize) -> glam::DVec3 {
        let ((sin, cos), (sin_phi, cos_phi)) = (self.rows[row], self.columns[column]);
        glam::DVec3::new(sin * sin_phi, cos, -sin * cos_phi)
    }

    /// For each of some columns, 1 - cos of the azimuth between it and the nearer one of its run's `ends`.
    fn fill_turns(&self, columns: Range<usize>, ends: Option<[usize; 2]>, turns: &mut Vec<f32>) {
        turns.clear();
        let Some(ends) = ends else { return turns.resize(columns.len(), NO_OUTER) };
        let [before, after] = ends.map(|end| self.columns[end]);
        turns.extend(self.columns[columns].iter().map(|(sin, cos)| {
            let turn = |end: (f64, f64)| 1.0 - (sin * end.0 + cos * end.1);
            turn(before).min(turn(after)) as f32
        }));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use glam::DVec3;
    use ndarray::Array3;

    use super::super::super::segment::run::runs;
    use super::*;
    use crate::kernels::sphere::Registration;

    const HEIGHT: usize = 64;

    /// The depths of pixels in ascending order.
    fn depths_of(working: &WorkingImage, plateau: &[u32]) -> Vec<f32> {
        depths(working, &runs(plateau, 2 * HEIGHT))
    }

    fn image() -> WorkingImage {
        let map = Array3::zeros((HEIGHT, 2 * HEIGHT, 3));
        WorkingImage::of(map.view(), Registration::CellCentred, 2 * HEIGHT).unwrap()
    }

    /// Pixels within `radius` of `centre`.
    fn cap(sphere: &PixelDirections, centre: DVec3, radius: f64) -> Vec<u32> {
        let all = 0..(2 * HEIGHT * HEIGHT) as u32;
        all.filter(|&pixel| sphere.direction(pixel).angle_between(centre) < radius).collect()
    }

    /// The nearest outer pixel of each, by trying all of them.
    #[test]
    fn depths_are_the_angles_to_the_nearest_outer_pixel_across_seam_and_pole_too() {
        let working = image();
        let sphere = PixelDirections::new(&working);
        for centre in [DVec3::new(0.3, 0.4, 1.0), DVec3::new(0.05, 0.3, -1.0), DVec3::new(0.1, -1.0, 0.1)] {
            let mut plateau = cap(&sphere, centre.normalize(), 0.35);
            plateau.retain(|pixel| pixel % 41 != 0); // some holes
            let found = depths_of(&working, &plateau);
            let outer: Vec<DVec3> = (0..found.len() as u32)
                .filter(|pixel| plateau.binary_search(pixel).is_err())
                .map(|pixel| sphere.direction(pixel))
                .collect();
            for &pixel in &plateau {
                let own = sphere.direction(pixel);
                let cosine = outer.iter().map(|other| own.dot(*other)).fold(-1.0, f64::max);
                assert_relative_eq!(f64::from(found[pixel as usize]), cosine.min(1.0).acos(), epsilon = 1e-6);
            }
        }
    }

    #[test]
    fn the_centre_of_a_cap_is_as_deep_as_its_radius() {
        let working = image();
        let plateau = cap(&PixelDirections::new(&working), DVec3::Y, 0.5);
        let deepest = depths_of(&working, &plateau).into_iter().fold(0.0, f32::max);
        assert_relative_eq!(f64::from(deepest), 0.5, epsilon = working.row_height());
    }

    #[test]
    fn a_plateau_without_a_rim_is_half_a_turn_deep() {
        let all: Vec<u32> = (0..(2 * HEIGHT * HEIGHT) as u32).collect();
        let depth = depths_of(&image(), &all);
        assert!(depth.iter().all(|&depth| (depth - std::f32::consts::PI).abs() < 1e-5));
    }
}
