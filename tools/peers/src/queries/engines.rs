//! What answers queries.

use std::{cell::Cell, ops::ControlFlow, time::Duration};

use avian3d::prelude as avian;
use bevy::{
    ecs::system::SystemState,
    math::{
        Vec3, Vec3A,
        bounding::{Aabb3d, RayCast3d},
    },
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_octree::broad_phase::{BroadPhaseMethod, SpatialIndex};
use obvhs::{BvhBuildParams, bvh2::Bvh2, cwbvh::CwBvh};
use parry3d::{
    bounding_volume::Aabb as ParryAabb,
    partitioning::{Bvh, BvhBuildStrategy},
    query::{PointQuery, RayCast},
};
use rstar::{AABB, PointDistance, RTree, SelectionFunction};

use super::{Ray, mesh_ray_cast::Meshes};
use crate::engines::{
    Role,
    obvhs::aabb_of as obvhs_aabb,
    parry::aabb_of as parry_aabb,
    rstar::{Object, envelope_of, load},
};

/// What a batch of queries found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answer {
    /// How much.
    pub found: u64,
    /// The sum of all distances, or of the numbers of all objects.
    pub sum: f64,
}

impl Answer {
    fn add(&mut self, value: f64) {
        self.found += 1;
        self.sum += value;
    }

    pub(super) fn of(values: impl Iterator<Item = Option<f32>>) -> Option<Self> {
        let mut answer = Self::default();
        values
            .flatten()
            .for_each(|value| answer.add(f64::from(value)));
        Some(answer)
    }

    /// Is this the same, but for rounding and Avian's tolerance?
    pub fn agrees(self, other: Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 0.01 * a.abs().max(1.0);
        close(self.found as f64, other.found as f64) && close(self.sum, other.sum)
    }
}

/// Answers batches of queries, or not: `None` where an engine has no such query.
pub trait QueryEngine {
    /// The first box along each ray; the sum is that of distances.
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer>;
    /// All boxes in each region; the sum is that of their numbers.
    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer>;
    /// The box nearest to each point; the sum is that of distances.
    fn nearest(&mut self, points: &[Vec3]) -> Option<Answer>;
}

/// An engine with the boxes in it.
pub struct Entry {
    /// Its name in tables.
    pub name: &'static str,
    /// What it is to the comparison.
    pub role: Role,
    /// Itself.
    pub engine: Box<dyn QueryEngine>,
}

/// All engines, in the order of the tables.
pub fn all(boxes: &[Aabb3d]) -> Vec<Entry> {
    let entry = |name, role, engine| Entry { name, role, engine };
    vec![
        entry("auto", Role::Ours, Box::new(Ours::new(boxes, "auto"))),
        entry("object", Role::Ours, Box::new(Ours::new(boxes, "object"))),
        entry("parry", Role::Peer, Box::new(Parry::new(boxes))),
        entry("obvhs-bvh2", Role::Peer, Box::new(Obvhs2::new(boxes))),
        entry("obvhs-cwbvh", Role::Peer, Box::new(ObvhsWide::new(boxes))),
        entry("rstar", Role::Peer, Box::new(Rstar::new(boxes))),
        entry("avian", Role::Peer, Box::new(Avian::new(boxes))),
        entry("mesh-ray-cast", Role::Peer, Box::new(Meshes::new(boxes))),
    ]
}

/// This crate.
struct Ours(SpatialIndex);

impl Ours {
    fn new(boxes: &[Aabb3d], method: &str) -> Self {
        let method: BroadPhaseMethod = method.parse().expect("the engines of the list are methods");
        let mut index = SpatialIndex::new(&method);
        for aabb in boxes {
            index.insert(*aabb).expect("the boxes are finite");
        }
        index.update();
        Self(index)
    }
}

