//! The shape of an entity from a mesh asset.

use std::collections::{HashMap, HashSet};

use bevy::{
    asset::{
        AssetEvent, AssetId, AssetLoadFailedEvent, AssetServer, Assets, Handle, LoadState,
        RenderAssetUsages,
    },
    ecs::{lifecycle::HookContext, query::QueryItem, world::DeferredWorld},
    mesh::{Mesh, Mesh3d},
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};

use super::{
    form::{Built, MeshForm, build},
    progress::{Progress as Outcome, Ruled, Settled},
};
use crate::{
    components::CollisionShape,
    narrow_phase::ShapeError,
    schedule::{CollisionSystems, add_to_tick},
};

/// The mesh asset that the [`CollisionShape`] of an entity is built of (feature `mesh`): that of its
/// own `Mesh3d`, or one that is named.
///
/// The shape is built once for all entities that ask for the same, as soon as the asset is loaded:
/// on [other threads](super#threads), if there are any. It is inserted at the start of the first tick after
/// it is done: an entity that must not be without a shape until then is given one by
/// [`PolygonMesh::from_mesh`](crate::narrow_phase::PolygonMesh::from_mesh) instead. In which tick that is depends on the asset server and on the
/// other threads; what has to come out the same in each run waits until all shapes are there.
///
/// ```
/// use bevy::{asset::AssetPlugin, mesh::MeshPlugin, prelude::*};
/// use bevy_octree::prelude::*;
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, OctreePlugins::new(Update)));
/// // Whoever is to know that a mesh makes no shape.
/// app.add_observer(|insert: On<Insert, ShapeFromMeshError>, errors: Query<&ShapeFromMeshError>| {
///     println!("{}: {}", insert.entity, errors.get(insert.entity).unwrap().0);
/// });
/// let room = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::new(20.0, 4.0, 20.0));
/// // What is seen is what is met; `ShapeFromMesh::new(room)` would be of what is not seen.
/// let level = (Mesh3d(room), ShapeFromMesh::own(MeshForm::SurfaceOnly), StaticShape);
/// let level = app.world_mut().spawn(level).id();
/// // In a game, frames go by.
/// for _ in 0..1000 {
///     app.update();
///     if app.world().get::<CollisionShape>(level).is_some() {
///         break;
///     }
///     std::thread::sleep(std::time::Duration::from_millis(1));
/// }
/// assert!(app.world().get::<CollisionShape>(level).is_some());
/// ```
///
/// # What goes wrong
///
/// If no shape can be built, the entity gets a [`ShapeFromMeshError`] that says why, and so does the
/// log. The log also tells where a mesh that is to be solid has no inside, or one of which nothing
/// is said looks as if it was meant to have one: it closes but for a few edges, of which one is
/// named.
///
/// A mesh that could not be loaded is such an error, too, until it is loaded after all. A handle
/// that leads nowhere is waited for: its asset may come in any later tick. So is a `Mesh3d`, if there is
/// none and no mesh is named. Of who has waited for ten to twenty seconds the log says so, once. Without an `Assets<Mesh>`, as `MeshPlugin` or `DefaultPlugins` bring it, the component does
/// nothing, and the log says so once.
///
/// # What changes
///
/// * An asset that changes is built again, and the shape stays as it is until then.
/// * So it is where the component changes, in place or by a new one, or the entity's `Mesh3d`, if
///   that is meant: another mesh, or another form, is built if nobody had it built before, and then
///   replaces the shape.
/// * Removing the component, or its `Mesh3d`, leaves the shape. During the building, none comes.
/// * A `CollisionShape` that is there before, or is inserted meanwhile, is a placeholder: when the
///   building ends, it is replaced. One that is inserted later stays until the asset or the
///   component changes.
#[doc(alias("AsyncCollider", "ColliderConstructor", "mesh collider"))]
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[component(on_remove = forget_error)]
pub struct ShapeFromMesh {
    /// The mesh; `None`: that of the entity's `Mesh3d`.
    pub mesh: Option<Handle<Mesh>>,
    /// What is made of it.
    pub form: MeshForm,
}

impl ShapeFromMesh {
    /// Makes the component for a mesh that is solid where it is closed.
    #[must_use]
    pub fn new(mesh: Handle<Mesh>) -> Self {
        let form = MeshForm::default();
        Self::of(mesh, form)
    }

    /// Makes the component for a mesh, and what is to be made of it.
    #[must_use]
    pub const fn of(mesh: Handle<Mesh>, form: MeshForm) -> Self {
        let mesh = Some(mesh);
        Self { mesh, form }
    }

