//! Shapes of all kinds, by the convex ones that they consist of.

use bevy::{
    math::{DMat3, DQuat, DVec3, Isometry3d},
    prelude::*,
};
use bevy_octree::narrow_phase::{HeightField, Placed, PolygonMesh, Shape, Voxels};
use fastrand::Rng;

use super::known::{self, Known, PartAt, kinds, point, pose};

/// What the depth of a contact is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// The least way out of the whole.
    Least,
    /// That of the two parts that are deepest in each other.
    OfParts,
    /// Something else, no more than takes the two apart.
    Other,
}

/// A shape, and what it consists of, each in its place.
pub(super) struct Whole {
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    pub(super) parts: Vec<(Isometry3d, Known)>,
    pub(super) depth: Depth,
    /// Scale has no effect on it.
    is_rigid: bool,
}

/// One of them in its place.
pub(super) struct At<'a> {
    pub(super) whole: &'a Whole,
    pub(super) transform: Transform,
    pub(super) parts: Vec<PartAt<'a>>,
}

impl From<Known> for Whole {
    fn from(known: Known) -> Self {
        Self {
            name: known.name,
            shape: known.shape.clone(),
            parts: vec![(Isometry3d::IDENTITY, known)],
            depth: Depth::Least,
            is_rigid: false,
        }
    }
}

fn here(parts: impl IntoIterator<Item = Known>) -> Vec<(Isometry3d, Known)> {
    parts
        .into_iter()
        .map(|known| (Isometry3d::IDENTITY, known))
        .collect()
}

fn boxes(centers: impl IntoIterator<Item = Vec3>, half: Vec3) -> Vec<(Isometry3d, Known)> {
    centers
        .into_iter()
        .map(|center| {
            let at = Isometry3d::from_translation(center);
            (at, Known::cuboid("cell", half, 0.0))
        })
        .collect()
}

/// An outline that is not convex: three of four squares.
const OUTLINE: [Vec2; 6] = [
    Vec2::new(-1.0, -1.0),
    Vec2::new(1.0, -1.0),
    Vec2::new(1.0, 0.0),
    Vec2::new(0.0, 0.0),
    Vec2::new(0.0, 1.0),
    Vec2::new(-1.0, 1.0),
];

/// A closed mesh above that outline.
fn angle() -> PolygonMesh {
    let level = |z: f32| OUTLINE.map(|corner| corner.extend(z));
    let vertices = [level(-0.6), level(0.6)].concat();
    let count = OUTLINE.len() as u32;
    let side = |i: u32| vec![i, (i + 1) % count, (i + 1) % count + count, i + count];
    let ends = [(0..count).rev().collect(), (count..2 * count).collect()];
    PolygonMesh::new(vertices, ends.into_iter().chain((0..count).map(side))).unwrap()
}

fn field(rng: &mut Rng) -> HeightField {
    let field = HeightField::from_fn(4, 5, Vec2::new(0.7, 0.9), |_, _| rng.f32() * 0.8).unwrap();
    field.with_holes([(1, 2)]).unwrap()
}

fn triangles_of(field: &HeightField) -> Vec<[Vec3; 3]> {
    let most = field.heights().len() as u32 * 2;
    let triangles = (0..most).filter_map(|number| field.triangle(number));
    triangles.map(|corners| corners.map(Vec3::from)).collect()
}

