//! Meshes of arbitrary vertices and polygons: refused with the fault, or all that is asked of one is
//! what comes of its triangles, one after the other.

use bevy::{
    asset::RenderAssetUsages,
    math::DVec3,
    mesh::{Indices, Mesh, PrimitiveTopology},
    prelude::*,
};
use bevy_octree::narrow_phase::{
    ConvexMesh, Moving, NarrowPhase, Placed, PolygonMesh, Shape, ShapeError, Workspace,
};

use crate::{
    data,
    oracle::{self, Pose, Triangle},
    source::Source,
};

/// How far off an answer may be, as a share of the sizes.
const EXACT: f64 = 2e-5;

/// Makes a mesh of the bytes, in one of several ways.
pub fn run(bytes: &[u8]) {
    let mut source = Source::new(bytes);
    let is_wild = source.may_go_wild();
    match source.below(8) {
        0 => from_bevy(&mut source),
        1 => hull(&mut source, is_wild),
        2 => convex(&mut source),
        kind => {
            let (vertices, polygons) = if kind < 5 {
                data::polygons(&mut source)
            } else {
                lattice(&mut source)
            };
            match PolygonMesh::new(vertices.as_slice(), &polygons) {
                Ok(mesh) => {
                    check_topology(&mesh, &vertices, &polygons);
                    let mesh = if source.bit() {
                        mesh.surface_only()
                    } else {
                        mesh
                    };
                    check_queries(mesh, &mut source, is_wild);
                }
                Err(error) => check_error(&error, &vertices, &polygons),
            }
        }
    }
}

/// The surface of a box of so many cells that it has a tree, its corners moved.
fn lattice(source: &mut Source) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let size = [(); 3].map(|()| 1 + source.below(4) as i32);
    let cell = source.sizes();
    let mut places: Vec<IVec3> = vec![];
    let mut polygons = vec![];
    let mut corner = |at: IVec3| {
        let found = places.iter().position(|place| *place == at);
        found.unwrap_or_else(|| {
            places.push(at);
            places.len() - 1
        }) as u32
    };
    for axis in 0..3 {
        let (across, up) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, size[axis]] {
            for x in 0..size[across] {
                for y in 0..size[up] {
                    let quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[right, above]| {
                        let mut at = IVec3::ZERO;
                        at[axis] = side;
                        at[across] = x + right;
                        at[up] = y + above;
                        corner(at)
                    });
                    let [a, b, c, d] = quad;
                    let triangles = [[a, b, c], [a, c, d]];
                    polygons.extend(triangles.map(|[a, b, c]| {
                        if side == 0 {
                            vec![a, c, b]
                        } else {
                            vec![a, b, c]
                        }
                    }));
                }
            }
        }
    }
    let moved = |place: &IVec3| {
        let by = match source.byte() {
            0..128 => Vec3::ZERO,
            _ => Vec3::from([(); 3].map(|()| f32::from(source.byte().cast_signed()))) / 300.0,
        };
        cell * (place.as_vec3() + by)
    };
    let vertices = places.iter().map(moved).collect();
    for _ in 0..source.below(3) {
        let number = source.below(polygons.len());
        polygons.remove(number);
    }
    (vertices, polygons)
}

/// What an error says is so.
fn check_error(error: &ShapeError, vertices: &[Vec3], polygons: &[Vec<u32>]) {
    assert!(!error.to_string().is_empty());
    match *error {
        ShapeError::Empty => assert!(polygons.is_empty()),
        ShapeError::NonFiniteVertex { vertex, .. } => assert!(!vertices[vertex].is_finite()),
        ShapeError::TooFewCorners { polygon, corners } => {
            assert!(corners < 3 && polygons[polygon].len() == corners);
        }
        ShapeError::IndexOutOfRange {
            polygon, vertex, ..
        } => {
            assert!(vertex as usize >= vertices.len() && polygons[polygon].contains(&vertex));
        }
        ShapeError::RepeatedVertex { polygon, vertex } => {
            let times = polygons[polygon].iter().filter(|corner| **corner == vertex);
            assert!(times.count() > 1);
        }
        ShapeError::ZeroArea { polygon } => {
            let corners: Vec<DVec3> = at(vertices, &polygons[polygon]).collect();
            let reach = reach(&corners);
            let area = area(&corners).length();
            assert!(area <= 1e-5 * reach * reach, "{area} {reach} {corners:?}");
        }
        ShapeError::NotPlanar { polygon, .. } => assert!(polygons[polygon].len() > 3),
        _ => panic!("no fault of a mesh: {error}"),
    }
}

