//! Discs of few pixels: their radius, by the share of each pixel that they cover.
//!
//! The rim of a small disc cuts most of its pixels, which moments hardly know how to count. A disc of the luminance A before
//! one of B gives a pixel of which it covers the share c
//!
//! ```text
//!   y = B + c A
//! ```
//!
//! and its place and radius, with A and B, follow from the pixels around it by least squares (Levenberg 1944).
//!
//! They do where it reaches into three rows or three columns, as any disc does that is two pixels wide. A smaller one may
//! lie within two rows and two columns. Shrunk towards the place where these cross, it covers the same shares, brighter: its
//! pixels tell no more than the greatest radius. There, what moments say stands in, as far as the pixels allow.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use nalgebra::{SMatrix, SVector};
use ndarray::ArrayView3;
use rayon::prelude::*;

use super::moments::Light;
use crate::kernels::image::{Grid, luminance};
use crate::kernels::sphere::{Registration, angles};

/// How far a fitted radius may be from that of the moments, as a logarithm, for the same cost as what pixels usually are off
/// by: a share of the light's luminance.
const RADIUS_ERROR: f64 = 0.15;
const PIXEL_ERROR: f64 = 0.03;

/// Give each light of few pixels that a disc explains the solid angle of that disc.
pub fn measure(radiance: ArrayView3<'_, f32>, registration: Registration, lights: &mut [Light]) {
    /// Squares of rows. From 1.5 rows in radius on, moments are right to 5 %.
    const FEW: f64 = 10.0;
    let (height, width, _) = radiance.dim();
    let most = FEW * (PI / height as f64).powi(2);
    let is_small = |light: &&mut Light| light.solid_angle() < most;
    if lights.iter_mut().any(|light| is_small(&light)) {
        let map = Map { radiance, grid: Grid::of_pixels(height, width, registration) };
        lights.par_iter_mut().filter(is_small).for_each(|light| light.disc = map.disc(light));
    }
}

/// A map in its own pixels.
struct Map<'a> {
    radiance: ArrayView3<'a, f32>,
    grid: Grid,
}

/// A pixel in the plane that touches the sphere at the light: its edges, in radians, and its luminance.
#[derive(Clone, Copy, Debug)]
struct Cell {
    x: [f64; 2],
    y: [f64; 2],
    luminance: f64,
}

impl Map<'_> {
    /// Solid angle of the disc that explains the pixels around a light, if one does.
    fn disc(&self, light: &Light) -> Option<f64> {
        let radius = 2.0 * (0.25 * light.solid_angle() / PI).sqrt().min(1.0).asin();
        let cells = self.cells(light.direction(), radius);
        let radius = Fit::of(&cells, radius)?.radius();
        Some(4.0 * PI * (0.5 * radius).sin().powi(2))
    }

    /// The pixels around a disc; none where they are no rectangles, near a pole and in maps of few rows.
    fn cells(&self, direction: DVec3, radius: f64) -> Vec<Cell> {
        /// How far beyond the radius they reach, in heights of a row.
        const BEYOND: f64 = 1.5;
        /// Azimuth within which a parallel is straight, in radians.
        const STRAIGHT: f64 = 0.2;
        let (theta, phi) = angles(direction);
        let (height, width, _) = self.radiance.dim();
        let reach = radius + BEYOND * PI / height as f64;
        let across = reach / theta.sin();
        if across > STRAIGHT {
            return Vec::new();
        }
        let Grid { theta_edges, phi_edges, columns_per_radian, first_column } = &self.grid;
        let row = |theta: f64| theta_edges.partition_point(|&edge| edge <= theta).clamp(1, height) - 1;
        let column = |phi: f64| (phi * columns_per_radian + first_column).floor() as i64;
        let mut cells = Vec::new();
        for row in row(theta - reach)..=row(theta + reach) {
            let y = [theta_edges[row] - theta, theta_edges[row + 1] - theta];
            let scale = (0.5 * (theta_edges[row] + theta_edges[row + 1])).sin();
            for column in column(phi - across)..=column(phi + across) {
                let column = column.rem_euclid(width as i64) as usize;
                let [left, right] = [phi_edges[column], phi_edges[column + 1]];
                // Across the seam, the way round is longer.
                let turn = TAU * ((0.5 * (left + right) - phi) / TAU).round();
                let rgb = [0, 1, 2].map(|c| f64::from(self.radiance[[row, column, c]]));
                let x = [left, right].map(|edge| scale * (edge - turn - phi));
                cells.push(Cell { x, y, luminance: luminance(rgb) });
            }
        }
        cells
    }
}

