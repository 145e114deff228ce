//! How far two convex shapes are apart, by the algorithm of Gilbert, Johnson and Keerthi (*A Fast
//! Procedure for Computing the Distance between Complex Objects*, 1988), and how deep they are in
//! each other, by an expanding polytope (van den Bergen, *Proximity Queries and Penetration Depth
//! Computation on 3D Game Objects*, 2001).
//!
//! Both look at the difference of the cores of two shapes, the set of all ways from a point of the
//! second to one of the first: how far it is from the origin, and how deep the origin is inside.
//! Whatever is found is certain to its bounds: a plane with all of the difference beyond says that
//! the two are apart, and by how much.

use bevy::math::DVec3;

use super::convex::Convex;
use super::gap::Gap;
use super::segment_triangle;

/// Where a search for the distance ends that finds no end by itself: it is exact long before.
const MOST_STEPS: usize = 64;
/// What is left uncertain of a distance, as a share of it and of the sizes at hand.
const PRECISION: f64 = 1e-9;
/// What counts as flat, or as nothing, as a share of the sizes at hand: more than rounding.
const FLAT: f64 = 1e-13;
/// So often is a polytope expanded: enough for the depth of round shapes to be off by less than a
/// hundredth.
const MOST_EXPANSIONS: usize = 64;

/// The gap between two shapes; `None` if it is wider than `limit`. Where the depth is not asked
/// for, the distance of two that overlap is no more than negative.
pub fn gap(a: &Convex, b: &Convex, limit: f64, with_depth: bool) -> Option<Gap> {
    let radii = [a.radius, b.radius];
    let limit = limit + a.radius + b.radius;
    let in_closed_form = |a: &Convex, b: &Convex| {
        let (segment, triangle) = (a.core_segment()?, b.core_triangle()?);
        Some(segment_triangle::gap(segment, triangle, limit, with_depth))
    };
    if let Some(gap) = in_closed_form(a, b) {
        return Some(gap?.grown(radii));
    }
    if let Some(gap) = in_closed_form(b, a) {
        return Some(gap?.reversed().grown(radii));
    }
    by_steps(a, b, limit, with_depth).map(|gap| gap.grown(radii))
}

/// The gap between two cores, whatever they are.
pub fn by_steps(a: &Convex, b: &Convex, limit: f64, with_depth: bool) -> Option<Gap> {
    let difference = |direction: DVec3| {
        let on = [a.furthest(direction), b.furthest(-direction)];
        Vertex {
            point: on[0] - on[1],
            on,
        }
    };
    let towards_b = (b.at.translation - a.at.translation)
        .try_normalize()
        .unwrap_or(DVec3::X);
    let mut simplex = Simplex::new(difference(towards_b));
    let mut size = simplex.nearest().length();
    let mut is_inside = false;
    for _ in 0..MOST_STEPS {
        let nearest = simplex.nearest();
        let distance = nearest.length();
        if distance <= FLAT * size {
            is_inside = true;
            break;
        }
        let vertex = difference(-nearest / distance);
        size = size.max(vertex.point.length());
        // All of the difference is as far from the origin, this way.
        let certain = vertex.point.dot(nearest) / distance;
        if certain > limit {
            return None;
        }
        if distance - certain <= PRECISION * (distance + size) {
            break;
        }
        let Some(next) = simplex.with(vertex) else {
            simplex.enclose(vertex);
            is_inside = true;
            break;
        };
        // A step that is none would be made over and over.
        if next.nearest().length_squared() >= distance * distance {
            break;
        }
        simplex = next;
    }
    let nearest = simplex.nearest();
    if let Some(normal) = (-nearest).try_normalize().filter(|_| !is_inside) {
        let gap = Gap {
            distance: nearest.length(),
            normal,
            points: simplex.points(),
            between: DVec3::ZERO,
        };
        return Some(gap).filter(|gap| gap.distance <= limit);
    }
    let [on_a, on_b] = simplex.points();
    let between = on_a.midpoint(on_b);
    let overlap = Gap {
        distance: -f64::MIN_POSITIVE,
        normal: towards_b,
        points: [between; 2],
        between,
    };
    Some(if with_depth {
        expand(&simplex, difference, size, overlap)
    } else {
        overlap
    })
}

/// A point of the difference of two shapes, and of which points it is that.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    point: DVec3,
    on: [DVec3; 2],
}