pub(super) fn wholes(rng: &mut Rng) -> Vec<Whole> {
    let mut parts = vec![];
    let of_some = ["sphere", "cuboid", "capsule", "cone", "hull", "triangle"];
    for known in kinds(rng) {
        if of_some.contains(&known.name) {
            let at = pose(rng, 1.6, false);
            parts.push((Isometry3d::new(at.translation, at.rotation), known));
        }
    }
    let whole = |name, shape, parts, depth| Whole {
        name,
        shape,
        parts,
        depth,
        is_rigid: false,
    };
    let given = parts.iter().map(|(at, known)| (*at, known.shape.clone()));
    let compound = Shape::compound(given).unwrap();
    let mut all = vec![whole("compound", compound, parts, Depth::OfParts)];
    let field = field(rng);
    let parts = here(triangles_of(&field).into_iter().map(known::triangle));
    assert_eq!(parts.len(), 22);
    all.push(whole("height field", field.into(), parts, Depth::OfParts));
    let mut voxels = Voxels::new(0.5).unwrap();
    for _ in 0..24 {
        voxels.set(IVec3::new(rng.i32(-2..2), rng.i32(-2..2), rng.i32(-2..2)));
    }
    let centers = voxels.iter().map(|cell| (cell.as_vec3() + 0.5) * 0.5);
    let parts = boxes(centers, Vec3::splat(0.25));
    all.push(whole("voxels", voxels.into(), parts, Depth::Other));
    // Solid: known by three boxes.
    let squares = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5]];
    let centers = squares.map(|[x, y]| Vec3::new(x, y, 0.0));
    let parts = boxes(centers, Vec3::new(0.5, 0.5, 0.6));
    all.push(whole("closed mesh", angle().into(), parts, Depth::Other));
    let corners: Vec<[Vec3; 3]> = (0..6)
        .map(|_| std::array::from_fn(|_| point(rng, 1.5)))
        .collect();
    let lists = (0..6).map(|number| [0, 1, 2].map(|corner| 3 * number + corner));
    let open = Shape::mesh(corners.as_flattened(), lists).unwrap();
    let parts = here(corners.into_iter().map(known::triangle));
    all.push(whole("open mesh", open, parts, Depth::Other));
    #[cfg(feature = "rapier")]
    all.extend(foreign(rng));
    all
}

#[cfg(feature = "rapier")]
fn foreign(rng: &mut Rng) -> Vec<Whole> {
    use bevy_rapier3d::geometry::Collider;

    let whole = |name, collider: &Collider, parts, depth| Whole {
        name,
        shape: collider.into(),
        parts,
        depth,
        is_rigid: true,
    };
    let field = field(rng);
    let corners = triangles_of(&field);
    let lists = (0..corners.len() as u32).map(|number| [0, 1, 2].map(|i| 3 * number + i));
    let mesh = Collider::trimesh(corners.as_flattened().to_vec(), lists.collect()).unwrap();
    let parts = here(corners.into_iter().map(known::triangle));
    let mut all = vec![whole("Rapier's mesh", &mesh, parts, Depth::Other)];
    let heights: Vec<f32> = (0..12).map(|_| rng.f32()).collect();
    let field = Collider::heightfield(heights, 3, 4, Vec3::new(3.0, 1.0, 2.0));
    let (vertices, triangles) = field.raw.as_heightfield().unwrap().to_trimesh();
    let corners = triangles
        .iter()
        .map(|corners| corners.map(|corner| vertices[corner as usize]));
    let parts = here(corners.map(known::triangle));
    all.push(whole(
        "Rapier's height field",
        &field,
        parts,
        Depth::OfParts,
    ));
    let mut cells: Vec<IVec3> = (0..8)
        .map(|_| IVec3::new(rng.i32(-2..2), rng.i32(-2..2), rng.i32(-2..2)))
        .collect();
    cells.sort_by_key(IVec3::to_array);
    cells.dedup();
    let size = Vec3::new(0.5, 0.7, 0.6);
    let voxels = Collider::voxels(size, &cells);
    let centers = cells.iter().map(|cell| (cell.as_vec3() + 0.5) * size);
    let parts = boxes(centers, size * 0.5);
    all.push(whole("Rapier's voxels", &voxels, parts, Depth::Other));
    let line: Vec<Vec3> = (0..5).map(|_| point(rng, 1.5)).collect();
    let segments = line.windows(2).map(|ends| {
        let shape = Shape::segment(ends[0], ends[1]).unwrap();
        Known::of_points("segment", shape, ends)
    });
    let parts = here(segments);
    let line = Collider::polyline(line.clone(), None);
    all.push(whole("Rapier's polyline", &line, parts, Depth::OfParts));
    let half = Vec3::new(0.3, 0.5, 0.8);
    let cuboid = Known::cuboid("cuboid", half, 0.0);
    let corners = std::array::from_fn(|_| point(rng, 1.0));
    let [a, b, c] = corners;
    let (at, turn) = (Vec3::new(0.7, -0.4, 0.1), Quat::from_rotation_x(0.7));
    let compound = Collider::compound(vec![
        (at, turn, Collider::cuboid(half.x, half.y, half.z)),
        (Vec3::ZERO, Quat::IDENTITY, Collider::triangle(a, b, c)),
    ]);
    let mut parts = here([known::triangle(corners)]);
    parts.push((Isometry3d::new(at, turn), cuboid));
    all.push(whole("Rapier's compound", &compound, parts, Depth::OfParts));
    let mut hull = kinds(rng);
    hull.retain(|known| known.name == "hull");
    let hull = hull.remove(0);
    let known::Core::Points(points) = &hull.core else {
        unreachable!();
    };
    let points: Vec<Vec3> = points.iter().map(|point| point.as_vec3()).collect();
    let shape = Collider::convex_hull(&points).unwrap();
    let parts = here([hull]);
    all.push(whole("Rapier's hull", &shape, parts, Depth::Least));
    let side = known::half_space("half-space", Vec3::new(0.6, 0.0, 0.8));
    let shape = Collider::halfspace(Vec3::new(0.6, 0.0, 0.8)).unwrap();
    all.push(whole(
        "Rapier's half-space",
        &shape,
        here([side]),
        Depth::Least,
    ));
    all
}

