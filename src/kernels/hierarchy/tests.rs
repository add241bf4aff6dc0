//! Rays through the hierarchy against rays against every triangle.

use glam::DVec3;
use ndarray::Array2;
use proptest::prelude::*;

use super::nodes::{COUNT_SHIFT, LEAF};
use super::*;
use crate::error::Error;

/// Triangles of a model on the grid.
struct Soup {
    vertices: Array2<u16>,
    triangles: Array2<u32>,
}

impl Soup {
    /// Triangles of three vertices each, (vertices, 3).
    fn new(vertices: Vec<[u16; 3]>) -> Self {
        let triangles = (0..vertices.len() as u32 / 3).map(|row| [3 * row, 3 * row + 1, 3 * row + 2]);
        Self { triangles: Array2::from(triangles.collect::<Vec<_>>()), vertices: Array2::from(vertices) }
    }

    fn hierarchy(&self) -> Hierarchy {
        bounding_volume_hierarchy(self.vertices.view(), self.triangles.view()).unwrap()
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        [0, 1, 2].map(|k| {
            let row = self.vertices.row(self.triangles[[triangle, k]] as usize);
            DVec3::new(f64::from(row[0]), f64::from(row[1]), f64::from(row[2]))
        })
    }

    /// Length of the ray to a triangle (Möller and Trumbore 1997).
    fn hit(&self, triangle: usize, ray: Ray) -> Option<f64> {
        let corners = self.corners(triangle);
        let (one, two) = (corners[1] - corners[0], corners[2] - corners[0]);
        let away = ray.origin - corners[0];
        let (p, q) = (ray.direction.cross(two), away.cross(one));
        let (u, v, length) = (away.dot(p), ray.direction.dot(q), two.dot(q));
        let [u, v, length] = [u, v, length].map(|product| product / one.dot(p));
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && length > 0.0).then_some(length)
    }

    /// Nearest triangle by trying all of them.
    fn nearest_of_all(&self, ray: Ray) -> Option<(usize, f64)> {
        let hits = (0..self.triangles.nrows()).filter_map(|k| Some((k, self.hit(k, ray)?)));
        hits.min_by(|one, two| one.1.total_cmp(&two.1).then(one.0.cmp(&two.0)))
    }

    /// Nearest triangle as the shader finds it, and the number of boxes and of triangles on the way.
    fn nearest(&self, tree: &Hierarchy, ray: Ray) -> (Option<(usize, f64)>, [usize; 2]) {
        let (mut best, mut node, mut visits) = (None::<(usize, f64)>, 0, [0, 0]);
        while node < tree.nodes.len() {
            visits[0] += 1;
            let [.., link] = tree.nodes[node];
            let met = ray.meets(tree.nodes[node], best.map_or(f64::INFINITY, |hit| hit.1));
            node = if met || link & LEAF != 0 { node + 1 } else { link as usize };
            if !met || link & LEAF == 0 {
                continue;
            }
            let first = (link & ((1 << COUNT_SHIFT) - 1)) as usize;
            for &row in &tree.order[first..=first + (link >> COUNT_SHIFT & 15) as usize] {
                visits[1] += 1;
                let Some(length) = self.hit(row as usize, ray) else { continue };
                let is_nearer = |(other, old): (usize, f64)| {
                    length.total_cmp(&old).then((row as usize).cmp(&other)).is_lt()
                };
                if best.is_none_or(is_nearer) {
                    best = Some((row as usize, length));
                }
            }
        }
        (best, visits)
    }
}

/// A ray.
#[derive(Clone, Copy, Debug)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
}

impl Ray {
    /// True if the ray meets the box of a node, enlarged by half a step as in the shader, before `most`.
    fn meets(self, [a, b, c, _]: [u32; 4], most: f64) -> bool {
        let (low, high) = (|pair: u32| f64::from(pair & 0xffff) - 0.5, |pair: u32| f64::from(pair >> 16));
        let lower = DVec3::new(low(a), high(a) - 0.5, low(b));
        let upper = DVec3::new(high(b) + 0.5, low(c) + 1.0, high(c) + 0.5);
        let near = (lower - self.origin) / self.direction;
        let far = (upper - self.origin) / self.direction;
        let (entry, exit) = (near.min(far).max_element(), near.max(far).min_element());
        entry <= exit && exit >= 0.0 && entry <= most
    }
}

/// Triangles of all sizes, thin and degenerate ones among them.
fn vertices() -> impl Strategy<Value = Vec<[u16; 3]>> {
    let triangle = (any::<[u16; 3]>(), 0..16_u32, any::<[[u16; 3]; 2]>()).prop_map(|(at, shift, offsets)| {
        let moved = |by: [u16; 3]| [0, 1, 2].map(|k| at[k].saturating_add(by[k] >> shift));
        [at, moved(offsets[0]), moved(offsets[1])]
    });
    prop::collection::vec(triangle, 1..200).prop_map(|triangles| triangles.concat())
}

