//! Why a shape has no data.

use thiserror::Error;

/// Why a shape has no data: it is one of Rapier's, of a kind that the crate has none for.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no data for a shape of Rapier's of the kind {kind}")]
#[non_exhaustive]
pub struct NoDescriptionError {
    /// What Rapier calls the kind.
    pub kind: String,
}
