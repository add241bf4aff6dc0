//! Bright places of a map: the component tree.
//!
//! | way     | what it does                                                         |
//! |---------|----------------------------------------------------------------------|
//! | `tree/` | follows every bright path exactly: [`tree::detect`]                   |

pub mod tree;