impl<'a> At<'a> {
    pub(super) fn new(whole: &'a Whole, transform: Transform) -> Self {
        let scale = if whole.is_rigid {
            DVec3::ONE
        } else {
            transform.scale.as_dvec3()
        };
        let turn = DMat3::from_quat(transform.rotation.as_dquat().normalize());
        let parts = whole.parts.iter().map(|(pose, known)| {
            let own = DMat3::from_quat(pose.rotation.as_dquat().normalize());
            let signs = DMat3::from_diagonal(scale.signum());
            let size = scale.abs();
            // What is turned is as long along its axes as the scale makes these.
            let is_even = size.x == size.y && size.y == size.z;
            let part_scale = if is_even || pose.rotation == Quat::IDENTITY {
                scale
            } else {
                let lengths =
                    [own.x_axis, own.y_axis, own.z_axis].map(|axis| (axis * size).length());
                DVec3::from_array(lengths) * scale.signum()
            };
            let turn = turn * (signs * own * signs);
            let position = transform.translation.as_dvec3()
                + DMat3::from_quat(transform.rotation.as_dquat().normalize())
                    * (Vec3::from(pose.translation).as_dvec3() * scale);
            PartAt {
                known,
                transform: Transform {
                    translation: position.as_vec3(),
                    rotation: DQuat::from_mat3(&turn).normalize().as_quat(),
                    scale: part_scale.as_vec3(),
                },
                turn,
                scale: part_scale,
                position,
            }
        });
        let parts = parts.collect();
        Self {
            whole,
            transform,
            parts,
        }
    }

    pub(super) fn moved(&self, transform: Transform) -> Self {
        Self::new(self.whole, transform)
    }

    pub(super) fn placed(&self) -> Placed<'_> {
        Placed::new(&self.whole.shape, &self.transform)
    }

    pub(super) fn is_convex(&self) -> bool {
        self.parts.len() == 1
    }

    pub(super) fn has_end(&self) -> bool {
        self.parts.iter().all(|part| part.plane().is_none())
    }

    /// How far it reaches along a unit vector.
    pub(super) fn reach(&self, direction: DVec3) -> f64 {
        self.parts
            .iter()
            .map(|part| part.reach(direction))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// How far outside of all parts a point is at least.
    pub(super) fn excess(&self, point: DVec3, directions: &[DVec3]) -> f64 {
        const AXES: [DVec3; 6] = [
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::NEG_X,
            DVec3::NEG_Y,
            DVec3::NEG_Z,
        ];
        let mut least = f64::INFINITY;
        for part in &self.parts {
            let roughly = part.excess(point, &AXES);
            if roughly < least {
                least = least.min(part.excess(point, directions).max(roughly));
            }
        }
        least
    }

    /// The sides of its box, added up; 2 for what has no end.
    pub(super) fn size(&self) -> f64 {
        if !self.has_end() {
            return 2.0;
        }
        DVec3::AXES
            .iter()
            .map(|axis| self.reach(*axis) + self.reach(-*axis))
            .sum::<f64>()
    }
}