fn at<'a>(vertices: &'a [Vec3], polygon: &'a [u32]) -> impl Iterator<Item = DVec3> + 'a {
    polygon
        .iter()
        .map(|corner| vertices[*corner as usize].as_dvec3())
}

fn reach(corners: &[DVec3]) -> f64 {
    let from = corners[0];
    corners
        .iter()
        .map(|corner| corner.distance(from))
        .fold(0.0, f64::max)
}

/// Twice the area, along the normal.
fn area(corners: &[DVec3]) -> DVec3 {
    let from = corners[0];
    let fan = corners[1..].windows(2);
    fan.map(|pair| (pair[0] - from).cross(pair[1] - from)).sum()
}

fn check_topology(mesh: &PolygonMesh, vertices: &[Vec3], polygons: &[Vec<u32>]) {
    assert_eq!(mesh.vertices(), vertices);
    assert_eq!(mesh.polygon_count(), polygons.len());
    for (number, (own, given)) in mesh.polygons().zip(polygons).enumerate() {
        let sorted = |corners: &[u32]| {
            let mut corners = corners.to_vec();
            corners.sort_unstable();
            corners
        };
        assert_eq!(sorted(own), sorted(given));
        assert_eq!(mesh.polygon_number(number) as usize, number);
        assert_eq!(mesh.polygon_index(number as u32), Some(number));
        let normal = mesh.normals()[number].as_dvec3();
        assert!((normal.length() - 1.0).abs() < 1e-5, "{normal}");
        if own.len() == 3 {
            let corners: Vec<DVec3> = at(vertices, own).collect();
            let area = area(&corners);
            let off = (area.normalize_or_zero() - normal).length();
            let reach = reach(&corners);
            assert!(
                off < 1e-5 || area.length() < 1e-3 * reach * reach,
                "{off} {corners:?}"
            );
        }
        assert!(!mesh.bounds_solid(number) || mesh.has_inside());
    }
    let mut edges: Vec<[u32; 2]> = polygons
        .iter()
        .flat_map(|corners| {
            let next = corners.iter().cycle().skip(1);
            corners
                .iter()
                .zip(next)
                .map(|(a, b)| [*a.min(b), *a.max(b)])
        })
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut own: Vec<[u32; 2]> = mesh
        .edges()
        .iter()
        .map(|[a, b]| [*a.min(b), *a.max(b)])
        .collect();
    own.sort_unstable();
    assert_eq!(own, edges);
    assert_eq!(mesh.is_closed(), mesh.open_edge().is_none());
    // Polygons that bound a solid and share no edge with anything else run once each way along it.
    if mesh.is_closed() && !mesh.is_surface_only() && mesh.has_inside() {
        assert!((0..polygons.len()).any(|number| mesh.bounds_solid(number)));
    }
}

/// The triangles of the polygons for which `is_one_of` holds; `None` if some are not convex.
fn triangles(
    mesh: &PolygonMesh,
    pose: &Pose,
    is_one_of: impl Fn(usize) -> bool,
) -> Option<Vec<Triangle>> {
    let mut triangles = vec![];
    for (number, polygon) in mesh.polygons().enumerate() {
        if !is_one_of(number) {
            continue;
        }
        let own: Vec<DVec3> = at(mesh.vertices(), polygon).collect();
        let normal = mesh.normals()[number].as_dvec3();
        let count = own.len();
        let side = |from: usize, to: usize, third: usize| {
            (own[to] - own[from])
                .cross(own[third] - own[from])
                .dot(normal)
        };
        let is_convex = (0..count).all(|from| {
            let to = (from + 1) % count;
            (0..count).all(|third| third == from || third == to || side(from, to, third) > 0.0)
        });
        if !is_convex && count > 3 {
            return None;
        }
        let corners: Vec<DVec3> = polygon
            .iter()
            .map(|corner| pose.of(mesh.vertices()[*corner as usize]))
            .collect();
        let fan = (1..count - 1).map(|second| [corners[0], corners[second], corners[second + 1]]);
        triangles.extend(fan);
    }
    Some(triangles)
}

