//! Window bars: panes that only narrow dark bars divide are joined to one light, such as those of a glass roof.
//!
//! [`super::bridging`] joins across gaps that no light has. A wider gap is either a bar, or the dark between two lamps
//! of a row; its width, compared with the segments that it divides, decides. Panes face each other along their sides,
//! over a narrow bar. Lamps face each other at a point, or over a gap as wide as they are. Two segments of the solid
//! angles `W` face each other along a length `l`, over a gap of the mean width `g`. They are panes of one window if
//!
//! ```text
//!   g <= 0.5 sqrt(d_1 d_2),   d = min(W / l, sqrt W)      narrow compared with the depths of the panes
//!   g <= 2.5 degrees                                      a wider gap is a wall
//!   l >= g / 2,   l >= sqrt(W) / 4 of the smaller         they face each other along a side
//!   mean luminances within a factor of 4                  one source lies behind both
//!   that of the gap is at most 0.8 of either              a bar is dark: between two clouds lies a pale sky
//! ```
//!
//! Lights that touch are never panes: a saddle divides them, not a bar. Prominence and the necks of a clipped region
//! decide about saddles.
//!
//! The lights are joined after they are measured, because moments add up: a joined light holds all flux of its panes.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::adjacency::Adjacency;
use super::components::Segments;
use super::forest::{self, root};
use super::light_moments::LightMoments;
use super::merge::{self, Selection};
use super::working_image::WorkingImage;
use crate::interrupt;

/// Settings of the window rule.
pub struct BarSettings {
    /// Largest width of a bar over the geometric mean of the depths of its two panes.
    pub widest: f64,
    /// Largest width of a bar, in radians: a wider gap is a wall.
    pub widest_angle: f64,
    /// Least length along which panes face each other, in widths of the bar.
    least_length: f64,
    /// Least length along which panes face each other, over the side of the smaller one.
    least_side: f64,
    /// Largest ratio of the mean luminances of two panes.
    max_pane_ratio: f64,
    /// Largest ratio of the mean luminance of a bar to that of the dimmer pane. Without it, the sky between two clipped
    /// clouds is a bar: all panes of a clipped map are alike, and the sky is little darker.
    max_bar_ratio: f64,
}

/// Settings of the window rule.
pub const BARS: BarSettings = BarSettings {
    widest: 0.5,
    widest_angle: PI / 72.0,
    least_length: 0.5,
    least_side: 0.25,
    max_pane_ratio: 4.0,
    max_bar_ratio: 0.8,
};

/// Lights after panes were joined.
pub struct WindowLights {
    /// Lights of one window or of one segment each.
    pub lights: Vec<LightMoments>,
    /// For each light, the luminance of its local background: the least one of its panes.
    pub backgrounds: Vec<f64>,
    /// For each measured light, the one that it is part of.
    pub part_of: Vec<usize>,
}

/// Gap between two segments that face each other, along the rows and along the columns.
#[derive(Default)]
struct Facing {
    /// Lengths across the rows and across the columns, in radians.
    lengths: [f64; 2],
    /// Solid angles of the gap between.
    gaps: [f64; 2],
    /// Integral of the luminance over both of them.
    flux: f64,
    /// True if the segments touch somewhere.
    touch: bool,
}

impl Facing {
    /// Length of the bar, which is oblique to rows and columns.
    fn length(&self) -> f64 {
        self.lengths[0].hypot(self.lengths[1])
    }

    /// Width of the bar.
    ///
    /// At the angle a to the columns, the views along rows and along columns measure its solid angle `g L` over the
    /// lengths `L cos a` and `L sin a`. The width is the mean of both, weighted by the squares of these lengths.
    fn width(&self) -> f64 {
        let [rows, columns] = [0, 1].map(|view| self.gaps[view] * self.lengths[view].powi(2));
        (rows + columns) / self.length().powi(3)
    }

    /// Mean luminance of the gap.
    fn luminance(&self) -> f64 {
        self.flux / (self.gaps[0] + self.gaps[1])
    }

