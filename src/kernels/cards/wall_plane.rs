//! A map in the plane of an upright wall, with the contrast along all lines that are level or plumb there.

use std::f64::consts::{FRAC_PI_2, LN_2};

use glam::{DMat3, DVec2, DVec3};

use super::footprint::RemovedRadiance;

/// Cells on each side of a line whose means are compared.
const STRIP: usize = 3;
/// Share of the flux on each side of the extent of a light.
const TAIL: f64 = 0.02;
/// Least cosine between the normal of a wall and a direction to it.
const LEAST_COSINE: f64 = 0.2;
/// Luminance below which nothing contrasts, relative to that of the light.
const DARKEST: f64 = 1e-3;

/// Directions of a light with the flux of each, and its luminance.
pub struct LightSamples {
    pub samples: Vec<(DVec3, f64)>,
    pub luminance: f64,
}

/// Rectangle along the axes of a wall: left, right, bottom, top.
pub type Sides = [f64; 4];

/// Luminance of a map in the plane of a wall, in cells.
pub struct WallPlane {
    low: DVec2,
    cell: f64,
    /// Columns and rows.
    size: [usize; 2],
    /// Contrast over the left, right, bottom and top side of a bright rectangle.
    contrasts: [LineContrasts; 4],
    /// Flux left of and below the corner of each cell.
    flux: Vec<f64>,
    /// Left, right, bottom and top of the light, in cells.
    pub extent: [usize; 4],
}

/// Axes of the wall in a direction: to the right, up, and to the wall.
pub fn wall_frame(azimuth: f64) -> DMat3 {
    let towards = crate::kernels::sphere::direction(FRAC_PI_2, azimuth);
    DMat3::from_cols(towards.cross(DVec3::Y), DVec3::Y, towards)
}

impl WallPlane {
    /// Plane around a light; none if the wall is too oblique for it.
    ///
    /// At most `cells` lie along the longer side of the light, and as many on each side of it.
    pub fn new(
        removed: &RemovedRadiance<'_>,
        light: &LightSamples,
        azimuth: f64,
        cells: f64,
    ) -> Option<Self> {
        let places = places(light, azimuth)?;
        let [left, right] = extent(&places, |place| place.x);
        let [bottom, top] = extent(&places, |place| place.y);
        let span = DVec2::new(right - left, top - bottom);
        // Cells of less than half a pixel show no more.
        let cell = (span.max_element() / cells).max(0.5 * removed.pixels.step());
        let low = DVec2::new(left, bottom) - span.max_element();
        let size =
            ((span + 2.0 * span.max_element()) / cell).ceil().to_array().map(|cells| cells as usize + 1);
        if span.min_element() < 4.0 * cell {
            return None;
        }
        let logs = logs(removed, light.luminance, azimuth, low, cell, size);
        let [columns, rows] = size;
        let [left_sides, right_sides] = line_contrasts(columns, rows, |i, j| logs[j * columns + i]);
        let [bottoms, tops] = line_contrasts(rows, columns, |i, j| logs[i * columns + j]);
        let line = |at: f64, low: f64| ((at - low) / cell).round() as usize;
        Some(Self {
            low,
            cell,
            size,
            contrasts: [left_sides, right_sides, bottoms, tops],
            flux: flux_sums(&places, low, cell, size),
            extent: [line(left, low.x), line(right, low.x), line(bottom, low.y), line(top, low.y)],
        })
    }

    /// Lines of a side on which contrast is largest, near the side of the light.
    pub fn candidates(&self, side: usize, most: usize) -> Vec<usize> {
        let across = if side < 2 { [2, 3] } else { [0, 1] };
        let [from, to] = across.map(|i| self.extent[i]);
        let [left, right, bottom, top] = self.extent;
        let span = (right - left).max(top - bottom);
        let last = self.size[side / 2] - STRIP - 1;
        let near =
            self.extent[side].saturating_sub(span).max(STRIP + 1)..(self.extent[side] + span).min(last);
        let contrast = |line: usize| self.contrasts[side].mean(line, from, to);
        let is_peak = |line: &usize| {
            let own = contrast(*line);
            own > 0.0 && own >= contrast(line - 1) && own >= contrast(line + 1)
        };
        let mut lines: Vec<usize> = near.filter(is_peak).collect();
        lines.sort_by(|a, b| contrast(*b).total_cmp(&contrast(*a)));
        lines.truncate(most);
        lines
    }

