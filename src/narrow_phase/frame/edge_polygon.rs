//! The last stage: every edge of one mesh against every polygon of the other, both ways, as far as
//! trees find them near each other, then the question whether one is inside the other.

use std::ops::ControlFlow;

use bevy::math::Vec3A;

use super::apart;
use super::cuboid_mesh::{self, CuboidMesh, Found};
use super::local_aabb::LocalAabb;
use super::near_faces::{Touching, for_each_near};
use super::oriented_box::OrientedBox;
use super::outward;
use super::placed::{Placed, PlacedPair};
use super::surface::{ClosestPoint, PlacedFace, Surface};
use super::workspace::Workspace;
use crate::broad_phase::Overlap;
use crate::narrow_phase::mesh::{cube::CUBE, polygon_mesh::PolygonMesh};

/// Where an edge of one mesh comes as close to a polygon of the other as the tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    pub point: Vec3A,
    /// The normal of the polygon, turned to point from the first mesh to the second.
    pub normal: Vec3A,
    /// Is the edge one of the first mesh?
    pub of_first: bool,
    pub edge: [Vec3A; 2],
    pub face: PlacedFace,
}

/// Whether two shapes made of polygons are in contact. False if one is not.
pub fn intersects(pair: &PlacedPair, workspace: &mut Workspace) -> bool {
    if let Some(both) = CuboidMesh::of(pair) {
        return cuboid_intersects(&both, pair, workspace);
    }
    let mut touch = false;
    let meshes = for_each_surface(pair, workspace, |surfaces| {
        let stop = |_| ControlFlow::Break(());
        touch = for_each_touch(surfaces, pair.tolerance, stop).is_break();
        if touch {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    touch || meshes.is_some_and(|meshes| nested(pair, meshes, workspace).is_some())
}

/// Whether a cuboid and a mesh with a tree are in contact.
fn cuboid_intersects(both: &CuboidMesh, pair: &PlacedPair, workspace: &mut Workspace) -> bool {
    let (half, tolerance) = (both.half(), pair.tolerance);
    place_both(pair, &mut workspace.surfaces);
    let mut touch = false;
    both.for_each(&Touching(2.0 * tolerance), 0.0, |found| {
        touch = match found {
            Found::Triangle(corners) => cuboid_mesh::touches(half, corners, tolerance),
            Found::Polygon(polygon) => {
                let surfaces = &mut workspace.surfaces;
                select_polygon(both, polygon, tolerance, surfaces);
                for_each_touch(surfaces, tolerance, |_| ControlFlow::Break(())).is_break()
            }
        };
        if touch {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(0.0)
        }
    });
    touch || nested(pair, both.in_order(&*CUBE, both.mesh), workspace).is_some()
}

/// Puts both shapes in place, if they are made of polygons, with none of these selected.
pub fn place_both(pair: &PlacedPair, surfaces: &mut [Surface; 2]) {
    let of = [(pair.a, &pair.box_a), (pair.b, &pair.box_b)];
    for (surface, (placed, bounds)) in surfaces.iter_mut().zip(of) {
        if let Some(polygons) = placed.shape.polygons() {
            surface.place(polygons, placed, bounds);
        }
    }
}

/// Selects all faces of the cuboid, if that has not been done, and a polygon of the mesh.
pub fn select_polygon(
    both: &CuboidMesh,
    polygon: u32,
    tolerance: f32,
    surfaces: &mut [Surface; 2],
) {
    let [of_cuboid, of_mesh] = both.in_order(0, 1);
    if surfaces[of_cuboid].faces.is_empty() {
        surfaces[of_cuboid].select_all(&CUBE, tolerance);
    }
    surfaces[of_mesh].select(both.mesh, polygon, tolerance);
}

/// Calls `visit` with all points where the surfaces of two shapes made of polygons meet: once for
/// each edge and polygon, or for each polygon that shares the edge.
pub fn touches(pair: &PlacedPair, workspace: &mut Workspace, mut visit: impl FnMut(Touch)) {
    for_each_surface(pair, workspace, |surfaces| {
        for_each_touch(surfaces, pair.tolerance, |hit| {
            visit(hit);
            ControlFlow::Continue(())
        })
    });
}

/// Calls `visit` with what of two shapes made of polygons may touch, until it breaks. `None` if one
/// is not made of polygons.
fn for_each_surface<'a>(
    pair: &PlacedPair<'a>,
    workspace: &mut Workspace,
    mut visit: impl FnMut(&[Surface; 2]) -> ControlFlow<()>,
) -> Option<[&'a PolygonMesh; 2]> {
    let has_tree = |placed: Placed| {
        let polygons = placed.shape.polygons();
        polygons.is_some_and(|(mesh, _)| mesh.tree().is_some())
    };
    if has_tree(pair.a) || has_tree(pair.b) {
        let near = Touching(2.0 * pair.tolerance);
        return for_each_near(&near, pair, workspace, 0.0, |surfaces| {
            visit(surfaces)?;
            ControlFlow::Continue(0.0)
        });
    }
    let meshes = fill(pair, workspace)?;
    let _ = visit(&workspace.surfaces);
    Some(meshes)
}

/// Whether a sphere, the first of the pair, is in contact with a shape made of polygons.
pub fn sphere_intersects(pair: &PlacedPair, workspace: &mut Workspace) -> bool {
    let sphere = &pair.box_a;
    let limit = sphere.radius + pair.tolerance;
    let found = match pair.b.shape.polygons() {
        Some((mesh, _)) if mesh.tree().is_some() => fill_second_to_search(pair, workspace),
        _ => fill_second_near(pair, workspace),
    };
    found.is_some_and(|(mesh, surface)| {
        surface.is_near(mesh, sphere.center, limit) || surface.encloses(mesh, sphere.center)
    })
}

/// The point on a mesh, the second of the pair, that is closest to the centre of a sphere, the
/// first; and whether the centre is inside the mesh.
pub fn sphere_closest(
    pair: &PlacedPair,
    workspace: &mut Workspace,
) -> Option<(ClosestPoint, bool)> {
    let (mesh, surface) = fill_second_to_search(pair, workspace)?;
    let center = pair.box_a.center;
    let closest = surface.closest_of_all(mesh, center, f32::INFINITY)?;
    Some((closest, is_inside(pair, mesh, surface, &closest)))
}

/// Whether the centre of a sphere, the first of the pair, is inside a mesh, whose closest point is
/// known: by the side of the surface there, if that tells.
fn is_inside(
    pair: &PlacedPair,
    mesh: &PolygonMesh,
    surface: &Surface,
    closest: &ClosestPoint,
) -> bool {
    let center = pair.box_a.center;
    if !mesh.has_inside() || surface.placing().is_beyond(center) {
        return false;
    }
    let is_told = surface.placing().is_even() && apart::tells_sides(mesh);
    is_told
        .then(|| outward::is_behind(mesh, surface.placing(), closest, center, pair.tolerance))
        .flatten()
        .unwrap_or_else(|| surface.encloses(mesh, center))
}

/// The same as [`sphere_closest`] if the sphere is in contact with the mesh, and only then.
pub fn sphere_touching(
    pair: &PlacedPair,
    workspace: &mut Workspace,
) -> Option<(ClosestPoint, bool)> {
    let (mesh, surface) = fill_second_to_search(pair, workspace)?;
    let sphere = &pair.box_a;
    let limit = sphere.radius + pair.tolerance;
    if let Some(closest) = surface.closest_of_all(mesh, sphere.center, limit) {
        return Some((closest, is_inside(pair, mesh, surface, &closest)));
    }
    if !surface.encloses(mesh, sphere.center) {
        return None;
    }
    let closest = surface.closest_of_all(mesh, sphere.center, f32::INFINITY)?;
    Some((closest, true))
}

/// Whether a point is inside a mesh, the second of the pair.
pub fn encloses(pair: &PlacedPair, point: Vec3A, workspace: &mut Workspace) -> bool {
    // One without an inside is not even put in place.
    pair.b
        .shape
        .polygons()
        .is_some_and(|(mesh, _)| mesh.has_inside())
        && fill_second(pair, &LocalAabb::NOWHERE, workspace)
            .is_some_and(|(mesh, surface)| surface.encloses(mesh, point))
}

/// Puts the second mesh in place, to be searched for its closest point: with no faces if it has a
/// tree, with all of them if not.
pub fn fill_second_to_search<'a>(
    pair: &PlacedPair<'a>,
    workspace: &'a mut Workspace,
) -> Option<(&'a PolygonMesh, &'a mut Surface)> {
    let polygons = pair.b.shape.polygons()?;
    let surface = &mut workspace.surfaces[1];
    surface.place(polygons, pair.b, &pair.box_b);
    if polygons.0.tree().is_none() {
        surface.select_all(polygons.0, pair.tolerance);
    }
    Some((polygons.0, surface))
}

/// Puts the second mesh in place, with the edges and faces in a region.
fn fill_second<'a>(
    pair: &PlacedPair<'a>,
    region: &LocalAabb,
    workspace: &'a mut Workspace,
) -> Option<(&'a PolygonMesh, &'a mut Surface)> {
    let polygons = pair.b.shape.polygons()?;
    let surface = &mut workspace.surfaces[1];
    surface.fill(polygons, pair.b, &pair.box_b, region, pair.tolerance);
    Some((polygons.0, surface))
}