    fn add(&mut self, view: usize, length: f64, width: f64, luminance: f64) {
        self.lengths[view] += length;
        self.gaps[view] += length * width;
        self.flux += length * width * luminance;
        self.touch |= width == 0.0;
    }
}

/// Join the lights that are panes of one window; none if `gap` is 0.
pub fn join(
    working: &WorkingImage,
    adjacency: &Adjacency,
    segments: &Segments,
    outline: &[u32],
    gap: f64,
    lights: Vec<LightMoments>,
    backgrounds: Vec<f64>,
) -> WindowLights {
    let mut parent = forest::singletons(lights.len());
    if lights.len() > 1 && gap > 0.0 {
        for ((one, other), facing) in facing(working, adjacency, segments, outline, &lights) {
            if are_panes(&lights[one as usize], &lights[other as usize], &facing) {
                forest::join(&mut parent, one, other);
            }
        }
    }
    WindowLights::of(lights, backgrounds, &mut parent)
}

/// True if the gap between two lights is a window bar.
fn are_panes(one: &LightMoments, other: &LightMoments, facing: &Facing) -> bool {
    if facing.touch {
        return false;
    }
    let (width, length) = (facing.width(), facing.length());
    let side = one.solid_angle().min(other.solid_angle()).sqrt();
    let depth = |light: &LightMoments| (light.solid_angle() / length).min(light.solid_angle().sqrt());
    let mean = |light: &LightMoments| light.flux / light.solid_angle();
    let (dimmer, brighter) = (mean(one).min(mean(other)), mean(one).max(mean(other)));
    width <= BARS.widest * (depth(one) * depth(other)).sqrt()
        && width <= BARS.widest_angle
        && length >= (BARS.least_length * width).max(BARS.least_side * side)
        && brighter <= BARS.max_pane_ratio * dimmer
        && facing.luminance() <= BARS.max_bar_ratio * dimmer
}

/// Find the pairs of segments that face each other to the right or downwards.
///
/// A sorted map makes the order of the joins the same in every run.
fn facing(
    working: &WorkingImage,
    adjacency: &Adjacency,
    segments: &Segments,
    outline: &[u32],
    lights: &[LightMoments],
) -> BTreeMap<(u32, u32), Facing> {
    let (height, width) = working.size;
    let (reaches, pixel_height) = (reaches(lights), working.row_height());
    let mut pairs: BTreeMap<(u32, u32), Facing> = BTreeMap::new();
    for index in outline.iter().map(|&index| index as usize) {
        interrupt::check();
        let own = segments.label[index];
        let (row, column) = (index / width, index % width);
        let [_, right, _, down] = adjacency.sides(index);
        let reach = reaches[own as usize - 1];
        // Find the width of the pixel, and the number of pixels within reach.
        let pixel_width = working.bands[row] * TAU / width as f64 / pixel_height;
        let on_the_right = ((reach / pixel_width) as usize + 1).min(width / 2);
        let below = ((reach / pixel_height) as usize + 1).min(height - 1 - row);
        // Look along the row and along the column for another segment.
        let mut look = |view: usize, met: Option<Gap>, length: f64, step: f64| {
            if let Some(gap) = met.filter(|gap| gap.label != own) {
                let pair = (own.min(gap.label) - 1, own.max(gap.label) - 1);
                pairs.entry(pair).or_default().add(view, length, step * gap.pixels as f64, gap.luminance);
            }
        };
        if segments.label[right] != own {
            let pixels = (1..=on_the_right).map(|k| row * width + (column + k) % width);
            look(0, Gap::along(working, segments, pixels), pixel_height, pixel_width);
        }
        if segments.label[down] != own {
            let pixels = (1..=below).map(|k| index + k * width);
            look(1, Gap::along(working, segments, pixels), pixel_width, pixel_height);
        }
    }
    pairs
}

/// Unlabelled pixels before the first labelled one.
struct Gap {
    pixels: usize,
    /// Their mean; 0 without any.
    luminance: f64,
    /// Label of the pixel behind the gap.
    label: u32,
}