/// A disc, and how well it explains pixels.
#[derive(Clone, Debug)]
struct Fit {
    /// Its middle, and the logarithm of its radius.
    at: [f64; 3],
    /// Sums of squares of its light, and of what is left.
    used: f64,
    left: f64,
    cost: f64,
    /// Half the negative gradient of the cost by place, radius and levels, and half its second derivative.
    gradient: SVector<f64, 5>,
    hessian: SMatrix<f64, 5, 5>,
}

impl Fit {
    /// The best disc near one of a `radius` in the middle of `cells`; none where no disc explains them.
    fn of(cells: &[Cell], radius: f64) -> Option<Self> {
        const MOST_STEPS: usize = 20;
        /// What is left of the light, as a share of its RMS luminance: pixels of generated discs, whose coverage is counted
        /// in sixteenths, leave up to .09.
        const MOST_LEFT: f64 = 0.15;
        let mut fit = Self::at(cells, [0.0, 0.0, radius.ln()], radius)?;
        let mut damping = 1e-2;
        for _ in 0..MOST_STEPS {
            let Some(next) = fit.lower(cells, radius, &mut damping) else { break };
            fit = next;
        }
        (fit.left <= MOST_LEFT.powi(2) * fit.used).then_some(fit)
    }

    fn radius(&self) -> f64 {
        self.at[2].exp()
    }

    /// At one place, with the best levels: none where pixels do not tell them.
    fn at(cells: &[Cell], at: [f64; 3], radius: f64) -> Option<Self> {
        let shares: Vec<(f64, [f64; 3])> = cells.iter().map(|cell| cell.share(at)).collect();
        // Regress the luminance on the share.
        let count = cells.len() as f64;
        let mean = |of: &dyn Fn(usize) -> f64| (0..cells.len()).map(of).sum::<f64>() / count;
        let (share, luminance) = (mean(&|i| shares[i].0), mean(&|i| cells[i].luminance));
        let square = mean(&|i| (shares[i].0 - share).powi(2));
        let product = mean(&|i| (shares[i].0 - share) * (cells[i].luminance - luminance));
        let disc = product / square;
        let behind = luminance - disc * share;
        if !(disc > 0.0 && disc.is_finite()) {
            return None;
        }
        // Sum the derivatives of what is left; a radius far from the moments' costs.
        let (mut gradient, mut hessian) = (SVector::<f64, 5>::zeros(), SMatrix::<f64, 5, 5>::zeros());
        let (mut used, mut left) = (0.0, 0.0);
        for (cell, (share, [x, y, r])) in cells.iter().zip(&shares) {
            let slopes = SVector::from([disc * x, disc * y, disc * r, *share, 1.0]);
            let off = cell.luminance - behind - disc * share;
            used += (disc * share).powi(2);
            left += off * off;
            gradient += off * slopes;
            hessian += slopes * slopes.transpose();
        }
        let (weight, off) = ((PIXEL_ERROR * disc / RADIUS_ERROR).powi(2), at[2] - radius.ln());
        gradient[2] -= weight * off;
        hessian[(2, 2)] += weight;
        Some(Self { at, used, left, cost: left + weight * off * off, gradient, hessian })
    }

