//! `kernels::hierarchy` for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::kernels::hierarchy as kernel;

/// Nodes, (n, 4), and the row of each triangle, leaf by leaf.
type Tree<'py> = (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<u32>>);

/// See `envlights.viewer.model.Model.textures`.
#[pyfunction]
pub fn bounding_volume_hierarchy<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, u16>,
    triangles: PyReadonlyArray2<'py, u32>,
) -> PyResult<Tree<'py>> {
    let (vertices, triangles) = (vertices.as_array(), triangles.as_array());
    let tree = interruptible(py, || kernel::bounding_volume_hierarchy(vertices, triangles))?;
    Ok((ndarray::Array2::from(tree.nodes).into_pyarray(py), tree.order.into_pyarray(py)))
}