impl QueryEngine for Ours {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        let cast = |ray: &Ray| {
            self.0
                .cast(&RayCast3d::new(ray.origin, ray.direction, f32::INFINITY))
        };
        Answer::of(rays.iter().map(|ray| cast(ray).map(|hit| hit.distance)))
    }

    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer> {
        let mut answer = Answer::default();
        for region in regions {
            self.0
                .for_each_overlapping(region, |id| answer.add(f64::from(id.get())));
        }
        Some(answer)
    }

    fn nearest(&mut self, points: &[Vec3]) -> Option<Answer> {
        let nearest = |point: &Vec3| {
            self.0
                .nearest(*point, f32::INFINITY)
                .map(|hit| hit.distance)
        };
        Answer::of(points.iter().map(nearest))
    }
}

/// parry's `Bvh`, built by binning.
struct Parry {
    tree: Bvh,
    boxes: Vec<ParryAabb>,
}

impl Parry {
    fn new(boxes: &[Aabb3d]) -> Self {
        let boxes: Vec<_> = boxes.iter().map(parry_aabb).collect();
        Self {
            tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            boxes,
        }
    }
}

impl QueryEngine for Parry {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        Answer::of(rays.iter().map(|ray| {
            let ray = parry3d::query::Ray::new(
                ray.origin.to_array().into(),
                ray.direction.to_array().into(),
            );
            let leaf = |leaf: u32, best| self.boxes[leaf as usize].cast_local_ray(&ray, best, true);
            self.tree
                .cast_ray(&ray, f32::MAX, leaf)
                .map(|(_, distance)| distance)
        }))
    }

    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer> {
        let mut answer = Answer::default();
        for region in regions {
            self.tree
                .intersect_aabb(&parry_aabb(region))
                .for_each(|leaf| answer.add(f64::from(leaf)));
        }
        Some(answer)
    }

    fn nearest(&mut self, points: &[Vec3]) -> Option<Answer> {
        Answer::of(points.iter().map(|point| {
            let point = point.to_array().into();
            let leaf =
                |leaf: u32, _| Some(self.boxes[leaf as usize].distance_to_local_point(point, true));
            let node = |node: &parry3d::partitioning::BvhNode, _| {
                node.aabb().distance_to_local_point(point, true)
            };
            self.tree
                .find_best(f32::MAX, node, leaf)
                .map(|(_, distance)| distance)
        }))
    }
}

fn obvhs_ray(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new_inf(
        ray.origin.to_array().into(),
        ray.direction.to_array().into(),
    )
}

/// The first box along each ray, by one of obvhs' trees.
fn obvhs_rays(
    rays: &[Ray],
    walk: impl Fn(obvhs::ray::Ray, &mut obvhs::ray::RayHit) -> bool,
) -> Option<Answer> {
    Answer::of(rays.iter().map(|ray| {
        let mut hit = obvhs::ray::RayHit::none();
        walk(obvhs_ray(ray), &mut hit).then_some(hit.t)
    }))
}

/// How far along a ray it enters a box, by place in the tree.
fn entry_into(boxes: &[obvhs::aabb::Aabb]) -> impl Fn(&obvhs::ray::Ray, usize) -> f32 {
    move |ray, primitive| boxes[primitive].intersect_ray(ray).max(0.0)
}

/// The boxes in the order of a tree.
fn in_order(boxes: &[Aabb3d], order: &[u32]) -> Vec<obvhs::aabb::Aabb> {
    order
        .iter()
        .map(|&i| obvhs_aabb(&boxes[i as usize]))
        .collect()
}

/// obvhs' binary tree.
struct Obvhs2 {
    tree: Bvh2,
    boxes: Vec<obvhs::aabb::Aabb>,
}

impl Obvhs2 {
    fn new(boxes: &[Aabb3d]) -> Self {
        let aabbs: Vec<_> = boxes.iter().map(obvhs_aabb).collect();
        let parameters = BvhBuildParams::medium_build();
        let tree = obvhs::bvh2::builder::build_bvh2(&aabbs, parameters, &mut Duration::default());
        let boxes = in_order(boxes, &tree.primitive_indices);
        Self { tree, boxes }
    }
}