/// A mesh in its place, and what it is asked with.
struct Asked {
    shape: Shape,
    at: Transform,
    triangles: Vec<Triangle>,
    /// Of those that bound solids.
    walls: Vec<Triangle>,
    exact: f64,
    tests: NarrowPhase,
}

fn check_queries(mesh: PolygonMesh, source: &mut Source, is_wild: bool) {
    let at = source.pose();
    let pose = Pose::from(&at);
    let all = triangles(&mesh, &pose, |_| true);
    let walls = triangles(&mesh, &pose, |number| mesh.bounds_solid(number));
    let shape = Shape::from(mesh);
    let tests = NarrowPhase::default();
    let (Some(triangles), Some(walls), false) = (all, walls, is_wild) else {
        return ask_anything(&shape, &at, source);
    };
    let size = triangles
        .as_flattened()
        .iter()
        .map(|corner| corner.abs().max_element());
    let size = size.fold(8.0, f64::max);
    let asked = Asked {
        shape,
        at,
        triangles,
        walls,
        exact: EXACT * size + f64::from(tests.tolerance()),
        tests,
    };
    asked.check_box();
    for _ in 0..4 {
        let point = source.vector();
        asked.check_point(point);
        asked.check_ray(point, source.direction(), 16.0);
    }
    // At a corner, and along a side.
    let number = source.below(asked.triangles.len());
    let [a, b, c] = asked.triangles[number].map(DVec3::as_vec3);
    asked.check_point(a);
    asked.check_point((a + b) * 0.5);
    let middle = (a + b + c) / 3.0;
    let from = source.vector();
    if let Ok((direction, length)) = Dir3::new_and_length(middle - from) {
        asked.check_ray(from, direction, length * 2.0);
    }
    let other = match source.below(5) {
        0 => Shape::sphere(source.size()),
        1 => Shape::from_half_size(source.sizes()),
        2 => Shape::capsule(source.size(), source.size()),
        3 => Shape::cylinder(source.size(), source.size()),
        _ => match Shape::tetrahedron(std::array::from_fn(|_| source.vector())) {
            Ok(shape) => shape,
            Err(_) => return,
        },
    };
    asked.check_other(&other, &source.pose(), source.direction());
}

