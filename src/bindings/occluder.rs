//! `kernels::occluder` for Python.

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::error::{Error, Result};
use crate::kernels::occluder::{self as kernel, Ball, Polyhedron, Receivers, Solid, Sources, Surroundings};
use crate::kernels::sphere::{check_lengths, unit_vectors, vectors};

/// A solid: `envlights.occluders.Ball` or `envlights.occluders.Polyhedron`.
#[derive(FromPyObject)]
enum Shape {
    Ball { centre: [f64; 3], radius: f64 },
    Polyhedron { vertices: Vec<[f64; 3]>, faces: Vec<Vec<usize>> },
}

impl Shape {
    /// Solid of the kernel.
    fn for_kernel(self) -> Result<Solid> {
        match self {
            Self::Ball { centre, radius } => Ok(Solid::Ball(Ball { centre: centre.into(), radius })),
            Self::Polyhedron { vertices, faces } => {
                let vertices = vertices.into_iter().map(Into::into).collect();
                Ok(Solid::Polyhedron(Polyhedron::new(vertices, &faces)?))
            }
        }
    }
}

/// Solids, and points of surfaces; a scene of `envlights.occluders`.
#[derive(FromPyObject)]
pub struct Stage<'py> {
    solids: Vec<Shape>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    /// Solid of each point, or -1.
    own: PyReadonlyArray1<'py, i64>,
}

impl Stage<'_> {
    /// Solids and receivers of the kernel.
    fn for_kernel(self) -> Result<(Vec<Solid>, Receivers)> {
        let solids = self.solids.into_iter().map(Shape::for_kernel).collect::<Result<Vec<_>>>()?;
        let points = vectors("points", self.points.as_array())?;
        let normals = unit_vectors("normals", self.normals.as_array())?;
        let own: Vec<_> = self.own.as_array().iter().map(|&solid| usize::try_from(solid).ok()).collect();
        check_lengths("points", points.len(), [("normals", normals.len()), ("own", own.len())])?;
        if let Some(&index) = own.iter().flatten().find(|&&index| index >= solids.len()) {
            let most = solids.len() as f64 - 1.0;
            return Err(Error::OutOfRange { what: "own", value: index as f64, least: -1.0, most });
        }
        Ok((solids, Receivers { points, normals, own }))
    }
}

/// Discs of the kernel.
fn sources(
    directions: PyReadonlyArray2<'_, f64>,
    radii: PyReadonlyArray1<'_, f64>,
    floor: bool,
) -> Result<Sources> {
    let directions = unit_vectors("direction", directions.as_array())?;
    let radii = radii.as_array().to_vec();
    check_lengths("directions", directions.len(), [("angular_radius", radii.len())])?;
    Ok(Sources::new(&directions, &radii, floor))
}

/// See `envlights.kernels.hidden_fractions`.
#[pyfunction]
pub fn hidden_fractions<'py>(
    py: Python<'py>,
    stage: Stage<'py>,
    directions: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    floor: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (solids, receivers) = stage.for_kernel()?;
    let sources = sources(directions, radii, floor)?;
    let out = interruptible(py, || Ok(kernel::hidden_fractions(&receivers, &sources, &solids)))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.form_factors`.
#[pyfunction]
pub fn form_factors<'py>(py: Python<'py>, stage: Stage<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (solids, receivers) = stage.for_kernel()?;
    let out = interruptible(py, || Ok(kernel::form_factors(&receivers, &solids)))?;
    Ok(out.into_pyarray(py))
}

/// A rig and the albedos of a scene.
#[derive(FromPyObject)]
pub struct Lighting<'py> {
    directions: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
    ambient: [f64; 3],
    albedo: Vec<[f64; 3]>,
    floor_albedo: [f64; 3],
    floor: bool,
}

/// See `envlights.kernels.reflected_irradiance`.
#[pyfunction]
pub fn reflected_irradiance<'py>(
    py: Python<'py>,
    stage: Stage<'py>,
    lighting: Lighting<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (solids, receivers) = stage.for_kernel()?;
    let surroundings = Surroundings {
        ambient: lighting.ambient.into(),
        irradiance: vectors("irradiance", lighting.irradiance.as_array())?,
        albedo: lighting.albedo.into_iter().map(Into::into).collect(),
        floor_albedo: lighting.floor_albedo.into(),
    };
    let sources = sources(lighting.directions, lighting.radii, lighting.floor)?;
    check_lengths("irradiance", surroundings.irradiance.len(), [("directions", sources.discs())])?;
    check_lengths("solids", solids.len(), [("albedo", surroundings.albedo.len())])?;
    let out =
        interruptible(py, || Ok(kernel::received_irradiance(&receivers, &sources, &solids, &surroundings)))?;
    Ok(out.into_pyarray(py))
}