impl QueryEngine for Obvhs2 {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        obvhs_rays(rays, |ray, hit| {
            self.tree.ray_traverse(ray, hit, entry_into(&self.boxes))
        })
    }

    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer> {
        let mut answer = Answer::default();
        for region in regions {
            let region = obvhs_aabb(region);
            self.tree.aabb_traverse(region, |tree, node| {
                let node = &tree.nodes[node as usize];
                let first = node.first_index as usize;
                for primitive in first..first + node.prim_count as usize {
                    if self.boxes[primitive].intersect_aabb(&region) {
                        answer.add(f64::from(tree.primitive_indices[primitive]));
                    }
                }
                true
            });
        }
        Some(answer)
    }

    fn nearest(&mut self, _: &[Vec3]) -> Option<Answer> {
        None
    }
}

/// obvhs' compressed tree of eight children per node.
struct ObvhsWide {
    tree: CwBvh,
    boxes: Vec<obvhs::aabb::Aabb>,
}

impl ObvhsWide {
    fn new(boxes: &[Aabb3d]) -> Self {
        let aabbs: Vec<_> = boxes.iter().map(obvhs_aabb).collect();
        let parameters = BvhBuildParams::medium_build();
        let tree = obvhs::cwbvh::builder::build_cwbvh(&aabbs, parameters, &mut Duration::default());
        let boxes = in_order(boxes, &tree.primitive_indices);
        Self { tree, boxes }
    }
}

impl QueryEngine for ObvhsWide {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        obvhs_rays(rays, |ray, hit| {
            self.tree.ray_traverse(ray, hit, entry_into(&self.boxes))
        })
    }

    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer> {
        // The macro below needs the name, and of the version of glam that obvhs has, which is
        // parry's too.
        use parry3d::glamx::UVec2;
        let mut answer = Answer::default();
        let tree = &self.tree;
        for region in regions {
            let region = obvhs_aabb(region);
            let mut state = tree.new_traversal(Vec3A::ONE.to_array().into());
            let mut node;
            obvhs::traverse!(
                tree,
                node,
                state,
                node.intersect_aabb(&region, state.oct_inv4),
                {
                    let primitive = state.primitive_id as usize;
                    if self.boxes[primitive].intersect_aabb(&region) {
                        answer.add(f64::from(tree.primitive_indices[primitive]));
                    }
                }
            );
        }
        Some(answer)
    }

    fn nearest(&mut self, _: &[Vec3]) -> Option<Answer> {
        None
    }
}

/// rstar's tree, bulk-loaded. It has no rays: they are a selection, which stops at what is beyond
/// the best hit.
struct Rstar(RTree<Object>);

impl PointDistance for Object {
    fn distance_2(&self, point: &[f32; 3]) -> f32 {
        self.envelope.distance_2(point)
    }
}

/// Nodes that a ray meets before its best hit so far.
struct Along<'a> {
    origin: Vec3A,
    reciprocal: Vec3A,
    best: &'a Cell<f32>,
}

impl Along<'_> {
    fn distance(&self, envelope: &AABB<[f32; 3]>) -> Option<f32> {
        let at = |corner: [f32; 3]| (Vec3A::from(corner) - self.origin) * self.reciprocal;
        let (a, b) = (at(envelope.lower()), at(envelope.upper()));
        let (enter, leave) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (enter <= leave && enter < self.best.get()).then_some(enter)
    }
}

impl SelectionFunction<Object> for Along<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<[f32; 3]>) -> bool {
        self.distance(envelope).is_some()
    }

    fn should_unpack_leaf(&self, object: &Object) -> bool {
        let distance = self.distance(&object.envelope);
        distance
            .inspect(|distance| self.best.set(*distance))
            .is_some()
    }
}

