//! Shapes in their places as something that can be asked.

use bevy::math::{DMat3, DVec3, Isometry3d, Vec3, Vec3A};

use super::convex::feature::stretched_normal;
use super::convex::{Convex, Isometry};
use super::foreign::{Foreign, ForeignPart};
use super::parts::Part;
use super::posed_mesh::PosedMesh;
use super::probe::{Probe, Search};
use crate::narrow_phase::{
    frame::placed::Placed,
    leaves::{Composite, Leaf},
    shape::Shape,
};

/// What rounding leaves uncertain of the boxes in a tree, as a share of the whole.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// A shape in its place, as something that can be asked.
#[derive(Clone, Copy)]
pub enum PosedShape<'a> {
    Part(Part<'a>),
    /// A mesh of ours, that is not convex.
    Mesh(PosedMesh<'a>),
    /// What consists of many, at a scale.
    Composite {
        shape: Composite<'a>,
        scale: DVec3,
        at: Isometry,
    },
    /// What somebody else knows the parts of.
    Foreign(Foreign<'a>),
}

impl<'a> PosedShape<'a> {
    pub fn isometry(&self) -> Isometry {
        match self {
            Self::Part(Part::Convex(convex)) => convex.at,
            Self::Part(Part::HalfSpace { .. }) => Isometry::IDENTITY,
            Self::Mesh(mesh) => mesh.at,
            Self::Composite { at, .. } => *at,
            Self::Foreign(foreign) => foreign.isometry(),
        }
    }

    /// Centre and half extents of the box around the shape, in its own axes; `None` if it has no
    /// end.
    pub fn local_box(&self) -> Option<[DVec3; 2]> {
        match self {
            Self::Part(Part::Convex(convex)) => Some(convex.local_box()),
            Self::Part(Part::HalfSpace { .. }) => None,
            Self::Mesh(mesh) => Some(mesh.local_box()),
            Self::Composite { shape, scale, .. } => Some(shape.box_at(*scale)),
            Self::Foreign(foreign) => Some(foreign.local_box()),
        }
    }

    /// Is it made of triangles that have numbers?
    pub fn has_triangles(&self) -> bool {
        match self {
            Self::Part(_) => false,
            Self::Mesh(_) => true,
            Self::Composite { shape, .. } => matches!(shape, Composite::HeightField(_)),
            Self::Foreign(foreign) => foreign.has_triangles(),
        }
    }

    /// Half the diagonal of that box; infinite without an end.
    pub fn size(&self) -> f64 {
        self.local_box()
            .map_or(f64::INFINITY, |[_, half]| half.length())
    }

    /// Where it is, and that it goes in a direction, as seen from another.
    pub fn probe(&self, whole: Isometry, direction: DVec3) -> Probe {
        if let Self::Part(Part::HalfSpace { normal, offset }) = self {
            return Probe::HalfSpace {
                normal: whole.direction_to_local(*normal),
                offset: offset - normal.dot(whole.translation),
                approach: normal.dot(direction).max(0.0),
            };
        }
        let Some(bounds) = self.local_box() else {
            return Probe::Everywhere;
        };
        let [center, half] = whole.bounds_to_local(&self.isometry(), bounds);
        Probe::Box {
            center,
            half,
            direction: whole.direction_to_local(direction),
        }
    }

    /// Calls `visit` with all parts that a probe admits, and again with their parts. False if there
    /// is one about which nothing can be said.
    pub fn each(
        &self,
        probe: &Probe,
        search: &Search,
        visit: &mut dyn FnMut(&PosedShape) -> bool,
    ) -> bool {
        match *self {
            Self::Part(_) => visit(self),
            Self::Mesh(mesh) => {
                let mut is_known = true;
                mesh.each(probe, search, &mut |polygon, corners| {
                    search.triangle.set(Some(mesh.mesh.source(polygon)));
                    let part = Convex::triangle(corners, 0.0, Isometry::IDENTITY);
                    is_known &= visit(&PosedShape::Part(Part::Convex(part)));
                });
                is_known
            }
            Self::Composite { shape, scale, at } => {
                each_leaf(shape, (scale, at), probe, search, visit)
            }
            Self::Foreign(foreign) => foreign.each(probe, search, &mut |part| visit(&part.into())),
        }
    }

    /// A point of the shape, or of each of its parts if these need not hang together.
    pub fn each_point(&self, visit: &mut dyn FnMut(DVec3)) {
        let search = Search::within(f64::INFINITY);
        match self {
            Self::Part(Part::Convex(convex)) => visit(convex.furthest(DVec3::X)),
            Self::Part(Part::HalfSpace { .. }) => {}
            // Those of a compound are shapes of their own.
            Self::Composite {
                shape: Composite::Compound(_) | Composite::Voxels(_),
                ..
            } => {
                self.each(&Probe::Everywhere, &search, &mut |part| {
                    part.each_point(visit);
                    true
                });
            }
            Self::Foreign(foreign) if foreign.is_compound() => {
                self.each(&Probe::Everywhere, &search, &mut |part| {
                    part.each_point(visit);
                    true
                });
            }
            _ => {
                self.each(&Probe::Everywhere, &search, &mut |part| {
                    if search.goes_on() {
                        part.each_point(visit);
                    }
                    search.end();
                    true
                });
            }
        }
    }
}

impl<'a> From<ForeignPart<'a>> for PosedShape<'a> {
    fn from(part: ForeignPart<'a>) -> Self {
        match part {
            ForeignPart::Convex(convex) => Self::Part(Part::Convex(convex)),
            ForeignPart::HalfSpace(normal, at) => Self::Part(Part::half_space(normal, at)),
            ForeignPart::Whole(foreign) => Self::Foreign(foreign),
        }
    }
}

/// A shape in its place, relative to an origin, as something that can be asked; `None` for what
/// parry knows no more of than its name.
pub fn posed<'a>(placed: Placed<'a>, origin: Vec3) -> Option<PosedShape<'a>> {
    let at = Isometry::of(placed.transform, origin);
    // If one of three numbers is none, so is the largest.
    let scale = placed.transform.scale.as_dvec3();
    let scale = if scale.is_finite() { scale } else { DVec3::NAN };
    posed_at(placed.shape, scale, at)
}

