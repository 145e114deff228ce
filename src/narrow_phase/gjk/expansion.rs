//! The least overlap of two convex shapes, by an expanding polytope.

use bevy::math::DVec3;

use super::simplex::{Simplex, Vertex, triangle_weights};

/// What counts as flat, as a share of the sizes at hand.
const FLAT: f64 = 1e-12;
/// So often is a polytope expanded: round shapes in the middle of each other need most.
const MOST_EXPANSIONS: usize = 96;

/// How deep two shapes are in each other.
#[derive(Clone, Copy, Debug)]
pub struct Overlap {
    pub depth: f64,
    /// The unit vector, from the first to the second, along which they overlap least.
    pub normal: DVec3,
    /// The points of the two that are deepest in the other.
    pub points: [DVec3; 2],
}

/// A triangle of the polytope, counter-clockwise as seen from outside.
#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [usize; 3],
    normal: DVec3,
    offset: f64,
}

impl Facet {
    fn new(vertices: &[Vertex<DVec3>], corners: [usize; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| vertices[corner].point);
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Self {
            corners,
            normal,
            offset: normal.dot(a),
        })
    }

    /// The same, turned around if a point is in front of it.
    fn away_from(vertices: &[Vertex<DVec3>], corners: [usize; 3], inner: usize) -> Option<Self> {
        let facet = Self::new(vertices, corners)?;
        if facet.normal.dot(vertices[inner].point) <= facet.offset {
            Some(facet)
        } else {
            Self::new(vertices, [corners[0], corners[2], corners[1]])
        }
    }
}

/// The memory of a polytope that expands.
#[derive(Clone, Debug, Default)]
pub struct Polytope {
    vertices: Vec<Vertex<DVec3>>,
    facets: Vec<Facet>,
    horizon: Vec<[usize; 2]>,
}

/// The least overlap of two shapes, of whose difference the simplex has the origin inside: that of
/// the polytope that begins with it and grows where it is closest to the origin. Every direction
/// that is tried parts the two, and so the least is no guess wherever the search ends.
///
/// It ends where no more of the depth is uncertain than that share of the sizes, which leaves the normal
/// uncertain by the root of that where the shapes are round.
///
/// Those without a volume in common overlap by nothing, along a normal that is as near to `towards`
/// as there is.
pub fn expand(
    simplex: &Simplex<DVec3>,
    difference: impl Fn(DVec3) -> Vertex<DVec3>,
    uncertain: f64,
    towards: DVec3,
    polytope: &mut Polytope,
) -> Overlap {
    let Polytope {
        vertices,
        facets,
        horizon,
    } = polytope;
    vertices.clear();
    facets.clear();
    let extents = DVec3::AXES.map(|axis| difference(axis).point.distance(difference(-axis).point));
    let size = extents.into_iter().fold(0.0, f64::max);
    let nothing = |normal: DVec3| Overlap {
        depth: 0.0,
        normal: if normal.dot(towards) < 0.0 {
            -normal
        } else {
            normal
        },
        points: simplex.points(),
    };
    if let Some(flat) = span(simplex, &difference, FLAT * size, vertices) {
        return nothing(flat);
    }
    let first = [
        ([0, 1, 2], 3),
        ([0, 1, 3], 2),
        ([0, 2, 3], 1),
        ([1, 2, 3], 0),
    ];
    let begins = first.map(|(corners, inner)| Facet::away_from(vertices, corners, inner));
    facets.extend(begins.into_iter().flatten());
    let mut least: Option<(f64, Facet)> = None;
    for _ in 0..MOST_EXPANSIONS {
        let by_offset = |a: &&Facet, b: &&Facet| a.offset.total_cmp(&b.offset);
        let Some(nearest) = facets.iter().min_by(by_offset).copied() else {
            break;
        };
        let vertex = difference(nearest.normal);
        let reach = vertex.point.dot(nearest.normal);
        if least.is_none_or(|(least, _)| reach < least) {
            least = Some((reach, nearest));
        }
        // No direction parts them by less than the polytope does.
        let certain = least.map_or(reach, |(least, _)| least);
        if certain - nearest.offset <= uncertain * size {
            break;
        }
        let last = vertices.len();
        vertices.push(vertex);
        horizon.clear();
        facets.retain(|facet| {
            let is_seen = facet.normal.dot(vertex.point) - facet.offset > FLAT * size;
            if is_seen {
                let [i, j, k] = facet.corners;
                horizon.extend([[i, j], [j, k], [k, i]]);
            }
            !is_seen
        });
        if horizon.is_empty() {
            break;
        }
        // Between two that are seen is no horizon.
        let border = horizon.iter().filter(|[i, j]| !horizon.contains(&[*j, *i]));
        facets.extend(border.filter_map(|[i, j]| Facet::new(vertices, [*i, *j, last])));
    }
    let Some((reach, facet)) = least else {
        return nothing(towards);
    };
    let weights = triangle_weights(facet.corners.map(|corner| vertices[corner].point));
    let on = |which: usize| {
        let corners = facet.corners.iter().zip(weights);
        corners
            .map(|(corner, weight)| vertices[*corner].on[which] * weight)
            .sum()
    };
    Overlap {
        depth: reach.max(0.0),
        normal: facet.normal,
        points: [on(0), on(1)],
    }
}

/// Four points of the difference that span a volume, those of the simplex first; or a direction in
/// which it has no extent.
fn span(
    simplex: &Simplex<DVec3>,
    difference: impl Fn(DVec3) -> Vertex<DVec3>,
    flat: f64,
    vertices: &mut Vec<Vertex<DVec3>>,
) -> Option<DVec3> {
    /// How far a point is from the hull of the others.
    fn height(vertices: &[Vertex<DVec3>], point: DVec3) -> f64 {
        match *vertices {
            [] => f64::INFINITY,
            [a] => point.distance(a.point),
            [a, b] => (point - a.point).reject_from(b.point - a.point).length(),
            [a, b, c, ..] => (point - a.point).dot(across(a, b, c)).abs(),
        }
    }
    fn across(a: Vertex<DVec3>, b: Vertex<DVec3>, c: Vertex<DVec3>) -> DVec3 {
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
