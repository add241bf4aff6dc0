//! The plan against all permutations, closed forms, and the axioms of a metric.

use std::f64::consts::PI;

use approx::assert_abs_diff_eq;
use glam::{DMat3, DVec3};
use ndarray::{Array1, Array2, aview1};
use proptest::prelude::*;

use super::*;
use crate::error::Error;
use crate::kernels::sphere::direction;

/// Directions and weights.
type Cloud = (Vec<DVec3>, Vec<f64>);

fn array(directions: &[DVec3]) -> Array2<f64> {
    Array2::from(directions.iter().map(DVec3::to_array).collect::<Vec<_>>())
}

fn plan(from: &Cloud, to: &Cloud) -> TransportPlan {
    transport_plan(array(&from.0).view(), aview1(&from.1), array(&to.0).view(), aview1(&to.1)).unwrap()
}

fn distance(from: &Cloud, to: &Cloud) -> f64 {
    plan(from, to).mean_angle
}

fn rotate((directions, weights): &Cloud, turn: DMat3) -> Cloud {
    (directions.iter().map(|&each| (turn * each).normalize()).collect(), weights.clone())
}

/// Least mean angle over all assignments of `to` to `from`, by recursion.
fn best_assignment(from: &[DVec3], to: &[DVec3]) -> f64 {
    let Some((&one, others)) = from.split_first() else { return 0.0 };
    let cost = |k: usize| {
        let mut remaining = to.to_vec();
        let other = remaining.swap_remove(k);
        one.cross(other).length().atan2(one.dot(other)) + best_assignment(others, &remaining)
    };
    (0..to.len()).map(cost).fold(f64::INFINITY, f64::min)
}

/// Directions on a coarse grid, so that many coincide, and small whole weights, so that many are equal or 0.
fn degenerate_cloud() -> impl Strategy<Value = Cloud> {
    let light = (0..5_u8, 0..6_u8, 0..4_u8).prop_map(|(theta, phi, weight)| {
        (direction(PI * f64::from(theta) / 4.0, PI * f64::from(phi) / 3.0), f64::from(weight))
    });
    with_weight(light)
}

fn random_cloud() -> impl Strategy<Value = Cloud> {
    with_weight((0.0..PI, 0.0..2.0 * PI, 0.0..1.0_f64).prop_map(|(t, p, weight)| (direction(t, p), weight)))
}

/// Up to 11 lights, the first one with a weight above 0.
fn with_weight(light: impl Strategy<Value = (DVec3, f64)>) -> impl Strategy<Value = Cloud> {
    prop::collection::vec(light, 1..12).prop_map(|mut lights| {
        lights[0].1 += 1.0;
        lights.into_iter().unzip()
    })
}

fn any_cloud() -> impl Strategy<Value = Cloud> {
    prop_oneof![degenerate_cloud(), random_cloud()]
}

fn any_rotation() -> impl Strategy<Value = DMat3> {
    (0.0..PI, 0.0..2.0 * PI, -PI..PI).prop_map(|(t, p, turn)| DMat3::from_axis_angle(direction(t, p), turn))
}

proptest! {
    #[test]
    fn equal_masses_get_the_best_of_all_assignments(
        angles in prop::collection::vec((0.0..PI, 0.0..2.0 * PI), 2..13), mass in 1e-3..1e3_f64,
    ) {
        let half = angles.len() / 2;
        let directions: Vec<_> = angles[..2 * half].iter().map(|&(theta, phi)| direction(theta, phi)).collect();
        let (from, to) = directions.split_at(half);
        let found = distance(&(from.to_vec(), vec![mass; half]), &(to.to_vec(), vec![1.0; half]));
        prop_assert!((found - best_assignment(from, to) / half as f64).abs() < 2e-11);
    }

    #[test]
    fn the_plan_moves_each_share_at_the_cost_that_it_states(from in any_cloud(), to in any_cloud()) {
        let plan = plan(&from, &to);
        let (mut sent, mut received) = (vec![0.0; from.0.len()], vec![0.0; to.0.len()]);
        let mut cost = 0.0;
        for (pair, share) in plan.pairs.rows().into_iter().zip(&plan.shares) {
            let (i, j) = (pair[0] as usize, pair[1] as usize);
            sent[i] += share;
            received[j] += share;
            cost += share * from.0[i].cross(to.0[j]).length().atan2(from.0[i].dot(to.0[j]));
        }
        prop_assert!((cost - plan.mean_angle).abs() < 1e-12);
        for (weights, moved) in [(&from.1, sent), (&to.1, received)] {
            let whole: f64 = weights.iter().sum();
            for (weight, moved) in weights.iter().zip(moved) {
                prop_assert!((weight / whole - moved).abs() < 1e-12, "{weight} {whole} {moved}");
            }
        }
    }

    #[test]
    fn the_distance_is_a_metric(a in any_cloud(), b in any_cloud(), c in any_cloud()) {
        let [ab, ba, bc, ac] = [(&a, &b), (&b, &a), (&b, &c), (&a, &c)].map(|(from, to)| distance(from, to));
        prop_assert!(distance(&a, &a) < 1e-12);
        prop_assert!((ab - ba).abs() < 1e-11, "{ab} {ba}");
        prop_assert!(ac <= ab + bc + 1e-11, "{ac} {ab} {bc}");
    }

    #[test]
    fn a_rotation_of_both_sets_changes_nothing(a in any_cloud(), b in any_cloud(), turn in any_rotation()) {
        let before = distance(&a, &b);
        let after = distance(&rotate(&a, turn), &rotate(&b, turn));
        prop_assert!((before - after).abs() < 1e-11, "{before} {after}");
    }

    /// Lights at the corners of a cube are 54 degrees or more apart.
    #[test]
    fn lights_that_move_less_than_half_of_their_distance_keep_their_partner(
        weights in prop::collection::vec(0.0..1.0_f64, 8), turn in any_rotation(), angle in 0.0..0.4_f64,
        around in (0.0..PI, 0.0..2.0 * PI),
    ) {
        let sign = |code: usize, bit: usize| if code >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |code| turn * DVec3::new(sign(code, 0), sign(code, 1), sign(code, 2)).normalize();
        let corners: Cloud = ((0..8).map(corner).collect(), weights.iter().map(|weight| weight + 1e-3).collect());
        let moved = rotate(&corners, DMat3::from_axis_angle(direction(around.0, around.1), angle));
        let movement = |k: usize| corners.0[k].cross(moved.0[k]).length().atan2(corners.0[k].dot(moved.0[k]));
        let whole: f64 = corners.1.iter().sum();
        let expected: f64 = (0..8).map(|k| movement(k) * corners.1[k] / whole).sum();
        let plan = plan(&corners, &moved);
        prop_assert!((plan.mean_angle - expected).abs() < 1e-12, "{} {expected}", plan.mean_angle);
        prop_assert!(plan.pairs.rows().into_iter().all(|pair| pair[0] == pair[1]));
    }
}

