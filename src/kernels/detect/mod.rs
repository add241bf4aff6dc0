//! Bright places of a map, found in two ways.
//!
//! | way        | what it does                                                        |
//! |------------|---------------------------------------------------------------------|
//! | `article/` | the steps of Loghin (2021), sample by sample; put together in Python  |
//! | `tree/`    | follows every bright path exactly: [`tree::detect`]                 |

pub mod article;
pub mod tree;
