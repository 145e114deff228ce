//! Shapes of entities from mesh assets, built on threads of their own.

use std::collections::{HashMap, HashSet};

use bevy::{
    asset::{AssetEvent, AssetId, Assets, Handle, RenderAssetUsages},
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
/// The shape is built on Bevy's `AsyncComputeTaskPool`, once for all entities that ask for the same,
/// as soon as the asset is loaded, and inserted at the start of the first tick after it is done: an
/// entity that must not be without a shape until then is given one by
/// [`PolygonMesh::from_mesh`] instead. In which tick that is depends on the asset server and on the
/// other threads; what has to come out the same in each run waits until all shapes are there.
///
/// An asset that changes is built again, and the shape stays as it is until then. If no shape can
/// be built, the log says for which entity, and why. It also says so where a mesh that is to be
/// solid has no inside, or one of which nothing is said looks as if it was meant to have one: it
/// closes but for a few edges, of which one is named. Removing the component leaves the shape.
///
/// Without an `Assets<Mesh>`, as `MeshPlugin` or `DefaultPlugins` bring it, it does nothing.
///
/// ```
/// use bevy::{asset::AssetPlugin, mesh::MeshPlugin, prelude::*};
/// use bevy_octree::{mesh_shape::{MeshForm, ShapeFromMesh}, prelude::*};
///
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin, OctreePlugins::new(Update)));
/// let room = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::new(20.0, 4.0, 20.0));
/// let level = ShapeFromMesh { mesh: room, form: MeshForm::SurfaceOnly };
/// let level = app.world_mut().spawn(level).id();
/// while app.world().get::<CollisionShape>(level).is_none() {
///     app.update();
/// }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
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
        .register_type::<MeshForm>()
        .init_resource::<MeshShapes>();
    add_to_tick(app, |app, schedule| {
        app.add_systems(
            schedule,
            build_shapes
                .in_set(CollisionSystems::First)
                .run_if(resource_exists::<Assets<Mesh>>)
                .run_if(resource_exists::<Messages<AssetEvent<Mesh>>>),
        );
    });
}

fn build_shapes(
    mut commands: Commands,
    mut shapes: ResMut<MeshShapes>,
    meshes: Res<Assets<Mesh>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    all: Query<(Entity, &ShapeFromMesh)>,
    changed: Query<(Entity, &ShapeFromMesh), Changed<ShapeFromMesh>>,
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
    let mut tell = |entity: Entity, source: Source| {
        let progress = match shapes.0.get(&source) {
            Some(progress) => progress,
            None => {
                let Some(mesh) = meshes.get(source.0) else {
                    // Not loaded yet: an event will tell.
                    return;
                };
                let mesh = geometry(mesh);
                let task = AsyncComputeTaskPool::get_or_init(TaskPool::default)
                    .spawn(async move { build(&mesh, source.1) });
                shapes.0.insert(source, Progress::Building(task));
                return;
            }
        };
        match progress {
            Progress::Building(_) => {}
            Progress::Done(Ok(built)) => {
                if let Some(doubt) = &built.doubt {
                    tracing::warn!("the mesh of entity {entity} {doubt}");
                }
                commands
                    .entity(entity)
                    .try_insert(CollisionShape(built.shape.clone()));
            }
            Progress::Done(Err(error)) => {
                tracing::warn!("entity {entity} has no shape of its mesh: {error}");
            }
        }
    };
    let source = |from: &ShapeFromMesh| (from.mesh.id(), from.form);
    if stale.is_empty() && done.is_empty() {
        changed
            .iter()
            .for_each(|(entity, from)| tell(entity, source(from)));
    } else {
        let is_changed = |entity| changed.contains(entity);
        for (entity, from) in &all {
            if is_changed(entity) || stale.contains(&from.mesh.id()) || done.contains(&source(from))
            {
                tell(entity, source(from));
            }
        }
    }
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
    let doubt = mesh.open_edge().filter(|_| is_in_doubt).map(|edge| {
        let [from, to] = edge.map(|vertex| mesh.vertices()[vertex as usize]);
        format!("has no inside: it is open at the edge from {from} to {to}, if not elsewhere, too")
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
