//! The equations of Madsen, Sørensen and Vittrup (2003) as the paper writes them, for any optimiser.
//!
//! [`super::fit`] solves the same problem by another method. Each file holds one equation of the paper, over all
//! 3 + 5M unknowns:
//!
//! | step                                     | equations | file            |
//! |------------------------------------------|-----------|-----------------|
//! | a radiance for each face of the scene    |           | `faces.rs`      |
//! | the probe under K sources                | 1 to 3    | `super::probe`  |
//! | unknowns <-> lights                      |           | `parameters.rs` |
//! | the surface of the probe                 |           | `surface.rs`    |
//! | the probe under ambient and M lights     | 4 to 6    | `model.rs`      |
//! | the residual of a measured probe         | 7 to 9    | `residual.rs`   |
//! | its derivative by every unknown          |           | `jacobian.rs`   |
//!
//! The paper sums `n.l`; here, as in every renderer, a light behind the surface contributes nothing:
//! `max(0, n.l)`.

mod faces;
mod jacobian;
mod model;
mod parameters;
mod residual;
mod surface;

pub use faces::face_radiance;
pub use jacobian::jacobian;
pub use model::model;
pub use parameters::{Parameters, pack};
pub use residual::{ProbeValues, residual};
pub use surface::Surface;