    /// Makes the component for the mesh that the entity itself has, by its `Mesh3d`, and what is to
    /// be made of it.
    #[must_use]
    pub const fn own(form: MeshForm) -> Self {
        let mesh = None;
        Self { mesh, form }
    }

    /// The mesh that is meant, of an entity with this `Mesh3d`.
    pub(super) fn handle<'a>(&'a self, own: Option<&'a Mesh3d>) -> Option<&'a Handle<Mesh>> {
        self.mesh.as_ref().or_else(|| own.map(|own| &own.0))
    }
}

/// Nothing is asked of a mesh any more, so nothing is wrong with it.
fn forget_error(mut world: DeferredWorld, context: HookContext) {
    let mut commands = world.commands();
    commands
        .entity(context.entity)
        .try_remove::<ShapeFromMeshError>();
}

/// Why an entity has no shape of its mesh: a component that is inserted, at the start of a tick, on
/// entities with a [`ShapeFromMesh`] of which none could be built.
///
/// A shape that the entity had before stays. It is removed once that is no longer so: when a shape
/// arrives, when the asset or the `ShapeFromMesh` changes and so another is built, and with the
/// `ShapeFromMesh`. An observer of `On<Insert, ShapeFromMeshError>` is told of each failure.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(opaque)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct ShapeFromMeshError(
    /// What is wrong with the mesh.
    pub ShapeError,
);

type Source = (AssetId<Mesh>, MeshForm);

/// What is known of the meshes that shapes are built of.
#[derive(Resource, Default)]
pub(super) struct MeshShapes(HashMap<Source, Progress>);

impl MeshShapes {
    /// Was a shape of this form built of a mesh, or is it being built?
    pub(super) fn knows(&self, mesh: AssetId<Mesh>, form: MeshForm) -> bool {
        self.0.contains_key(&(mesh, form))
    }
}

enum Progress {
    Building(Task<Result<Built, ShapeError>>),
    Done(Result<Built, ShapeError>),
}

/// The systems that build shapes, for those that come right before and after.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MeshShapeSystems;

pub(super) fn register(app: &mut App) {
    app.register_type::<ShapeFromMesh>()
        .register_type::<ShapeFromMeshError>()
        .register_type::<MeshForm>()
        .init_resource::<MeshShapes>();
    add_to_tick(app, |app, schedule| {
        app.configure_sets(schedule, MeshShapeSystems.in_set(CollisionSystems::First))
            .add_systems(
                schedule,
                (
                    build_shapes.run_if(has_meshes),
                    miss_meshes
                        .run_if(not(has_meshes).and_then(any_with_component::<ShapeFromMesh>)),
                )
                    .in_set(MeshShapeSystems),
            );
    });
}

type MeshEvents = Messages<AssetEvent<Mesh>>;
type MeshFailures = Messages<AssetLoadFailedEvent<Mesh>>;

/// All of it comes with the asset.
fn has_meshes(
    meshes: Option<Res<Assets<Mesh>>>,
    events: Option<Res<MeshEvents>>,
    failures: Option<Res<MeshFailures>>,
) -> bool {
    meshes.is_some() && events.is_some() && failures.is_some()
}

/// Says once that nothing will come of it.
fn miss_meshes(mut is_said: Local<bool>) {
    if !std::mem::replace(&mut *is_said, true) {
        tracing::warn!(
            "there are entities with a `ShapeFromMesh`, which get no shape: the app has no \
             `Assets<Mesh>`, as `MeshPlugin` brings them"
        );
    }
}

/// What is looked at of an entity.
type Asking<'a> = (
    Entity,
    Ref<'a, ShapeFromMesh>,
    Option<Ref<'a, Mesh3d>>,
    Option<&'a Name>,
    Has<CollisionShape>,
    Has<ShapeFromMeshError>,
    Has<Ruled>,
);

/// Either may be what changed; whose `Mesh3d` is not meant, is found, too.
type Changes = Or<(Changed<ShapeFromMesh>, Changed<Mesh3d>)>;

