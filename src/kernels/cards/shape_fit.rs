//! Shape of a light: rectangle, tube, disc, point or other.
//!
//! At each of five levels, a rectangle and an ellipse are fitted to the pixels above the level. The level of the best
//! overlap tells the outline. The shapes are then fitted again to the parts of pixels between the luminance outside
//! and inside of that outline, which places an edge within a fraction of a pixel.

use std::f64::consts::FRAC_PI_8;

use glam::{DMat3, DVec2};

use super::card_matrix::{matrix_of_corners, reach};
use super::footprint::{FARTHEST, Footprint, PlaneSample};
use super::least_squares::minimise;
use super::soft_shapes::{Ellipse, Quadrilateral, SoftRectangle, SoftShape, rectangle_corners};

/// Levels of the outline, relative to the reference luminance.
const LEVELS: [f64; 5] = [0.03, 0.06, 0.12, 0.25, 0.5];
/// Covered pixels below which a light is a point.
const POINT_PIXELS: f64 = 12.0;
/// Overlap of the best shape below which a light is other. True shapes reach 0.87 to 0.99.
const LEAST_OVERLAP: f64 = 0.7;
/// Aspect above which a rectangle is a tube.
const TUBE_ASPECT: f64 = 6.0;
/// Relative cost below which a free quadrilateral replaces a rectangle.
const QUADRILATERAL_COST: f64 = 0.8;
/// Overlap by which a quadrilateral must exceed an ellipse: four free corners follow a disc better than a rectangle.
const QUADRILATERAL_MARGIN: f64 = 0.02;

/// Pixels at most for the choice of the level; the last fit uses all.
const LEVEL_SAMPLES: usize = 3000;

/// Largest change of centre and half sizes by the last fit, in pixels: more is another shape, such as the hot middle of a lamp.
const LARGEST_MOVE: f64 = 2.0;

/// Name of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Rectangle,
    Tube,
    Disc,
    Point,
    Other,
}

/// Shape of a light, with its matrix and overlap.
#[derive(Clone, Debug)]
pub struct FittedShape {
    pub shape: Shape,
    pub matrix: DMat3,
    /// Intersection over union of light and shape.
    pub overlap: f64,
    /// Luminance inside.
    pub inner: f64,
    /// True for a window that edges of the map show; its overlap is the contrast of its sides.
    pub is_window: bool,
}

/// Rectangle and ellipse of one footprint.
struct Fit {
    rectangle: [f64; 5],
    rectangle_cost: f64,
    rectangle_overlap: f64,
    ellipse: [f64; 5],
    ellipse_overlap: f64,
    covered: f64,
}

/// Shape of a light; none for a light without radiance.
pub fn fit(footprint: &Footprint) -> Option<FittedShape> {
    let thin = footprint.every_nth(LEVEL_SAMPLES);
    let (outline, level) = best_level(&thin)?;
    let (outer, inner) = levels_around(footprint, &outline);
    let parts = footprint.coverage(outer, inner);
    let starts = [outline.rectangle, outline.ellipse];
    let refined = fit_shapes(footprint, &parts, Some(starts))
        .filter(|fit| fit.best() >= LEAST_OVERLAP && fit.distance(&outline) < LARGEST_MOVE * footprint.step);
    let (fit, parts) = match refined {
        Some(fit) => (fit, parts),
        None => (outline, footprint.coverage(0.5 * level, 1.5 * level)),
    };
    name(footprint, &fit, &parts, inner).map(within_reach)
}

/// The shape, or "other" for a matrix that reaches beyond the search: its far side may face away from its centre.
fn within_reach(fitted: FittedShape) -> FittedShape {
    let is_within = reach(&fitted.matrix) < FARTHEST;
    FittedShape { shape: if is_within { fitted.shape } else { Shape::Other }, ..fitted }
}

/// Fit of the level whose shape overlaps best and holds most of the flux, and the luminance of that level.
fn best_level(footprint: &Footprint) -> Option<(Fit, f64)> {
    let mut best: Option<(f64, Fit, f64)> = None;
    let total = footprint.sum(&vec![1.0; footprint.samples.len()], |sample| sample.luminance);
    for level in LEVELS {
        let middle = level * footprint.reference;
        let parts = footprint.coverage(0.5 * middle, 1.5 * middle);
        let Some(fit) = fit_shapes(footprint, &parts, None) else { continue };
        let inside = values(footprint, &*fit.shape_grown(0.0));
        let share = footprint.sum(&inside, |sample| sample.luminance) / total;
        let score = fit.best() * share.powf(0.25);
        if best.as_ref().is_none_or(|(other, ..)| score > *other) {
            best = Some((score, fit, middle));
        }
    }
    best.map(|(_, fit, level)| (fit, level))
}

impl Fit {
    fn best(&self) -> f64 {
        self.rectangle_overlap.max(self.ellipse_overlap)
    }

    /// Centre and half sizes of the shape of the larger overlap.
    fn place(&self) -> [f64; 4] {
        let [x, y, a, b, _] =
            if self.ellipse_overlap > self.rectangle_overlap { self.ellipse } else { self.rectangle };
        [x, y, a.abs(), b.abs()]
    }