    /// A step down, with more and more damping; none at the bottom.
    fn lower(&self, cells: &[Cell], radius: f64, damping: &mut f64) -> Option<Self> {
        const STIFFEST: f64 = 1e6;
        /// Steps end at this, in radii.
        const LEAST_STEP: f64 = 3e-3;
        while *damping < STIFFEST {
            let mut damped = self.hessian;
            (0..3).for_each(|i| damped[(i, i)] *= 1.0 + *damping);
            let step = damped.cholesky()?.solve(&self.gradient);
            let own = self.radius();
            let longest = (step[0] / own).abs().max((step[1] / own).abs()).max(step[2].abs());
            if longest < LEAST_STEP {
                return None;
            }
            // Half a radius at most: farther off, all slopes are others.
            let scale = (0.5 / longest).min(1.0);
            let at = [0, 1, 2].map(|i| self.at[i] + scale * step[i]);
            if let Some(next) = Self::at(cells, at, radius).filter(|next| next.cost < self.cost) {
                *damping *= 0.1;
                return Some(next);
            }
            *damping *= 10.0;
        }
        None
    }
}

impl Cell {
    /// The share that a disc covers, and its derivatives by the middle and the logarithm of the radius.
    ///
    /// Where the middle moves, the disc gains along one edge what it loses along the other. Where all lengths grow, the
    /// area does with their square, so that Euler's theorem tells the derivative by the radius from those by the edges.
    fn share(&self, [x, y, log_radius]: [f64; 3]) -> (f64, [f64; 3]) {
        let radius = log_radius.exp();
        let [left, right] = self.x.map(|edge| (edge - x) / radius);
        let [top, bottom] = self.y.map(|edge| (edge - y) / radius);
        // Most pixels are wholly outside, and some inside.
        let nearest = left.max(-right).max(0.0).powi(2) + top.max(-bottom).max(0.0).powi(2);
        let farthest = right.max(-left).powi(2) + bottom.max(-top).powi(2);
        if nearest >= 1.0 || farthest <= 1.0 {
            return (if nearest >= 1.0 { 0.0 } else { 1.0 }, [0.0; 3]);
        }
        let area = beyond(right, bottom) - beyond(left, bottom) - beyond(right, top) + beyond(left, top);
        let [along_left, along_right] = [left, right].map(|edge| chord(edge, top, bottom));
        let [along_top, along_bottom] = [top, bottom].map(|edge| chord(edge, left, right));
        let edges = right * along_right - left * along_left + bottom * along_bottom - top * along_top;
        let whole = (right - left) * (bottom - top);
        let slopes =
            [(along_left - along_right) / radius, (along_top - along_bottom) / radius, 2.0 * area - edges];
        (area / whole, slopes.map(|slope| slope / whole))
    }
}

/// Length of the line at the distance `at` from the middle of the unit disc, within the disc and from `low` to `high`.
fn chord(at: f64, low: f64, high: f64) -> f64 {
    let half = (1.0 - at * at).max(0.0).sqrt();
    (high.min(half) - low.max(-half)).max(0.0)
}

/// Area of the unit disc before x and before y.
fn beyond(x: f64, y: f64) -> f64 {
    let (x, y) = (x.clamp(-1.0, 1.0), y.clamp(-1.0, 1.0));
    // The line at y ends at +-half. Between, the area reaches up to it, and outside of it to the rim, if at all.
    let half = (1.0 - y * y).sqrt();
    let inside = x.clamp(-half, half);
    let between = y * (inside + half) + rim(inside) - rim(-half);
    let outside = rim(x.min(-half)) - rim(-1.0) + rim(x.max(half)) - rim(half);
    if y < 0.0 { between } else { between + 2.0 * outside }
}