impl Asked {
    fn placed(&self) -> Placed<'_> {
        Placed::new(&self.shape, &self.at)
    }

    fn what(&self) -> String {
        format!("{:?}\n{:?}", self.triangles, self.at)
    }

    /// How far it is to the surface.
    fn surface(&self, point: DVec3) -> f64 {
        let distances = self
            .triangles
            .iter()
            .map(|corners| oracle::distance(*corners, point));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Is it wound around? `None` if that is a matter of rounding.
    fn is_inside(&self, point: DVec3) -> Option<bool> {
        if self.walls.is_empty() {
            return Some(false);
        }
        let winding = oracle::winding(&self.walls, point).abs();
        let is_whole = (winding - winding.round()).abs() < 0.01;
        (self.surface(point) > self.exact && is_whole).then_some(winding > 0.5)
    }

    fn check_box(&self) {
        let aabb = self.shape.world_aabb(&self.at).expect("it is finite");
        let [min, max] = [aabb.min, aabb.max].map(|corner| Vec3::from(corner).as_dvec3());
        let corners = self.triangles.as_flattened();
        let low = corners
            .iter()
            .copied()
            .reduce(DVec3::min)
            .expect("it has corners");
        let high = corners
            .iter()
            .copied()
            .reduce(DVec3::max)
            .expect("it has corners");
        let exact = DVec3::splat(self.exact);
        assert!(
            min.cmple(low + exact).all() && max.cmpge(high - exact).all(),
            "{}",
            self.what()
        );
    }

    fn check_point(&self, point: Vec3) {
        let mut workspace = Workspace::default();
        let closest = self
            .tests
            .closest_point(self.placed(), point, &mut workspace);
        let closest = closest.expect("it is finite");
        let point = point.as_dvec3();
        let found = closest.as_dvec3().distance(point);
        let surface = self.surface(point);
        let mote = Shape::sphere(0.0);
        let here = Transform::from_translation(point.as_vec3());
        let meets = self
            .tests
            .intersects(Placed::new(&mote, &here), self.placed(), &mut workspace);
        let agrees = match self.is_inside(point) {
            Some(true) => found == 0.0 && meets,
            Some(false) => {
                (found - surface).abs() <= self.exact && (!meets || surface <= 2.0 * self.exact)
            }
            None => found <= surface + self.exact,
        };
        assert!(
            agrees,
            "{point}: {found} off, meets: {meets}, but {:?} inside and {surface} off\n{}",
            self.is_inside(point),
            self.what()
        );
        assert!(
            found == 0.0 || self.surface(closest.as_dvec3()) <= 2.0 * self.exact,
            "{closest} is not on it\n{}",
            self.what()
        );
    }

    fn check_ray(&self, origin: Vec3, direction: Dir3, length: f32) {
        let hit = self
            .tests
            .cast_ray(self.placed(), origin, direction, length);
        let (from, way) = (origin.as_dvec3(), direction.as_vec3().as_dvec3());
        let first = self
            .triangles
            .iter()
            .filter_map(|corners| oracle::meets(*corners, from, way))
            .fold(f64::INFINITY, f64::min);
        let until = hit.map_or(f64::from(length), |hit| f64::from(hit.distance));
        let is_inside = self.is_inside(from);
        if is_inside == Some(true) {
            return assert!(until == 0.0, "{origin} is inside\n{}", self.what());
        }
        assert!(
            first >= until - 20.0 * self.exact,
            "{hit:?} of {direction:?} from {origin}, but meets at {first}\n{}",
            self.what()
        );
        let Some(hit) = hit else {
            return;
        };
        let met = from + way * until;
        let off = self.surface(met);
        assert!(
            off <= 4.0 * self.exact || until == 0.0 && is_inside.is_none(),
            "{hit:?} of {direction:?} from {origin} is {off} off\n{}",
            self.what()
        );
        assert!(
            hit.normal.is_normalized() && hit.normal.dot(*direction) <= 1e-5,
            "{hit:?}"
        );
    }

    /// Another shape, beside one triangle after the other.
    fn check_other(&self, other: &Shape, at: &Transform, direction: Dir3) {
        let Self { tests, .. } = self;
        let other = Placed::new(other, at);
        let mut workspace = Workspace::default();
        let mut apart = f64::INFINITY;
        let mut met = f64::INFINITY;
        const LENGTH: f32 = 12.0;
        let here = Transform::IDENTITY;
        for corners in &self.triangles {
            let [a, b, c] = corners.map(DVec3::as_vec3);
            let triangle = Shape::triangle(a, b, c).expect("it is finite");
            let triangle = Placed::new(&triangle, &here);
            let near = tests
                .closest_points(triangle, other, &mut workspace)
                .expect("all is known");
            apart = apart.min(near.distance.into());
            if let Some(hit) = tests.sweep(other, direction, LENGTH, triangle, &mut workspace) {
                met = met.min(hit.distance.into());
            }
        }
        let what = || format!("{:?}\n{}", other, self.what());
        let near = tests
            .closest_points(self.placed(), other, &mut workspace)
            .expect("all is known");
        let found = f64::from(near.distance);
        // What is inside touches no polygon.
        let point = near.points[1].as_dvec3();
        let is_inside = apart > self.exact
            && (found == 0.0 && !self.walls.is_empty())
            && self.is_inside(point) != Some(false);
        assert!(
            is_inside || (found - apart).abs() <= 2.0 * self.exact,
            "{found} apart, not {apart} {point}\n{}",
            what()
        );
        let contact = tests.contact(self.placed(), other, &mut workspace);
        assert_eq!(
            contact.is_some(),
            tests.intersects(self.placed(), other, &mut workspace)
        );
        assert!(contact.is_some() || apart > 0.0, "{}", what());
        assert!(
            contact.is_none() || is_inside || apart <= 2.0 * self.exact,
            "{}",
            what()
        );
        if let Some(contact) = contact {
            assert!(
                contact.normal.is_normalized() && contact.depth >= 0.0,
                "{contact:?}\n{}",
                what()
            );
        }
        let swept = tests.sweep(other, direction, LENGTH, self.placed(), &mut workspace);
        let until = swept.map_or(f64::INFINITY, |hit| f64::from(hit.distance));
        if is_inside || (apart > self.exact && !self.walls.is_empty() && found == 0.0) {
            return;
        }
        // A graze may be met or not, by a tolerance.
        let agree = (until - met).abs() <= 100.0 * self.exact;
        let both = until.is_infinite() && met.is_infinite();
        let graze = || {
            let nearest = until.min(met);
            let there = Transform {
                translation: at.translation + direction * nearest.min(f64::from(LENGTH)) as f32,
                ..*at
            };
            let there = Placed::new(other.shape, &there);
            let near = tests.closest_points(self.placed(), there, &mut Workspace::default());
            near.is_some_and(|near| f64::from(near.distance) <= 4.0 * self.exact)
        };
        assert!(
            agree || both || graze(),
            "met after {until}, not {met} {direction:?}\n{}",
            what()
        );
        let end = Transform {
            translation: at.translation + direction * LENGTH,
            ..*at
        };
        let moving = Moving::new(other.shape, at, &end);
        let resting = Moving::resting(self.placed());
        let timed = tests.time_of_impact(&moving, &resting, &mut workspace);
        assert!(
            timed.is_none_or(|met| (0.0..=1.0).contains(&met.time)),
            "{timed:?}"
        );
    }
}