/// The same, of a shape at a scale.
pub fn posed_at(shape: &Shape, scale: DVec3, at: Isometry) -> Option<PosedShape<'_>> {
    let size = scale.abs();
    let largest = size.max_element();
    let wide = |number: f32| f64::from(number.abs());
    let convex = match shape {
        Shape::Cuboid { half_size } => Convex::cuboid(half_size.as_dvec3() * scale, at),
        Shape::Sphere { radius } => Convex::ball(wide(*radius) * largest, at),
        Shape::Capsule {
            radius,
            half_length,
        } => Convex::capsule(
            wide(*radius) * size.x.max(size.z),
            wide(*half_length) * size.y,
            at,
        ),
        Shape::ConicalFrustum {
            radius_top,
            radius_bottom,
            half_height,
        } => {
            let sizes = [radius_bottom, radius_top, half_height].map(|number| wide(*number));
            Convex::frustum(sizes, scale, 0.0, at)
        }
        Shape::HalfSpace { normal } => {
            let normal = scaled_normal(normal.as_dvec3(), scale);
            return Some(PosedShape::Part(Part::half_space(normal, at)));
        }
        Shape::Rounded(rounded) => {
            Convex::rounded(rounded.core(), scale, wide(rounded.radius()) * largest, at)
        }
        Shape::Convex(mesh) => Convex::mesh(mesh, scale, at),
        Shape::Compound(_) | Shape::HeightField(_) | Shape::Voxels(_) => {
            let shape = Composite::of(shape)?;
            return Some(PosedShape::Composite { shape, scale, at });
        }
        Shape::Mesh(mesh) => return Some(PosedShape::Mesh(PosedMesh { mesh, scale, at })),
        #[cfg(feature = "rapier")]
        Shape::Rapier(inner) => {
            return match inner.own() {
                Some(own) => posed_at(own, DVec3::ONE, at),
                None => super::foreign::foreign(shape, at).map(PosedShape::from),
            };
        }
    };
    Some(PosedShape::Part(Part::Convex(convex)))
}