/// A ray from anywhere around the grid towards a point of it.
fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let point = || prop::array::uniform3(-30_000.0..95_000.0).prop_map(DVec3::from);
    let ray =
        (point(), point()).prop_map(|(origin, to)| Ray { origin, direction: (to - origin).normalize() });
    prop::collection::vec(ray, 20)
}

proptest! {
    #[test]
    fn rays_meet_the_same_triangles_as_without_a_tree(vertices in vertices(), rays in rays()) {
        let soup = Soup::new(vertices);
        let tree = soup.hierarchy();
        for ray in rays {
            prop_assert_eq!(soup.nearest(&tree, ray).0, soup.nearest_of_all(ray));
        }
    }

    #[test]
    fn nearest_hits_are_those_without_a_tree(vertices in vertices(), rays in rays(), scale in 1e-3..1e3_f64) {
        let soup = Soup::new(vertices);
        let place = |at: DVec3| scale * (at - DVec3::splat(20_000.0));
        let rows = |points: Vec<DVec3>| Array2::from(points.iter().map(DVec3::to_array).collect::<Vec<_>>());
        let corners = (0..soup.triangles.nrows()).flat_map(|k| soup.corners(k)).map(place).collect();
        let tree = TriangleTree::new(rows(corners).view()).unwrap();
        let origins = rows(rays.iter().map(|ray| place(ray.origin)).collect());
        let directions = rows(rays.iter().map(|ray| ray.direction).collect());
        let hits = tree.nearest_hits(origins.view(), directions.view()).unwrap();
        for (ray, hit) in rays.into_iter().zip(hits) {
            // Another scale rounds differently: an edge or a tie may change the row, but not the place.
            let truth = soup.nearest_of_all(ray);
            let point = hit.map(|hit| {
                let [a, b, c] = soup.corners(hit.row as usize);
                a + hit.weights.x * (b - a) + hit.weights.y * (c - a)
            });
            let expected = truth.map(|(_, length)| ray.origin + length * ray.direction);
            match (point, expected) {
                (Some(point), Some(expected)) => prop_assert!((point - expected).length() < 1e-3),
                (point, expected) => prop_assert_eq!(point.is_some(), expected.is_some()),
            }
        }
    }

    #[test]
    fn each_triangle_is_in_one_leaf_and_each_link_points_ahead(vertices in vertices()) {
        let tree = Soup::new(vertices.clone()).hierarchy();
        let mut order = tree.order.clone();
        order.sort_unstable();
        prop_assert!(order.iter().enumerate().all(|(k, &row)| row as usize == k));
        prop_assert_eq!(order.len(), vertices.len() / 3);
        let is_ahead = |(k, node): (usize, &[u32; 4])| {
            node[3] & LEAF != 0 || (k + 1..=tree.nodes.len()).contains(&(node[3] as usize))
        };
        prop_assert!(tree.nodes.iter().enumerate().all(is_ahead));
    }
}

/// Triangles of a bumpy sphere with the given number of rings.
fn bumpy(rings: u16) -> Soup {
    let at = |row: u16, column: u16| {
        let theta = f64::from(row) / f64::from(rings) * std::f64::consts::PI;
        let phi = f64::from(column) / f64::from(rings) * std::f64::consts::PI;
        let radius = 25_000.0 + 5_000.0 * (9.0 * theta).sin() * (7.0 * phi).sin();
        [phi.sin() * theta.sin(), theta.cos(), phi.cos() * theta.sin()]
            .map(|x| (32_768.0 + radius * x) as u16)
    };
    let cells = (0..rings).flat_map(|row| (0..2 * rings).map(move |column| (row, column)));
    Soup::new(
        cells
            .flat_map(|(r, c)| {
                [at(r, c), at(r + 1, c), at(r, c + 1), at(r, c + 1), at(r + 1, c), at(r + 1, c + 1)]
            })
            .collect(),
    )
}

/// Rays between points of a sphere around the grid.
fn through(count: u32) -> impl Iterator<Item = Ray> {
    let point = |k: u32| {
        let y = (f64::from(k) * 0.754_877_666_246_692_7).fract() * 2.0 - 1.0;
        let phi = std::f64::consts::TAU * (f64::from(k) * 0.569_840_290_998_053_2).fract();
        let r = (1.0 - y * y).sqrt();
        DVec3::splat(32_768.0) + 60_000.0 * DVec3::new(r * phi.sin(), y, r * phi.cos())
    };
    (0..count).map(move |k| {
        let (origin, to) = (point(2 * k), point(2 * k + 1));
        Ray { origin, direction: (to - origin).normalize() }
    })
}