/// Nothing panics, whatever the numbers.
fn ask_anything(shape: &Shape, at: &Transform, source: &mut Source) {
    let tests = NarrowPhase::default();
    let mut workspace = Workspace::default();
    let placed = Placed::new(shape, at);
    let point = source.vector();
    let direction = source.direction();
    let closest = tests.closest_point(placed, point, &mut workspace);
    assert!(closest.is_none_or(Vec3::is_finite));
    let hit = tests.cast_ray(placed, point, direction, source.size());
    assert!(hit.is_none_or(|hit| hit.distance >= 0.0));
    let other = data::description(source, 0)
        .build()
        .unwrap_or(Shape::sphere(0.5));
    let there = source.pose();
    let other = Placed::new(&other, &there);
    let meets = tests.intersects(placed, other, &mut workspace);
    assert_eq!(meets, tests.intersects(other, placed, &mut workspace));
    assert_eq!(
        meets,
        tests.contact(placed, other, &mut workspace).is_some()
    );
    let near = tests.closest_points(placed, other, &mut workspace);
    assert!(near.is_none_or(|near| near.distance >= 0.0 && near.offset.is_finite()));
}

/// A mesh of Bevy's, of any topology.
fn from_bevy(source: &mut Source) {
    let topologies = [
        PrimitiveTopology::TriangleList,
        PrimitiveTopology::TriangleStrip,
        PrimitiveTopology::LineList,
    ];
    let topology = topologies[[0, 0, 0, 1, 1, 2][source.below(6)]];
    let mut mesh = Mesh::new(topology, RenderAssetUsages::default());
    let positions: Vec<[f32; 3]> = source.list(40, |source| source.vector().to_array());
    let count = positions.len();
    match source.byte() {
        255 => {}
        254 => mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.0_f32; 4]; count]),
        _ => mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions.clone()),
    }
    let mut index = |source: &mut Source| match source.byte() {
        255 => source.bits(),
        byte => u32::from(byte).checked_rem(count as u32).unwrap_or(0),
    };
    match source.below(3) {
        0 => {}
        1 => {
            let indices = source.list(60, |source| index(source) as u16);
            mesh.insert_indices(Indices::U16(indices));
        }
        _ => {
            let indices = source.list(60, &mut index);
            mesh.insert_indices(Indices::U32(indices));
        }
    }
    match PolygonMesh::from_mesh(&mesh) {
        Ok(polygons) => {
            assert_ne!(topology, PrimitiveTopology::LineList);
            let extent = positions
                .iter()
                .flatten()
                .fold(0.0_f32, |most, at| most.max(at.abs()));
            for (number, corners) in polygons.polygons().enumerate() {
                assert_eq!(corners.len(), 3);
                let source = polygons.polygon_number(number);
                assert_eq!(polygons.polygon_index(source), Some(number));
                // Welded, not moved by more than that.
                for corner in corners {
                    let at = polygons.vertices()[*corner as usize];
                    let nearest = positions
                        .iter()
                        .map(|other| Vec3::from(*other).distance(at));
                    let nearest = nearest.fold(f32::INFINITY, f32::min);
                    assert!(nearest <= 1e-4 * extent, "{at} is {nearest} off");
                }
            }
            check_queries(polygons, source, true);
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Is it nearly flat?
fn is_wafer(mesh: &PolygonMesh) -> bool {
    let at = |vertex: u32| mesh.vertices()[vertex as usize].as_dvec3();
    let first = at(0);
    let volume: f64 = mesh
        .polygons()
        .flat_map(|corners| {
            corners[1..].windows(2).map(move |side| {
                let [a, b, c] = [corners[0], side[0], side[1]].map(|vertex| at(vertex) - first);
                a.cross(b).dot(c)
            })
        })
        .sum();
    let far = mesh
        .vertices()
        .iter()
        .map(|at| at.as_dvec3().distance(first));
    volume < 1e-3 * far.fold(0.0, f64::max).powi(3)
}

/// A hull holds all points, and reaches no further than these.
fn hull(source: &mut Source, is_wild: bool) {
    let points = source.list(40, Source::vector);
    match Shape::convex_hull(points.iter().copied()) {
        Ok(shape) if is_wild => ask_anything(&shape, &source.pose(), source),
        Ok(shape) => {
            let mut workspace = Workspace::default();
            let placed = Placed::new(&shape, &Transform::IDENTITY);
            let Shape::Convex(mesh) = &shape else {
                panic!("a hull is convex: {shape:?}");
            };
            check_convex(mesh);
            // Beside the border of a wafer, a point is near the planes of both of its sides.
            let least = if is_wafer(mesh) { f32::INFINITY } else { 1e-3 };
            for point in &points {
                let closest = NarrowPhase::default().closest_point(placed, *point, &mut workspace);
                let off = closest.expect("it is finite").distance(*point);
                assert!(off <= least, "{point} is {off} off the hull of {points:?}");
            }
            for vertex in mesh.vertices() {
                let is_one = points.iter().any(|point| point.distance(*vertex) <= 1e-3);
                assert!(is_one, "{vertex} is none of {points:?}");
            }
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            let are_finite = points.iter().all(|point| point.is_finite());
            let is_fault = match error {
                ShapeError::FewPoints(count) => count < 4,
                ShapeError::NonFiniteVertex { .. } => !are_finite,
                _ => true,
            };
            assert!(is_fault, "{error}: {points:?}");
        }
    }
}

fn convex(source: &mut Source) {
    let (vertices, polygons) = data::polygons(source);
    let Ok(mesh) = PolygonMesh::new(vertices, &polygons) else {
        return;
    };
    match ConvexMesh::new(mesh) {
        Ok(mesh) => {
            check_convex(&mesh);
            let shape = Shape::Convex(mesh.into());
            ask_anything(&shape, &source.pose(), source);
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// No vertex is outside of a polygon, but by what is allowed.
fn check_convex(mesh: &PolygonMesh) {
    assert!(mesh.is_closed() && mesh.has_inside());
    let used = mesh.polygons().flatten();
    let corners: Vec<DVec3> = used
        .map(|corner| mesh.vertices()[*corner as usize].as_dvec3())
        .collect();
    let size = reach(&corners);
    for (number, polygon) in mesh.polygons().enumerate() {
        let normal = mesh.normals()[number].as_dvec3();
        let own: Vec<DVec3> = at(mesh.vertices(), polygon).collect();
        let thin = area(&own).length() / reach(&own).powi(2);
        for corner in &corners {
            let beyond = (*corner - own[0]).dot(normal);
            let allowed = 3e-4 * size + 1e-5 * size * size / (thin * reach(&own));
            assert!(beyond <= allowed, "{corner} is {beyond} outside of {own:?}");
        }
    }
}
