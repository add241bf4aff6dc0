//! Irradiance of a convex polygon of radiance 1: Lambert's formula, with the horizon as a further edge.
//!
//! The vector irradiance V is half the sum over all edges of the angle between the vectors to both vertices, along their
//! unit cross product. A normal n that sees the whole polygon receives `n.V`. Where the horizon of n cuts the polygon,
//! the part in front is a convex polygon with one edge on the horizon.

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
    match around.iter().filter(|vertex| normal.dot(**vertex) > 0.0).count() {
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
        if height > 0.0 && next <= 0.0 {
            exit = on_horizon;
        } else if height <= 0.0 && next > 0.0 {
            entry = on_horizon;
        }
        let start = if height > 0.0 { from } else { entry };
        let end = if next > 0.0 { to } else { exit };
        if height > 0.0 || next > 0.0 {
            sum += edge(start, end);
        }
    }
    normal.dot(sum + edge(exit, entry))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square of 2 x 2 at the height 1 over the origin, its corners as of a card that shines down.
    const SQUARE: [DVec3; 4] = [
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(-1.0, 1.0, 1.0),
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, 1.0, -1.0),
    ];

    fn at(normal: DVec3) -> f64 {
        irradiance(&SQUARE, vector_irradiance(&SQUARE), normal)
    }

    /// Four quadrants with the form factor of a corner (Howell, C-12), times pi.
    #[test]
    fn a_square_overhead_has_the_form_factor_of_the_tables() {
        let quadrant = (0.5_f64.sqrt()) * (0.5_f64.sqrt()).atan();
        assert!((at(DVec3::Y) - 4.0 * quadrant).abs() < 1e-12, "{} {}", at(DVec3::Y), 4.0 * quadrant);
    }

    /// The parts of the two sides of the horizon add up to the whole vector.
    #[test]
    fn opposite_normals_share_what_the_horizon_cuts() {
        let vector = vector_irradiance(&SQUARE);
        for normal in [DVec3::new(1.0, 0.2, 0.3), DVec3::new(0.7, -0.5, 0.1), DVec3::new(-0.2, 0.1, 1.0)] {
            let normal = normal.normalize();
            let [front, back] = [at(normal), at(-normal)];
            assert!(front > 0.0 && back > 0.0);
            assert!((front - back - normal.dot(vector)).abs() < 1e-12, "{front} {back}");
        }
        assert!(at(-DVec3::Y) == 0.0);
    }
}