    /// Mean contrast of the side of a rectangle of lines.
    pub fn contrast(&self, side: usize, [left, right, bottom, top]: [usize; 4]) -> f64 {
        let [line, from, to] = match side {
            0 => [left, bottom, top],
            1 => [right, bottom, top],
            2 => [bottom, left, right],
            _ => [top, left, right],
        };
        self.contrasts[side].mean(line, from, to)
    }

    /// Share of the flux of the light in a rectangle of lines.
    pub fn share(&self, [left, right, bottom, top]: [usize; 4]) -> f64 {
        let sum = |column: usize, row: usize| self.flux[row * (self.size[0] + 1) + column];
        sum(right, top) - sum(left, top) - sum(right, bottom) + sum(left, bottom)
    }

    /// Places of the lines of a rectangle.
    pub fn sides(&self, lines: [usize; 4]) -> Sides {
        std::array::from_fn(|side| self.low[side / 2] + self.cell * lines[side] as f64)
    }
}

/// Places of a light in the plane, each with its share of the flux; none if too much is oblique or behind.
fn places(light: &LightSamples, azimuth: f64) -> Option<Vec<(DVec2, f64)>> {
    let to_plane = wall_frame(azimuth).transpose();
    let total: f64 = light.samples.iter().map(|(_, flux)| flux).sum();
    let local = light.samples.iter().map(|(direction, flux)| (to_plane * *direction, flux / total));
    let places = local.filter(|(local, _)| local.z > LEAST_COSINE);
    let places: Vec<_> = places.map(|(local, share)| (local.truncate() / local.z, share)).collect();
    (places.iter().map(|(_, share)| share).sum::<f64>() >= 1.0 - TAIL).then_some(places)
}

