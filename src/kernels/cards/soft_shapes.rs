//! Part of a pixel that a shape in a plane covers, with derivatives by the numbers of the shape.

use glam::DVec2;

/// Centre of a pixel in the plane, and its sides.
#[derive(Clone, Copy)]
pub struct PlanePixel {
    pub place: DVec2,
    pub sides: [DVec2; 2],
}

impl PlanePixel {
    /// Width of a pixel across an edge with this unit normal: that of a line with the same variance.
    fn width(&self, normal: DVec2) -> f64 {
        let [first, second] = self.sides.map(|side| normal.dot(side));
        (first * first + second * second).sqrt().max(1e-12)
    }
}

/// Value and derivatives.
pub type Value<const N: usize> = (f64, [f64; N]);

/// Shape in a plane with `N` numbers, ready for many pixels.
pub trait SoftShape<const N: usize> {
    /// Covered part of a pixel, and its derivatives by the numbers of the shape.
    fn cover(&self, pixel: &PlanePixel) -> Value<N>;
}

/// Edge of a quadrilateral.
struct Edge {
    from: DVec2,
    to: DVec2,
    unit: DVec2,
    length: f64,
}

/// Convex quadrilateral of corners in counterclockwise order.
///
/// An edge is a ramp as wide as the pixel. Opposite edges overlap as intervals do: exact for a thin strip.
pub struct Quadrilateral([Edge; 4]);

impl Quadrilateral {
    pub fn new(corners: &[f64; 8]) -> Self {
        let corner = |i: usize| DVec2::new(corners[(2 * i) % 8], corners[(2 * i + 1) % 8]);
        Self([0, 1, 2, 3].map(|i| {
            let (from, to) = (corner(i), corner(i + 1));
            let length = (to - from).length().max(1e-12);
            Edge { from, to, unit: (to - from) / length, length }
        }))
    }
}

impl SoftShape<8> for Quadrilateral {
    fn cover(&self, pixel: &PlanePixel) -> Value<8> {
        let [e0, e1, e2, e3] = &self.0;
        // Most pixels lie outside of one edge: stop there.
        let (r0, r2) = (e0.ramp(pixel), e2.ramp(pixel));
        if r0.0 + r2.0 <= 1.0 {
            return (0.0, [0.0; 8]);
        }
        let edges = [r0, e1.ramp(pixel), r2, e3.ramp(pixel)];
        let [first, second] = [0, 1].map(|pair| (edges[pair].0 + edges[pair + 2].0 - 1.0).max(0.0));
        let mut derivatives = [0.0; 8];
        if first == 0.0 || second == 0.0 {
            return (0.0, derivatives);
        }
        for (edge, (_, slopes)) in edges.iter().enumerate() {
            let other = if edge % 2 == 0 { second } else { first };
            for (i, slope) in slopes.iter().enumerate() {
                derivatives[(2 * edge + i) % 8] += other * slope;
            }
        }
        (first * second, derivatives)
    }
}

impl Edge {
    /// Ramp across the edge, and its derivatives by the two ends.
    fn ramp(&self, pixel: &PlanePixel) -> Value<4> {
        let (from, to, at) = (self.from, self.to, pixel.place);
        let width = pixel.width(self.unit.perp());
        let distance = self.unit.perp_dot(at - from);
        let value = distance / width + 0.5;
        if value <= 0.0 || value >= 1.0 {
            return (value.clamp(0.0, 1.0), [0.0; 4]);
        }
        // The distance is a cross product, divided by the length.
        let scale = 1.0 / (self.length * width);
        let by_from = (DVec2::new(to.y - at.y, at.x - to.x) + distance * self.unit) * scale;
        let by_to = (DVec2::new(at.y - from.y, from.x - at.x) - distance * self.unit) * scale;
        (value, [by_from.x, by_from.y, by_to.x, by_to.y])
    }
}

/// Corners of the rectangle of centre, half sizes and angle, and their derivatives.
pub fn rectangle_corners(&[x, y, a, b, angle]: &[f64; 5]) -> ([f64; 8], [[f64; 5]; 8]) {
    let along = DVec2::from_angle(angle);
    let across = along.perp();
    let (mut corners, mut derivatives) = ([0.0; 8], [[0.0; 5]; 8]);
    for (i, (s, t)) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].into_iter().enumerate() {
        let corner = DVec2::new(x, y) + s * a * along + t * b * across;
        let turn = s * a * across - t * b * along;
        corners[2 * i] = corner.x;
        corners[2 * i + 1] = corner.y;
        derivatives[2 * i] = [1.0, 0.0, s * along.x, t * across.x, turn.x];
        derivatives[2 * i + 1] = [0.0, 1.0, s * along.y, t * across.y, turn.y];
    }
    (corners, derivatives)
}

/// Rectangle of centre, half sizes and angle.
pub struct SoftRectangle {
    quadrilateral: Quadrilateral,
    chain: [[f64; 5]; 8],
}

impl SoftRectangle {
    pub fn new(numbers: &[f64; 5]) -> Self {
        let (corners, chain) = rectangle_corners(numbers);
        Self { quadrilateral: Quadrilateral::new(&corners), chain }
    }
}

