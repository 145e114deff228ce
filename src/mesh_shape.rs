//! Shapes of entities from mesh assets, built beside the ticks where there are threads for it.
//!
//! With the feature `multi_threaded`, or Bevy's of that name, shapes are built on the threads of
//! Bevy's `AsyncComputeTaskPool`, and ticks go on meanwhile. Without it, there are no other threads:
//! the tick that finds the asset builds the shape itself, and takes as much longer (on the web,
//! between two frames). Which it is, is a matter of how long a tick takes, and of the tick in which
//! shapes appear; all else is the same. A large level in an app of one thread is best waited for on
//! a loading screen.

use std::collections::{HashMap, HashSet};

use bevy::{
    asset::{AssetEvent, AssetId, Assets, Handle, RenderAssetUsages},
    ecs::{lifecycle::HookContext, query::QueryItem, world::DeferredWorld},
    mesh::Mesh,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};

use crate::{
    components::CollisionShape,
    narrow_phase::{ConvexMesh, PolygonMesh, Shape, ShapeError},
    schedule::{CollisionSystems, add_to_tick},
};

/// The mesh asset that the [`CollisionShape`] of an entity is built of (feature `mesh`).
///
/// The shape is built once for all entities that ask for the same, as soon as the asset is loaded:
/// on [other threads](self), if there are any. It is inserted at the start of the first tick after
/// it is done: an entity that must not be without a shape until then is given one by
/// [`PolygonMesh::from_mesh`] instead. In which tick that is depends on the asset server and on the
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
/// let level = ShapeFromMesh { mesh: room, form: MeshForm::SurfaceOnly };
/// let level = app.world_mut().spawn((level, StaticShape)).id();
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
/// A handle that leads nowhere is waited for, without a word: its asset may come in any later tick.
/// That one could not be loaded is told by the asset server, in the log and by its `load_state`.
/// Without an `Assets<Mesh>`, as `MeshPlugin` or `DefaultPlugins` bring it, the component does
/// nothing, and the log says so once.
///
/// # What changes
///
/// * An asset that changes is built again, and the shape stays as it is until then.
/// * So it is where the component changes, in place or by a new one: another mesh, or another form,
///   is built if nobody had it built before, and then replaces the shape.
/// * Removing the component leaves the shape. During the building, none comes.
/// * A `CollisionShape` that is there before, or is inserted meanwhile, is a placeholder: when the
///   building ends, it is replaced. One that is inserted later stays until the asset or the
///   component changes.
#[derive(Component, Clone, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
#[component(on_remove = forget_error)]
pub struct ShapeFromMesh {
    /// The mesh.
    pub mesh: Handle<Mesh>,
    /// What is made of it.
    pub form: MeshForm,
}

