//! How far the shapes of a whole scene have come.

use bevy::{
    ecs::entity::{Entities, EntityHashMap},
    prelude::*,
};

use super::rules::Extra;

/// How many meshes there are under an entity with [`ShapesFromMeshes`](super::ShapesFromMeshes), by
/// what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct MeshShapeCounts {
    /// Those that have a shape.
    pub shapes: usize,
    /// Those of which no shape could be made: they have a
    /// [`ShapeFromMeshError`](super::ShapeFromMeshError).
    pub errors: usize,
    /// Those that are to have none by the rules, or had a shape or a
    /// [`ShapeFromMesh`](super::ShapeFromMesh) of their own.
    pub left_out: usize,
    /// Those that are not loaded yet, or of which a shape is being built.
    pub waiting: usize,
}

/// Tells that all meshes under an entity with [`ShapesFromMeshes`](super::ShapesFromMeshes) have
/// shapes, or errors: an event for observers, of that entity or of all.
///
/// It is triggered at the start of a tick, when the last of the shapes is inserted; so is the
/// entity's [`ShapesProgress`]. It is triggered again each time when meshes came under the entity
/// later, as by a scene that is spawned again, or the rules changed, and these are done. As long as
/// no mesh comes at all, it is not: nobody knows of a scene that is not there yet how large it will
/// be.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Event, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct ShapesReady {
    /// The entity with the [`ShapesFromMeshes`](super::ShapesFromMeshes).
    pub entity: Entity,
    /// What became of the meshes; none is waiting.
    pub counts: MeshShapeCounts,
}

/// How far the shapes of the meshes under an entity have come, for who draws a loading bar.
///
/// It comes and goes with [`ShapesFromMeshes`](super::ShapesFromMeshes).
#[derive(Component, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct ShapesProgress {
    meshes: EntityHashMap<Progress>,
    /// Was it told that all is done?
    is_told: Told,
}

/// What became of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    Waiting,
    Shape,
    Error,
    LeftOut,
}

/// There is nothing to tell of no mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Told {
    #[default]
    Yes,
    No,
}

impl ShapesProgress {
    /// Counts the meshes, in time linear in their number. Those that are gone since they were last
    /// counted for a [`ShapesReady`] are among them.
    #[must_use]
    pub fn counts(&self) -> MeshShapeCounts {
        let mut counts = MeshShapeCounts::default();
        for progress in self.meshes.values() {
            *match progress {
                Progress::Waiting => &mut counts.waiting,
                Progress::Shape => &mut counts.shapes,
                Progress::Error => &mut counts.errors,
                Progress::LeftOut => &mut counts.left_out,
            } += 1;
        }
        counts
    }

    /// Is it so that meshes have come, and none is waiting?
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.is_told == Told::Yes && !self.meshes.is_empty()
    }

    /// Takes note of a mesh that was decided about.
    pub(super) fn note(&mut self, mesh: Entity, progress: Progress) {
        self.meshes.insert(mesh, progress);
        self.is_told = Told::No;
    }

    /// Takes note of how it ended for a mesh, if it is one of these.
    fn settle(&mut self, mesh: Entity, progress: Progress) {
        if let Some(known) = self.meshes.get_mut(&mesh) {
            *known = progress;
        }
    }
}

/// Says of an entity with a [`ShapeFromMesh`](super::ShapeFromMesh) that rules gave it.
#[derive(Component, Clone, Debug)]
pub(super) struct Ruled {
    /// Whose rules.
    pub(super) root: Entity,
    /// What they inserted beside.
    pub(super) extras: Vec<Extra>,
}

/// What shapes, or errors, entities got by rules since that was last looked at.
#[derive(Resource, Debug, Default)]
pub(super) struct Settled(pub(super) Vec<(Entity, Progress)>);

/// Tells of those whose last mesh was waited for.
pub(super) fn tell_ready(
    mut commands: Commands,
    mut settled: ResMut<Settled>,
    mut roots: Query<(Entity, &mut ShapesProgress)>,
    ruled: Query<&Ruled>,
    entities: &Entities,
) {
    for (mesh, progress) in settled.0.drain(..) {
        if let Ok(Ruled { root, .. }) = ruled.get(mesh)
            && let Ok((_, mut known)) = roots.get_mut(*root)
        {
            known.settle(mesh, progress);
        }
    }
    for (root, mut known) in &mut roots {
        if known.is_told == Told::Yes {
            continue;
        }
        // Nothing comes of those any more that went away, or to others.
        known.meshes.retain(|mesh, progress| match progress {
            Progress::LeftOut => entities.contains(*mesh),
            _ => ruled.get(*mesh).is_ok_and(|ruled| ruled.root == root),
        });
        let counts = known.counts();
        if counts.waiting == 0 {
            known.is_told = Told::Yes;
            let entity = root;
            commands.trigger(ShapesReady { entity, counts });
        }
    }
}
