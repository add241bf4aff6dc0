//! `kernels::madsen` for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::{interruptible, without_gil};
use super::sphere::registration;
use crate::kernels::madsen::{self, Parameters, ProbeValues, Surface};

/// See `envlights.kernels.face_radiance`.
#[pyfunction]
pub fn face_radiance<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    faces: usize,
    border_sampled: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let radiance = radiance.as_array();
    let out = interruptible(py, || madsen::face_radiance(radiance, registration(border_sampled), faces))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.pack_lights`.
#[pyfunction]
pub fn pack_lights<'py>(
    py: Python<'py>,
    ambient: PyReadonlyArray1<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (ambient, directions) = (ambient.as_array(), directions.as_array());
    let irradiance = irradiance.as_array();
    let out = without_gil(py, || madsen::pack(ambient, directions, irradiance))?;
    Ok(out.into_pyarray(py))
}

type Lights<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// See `envlights.kernels.unpack_lights`.
#[pyfunction]
pub fn unpack_lights<'py>(py: Python<'py>, x: PyReadonlyArray1<'py, f64>) -> PyResult<Lights<'py>> {
    let x = x.as_array();
    let (ambient, directions, irradiance) = without_gil(py, || {
        let parts = Parameters::unpack(x)?;
        Ok((parts.ambient, parts.directions(), parts.irradiance()))
    })?;
    let ambient = PyArray1::from_slice(py, ambient.as_ref());
    Ok((ambient, directions.into_pyarray(py), irradiance.into_pyarray(py)))
}

/// Ambient and diffuse coefficient and colour of a surface.
type Coefficients = (f64, f64, [f64; 3]);

fn surface_of((k_a, k_d, colour): Coefficients) -> Surface {
    Surface { k_a, k_d, colour: colour.into() }
}

/// See `envlights.kernels.probe_model`.
#[pyfunction]
pub fn probe_model<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    surface: Coefficients,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (x, normals) = (x.as_array(), normals.as_array());
    let surface = surface_of(surface);
    let out = interruptible(py, || madsen::model(x, normals, &surface))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.probe_residual`.
#[pyfunction]
pub fn probe_residual<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    probe: PyReadonlyArray2<'py, f64>,
    weights: PyReadonlyArray1<'py, f64>,
    surface: Coefficients,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (x, normals, probe, weights) =
        (x.as_array(), normals.as_array(), probe.as_array(), weights.as_array());
    let surface = surface_of(surface);
    let out = interruptible(py, || {
        let measured = ProbeValues::new(normals, probe, weights)?;
        madsen::residual(x, &measured, &surface)
    })?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.probe_jacobian`.
#[pyfunction]
pub fn probe_jacobian<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    probe: PyReadonlyArray2<'py, f64>,
    weights: PyReadonlyArray1<'py, f64>,
    surface: Coefficients,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (x, normals, probe, weights) =
        (x.as_array(), normals.as_array(), probe.as_array(), weights.as_array());
    let surface = surface_of(surface);
    let out = interruptible(py, || {
        let measured = ProbeValues::new(normals, probe, weights)?;
        madsen::jacobian(x, &measured, &surface)
    })?;
    Ok(out.into_pyarray(py))
}
