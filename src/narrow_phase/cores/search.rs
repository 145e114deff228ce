//! Convex shapes of any kind by their support functions, in 32-bit floats: a fraction of the steps
//! that 64-bit ones take, and as exact as positions are. What these cannot tell is left to those.

use bevy::math::{DVec3, Mat3A, Vec3A};

use super::body::{Body, Core};
use super::nearest::{Closest, Nearest};
use crate::narrow_phase::{
    answer::LocalContact,
    frame::{
        case::Case,
        placed::{Placed, PlacedPair},
    },
    gjk::{Found, Overlap, Polytope, Simplex, Vertex, common_point, expand, search},
    shape::Shape,
};

/// The sizes for which products of lengths are numbers, and not nothing.
const FAIR: std::ops::RangeInclusive<f32> = 1e-4..=1e6;
/// Meshes of more corners have trees that are quicker.
const FEW_CORNERS: usize = 256;
/// The least distance of two cores whose points tell it, and a direction, as a share of the sizes.
const LEAST: f32 = 1e-2;
/// The greatest distance that is told as exactly as the sizes ask for.
const MOST: f32 = 2.0;
/// How much less the overlap along the normals of the second of two has to be to be preferred, and
/// along any that is of neither: as a share of the smaller of the two, or else what is thin, or lies
/// near the border of what is much larger, would be pushed to a wrong side.
const BIAS: f32 = 2e-3;
/// What rounding may make of a distance on two ways to it, as a share of the sizes.
const UNSURE: f32 = 1e-6;
/// What is left uncertain of a depth, as a share of the sizes: about what rounding leaves.
const UNCERTAIN: f64 = 1e-7;
/// The cosine of the angle up to which a normal may be that of a face.
const ALONG_FACE: f32 = 0.999;
/// Two points that are no further apart count as one, as a share of the sizes at hand.
const SAME: f32 = 1e-5;

/// Two convex shapes in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a> {
    a: Body<'a>,
    b: Body<'a>,
    /// How far the two reach from their centres.
    reaches: [f32; 2],
    size: f32,
    tolerance: f32,
    /// The axes in which the two are, if not those of the frame: of a cuboid among them, which is
    /// quicker to ask for it.
    axes: Option<Mat3A>,
}

/// The centre of a ball, inside a convex mesh or over the middle of one of its faces.
struct OverFace {
    center: Vec3A,
    /// How far it is from the face: less than nothing, if it is inside.
    height: f32,
    /// The normal of the face, or against it, from the first of the two to the second.
    towards_b: Vec3A,
    on_mesh: Vec3A,
    is_mesh_first: bool,
}

impl OverFace {
    /// A point of both, where they touch: of a ball that is further inside than it is large, the one
    /// nearest to the face.
    fn point(&self, radius: f32) -> Vec3A {
        let way = self.on_mesh - self.center;
        self.center + way * (radius / self.height.abs().max(f32::MIN_POSITIVE)).min(1.0)
    }

    /// Where the two are closest, given their radii.
    fn nearest(&self, radii: [f32; 2]) -> Nearest {
        let on_mesh = if self.height > 0.0 {
            self.on_mesh
        } else {
            self.center
        };
        let points = if self.is_mesh_first {
            [on_mesh, self.center]
        } else {
            [self.center, on_mesh]
        };
        Nearest {
            points,
            offset: self.towards_b * self.height.max(0.0),
            radii,
        }
    }
}

impl<'a> Bodies<'a> {
    /// Those of a pair; `None` if one is not convex, or so large or small that numbers go out.
    #[inline]
    pub fn of(pair: &PlacedPair<'a>) -> Option<Self> {
        if !FAIR.contains(&pair.size) || pair.is_wide() {
            return None;
        }
        let (mut a, mut b) = (
            Body::of(pair.a, &pair.box_a)?,
            Body::of(pair.b, &pair.box_b)?,
        );
        let own = a.axes_of_cuboid();
        let axes = own.or_else(|| b.axes_of_cuboid());
        if let Some(axes) = &axes {
            (a, b) = (a.along(axes, own.is_some()), b.along(axes, own.is_none()));
        }
        Some(Self {
            a,
            b,
            axes,
            reaches: [pair.box_a.radius, pair.box_b.radius],
            size: pair.size,
            tolerance: pair.tolerance,
        })
    }

    /// Those of a pair for which nothing else is quicker, or tells more.
    #[inline]
    pub fn of_case(pair: &PlacedPair<'a>) -> Option<Self> {
        match pair.case() {
            Case::SphereFirst | Case::SphereSecond | Case::Convex => {
                let is_small = |placed: Placed| match placed.shape {
                    Shape::Convex(mesh) => mesh.vertices().len() <= FEW_CORNERS,
                    _ => true,
                };
                (is_small(pair.a) && is_small(pair.b)).then(|| Self::of(pair))?
            }
            Case::Parts => Self::of(pair),
            Case::Spheres | Case::Cuboids | Case::Polygons | Case::Foreign => None,
        }
    }

