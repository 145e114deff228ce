//! Queries by entity: rays, moving shapes, overlaps, contacts, what is near.
//!
//! [`SpatialQuery`] is what systems ask, and has a table of [all questions](SpatialQuery#all-questions);
//! a [`SpatialQueryFilter`] says who is seen, and [`update_spatial_index`] has queries see what was
//! spawned or moved in this frame.

mod best;
mod contacts;
mod filter;
mod flush;
mod nearest;
mod overlap;
mod pairs;
mod posed;
mod query;
mod rays;
mod scratch;
mod shape_cast;

pub use contacts::ShapeContact;
pub use filter::SpatialQueryFilter;
pub use flush::update_spatial_index;
pub use nearest::PointHit;
pub use pairs::PairHit;
pub use posed::PosedQuery;
pub use query::SpatialQuery;
pub use rays::{BatchRay, RayHit, RayPassage};

#[doc(inline)]
pub use crate::broad_phase::HitLists;

#[doc(inline)]
pub use crate::narrow_phase::{RayCastOptions, ShapeCastOptions};
pub(crate) use scratch::with_workspace;
pub use shape_cast::ShapeHit;
