//! The scenes, a file for each kind.
//!
//! A new one is a file with a `plugin` that calls
//! [`add_scene`](crate::scene::AddScene::add_scene), and a line for it here. Whatever it spawns with
//! a `CollisionShape` is drawn, coloured and taken away by the gallery (but not drawn where it is of
//! a kind of which `solid` makes no mesh); systems that move things are
//! added to [`Tick`](crate::play::Tick), with the condition
//! [`showing`](crate::scene::showing). It must go the same way on every run: no clocks, and random
//! numbers from a seed.

mod bullets;
mod figures;
mod level;
mod parts;
mod queries;
mod rapier;
mod rollback;
mod stress;
mod test_sets;
mod tracks;
mod walk;

use bevy::prelude::*;

/// Adds all scenes, in the order in which they are gone through.
pub fn plugin(app: &mut App) {
    app.add_plugins((
        test_sets::plugin,
        figures::plugin,
        bullets::plugin,
        level::plugin,
        parts::plugin,
        queries::plugin,
        tracks::plugin,
        rapier::plugin,
        stress::plugin,
        walk::plugin,
        rollback::plugin,
    ));
}