/// Interval that leaves the tails of the flux out.
fn extent(places: &[(DVec2, f64)], axis: impl Fn(DVec2) -> f64) -> [f64; 2] {
    let mut along: Vec<(f64, f64)> = places.iter().map(|&(place, flux)| (axis(place), flux)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = along.iter().map(|(_, flux)| flux).sum();
    let at = |part: f64| {
        let mut sum = 0.0;
        let found = along.iter().find(|(_, flux)| {
            sum += flux;
            sum >= part * total
        });
        found.map_or(0.0, |(at, _)| *at)
    };
    [at(TAIL), at(1.0 - TAIL)]
}

/// Logarithm of the luminance of the pixel at the middle of each cell, above the darkest.
fn logs(
    removed: &RemovedRadiance<'_>,
    light: f64,
    azimuth: f64,
    low: DVec2,
    cell: f64,
    [columns, rows]: [usize; 2],
) -> Vec<f64> {
    let middle = |i: usize, low: f64| low + cell * (i as f64 + 0.5);
    // A plumb line is a meridian.
    let meridian = |column: usize| {
        let x = middle(column, low.x);
        (removed.pixels.column(azimuth + x.atan()), (1.0 + x * x).sqrt().recip())
    };
    let meridians: Vec<(usize, f64)> = (0..columns).map(meridian).collect();
    let cells =
        (0..rows).flat_map(|row| meridians.iter().map(move |meridian| (middle(row, low.y), meridian)));
    cells
        .map(|(y, (column, cosine))| {
            let pixel = removed.pixels.row(FRAC_PI_2 - (y * cosine).atan()) * removed.pixels.width + column;
            (removed.luminance(pixel) + DARKEST * light).ln()
        })
        .collect()
}

/// Luminance of the map in a direction of any length.
pub fn luminance(removed: &RemovedRadiance<'_>, towards: DVec3) -> f64 {
    let around = removed.pixels.around(towards.normalize());
    around.into_iter().map(|(pixel, weight)| weight * removed.luminance(pixel)).sum()
}

/// Sums of the shares of flux over all cells left of and below each corner.
fn flux_sums(places: &[(DVec2, f64)], low: DVec2, cell: f64, [columns, rows]: [usize; 2]) -> Vec<f64> {
    let width = columns + 1;
    let mut sums = vec![0.0; width * (rows + 1)];
    for &(place, share) in places {
        let at = (place - low) / cell;
        if at.min_element() >= 0.0 && at.x < columns as f64 && at.y < rows as f64 {
            sums[(at.y as usize + 1) * width + at.x as usize + 1] += share;
        }
    }
    for row in 1..=rows {
        for column in 1..width {
            sums[row * width + column] += sums[row * width + column - 1];
        }
        for column in 0..width {
            sums[row * width + column] += sums[(row - 1) * width + column];
        }
    }
    sums
}

/// Sums of the contrast along lines, from their starts.
struct LineContrasts {
    stride: usize,
    sums: Vec<f64>,
}

impl LineContrasts {
    fn mean(&self, line: usize, from: usize, to: usize) -> f64 {
        let start = line * self.stride;
        (self.sums[start + to] - self.sums[start + from]) / to.abs_diff(from).max(1) as f64
    }
}

/// Contrasts of lines between cells that are brighter after the line, and of those that are brighter before it.
///
/// A contrast is 1 where one side is twice as bright as the other, and at least -1/2.
fn line_contrasts(lines: usize, cells: usize, log: impl Fn(usize, usize) -> f64) -> [LineContrasts; 2] {
    let stride = cells + 1;
    let mut sums = [0, 1].map(|_| vec![0.0; lines * stride]);
    let mut fronts = vec![0.0; lines + 1];
    for j in 0..cells {
        for i in 0..lines {
            fronts[i + 1] = fronts[i] + log(i, j);
        }
        for line in 0..lines {
            let is_inner = line >= STRIP && line + STRIP <= lines;
            let rise = if is_inner {
                (fronts[line + STRIP] - 2.0 * fronts[line] + fronts[line - STRIP]) / (STRIP as f64 * LN_2)
            } else {
                0.0
            };
            for (sums, rise) in sums.iter_mut().zip([rise, -rise]) {
                sums[line * stride + j + 1] = sums[line * stride + j] + rise.clamp(-0.5, 1.0);
            }
        }
    }
    sums.map(|sums| LineContrasts { stride, sums })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_at_a_step_of_a_factor_of_two_has_a_contrast_of_one() {
        let log = |i: usize, _: usize| if i < 10 { 0.0 } else { LN_2 };
        let [rising, falling] = line_contrasts(20, 8, log);
        assert!((rising.mean(10, 0, 8) - 1.0).abs() < 1e-12);
        assert!((rising.mean(10, 3, 5) - 1.0).abs() < 1e-12);
        assert!((falling.mean(10, 0, 8) + 0.5).abs() < 1e-12);
        assert!(rising.mean(5, 0, 8).abs() < 1e-12);
    }

    #[test]
    fn axes_of_a_wall_are_right_up_and_towards_it() {
        let frame = wall_frame(0.7);
        assert!((frame.z_axis.cross(DVec3::Y) - frame.x_axis).length() < 1e-12);
        // The middle column of a map is at an azimuth of half a turn, and columns to the right have larger ones.
        let right = wall_frame(std::f64::consts::PI).x_axis;
        let next = crate::kernels::sphere::direction(std::f64::consts::FRAC_PI_2, std::f64::consts::PI + 0.1);
        assert!(right.dot(next) > 0.0);
    }

    #[test]
    fn sums_of_flux_hold_what_lies_in_a_rectangle() {
        let places = [(DVec2::new(0.5, 0.5), 0.25), (DVec2::new(2.5, 1.5), 0.75)];
        let sums = flux_sums(&places, DVec2::ZERO, 1.0, [4, 3]);
        let seen = [sums[6], sums[2 * 5 + 3], sums[3 * 5 + 4], sums[5 + 4]];
        assert!(seen.iter().zip([0.25, 1.0, 1.0, 0.25]).all(|(sum, wanted)| (sum - wanted).abs() < 1e-12));
    }
}