impl Gap {
    /// The gap along these `pixels`, if one of them has a label.
    fn along(
        working: &WorkingImage,
        segments: &Segments,
        pixels: impl Iterator<Item = usize>,
    ) -> Option<Self> {
        let mut sum = 0.0;
        for (count, pixel) in pixels.enumerate() {
            let label = segments.label[pixel];
            if label != 0 {
                return Some(Self { pixels: count, luminance: sum / count.max(1) as f64, label });
            }
            sum += f64::from(working.luminance[pixel]);
        }
        None
    }
}

/// Distance from each light within which facing panes are sought: twice the widest bar to the largest light.
fn reaches(lights: &[LightMoments]) -> Vec<f64> {
    let sides: Vec<f64> = lights.iter().map(|light| light.solid_angle().sqrt()).collect();
    let largest = sides.iter().copied().fold(0.0, f64::max);
    // One ray through a curved gap may be longer than the mean: look as far as twice the widest bar.
    sides.iter().map(|side| 2.0 * (BARS.widest * (side * largest).sqrt()).min(BARS.widest_angle)).collect()
}

impl WindowLights {
    /// Select at most `most` of the listed lights, and count the panes of each.
    pub fn select(
        self,
        is_listed: impl Fn(&LightMoments, f64) -> bool,
        most: usize,
    ) -> (Selection, Vec<usize>) {
        let listed: Vec<bool> = self
            .lights
            .iter()
            .zip(&self.backgrounds)
            .map(|(light, &behind)| is_listed(light, behind))
            .collect();
        let Self { lights, part_of, .. } = self;
        let selection = merge::select(lights, &listed, most);
        let panes = panes(&part_of, &selection);
        let part_of = part_of.iter().map(|&window| selection.part_of[window]).collect();
        (Selection { part_of, ..selection }, panes)
    }

    /// Join the lights of each tree of `parent`.
    fn of(lights: Vec<LightMoments>, backgrounds: Vec<f64>, parent: &mut [u32]) -> Self {
        let mut windows = Self { lights: Vec::new(), backgrounds: Vec::new(), part_of: Vec::new() };
        for ((i, light), background) in (0..).zip(lights).zip(backgrounds) {
            let first = root(parent, i);
            if first == i {
                windows.part_of.push(windows.lights.len());
                windows.lights.push(light);
                windows.backgrounds.push(background);
            } else {
                // The first light of a tree comes before the others.
                let whole = windows.part_of[first as usize];
                windows.part_of.push(whole);
                windows.lights[whole] = windows.lights[whole].and(&light);
                windows.backgrounds[whole] = windows.backgrounds[whole].min(background);
            }
        }
        windows
    }
}

