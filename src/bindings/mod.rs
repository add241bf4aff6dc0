//! The border between Python and the kernels: borrow arrays, release the GIL, call one kernel, wrap its result.
//!
//! [`pool::without_gil`] runs a kernel in the calling thread, [`pool::by_size`] does so if there are few numbers,
//! [`pool::in_pool`] uses several threads, and [`pool::interruptible`] also checks for Ctrl-C, for kernels that may
//! last seconds. All of them turn a panic into an error.

mod cards;
mod detect;
mod error;
mod fill;
mod fit;
mod formats;
mod gloss;
mod harmonics;
mod hierarchy;
mod image;
mod loghin;
mod madsen;
mod near_lights;
mod occluder;
mod output;
mod pool;
mod probe;
mod projection;
mod reduction;
mod repair;
mod rough_reflection;
mod sampling;
mod sphere;
mod split;
mod transfer;
mod transport;

use pyo3::prelude::*;

/// Native kernels of `envlights`; import the typed functions of the package instead.
#[pymodule(gil_used = false)]
mod _native {
    use numpy::PyArray1;
    use pyo3::prelude::*;

    #[pymodule_export]
    const LUMINANCE: [f64; 3] = crate::kernels::image::LUMINANCE;
    #[pymodule_export]
    const GLOSS_DEGREE: usize = crate::kernels::fit::BAND_DEGREE;
    #[pymodule_export]
    const HARMONIC_FACTORS: [f64; 9] = crate::kernels::harmonics::FACTORS;
    #[pymodule_export]
    const LEAST_WHITE: f64 = crate::kernels::image::LEAST_WHITE;
    #[pymodule_export]
    const MOST_PARTS: usize = crate::kernels::image::MOST_PARTS;
    #[pymodule_export]
    const BASIS_SHARE: usize = crate::kernels::transfer::SHARE;
    #[pymodule_export]
    const BASIS_TILE: usize = crate::kernels::transfer::TILE;

    #[pymodule_export]
    use super::cards::{MapCards, cut_cards, draw_cards};
    #[pymodule_export]
    use super::detect::{ClippedDetection, TreeDetection, detect_tree, reduced_luminance};
    #[pymodule_export]
    use super::error::{DamagedBytesError, EnvLightsError, UnusableSamplesError};
    #[pymodule_export]
    use super::fill::fill_unseen;
    #[pymodule_export]
    use super::fit::{
        FitAnswer, continue_reduced, fit_reduced, fit_samples, map_energy, relative_rms, rig_error,
        rig_irradiance,
    };
    #[pymodule_export]
    use super::formats::{PictureFile, exr_file, png_file, radiance_rows, tiff_file};
    #[pymodule_export]
    use super::gloss::gloss_spectrum;
    #[pymodule_export]
    use super::harmonics::{
        expand_discs, expand_map, expand_reduced, harmonic_irradiance, harmonic_radiance, kernel_spectra,
        nine_harmonics,
    };
    #[pymodule_export]
    use super::hierarchy::{TriangleTree, bounding_volume_hierarchy};
    #[pymodule_export]
    use super::image::{
        apply_matrix, area_means, clean, code_histogram_8, code_histogram_16, decode_8, decode_16, overview,
        white_code, widen,
    };
    #[pymodule_export]
    use super::loghin::{
        are_clipped, blur, bresenham_line, luminance, merge_along_lines, neighbour_maximum, plane_threshold,
        resize_bilinear, suppress, uv_to_pixel, weighted_means,
    };
    #[pymodule_export]
    use super::madsen::{
        face_radiance, pack_lights, probe_jacobian, probe_model, probe_residual, unpack_lights,
    };
    #[pymodule_export]
    use super::near_lights::near_irradiance;
    #[pymodule_export]
    use super::occluder::{form_factors, hidden_fractions, reflected_irradiance};
    #[pymodule_export]
    use super::pool::threads;
    #[pymodule_export]
    use super::probe::{disc_map, irradiance, sum_over_sources, working_irradiance};
    #[pymodule_export]
    use super::projection::{
        projection_directions, projection_places, projection_solid_angles, resample, rotate_map,
    };
    #[pymodule_export]
    use super::reduction::{PyRowReducer, ReducedMap, reduce_map};
    #[pymodule_export]
    use super::repair::{clipped_depth, clipped_fraction, clipped_light_shares};
    #[pymodule_export]
    use super::rough_reflection::rough_reflection;
    #[pymodule_export]
    use super::sampling::{even_sphere, halton, hammersley, icosphere, radical_inverse, uniform_sphere};
    #[pymodule_export]
    use super::sphere::{direction_to_uv, pixel_directions, pixel_solid_angles, uv_to_direction};
    #[pymodule_export]
    use super::split::{MapSplit, split_map};
    #[pymodule_export]
    use super::transfer::{transfer_columns, transfer_frames, transfer_gram};
    #[pymodule_export]
    use super::transport::{assignment, transport_plan};

    /// Import `numpy` now: the first array would import it inside a kernel, where Ctrl-C could interrupt it.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.py().import("numpy")?;
        PyArray1::<f64>::zeros(module.py(), 0, false);
        Ok(())
    }
}