#[test]
fn neither_the_seam_nor_a_pole_is_special() {
    for (one, other) in [
        (direction(1.0, 1e-4), direction(1.0, 2.0 * PI - 1e-4)),
        (direction(1e-4, 0.0), direction(1e-4, PI)),
        (direction(PI - 1e-4, 0.3), direction(PI - 1e-4, 0.3 + PI)),
    ] {
        let chord = (one - other).length();
        let angle = 2.0 * (chord / 2.0).asin();
        assert_abs_diff_eq!(
            distance(&(vec![one], vec![2.0]), &(vec![other], vec![9.0])),
            angle,
            epsilon = 1e-15
        );
    }
}

/// The first light could also move past all others at the same mean angle.
#[test]
fn lights_that_move_along_one_circle_all_move() {
    let row = |first: i32| -> Cloud {
        let lights = (0..5).map(|k| direction(PI / 2.0, 0.2 * f64::from(first + k)));
        (lights.collect(), vec![1.0; 5])
    };
    for (from, to) in [(row(0), row(1)), (row(3), row(0))] {
        let plan = plan(&from, &to);
        assert!(plan.pairs.rows().into_iter().all(|pair| pair[0] == pair[1]), "{}", plan.pairs);
    }
}

#[test]
fn a_missing_light_costs_its_share_times_its_angle() {
    let both = (vec![DVec3::Y, DVec3::X], vec![3.0, 1.0]);
    assert_abs_diff_eq!(distance(&both, &(vec![DVec3::Y], vec![1.0])), PI / 8.0, epsilon = 1e-15);
}

#[test]
fn the_angle_between_opposite_directions_is_pi() {
    assert_abs_diff_eq!(distance(&(vec![DVec3::Y], vec![1.0]), &(vec![-DVec3::Y], vec![1.0])), PI);
}

/// All pivots are degenerate here: any assignment is a vertex with half of the flows at 0.
#[test]
fn hundred_equal_lights_in_one_direction_do_not_cycle() {
    let many = (vec![DVec3::Z; 100], vec![1.0; 100]);
    assert_eq!(plan(&many, &many).pairs.nrows(), 100);
    assert_abs_diff_eq!(distance(&many, &(vec![DVec3::X; 100], vec![7.0; 100])), PI / 2.0, epsilon = 1e-12);
}

#[test]
fn extreme_weights_neither_overflow_nor_vanish() {
    let ends = vec![DVec3::Z, DVec3::X];
    for scale in [1e308, 1e-320] {
        let from = (ends.clone(), vec![scale, scale]);
        assert_abs_diff_eq!(distance(&from, &(vec![DVec3::X], vec![1.0])), PI / 4.0, epsilon = 1e-12);
    }
    let from = (ends.clone(), vec![1e300, 1e-300]);
    assert_eq!(plan(&from, &(ends, vec![1.0, 0.0])).pairs, Array2::from(vec![[0_i64, 0]]));
}

#[test]
fn pairs_of_equal_weights_in_another_order_hold_no_rounding() {
    let thirds = (vec![DVec3::X, DVec3::Y, DVec3::Z], vec![1.0; 3]);
    let reverse = (vec![DVec3::Z, DVec3::Y, DVec3::X], vec![0.1; 3]);
    assert_eq!(plan(&thirds, &reverse).pairs, Array2::from(vec![[0_i64, 2], [1, 1], [2, 0]]));
}

#[test]
fn sets_without_weight_are_refused() {
    let directions = array(&[DVec3::Z]);
    let weights = |weight: f64| Array1::from(vec![weight]);
    let refusal = |from: f64, to: f64| {
        let (from, to) = (weights(from), weights(to));
        transport_plan(directions.view(), from.view(), directions.view(), to.view()).err()
    };
    assert_eq!(refusal(1.0, 0.0), Some(Error::NoWeight { what: "to_weights" }));
    assert_eq!(refusal(-1.0, 1.0), Some(Error::Negative { what: "from_weights", index: 0, value: -1.0 }));
    assert!(matches!(refusal(f64::NAN, 1.0), Some(Error::NotFinite { what: "from_weights", .. })));
}
