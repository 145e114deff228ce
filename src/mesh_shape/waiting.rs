//! Who waits for a mesh that does not come.

use std::time::Duration;

use bevy::{ecs::entity::EntityHashMap, mesh::Mesh3d, prelude::*};

use super::shape_from_mesh::{MeshShapeSystems, MeshShapes, ShapeFromMesh, called, called_mesh};
use crate::schedule::{CollisionSystems, add_to_tick};

/// How often is looked who waits. Who did so the last time as well, is told of.
const PATIENCE: Duration = Duration::from_secs(10);

/// Who waited at the last look, whether that was told, and when that look was.
#[derive(Default)]
struct Waiting {
    looked: Duration,
    told: EntityHashMap<bool>,
}

type Asking<'a> = (
    Entity,
    &'a ShapeFromMesh,
    Option<&'a Mesh3d>,
    Option<&'a Name>,
);

/// Tells once of each that has waited long: nobody may know that its mesh will never come.
fn tell_waiting(
    mut waiting: Local<Waiting>,
    time: Option<Res<Time<Real>>>,
    meshes: Res<Assets<Mesh>>,
    shapes: Res<MeshShapes>,
    server: Option<Res<AssetServer>>,
    all: Query<Asking>,
) {
    let Some(now) = time.map(|time| time.elapsed()) else {
        return;
    };
    if now < waiting.looked + PATIENCE {
        return;
    }
    waiting.looked = now;
    let before = std::mem::take(&mut waiting.told);
    for (entity, from, own, name) in &all {
        let mesh = from.handle(own).map(Handle::id);
        let is_there = mesh.is_some_and(|mesh| {
            let has_failed = |server: &AssetServer| server.load_state(mesh).is_failed();
            // What could not be loaded was told of when that was so.
            meshes.contains(mesh)
                || shapes.knows(mesh, from.form)
                || server.as_deref().is_some_and(has_failed)
        });
        if is_there {
            continue;
        }
        let mut is_told = before.get(&entity).copied();
        if is_told == Some(false) {
            let (who, mesh) = (called(entity, name), called_mesh(from, own));
            tracing::warn!(
                "{who} has been waiting for its mesh{mesh} for more than {} s, and has no shape of it",
                PATIENCE.as_secs()
            );
            is_told = Some(true);
        }
        waiting.told.insert(entity, is_told.unwrap_or(false));
    }
}

pub(super) fn register(app: &mut App) {
    add_to_tick(app, |app, schedule| {
        let tell = tell_waiting
            .run_if(resource_exists::<Assets<Mesh>>)
            .in_set(CollisionSystems::First)
            .after(MeshShapeSystems);
        app.add_systems(schedule, tell);
    });
}
