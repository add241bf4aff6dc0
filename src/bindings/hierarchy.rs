//! `kernels::hierarchy` for Python.

use numpy::ndarray::{Array1, Array2};
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
    Ok((Array2::from(tree.nodes).into_pyarray(py), tree.order.into_pyarray(py)))
}

/// Row of the triangle that each ray hits or -1, weights of its second and third corner, and the mask of front sides.
type Hits<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<bool>>);

/// Triangles that rays hit; see `envlights.scene.triangles`.
#[pyclass(frozen)]
pub struct TriangleTree {
    tree: kernel::TriangleTree,
}

#[pymethods]
impl TriangleTree {
    /// Corners, (3 n, 3).
    #[new]
    fn new(py: Python<'_>, corners: PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let corners = corners.as_array();
        Ok(Self { tree: interruptible(py, || kernel::TriangleTree::new(corners))? })
    }

    /// Nearest triangle that each ray hits.
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        origins: PyReadonlyArray2<'py, f64>,
        directions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Hits<'py>> {
        let (origins, directions) = (origins.as_array(), directions.as_array());
        let hits = interruptible(py, || self.tree.nearest_hits(origins, directions))?;
        let rows = hits.iter().map(|hit| hit.map_or(-1, |hit| i64::from(hit.row)));
        let weights: Vec<_> = hits.iter().map(|hit| hit.map_or([0.0; 2], |hit| hit.weights.into())).collect();
        let fronts = hits.iter().map(|hit| hit.is_some_and(|hit| hit.is_front));
        Ok((
            rows.collect::<Array1<_>>().into_pyarray(py),
            Array2::from(weights).into_pyarray(py),
            fronts.collect::<Array1<_>>().into_pyarray(py),
        ))
    }
}
