//! Bright places of a map, found by one of two methods, the tree in two ways.
//!
//! | method        | what it does                                                                  |
//! |---------------|-------------------------------------------------------------------------------|
//! | `tree/`       | finds connected bright pixels, along any path, and measures them: [`tree::detect`] |
//! | `loghin/`     | the steps of Loghin (2021), sample by sample; Python puts them together       |
//! | `white/`      | the tree on maps whose values end at a known white: [`white::detect`]         |
//! | `clipping.rs` | the rule for a light that a camera has clipped, for all of them               |
//! | `clipped_share.rs` | how much of a map is clipped                                             |

pub mod clipped_share;
pub mod clipping;
pub mod loghin;
pub mod tree;
pub mod white;
