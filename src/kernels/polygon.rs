//! Irradiance of a convex polygon of radiance 1: Lambert's formula, with the horizon as a further edge.
//!
//! For the unit vectors `p` to the vertices, the vector irradiance is half the sum over all edges of the angle between
//! `p_i` and `p_i+1`, along their unit cross product. A normal n that sees the whole polygon receives `n.V`. Where the
//! horizon of n cuts the polygon, the part in front is a convex polygon with one edge on the horizon.

use glam::DVec3;

/// Half the angle between two vectors along their unit cross product: the term of one edge.
fn edge(from: DVec3, to: DVec3) -> DVec3 {
    let across = from.cross(to);
    let sine = across.length();
    if sine > 0.0 { across * (0.5 * sine.atan2(from.dot(to)) / sine) } else { DVec3::ZERO }
}

/// Vector irradiance of a polygon around these vectors, towards it if they go around as the corners of a card.
pub fn vector_irradiance(around: &[DVec3]) -> DVec3 {
    (0..around.len()).map(|i| edge(around[i], around[(i + 1) % around.len()])).sum()
}

/// Irradiance at a normal, of the part above its horizon; `vector` is the [`vector_irradiance`].
pub fn irradiance(around: &[DVec3], vector: DVec3, normal: DVec3) -> f64 {
    let in_front = around.iter().filter(|vertex| normal.dot(**vertex) > 0.0).count();
    match in_front {
        0 => 0.0,
        n if n == around.len() => normal.dot(vector).max(0.0),
        _ => clipped(around, normal).max(0.0),
    }
}

/// Irradiance of a polygon that the horizon cuts: its edges in front, and the edge from exit to entry.
fn clipped(around: &[DVec3], normal: DVec3) -> f64 {
    let (mut sum, mut exit, mut entry) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for (i, &from) in around.iter().enumerate() {
        let to = around[(i + 1) % around.len()];
        let (height, next) = (normal.dot(from), normal.dot(to));
        let on_horizon = from * next.abs() + to * height.abs();
        match (height > 0.0, next > 0.0) {
            (true, true) => sum += edge(from, to),
            (true, false) => {
                exit = on_horizon;
                sum += edge(from, exit);
            }
            (false, true) => {
                entry = on_horizon;
                sum += edge(entry, to);
            }
            (false, false) => {}
        }
    }
    normal.dot(sum + edge(exit, entry))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Corners of a card of half sizes 1 and `half`, 2 away along +z; from the origin, U goes to the right, to -x.
    fn panel(half: f64) -> Vec<DVec3> {
        [(1.0, half), (-1.0, half), (-1.0, -half), (1.0, -half)].map(|(x, y)| DVec3::new(x, y, 2.0)).to_vec()
    }

    /// Sum over 400 x 400 parts, with the horizon.
    fn by_parts(half: f64, normal: DVec3) -> f64 {
        let n = 400;
        let part = |i: usize| {
            let x = ((i % n) as f64 + 0.5) / n as f64 * 2.0 - 1.0;
            let y = ((i / n) as f64 + 0.5) / n as f64 * 2.0 - 1.0;
            let to = DVec3::new(x, y * half, 2.0);
            normal.dot(to).max(0.0) * 2.0 / to.length_squared().powi(2)
        };
        (0..n * n).map(part).sum::<f64>() * 4.0 * half / (n * n) as f64
    }

    proptest! {
        #[test]
        fn the_horizon_hides_what_a_sum_over_parts_leaves_out(
            theta in 0.0..3.14_f64, phi in 0.0..6.28_f64, half in 0.2..3.0_f64
        ) {
            let (around, normal) = (panel(half), crate::kernels::sphere::direction(theta, phi));
            let received = irradiance(&around, vector_irradiance(&around), normal);
            prop_assert!((received - by_parts(half, normal)).abs() < 2e-4 * (1.0 + half), "{received}");
        }
    }

    #[test]
    fn a_facing_square_has_the_form_factor_of_the_tables() {
        // Howell, configuration C-1 four times: 2 / (pi sqrt(1 + x^2)) * x * atan(x / sqrt(1 + x^2)) each, at x = 1/2.
        let around = panel(1.0);
        let x = 0.5_f64;
        let root = (1.0 + x * x).sqrt();
        let wanted = 4.0 * x / root * (x / root).atan();
        assert!((irradiance(&around, vector_irradiance(&around), DVec3::Z) - wanted).abs() < 1e-12);
    }
}
