//! How far the lights of a lane turn.
//!
//! Gauss and Newton's model leaves out the second derivatives of the columns, and mostly bends more than the cost does:
//! its steps fall short, one after the other. By how much shows in the slope. Where the slope along the last turn was g at
//! its start and is g' at its end, a parabola has its bottom after
//!
//! ```text
//!   g / (g - g')   such turns                                         (Barzilai and Borwein 1988)
//! ```
//!
//! and as many times longer the next turn is than the step of the model. With that, the rounds of a search for 8 lights
//! are fewer by a tenth where starts are rough, and half as many where they are nearly close.

use glam::DVec3;

use super::place::Places;
use crate::kernels::fit::descent::LONGEST_STEP;
use crate::kernels::fit::wide::Wide;
use crate::kernels::sphere::exponential_map;

/// Steps of the model in one turn at most: with 5, seven times as many turns lead uphill as with 2, and the time is that
/// of 2.
const LONGEST_STRIDE: f64 = 3.0;

/// A turn of the lights of one lane.
#[derive(Clone, Debug)]
pub struct Turn {
    /// How each light goes that may turn, in radians; tangent at its end.
    along: Vec<DVec3>,
    /// Half of the slope of the cost along it, at its start.
    slope: f64,
    /// How many steps of the model it is long.
    pub stride: f64,
}

impl Turn {
    /// On from the place in a lane after the `last` turn that led there, and where that leads to.
    pub fn after(
        last: Option<&Self>,
        places: &Places,
        lane: usize,
        step: &[Wide],
        fixed: usize,
    ) -> (Self, Vec<DVec3>) {
        let stride = last.map_or(1.0, |last| last.next_stride(slope(places, lane, fixed, &last.along)));
        let way = |([s, t], step): (&[DVec3; 2], &[Wide])| {
            ((*s * step[0].0[lane] + *t * step[1].0[lane]) * stride).clamp_length_max(LONGEST_STEP)
        };
        let frames = places.frames[lane].iter().skip(fixed);
        let mut along: Vec<DVec3> = frames.zip(step.chunks_exact(2)).map(way).collect();
        let slope = slope(places, lane, fixed, &along);
        let mut directions = places.sets[lane].clone();
        for (direction, along) in directions.iter_mut().skip(fixed).zip(&mut along) {
            let (from, way, angle) = (*direction, *along, along.length());
            *direction = exponential_map(from, way);
            // What leads along a great circle goes on along it.
            *along = way * angle.cos() - from * (angle * angle.sin());
        }
        (Self { along, slope, stride }, directions)
    }

    /// How many steps of the model lead to the bottom of a parabola, if the slope along this turn is now `slope`.
    fn next_stride(&self, slope: f64) -> f64 {
        let bend = slope - self.slope;
        // Where the way gets steeper, no bottom is in sight.
        if bend > 0.0 {
            (-self.slope / bend * self.stride).clamp(1.0, LONGEST_STRIDE)
        } else {
            LONGEST_STRIDE
        }
    }
}

/// Half of the slope of the cost along the ways of the lights that may turn.
fn slope(places: &Places, lane: usize, fixed: usize, along: &[DVec3]) -> f64 {
    let gradient = places.model.gradient.chunks_exact(2);
    let frames = places.frames[lane].iter().skip(fixed);
    let slope = |((along, [s, t]), gradient): ((&DVec3, &[DVec3; 2]), &[Wide])| {
        along.dot(*s) * gradient[0].0[lane] + along.dot(*t) * gradient[1].0[lane]
    };
    along.iter().zip(frames).zip(gradient).map(slope).sum()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::lanes::LANES;
    use crate::kernels::fit::wide::Matrix;
    use crate::kernels::fit::{Ambient, Objective, Sphere};
    use crate::kernels::image;
    use crate::kernels::sphere::Registration;
    use approx::assert_relative_eq;
    use ndarray::Array3;
    use pulp::Scalar;
    use std::array;

    fn sphere() -> Sphere {
        let map =
            Array3::from_shape_fn((16, 32, 3), |(y, x, c)| if (y, x % 9) == (3 + c, 4) { 50.0 } else { 1.0 });
        let working = image::reduce(map.view(), Registration::CellCentred, 256, 3e-3, false).unwrap();
        Sphere::new(&working, Ambient::None, false)
    }

    /// Three lights in each lane, the first of which stays.
    fn places(sphere: &Sphere, sets: [Vec<DVec3>; LANES]) -> Places {
        let mut used = Matrix::zeros(sphere.given().channels.len(), 3);
        (0..LANES).for_each(|lane| used.fill_lane(lane, 1.0));
        Places::at(Scalar::new(), sphere, sets, 1, used).unwrap()
    }

    fn sets() -> [Vec<DVec3>; LANES] {
        let direction = |i: usize| {
            let [x, y, z] = [1.3, 2.1, 3.7].map(|turn| (turn * (i + 1) as f64).sin());
            DVec3::new(x, y, z).normalize()
        };
        array::from_fn(|lane| (0..3).map(|light| direction(3 * lane + light)).collect())
    }

    /// The slope at both ends of a short turn, by differences of the cost along it.
    #[test]
    fn the_slope_along_a_turn_is_that_of_the_cost() {
        const NEXT: f64 = 1e-4;
        let sphere = sphere();
        let from = places(&sphere, sets());
        let step = |factor: f64| -> Vec<Wide> {
            [0.03, -0.02, 0.01, 0.04].map(|step| Wide::splat(factor * step)).to_vec()
        };
        let turned = |factor: f64| {
            places(&sphere, array::from_fn(|lane| Turn::after(None, &from, lane, &step(factor), 1).1))
        };
        let (to, beyond, short) = (turned(1.0), turned(1.0 + NEXT), turned(1.0 - NEXT));
        for lane in 0..LANES {
            let (turn, directions) = Turn::after(None, &from, lane, &step(1.0), 1);
            assert_eq!(directions[0], from.sets[lane][0]);
            let wanted = (beyond.cost.0[lane] - short.cost.0[lane]) / (4.0 * NEXT);
            let seen = slope(&to, lane, 1, &turn.along);
            assert!((seen - wanted).abs() < 1e-6 * sphere.given().energy, "{seen} {wanted}");
            let wanted = (turned(NEXT).cost.0[lane] - turned(-NEXT).cost.0[lane]) / (4.0 * NEXT);
            assert!((turn.slope - wanted).abs() < 1e-6 * sphere.given().energy, "{} {wanted}", turn.slope);
        }
    }

    #[test]
    fn a_stride_leads_to_the_bottom_of_a_parabola() {
        for (before, stride, after, wanted) in [
            (-1.0, 0.5, -0.6, 1.25),
            (-1.0, 1.0, -0.5, 2.0),
            (-1.0, 2.0, -0.2, 2.5),
            (-1.0, 1.0, 0.3, 1.0),
            (-1.0, 1.0, -0.9, LONGEST_STRIDE),
            (-1.0, 1.0, -1.1, LONGEST_STRIDE),
        ] {
            let turn = Turn { along: Vec::new(), slope: before, stride };
            assert_relative_eq!(turn.next_stride(after), wanted, max_relative = 1e-12);
        }
    }
}
