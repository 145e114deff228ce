//! What is allocated: in a program of its own, for its allocator counts for all that runs in it.

#[path = "../common/allocator.rs"]
mod allocator;
#[expect(dead_code, reason = "shared with other tests")]
#[path = "../common/mod.rs"]
mod common;
mod counted;
mod swept;
