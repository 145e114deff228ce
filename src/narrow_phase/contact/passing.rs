//! Whether two that touch keep each other from going on, where more than one plane parts them.
//!
//! A box that slides over a floor of flush boxes comes to touch each of them edge on edge. Its
//! front and its bottom both part it from the next one, and the contact says nothing about which of
//! them counts. Its way does: what stays on its side of a plane that parts the two is not in the
//! way of the other, whatever else they touch.

use std::ops::ControlFlow;

use bevy::math::{Vec3, Vec3A};

use crate::narrow_phase::{
    answer::Contact,
    frame::{
        approach::approach,
        case::Case,
        edge_polygon::{self, Touch},
        placed::{Placed, PlacedPair, in_order},
        separation::sign,
        solid::Solid,
        two_solids,
        workspace::Workspace,
    },
    settings::NarrowPhase,
    support,
};

/// So many planes at most are looked at: there are few where two solids touch, and the first ones
/// do.
const MOST_PLANES: usize = 16;

/// The square of the distance of two normals that count as one: what rounding makes of it.
const SAME: f32 = 1e-12;
/// The same of what faces the other way: two in one plane are on either side of it, and on which one they
/// came, their contact says.
const AGAINST: f32 = 1e-6;

impl NarrowPhase {
    /// The contact of two of which the first moves with a velocity, as the second sees it, which
    /// may depend on the point of contact: as [`contact`](Self::contact), but where they no more
    /// than touch, and the planes of several faces part them to within the tolerance, with the
    /// normal along which they come nearer to each other the least.
    pub(crate) fn contact_in_passing(
        &self,
        a: Placed,
        b: Placed,
        velocity: impl FnOnce(Vec3) -> Vec3,
        workspace: &mut Workspace,
    ) -> Option<Contact> {
        let contact = self.contact(a, b, workspace)?;
        let normal =
            self.normal_in_passing(a, b, contact.normal, velocity(contact.point), workspace);
        Some(Contact { normal, ..contact })
    }

    /// Of all normals that part two which touch, that one among them, the one along which they come
    /// nearer to each other the least.
    pub(crate) fn normal_in_passing(
        &self,
        a: Placed,
        b: Placed,
        normal: Vec3,
        velocity: Vec3,
        workspace: &mut Workspace,
    ) -> Vec3 {
        if !approach([velocity, Vec3::ZERO], normal) {
            return normal;
        }
        if let Some(normal) = support::with_own(a, b, |a, b| {
            self.normal_in_passing(a, b, normal, velocity, workspace)
        }) {
            return normal;
        }
        let (first, second, swapped) = in_order(a, b);
        let turn = if swapped { -1.0 } else { 1.0 };
        let Ok(pair) = PlacedPair::new(first, second, self.tolerance()) else {
            return normal;
        };
        // By more than rounding, as the early stages have it.
        let pair = PlacedPair {
            tolerance: 2.0 * pair.tolerance,
            ..pair
        };
        let planes = Planes::new(
            Vec3A::from(normal) * turn,
            Vec3A::from(velocity) * turn,
            pair.tolerance,
        );
        let best = match pair.case() {
            Case::Spheres | Case::Parts | Case::Foreign => return normal,
            Case::SphereFirst => planes.of_sphere(&pair, workspace),
            Case::SphereSecond => -planes.reversed().of_sphere(&pair.swapped(), workspace),
            Case::Cuboids => planes.of_boxes(&pair),
            Case::Convex => match two_solids::place_both(&pair, workspace) {
                Some(solids) => planes.of_solids(solids),
                None => planes.of_polygons(&pair, workspace),
            },
            Case::Polygons => planes.of_polygons(&pair, workspace),
        };
        Vec3::from(best) * turn
    }
}

/// The planes that may part two shapes.
struct Planes {
    velocity: Vec3A,
    tolerance: f32,
    count: usize,
    /// The first is that of the contact.
    normals: [Vec3A; MOST_PLANES],
    /// How far the first shape reaches along each of them, where the two touch, and where the
    /// second begins.
    reach: [f32; MOST_PLANES],
    begin: [f32; MOST_PLANES],
}

impl Planes {
    fn new(normal: Vec3A, velocity: Vec3A, tolerance: f32) -> Self {
        Self {
            velocity,
            tolerance,
            count: 1,
            normals: [normal; MOST_PLANES],
            reach: [f32::NEG_INFINITY; MOST_PLANES],
            begin: [f32::INFINITY; MOST_PLANES],
        }
    }

    /// Those of the pair with its two shapes swapped.
    fn reversed(&self) -> Self {
        Self::new(-self.normals[0], -self.velocity, self.tolerance)
    }

    /// Takes up a plane, by its normal from the first shape to the second.
    fn suggest(&mut self, normal: Vec3A) {
        let is_new = || {
            let mut known = self.normals[..self.count].iter();
            known.all(|known| known.distance_squared(normal) > SAME)
                && self.normals[0].distance_squared(-normal) > AGAINST
        };
        if normal != Vec3A::ZERO && self.count < MOST_PLANES && is_new() {
            self.normals[self.count] = normal;
            self.count += 1;
        }
    }