impl SoftShape<5> for SoftRectangle {
    fn cover(&self, pixel: &PlanePixel) -> Value<5> {
        let (value, by_corner) = self.quadrilateral.cover(pixel);
        let mut derivatives = [0.0; 5];
        if value > 0.0 && value < 1.0 {
            for (by_corner, row) in by_corner.iter().zip(&self.chain) {
                derivatives.iter_mut().zip(row).for_each(|(sum, along)| *sum += by_corner * along);
            }
        }
        (value, derivatives)
    }
}

/// Ellipse of centre, half axes and angle; the distance to its rim is of first order.
pub struct Ellipse {
    centre: DVec2,
    axes: DVec2,
    along: DVec2,
}

impl Ellipse {
    pub fn new(&[x, y, a, b, angle]: &[f64; 5]) -> Self {
        Self { centre: DVec2::new(x, y), axes: DVec2::new(a, b), along: DVec2::from_angle(angle) }
    }
}

impl SoftShape<5> for Ellipse {
    fn cover(&self, pixel: &PlanePixel) -> Value<5> {
        let (a, b) = (self.axes.x, self.axes.y);
        let offset = pixel.place - self.centre;
        let (u, v) = (offset.dot(self.along), offset.dot(self.along.perp()));
        let radius = (u * u / (a * a) + v * v / (b * b)).sqrt().max(1e-9);
        let by_place = DVec2::new(u / (a * a), v / (b * b)) / radius;
        let slope = by_place.length().max(1e-12);
        let normal = (by_place.x * self.along + by_place.y * self.along.perp()) / slope;
        let width = pixel.width(normal);
        let value = (1.0 - radius) / (slope * width) + 0.5;
        if value <= 0.0 || value >= 1.0 {
            return (value.clamp(0.0, 1.0), [0.0; 5]);
        }
        let scale = 1.0 / width;
        let by_axis = [u * by_place.x / a, v * by_place.y / b].map(|d| d * scale / slope);
        let turn = (by_place.y * u - by_place.x * v) * scale / slope;
        (value, [normal.x * scale, normal.y * scale, by_axis[0], by_axis[1], turn])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pixel(x: f64, y: f64) -> PlanePixel {
        PlanePixel { place: DVec2::new(x, y), sides: [DVec2::new(0.1, 0.02), DVec2::new(-0.01, 0.15)] }
    }

    proptest! {
        #[test]
        fn derivatives_of_a_rectangle_are_those_of_differences(
            edge in 0..4_u8, along in -0.8..0.8_f64, offset in -0.04..0.04_f64,
        ) {
            // Half sizes of 1.0 and 0.5, turned by 0.3: each pixel lies on the ramp of one edge.
            let numbers = [0.02, 0.01, 1.0, 0.5, 0.3];
            let place = match edge {
                0 => DVec2::new(along, 0.5 + offset),
                1 => DVec2::new(along, -0.5 + offset),
                2 => DVec2::new(1.0 + offset, 0.5 * along),
                _ => DVec2::new(-1.0 + offset, 0.5 * along),
            };
            let place = DVec2::new(0.02, 0.01) + DVec2::from_angle(0.3).rotate(place);
            let pixel = pixel(place.x, place.y);
            let (value, derivatives) = SoftRectangle::new(&numbers).cover(&pixel);
            prop_assert!(value > 0.0 && value < 1.0);
            for n in 0..5 {
                let mut moved = numbers;
                moved[n] += 1e-6;
                let difference = (SoftRectangle::new(&moved).cover(&pixel).0 - value) / 1e-6;
                // The width of the ramp is constant in the derivative.
                prop_assert!((difference - derivatives[n]).abs() < 0.25 * (1.0 + derivatives[n].abs()), "{n} {difference} {derivatives:?}");
            }
        }
    }

    #[test]
    fn a_strip_thinner_than_a_pixel_covers_its_own_width() {
        let pixel = PlanePixel { place: DVec2::ZERO, sides: [DVec2::X * 0.1, DVec2::Y * 0.1] };
        assert!((SoftRectangle::new(&[0.0, 0.0, 2.0, 0.01, 0.0]).cover(&pixel).0 - 0.2).abs() < 1e-12);
    }

    #[test]
    fn covered_parts_sum_to_the_areas() {
        let side = 0.02;
        let sum = |shape: &dyn SoftShape<5>| -> f64 {
            let places =
                (0..14_400).map(|i| DVec2::new(f64::from(i % 120), f64::from(i / 120)) * side - 1.19);
            let pixels = places.map(|place| PlanePixel { place, sides: [DVec2::X * side, DVec2::Y * side] });
            pixels.map(|pixel| shape.cover(&pixel).0 * side * side).sum()
        };
        assert!((sum(&SoftRectangle::new(&[0.1, 0.05, 0.8, 0.4, 0.6])) / 1.28 - 1.0).abs() < 2e-3);
        assert!(
            (sum(&Ellipse::new(&[0.1, 0.05, 0.8, 0.4, 0.6])) / (0.32 * std::f64::consts::PI) - 1.0).abs()
                < 2e-3
        );
    }
}
