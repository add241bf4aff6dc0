//! Every refusal of every kernel. Each sentence names the argument, its value and the expected value.

use thiserror::Error;

/// Result of a kernel, or the reason for its refusal.
pub type Result<T> = std::result::Result<T, Error>;

/// Reason for the refusal of a kernel.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// An image is not (height, width, 3) or too small to cover the sphere.
    #[error(
        "radiance must have the shape (height, width, 3) with height and width at least 2; got {shape:?}"
    )]
    NotAMap {
        /// Shape of the array that was given.
        shape: Vec<usize>,
    },

    /// Numbers of a layout that no picture has.
    #[error("{what}")]
    NoSuchLayout {
        /// Condition that does not hold.
        what: &'static str,
    },

    /// Vertices and faces that are no convex polyhedron.
    #[error("{what}")]
    NoSuchSolid {
        /// Condition that does not hold.
        what: &'static str,
    },

    /// An array does not have the columns that it must have.
    #[error("{what} must have the shape (n, {columns}); got {shape:?}")]
    WrongColumns {
        /// Name of the argument.
        what: &'static str,
        /// Columns that it must have.
        columns: usize,
        /// Shape that was given.
        shape: Vec<usize>,
    },

    /// An array of another shape than a kernel takes.
    #[error("{what} must have the shape {wanted}; got {shape:?}")]
    WrongShape {
        /// Name of the argument.
        what: &'static str,
        /// The shape in words, as `(n, rank, 3)`.
        wanted: &'static str,
        /// Shape that was given.
        shape: Vec<usize>,
    },

    /// Two arrays that describe the same things have different lengths.
    #[error("{what} must have as many rows as {other} ({wanted}); got {seen}")]
    LengthMismatch {
        /// Name of the argument.
        what: &'static str,
        /// Name of the argument with the expected length.
        other: &'static str,
        /// Rows of `other`.
        wanted: usize,
        /// Rows of `what`.
        seen: usize,
    },

    /// An ambient term with another number of coefficients than 0, 1 or 9.
    #[error("the ambient term must have 0, 1 or 9 coefficients in each channel; got {seen}")]
    NotAmbient {
        /// Coefficients that were given.
        seen: usize,
    },

    /// A direction whose length is not 1.
    #[error("{what} {index} has length {length}; it must be a unit vector")]
    NotUnit {
        /// Name of the argument.
        what: &'static str,
        /// Row of the first offender.
        index: usize,
        /// Its length.
        length: f64,
    },

    /// A number is NaN or infinite.
    #[error("{what} must be finite; row {index} holds {value}")]
    NotFinite {
        /// Name of the argument.
        what: &'static str,
        /// Row of the first offender.
        index: usize,
        /// Its value.
        value: f64,
    },

    /// A number below zero in an argument that must not be negative.
    #[error("{what} must not be negative; row {index} holds {value}")]
    Negative {
        /// Name of the argument.
        what: &'static str,
        /// Row of the first offender.
        index: usize,
        /// Its value.
        value: f64,
    },

    /// Weights that are all 0.
    #[error("{what} must hold a number above 0; the sum is 0")]
    NoWeight {
        /// Name of the argument.
        what: &'static str,
    },

    /// An icosphere of this many faces does not exist.
    #[error("an icosphere has 20 * 4^k faces (20, 80, 320, 1280, 5120, ... up to {limit}); got {faces}")]
    NoSuchIcosphere {
        /// Requested number of faces.
        faces: usize,
        /// Largest supported number.
        limit: usize,
    },

    /// The base of a radical inverse is too small.
    #[error("a radical inverse needs a base of at least 2; got {base}")]
    BadBase {
        /// Base that was given.
        base: u64,
    },

    /// Too few probe values for the unknowns.
    #[error("a fit needs at least {wanted} normals for {lights} lights; got {seen}")]
    TooFewNormals {
        /// Normals that were given.
        seen: usize,
        /// Normals needed for as many equations as unknowns.
        wanted: usize,
        /// Requested number of lights.
        lights: usize,
    },

    /// A vector whose length is not 3 + 5 M.
    #[error("x must hold 3 + 5 M numbers (ambient RGB, then each light's RGB, theta and phi); got {seen}")]
    NotParameters {
        /// Numbers that were given.
        seen: usize,
    },

    /// An image of too few pixels to cover the sphere.
    #[error("an image of the sphere needs at least 2 rows and 2 columns; got {height} rows of {width}")]
    TooFewPixels {
        /// Requested rows.
        height: usize,
        /// Requested columns.
        width: usize,
    },

    /// Samples of a map that are NaN, infinite or negative.
    #[error(
        "radiance must be finite and not negative; row {row} holds {value}, and of all samples \
         {nan} are NaN, {infinite} infinite and {negative} negative"
    )]
    UnusableSamples {
        /// Row of the first offender.
        row: usize,
        /// Its value.
        value: f32,
        /// Samples that are not a number.
        nan: usize,
        /// Samples of positive infinity.
        infinite: usize,
        /// Samples below zero, negative infinity among them.
        negative: usize,
    },

    /// A map whose samples are all NaN or infinite.
    #[error("the image holds no finite sample; is it damaged?")]
    NoFiniteSample,

    /// An image without a pixel.
    #[error("an image needs at least one pixel; got {height} rows of {width}")]
    EmptyImage {
        /// Rows that were given.
        height: usize,
        /// Columns that were given.
        width: usize,
    },

    /// An image with more pixels than the limit.
    #[error("an image may have up to {limit} pixels; got {height} rows of {width}")]
    HugeImage {
        /// Requested rows.
        height: usize,
        /// Requested columns.
        width: usize,
        /// Largest number of pixels.
        limit: usize,
    },

    /// A map whose sums overflow single precision.
    #[error("radiance is too large to be summed in single precision; divide the map by a scale")]
    TooBright,

    /// An array that does not fit in memory.
    #[error("there is no memory for an array of the shape {shape:?}")]
    NoMemory {
        /// Shape of the array.
        shape: Vec<usize>,
    },

    /// A number outside of its range.
    #[error("{what} must be from {least} to {most}; got {value}")]
    OutOfRange {
        /// Name of the argument.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Smallest accepted value.
        least: f64,
        /// Largest accepted value.
        most: f64,
    },

    /// A pixel of a gray image is NaN or infinite.
    #[error("{what} must be finite; pixel (row {row}, column {column}) holds {value}")]
    BadPixel {
        /// Name of the argument.
        what: &'static str,
        /// Row of the first offender.
        row: usize,
        /// Its column.
        column: usize,
        /// Its value.
        value: f32,
    },

    /// A line with more pixels than the limit.
    #[error("a line must be shorter than {limit} pixels; got one from {start:?} to {end:?}")]
    LongLine {
        /// Row and column of its start.
        start: [i64; 2],
        /// Row and column of its end.
        end: [i64; 2],
        /// Length of the shortest line that is refused.
        limit: u64,
    },

    /// A pixel outside of the image.
    #[error("pixel {index} is row {row}, column {column}; the image has {height} rows and {width} columns")]
    OutsideImage {
        /// Index of the first offender.
        index: usize,
        /// Its row.
        row: i64,
        /// Its column.
        column: i64,
        /// Rows of the image.
        height: usize,
        /// Columns of the image.
        width: usize,
    },

    /// An image file whose content is not converted.
    #[error("{reason}")]
    UnreadFile {
        /// Sentence about the content and the way out.
        reason: String,
    },

    /// An image file whose bytes contradict its format.
    #[error("{reason}")]
    DamagedFile {
        /// Sentence about the damage and the expected bytes.
        reason: String,
    },
}
