//! Direction of a clipped light, and its uncertainty.
//!
//! Inside a clipped region the picture holds no detail, but glow is even around a sun: its centre is the centroid of the
//! region, weighted by depth so that spurs count little. Without a clipped region it is the centroid of the squared
//! expanded luminance.

use glam::DVec3;

use super::super::segment::components::Segments;
use super::super::segment::run::{Run, runs};
use super::super::segment::working_image::WorkingImage;
use crate::kernels::image::CellCentres;

/// Pixels below this fraction of the largest depth do not count: spurs, and a clipped horizon.
const SHALLOW: f32 = 0.5;

/// Direction of a light of a clipped map.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPosition {
    /// Unit vector.
    pub direction: DVec3,
    /// Angle from the deepest point of its plateau to the rim, in radians; 0 without a plateau.
    pub plateau_radius: f64,
    /// Angle in radians that contains the error of two thirds of such lights.
    pub uncertainty: f64,
}

impl LightPosition {
    fn new(direction: DVec3, plateau_radius: f64, radius: f64) -> Self {
        Self { direction, plateau_radius, uncertainty: uncertainty(plateau_radius, radius) }
    }

    /// Position of two lights joined to one that points to `direction`.
    #[must_use]
    pub fn and(&self, other: &Self, direction: DVec3) -> Self {
        let apart = |position: &Self| position.direction.angle_between(direction);
        Self {
            direction,
            plateau_radius: self.plateau_radius.max(other.plateau_radius),
            uncertainty: self.uncertainty.max(other.uncertainty).max(apart(self)).max(apart(other)),
        }
    }
}

/// Angle that contains the error of two thirds of all lights with the radius r and a plateau of the radius R:
///
/// ```text
///   u = max(0.7 (R + 0.5 degrees), 0.3 r)
/// ```
///
/// Calibrated on pictures of HDR maps, whose lights are known, by classes of R.
fn uncertainty(plateau_radius: f64, radius: f64) -> f64 {
    (0.7 * (plateau_radius + 0.5_f64.to_radians())).max(0.3 * radius)
}

/// Position of each segment. `depth` is that of the clipped region, as an image.
pub fn positions(
    working: &WorkingImage,
    expanded: &WorkingImage,
    segments: &Segments,
    depth: &[f32],
) -> Vec<LightPosition> {
    let sphere = CellCentres::new(&working.grid);
    let width = working.size.1;
    let position = |pixels: &Vec<u32>| {
        let runs = runs(pixels, width);
        let labelled = |run: &Run| run.pixels(width).filter(|&pixel| segments.label[pixel] != 0);
        let deepest = runs.iter().flat_map(labelled).map(|pixel| depth[pixel]).fold(0.0, f32::max);
        let (mut on_plateau, mut outside, mut solid_angle) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for run in &runs {
            let band = working.bands[run.row];
            for pixel in labelled(run) {
                let towards = sphere.at(run.row, pixel - run.row * width) * band;
                if depth[pixel] >= SHALLOW * deepest {
                    on_plateau += towards * f64::from(depth[pixel]).powi(2);
                }
                outside += towards * f64::from(expanded.luminance[pixel]).powi(2);
                solid_angle += band;
            }
        }
        let sum = if deepest > 0.0 { on_plateau } else { outside };
        // The rim lies between the last pixel of the plateau and the first outside of it.
        let rim = 0.5 * working.row_height();
        let radius = (1.0 - solid_angle / width as f64).max(-1.0).acos();
        LightPosition::new(sum.normalize_or(DVec3::Y), (f64::from(deepest) - rim).max(0.0), radius)
    };
    segments.pixels.iter().map(position).collect()
}
