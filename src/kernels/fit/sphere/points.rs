//! Lights of a map that are kept as points, four side by side.

use glam::{DMat3, DVec3};
use wide::f64x4;

use super::kernel::{Lanes, angle};

/// A light of the map that is kept as a point: its direction, and its irradiance at normal incidence.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub direction: DVec3,
    pub irradiance: [f64; 3],
}

/// Points, four to a vector: the last vector is filled up with black ones.
#[derive(Clone, Debug)]
pub struct Points {
    fours: Vec<(Lanes, [f64x4; 3])>,
}

impl Points {
    /// Of one list.
    pub fn new(points: &[Point]) -> Self {
        let four = |points: &[Point]| {
            let irradiance = |channel: usize| {
                f64x4::from(std::array::from_fn::<f64, 4, _>(|i| {
                    points.get(i).map_or(0.0, |point| point.irradiance[channel])
                }))
            };
            let directions: Vec<DVec3> = points.iter().map(|point| point.direction).collect();
            (Lanes::new(&directions), [0, 1, 2].map(irradiance))
        };
        Self { fours: points.chunks(4).map(four).collect() }
    }

    /// Gradients at l of the inner product of a light with all points, by channel.
    pub fn gradient(&self, l: DVec3) -> [DVec3; 3] {
        let mut along = [f64x4::ZERO; 3];
        let mut towards = [[f64x4::ZERO; 3]; 3];
        for (points, irradiance) in &self.fours {
            let angle = angle(l, points);
            for channel in 0..3 {
                along[channel] += irradiance[channel] * angle.rest();
                let pull = irradiance[channel] * angle.slope;
                (0..3).for_each(|axis| towards[channel][axis] += pull * points.axes[axis]);
            }
        }
        [0, 1, 2].map(|channel| {
            l * along[channel].reduce_add() + DVec3::from(towards[channel].map(f64x4::reduce_add))
        })
    }

    /// The second derivative on the tangent plane of l, of the channels with these `shares`.
    pub fn second_derivative(&self, l: DVec3, shares: [f64; 3]) -> DMat3 {
        let mut round = f64x4::ZERO;
        let mut products = [f64x4::ZERO; 6];
        for (points, irradiance) in &self.fours {
            let angle = angle(l, points);
            let weight = (0..3)
                .fold(f64x4::ZERO, |sum, channel| sum + irradiance[channel] * f64x4::splat(shares[channel]));
            round += weight * angle.rest();
            let bend = weight * angle.bend();
            // Of the points only what lies in the tangent plane, for k'' may be large.
            let [x, y, z] = [0, 1, 2].map(|axis| points.axes[axis] - angle.cosine * f64x4::splat(l[axis]));
            for (sum, product) in products.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x]) {
                *sum += bend * product;
            }
        }
        let [xx, yy, zz, xy, yz, zx] = products.map(f64x4::reduce_add);
        let round = round.reduce_add();
        DMat3::from_cols_array(&[xx + round, xy, zx, xy, yy + round, yz, zx, yz, zz + round])
    }
}