/// Number of panes that each selected light was joined from; 0 for a light without panes.
///
/// `part_of` holds the window of each segment.
fn panes(part_of: &[usize], selection: &Selection) -> Vec<usize> {
    // Count the segments of each window.
    let mut segments = vec![0; selection.part_of.len()];
    for &window in part_of {
        segments[window] += 1;
    }
    // Add up those of windows with bars: lights may have been merged since.
    let mut panes = vec![0; selection.lights.len()];
    for (&segments, light) in segments.iter().zip(&selection.part_of) {
        if let Some(light) = light.filter(|_| segments > 1) {
            panes[light] += segments;
        }
    }
    panes
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::background::local_backgrounds;
    use super::super::measure::measure;
    use super::super::outline;
    use super::super::test_maps::{map_of, segments};
    use super::*;
    use crate::kernels::sphere::Registration;

    /// Lights before and after the join, of a drawing of 128 x 256 pixels of 1.4 degrees with these `rows` in the middle.
    ///
    /// A light ends at the fraction `extent` of its peak.
    fn before_and_after(rows: &[&str], extent: f64) -> (Vec<LightMoments>, WindowLights) {
        let dark = ".".repeat(256);
        let mut all = vec![dark; 128];
        for (row, pixels) in all[60..].iter_mut().zip(rows) {
            row.replace_range(80..80 + pixels.len(), pixels);
        }
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        let map = map_of(&all);
        let working = WorkingImage::of(map.view(), Registration::CellCentred, 256).unwrap();
        let adjacency = Adjacency::of(&working);
        let segments = outline::trim(&adjacency, segments(&working, extent));
        let outline = outline::outline(&adjacency, &segments);
        let backgrounds = local_backgrounds(map.view(), &working, &adjacency, &segments, &outline);
        let lights = measure(map.view(), Registration::CellCentred, &working, &segments, &backgrounds);
        let backgrounds = backgrounds.iter().map(|background| background.luminance).collect();
        (lights.clone(), join(&working, &adjacency, &segments, &outline, 0.01, lights, backgrounds))
    }

    fn lights_of(rows: &[&str]) -> usize {
        before_and_after(rows, 0.5).1.lights.len()
    }

    #[test]
    fn panes_behind_a_narrow_bar_are_one_light_with_all_their_flux() {
        let (panes, window) = before_and_after(&["8888.8888.8888"; 3], 0.5);
        assert_eq!((panes.len(), window.lights.len()), (3, 1));
        let flux: f64 = panes.iter().map(|pane| pane.flux).sum();
        assert!((window.lights[0].flux - flux).abs() < 1e-12 * flux, "{flux}");
        assert_eq!(window.part_of, [0, 0, 0]);
    }

    #[test]
    fn lamps_as_far_apart_as_they_are_broad_stay_apart() {
        assert_eq!(lights_of(&["8.8.8.8"; 3]), 4); // tubes
        assert_eq!(lights_of(&["8.8", "...", "8.8"]), 4);
    }

    /// The bridge between the lamps is above the edge of both: they meet halfway, without a bar.
    #[test]
    fn lamps_on_a_bridge_stay_apart_as_prominence_says() {
        let bridge = ["9999222222229999"; 6];
        assert_eq!(before_and_after(&bridge, 0.0).1.lights.len(), 2);
    }

    #[test]
    fn a_lamp_beside_a_window_of_another_luminance_stays_apart() {
        assert_eq!(lights_of(&["9999.2222", "9999.2222", "9999.2222"]), 2);
        assert_eq!(lights_of(&["9999.4444", "9999.4444", "9999.4444"]), 1);
    }

    /// Panes of 4 x 4 pixels at luminance 8, with a bar of 1.4 degrees.
    #[test]
    fn a_bar_is_dark_lies_along_a_side_and_is_nowhere_open() {
        let (panes, _) = before_and_after(&["8888.8888"; 4], 0.5);
        let is_bar = |luminance: f64, length: f64, open: f64| {
            let mut facing = Facing::default();
            facing.add(0, length, 0.0245, luminance);
            if open > 0.0 {
                facing.add(1, open, 0.0, 0.0);
            }
            are_panes(&panes[0], &panes[1], &facing)
        };
        assert!(is_bar(6.3, 0.098, 0.0) && !is_bar(6.5, 0.098, 0.0));
        assert!(is_bar(0.1, 0.026, 0.0) && !is_bar(0.1, 0.023, 0.0));
        assert!(!is_bar(0.1, 0.098, 0.001));
    }

    /// Two pixels are 2.8 degrees.
    #[test]
    fn a_gap_wider_than_2_5_degrees_is_a_wall() {
        assert_eq!(lights_of(&["8888888888..8888888888"; 10]), 2);
        assert_eq!(lights_of(&["8888888888.8888888888"; 10]), 1);
    }

    #[test]
    fn the_width_of_an_oblique_bar_is_measured_across_it() {
        let mut facing = Facing::default();
        let (length, width, angle) = (3.0, 0.2, 0.4_f64);
        facing.add(0, length * angle.cos(), width / angle.cos(), 0.25);
        facing.add(1, length * angle.sin(), width / angle.sin(), 0.75);
        assert!((facing.length() - length).abs() < 1e-12);
        assert!((facing.width() - width).abs() < 1e-12);
        assert!((facing.luminance() - 0.5).abs() < 1e-12);
    }
}