/// Puts the second mesh in place, with the edges and faces near a sphere, the first of the pair.
pub fn fill_second_near<'a>(
    pair: &PlacedPair<'a>,
    workspace: &'a mut Workspace,
) -> Option<(&'a PolygonMesh, &'a mut Surface)> {
    let reach = (pair.box_a.center, pair.box_a.half);
    fill_second(
        pair,
        &LocalAabb::shared(reach, reach, 2.0 * pair.tolerance),
        workspace,
    )
}

/// Puts both meshes in place, with the edges and faces where their boxes overlap.
pub fn fill<'a>(pair: &PlacedPair<'a>, workspace: &mut Workspace) -> Option<[&'a PolygonMesh; 2]> {
    let reach = |bounds: &OrientedBox| (bounds.center, bounds.reach());
    let margin = 2.0 * pair.tolerance;
    let region = LocalAabb::shared(reach(&pair.box_a), reach(&pair.box_b), margin);
    fill_region(pair, region, workspace)
}

/// Puts both meshes in place, with all edges and faces.
pub fn fill_all<'a>(
    pair: &PlacedPair<'a>,
    workspace: &mut Workspace,
) -> Option<[&'a PolygonMesh; 2]> {
    fill_region(pair, LocalAabb::EVERYWHERE, workspace)
}

