//! Matrix of a card: the columns U, V, O of its points `O + a U + b V`.

use glam::{DMat3, DVec2, DVec3};

/// Places of the corners in a card, in their order.
const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

/// Matrix of the only parallelogram whose corners are seen in these directions, with its centre at distance 1.
///
/// The weights of `s0 d0 - s1 d1 + s2 d2 - s3 d3 = 0` are determinants; all are positive if the corners are convex and
/// in counterclockwise order around the direction away from the origin.
pub fn matrix_of_corners(corners: [DVec3; 4]) -> Option<DMat3> {
    let [d0, d1, d2, d3] = corners;
    let volume = |a: DVec3, b: DVec3, c: DVec3| a.cross(b).dot(c);
    let weights = [volume(d1, d2, d3), volume(d0, d2, d3), volume(d0, d1, d3), volume(d0, d1, d2)];
    if weights.iter().any(|&weight| weight <= 0.0 || !weight.is_finite()) {
        return None;
    }
    let [p0, p1, _, p3] = [0, 1, 2, 3].map(|corner| weights[corner] * corners[corner]);
    let matrix = DMat3::from_cols(p1 - p0, p3 - p0, p0);
    Some(matrix * (1.0 / point(&matrix, DVec2::splat(0.5)).length()))
}

/// Point of a card at a place.
pub fn point(matrix: &DMat3, place: DVec2) -> DVec3 {
    *matrix * place.extend(1.0)
}

/// Unit directions of the corners.
pub fn corners(matrix: &DMat3) -> [DVec3; 4] {
    CORNERS.map(|place| point(matrix, place).normalize())
}

/// Unit direction of the centre.
pub fn centre(matrix: &DMat3) -> DVec3 {
    point(matrix, DVec2::splat(0.5)).normalize()
}

/// Angle from the centre to the farthest corner.
pub fn reach(matrix: &DMat3) -> f64 {
    let centre = centre(matrix);
    corners(matrix).iter().map(|corner| corner.angle_between(centre)).fold(0.0, f64::max)
}

/// Angles between the middles of opposite edges, along U and along V.
pub fn sizes(matrix: &DMat3) -> [f64; 2] {
    let angle =
        |from: [f64; 2], to: [f64; 2]| point(matrix, from.into()).angle_between(point(matrix, to.into()));
    [angle([0.0, 0.5], [1.0, 0.5]), angle([0.5, 0.0], [0.5, 1.0])]
}

/// Place of a direction on the plane of a card, by the inverse of its matrix; none behind the origin.
pub fn place_of(inverse: &DMat3, direction: DVec3) -> Option<DVec2> {
    let p = *inverse * direction;
    (p.z > 0.0).then(|| p.truncate() / p.z)
}

/// True if a place lies in a card, or in its inscribed ellipse.
pub fn is_inside(place: DVec2, is_ellipse: bool) -> bool {
    if is_ellipse {
        return (place - 0.5).length_squared() <= 0.25;
    }
    place.min_element() >= 0.0 && place.max_element() <= 1.0
}

/// Matrix of the same corners, with U to the right and V down where the top of the map is up.
pub fn upright(matrix: &DMat3) -> DMat3 {
    let centre = centre(matrix);
    let up = if centre.y.abs() < 1.0 - 1e-9 { DVec3::Y } else { DVec3::NEG_Z * centre.y.signum() };
    let turns = (0..4).map(|turn| quarter_turns(matrix, turn));
    let height = |matrix: &DMat3| {
        let down = matrix.y_axis.reject_from_normalized(centre);
        down.normalize_or_zero().dot(up)
    };
    turns.min_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(*matrix)
}

/// Matrix of the same parallelogram from another corner.
fn quarter_turns(matrix: &DMat3, turns: usize) -> DMat3 {
    let DMat3 { x_axis: u, y_axis: v, z_axis: o } = *matrix;
    match turns {
        0 => *matrix,
        1 => DMat3::from_cols(v, -u, o + u),
        2 => DMat3::from_cols(-u, -v, o + u + v),
        _ => DMat3::from_cols(-v, u, o + v),
    }
}

/// Matrix of the facing square around a disc.
pub fn square_towards(direction: DVec3, radius: f64) -> DMat3 {
    let [x, y] = crate::kernels::sphere::tangents(direction);
    // The side of a square to the left of up is down.
    let half = radius.min(1.4).tan();
    let right = if direction.y.abs() < 1.0 - 1e-9 { direction.cross(DVec3::Y).normalize() } else { x };
    let down = if direction.y.abs() < 1.0 - 1e-9 { direction.cross(right) } else { y };
    let matrix = DMat3::from_cols(2.0 * half * right, 2.0 * half * down, direction - half * (right + down));
    upright(&matrix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix() -> impl Strategy<Value = DMat3> {
        let side = -0.6..0.6_f64;
        (prop::array::uniform9(side), -3.0..3.0_f64, -1.5..1.5_f64).prop_filter_map(
            "seen from behind",
            |(n, phi, lift)| {
                let centre = crate::kernels::sphere::direction(lift + 1.57, phi);
                let (u, v) = (DVec3::new(n[0], n[1], n[2]), DVec3::new(n[3], n[4], n[5]));
                let matrix = DMat3::from_cols(u, v, centre - 0.5 * (u + v));
                (matrix.determinant() > 1e-3).then_some(matrix)
            },
        )
    }

    proptest! {
        #[test]
        fn four_corners_give_back_their_parallelogram(matrix in matrix()) {
            let again = matrix_of_corners(corners(&matrix)).expect("convex");
            prop_assert!(again.abs_diff_eq(matrix, 1e-7), "{again} {matrix}");
        }

        #[test]
        fn an_upright_card_has_the_same_corners_and_goes_down(matrix in matrix()) {
            let turned = upright(&matrix);
            prop_assert!(turned.y_axis.reject_from(centre(&matrix)).y <= 1e-9);
            prop_assert!(turned.determinant() > 0.0);
            let sum = |matrix: &DMat3| corners(matrix).into_iter().sum::<DVec3>();
            prop_assert!(sum(&turned).abs_diff_eq(sum(&matrix), 1e-9));
        }

        #[test]
        fn the_place_of_a_point_is_where_it_was_put(matrix in matrix(), a in 0.0..1.0_f64, b in 0.0..1.0_f64) {
            let place = place_of(&matrix.inverse(), point(&matrix, DVec2::new(a, b))).expect("in front");
            prop_assert!(place.abs_diff_eq(DVec2::new(a, b), 1e-7));
            prop_assert!(is_inside(place.clamp(DVec2::ZERO, DVec2::ONE), false));
        }
    }

    #[test]
    fn corners_in_the_wrong_order_have_no_parallelogram() {
        let mut four = corners(&square_towards(DVec3::Z, 0.3));
        assert!(matrix_of_corners(four).is_some());
        four.swap(0, 1);
        assert!(matrix_of_corners(four).is_none());
    }
}