/// Up to four points of the difference, with the weights that make up the point of their hull
/// closest to the origin.
#[derive(Clone, Copy, Debug)]
struct Simplex {
    vertices: [Vertex; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    fn new(vertex: Vertex) -> Self {
        Self {
            vertices: [vertex; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
            count: 1,
        }
    }

    fn vertices(&self) -> &[Vertex] {
        debug_assert!((1..=4).contains(&self.count), "{} vertices", self.count);
        &self.vertices[..self.count]
    }

    fn weighted(&self, of: impl Fn(&Vertex) -> DVec3) -> DVec3 {
        self.vertices()
            .iter()
            .zip(self.weights)
            .map(|(vertex, weight)| of(vertex) * weight)
            .sum()
    }

    /// The point of the hull that is closest to the origin.
    fn nearest(&self) -> DVec3 {
        self.weighted(|vertex| vertex.point)
    }

    /// The points of the two shapes that it comes from.
    fn points(&self) -> [DVec3; 2] {
        [
            self.weighted(|vertex| vertex.on[0]),
            self.weighted(|vertex| vertex.on[1]),
        ]
    }

    /// With one more vertex, and without those that are then no use; `None` if the hull has the
    /// origin inside.
    fn with(&self, vertex: Vertex) -> Option<Self> {
        let all = self.joined(vertex);
        let points = all.vertices.map(|vertex| vertex.point);
        let weights = match all.count {
            2 => segment(points, [0, 1]),
            3 => triangle(points, [0, 1, 2]),
            _ => tetrahedron(points)?,
        };
        let mut kept = Self { count: 0, ..all };
        for (vertex, weight) in all.vertices().iter().zip(weights) {
            if weight > 0.0 {
                (kept.vertices[kept.count], kept.weights[kept.count]) = (*vertex, weight);
                kept.count += 1;
            }
        }
        Some(kept)
    }

    fn joined(&self, vertex: Vertex) -> Self {
        let mut all = *self;
        all.vertices[all.count.min(3)] = vertex;
        all.count = (all.count + 1).min(4);
        all
    }

    /// Becomes the hull with one more vertex, which has the origin inside.
    fn enclose(&mut self, vertex: Vertex) {
        *self = self.joined(vertex);
        self.weights = inside(self.vertices.map(|vertex| vertex.point)).unwrap_or([0.25; 4]);
    }
}

/// The weights of the point of a segment that is closest to the origin.
fn segment(points: [DVec3; 4], [i, j]: [usize; 2]) -> [f64; 4] {
    let (a, along) = (points[i], points[j] - points[i]);
    let squared = along.length_squared();
    let share = if squared > 0.0 {
        (-a.dot(along) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut weights = [0.0; 4];
    (weights[i], weights[j]) = (1.0 - share, share);
    weights
}

/// The weights of the point of a triangle that is closest to the origin.
fn triangle(points: [DVec3; 4], corners: [usize; 3]) -> [f64; 4] {
    let [a, b, c] = corners.map(|corner| points[corner]);
    let normal = (b - a).cross(c - a);
    let squared = normal.length_squared();
    let areas = [b.cross(c), c.cross(a), a.cross(b)].map(|area| area.dot(normal));
    let whole: f64 = areas.iter().sum();
    let mut weights = [0.0; 4];
    if squared > 0.0 && whole > 0.0 && areas.iter().all(|area| *area >= 0.0) {
        for (corner, area) in corners.into_iter().zip(areas) {
            weights[corner] = area / whole;
        }
        return weights;
    }
    let [i, j, k] = corners;
    closest(
        points,
        [
            segment(points, [i, j]),
            segment(points, [j, k]),
            segment(points, [k, i]),
        ],
    )
}

/// The weights of the point of a tetrahedron that is closest to the origin; `None` if that is
/// inside.
fn tetrahedron(points: [DVec3; 4]) -> Option<[f64; 4]> {
    if inside(points).is_some() {
        return None;
    }
    // The triangle of the first three has been looked at before the fourth came.
    let sides = [[0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|side| triangle(points, side));
    Some(closest(points, sides))
}

/// The weights of the origin, if it is inside a tetrahedron that is not flat.
fn inside(points: [DVec3; 4]) -> Option<[f64; 4]> {
    let [a, b, c, d] = points;
    let [u, v, w] = [b - a, c - a, d - a];
    let volume = u.cross(v).dot(w);
    let longest = u
        .length_squared()
        .max(v.length_squared())
        .max(w.length_squared())
        .sqrt();
    if volume.abs() <= FLAT * longest.powi(3) {
        return None;
    }
    let [to_b, to_c, to_d] =
        [v.cross(w), w.cross(u), u.cross(v)].map(|normal| -a.dot(normal) / volume);
    let weights = [1.0 - to_b - to_c - to_d, to_b, to_c, to_d];
    weights
        .iter()
        .all(|weight| *weight >= 0.0)
        .then_some(weights)
}

/// Those of some weights whose point is closest to the origin.
fn closest<const N: usize>(points: [DVec3; 4], weights: [[f64; 4]; N]) -> [f64; 4] {
    let squared = |weights: &[f64; 4]| -> f64 {
        points
            .iter()
            .zip(weights)
            .map(|(point, weight)| *point * *weight)
            .sum::<DVec3>()
            .length_squared()
    };
    weights
        .into_iter()
        .min_by(|a, b| squared(a).total_cmp(&squared(b)))
        .expect("there are some")
}

/// A triangle of the polytope, counter-clockwise as seen from outside.
#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [usize; 3],
    normal: DVec3,
    offset: f64,
}

impl Facet {
    fn new(vertices: &[Vertex], corners: [usize; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| vertices[corner].point);
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Self {
            corners,
            normal,
            offset: normal.dot(a),
        })
    }
}

/// The least overlap of two shapes, of whose difference the simplex has the origin inside: that of
/// the polytope that begins with it and grows where it is closest to the origin. Every direction
/// that is tried parts the two, and so the least is no guess wherever the search ends.
fn expand(simplex: &Simplex, difference: impl Fn(DVec3) -> Vertex, size: f64, overlap: Gap) -> Gap {
    let mut vertices = Vec::with_capacity(16);
    if let Some(flat) = span(simplex, &difference, FLAT * size, &mut vertices) {
        // Without a volume, they overlap by nothing.
        let normal = if flat.dot(overlap.normal) < 0.0 {
            -flat
        } else {
            flat
        };
        return Gap { normal, ..overlap };
    }
    let outwards = |corners: [usize; 3], inner: usize| {
        let facet = Facet::new(&vertices, corners)?;
        let is_outside = facet.normal.dot(vertices[inner].point) <= facet.offset;
        if is_outside {
            Some(facet)
        } else {
            Facet::new(&vertices, [corners[0], corners[2], corners[1]])
        }
    };
    let first = [
        ([0, 1, 2], 3),
        ([0, 1, 3], 2),
        ([0, 2, 3], 1),
        ([1, 2, 3], 0),
    ];
    let mut facets: Vec<_> = first
        .into_iter()
        .filter_map(|(corners, inner)| outwards(corners, inner))
        .collect();
    let mut least: Option<(f64, Facet)> = None;
    let mut horizon = Vec::new();
    for _ in 0..MOST_EXPANSIONS {
        let Some(nearest) = facets
            .iter()
            .min_by(|a, b| a.offset.total_cmp(&b.offset))
            .copied()
        else {
            break;
        };
        let vertex = difference(nearest.normal);
        let reach = vertex.point.dot(nearest.normal);
        if least.is_none_or(|(least, _)| reach < least) {
            least = Some((reach, nearest));
        }
        if reach - nearest.offset <= PRECISION * (size + reach) {
            break;
        }
        vertices.push(vertex);
        let is_seen = |facet: &Facet| facet.normal.dot(vertex.point) - facet.offset > FLAT * size;
        horizon.clear();
        let edges = |[i, j, k]: [usize; 3]| [[i, j], [j, k], [k, i]];
        horizon.extend(
            facets
                .iter()
                .filter(|facet| is_seen(facet))
                .flat_map(|facet| edges(facet.corners)),
        );
        facets.retain(|facet| !is_seen(facet));
        // Between two that are seen is no horizon.
        let border = horizon.iter().filter(|[i, j]| !horizon.contains(&[*j, *i]));
        facets.extend(
            border.filter_map(|[i, j]| Facet::new(&vertices, [*i, *j, vertices.len() - 1])),
        );
    }
    let Some((reach, facet)) = least else {
        return overlap;
    };
    let mut corners = [DVec3::ZERO; 4];
    for (corner, vertex) in corners.iter_mut().zip(facet.corners) {
        *corner = vertices[vertex].point;
    }
    let weights = triangle(corners, [0, 1, 2]);
    let on = |which: usize| {
        facet
            .corners
            .iter()
            .zip(weights)
            .map(|(i, weight)| vertices[*i].on[which] * weight)
            .sum()
    };
    let points: [DVec3; 2] = [on(0), on(1)];
    Gap {
        distance: -reach.max(f64::MIN_POSITIVE),
        normal: facet.normal,
        points,
        between: points[0].midpoint(points[1]),
    }
}

/// Four points of the difference that span a volume, those of the simplex first; or a direction in
/// which it has no extent.
fn span(
    simplex: &Simplex,
    difference: impl Fn(DVec3) -> Vertex,
    flat: f64,
    vertices: &mut Vec<Vertex>,
) -> Option<DVec3> {
    /// How far a point is from the hull of the others.
    fn height(vertices: &[Vertex], point: DVec3) -> f64 {
        match *vertices {
            [] => f64::INFINITY,
            [a] => point.distance(a.point),
            [a, b] => (point - a.point).reject_from(b.point - a.point).length(),
            [a, b, c, ..] => (point - a.point).dot(across(a, b, c)).abs(),
        }
    }
    fn across(a: Vertex, b: Vertex, c: Vertex) -> DVec3 {
        (b.point - a.point)
            .cross(c.point - a.point)
            .normalize_or_zero()
    }
    for vertex in simplex.vertices() {
        if height(vertices, vertex.point) > flat {
            vertices.push(*vertex);
        }
    }
    while vertices.len() < 4 {
        let directions = match *vertices.as_slice() {
            [a, b] => {
                let (u, v) = (b.point - a.point)
                    .normalize_or(DVec3::X)
                    .any_orthonormal_pair();
                [u, v, u]
            }
            [a, b, c] => [across(a, b, c); 3],
            _ => DVec3::AXES,
        };
        let candidates = directions
            .into_iter()
            .flat_map(|direction| [direction, -direction])
            .map(&difference);
        let furthest = candidates
            .max_by(|a, b| height(vertices, a.point).total_cmp(&height(vertices, b.point)));
        match furthest {
            Some(vertex) if height(vertices, vertex.point) > flat => vertices.push(vertex),
            _ => return Some(directions[0]),
        }
    }
    None
}
