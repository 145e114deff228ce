//! Up to four points at which two shapes lie on each other.

use bevy::math::{Vec3, Vec3A};
use bevy::reflect::Reflect;

use super::{
    buffers::Buffers,
    convex,
    features::{self, Measure},
    meshes,
    patch::PatchPoint,
};
use crate::narrow_phase::{
    answer::Contact,
    frame::{
        case::Case,
        placed::{Placed, PlacedPair, in_order},
        smaller::{Smaller, unit},
        workspace::Workspace,
    },
    settings::NarrowPhase,
    support,
};

/// How far two points have to be from each other, or a point from a line, to count by themselves,
/// as a share of the whole.
const APART: f32 = 1e-3;
/// How much less deep than the contact the deepest point of two features may be, as a share: the
/// depth of round shapes is not known more exactly.
const SHALLOWER: f32 = 0.02;

/// A point at which two shapes overlap or touch, and how deep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub struct ManifoldPoint {
    /// In the world, halfway between the surfaces of the two.
    pub point: Vec3,
    /// How far the two overlap there along the normal, in world units. Zero if they touch, or are
    /// apart by no more than the tolerance.
    pub depth: f32,
}

/// The points at which two shapes lie on each other, up to four, with one normal for all.
///
/// The deepest comes first, as deep as the [`Contact`], then the one that is furthest from it, then
/// those that span the largest area with these. There is at least one.
///
/// The one normal is that of the place where the two are deepest in each other. So of two that meet
/// at several faces, as a box in the corner of a room that is one mesh, or in a valley whose walls
/// it both touches, only what lies along that normal has its points here: the box is still in the
/// other wall once it got off this one, and the next tick tells so. Where all of it counts at once,
/// have the walls as meshes of their own.
#[doc(alias("contact points", "contact manifold"))]
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[type_path = "bevy_octree"]
pub struct Manifold {
    /// A unit vector from the first shape to the second: that of the [`Contact`].
    pub normal: Vec3,
    points: [ManifoldPoint; Self::MOST_POINTS],
    count: u8,
}

impl Manifold {
    /// The greatest number of points.
    pub const MOST_POINTS: usize = 4;

    /// Returns the points, one to four.
    #[must_use]
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..usize::from(self.count)]
    }

    /// Returns the same as the other shape sees it: with the normal turned around.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self {
            normal: -self.normal,
            ..self
        }
    }

    /// With the deepest point first, as deep as the contact, and none deeper.
    fn of_depth(mut self, depth: f32) -> Self {
        let points = &mut self.points[..usize::from(self.count)];
        let mut deepest = 0;
        for (index, point) in points.iter().enumerate() {
            if point.depth > points[deepest].depth {
                deepest = index;
            }
        }
        points[..=deepest].rotate_right(1);
        points[0].depth = depth;
        for point in points {
            point.depth = point.depth.min(depth);
        }
        self
    }

    /// At larger scale.
    fn larger(mut self, factor: f32) -> Self {
        self.normal = unit(self.normal);
        for point in &mut self.points {
            point.point *= factor;
            point.depth = (point.depth * factor).min(f32::MAX);
        }
        self
    }
}

impl From<Contact> for Manifold {
    /// The contact's one point.
    fn from(contact: Contact) -> Self {
        let mut points = [ManifoldPoint::default(); Self::MOST_POINTS];
        points[0] = ManifoldPoint {
            point: contact.point,
            depth: contact.depth,
        };
        Self {
            normal: contact.normal,
            points,
            count: 1,
        }
    }
}

