//! The order of shapes by what they consist of, for two of one kind, size and place: what is told of
//! a pair must not depend on which of the two comes first.

use std::cmp::Ordering;

use super::{
    mesh::polygon_mesh::PolygonMesh,
    rounded::{Rounded, RoundedCore},
    shape::Shape,
};

impl Shape {
    /// Which of two shapes comes first whose [keys](Self::order_key) are equal. Linear in what is the
    /// same of both at the beginning. Those of Rapier's have no order.
    #[cold]
    pub(super) fn content_order(&self, other: &Self) -> Ordering {
        if self.is_same(other) {
            return Ordering::Equal;
        }
        match (self, other) {
            (Self::Convex(a), Self::Convex(b)) => of_meshes(a, b),
            (Self::Mesh(a), Self::Mesh(b)) => {
                of_meshes(a, b).then(a.is_surface_only().cmp(&b.is_surface_only()))
            }
            (Self::Rounded(a), Self::Rounded(b)) => of_rounded(a, b),
            (Self::Compound(a), Self::Compound(b)) => {
                let parts = a.parts().zip(b.parts());
                let orders = parts.map(|((at_a, a), (at_b, b))| {
                    let place = |at: bevy::math::Isometry3d| {
                        (at.translation.to_array(), at.rotation.to_array())
                    };
                    of_numbers(&place(at_a), &place(at_b))
                        .then_with(|| of_numbers(&a.order_key(), &b.order_key()))
                        .then_with(|| a.content_order(b))
                });
                first(orders)
            }
            (Self::HeightField(a), Self::HeightField(b)) => {
                of_numbers(&a.cell_size().to_array(), &b.cell_size().to_array())
                    .then(a.rows().cmp(&b.rows()))
                    .then_with(|| of_numbers(a.heights(), b.heights()))
                    .then_with(|| a.holes().cmp(b.holes()))
            }
            (Self::Voxels(a), Self::Voxels(b)) => of_numbers(&a.cell_size(), &b.cell_size())
                .then_with(|| {
                    let [a, b] = [a, b].map(|voxels| voxels.iter().map(|cell| cell.to_array()));
                    a.cmp(b)
                }),
            _ => Ordering::Equal,
        }
    }
}

/// Numbers that are none have no order.
fn of_numbers<T: PartialOrd + ?Sized>(a: &T, b: &T) -> Ordering {
    a.partial_cmp(b).unwrap_or(Ordering::Equal)
}

fn first(mut orders: impl Iterator<Item = Ordering>) -> Ordering {
    orders
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

fn of_meshes(a: &PolygonMesh, b: &PolygonMesh) -> Ordering {
    let vertices = a.vertices().iter().zip(b.vertices());
    first(vertices.map(|(a, b)| of_numbers(&a.to_array(), &b.to_array())))
        .then(a.vertices().len().cmp(&b.vertices().len()))
        .then_with(|| a.polygons().cmp(b.polygons()))
}

fn of_rounded(a: &Rounded, b: &Rounded) -> Ordering {
    let number = |core: &RoundedCore| match core {
        RoundedCore::Segment(_) => 0,
        RoundedCore::Triangle(_) => 1,
        RoundedCore::Cuboid { .. } => 2,
        RoundedCore::ConicalFrustum { .. } => 3,
        RoundedCore::Convex(_) => 4,
    };
    match (a.core(), b.core()) {
        (RoundedCore::Segment(a), RoundedCore::Segment(b)) => {
            of_numbers(&a.map(|end| end.to_array()), &b.map(|end| end.to_array()))
        }
        (RoundedCore::Triangle(a), RoundedCore::Triangle(b)) => {
            of_numbers(&a.map(|end| end.to_array()), &b.map(|end| end.to_array()))
        }
        (RoundedCore::Cuboid { half_size: a }, RoundedCore::Cuboid { half_size: b }) => {
            of_numbers(&a.to_array(), &b.to_array())
        }
        (
            RoundedCore::ConicalFrustum {
                radius_top: top_a,
                radius_bottom: bottom_a,
                half_height: half_a,
            },
            RoundedCore::ConicalFrustum {
                radius_top: top_b,
                radius_bottom: bottom_b,
                half_height: half_b,
            },
        ) => of_numbers(&[top_a, bottom_a, half_a], &[top_b, bottom_b, half_b]),
        (RoundedCore::Convex(a), RoundedCore::Convex(b)) => of_meshes(a, b),
        (a, b) => number(a).cmp(&number(b)),
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;
    use bevy::transform::components::Transform;

    use crate::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};

    /// As of a level whose vertices are those in the world: all transforms are none.
    #[test]
    fn what_is_alike_and_at_one_place_may_be_swapped() {
        let tilted = |sign: f32| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let low = corners.map(|[x, z]| Vec3::new(x, 0.3 * x * sign, z));
            let high = corners.map(|[x, z]| Vec3::new(x, 0.3 * x * sign + 0.5, z));
            Shape::convex_hull(low.into_iter().chain(high)).unwrap()
        };
        let (hulls, at) = ([tilted(1.0), tilted(-1.0)], Transform::IDENTITY);
        let segment = |z: f32| Shape::segment(Vec3::new(-1.0, 0.0, -z), Vec3::new(1.0, 0.0, z));
        let segments = [1.0, -1.0].map(|z| segment(z).unwrap());
        let rounded = segments
            .each_ref()
            .map(|segment| Shape::rounded(segment, 0.2).unwrap());
        let compounds = hulls.each_ref().map(|hull| {
            Shape::compound([(bevy::math::Isometry3d::IDENTITY, hull.clone())]).unwrap()
        });
        let (tests, mut workspace) = (NarrowPhase::default(), Workspace::default());
        for [a, b] in [&hulls, &segments, &rounded, &compounds] {
            assert_eq!(a.order_key(), b.order_key());
            let (a, b) = (Placed::new(a, &at), Placed::new(b, &at));
            let found = tests.contact(a, b, &mut workspace).unwrap();
            let back = tests.contact(b, a, &mut workspace).unwrap();
            assert_eq!(found, back.reversed(), "{a:?} {b:?}");
        }
    }
}
