//! Why a picture could not be made.

use mercury_common::whole_file::FileError;

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// The pixels could not be encoded.
    #[error("cannot encode the picture as PNG: {0}")]
    Encode(#[from] png::EncodingError),
    /// The pixels could not be encoded as GIF.
    #[error("cannot encode the film as GIF: {0}")]
    EncodeGif(#[from] gif::EncodingError),
    /// An option has a value that cannot be drawn.
    #[error("the picture's {option} {problem}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Description of the problem, with the expected value.
        problem: String,
    },
    /// A chart has data that cannot be drawn.
    #[error("the chart cannot be drawn: {0}")]
    Chart(String),
    /// A film needs pictures of one size.
    #[error(
        "picture {number} of the film has {width} x {height} pixels, the first {first_width} x {first_height}"
    )]
    Sizes {
        /// Counted from 1.
        number: usize,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Width of the first.
        first_width: u32,
        /// Height of the first.
        first_height: u32,
    },
    /// A film without pictures, or other than the number announced.
    #[error("the film has {got} pictures, expected {expected}")]
    Number {
        /// Number of values.
        got: usize,
        /// Expected number of values.
        expected: String,
    },
}

impl PictureError {
    pub(crate) fn option(option: &'static str, problem: String) -> Self {
        Self::Option { option, problem }
    }
}