    /// Largest difference of centre and half sizes to those of another fit.
    fn distance(&self, other: &Fit) -> f64 {
        self.place().iter().zip(other.place()).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
    }

    /// Rectangle or ellipse, whichever fits better, enlarged by `grow` on all sides.
    fn shape_grown(&self, grow: f64) -> Box<dyn SoftShape<5>> {
        let larger = |&[x, y, a, b, angle]: &[f64; 5]| [x, y, a + grow, b + grow, angle];
        if self.ellipse_overlap > self.rectangle_overlap {
            Box::new(Ellipse::new(&larger(&self.ellipse)))
        } else {
            Box::new(SoftRectangle::new(&larger(&self.rectangle)))
        }
    }
}

/// Luminance just outside and inside of an outline: medians of a ring of three pixels, and of the inside.
fn levels_around(footprint: &Footprint, fit: &Fit) -> (f64, f64) {
    let step = footprint.step;
    let [own, near, far] = [0.0, step, 3.5 * step].map(|grow| values(footprint, &*fit.shape_grown(grow)));
    let (mut inner, mut outer) = (Vec::new(), Vec::new());
    for (i, sample) in footprint.samples.iter().enumerate() {
        if own[i] > 0.95 {
            inner.push(sample.luminance);
        } else if near[i] == 0.0 && far[i] > 0.5 {
            outer.push(sample.luminance);
        }
    }
    let inner = median(inner).unwrap_or(footprint.reference);
    let outer = median(outer).unwrap_or(0.0);
    (outer.min(0.5 * inner), inner)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().filter(|&value| value > 0.0 || values.len() > 2)
}

/// Covered parts of all samples by a shape.
fn values<const N: usize>(footprint: &Footprint, shape: &dyn SoftShape<N>) -> Vec<f64> {
    footprint.samples.iter().map(|sample| shape.cover(&sample.pixel).0).collect()
}

/// Rectangle and ellipse of covered parts, from the starts or from the moments; none if less than a pixel is covered.
fn fit_shapes(footprint: &Footprint, parts: &[f64], starts: Option<[[f64; 5]; 2]>) -> Option<Fit> {
    let covered: f64 = parts.iter().sum();
    if covered < 1.0 {
        return None;
    }
    let rectangle = |start| descend(footprint, parts, start, SoftRectangle::new);
    let (found, ellipse) = if let Some([box_start, ellipse]) = starts {
        (rectangle(box_start), ellipse)
    } else {
        let moments = moments(footprint, parts);
        let starts = (0..4).map(|turn| moments.start(f64::from(turn) * FRAC_PI_8, 3.0_f64.sqrt()));
        let mut starts: Vec<_> = starts.map(|start| (cost(footprint, parts, &start), start)).collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let best =
            starts.iter().take(2).map(|(_, start)| rectangle(*start)).min_by(|a, b| a.1.total_cmp(&b.1));
        (best?, moments.start(0.0, 2.0))
    };
    let (ellipse, _) = descend(footprint, parts, ellipse, Ellipse::new);
    let ellipse_overlap = overlap(footprint, parts, &Ellipse::new(&ellipse));
    let (rectangle, rectangle_cost) = found;
    let rectangle_overlap = overlap(footprint, parts, &SoftRectangle::new(&rectangle));
    Some(Fit { rectangle, rectangle_cost, rectangle_overlap, ellipse, ellipse_overlap, covered })
}

/// Sum of squares of a rectangle.
fn cost(footprint: &Footprint, parts: &[f64], numbers: &[f64; 5]) -> f64 {
    let covers = values(footprint, &SoftRectangle::new(numbers));
    let square =
        |((sample, part), cover): ((&PlaneSample, &f64), f64)| (cover - part).powi(2) * sample.solid_angle;
    footprint.samples.iter().zip(parts).zip(covers).map(square).sum()
}

/// Numbers of a shape that fit the parts best, from a start, and the sum of squares.
fn descend<const N: usize, S: SoftShape<N>>(
    footprint: &Footprint,
    parts: &[f64],
    start: [f64; N],
    shape: impl Fn(&[f64; N]) -> S,
) -> ([f64; N], f64) {
    minimise(start, |numbers, add| {
        let shape = shape(numbers);
        for (sample, part) in footprint.samples.iter().zip(parts) {
            let (value, derivatives) = shape.cover(&sample.pixel);
            add(sample.solid_angle, value - part, &derivatives);
        }
    })
}

/// Intersection over union of covered parts and a shape, by solid angle.
fn overlap<const N: usize>(footprint: &Footprint, parts: &[f64], shape: &dyn SoftShape<N>) -> f64 {
    let (mut common, mut union) = (0.0, 0.0);
    for ((sample, &part), value) in footprint.samples.iter().zip(parts).zip(values(footprint, shape)) {
        common += part.min(value) * sample.solid_angle;
        union += part.max(value) * sample.solid_angle;
    }
    common / union
}

/// Centre and second moments of covered parts in the plane.
struct PlaneMoments {
    centre: DVec2,
    /// Second moments xx, xy, yy.
    squares: [f64; 3],
    angle: f64,
    least: f64,
}