fn fill_region<'a>(
    pair: &PlacedPair<'a>,
    region: LocalAabb,
    workspace: &mut Workspace,
) -> Option<[&'a PolygonMesh; 2]> {
    let (a, b) = (pair.a.shape.polygons()?, pair.b.shape.polygons()?);
    let [on_a, on_b] = &mut workspace.surfaces;
    on_a.fill(a, pair.a, &pair.box_a, &region, pair.tolerance);
    on_b.fill(b, pair.b, &pair.box_b, &region, pair.tolerance);
    Some([a.0, b.0])
}

pub fn for_each_touch(
    [a, b]: &[Surface; 2],
    tolerance: f32,
    mut visit: impl FnMut(Touch) -> ControlFlow<()>,
) -> ControlFlow<()> {
    one_way(a, b, tolerance, -1.0, &mut visit)?;
    one_way(b, a, tolerance, 1.0, &mut visit)
}

fn one_way(
    edges: &Surface,
    faces: &Surface,
    tolerance: f32,
    towards_second: f32,
    visit: &mut impl FnMut(Touch) -> ControlFlow<()>,
) -> ControlFlow<()> {
    for edge in &edges.edges {
        for face in &faces.faces {
            if let Some(point) = faces.touch(face, edge, tolerance) {
                let normal = face.normal * towards_second;
                visit(Touch {
                    point,
                    normal,
                    of_first: towards_second < 0.0,
                    edge: edge.ends,
                    face: *face,
                })?;
            }
        }
    }
    ControlFlow::Continue(())
}

/// A mesh of so many parts, or fewer, is looked at part by part.
const FEW_PARTS: usize = 8;

/// A point of a part of one mesh that is inside the other. Given that their surfaces do not meet, a
/// part is inside with all of its vertices or with none.
///
/// Both have to be in place. Of a mesh of many parts, those are looked at that the other may hold.
pub fn nested(
    pair: &PlacedPair,
    meshes: [&PolygonMesh; 2],
    workspace: &Workspace,
) -> Option<Vec3A> {
    let [a, b] = &workspace.surfaces;
    within((meshes[0], a), (meshes[1], b, &pair.box_b))
        .or_else(|| within((meshes[1], b), (meshes[0], a, &pair.box_a)))
}

/// A vertex of a part of a mesh that is inside another.
fn within(
    (parts, placed): (&PolygonMesh, &Surface),
    (mesh, around, bounds): (&PolygonMesh, &Surface, &OrientedBox),
) -> Option<Vec3A> {
    if !mesh.has_inside() {
        return None;
    }
    let inside = |vertex: u32| {
        let vertex = placed.vertex(parts, vertex);
        let offset = bounds.axes.transpose() * (vertex - bounds.center);
        let is_close = offset.abs().cmple(bounds.half).all();
        (is_close && around.encloses(mesh, vertex)).then_some(vertex)
    };
    let mut shells = parts.shells();
    let Some(tree) = parts.tree().filter(|_| shells.len() > FEW_PARTS) else {
        return shells.find_map(inside);
    };
    let reach = bounds.reach();
    let region = LocalAabb {
        min: bounds.center - reach,
        max: bounds.center + reach,
    };
    let mut found = None;
    tree.search(
        &Overlap::new(placed.placing().back(&region)?),
        0.0,
        |polygon, _| {
            if parts.is_representative(polygon) {
                found = inside(parts.polygon(polygon as usize)[0]);
            }
            if found.is_some() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(0.0)
            }
        },
    );
    found
}
