//! Places on a grid in each pixel: as lines for look-ups, and as nodes of integrals.

use glam::{DMat3, DVec3};

use super::directions::{DirectionArrays, Line, Places};
use super::interface::SphereProjection;

/// Places that are even in x and y.
pub struct EvenPlaces<'a, P> {
    pub projection: &'a P,
    pub side: usize,
    pub turn: DMat3,
}

impl<P: SphereProjection> Places for EvenPlaces<'_, P> {
    fn directions(&self, line: &Line, out: &mut DirectionArrays) {
        let step = 1.0 / self.side as f64;
        let y = line.row as f64 + (line.line as f64 + 0.5) * step;
        for index in 0..line.columns * self.side {
            let x = line.first as f64 + (index as f64 + 0.5) * step;
            let direction = self.projection.direction(x, y);
            out.set(index, direction.map_or(DVec3::NAN, |direction| self.turn * direction));
        }
    }
}

/// Nodes along the side of a pixel that is cut by the edge of the picture of the sphere: 0.01 of its width.
const CUT_SIDE: usize = 32;

/// One node of a quadrature over a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub direction: DVec3,
    /// Fraction of the pixel's solid angle.
    pub weight: f64,
}

/// Integral of the direction over a pixel.
pub fn moment<P: SphereProjection>(projection: &P, pixel: usize) -> DVec3 {
    let nodes = nodes(projection, pixel);
    let sum: DVec3 = nodes.iter().map(|node| node.weight * node.direction).sum();
    sum * projection.solid_angle(pixel)
}

/// Nodes of Gauss and Legendre in a pixel, for accurate integrals; see [`nodes_of`].
pub fn nodes<P: SphereProjection + ?Sized>(projection: &P, pixel: usize) -> Vec<Node> {
    let nodes = nodes_of(projection, pixel, &gauss_legendre(4));
    if nodes.len() == 16 {
        return nodes;
    }
    let fine = nodes_of(projection, pixel, &gauss_legendre(CUT_SIDE));
    // The picture may show a sliver at the edge of the pixel only.
    let closed = || (0..=CUT_SIDE).map(|i| (i as f64 / CUT_SIDE as f64, 1.0)).collect::<Vec<_>>();
    if fine.is_empty() { nodes_of(projection, pixel, &closed()) } else { fine }
}

/// Nodes on a grid of equal cells in a pixel, for even distributions; see [`nodes_of`].
///
/// A pixel that is cut by the edge of the picture gets the nodes of [`nodes`].
pub fn even_nodes<P: SphereProjection + ?Sized>(projection: &P, pixel: usize, side: usize) -> Vec<Node> {
    let step = 1.0 / side as f64;
    let rule: Vec<_> = (0..side).map(|i| ((i as f64 + 0.5) * step, step)).collect();
    let even = nodes_of(projection, pixel, &rule);
    let is_cut = even.len() < rule.len() * rule.len();
    if is_cut { nodes(projection, pixel) } else { even }
}

/// Nodes of a pixel by a rule for both sides, those outside of the picture left out; their weights sum to 1.
fn nodes_of<P: SphereProjection + ?Sized>(projection: &P, pixel: usize, rule: &[(f64, f64)]) -> Vec<Node> {
    let width = projection.size()[1];
    let (row, column) = (pixel / width, pixel % width);
    let mut nodes = Vec::with_capacity(rule.len() * rule.len());
    for &(down, height) in rule {
        for &(across, breadth) in rule {
            let (x, y) = (column as f64 + across, row as f64 + down);
            if let Some(direction) = projection.direction(x, y) {
                nodes.push(Node { direction, weight: height * breadth * projection.density(x, y) });
            }
        }
    }
    let sum: f64 = nodes.iter().map(|node| node.weight).sum();
    for node in &mut nodes {
        node.weight /= sum;
    }
    nodes
}

/// Positions and weights on 0 to 1: Gauss and Legendre's four points in each of `side / 4` intervals.
pub(super) fn gauss_legendre(side: usize) -> Vec<(f64, f64)> {
    const POINTS: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    let intervals = side.div_ceil(4);
    let scale = 1.0 / intervals as f64;
    (0..intervals)
        .flat_map(|i| POINTS.map(|(at, weight)| ((i as f64 + at) * scale, weight * scale)))
        .collect()
}

/// Methods of layouts whose pixels have no closed form; a trait object cannot have them by default.
macro_rules! pixel_by_pixel {
    () => {
        fn pixels(&self, directions: &super::directions::DirectionArrays, pixels: &mut [u32]) {
            super::interface::search(self, directions, pixels);
        }

        fn places(&self, side: usize, turn: glam::DMat3) -> Box<dyn super::directions::Places + '_> {
            Box::new(super::places::EvenPlaces { projection: self, side, turn })
        }

        fn moment(&self, pixel: usize) -> DVec3 {
            super::places::moment(self, pixel)
        }
    };
}
pub(super) use pixel_by_pixel;
