//! What answers: this crate and parry.

use bevy::{
    math::{Quat, Vec3},
    transform::components::Transform,
};
use bevy_octree::narrow_phase::{NarrowPhase, Placed, PolygonMesh, Shape, Workspace};
use bevy_rapier3d::parry::shape::SharedShape;
use parry3d::{
    math::{Pose, Rotation, Vector},
    query::{self, PointQuery, Ray, RayCast, ShapeCastOptions},
    shape::{self, TriMesh, TriMeshFlags},
};

use super::{
    queries::{BALL, CAPSULE, CUBOID, Operation, Query, SWEEP},
    scenes::Mesh,
};

/// What came out: nothing without a hit, otherwise how far or how deep; 0 where that is not asked.
pub type Answer = Option<f32>;

/// Something with a mesh that can be asked.
pub trait Engine {
    /// Puts the answers to all questions into `answers`. What is built is not asked here.
    fn ask(&mut self, operation: Operation, queries: &[Query], answers: &mut Vec<Answer>);
}

/// This crate.
pub struct Ours {
    mesh: Shape,
    ball: Shape,
    cuboid: Shape,
    capsule: Shape,
    point: Shape,
    rock: Shape,
    tests: NarrowPhase,
    workspace: Workspace,
}

impl Ours {
    pub fn new(mesh: Shape, rock: &Mesh) -> Self {
        let [half_length, radius] = CAPSULE;
        Self {
            mesh,
            ball: Shape::Sphere { radius: BALL },
            cuboid: Shape::Cuboid { half_size: CUBOID },
            capsule: SharedShape::capsule_y(half_length, radius).into(),
            point: Shape::Sphere { radius: 0.0 },
            rock: Self::build(rock),
            tests: NarrowPhase::default(),
            workspace: Workspace::default(),
        }
    }

    pub fn build(mesh: &Mesh) -> Shape {
        let built = PolygonMesh::new(mesh.vertices.clone(), &mesh.triangles);
        built.expect("the meshes of the scenes are valid").into()
    }
}

impl Engine for Ours {
    fn ask(&mut self, operation: Operation, queries: &[Query], answers: &mut Vec<Answer>) {
        use Operation as O;
        let (tests, workspace) = (self.tests, &mut self.workspace);
        let mesh = Placed::new(&self.mesh, &Transform::IDENTITY);
        let shape = match operation {
            O::BallContact | O::BallSweep => &self.ball,
            O::CuboidContact | O::CuboidIntersects | O::CuboidSweep | O::Distance => &self.cuboid,
            O::CapsuleContact | O::CapsuleSweep => &self.capsule,
            O::MeshIntersects | O::MeshContact | O::MeshSweep => &self.rock,
            _ => &self.point,
        };
        let at = |query: &Query| {
            Transform::from_translation(query.position).with_rotation(query.rotation)
        };
        match operation {
            O::Ray => answers.extend(queries.iter().map(|query| {
                let hit = tests.cast_ray(mesh, query.position, query.direction, f32::INFINITY);
                hit.map(|hit| hit.distance)
            })),
            O::BallContact | O::CuboidContact | O::CapsuleContact | O::MeshContact => {
                answers.extend(queries.iter().map(|query| {
                    let contact = tests.contact(mesh, Placed::new(shape, &at(query)), workspace);
                    contact.map(|contact| contact.depth)
                }));
            }
            O::CuboidIntersects | O::MeshIntersects | O::Contains => {
                answers.extend(queries.iter().map(|query| {
                    let at = at(query);
                    let meets = tests.intersects(mesh, Placed::new(shape, &at), workspace);
                    meets.then_some(0.0)
                }));
            }
            O::BallSweep | O::CuboidSweep | O::CapsuleSweep | O::MeshSweep => {
                answers.extend(queries.iter().map(|query| {
                    let at = at(query);
                    let moving = Placed::new(shape, &at);
                    let impact = tests.sweep(moving, query.direction, SWEEP, mesh, workspace);
                    impact.map(|impact| impact.distance)
                }));
            }
            O::ClosestPoint => answers.extend(queries.iter().map(|query| {
                let closest = tests.closest_point(mesh, query.position, workspace);
                closest.map(|closest| closest.distance(query.position))
            })),
            O::Distance => answers.extend(queries.iter().map(|query| {
                let closest = tests.closest_points(mesh, Placed::new(shape, &at(query)), workspace);
                closest.map(|closest| closest.distance)
            })),
            O::Build | O::BuildClosed => {}
        }
    }
}