/// Integral of the height of the rim, `sqrt(1 - x^2)`, from 0.
fn rim(x: f64) -> f64 {
    0.5 * (x * (1.0 - x * x).max(0.0).sqrt() + x.asin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cell(x: [f64; 2], y: [f64; 2]) -> Cell {
        Cell { x, y, luminance: 0.0 }
    }

    /// Pixels of the side 1 around the origin, which a disc covers.
    fn pixels(disc: [f64; 3], levels: [f64; 2]) -> Vec<Cell> {
        let edges = |i: i32| [f64::from(i) - 0.5, f64::from(i) + 0.5];
        let places = (-4..=4).flat_map(|y| (-4..=4).map(move |x| (x, y)));
        let cells = places.map(|(x, y)| cell(edges(x), edges(y)));
        cells.map(|cell| Cell { luminance: levels[1] + levels[0] * cell.share(disc).0, ..cell }).collect()
    }

    proptest! {
        /// The share by counting points, and its derivatives by differences.
        #[test]
        fn a_share_is_the_part_of_the_pixel_within_the_disc(
            x in -1.5..1.5_f64, y in -1.5..1.5_f64, log_radius in -1.0..1.0_f64,
        ) {
            const POINTS: i32 = 200;
            let cell = cell([-0.4, 0.6], [-0.3, 0.5]);
            let (share, slopes) = cell.share([x, y, log_radius]);
            let within = |i: i32| {
                let at = |[low, high]: [f64; 2], k: i32| low + (high - low) * (f64::from(k) + 0.5) / f64::from(POINTS);
                let (px, py) = (at(cell.x, i % POINTS), at(cell.y, i / POINTS));
                (px - x).hypot(py - y) < log_radius.exp()
            };
            let count = (0..POINTS * POINTS).filter(|&i| within(i)).count();
            prop_assert!((share - count as f64 / f64::from(POINTS * POINTS)).abs() < 0.01);
            for (i, slope) in slopes.into_iter().enumerate() {
                let moved = |by: f64| {
                    let mut at = [x, y, log_radius];
                    at[i] += by;
                    cell.share(at).0
                };
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                prop_assert!((slope - difference).abs() < 0.01, "{i}: {slope} {difference}");
            }
        }

        /// Two pixels wide and more, it reaches into three rows or columns wherever it stands.
        #[test]
        fn a_disc_is_found_by_the_pixels_that_it_covers(
            x in -0.5..0.5_f64, y in -0.5..0.5_f64, radius in 1.0..2.0_f64, start in 0.8..1.25_f64, behind in 0.0..0.2_f64,
        ) {
            let cells = pixels([x, y, radius.ln()], [10.0, behind]);
            let fit = Fit::of(&cells, start * radius);
            let found = fit.map_or(0.0, |fit| fit.radius());
            prop_assert!((found / radius - 1.0).abs() < 0.03, "{found} {radius}");
        }

        /// Four pixels about a corner are as bright under a smaller disc nearer to it.
        #[test]
        fn a_disc_within_two_rows_and_columns_has_any_radius(x in 0.35..0.65_f64, y in 0.35..0.65_f64, scale in 0.3..1.0_f64) {
            let radius = 0.8_f64;
            let smaller = [0.5 + scale * (x - 0.5), 0.5 + scale * (y - 0.5), (scale * radius).ln()];
            let one = pixels([x, y, radius.ln()], [1.0, 0.0]);
            let other = pixels(smaller, [1.0 / (scale * scale), 0.0]);
            for (one, other) in one.iter().zip(&other) {
                prop_assert!((one.luminance - other.luminance).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn no_disc_explains_a_line_of_pixels_or_none() {
        let line = pixels([0.0, 0.0, 1.0], [1.0, 0.0]).into_iter().map(|cell| Cell {
            luminance: if cell.y[0] < 0.0 && cell.y[1] > 0.0 { 1.0 } else { 0.0 },
            ..cell
        });
        assert!(Fit::of(&line.collect::<Vec<_>>(), 1.0).is_none());
        assert!(Fit::of(&pixels([0.0, 0.0, 0.0], [0.0, 1.0]), 1.0).is_none());
        assert!(Fit::of(&[], 1.0).is_none());
    }
}