/// Calls `visit` with all of what a shape consists of that a probe admits: near ones first on a way,
/// and where what is nearest is looked for. False if there is one about which nothing can be said.
fn each_leaf(
    shape: Composite,
    (scale, at): (DVec3, Isometry),
    probe: &Probe,
    search: &Search,
    visit: &mut dyn FnMut(&PosedShape) -> bool,
) -> bool {
    let boxed = |low: Vec3A, high: Vec3A| {
        let (one, other) = (low.as_dvec3() * scale, high.as_dvec3() * scale);
        [one.min(other), one.max(other)]
    };
    // Rounding is for the numbers in the tree.
    let slack = ROUNDING * shape.box_at(scale).map(|side| side.abs().max_element())[1]
        + shape.stray_at(scale);
    let mut is_known = true;
    let mut on_leaf = |leaf: Leaf| {
        if !search.goes_on() {
            return;
        }
        let part = match leaf {
            Leaf::Part(part) => {
                let (pose, scale) = part_at(part.pose, scale, &at);
                match posed_at(&part.shape, scale, pose) {
                    Some(posed) => posed,
                    None => {
                        is_known = false;
                        return;
                    }
                }
            }
            Leaf::Triangle(triangle) => {
                search.triangle.set(Some(triangle.number));
                let mut corners = triangle.corners.map(|corner| corner.as_dvec3() * scale);
                if scale.x * scale.y * scale.z < 0.0 {
                    corners.swap(1, 2);
                }
                PosedShape::Part(Part::Convex(Convex::triangle(corners, 0.0, at)))
            }
            Leaf::Cells(cells) => {
                let [low, high] = boxed(cells.low, cells.high);
                let at = Isometry {
                    translation: at.to_world((low + high) * 0.5),
                    ..at
                };
                let mut cuboid = Convex::cuboid((high - low) * 0.5, at);
                cuboid.faces = cells.faces.mirrored(scale.cmplt(DVec3::ZERO));
                PosedShape::Part(Part::Convex(cuboid))
            }
        };
        is_known &= visit(&part);
    };
    let mut admits = |low: Vec3A, high: Vec3A| {
        let [low, high] = boxed(low, high);
        probe.admits(low - slack, high + slack, search)
    };
    if search.is_for_nearest || search.limit.get() > 0.0 {
        let mut distance = |low: Vec3A, high: Vec3A| {
            let admitted = admits(low, high);
            let [low, high] = boxed(low, high);
            admitted.then(|| probe.entry(low - slack, high + slack, search) as f32)
        };
        shape.walk_near(&mut distance, &mut on_leaf);
    } else {
        shape.walk(&mut admits, &mut on_leaf);
    }
    is_known
}

/// Where a part is, and at what scale, given those of the whole.
///
/// A scale that differs by axis shears a part that is turned. That is left away: the part is as long
/// along each of its own axes as the scale makes it.
fn part_at(pose: Isometry3d, scale: DVec3, at: &Isometry) -> (Isometry, DVec3) {
    let turn = DMat3::from_quat(pose.rotation.as_dquat().normalize());
    let translation = at.to_world(Vec3::from(pose.translation).as_dvec3() * scale);
    let signs = DMat3::from_diagonal(scale.signum());
    let size = scale.abs();
    let part_scale = if size.x == size.y && size.y == size.z {
        scale
    } else {
        let lengths = [turn.x_axis, turn.y_axis, turn.z_axis].map(|axis| (axis * size).length());
        DVec3::from_array(lengths) * scale.signum()
    };
    let pose = Isometry {
        rotation: at.rotation * (signs * turn * signs),
        translation,
    };
    (pose, part_scale)
}

/// The normal of a plane through the origin that a scale stretches. A scale that leaves no plane of
/// it leaves the normal as it is.
fn scaled_normal(normal: DVec3, scale: DVec3) -> DVec3 {
    stretched_normal(normal, scale).unwrap_or_else(|| normal.normalize_or(DVec3::Y))
}