/// parry's `TriMesh`.
pub struct Parry {
    mesh: TriMesh,
    /// With what it takes to tell inside from outside, if the mesh is closed.
    oriented: Option<TriMesh>,
    ball: shape::Ball,
    cuboid: shape::Cuboid,
    capsule: shape::Capsule,
    rock: TriMesh,
}

impl Parry {
    pub fn new(mesh: TriMesh, oriented: Option<TriMesh>, rock: &Mesh) -> Self {
        let [half_length, radius] = CAPSULE;
        Self {
            mesh,
            oriented,
            ball: shape::Ball::new(BALL),
            cuboid: shape::Cuboid::new(vector(CUBOID)),
            capsule: shape::Capsule::new_y(half_length, radius),
            rock: Self::build(rock, TriMeshFlags::empty()),
        }
    }

    pub fn build(mesh: &Mesh, flags: TriMeshFlags) -> TriMesh {
        let vertices = mesh.vertices.iter().copied().map(vector).collect();
        TriMesh::with_flags(vertices, mesh.triangles.clone(), flags)
            .expect("the meshes of the scenes are valid")
    }
}

impl Engine for Parry {
    fn ask(&mut self, operation: Operation, queries: &[Query], answers: &mut Vec<Answer>) {
        use Operation as O;
        const KNOWN: &str = "parry knows all of these pairs";
        let (mesh, here) = (&self.mesh, &Pose::IDENTITY);
        let shape: &dyn shape::Shape = match operation {
            O::BallContact | O::BallSweep => &self.ball,
            O::CuboidContact | O::CuboidIntersects | O::CuboidSweep | O::Distance => &self.cuboid,
            O::CapsuleContact | O::CapsuleSweep => &self.capsule,
            _ => &self.rock,
        };
        match operation {
            O::Ray => answers.extend(queries.iter().map(|query| {
                let ray = Ray::new(vector(query.position), vector(*query.direction));
                mesh.cast_local_ray(&ray, f32::MAX, true)
            })),
            O::BallContact | O::CuboidContact | O::CapsuleContact | O::MeshContact => {
                answers.extend(queries.iter().map(|query| {
                    let contact = query::contact(here, mesh, &pose(query), shape, 0.0);
                    contact
                        .expect(KNOWN)
                        .map(|contact| (-contact.dist).max(0.0))
                }));
            }
            O::CuboidIntersects | O::MeshIntersects => {
                answers.extend(queries.iter().map(|query| {
                    let meets = query::intersection_test(here, mesh, &pose(query), shape);
                    meets.expect(KNOWN).intersecting.then_some(0.0)
                }));
            }
            O::BallSweep | O::CuboidSweep | O::CapsuleSweep | O::MeshSweep => {
                let options = ShapeCastOptions::with_max_time_of_impact(SWEEP);
                answers.extend(queries.iter().map(|query| {
                    let velocity = vector(*query.direction);
                    let at = pose(query);
                    let hit =
                        query::cast_shapes(&at, velocity, shape, here, Vector::ZERO, mesh, options);
                    hit.expect(KNOWN).map(|hit| hit.time_of_impact)
                }));
            }
            O::ClosestPoint => answers.extend(queries.iter().map(|query| {
                let point = vector(query.position);
                let closest = mesh.project_local_point(point, true).point;
                Some((closest - point).length())
            })),
            O::Distance => answers.extend(queries.iter().map(|query| {
                let distance = query::distance(here, mesh, &pose(query), shape);
                Some(distance.expect(KNOWN).distance)
            })),
            O::Contains => answers.extend(queries.iter().map(|query| {
                let mesh = self.oriented.as_ref()?;
                let contains = mesh.contains_local_point(vector(query.position));
                contains.then_some(0.0)
            })),
            O::Build | O::BuildClosed => {}
        }
    }
}

fn vector(vector: Vec3) -> Vector {
    vector.to_array().into()
}

fn pose(query: &Query) -> Pose {
    Pose::from_parts(vector(query.position), rotation(query.rotation))
}

fn rotation(rotation: Quat) -> Rotation {
    Rotation::from_array(rotation.to_array())
}
