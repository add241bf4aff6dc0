//! Bright sources of a map as exact points.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::{DMat3, DVec3};
use pulp::Simd;

use super::kernel::{Angles, Block, second_derivative, splat};
use crate::kernels::expansion::PointLight;
use crate::kernels::image::WorkingMap;
use crate::kernels::lanes::{LANES, Lanes, Number};

/// Limit on exact points, the brightest first: harmonics are as accurate for the others.
const MOST_POINTS: usize = 24;

/// Points in blocks; the last block ends with black ones.
#[derive(Clone, Debug)]
pub struct Points {
    blocks: Vec<(Block, [[f64; LANES]; 3])>,
}

impl Points {
    /// The brightest sources of the map, the other sources, and the vector irradiance that is missing in both.
    ///
    /// The channels of a source may have different directions; a point has one.
    pub fn of_sources(map: &WorkingMap) -> (Vec<PointLight>, Vec<PointLight>, [DVec3; 3]) {
        let mut sources = map.source_vectors();
        let power = |source: &[DVec3; 3]| source.iter().map(|e| e.length()).sum::<f64>();
        sources.sort_by(|a, b| power(b).total_cmp(&power(a)));
        let mut missing = [DVec3::ZERO; 3];
        let point = |source: &[DVec3; 3]| {
            let direction = source.iter().sum::<DVec3>().normalize_or(DVec3::Y);
            PointLight { direction, irradiance: source.map(|e| e.dot(direction)) }
        };
        let mut points: Vec<PointLight> = sources.iter().map(point).collect();
        for (source, point) in sources.iter().zip(&points) {
            (0..3).for_each(|c| missing[c] += source[c] - point.irradiance[c] * point.direction);
        }
        let powers: Vec<f64> = sources.iter().map(power).collect();
        let others = points.split_off(brightest(&powers));
        (points, others, missing)
    }

    /// Group points into blocks.
    pub fn new(points: &[PointLight]) -> Self {
        let block = |points: &[PointLight]| {
            let mut irradiance = [[0.0; LANES]; 3];
            for (i, point) in points.iter().enumerate() {
                (0..3).for_each(|channel| irradiance[channel][i] = point.irradiance[channel]);
            }
            (Block::new(points.iter().map(|point| point.direction)), irradiance)
        };
        Self { blocks: points.chunks(LANES).map(block).collect() }
    }

    /// Gradients at l of the inner product of a light with all points, by channel.
    #[inline(always)]
    pub fn gradient<S: Simd>(&self, simd: S, l: DVec3) -> [DVec3; 3] {
        let own = splat(simd, l);
        // Sum for each channel the parts of the gradient towards the points, and the part along l.
        let mut sums = [[Lanes::splat(simd, 0.0); 4]; 3];
        for (points, irradiance) in &self.blocks {
            for vector in 0..Lanes::<S>::VECTORS {
                let points = points.at(simd, vector);
                let angles = Angles::between(&own, &points);
                let (along, towards) = (angles.intercepts(), angles.first());
                for (sums, e) in sums.iter_mut().zip(irradiance) {
                    let e = Lanes::at(simd, e, vector);
                    let towards = e * towards;
                    for axis in 0..3 {
                        sums[axis] = sums[axis].add_product(towards, points[axis]);
                    }
                    sums[3] = sums[3].add_product(e, along);
                }
            }
        }
        let mut gradients = [DVec3::ZERO; 3];
        for (gradient, [x, y, z, along]) in gradients.iter_mut().zip(sums) {
            *gradient = DVec3::new(x.sum(), y.sum(), z.sum()) + l * along.sum();
        }
        gradients
    }

    /// Second derivative on the tangent plane of l of the weighted sum of the channels.
    #[inline(always)]
    pub fn second_derivative<S: Simd>(&self, simd: S, l: DVec3, weights: [f64; 3]) -> DMat3 {
        let mut out = DMat3::ZERO;
        for (points, [red, green, blue]) in &self.blocks {
            let mut powers = [0.0; LANES];
            for i in 0..LANES {
                powers[i] = red[i] * weights[0] + green[i] * weights[1] + blue[i] * weights[2];
            }
            out += second_derivative(simd, l, &powers, points);
        }
        out
    }
}

/// Number of sources that become exact points, at most [`MOST_POINTS`], for decreasing `powers`.
///
/// Equal sources are not separated, because their order depends on the side that the map is read from.
fn brightest(powers: &[f64]) -> usize {
    const ALIKE: f64 = 1e-6;
    let is_gap = |&count: &usize| count == 0 || powers[count] < (1.0 - ALIKE) * powers[count - 1];
    if powers.len() <= MOST_POINTS {
        return powers.len();
    }
    (0..=MOST_POINTS).rev().find(is_gap).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sources_are_not_separated() {
        let (bright, alike) = (vec![2.0; 20], vec![1.0; 6]);
        assert_eq!(brightest(&[bright.clone(), alike].concat()), 20);
        assert_eq!(brightest(&[1.0; MOST_POINTS + 1]), 0);
        assert_eq!(brightest(&[1.0; MOST_POINTS]), MOST_POINTS);
        let falling: Vec<f64> = (0..30).map(|i| 1.0 - 0.01 * f64::from(i)).collect();
        assert_eq!(brightest(&falling), MOST_POINTS);
        assert_eq!(brightest(&[]), 0);
    }
}
