//! Layouts of the sphere in a picture: directions of places, places of directions, solid angles of pixels.
//!
//! Every layout has its own frame: forward is +z, right of the picture -x, up of it +y. Callers rotate.
//!
//! Coordinates of a picture: x to the right, y down, (0, 0) at the corner of the first pixel, whose centre is (0.5, 0.5).
//!
//! | layout                                           | file                 |
//! |--------------------------------------------------|----------------------|
//! | equirectangular, whole or cropped                | `equirectangular.rs` |
//! | - the cell that holds a direction                | `cells.rs`           |
//! | cylinder                                         | `cylinder.rs`        |
//! | cube: six faces, one above the other             | `cube.rs`            |
//! | octahedron, unfolded                             | `octahedral.rs`      |
//! | octahedron of equal areas                        | `equal_area.rs`      |
//! | angular map, mirror ball, fisheye                | `circle.rs`          |
//! | photograph                                       | `planar.rs`          |
//! | the common interface                             | `interface.rs`       |
//! | - arrays of directions, lines of places          | `directions.rs`      |
//! | rectangles of a plane, seen from outside         | `plane_angles.rs`    |
//! | places on a grid in each pixel                   | `places.rs`          |

mod cells;
mod circle;
mod cube;
mod cylinder;
mod directions;
mod equal_area;
mod equirectangular;
mod interface;
mod octahedral;
mod places;
mod planar;
mod plane_angles;

use crate::error::{Error, Result};
use interface::check;

pub use circle::{AzimuthalCircle, AzimuthalMapping};
pub use cube::Cube;
pub use cylinder::Cylinder;
pub use directions::{DirectionArrays, Line, Places};
pub use equal_area::EqualArea;
pub use equirectangular::Equirectangular;
pub use interface::{NO_PIXEL, PictureNumbers, SphereProjection};
pub use octahedral::Octahedral;
pub(crate) use places::even_nodes;
pub use planar::Planar;

/// Layout of a picture by the name of its projection.
///
/// # Errors
/// [`Error::NoSuchLayout`] for numbers that no such picture has.
pub fn projection_of(name: &str, picture: &PictureNumbers) -> Result<Box<dyn SphereProjection>> {
    check(picture.size.iter().all(|&side| side > 0), "a layout needs at least one row and column")?;
    Ok(match name {
        "equirectangular" => Box::new(Equirectangular::of(picture)?),
        "cylinder" => Box::new(Cylinder::of(picture)?),
        "cube" => Box::new(Cube::of(picture)?),
        "octahedral" => Box::new(Octahedral::of(picture)?),
        "octahedral-equal-area" => Box::new(EqualArea::of(picture)?),
        "azimuthal" => Box::new(AzimuthalCircle::of(picture)?),
        "planar" => Box::new(Planar::of(picture)?),
        _ => return Err(Error::NoSuchLayout { what: "the kind of a layout is not known" }),
    })
}

#[cfg(test)]
mod tests;
