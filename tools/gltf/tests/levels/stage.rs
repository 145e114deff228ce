//! A headless app that loads scenes from files in memory.

use std::{collections::HashMap, path::Path, time::Duration};

use bevy::{
    asset::{
        AssetPlugin,
        io::{
            AssetSourceBuilder, AssetSourceId,
            memory::{Dir, MemoryAssetReader},
        },
    },
    gltf::GltfPlugin,
    image::{CompressedImageFormatSupport, CompressedImageFormats, ImagePlugin},
    mesh::MeshPlugin,
    prelude::*,
    world_serialization::{WorldAssetRoot, WorldSerializationPlugin},
};
use bevy_octree::{mesh_shape::MeshShapeCounts, prelude::*};

use crate::file::File;

pub struct Stage {
    pub app: App,
    files: Dir,
}

/// What `ShapesReady` told so far.
#[derive(Resource, Default)]
struct Told(Vec<ShapesReady>);

impl Stage {
    pub fn new() -> Self {
        let files = Dir::default();
        let root = files.clone();
        let memory =
            AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: root.clone() }));
        let mut app = App::new();
        app.register_asset_source(AssetSourceId::Default, memory)
            .insert_resource(CompressedImageFormatSupport(CompressedImageFormats::NONE))
            .init_resource::<Told>()
            .add_plugins((
                MinimalPlugins,
                AssetPlugin::default(),
                ImagePlugin::default(),
                MeshPlugin,
                WorldSerializationPlugin,
                GltfPlugin::default(),
                OctreePlugins::new(Update),
            ))
            .add_observer(|ready: On<ShapesReady>, mut told: ResMut<Told>| told.0.push(*ready));
        // As the feature `reflect_auto_register`, one of Bevy's defaults, does: scenes are of such.
        let types = app.world().resource::<AppTypeRegistry>();
        types.write().register_derived_types();
        app.finish();
        app.cleanup();
        Self { app, files }
    }

    /// Puts a file there, and spawns the entity that its scene will be below.
    pub fn spawn(&mut self, file: &File, rules: ShapesFromMeshes) -> Entity {
        self.files
            .insert_asset_text(Path::new("level.gltf"), &file.text());
        let scene = self.load("level.gltf#Scene0");
        self.app
            .world_mut()
            .spawn((WorldAssetRoot(scene), rules))
            .id()
    }

    pub fn load<A: Asset>(&self, path: &'static str) -> Handle<A> {
        self.app.world().resource::<AssetServer>().load(path)
    }

    /// Updates until something is so, but not for ever.
    pub fn wait(&mut self, what: impl Fn(&World) -> bool) {
        for _ in 0..5000 {
            self.app.update();
            if what(self.app.world()) {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("it took too long");
    }

    /// Waits until it is told so often that an entity's shapes are ready; what was told then.
    pub fn ready(&mut self, root: Entity, times: usize) -> MeshShapeCounts {
        let told = move |world: &World| {
            let all = world.resource::<Told>().0.iter();
            let of_root: Vec<_> = all.filter(|ready| ready.entity == root).collect();
            assert!(of_root.len() <= times, "told too often: {of_root:?}");
            of_root.get(times - 1).map(|ready| ready.counts)
        };
        if told(self.app.world()).is_none() {
            self.wait(|world| told(world).is_some());
        }
        told(self.app.world()).unwrap()
    }

    /// Runs some ticks.
    pub fn tick(&mut self, count: usize) {
        (0..count).for_each(|_| self.app.update());
    }

    /// The entities with meshes, by the names of their nodes.
    pub fn meshes(&mut self) -> HashMap<String, Vec<Entity>> {
        let world = self.app.world_mut();
        let mut meshes = world.query_filtered::<(Entity, &ChildOf), With<Mesh3d>>();
        let mut found: HashMap<_, Vec<_>> = HashMap::new();
        for (mesh, child_of) in meshes.iter(world) {
            let name = world.get::<Name>(child_of.parent()).unwrap();
            found.entry(name.to_string()).or_default().push(mesh);
        }
        found
    }

    /// The one mesh of a node.
    pub fn mesh(&mut self, node: &str) -> Entity {
        let meshes = self.meshes();
        let [mesh] = *meshes[node] else {
            panic!("{node} has not one mesh")
        };
        mesh
    }

    /// The nodes of whose meshes a point is in or on.
    pub fn at(&mut self, point: Vec3) -> Vec<String> {
        let world = self.app.world_mut();
        let found = world
            .run_system_cached_with(
                |point: In<Vec3>,
                 spatial: SpatialQuery,
                 parents: Query<(&ChildOf, &Name)>,
                 names: Query<&Name>| {
                    let mut found = vec![];
                    spatial.point_intersections(*point, &SpatialQueryFilter::DEFAULT, &mut found);
                    let name = |mesh: Entity| {
                        let (child_of, _) = parents.get(mesh).unwrap();
                        names.get(child_of.parent()).unwrap().to_string()
                    };
                    found.into_iter().map(name).collect::<Vec<_>>()
                },
                point,
            )
            .unwrap();
        let mut found = found;
        found.sort();
        found
    }
}