impl Rstar {
    fn new(boxes: &[Aabb3d]) -> Self {
        Self(load(boxes))
    }
}

impl QueryEngine for Rstar {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        Answer::of(rays.iter().map(|ray| {
            let best = Cell::new(f32::INFINITY);
            let reciprocal = Vec3A::from(*ray.direction).recip();
            let along = Along {
                origin: ray.origin.into(),
                reciprocal,
                best: &best,
            };
            self.0
                .locate_with_selection_function(along)
                .last()
                .map(|_| best.get())
        }))
    }

    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer> {
        let mut answer = Answer::default();
        for region in regions {
            let region = envelope_of(region);
            let _: ControlFlow<()> = self
                .0
                .locate_in_envelope_intersecting_int(region, |object| {
                    answer.add(f64::from(object.number));
                    ControlFlow::Continue(())
                });
        }
        Some(answer)
    }

    fn nearest(&mut self, points: &[Vec3]) -> Option<Answer> {
        Answer::of(points.iter().map(|point| {
            self.0
                .nearest_neighbor_with_distance_2(point.to_array())
                .map(|(_, squared)| squared.sqrt())
        }))
    }
}

/// Avian's `SpatialQuery`, against static bodies.
struct Avian {
    app: App,
    state: SystemState<(
        avian::SpatialQuery<'static, 'static>,
        Query<'static, 'static, &'static Number>,
    )>,
}

/// The number of a box.
#[derive(Component)]
struct Number(u32);

impl Avian {
    fn new(boxes: &[Aabb3d]) -> Self {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            TransformPlugin,
            avian::PhysicsPlugins::new(PostUpdate),
        ))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
            1.0 / 60.0,
        )));
        app.finish();
        app.cleanup();
        let body = |(i, aabb): (usize, &Aabb3d)| {
            let (center, sides) = ((aabb.min + aabb.max) * 0.5, aabb.max - aabb.min);
            let collider = avian::Collider::cuboid(sides.x, sides.y, sides.z);
            (
                Number(i as u32),
                avian::RigidBody::Static,
                collider,
                Transform::from_translation(center.into()),
            )
        };
        app.world_mut()
            .spawn_batch(boxes.iter().enumerate().map(body).collect::<Vec<_>>());
        // In the first updates the tree takes its shape.
        (0..4).for_each(|_| app.update());
        let state = SystemState::new(app.world_mut());
        Self { app, state }
    }
}

impl QueryEngine for Avian {
    fn rays(&mut self, rays: &[Ray]) -> Option<Answer> {
        let (query, _) = self.state.get(self.app.world()).ok()?;
        let filter = avian::SpatialQueryFilter::default();
        let cast = |ray: &Ray| query.cast_ray(ray.origin, ray.direction, f32::MAX, true, &filter);
        Answer::of(rays.iter().map(|ray| cast(ray).map(|hit| hit.distance)))
    }

    fn regions(&mut self, regions: &[Aabb3d]) -> Option<Answer> {
        let (query, numbers) = self.state.get(self.app.world()).ok()?;
        let mut answer = Answer::default();
        for region in regions {
            let region = avian::ColliderAabb {
                min: region.min.into(),
                max: region.max.into(),
            };
            query.aabb_intersections_with_aabb_callback(region, |entity| {
                // As elsewhere, what was found is looked up.
                answer.add(
                    numbers
                        .get(entity)
                        .map_or(0.0, |number| f64::from(number.0)),
                );
                true
            });
        }
        Some(answer)
    }

    fn nearest(&mut self, points: &[Vec3]) -> Option<Answer> {
        let (query, _) = self.state.get(self.app.world()).ok()?;
        let filter = avian::SpatialQueryFilter::default();
        let nearest = |point: &Vec3| {
            query
                .project_point(*point, true, &filter)
                .map(|found| found.point.distance(*point))
        };
        Answer::of(points.iter().map(nearest))
    }
}
