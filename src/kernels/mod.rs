//! The method, in the order in which it runs. A module uses only modules above it; nothing here names a Python type.
//!
//! | module                                         | file           |
//! |------------------------------------------------|----------------|
//! | one-entry cache                                | `cache.rs`     |
//! | vectors of the processor's width               | `lanes.rs`     |
//! | directions, pixels, solid angles               | `sphere.rs`    |
//! | integrals of the direction over a cell         | `cell_integrals.rs` |
//! | layouts of the sphere in a picture             | `projection/`  |
//! | low-discrepancy points, icospheres             | `sampling.rs`  |
//! | spherical harmonics, and irradiance under them | `harmonics.rs` |
//! | reflection of a map by a rough surface        | `rough_reflection.rs` |
//! | optimal transport between weighted directions  | `transport/`   |
//! | irradiance of a disc of uniform radiance       | `disc.rs`      |
//! | irradiance of a convex polygon                | `polygon.rs`   |
//! | irradiance of lights with a position           | `near_lights.rs` |
//! | drawing of discs into a map                    | `disc_map.rs`  |
//! | light hidden by balls and convex polyhedra     | `occluder/`    |
//! | bounding volume hierarchy of triangles         | `hierarchy/`   |
//! | unusable samples, reduction, resampling        | `image/`       |
//! | exact irradiance of a white probe              | `probe/`       |
//! | a map in spherical harmonics                   | `expansion/`   |
//! | spectrum of a shiny ball seen from all sides   | `gloss.rs`     |
//! | smooth radiance for pixels without any         | `fill/`        |
//! | lights of a map                                | `detect/`      |
//! | clipped part of a map, and its missing light   | `repair/`      |
//! | lights removed from a map                      | `split/`       |
//! | lights as planar shapes with textures        | `cards/`       |
//! | ambient + directional lights from the probe    | `fit/`         |
//! | equations of Madsen et al. (2003)              | `madsen/`      |
//! | indirect light from direct light               | `transfer/`    |

mod cache;
pub mod cards;
mod cell_integrals;
pub mod detect;
pub mod disc;
pub mod disc_map;
mod expansion;
pub mod fill;
pub mod fit;
pub mod gloss;
pub mod harmonics;
pub mod hierarchy;
pub mod image;
mod lanes;
pub mod madsen;
pub mod near_lights;
pub mod occluder;
mod polygon;
pub mod probe;
pub mod projection;
pub mod repair;
pub mod rough_reflection;
pub mod sampling;
pub mod sphere;
pub mod split;
pub mod transfer;
pub mod transport;

pub use expansion::{expand_discs, expand_map, nine_harmonics};