#[expect(clippy::too_many_arguments, reason = "so much is looked at")]
fn build_shapes(
    mut commands: Commands,
    mut shapes: ResMut<MeshShapes>,
    mut settled: ResMut<Settled>,
    meshes: Res<Assets<Mesh>>,
    server: Option<Res<AssetServer>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut failures: MessageReader<AssetLoadFailedEvent<Mesh>>,
    all: Query<Asking>,
    changed: Query<Asking, Changes>,
) {
    // What is still there is about rules that are gone.
    settled.0.clear();
    let mut stale: HashSet<AssetId<Mesh>> = HashSet::new();
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
                stale.insert(*id);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    shapes.0.retain(|(mesh, _), _| !stale.contains(mesh));
    stale.extend(failures.read().map(|failure| failure.id));

    let mut done: HashSet<Source> = HashSet::new();
    for (source, progress) in &mut shapes.0 {
        if let Progress::Building(task) = progress
            && let Some(result) = check_ready(task)
        {
            *progress = Progress::Done(result);
            done.insert(*source);
        }
    }
    let source = |from: &ShapeFromMesh, own: Option<&Mesh3d>| {
        let mesh = from.handle(own)?;
        Some((mesh.id(), from.form))
    };
    let failure = |mesh: AssetId<Mesh>| match server.as_ref()?.get_load_state(mesh)? {
        LoadState::Failed(error) => Some(ShapeError::NotLoaded(error.to_string())),
        _ => None,
    };
    let mut tell =
        |(entity, from, own, name, has_shape, has_error, is_ruled): QueryItem<Asking>| {
            let own = own.as_deref();
            // If there is none yet, a change will tell.
            let Some(source) = source(&from, own) else {
                return;
            };
            let mut error = None;
            match shapes.0.get(&source) {
                None => {
                    if let Some(mesh) = meshes.get(source.0) {
                        let mesh = geometry(mesh);
                        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default)
                            .spawn(async move { build(&mesh, source.1) });
                        shapes.0.insert(source, Progress::Building(task));
                    } else {
                        // If it is not loaded yet, an event will tell.
                        error = failure(source.0);
                    }
                }
                Some(Progress::Building(_)) => {}
                Some(Progress::Done(Ok(built))) => {
                    if let Some(doubt) = &built.doubt {
                        let (mesh, who) = (called_mesh(&from, own), called(entity, name));
                        tracing::warn!("the mesh{mesh} of {who} {doubt}");
                    }
                    commands
                        .entity(entity)
                        .try_insert(CollisionShape(built.shape.clone()));
                    if is_ruled {
                        settled.0.push((entity, Outcome::Shape));
                    }
                }
                Some(Progress::Done(Err(wrong))) => error = Some(wrong.clone()),
            }
            match error {
                Some(wrong) => {
                    let (mesh, who) = (called_mesh(&from, own), called(entity, name));
                    if has_shape {
                        tracing::warn!(
                            "{who} keeps its former shape, as its mesh{mesh} makes none: {wrong}"
                        );
                    } else {
                        tracing::warn!("{who} has no shape of its mesh{mesh}: {wrong}");
                    }
                    commands
                        .entity(entity)
                        .try_insert(ShapeFromMeshError(wrong));
                    if is_ruled {
                        settled.0.push((entity, Outcome::Error));
                    }
                }
                None if has_error => {
                    commands.entity(entity).try_remove::<ShapeFromMeshError>();
                }
                None => {}
            }
        };
    let is_changed = |from: &Ref<ShapeFromMesh>, own: &Option<Ref<Mesh3d>>| {
        let is_own = from.mesh.is_none();
        from.is_changed() || is_own && own.as_ref().is_some_and(DetectChanges::is_changed)
    };
    if stale.is_empty() && done.is_empty() {
        changed
            .iter()
            .filter(|(_, from, own, ..)| is_changed(from, own))
            .for_each(tell);
    } else {
        for asking in &all {
            let (_, from, own, ..) = &asking;
            let source = source(from, own.as_deref());
            let is_news =
                source.is_some_and(|source| stale.contains(&source.0) || done.contains(&source));
            if is_news || is_changed(from, own) {
                tell(asking);
            }
        }
    }
}

/// An entity, as the log has it.
pub(super) fn called(entity: Entity, name: Option<&Name>) -> String {
    name.map_or_else(
        || format!("entity {entity}"),
        |name| format!("entity {entity} \"{name}\""),
    )
}

/// Where the mesh is from, if that is known, with a space before.
pub(super) fn called_mesh(from: &ShapeFromMesh, own: Option<&Mesh3d>) -> String {
    let path = from.handle(own).and_then(Handle::path);
    path.map_or_else(String::new, |path| format!(" \"{path}\""))
}

/// What a shape needs of a mesh: all of it, if that is not there, for the error that tells.
fn geometry(mesh: &Mesh) -> Mesh {
    let positions = mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION);
    let (Ok(Some(positions)), Ok(indices)) = (positions, mesh.try_indices_option()) else {
        return mesh.clone();
    };
    let bare = Mesh::new(mesh.primitive_topology(), RenderAssetUsages::MAIN_WORLD)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions.clone());
    match indices {
        Some(indices) => bare.with_inserted_indices(indices.clone()),
        None => bare,
    }
}

#[cfg(test)]
mod tests;
