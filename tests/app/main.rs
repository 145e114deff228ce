//! What the crate promises to those who use it: a file for each promise, all of them in one
//! program, which is quicker to build than a program each. `cargo test --test app -- swept::` runs
//! one of them.

mod bad_shapes;
mod body_contacts;
mod bounce;
mod bullets;
mod cast_options;
mod casters;
mod characters;
#[path = "../common/mod.rs"]
mod common;
mod conservation;
mod contact_events;
mod contact_histories;
mod contacts;
#[cfg(feature = "debug_draw")]
mod debug_draw;
mod detectors;
mod determinism;
mod diagnostics;
mod disabling;
mod documentation;
mod extremes;
mod faults;
mod filters;
mod first_hits;
mod hierarchies;
#[path = "../common/hook.rs"]
mod hook;
mod interrupted_ticks;
mod layering;
mod lifecycle;
mod manifolds;
mod mesh_floors;
#[cfg(feature = "mesh")]
mod mesh_scenes;
#[cfg(feature = "mesh")]
mod mesh_shapes;
mod model;
mod move_and_slide;
mod neighbors;
mod order;
mod part_histories;
mod parts;
#[cfg(feature = "picking")]
mod picking;
mod plugin;
mod posed;
mod random_scenes;
#[cfg(feature = "rapier")]
mod rapier;
#[cfg(feature = "rapier")]
mod rapier_bodies;
mod restored_ways;
mod rollback;
mod rooms;
mod schedule;
mod seams;
mod shape_contacts;
mod shape_data;
mod shape_matrix;
mod shape_wholes;
mod shapes;
mod shear;
mod spaces;
mod spatial_query;
mod split_and_merge;
mod stop_at_solids;
mod stress;
mod swept;
#[cfg(feature = "rapier")]
mod swept_half_spaces;
mod swept_ways;
mod test_sets;
#[cfg(feature = "multi_threaded")]
mod threads;
mod trace;
mod upkeep;
mod who_is_who;
mod worlds;
