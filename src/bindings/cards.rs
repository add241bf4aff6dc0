//! `kernels::cards` for Python.

use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::prelude::*;

use super::output::fill;
use super::sphere::registration;
use crate::kernels::cards::{self, CardCut};
use crate::kernels::sphere;

/// Cards of a map, and the map without them; see `envlights.cards.cut`.
#[pyclass(frozen, get_all)]
pub struct MapCards {
    remainder: Py<PyArray3<f32>>,
    shape: Vec<usize>,
    matrix: Py<PyArray3<f64>>,
    irradiance: Py<PyArray2<f64>>,
    overlap: Py<PyArray1<f64>>,
    radius: Vec<Option<f64>>,
    texture: Vec<Py<PyArray3<f32>>>,
    lights: Vec<Vec<u32>>,
    is_window: Vec<bool>,
}

/// Cards of the lights that were removed from a map; `pixel` are those of lights in blocks.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "arrays of Python")]
pub fn cut_cards(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    rest: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    block: usize,
    pixel: PyReadonlyArray2<'_, i64>,
    light_of_pixel: PyReadonlyArray1<'_, i64>,
    direction: PyReadonlyArray2<'_, f64>,
    radius: PyReadonlyArray1<'_, f64>,
) -> PyResult<MapCards> {
    let (map, other) = (radiance.as_array(), rest.as_array());
    let (pixels, light_of_pixel) = (pixel.as_array(), light_of_pixel.as_array());
    let (directions, radii) = (direction.as_array(), radius.as_array());
    let lights = cards::MapLights { block, pixels, light_of_pixel, directions, radii };
    let (rest, cuts) = fill(py, map.dim().into(), |rest| {
        cards::cut_map(map, other, registration(border_sampled), &lights, rest)
    })?;
    let vectors: Vec<[f64; 3]> = cuts.iter().map(|cut| cut.irradiance.to_array()).collect();
    let rows = |cut: &CardCut| cut.matrix.transpose().to_cols_array_2d();
    let texture = |cut: &CardCut| -> Py<PyArray3<f32>> {
        let [rows, columns] = cut.texture.size;
        let texels = |at: (usize, usize, usize)| cut.texture.texels[at.0 * columns + at.1][at.2];
        Array3::from_shape_fn((rows, columns, 3), texels).into_pyarray(py).unbind()
    };
    Ok(MapCards {
        remainder: rest.unbind(),
        shape: cuts.iter().map(|cut| cut.shape as usize).collect(),
        matrix: Array3::from(cuts.iter().map(rows).collect::<Vec<_>>()).into_pyarray(py).unbind(),
        irradiance: Array2::from(vectors).into_pyarray(py).unbind(),
        overlap: cuts.iter().map(|cut| cut.overlap).collect::<Array1<f64>>().into_pyarray(py).unbind(),
        radius: cuts.iter().map(|cut| cut.radius).collect(),
        texture: cuts.iter().map(texture).collect(),
        lights: cuts.iter().map(|cut| cut.lights.clone()).collect(),
        is_window: cuts.iter().map(|cut| cut.is_window).collect(),
    })
}

/// Map of cards; `texels` holds those of all textures, and `sizes` their rows and columns.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "arrays of Python")]
pub fn draw_cards<'py>(
    py: Python<'py>,
    height: usize,
    width: usize,
    border_sampled: bool,
    matrix: PyReadonlyArray3<'py, f64>,
    is_disc: Vec<bool>,
    irradiance: PyReadonlyArray2<'py, f64>,
    sizes: Vec<[usize; 2]>,
    texels: PyReadonlyArray2<'py, f32>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let (matrix, irradiance, texels) = (matrix.as_array(), irradiance.as_array(), texels.as_array());
    sphere::check_size(height, width).map_err(PyErr::from)?;
    let (map, ()) = fill(py, [height, width, 3], |map| {
        cards::draw_map(matrix, &is_disc, irradiance, &sizes, texels, registration(border_sampled), map)
    })?;
    Ok(map)
}
