//! Descents side by side: each start in a lane of its own.
//!
//! A step for a few lights is some thousand small sums that wait for each other. Starts do not wait, so four of them go
//! downhill together, each in a lane of the vectors.
//!
//! | step                              | file           |
//! |-----------------------------------|----------------|
//! | a place in each lane, its cost    | `place.rs`     |
//! | - best radiances, none negative   | `radiances.rs` |
//! | Gauss and Newton's step           | `quadratic.rs` |
//! | - small systems of equations      | `factors.rs`   |
//! | how far lights turn               | `turn.rs`      |
//! | all lanes to the end of their way | `descent.rs`   |

mod descent;
mod factors;
mod place;
mod quadratic;
mod radiances;
mod turn;

pub use descent::{IN_A_QUEUE, Rough, descents};
