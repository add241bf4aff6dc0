//! Solid angles of the cells of a plane at distance 1.

/// Solid angle of the rectangle from (0, 0) to (x, y), with the sign of x y.
fn corner_angle(x: f64, y: f64) -> f64 {
    (x * y).atan2((1.0 + x * x + y * y).sqrt())
}

/// Solid angles of the cells between lines of x and lines of y, row after row.
pub fn plane_angles(x_edges: &[f64], y_edges: &[f64]) -> Vec<f64> {
    let line = |y: f64| -> Vec<f64> { x_edges.iter().map(|&x| corner_angle(x, y)).collect() };
    let mut angles = Vec::with_capacity(x_edges.len() * y_edges.len());
    let mut above = line(y_edges[0]);
    for &y in &y_edges[1..] {
        let below = line(y);
        let cells = above.windows(2).zip(below.windows(2));
        angles.extend(cells.map(|(a, b)| ((b[1] - b[0]) - (a[1] - a[0])).abs()));
        above = below;
    }
    angles
}

/// Solid angle for each unit of area at a place of the plane.
pub fn plane_density(x: f64, y: f64) -> f64 {
    (1.0 + x * x + y * y).powf(-1.5)
}
