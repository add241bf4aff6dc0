//! Nodes in depth-first order, with skip links: a ray needs no stack.

use ndarray::{ArrayView2, Axis};
use rayon::prelude::*;

use super::grid_box::GridBox;
use super::surface_area::{Item, split};
use crate::error::{Error, Result};
use crate::interrupt;

/// Bit of a link that marks a leaf.
pub const LEAF: u32 = 1 << 31;
/// Lowest of the four bits that hold the number of triangles of a leaf, less one.
pub const COUNT_SHIFT: u32 = 27;
/// Triangles of a part from which its two halves are built in parallel.
const FEW: usize = 4096;

/// Nodes of a hierarchy, and the order of its triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hierarchy {
    /// One node a row: lower x and y, lower z and upper x, upper y and z, and a link.
    ///
    /// The low 16 bits hold the first of two coordinates. After a hit of the box the next node follows, after a miss
    /// the node of the link. The link of a leaf is [`LEAF`], its number of triangles less one, and its first triangle.
    pub nodes: Vec<[u32; 4]>,
    /// Row of each triangle, leaf by leaf.
    pub order: Vec<u32>,
}

/// Bounding volume hierarchy of triangles, whose vertices are steps of a grid.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NoSuchSolid`] without a triangle or with more than 2^27, [`Error::OutOfRange`]
/// for a vertex that does not exist.
pub fn bounding_volume_hierarchy(
    vertices: ArrayView2<'_, u16>,
    triangles: ArrayView2<'_, u32>,
) -> Result<Hierarchy> {
    for (what, columns, shape) in [
        ("vertices", vertices.ncols(), vertices.shape()),
        ("triangles", triangles.ncols(), triangles.shape()),
    ] {
        if columns != 3 {
            return Err(Error::WrongColumns { what, columns: 3, shape: shape.to_vec() });
        }
    }
    if triangles.is_empty() || triangles.nrows() >= 1 << COUNT_SHIFT {
        return Err(Error::NoSuchSolid { what: "a model must have from 1 to 2^27 - 1 triangles" });
    }
    if let Some(&vertex) = triangles.iter().find(|&&vertex| vertex as usize >= vertices.nrows()) {
        let most = vertices.nrows() as f64 - 1.0;
        return Err(Error::OutOfRange { what: "triangles", value: f64::from(vertex), least: 0.0, most });
    }
    let corner = |vertex: u32| [0, 1, 2].map(|axis| vertices[[vertex as usize, axis]]);
    let rows = triangles.axis_iter(Axis(0)).into_par_iter().enumerate();
    let items = rows.map(|(triangle, row)| Item {
        bounds: GridBox::around([0, 1, 2].map(|k| corner(row[k]))),
        triangle: triangle as u32,
    });
    let mut hierarchy = subtree(items.collect());
    hierarchy.set_first_triangles();
    Ok(hierarchy)
}

/// Nodes of a part, with links relative to the first of them. Depth: the grid has 2^17 centres along an axis, and each
/// split by bins removes a sixteenth of a span, so at most 600.
fn subtree(items: Vec<Item>) -> Hierarchy {
    interrupt::check();
    let bounds = items.iter().fold(GridBox::EMPTY, |sum, item| sum.union(item.bounds));
    let count = items.len();
    match split(items, bounds) {
        Err(items) => {
            let link = LEAF | (items.len() as u32 - 1) << COUNT_SHIFT;
            let order = items.iter().map(|item| item.triangle).collect();
            Hierarchy { nodes: vec![texel(bounds, link)], order }
        }
        Ok([below, above]) => {
            let (below, above) = if count >= FEW {
                rayon::join(|| subtree(below), || subtree(above))
            } else {
                (subtree(below), subtree(above))
            };
            let mut joined = Hierarchy { nodes: vec![texel(bounds, 0)], order: Vec::with_capacity(count) };
            joined.append(below);
            joined.append(above);
            joined.nodes[0][3] = joined.nodes.len() as u32;
            joined
        }
    }
}

/// Texel of a node.
fn texel(bounds: GridBox, link: u32) -> [u32; 4] {
    let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
    let (low, high) = (bounds.lower, bounds.upper);
    [pair(low[0], low[1]), pair(low[2], high[0]), pair(high[1], high[2]), link]
}

impl Hierarchy {
    /// Append a subtree: its links are relative to its first node.
    fn append(&mut self, part: Self) {
        let shift = self.nodes.len() as u32;
        self.nodes.extend(
            part.nodes
                .into_iter()
                .map(|[a, b, c, link]| [a, b, c, if link & LEAF == 0 { link + shift } else { link }]),
        );
        self.order.extend(part.order);
    }

    /// Write the first triangle of each leaf into its link.
    fn set_first_triangles(&mut self) {
        let mut first = 0;
        for [.., link] in self.nodes.iter_mut().filter(|node| node[3] & LEAF != 0) {
            *link |= first;
            first += (*link >> COUNT_SHIFT & 15) + 1;
        }
    }
}
