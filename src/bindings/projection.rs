//! `kernels::projection` and the resampling between layouts for Python.

use glam::{DMat3, DVec2, DVec3};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::output::fill;
use super::pool::interruptible;
use crate::error::{Error, Result};
use crate::kernels::image::{SourcePicture, resample as resample_picture};
use crate::kernels::projection::{Equirectangular, PictureNumbers, SphereProjection, projection_of};
use crate::kernels::sphere::{check_rows, unit_vectors};

/// The named tuple of `envlights.environment.layouts.picture_layout`.
#[derive(FromPyObject)]
pub struct PictureLayout {
    kind: String,
    height: usize,
    width: usize,
    border_sampled: bool,
    whole: Option<[usize; 2]>,
    corner: [usize; 2],
    field_of_view: f64,
    horizon: Option<f64>,
    mapping: String,
    reach: f64,
    circle: Option<(f64, f64, f64)>,
    /// Forward, right and up of the picture.
    axes: [[f64; 3]; 3],
}

impl PictureLayout {
    /// The layout, or a refusal of numbers that no such picture has.
    fn layout(&self) -> Result<Box<dyn SphereProjection>> {
        let numbers = PictureNumbers {
            size: [self.height, self.width],
            border_sampled: self.border_sampled,
            whole: self.whole,
            corner: self.corner,
            field_of_view: self.field_of_view,
            horizon: self.horizon,
            mapping: self.mapping.clone(),
            reach: self.reach,
            circle: self.circle,
        };
        projection_of(&self.kind, &numbers)
    }

    /// Matrix from the frame of the picture to that of the world: a rotation, also with a mirror.
    fn to_world(&self) -> Result<DMat3> {
        let [forward, right, up] = self.axes.map(DVec3::from_array);
        let axes = DMat3::from_cols(-right, up, forward);
        let error = axes.transpose() * axes - DMat3::IDENTITY;
        let is_orthonormal = error.to_cols_array().iter().all(|value| value.abs() < 1e-6);
        if is_orthonormal {
            Ok(axes)
        } else {
            Err(Error::NoSuchLayout { what: "the axes of a picture must be orthogonal unit vectors" })
        }
    }
}

type ResampleResult<'py> = (Bound<'py, PyArray3<f32>>, Option<Bound<'py, PyArray2<f32>>>);

/// See `envlights.environment.resample`; `matrix` has its rows in order.
#[pyfunction]
pub fn resample<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    seen: Option<PyReadonlyArray2<'py, f32>>,
    source: PictureLayout,
    target: PictureLayout,
    matrix: [[f64; 3]; 3],
) -> PyResult<ResampleResult<'py>> {
    let rotation = DMat3::from_cols_array_2d(&matrix).transpose();
    let (from, to, rotation) = interruptible(py, || {
        let rotation = target.to_world()?.transpose() * rotation * source.to_world()?;
        Ok((source.layout()?, target.layout()?, rotation))
    })?;
    let (radiance, seen) = (radiance.as_array(), seen.as_ref().map(PyReadonlyArray2::as_array));
    let picture = SourcePicture { radiance, seen, layout: &*from };
    let [height, width] = to.size();
    let (image, seen) = fill(py, [height, width, 3], |out| resample_picture(&picture, &*to, rotation, out))?;
    Ok((image, seen.map(|seen| seen.into_pyarray(py))))
}

/// Rotate a cell-centred map; see `resample`.
#[pyfunction]
pub fn rotate_map<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    matrix: [[f64; 3]; 3],
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let rotation = DMat3::from_cols_array_2d(&matrix).transpose();
    let radiance = radiance.as_array();
    let (height, width, channels) = radiance.dim();
    let (rotated, _) = fill(py, [height, width, channels], |out| {
        let layout = Equirectangular::new([height, width]);
        let picture = SourcePicture { radiance, seen: None, layout: &layout };
        resample_picture(&picture, &layout, rotation, out)
    })?;
    Ok(rotated)
}

/// Solid angle of each pixel of a layout.
#[pyfunction]
pub fn projection_solid_angles(py: Python<'_>, layout: PictureLayout) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let angles = interruptible(py, || {
        let layout = layout.layout()?;
        let [height, width] = layout.size();
        Ok(Array2::from_shape_fn((height, width), |(row, column)| layout.solid_angle(row * width + column)))
    })?;
    Ok(angles.into_pyarray(py))
}

/// Directions of places (x, y) of a layout, (n, 3); NaN outside of the picture.
#[pyfunction]
pub fn projection_directions<'py>(
    py: Python<'py>,
    layout: PictureLayout,
    places: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let places = places.as_array();
    let directions = interruptible(py, || {
        let (layout, to_world) = (layout.layout()?, layout.to_world()?);
        let [height, width] = layout.size().map(|pixels| pixels as f64);
        let direction = |x: f64, y: f64| {
            let is_inside = (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
            to_world * layout.direction(x, y).filter(|_| is_inside).unwrap_or(DVec3::NAN)
        };
        check_rows("places", places, 2)?;
        Ok(rows(places.nrows(), |i| direction(places[[i, 0]], places[[i, 1]]).to_array()))
    })?;
    Ok(directions.into_pyarray(py))
}

/// Places (x, y) of unit directions in a layout, (n, 2); NaN for those that it does not show.
#[pyfunction]
pub fn projection_places<'py>(
    py: Python<'py>,
    layout: PictureLayout,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let directions = directions.as_array();
    let places = interruptible(py, || {
        let (layout, to_world) = (layout.layout()?, layout.to_world()?);
        let directions = unit_vectors("direction", directions)?;
        let place = |i: usize| {
            let own = to_world.transpose() * directions[i].normalize();
            layout.place(own).unwrap_or(DVec2::NAN)
        };
        Ok(rows(directions.len(), |i| place(i).to_array()))
    })?;
    Ok(places.into_pyarray(py))
}

fn rows<const N: usize>(count: usize, row: impl Fn(usize) -> [f64; N]) -> Array2<f64> {
    Array2::from((0..count).map(row).collect::<Vec<_>>())
}