    fn reaches(&mut self, points: impl Iterator<Item = Vec3A> + Clone) {
        for (reach, normal) in self.reach.iter_mut().zip(&self.normals[..self.count]) {
            *reach = points
                .clone()
                .fold(*reach, |reach, point| reach.max(point.dot(*normal)));
        }
    }

    fn begins(&mut self, points: impl Iterator<Item = Vec3A> + Clone) {
        for (begin, normal) in self.begin.iter_mut().zip(&self.normals[..self.count]) {
            *begin = points
                .clone()
                .fold(*begin, |begin, point| begin.min(point.dot(*normal)));
        }
    }

    /// The best of those that part the two; that of the contact, if there is none, or none that is
    /// better.
    fn best(&self) -> Vec3A {
        let slowest = |best: Option<usize>, plane: usize| {
            let closing = |plane: usize| self.normals[plane].dot(self.velocity);
            let is_slower =
                |best: usize| closing(plane) < closing(best) - 1e-6 * self.velocity.length();
            if best.is_none_or(is_slower) {
                Some(plane)
            } else {
                best
            }
        };
        let parts = |plane: &usize| self.begin[*plane] - self.reach[*plane] >= -self.tolerance;
        let best = (0..self.count).filter(parts).fold(None, slowest);
        self.normals[best.unwrap_or(0)]
    }

    /// A sphere, the first of the pair, and a shape made of polygons: the planes of faces that it
    /// touches.
    fn of_sphere(mut self, pair: &PlacedPair, workspace: &mut Workspace) -> Vec3A {
        let (center, radius) = (pair.box_a.center, pair.box_a.radius);
        let Some((_, surface)) = edge_polygon::fill_second_near(pair, workspace) else {
            return self.normals[0];
        };
        let touched = || {
            surface.faces.iter().filter(|face| {
                let closest = surface.closest_point_of(face, center);
                closest.is_some_and(|closest| closest.distance(center) <= radius + pair.tolerance)
            })
        };
        for face in touched() {
            let height = center.dot(face.normal) - face.plane;
            self.suggest(face.normal * -(1f32.copysign(height)));
        }
        if self.count > 1 {
            for (reach, normal) in self.reach.iter_mut().zip(&self.normals) {
                *reach = center.dot(*normal) + radius;
            }
            touched().for_each(|face| self.begins(surface.corners(face).iter().copied()));
        }
        self.best()
    }

    /// Takes up a plane of a convex solid, given how far the two are apart along its normal, which
    /// is all that has to be known of it.
    fn suggest_apart(&mut self, normal: Vec3A, gap: f32) {
        if gap < -self.tolerance {
            return;
        }
        let before = self.count;
        self.suggest(normal);
        if self.count > before {
            (self.reach[before], self.begin[before]) = (0.0, gap);
        }
    }

    /// Two cuboids: the planes of their faces.
    fn of_boxes(mut self, pair: &PlacedPair) -> Vec3A {
        let (a, b) = (&pair.box_a, &pair.box_b);
        let offset = b.center - a.center;
        let gap = |normal: Vec3A| normal.dot(offset) - a.extent(normal) - b.extent(normal);
        (self.reach[0], self.begin[0]) = (0.0, gap(self.normals[0]));
        for axis in [b, a]
            .into_iter()
            .flat_map(|bounds| [0, 1, 2].map(|axis| bounds.axes.col(axis)))
        {
            let normal = axis * sign(axis.dot(offset));
            self.suggest_apart(normal, gap(normal));
        }
        self.best()
    }

    /// Two convex meshes: the planes of their faces.
    fn of_solids(mut self, [a, b]: [&Solid; 2]) -> Vec3A {
        (self.reach[0], self.begin[0]) = (0.0, a.gap(b, self.normals[0]));
        let of_b = b.normals.iter().map(|normal| -*normal);
        for normal in of_b.chain(a.normals.iter().copied()) {
            self.suggest_apart(normal, a.gap(b, normal));
        }
        self.best()
    }

    /// Two shapes made of polygons: the planes of faces that edges of the other touch.
    fn of_polygons(mut self, pair: &PlacedPair, workspace: &mut Workspace) -> Vec3A {
        let Some(_) = edge_polygon::fill(pair, workspace) else {
            return self.normals[0];
        };
        let workspace = &*workspace;
        let each = |visit: &mut dyn FnMut(Touch)| {
            let _ = edge_polygon::for_each_touch(&workspace.surfaces, pair.tolerance, |hit| {
                visit(hit);
                ControlFlow::Continue(())
            });
        };
        // Of a surface without an inside, either side may be the one that the other is on.
        let is_two_sided = pair.case() == Case::Polygons;
        each(&mut |hit| {
            self.suggest(hit.normal);
            if is_two_sided {
                self.suggest(-hit.normal);
            }
        });
        if self.count == 1 {
            return self.normals[0];
        }
        each(&mut |hit| {
            let [on_a, on_b] = &workspace.surfaces;
            if hit.of_first {
                self.reaches(hit.edge.into_iter());
                self.begins(on_b.corners(&hit.face).iter().copied());
            } else {
                self.reaches(on_a.corners(&hit.face).iter().copied());
                self.begins(hit.edge.into_iter());
            }
        });
        self.best()
    }
}
