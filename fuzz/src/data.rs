//! Shapes as data, from bytes.

use bevy::prelude::*;
use bevy_octree::shape_data::{CoreDescription, PartDescription, ShapeDescription};

use crate::{common::SIDES, source::Source};

/// Returns a shape; a compound is in so few compounds that it may be in others.
pub fn description(source: &mut Source, depth: usize) -> ShapeDescription {
    match source.below(19) {
        0 => ShapeDescription::Cuboid {
            half_size: source.sizes(),
        },
        1 => ShapeDescription::Sphere {
            radius: source.size(),
        },
        2 => ShapeDescription::Capsule {
            radius: source.size(),
            length: source.size(),
        },
        3 => ShapeDescription::CapsuleBetween {
            a: source.vector(),
            b: source.vector(),
            radius: source.size(),
        },
        4 => ShapeDescription::Tetrahedron {
            vertices: std::array::from_fn(|_| source.vector()),
        },
        5 => ShapeDescription::HalfSpace {
            normal: source.vector(),
        },
        6 => mesh(source),
        7 => ShapeDescription::Rounded {
            core: core(source),
            radius: source.size(),
        },
        8 => ShapeDescription::Compound {
            parts: if depth < 4 {
                source.list(4, |source| PartDescription {
                    position: source.vector(),
                    rotation: source.turn(),
                    shape: description(source, depth + 1),
                })
            } else {
                vec![]
            },
        },
        9 => height_field(source),
        10 => ShapeDescription::Voxels {
            cell_size: source.size(),
            cells: source.list(9, cell),
        },
        _ => core(source).into(),
    }
}

fn core(source: &mut Source) -> CoreDescription {
    match source.below(8) {
        0 => CoreDescription::Segment {
            a: source.vector(),
            b: source.vector(),
        },
        1 => CoreDescription::Triangle {
            a: source.vector(),
            b: source.vector(),
            c: source.vector(),
        },
        2 => CoreDescription::Cuboid {
            half_size: source.sizes(),
        },
        3 => CoreDescription::Cylinder {
            radius: source.size(),
            height: source.size(),
        },
        4 => CoreDescription::Cone {
            radius: source.size(),
            height: source.size(),
        },
        5 => CoreDescription::ConicalFrustum {
            radius_top: source.size(),
            radius_bottom: source.size(),
            height: source.size(),
        },
        6 => {
            let (vertices, polygons) = polygons(source);
            CoreDescription::Convex { vertices, polygons }
        }
        _ => CoreDescription::ConvexHull {
            points: source.list(12, Source::vector),
        },
    }
}

/// The corners of a box, numbered by their bits, and its sides.
fn sides(min: Vec3, max: Vec3) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let corner = |bits: u8| {
        Vec3::select(
            BVec3::from([0, 1, 2].map(|axis| bits >> axis & 1 == 1)),
            max,
            min,
        )
    };
    ((0..8).map(corner).collect(), SIDES.map(Vec::from).into())
}

/// Vertices and polygons of a mesh: those of boxes, of triangles, or any.
pub fn polygons(source: &mut Source) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    match source.below(4) {
        0 => {
            let (mut vertices, mut polygons) = (vec![], vec![]);
            for (min, max) in source.list(4, |source| (source.vector(), source.sizes())) {
                let first = vertices.len() as u32;
                let (corners, sides) = sides(min, min + max);
                vertices.extend(corners);
                polygons.extend(sides.into_iter().map(|side| -> Vec<u32> {
                    side.into_iter().map(|corner| corner + first).collect()
                }));
            }
            // Some sides may be missing, or turned.
            for change in source.list(3, Source::byte) {
                let number = usize::from(change >> 1).checked_rem(polygons.len());
                match number {
                    Some(number) if change & 1 == 0 => _ = polygons.remove(number),
                    Some(number) => polygons[number].reverse(),
                    None => {}
                }
            }
            (vertices, polygons)
        }
        1 => {
            let vertices: Vec<Vec3> = source.list(48, Source::vector);
            let count = vertices.len() as u32 / 3;
            let polygons =
                (0..count).map(|number| vec![3 * number, 3 * number + 1, 3 * number + 2]);
            (vertices, polygons.collect())
        }
        2 => {
            let vertices = source.list(16, Source::vector);
            let most = vertices.len().max(1);
            let polygons = source.list(40, |source| {
                [(); 3].map(|()| source.below(most) as u32).into()
            });
            (vertices, polygons)
        }
        _ => {
            let vertices = source.list(12, Source::vector);
            let polygons = source.list(10, |source| {
                source.list(6, |source| u32::from(source.byte() & 15))
            });
            (vertices, polygons)
        }
    }
}

fn mesh(source: &mut Source) -> ShapeDescription {
    let (vertices, polygons) = polygons(source);
    ShapeDescription::Mesh {
        vertices,
        polygons,
        surface_only: source.bit(),
    }
}

fn cell(source: &mut Source) -> IVec3 {
    IVec3::from([(); 3].map(|()| match source.byte() {
        0..240 => i32::from(source.byte() & 3) - 1,
        240..248 => source.choose(&[i32::MIN, i32::MAX, 1 << 24, -(1 << 20)]),
        _ => source.bits().cast_signed() >> (source.byte() & 31),
    }))
}

fn height_field(source: &mut Source) -> ShapeDescription {
    let number = |source: &mut Source| match source.byte() {
        0..250 => 2 + source.below(4) as u32,
        _ => source.choose(&[0, 1, u32::MAX, 1 << 31]),
    };
    let (rows, columns) = (number(source), number(source));
    let fits = u64::from(rows) * u64::from(columns) < 40 && source.byte() != 255;
    let count = if fits { rows * columns } else { 4 };
    ShapeDescription::HeightField {
        rows,
        columns,
        heights: (0..count).map(|_| source.number()).collect(),
        cell_size: source.sizes().truncate(),
        holes: source.list(3, |source| [0, 1].map(|_| source.below(5) as u32)),
    }
}