#[test]
fn a_ray_visits_few_boxes() {
    let soup = bumpy(160);
    let tree = soup.hierarchy();
    let mut visits = [0.0, 0.0];
    for ray in through(2000) {
        let (_, [boxes, triangles]) = soup.nearest(&tree, ray);
        visits = [visits[0] + boxes as f64 / 2000.0, visits[1] + triangles as f64 / 2000.0];
    }
    assert!(visits[0] < 150.0 && visits[1] < 20.0, "{visits:?}");
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let soup = bumpy(100);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| soup.hierarchy())
    };
    let one = with(1);
    assert!([2, 3, 8].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn equal_triangles_are_split_down_to_full_leaves() {
    let tree = Soup::new([[1, 2, 3], [9, 2, 3], [1, 7, 5]].repeat(100)).hierarchy();
    let counts: Vec<_> = tree
        .nodes
        .iter()
        .filter(|node| node[3] & LEAF != 0)
        .map(|node| (node[3] >> COUNT_SHIFT & 15) + 1)
        .collect();
    assert_eq!(counts.iter().sum::<u32>(), 100);
    assert!(counts.len() <= 8, "{counts:?}");
}

#[test]
fn centres_in_a_geometric_series_do_not_overflow_the_stack() {
    let series = (0..200_000_u32).map(|k| 65_535_u32 >> (k % 17));
    let vertices = series.flat_map(|x| [[x as u16, 0, 0], [x as u16, 1, 0], [x as u16, 0, 1]]);
    let soup = Soup::new(vertices.collect());
    assert_eq!(soup.hierarchy().order.len(), 200_000);
}

#[test]
fn what_is_no_model_is_refused() {
    let vertices = Array2::from(vec![[0_u16, 0, 0], [1, 0, 0], [0, 1, 0]]);
    let of =
        |triangles: Array2<u32>| bounding_volume_hierarchy(vertices.view(), triangles.view()).unwrap_err();
    assert!(matches!(of(Array2::zeros((0, 3))), Error::NoSuchSolid { .. }));
    assert!(matches!(of(Array2::zeros((1, 4))), Error::WrongColumns { .. }));
    assert!(matches!(of(Array2::from(vec![[0, 1, 3]])), Error::OutOfRange { .. }));
}

/// Square of two triangles with a side of 2 around the origin, at the height `z`, with its front towards +z.
fn square(z: f64) -> Vec<[f64; 3]> {
    let corners = [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    [0, 1, 2, 0, 2, 3].map(|k| corners[k]).to_vec()
}

#[test]
fn a_ray_hits_the_nearer_of_two_squares_on_its_visible_side() {
    let corners = Array2::from([square(0.0), square(-1.0)].concat());
    let tree = TriangleTree::new(corners.view()).unwrap();
    let origins = Array2::from(vec![[0.5, -0.5, 2.0], [0.5, -0.5, -3.0], [0.5, -0.5, -0.5], [1.5, 0.0, 2.0]]);
    let down = [0.0, 0.0, -1.0];
    let directions = Array2::from(vec![down, [0.0, 0.0, 1.0], down, down]);
    let hits = tree.nearest_hits(origins.view(), directions.view()).unwrap();
    let seen: Vec<_> = hits.iter().map(|hit| hit.map(|hit| (hit.row, hit.is_front))).collect();
    assert_eq!(seen, [Some((0, true)), Some((2, false)), Some((2, true)), None]);
    let weights = hits[0].unwrap().weights;
    assert!((weights - glam::DVec2::new(0.5, 0.25)).length() < 1e-12, "{weights}");
}

#[test]
fn rays_along_the_faces_of_boxes_are_no_error() {
    let tree = TriangleTree::new(Array2::from(square(0.0)).view()).unwrap();
    let origins = Array2::from(vec![[-1.0, 0.25, 5.0], [-9.0, 0.0, 0.0]]);
    let directions = Array2::from(vec![[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]);
    let hits = tree.nearest_hits(origins.view(), directions.view()).unwrap();
    assert_eq!(hits.iter().map(Option::is_some).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn triangles_and_rays_with_wrong_shapes_are_refused() {
    let of = |corners: Array2<f64>| TriangleTree::new(corners.view()).unwrap_err();
    assert!(matches!(of(Array2::zeros((0, 3))), Error::NoSuchSolid { .. }));
    assert!(matches!(of(Array2::zeros((4, 3))), Error::LengthMismatch { .. }));
    assert!(matches!(of(Array2::zeros((3, 2))), Error::WrongColumns { .. }));
    assert!(matches!(of(Array2::from_elem((3, 3), f64::NAN)), Error::NotFinite { .. }));
    let tree = TriangleTree::new(Array2::from(square(0.0)).view()).unwrap();
    let error = tree.nearest_hits(Array2::zeros((2, 3)).view(), Array2::zeros((1, 3)).view()).unwrap_err();
    assert!(matches!(error, Error::LengthMismatch { .. }));
}