fn moments(footprint: &Footprint, parts: &[f64]) -> PlaneMoments {
    let area = |sample: &PlaneSample| {
        let place = sample.pixel.place;
        (1.0 + place.length_squared()).powf(1.5)
    };
    let total = footprint.sum(parts, area);
    let mean = |of: &dyn Fn(DVec2) -> f64| {
        footprint.sum(parts, |sample| area(sample) * of(sample.pixel.place)) / total
    };
    let centre = DVec2::new(mean(&|place| place.x), mean(&|place| place.y));
    let squares = [
        mean(&|place| (place.x - centre.x).powi(2)),
        mean(&|place| (place.x - centre.x) * (place.y - centre.y)),
        mean(&|place| (place.y - centre.y).powi(2)),
    ];
    let angle = 0.5 * (2.0 * squares[1]).atan2(squares[0] - squares[2]);
    PlaneMoments { centre, squares, angle, least: 0.25 * footprint.step }
}

impl PlaneMoments {
    /// Start turned from the longest axis, with half sizes of `factor` deviations.
    fn start(&self, turn: f64, factor: f64) -> [f64; 5] {
        let angle = self.angle + turn;
        let half = |along: DVec2| {
            let [xx, xy, yy] = self.squares;
            let variance = xx * along.x * along.x + 2.0 * xy * along.x * along.y + yy * along.y * along.y;
            (factor * variance.max(0.0).sqrt()).max(self.least)
        };
        let along = DVec2::from_angle(angle);
        [self.centre.x, self.centre.y, half(along), half(along.perp()), angle]
    }
}

/// Name of the shape that fits best, and its matrix.
fn name(footprint: &Footprint, fit: &Fit, parts: &[f64], inner: f64) -> Option<FittedShape> {
    let [x, y, a, b, angle] = fit.rectangle;
    let (a, b) = (a.abs(), b.abs());
    let (corners, _) = rectangle_corners(&[x, y, a, b, angle]);
    let (free, free_cost) = descend(footprint, parts, corners, Quadrilateral::new);
    let free_overlap = overlap(footprint, parts, &Quadrilateral::new(&free));
    let is_sound = is_near(&free, &corners, a.min(b))
        && free_overlap >= fit.rectangle_overlap
        && matrix_of(footprint, &free).is_some();
    let free_overlap = if is_sound { free_overlap } else { 0.0 };
    let box_overlap = fit.rectangle_overlap.max(free_overlap - QUADRILATERAL_MARGIN);
    let aspect = a.max(b) / a.min(b);
    let is_free = is_sound && free_cost < QUADRILATERAL_COST * fit.rectangle_cost;
    let (box_corners, box_best) =
        if is_free { (free, free_overlap) } else { (corners, fit.rectangle_overlap) };
    let shape = if fit.covered < POINT_PIXELS {
        Shape::Point
    } else if box_best.max(fit.ellipse_overlap) < LEAST_OVERLAP {
        Shape::Other
    } else if aspect > TUBE_ASPECT {
        Shape::Tube
    } else if fit.ellipse_overlap >= box_overlap {
        Shape::Disc
    } else {
        Shape::Rectangle
    };
    let is_disc = shape == Shape::Disc;
    let corners = if is_disc { ellipse_box(&fit.ellipse) } else { box_corners };
    let matrix = matrix_of(footprint, &corners)?;
    let overlap = if is_disc { fit.ellipse_overlap } else { box_best };
    Some(FittedShape { shape, matrix, overlap: overlap.clamp(0.0, 1.0), inner, is_window: false })
}

/// Matrix of the card with these corners in the plane.
fn matrix_of(footprint: &Footprint, corners: &[f64; 8]) -> Option<DMat3> {
    let corner = |i: usize| footprint.frame * DVec2::new(corners[2 * i], corners[2 * i + 1]).extend(1.0);
    matrix_of_corners([0, 1, 2, 3].map(|i| corner(i).normalize()))
}

/// Corners of the rectangle around an ellipse.
fn ellipse_box(&[x, y, a, b, angle]: &[f64; 5]) -> [f64; 8] {
    rectangle_corners(&[x, y, a.abs(), b.abs(), angle]).0
}

/// True if no corner is farther from its start than the smaller half size.
fn is_near(corners: &[f64; 8], start: &[f64; 8], limit: f64) -> bool {
    let corner = |of: &[f64; 8], i: usize| DVec2::new(of[2 * i], of[2 * i + 1]);
    (0..4).all(|i| corner(corners, i).distance(corner(start, i)) < limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::cards::card_matrix::square_towards;
    use glam::DVec3;

    #[test]
    fn a_shape_that_reaches_beyond_the_search_is_other() {
        let shape = |radius| FittedShape {
            shape: Shape::Rectangle,
            matrix: square_towards(DVec3::X, radius),
            overlap: 0.9,
            inner: 1.0,
            is_window: false,
        };
        assert_eq!(within_reach(shape(0.5)).shape, Shape::Rectangle);
        assert_eq!(within_reach(shape(1.4)).shape, Shape::Other);
    }
}