impl NarrowPhase {
    /// Returns the points at which two shapes lie on each other: some if and only if they
    /// [intersect](Self::intersects), with the normal of their [`contact`](Self::contact).
    ///
    /// * Where two faces lie on each other, the corners of what they share; of an edge on a face, the
    ///   ends of what is over the face; of a corner, or two edges that cross, one point.
    /// * The cap of a cylinder, cone or frustum counts as a face with eight corners on its circle: a
    ///   can stands on four points of its border. A capsule, and the side of a cylinder, cone or
    ///   frustum, is an edge: what lies has two points. So have two that lie side by side, along
    ///   each other to within 3°: the ends of what they share.
    /// * What is [rounded](crate::narrow_phase::Rounded) has the faces, edges and corners of its core,
    ///   moved out by the radius.
    /// * On a half-space, all corners of what faces it.
    /// * On a mesh, a height field or voxels, those of all polygons and cells in touch that share the
    ///   contact's normal, about as far as 10°, as one: a box on two triangles of a floor stands on
    ///   its own four corners. Faces between two cells count for nothing, nor do borders between
    ///   parts whose surfaces are one plane.
    /// * Of a compound, the same of all its parts: a table stands on the outermost corners of its legs.
    /// * Of a sphere, the one point of the contact; so it is for shapes of Rapier's that are known by a
    ///   support map alone.
    ///
    /// A face or edge that leans has those of its points that are below the surface of the other, or
    /// above it by no more than the tolerance, each with its own depth. A point is halfway between the
    /// two surfaces along the normal: of what is no wider there than it is deep, it may be beside.
    ///
    /// Swapping the two turns the normal around and keeps the points and their order, unless they
    /// are equal in all things, position included.
    ///
    /// Costs a contact, and the cutting of the faces; of shapes of many, those of each two parts that
    /// are near each other. Allocates nothing once the workspace is warm.
    ///
    /// ```
    /// use bevy::transform::components::Transform;
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    ///
    /// // A cube that has sunk into a table by 0.25.
    /// let (table, cube) = (Shape::cuboid(4.0, 1.0, 4.0), Shape::cuboid(1.0, 1.0, 1.0));
    /// let (here, there) = (Transform::IDENTITY, Transform::from_xyz(0.5, 0.75, 0.0));
    /// let (table, cube) = (Placed::new(&table, &here), Placed::new(&cube, &there));
    /// let tests = NarrowPhase::default();
    /// let manifold = tests.manifold(table, cube, &mut Workspace::default()).unwrap();
    /// assert_eq!(manifold.points().len(), 4);
    /// for found in manifold.points() {
    ///     assert_eq!(found.depth, 0.25);
    ///     assert_eq!(found.point.y, 0.375); // halfway between 0.5 and 0.25
    /// }
    /// ```
    #[doc(alias = "contact_manifold")]
    #[must_use]
    pub fn manifold(&self, a: Placed, b: Placed, workspace: &mut Workspace) -> Option<Manifold> {
        if let Some(found) = support::with_own(a, b, |a, b| self.manifold(a, b, workspace)) {
            return found;
        }
        let contact = self.contact(a, b, workspace)?;
        let (first, second, swapped) = in_order(a, b);
        let seen = if swapped { contact.reversed() } else { contact };
        let found = self.in_order_manifold(first, second, seen, workspace);
        let found = found.of_depth(contact.depth);
        Some(if swapped { found.reversed() } else { found })
    }

    /// Of two in the order in which pairs are computed, of which the contact is known: the workspace
    /// is as that left it.
    fn in_order_manifold(
        &self,
        first: Placed,
        second: Placed,
        contact: Contact,
        workspace: &mut Workspace,
    ) -> Manifold {
        let single = Manifold::from(contact);
        if matches!(
            Case::of(first.shape, second.shape),
            Case::Parts | Case::Foreign
        ) {
            let found = self.of_features(first, second, contact, workspace);
            return found.unwrap_or(single);
        }
        let Ok(pair) = PlacedPair::new(first, second, self.tolerance()) else {
            return single;
        };
        if pair.is_large() {
            let Some(smaller) = Smaller::of(&pair, self) else {
                return single;
            };
            let [a, b] = smaller.placed(&pair);
            let found = smaller.tests.manifold(a, b, workspace);
            return found.map_or(single, |found| found.larger(smaller.factor));
        }
        let normal = Vec3A::from(contact.normal);
        match pair.case() {
            // The last two went another way.
            Case::Spheres
            | Case::SphereFirst
            | Case::SphereSecond
            | Case::Parts
            | Case::Foreign => {
                return single;
            }
            Case::Cuboids | Case::Convex => convex::gather(&pair, normal, workspace),
            Case::Polygons => {
                let is_convex = [first, second].map(|placed| placed.shape.kind().is_convex());
                // Of a convex one, the contact has gathered them.
                if is_convex == [false; 2] {
                    meshes::gather(&pair, normal, contact.depth, workspace);
                }
            }
        }
        let size = pair.box_a.radius.min(pair.box_b.radius);
        let points = &workspace.contact.of::<Buffers>().patch.points;
        let (chosen, count) = choose(points, normal, size);
        if count == 0 {
            return single;
        }
        let origin = Vec3A::from(first.transform.translation);
        let point = |point: PatchPoint| ManifoldPoint {
            point: (origin + point.point).into(),
            depth: point.depth,
        };
        Manifold {
            normal: contact.normal,
            points: chosen.map(point),
            count,
        }
    }

