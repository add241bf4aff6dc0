//! The nodes of a model as texels of a shader.

use glam::DVec3;
use ndarray::{ArrayView2, Axis};

use super::nodes::{AxisBox, BoxNode, box_nodes};
use crate::error::{Error, Result};

/// Nodes of a hierarchy, and the order of its triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hierarchy {
    /// One node a row: lower x and y, lower z and upper x, upper y and z, and the link of the [`BoxNode`].
    ///
    /// The low 16 bits hold the first of two coordinates.
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
    for (what, shape) in [("vertices", vertices.shape()), ("triangles", triangles.shape())] {
        if shape[1] != 3 {
            return Err(Error::WrongColumns { what, columns: 3, shape: shape.to_vec() });
        }
    }
    if let Some(&vertex) = triangles.iter().find(|&&vertex| vertex as usize >= vertices.nrows()) {
        let most = vertices.nrows() as f64 - 1.0;
        return Err(Error::OutOfRange { what: "triangles", value: f64::from(vertex), least: 0.0, most });
    }
    let corner = |&row: &u32| DVec3::from([0, 1, 2].map(|axis| f64::from(vertices[[row as usize, axis]])));
    let boxes = triangles.axis_iter(Axis(0)).map(|rows| AxisBox::around(rows.into_iter().map(corner)));
    let (nodes, order) = box_nodes(boxes)?;
    Ok(Hierarchy { nodes: nodes.into_iter().map(texel).collect(), order })
}

fn texel(BoxNode { bounds, link }: BoxNode) -> [u32; 4] {
    let pair = |low: f64, high: f64| low as u32 | (high as u32) << 16;
    let (low, high) = (bounds.lower, bounds.upper);
    [pair(low.x, low.y), pair(low.z, high.x), pair(high.y, high.z), link]
}