    /// See [`search`].
    fn search(&self, limits: [f32; 2], simplex: &mut Simplex<Vec3A>) -> Found {
        let difference =
            |direction| Vertex::of([self.a.furthest(direction), self.b.furthest(-direction)]);
        search(difference, self.towards(), limits, simplex, &mut 0.0)
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
        if let Some(over) = self.over_face() {
            return Some(over.height <= limit);
        }
        match self.search([limit; 2], &mut Simplex::empty()) {
            Found::Beyond | Found::Apart => Some(false),
            Found::Enough | Found::Overlap => Some(true),
            Found::Unsettled => None,
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
        if let Some(over) = self.over_face() {
            return Some(over.nearest([self.a.radius, self.b.radius]).of_surfaces());
        }
        let mut simplex = Simplex::empty();
        match self.search([f32::INFINITY, -1.0], &mut simplex) {
            Found::Apart => {
                let nearest = self.nearest(&simplex);
                let share = nearest.distance() / self.size;
                (share > LEAST && share < MOST)
                    .then(|| self.closest_in_frame(nearest.of_surfaces()))
            }
            Found::Overlap | Found::Enough => {
                let [on_a, on_b] = simplex.points();
                Some(self.closest_in_frame([on_a.midpoint(on_b); 2].into()))
            }
            Found::Beyond | Found::Unsettled => None,
        }
    }

    /// Where and how deep the two meet, if they do: as [`intersects`](Self::intersects) has it. The
    /// outer `None` where that is too close to tell.
    pub fn contact(&self, polytope: &mut Polytope) -> Option<Option<LocalContact>> {
        let found = self.own_contact(polytope)?;
        Some(found.map(|found| match &self.axes {
            None => found,
            Some(axes) => LocalContact {
                normal: *axes * found.normal,
                point: *axes * found.point,
                ..found
            },
        }))
    }

    fn closest_in_frame(&self, found: Closest) -> Closest {
        match &self.axes {
            None => found,
            Some(axes) => {
                let offset = *axes * found.offset;
                Closest {
                    points: found.points.map(|point| *axes * point),
                    offset,
                    distance: offset.length(),
                }
            }
        }
    }

    /// The contact, in the axes in which the two are.
    #[inline]
    fn own_contact(&self, polytope: &mut Polytope) -> Option<Option<LocalContact>> {
        if let Some(over) = self.over_face() {
            let is_met = over.height <= self.tolerance + self.radii();
            return Some(is_met.then(|| LocalContact {
                normal: over.towards_b,
                point: over.point(if over.is_mesh_first {
                    self.b.radius
                } else {
                    self.a.radius
                }),
                depth: (self.radii() - over.height).max(0.0),
            }));
        }
        let mut simplex = Simplex::empty();
        let limit = self.tolerance + self.radii() + UNSURE * self.size;
        let limits = [limit, -1.0];
        match self.search(limits, &mut simplex) {
            Found::Beyond => Some(None),
            Found::Apart => {
                let nearest = self.nearest(&simplex);
                let beyond = nearest.gap() - self.tolerance;
                // Whether they are in contact is for `intersects` alone to say.
                if beyond.abs() <= UNSURE * self.size {
                    return None;
                }
                if beyond > 0.0 {
                    return Some(None);
                }
                if self.have_few_faces() {
                    return self.of_faces(&simplex, false, polytope).map(Some);
                }
                (nearest.distance() > LEAST * self.size).then(|| Some(nearest.contact()))
            }
            Found::Overlap | Found::Enough => {
                if self.have_few_faces() {
                    return self.of_faces(&simplex, true, polytope).map(Some);
                }
                Some(Some(self.deepest(&simplex, polytope)))
            }
            Found::Unsettled => None,
        }
    }

    /// A ball and a convex mesh, if the centre of the ball is inside, or over the middle of a face.
    #[inline]
    fn over_face(&self) -> Option<OverFace> {
        let (center, mesh, is_mesh_first) = match (self.a.core, self.b.core) {
            (Core::Point, Core::Hull(..)) => (self.a.center, &self.b, false),
            (Core::Hull(..), Core::Point) => (self.b.center, &self.a, true),
            _ => return None,
        };
        let under = mesh.face_under(center).filter(|face| face.is_over)?;
        Some(OverFace {
            center,
            height: under.height,
            towards_b: if is_mesh_first {
                under.outwards
            } else {
                -under.outwards
            },
            on_mesh: center - under.outwards * under.height,
            is_mesh_first,
        })
    }

    fn have_few_faces(&self) -> bool {
        self.a.has_few_faces() && self.b.has_few_faces()
    }

    /// Two that are bounded by faces: along the normal of one of these, if no other direction is much
    /// better. The simplex is what the search ended with.
    fn of_faces(
        &self,
        simplex: &Simplex<Vec3A>,
        do_overlap: bool,
        polytope: &mut Polytope,
    ) -> Option<LocalContact> {
        let smaller = self.reaches[0].min(self.reaches[1]);
        let bias = (BIAS * smaller).max(UNSURE * self.size);
        let of_one = |body: &Body, other: &Body, turn: f32| {
            let mut best = (Vec3A::ZERO, f32::NEG_INFINITY);
            body.each_face(|normal, plane| {
                let gap = -other.reach(-normal) - plane;
                if gap > best.1 {
                    best = (normal * turn, gap);
                }
            });
            best
        };
        let mut best = of_one(&self.a, &self.b, 1.0);
        let other = of_one(&self.b, &self.a, -1.0);
        if best.0 == Vec3A::ZERO || other.1 > best.1 + bias {
            best = other;
        }
        // Two edges, or corners, that hardly do not touch: no face tells of them.
        if !do_overlap && best.1 < -bias {
            return Some(self.nearest(simplex).contact());
        }
        if do_overlap && best.1 < -bias {
            let found = self.least_overlap(simplex, polytope);
            if -found.depth as f32 > best.1 + bias {
                best = (found.normal.as_vec3a(), -found.depth as f32);
            }
        }
        // From near the smaller one, the way to a point of both is short.
        let [reach_a, reach_b] = self.reaches;
        let ratio = reach_b / reach_a.max(f32::MIN_POSITIVE);
        let start = self
            .a
            .center
            .lerp(self.b.center, 1.0 / (1.0 + ratio * ratio));
        // What scales of zero leave of meshes may have no faces.
        (best.0 != Vec3A::ZERO).then(|| LocalContact {
            normal: best.0,
            point: self.common_point(start, simplex),
            depth: (-best.1).max(0.0),
        })
    }

    fn least_overlap(&self, simplex: &Simplex<Vec3A>, polytope: &mut Polytope) -> Overlap {
        let difference = |direction: DVec3| {
            let direction = direction.as_vec3a();
            let on = [self.a.furthest(direction), self.b.furthest(-direction)];
            Vertex::of(on.map(wide))
        };
        let towards = wide(self.towards());
        expand(&simplex.wide(), difference, UNCERTAIN, towards, polytope)
    }

    /// Two of which the cores overlap.
    fn deepest(&self, simplex: &Simplex<Vec3A>, polytope: &mut Polytope) -> LocalContact {
        let Overlap {
            depth,
            normal,
            points,
        } = self.least_overlap(simplex, polytope);
        let middle = points[0].midpoint(points[1]).as_vec3a();
        let (normal, depth) = self.along_face(normal.as_vec3a(), depth as f32);
        LocalContact {
            normal,
            point: self.common_point(middle, simplex),
            depth: (depth + self.radii()).max(0.0),
        }
    }

    /// The normal of a face that is as good as one that was found, but for rounding, and the overlap
    /// along it: what lies on a face does so exactly.
    fn along_face(&self, normal: Vec3A, depth: f32) -> (Vec3A, f32) {
        let mut best = (normal, depth);
        let mut most = depth + SAME * self.size;
        for (body, other, turn) in [(&self.a, &self.b, 1.0), (&self.b, &self.a, -1.0)] {
            body.each_face(|face, plane| {
                if face.dot(normal) * turn > ALONG_FACE {
                    let overlap = plane + other.reach(-face);
                    if overlap <= most {
                        (best, most) = ((face * turn, overlap), overlap);
                    }
                }
            });
        }
        best
    }

    /// A point of two cores that touch, near another, by going back and forth between the two; that
    /// which the search ended with, if that takes too long.
    fn common_point(&self, near: Vec3A, simplex: &Simplex<Vec3A>) -> Vec3A {
        let same = self.tolerance.max(SAME * self.size);
        let on_a = |point| closest(&self.a, point);
        let on_b = |point| closest(&self.b, point);
        common_point(near, on_a, on_b, same).unwrap_or_else(|| {
            let [on_a, on_b] = simplex.points();
            on_a.midpoint(on_b)
        })
    }
}

/// The point of a core that is closest to another; that one itself, if it is inside.
fn closest(body: &Body, point: Vec3A) -> Vec3A {
    let difference = |direction| Vertex::of([body.furthest(direction), point]);
    let towards = (point - body.center).try_normalize().unwrap_or(Vec3A::X);
    let mut simplex = Simplex::empty();
    match search(
        difference,
        towards,
        [f32::INFINITY, -1.0],
        &mut simplex,
        &mut 0.0,
    ) {
        Found::Apart | Found::Unsettled => simplex.points()[0],
        Found::Beyond | Found::Enough | Found::Overlap => point,
    }
}

fn wide(vector: Vec3A) -> DVec3 {
    vector.as_dvec3()
}
