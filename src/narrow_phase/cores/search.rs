//! Convex shapes of any kind by their support functions, in 32-bit floats: a fraction of the steps
//! that 64-bit ones take, and as exact as positions are. What these cannot tell is left to those.

use bevy::math::{DVec3, Vec3A};

use super::body::{Body, Core};
use super::nearest::{Closest, Nearest};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::{case::Case, placed::PlacedPair},
    gjk::{Found, Overlap, Simplex, Vertex, expand, search},
};

/// The sizes for which products of lengths are numbers, and not nothing.
const FAIR: std::ops::RangeInclusive<f32> = 1e-4..=1e6;
/// The least distance of two cores whose points tell it, and a direction, as a share of the sizes.
const LEAST: f32 = 1e-2;
/// So often does the search for a point of both go from one shape to the other.
const MOST_WAYS: usize = 8;
/// Two points that are no further apart count as one, as a share of the sizes at hand.
const SAME: f32 = 1e-5;

/// Two convex shapes in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a> {
    a: Body<'a>,
    b: Body<'a>,
    size: f32,
    tolerance: f32,
}

impl<'a> Bodies<'a> {
    /// Those of a pair; `None` if one is not convex, or so large or small that numbers go out.
    #[inline]
    pub fn of(pair: &PlacedPair<'a>) -> Option<Self> {
        if !FAIR.contains(&pair.size) || pair.is_wide() {
            return None;
        }
        Some(Self {
            a: Body::of(pair.a, &pair.box_a)?,
            b: Body::of(pair.b, &pair.box_b)?,
            size: pair.size,
            tolerance: pair.tolerance,
        })
    }

    /// Those of a pair for which nothing else is quicker, or tells more.
    #[inline]
    pub fn of_case(pair: &PlacedPair<'a>) -> Option<Self> {
        match pair.case() {
            Case::SphereFirst | Case::SphereSecond | Case::Convex | Case::Parts => Self::of(pair),
            Case::Spheres | Case::Cuboids | Case::Polygons | Case::Foreign => None,
        }
    }

    #[inline]
    fn difference(&self) -> impl Fn(Vec3A) -> Vertex<Vec3A> {
        |direction| Vertex::of([self.a.furthest(direction), self.b.furthest(-direction)])
    }

    #[inline]
    fn towards(&self) -> Vec3A {
        let offset = self.b.center - self.a.center;
        offset.try_normalize().unwrap_or(Vec3A::X)
    }

    #[inline]
    fn radii(&self) -> f32 {
        self.a.radius + self.b.radius
    }

    /// Whether the two are no further apart than the tolerance; `None` where that is too close to
    /// tell.
    #[inline]
    pub fn intersects(&self) -> Option<bool> {
        let limit = self.tolerance + self.radii();
        match search(self.difference(), self.towards(), [limit; 2], &mut 0.0) {
            Found::Beyond | Found::Apart(_) => Some(false),
            Found::Enough(_) | Found::Overlap(_) => Some(true),
            Found::Unsettled(_) => None,
        }
    }

    #[inline]
    fn nearest(&self, simplex: &Simplex<Vec3A>) -> Nearest {
        Nearest {
            points: simplex.points(),
            offset: -simplex.nearest(),
            radii: [self.a.radius, self.b.radius],
        }
    }

    /// Where the two are closest to each other. `None` where that is too close to tell.
    #[inline]
    pub fn closest_points(&self) -> Option<Closest> {
        let (limits, mut size) = ([f32::INFINITY, -1.0], 0.0);
        match search(self.difference(), self.towards(), limits, &mut size) {
            Found::Apart(simplex) => {
                let nearest = self.nearest(&simplex);
                (nearest.distance() > LEAST * self.size).then(|| nearest.of_surfaces())
            }
            Found::Overlap(simplex) | Found::Enough(simplex) => {
                let [on_a, on_b] = simplex.points();
                Some([on_a.midpoint(on_b); 2].into())
            }
            Found::Beyond | Found::Unsettled(_) => None,
        }
    }

    /// Where and how deep the two meet, if they do: as [`intersects`](Self::intersects) has it. The
    /// outer `None` where that is too close to tell.
    pub fn contact(&self) -> Option<Option<LocalContact>> {
        let mut size = 0.0;
        let limits = [self.tolerance + self.radii(), -1.0];
        match search(self.difference(), self.towards(), limits, &mut size) {
            Found::Beyond => Some(None),
            Found::Apart(simplex) => {
                let nearest = self.nearest(&simplex);
                if nearest.gap() > self.tolerance {
                    return Some(None);
                }
                (nearest.distance() > LEAST * self.size).then(|| Some(nearest.contact()))
            }
            Found::Overlap(simplex) | Found::Enough(simplex) => {
                let contact = self
                    .out_of_mesh()
                    .or_else(|| self.reversed().out_of_mesh().map(LocalContact::reversed));
                Some(Some(
                    contact.unwrap_or_else(|| self.deepest(&simplex, size)),
                ))
            }
            Found::Unsettled(_) => None,
        }
    }

    fn reversed(&self) -> Self {
        Self {
            a: self.b,
            b: self.a,
            ..*self
        }
    }

    /// A ball whose centre is inside a mesh, the second.
    fn out_of_mesh(&self) -> Option<LocalContact> {
        let Core::Point = self.a.core else {
            return None;
        };
        let (outwards, depth) = self.b.way_out(self.a.center)?;
        Some(LocalContact {
            normal: -outwards,
            point: self.a.center + outwards * depth,
            depth: depth.max(0.0) + self.a.radius,
        })
    }

    /// Two of which the cores overlap.
    fn deepest(&self, simplex: &Simplex<Vec3A>, size: f32) -> LocalContact {
        let Overlap {
            depth,
            normal,
            points,
        } = expand(
            &simplex.wide(),
            |direction| {
                let direction = direction.as_vec3a();
                Vertex::of([self.a.furthest(direction), self.b.furthest(-direction)].map(wide))
            },
            f64::from(size),
            wide(self.towards()),
        );
        let middle = points[0].midpoint(points[1]).as_vec3a();
        let [on_a, on_b] = simplex.points();
        LocalContact {
            normal: normal.as_vec3a(),
            point: self.common_point(middle).unwrap_or(on_a.midpoint(on_b)),
            depth: depth as f32 + self.radii(),
        }
    }

    /// A point of two cores that overlap, near another, by going back and forth between the two;
    /// `None` if that takes too long.
    fn common_point(&self, near: Vec3A) -> Option<Vec3A> {
        let mut point = near;
        (0..MOST_WAYS).find_map(|_| {
            let on_a = closest(&self.a, point);
            point = closest(&self.b, on_a);
            (on_a.distance(point) <= SAME * self.size).then(|| on_a.midpoint(point))
        })
    }
}

/// The point of a core that is closest to another; that one itself, if it is inside.
fn closest(body: &Body, point: Vec3A) -> Vec3A {
    let difference = |direction| Vertex::of([body.furthest(direction), point]);
    let towards = (point - body.center).try_normalize().unwrap_or(Vec3A::X);
    match search(difference, towards, [f32::INFINITY, -1.0], &mut 0.0) {
        Found::Apart(simplex) | Found::Unsettled(simplex) => simplex.points()[0],
        Found::Beyond | Found::Enough(_) | Found::Overlap(_) => point,
    }
}

fn wide(vector: Vec3A) -> DVec3 {
    vector.as_dvec3()
}