    /// Of two of which one is known by its support function, or taken apart; `None` if there is one
    /// point, which is that of the contact.
    fn of_features(
        &self,
        first: Placed,
        second: Placed,
        contact: Contact,
        workspace: &mut Workspace,
    ) -> Option<Manifold> {
        let Buffers { patch, flush, .. } = workspace.contact.of::<Buffers>();
        let pair = PlacedPair::new(first, second, self.tolerance());
        // One without an end has no size.
        let tolerance = pair.map_or(self.tolerance(), |pair| pair.tolerance);
        let both = (first, second);
        let measure = features::gather(both, &contact, tolerance, (patch, flush))?;
        let Measure { unit, size } = measure;
        let depths = patch.points.iter().map(|point| point.depth);
        let deepest = depths.reduce(f32::max)?;
        if deepest < contact.depth / unit * (1.0 - SHALLOWER) - tolerance / unit {
            patch.add_point(Vec3A::ZERO, contact.depth / unit);
        }
        let (chosen, count) = choose(&patch.points, contact.normal.into(), size);
        let origin = Vec3A::from(contact.point);
        (count > 1).then(|| Manifold {
            normal: contact.normal,
            points: chosen.map(|point| ManifoldPoint {
                point: (origin + point.point * unit).into(),
                depth: point.depth * unit,
            }),
            count,
        })
    }
}

/// Up to four of many points, and how many: the deepest, and those that span the most with it.
fn choose(
    points: &[PatchPoint],
    normal: Vec3A,
    size: f32,
) -> ([PatchPoint; Manifold::MOST_POINTS], u8) {
    let none = PatchPoint {
        point: Vec3A::ZERO,
        depth: 0.0,
    };
    let mut chosen = [none; Manifold::MOST_POINTS];
    if points.is_empty() {
        return (chosen, 0);
    }
    // Seen along the normal, so that depths do not count as distances.
    let flat = |point: &PatchPoint| point.point - normal * point.point.dot(normal);
    let furthest = |distance: &dyn Fn(&PatchPoint) -> f32| {
        let mut best: (f32, Option<&PatchPoint>) = (f32::NEG_INFINITY, None);
        for point in points {
            let distance = distance(point);
            if distance > best.0 {
                best = (distance, Some(point));
            }
        }
        (best.0, *best.1.unwrap_or(&points[0]))
    };
    let middle = points.iter().map(flat).sum::<Vec3A>() / points.len() as f32;
    let (deepest, _) = furthest(&|point| point.depth);
    // Of several that are as deep, the outermost.
    let nearly = deepest - APART * deepest - 1e-6 * size;
    let (_, first) = furthest(&|point| {
        if point.depth >= nearly {
            flat(point).distance(middle)
        } else {
            f32::NEG_INFINITY
        }
    });
    chosen[0] = first;
    let start = flat(&first);
    let (length, second) = furthest(&|point| flat(point).distance(start));
    if length <= APART * size {
        return (chosen, 1);
    }
    chosen[1] = second;
    let along = (flat(&second) - start) / length;
    let across = normal.cross(along);
    let aside = |point: &PatchPoint| (flat(point) - start).dot(across);
    let (width, third) = furthest(&|point| aside(point).abs());
    if width <= APART * length {
        return (chosen, 2);
    }
    chosen[2] = third;
    // Outside of the triangle, as far as can be.
    let mut corners = [start, flat(&second), flat(&third)];
    if aside(&third) < 0.0 {
        corners.swap(1, 2);
    }
    let (outside, fourth) = furthest(&|point| {
        let point = flat(point);
        (0..3).fold(f32::NEG_INFINITY, |outside, i| {
            let [from, to] = [corners[i], corners[(i + 1) % 3]];
            let outwards = (to - from).cross(normal).normalize_or_zero();
            outside.max((point - from).dot(outwards))
        })
    });
    if outside <= APART * length {
        return (chosen, 3);
    }
    chosen[3] = fourth;
    (chosen, 4)
}

#[cfg(test)]
mod tests;
