//! Checks of the second derivatives of `kernel.rs` against formulas without cancellation.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use proptest::prelude::*;
use pulp::Scalar;

use super::kernel::{Block, mixed_derivatives, second_derivative};
use crate::kernels::lanes::LANES;

/// Two lights at an `angle`, with two tangents each, along the arc between them and oblique to it.
fn lights(azimuth: f64, height: f64, turn: f64, angle: f64) -> (DVec3, DVec3, [DVec3; 2], [DVec3; 2]) {
    let radius = (1.0 - height * height).sqrt();
    let a = DVec3::new(radius * azimuth.sin(), height, radius * azimuth.cos()).normalize();
    let (east, north) = a.any_orthonormal_pair();
    let way = east * turn.cos() + north * turn.sin();
    let b = (a * angle.cos() + way * angle.sin()).normalize();
    let oblique = |at: DVec3, along: DVec3| (along + at.cross(along)).normalize();
    let ahead = way * angle.cos() - a * angle.sin();
    (a, b, [way, oblique(a, way)], [ahead, oblique(b, ahead)])
}

/// Second derivatives along the tangents of one light, and mixed ones along those of both.
fn derivatives(a: DVec3, b: DVec3, at_a: [DVec3; 2], at_b: [DVec3; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
    let mut weights = [0.0; LANES];
    weights[0] = 1.0;
    let own = second_derivative(Scalar::new(), a, &weights, &Block::new([b].into_iter()));
    let frames = [[a, at_a[0], at_a[1]], [b, at_b[0], at_b[1]]];
    let [own_frame, other_frame] = frames.map(|frame| frame.map(|axis| axis.to_array()));
    (at_a.map(|u| u.dot(own * u)), mixed_derivatives(&own_frame, &other_frame).both)
}

proptest! {
    /// Checks bound 7 of `docs/lab/bounds.md`, with an angle from a cross product, which keeps its digits everywhere.
    #[test]
    fn second_derivatives_keep_their_digits(
        azimuth in 0.0..TAU, height in -0.99..0.99_f64, turn in 0.0..TAU,
        angle in prop_oneof![0.01..3.13_f64, 1e-4..1e-2_f64, 3.1315..3.1414_f64],
    ) {
        const BOUND: f64 = 32.0 * f64::EPSILON / 2.0;
        let (a, b, at_a, at_b) = lights(azimuth, height, turn, angle);
        let (own, both) = derivatives(a, b, at_a, at_b);
        let sine = a.cross(b).length();
        let (first, second) = (2.0 / 3.0 * (PI - sine.atan2(a.dot(b))), 2.0 / 3.0 / sine);
        for (i, u) in at_a.into_iter().enumerate() {
            let expected = 2.0 / 3.0 * sine + second * u.dot(b).powi(2);
            prop_assert!((own[i] - expected).abs() <= BOUND, "{:e}", own[i] - expected);
            for (k, v) in at_b.into_iter().enumerate() {
                let expected = first * u.dot(v) + second * u.dot(b) * v.dot(a);
                prop_assert!((both[i][k] - expected).abs() <= BOUND, "mixed {:e}", both[i][k] - expected);
            }
        }
    }
}
