//! Bright places of a map, found by one of two methods.
//!
//! | method        | what it does                                                                  |
//! |---------------|-------------------------------------------------------------------------------|
//! | `tree/`       | finds connected bright pixels, along any path, and measures them: [`tree::detect`] |
//! | `loghin/`     | the steps of Loghin (2021), sample by sample; Python puts them together       |
//! | `clipping.rs` | the rule for a light that a camera has clipped, for both methods              |

pub mod clipping;
pub mod loghin;
pub mod tree;