impl ShapeFromMesh {
    /// Makes the component for a mesh that is solid where it is closed.
    #[must_use]
    pub fn new(mesh: Handle<Mesh>) -> Self {
        let form = MeshForm::default();
        Self { mesh, form }
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

/// What a [`ShapeFromMesh`] makes of its mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, PartialEq)]
#[type_path = "bevy_octree"]
#[non_exhaustive]
pub enum MeshForm {
    /// What is closed is solid, and the rest is surface.
    #[default]
    AsItIs,
    /// The same; the log says so if nothing is closed.
    Solid,
    /// A surface, however closed it is: see [`PolygonMesh::surface_only`].
    SurfaceOnly,
    /// A convex solid, as [`ConvexMesh::new`] makes it.
    Convex,
}

type Source = (AssetId<Mesh>, MeshForm);

/// What is known of the meshes that shapes are built of.
#[derive(Resource, Default)]
struct MeshShapes(HashMap<Source, Progress>);

enum Progress {
    Building(Task<Result<Built, ShapeError>>),
    Done(Result<Built, ShapeError>),
}

#[derive(Clone)]
struct Built {
    shape: Shape,
    /// What there is to be said about it.
    doubt: Option<String>,
}

pub(crate) fn register(app: &mut App) {
    app.register_type::<ShapeFromMesh>()
        .register_type::<ShapeFromMeshError>()
        .register_type::<MeshForm>()
        .init_resource::<MeshShapes>();
    add_to_tick(app, |app, schedule| {
        app.add_systems(
            schedule,
            (
                build_shapes.run_if(has_meshes),
                miss_meshes.run_if(not(has_meshes).and_then(any_with_component::<ShapeFromMesh>)),
            )
                .in_set(CollisionSystems::First),
        );
    });
}

type MeshEvents = Messages<AssetEvent<Mesh>>;

fn has_meshes(meshes: Option<Res<Assets<Mesh>>>, events: Option<Res<MeshEvents>>) -> bool {
    meshes.is_some() && events.is_some()
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
    &'a ShapeFromMesh,
    Option<&'a Name>,
    Has<CollisionShape>,
    Has<ShapeFromMeshError>,
);

fn build_shapes(
    mut commands: Commands,
    mut shapes: ResMut<MeshShapes>,
    meshes: Res<Assets<Mesh>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    all: Query<Asking>,
    changed: Query<Asking, Changed<ShapeFromMesh>>,
) {
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

    let mut done: HashSet<Source> = HashSet::new();
    for (source, progress) in &mut shapes.0 {
        if let Progress::Building(task) = progress
            && let Some(result) = check_ready(task)
        {
            *progress = Progress::Done(result);
            done.insert(*source);
        }
    }
    let source = |from: &ShapeFromMesh| (from.mesh.id(), from.form);
    let mut tell = |(entity, from, name, has_shape, has_error): QueryItem<Asking>| {
        let source = source(from);
        let mut error = None;
        match shapes.0.get(&source) {
            None => {
                // If it is not loaded yet, an event will tell.
                if let Some(mesh) = meshes.get(source.0) {
                    let mesh = geometry(mesh);
                    let task = AsyncComputeTaskPool::get_or_init(TaskPool::default)
                        .spawn(async move { build(&mesh, source.1) });
                    shapes.0.insert(source, Progress::Building(task));
                }
            }
            Some(Progress::Building(_)) => {}
            Some(Progress::Done(Ok(built))) => {
                if let Some(doubt) = &built.doubt {
                    let (mesh, who) = (called_mesh(from), called(entity, name));
                    tracing::warn!("the mesh{mesh} of {who} {doubt}");
                }
                commands
                    .entity(entity)
                    .try_insert(CollisionShape(built.shape.clone()));
            }
            Some(Progress::Done(Err(wrong))) => {
                let (mesh, who) = (called_mesh(from), called(entity, name));
                if has_shape {
                    tracing::warn!(
                        "{who} keeps its former shape, as its mesh{mesh} makes none: {wrong}"
                    );
                } else {
                    tracing::warn!("{who} has no shape of its mesh{mesh}: {wrong}");
                }
                error = Some(ShapeFromMeshError(wrong.clone()));
            }
        }
        match error {
            Some(error) => _ = commands.entity(entity).try_insert(error),
            None if has_error => {
                commands.entity(entity).try_remove::<ShapeFromMeshError>();
            }
            None => {}
        }
    };
    if stale.is_empty() && done.is_empty() {
        changed.iter().for_each(tell);
    } else {
        for asking in &all {
            let (entity, from, ..) = asking;
            let is_changed = changed.contains(entity);
            if is_changed || stale.contains(&from.mesh.id()) || done.contains(&source(from)) {
                tell(asking);
            }
        }
    }
}

/// An entity, as the log has it.
fn called(entity: Entity, name: Option<&Name>) -> String {
    name.map_or_else(
        || format!("entity {entity}"),
        |name| format!("entity {entity} \"{name}\""),
    )
}

/// Where the mesh is from, if that is known, with a space before.
fn called_mesh(from: &ShapeFromMesh) -> String {
    let path = from.mesh.path();
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

fn build(mesh: &Mesh, form: MeshForm) -> Result<Built, ShapeError> {
    let mesh = PolygonMesh::from_mesh(mesh)?;
    let is_in_doubt = !mesh.has_inside()
        && match form {
            MeshForm::AsItIs => mesh.is_nearly_closed(),
            MeshForm::Solid => true,
            MeshForm::SurfaceOnly | MeshForm::Convex => false,
        };
    let doubt = is_in_doubt.then(|| {
        mesh.open_edge().map_or_else(
            || "has no inside: it encloses nothing".into(),
            |edge| {
                let [from, to] = edge.map(|vertex| mesh.vertices()[vertex as usize]);
                format!(
                    "has no inside: it is open at the edge from {from} to {to}, if not elsewhere, too"
                )
            },
        )
    });
    let shape = match form {
        MeshForm::AsItIs | MeshForm::Solid => mesh.into(),
        MeshForm::SurfaceOnly => mesh.surface_only().into(),
        MeshForm::Convex => ConvexMesh::new(mesh)?.into(),
    };
    Ok(Built { shape, doubt })
}

#[cfg(test)]
mod tests;
