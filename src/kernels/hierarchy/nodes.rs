//! Nodes in depth-first order, with skip links: a ray needs no stack.
//!
//! Boxes are split by the surface area heuristic (Goldsmith and Salmon 1987), swept along the longest axis. On a bumpy
//! sphere and on loose triangles, sweeps along all axes save a ray at most 4 % of the boxes.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::interrupt;

/// Bit of a link that marks a leaf.
pub const LEAF: u32 = 1 << 31;
/// Lowest of the four bits that hold the number of boxes of a leaf, less one.
pub const COUNT_SHIFT: u32 = 27;
/// Largest number of triangles in a leaf, which its four bits can hold.
const MOST_IN_LEAF: usize = 16;
/// Cost of a ray that meets a triangle, four texels, relative to that of a box, one texel.
const TRIANGLE_COST: f64 = 3.0;
/// Triangles of a part from which its two halves are built in parallel.
const FEW: usize = 4096;
/// Depth from which parts are halved. Centres in a geometric series would be split off one by one.
const DEEP: usize = 64;

/// Box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisBox {
    /// Smallest coordinates.
    pub lower: DVec3,
    /// Largest coordinates.
    pub upper: DVec3,
}

impl AxisBox {
    /// Smallest box around points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        let boxes = points.into_iter().map(|point| Self { lower: point, upper: point });
        boxes.fold(Self { lower: DVec3::INFINITY, upper: DVec3::NEG_INFINITY }, Self::union)
    }

    fn union(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    fn half_area(self) -> f64 {
        let sides = self.upper - self.lower;
        sides.dot(DVec3::new(sides.y, sides.z, sides.x))
    }

    fn twice_centre(self) -> DVec3 {
        self.lower + self.upper
    }
}

/// Node of a tree.
///
/// After a hit of the box the next node follows, after a miss the node of the link. The link of a leaf is [`LEAF`], its
/// number of triangles less one, and its first triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxNode {
    /// Box around all triangles below.
    pub bounds: AxisBox,
    /// Place at which a ray goes on.
    pub link: u32,
}

impl BoxNode {
    /// Triangles of a leaf, in the order of the tree.
    pub fn leaf(self) -> Option<std::ops::Range<usize>> {
        let first = (self.link & ((1 << COUNT_SHIFT) - 1)) as usize;
        (self.link & LEAF != 0).then(|| first..first + (self.link >> COUNT_SHIFT & 15) as usize + 1)
    }
}

/// Nodes around boxes of triangles, and the row of each triangle, leaf by leaf.
///
/// # Errors
///
/// [`Error::NoSuchSolid`] without a triangle or with more than 2^27.
pub fn box_nodes(boxes: impl Iterator<Item = AxisBox>) -> Result<(Vec<BoxNode>, Vec<u32>)> {
    let mut items: Vec<_> = boxes.zip(0..).collect();
    if items.is_empty() || items.len() >= 1 << COUNT_SHIFT {
        return Err(Error::NoSuchSolid { what: "a model must have from 1 to 2^27 - 1 triangles" });
    }
    let nodes = subtree(&mut items, 0, 0);
    Ok((nodes, items.into_iter().map(|(_, row)| row).collect()))
}

/// Nodes of a part, with links relative to the first of them.
fn subtree(items: &mut [(AxisBox, u32)], first: u32, depth: usize) -> Vec<BoxNode> {
    interrupt::check();
    let bounds = items.iter().map(|item| item.0).reduce(AxisBox::union).expect("no part is empty");
    let Some(count) = split(items, bounds, depth) else {
        return vec![BoxNode { bounds, link: LEAF | (items.len() as u32 - 1) << COUNT_SHIFT | first }];
    };
    let is_large = items.len() >= FEW;
    let (one, other) = items.split_at_mut(count);
    let mut below = || subtree(one, first, depth + 1);
    let mut above = || subtree(other, first + count as u32, depth + 1);
    let (below, above) = if is_large { rayon::join(below, above) } else { (below(), above()) };
    let mut nodes = vec![BoxNode { bounds, link: 0 }];
    for part in [below, above] {
        let shift = nodes.len() as u32;
        let moved = |link: u32| if link & LEAF == 0 { link + shift } else { link };
        nodes.extend(part.into_iter().map(|node| BoxNode { link: moved(node.link), ..node }));
    }
    nodes[0].link = nodes.len() as u32;
    nodes
}

/// Sort a part along its longest axis, and count the items below the cheapest plane; `None` if a leaf is cheaper.
fn split(items: &mut [(AxisBox, u32)], bounds: AxisBox, depth: usize) -> Option<usize> {
    let centres = AxisBox::around(items.iter().map(|item| item.0.twice_centre()));
    let axis = (centres.upper - centres.lower).max_position();
    items.sort_unstable_by(|(one, row), (other, next)| {
        one.twice_centre()[axis].total_cmp(&other.twice_centre()[axis]).then(row.cmp(next))
    });
    let below = running_costs(items.iter());
    let above = running_costs(items.iter().rev());
    let all = items.len();
    // Of equal costs, as of equal boxes, take the most even parts.
    let costs = (1..all).map(|k| (below[k - 1] + above[all - k - 1], k.abs_diff(all / 2), k));
    let best = costs.min_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    let leaf_cost = below[all - 1] - 2.0 * bounds.half_area();
    let (.., count) = best.filter(|&(cost, ..)| all > MOST_IN_LEAF || cost < leaf_cost)?;
    Some(if depth < DEEP { count } else { all / 2 })
}

/// Area times cost of triangles, for the first item, the first two, and so on.
fn running_costs<'a>(items: impl Iterator<Item = &'a (AxisBox, u32)>) -> Vec<f64> {
    let mut bounds = AxisBox::around([]);
    let costs = items.enumerate().map(|(k, item)| {
        bounds = bounds.union(item.0);
        TRIANGLE_COST * bounds.half_area() * (k as f64 + 1.0)
    });
    costs.collect()
}
