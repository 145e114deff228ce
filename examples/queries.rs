//! Asks about a small world in every way there is: what a ray meets, what a moving ball meets, what
//! is in a blast, what is near what. Without a window: it prints what it finds.
//!
//! `cargo run --release --example queries`

use bevy::{ecs::entity::EntityHashSet, math::bounding::Aabb3d, prelude::*};
use bevy_octree::prelude::*;

fn main() {
    App::new()
        .add_plugins((MinimalPlugins, OctreePlugins::default()))
        // What was spawned is in the index from the next tick on; a flush puts it there at once.
        .add_systems(
            Startup,
            (
                spawn,
                update_spatial_index,
                look,
                sweep,
                overlap,
                near,
                many,
            )
                .chain(),
        )
        .update();
}

fn spawn(mut commands: Commands) {
    let eighth = Quat::from_rotation_y(std::f32::consts::FRAC_PI_4);
    let (cube, ball) = (
        CollisionShape::cuboid(2.0, 2.0, 2.0),
        CollisionShape::sphere(1.0),
    );
    commands.spawn((
        Name::new("gem"),
        cube.clone(),
        Transform::from_xyz(5.0, 0.0, 0.0).with_rotation(eighth),
    ));
    commands.spawn((Name::new("ball"), ball, Transform::from_xyz(10.0, 0.0, 0.0)));
    commands.spawn((
        Name::new("wall"),
        cube,
        Transform::from_xyz(20.0, 0.0, 0.0).with_scale(Vec3::new(0.1, 5.0, 5.0)),
    ));
}

/// Rays: the first hit, all hits, and what is hit if some are not seen.
fn look(spatial: SpatialQuery, names: Query<&Name>) -> Result {
    let (ray, all) = (Ray3d::new(Vec3::ZERO, Dir3::X), SpatialQueryFilter::DEFAULT);
    let Some(first) = spatial.cast_ray(ray, 100.0, &all) else {
        return Ok(());
    };
    println!(
        "a ray along x meets the {} at {:.3}",
        names.get(first.entity)?,
        first.distance
    );

    let mut hits = Vec::new();
    spatial.ray_hits(ray, 100.0, &all, &mut hits);
    for hit in &hits {
        println!(
            "  {:6.3}  {}, normal {:.2}",
            hit.distance,
            names.get(hit.entity)?,
            hit.normal
        );
    }

    let glass: EntityHashSet = hits.iter().map(|hit| hit.entity).take(2).collect();
    let behind = spatial.cast_ray(ray, 100.0, &all.excluding(&glass));
    println!(
        "  behind the first two is the {}",
        behind.map_or(Ok("sky"), |hit| names.get(hit.entity).map(|n| &**n))?
    );
    let is_ball = |entity| names.get(entity).is_ok_and(|name| name.as_str() == "ball");
    let ball = spatial.cast_ray(ray, 100.0, &all.only(&is_ball));
    let to_the_gem = spatial.ray_meets_any(ray, 3.0, &all.without_sensors());
    println!("  the first three units are free: {}", !to_the_gem);
    println!(
        "  the ball alone is at {:.3}",
        ball.map_or(f32::INFINITY, |hit| hit.distance)
    );
    Ok(())
}

/// Moving shapes: how far can they go?
fn sweep(spatial: SpatialQuery, names: Query<&Name>) -> Result {
    let all = SpatialQueryFilter::DEFAULT;
    if let Some(hit) = spatial.cast_sphere(Vec3::Y, 0.5, Dir3::X, 100.0, &all) {
        println!(
            "a ball that rolls along x touches the {} after {:.3}",
            names.get(hit.entity)?,
            hit.distance
        );
    }
    let crate_ = Aabb3d::new(Vec3::new(0.0, 3.0, 0.0), Vec3::splat(0.5));
    if let Some(hit) = spatial.cast_box(&crate_, Dir3::X, 100.0, &all) {
        println!(
            "a box that slides higher up touches the {} after {:.3}",
            names.get(hit.entity)?,
            hit.distance
        );
    }
    Ok(())
}

/// Parts of space: who is in them?
fn overlap(spatial: SpatialQuery, names: Query<&Name>) {
    let mut hurt = Vec::new();
    spatial.sphere_intersections(
        Vec3::new(7.5, 0.0, 0.0),
        2.0,
        &SpatialQueryFilter::DEFAULT,
        &mut hurt,
    );
    let hurt: Vec<_> = hurt
        .iter()
        .filter_map(|entity| names.get(*entity).ok())
        .map(Name::as_str)
        .collect();
    println!(
        "a blast at 7.5 with a radius of 2 hurts: {}",
        hurt.join(", ")
    );
}

/// Neighbours, by the distance of their surfaces.
fn near(spatial: SpatialQuery, names: Query<&Name>) -> Result {
    let mut hits = Vec::new();
    spatial.k_nearest(
        Vec3::X * 8.0,
        2,
        f32::INFINITY,
        &SpatialQueryFilter::DEFAULT,
        &mut hits,
    );
    println!("the two nearest to 8:");
    for hit in &hits {
        println!(
            "  {:6.3}  {}, closest at {:.2}",
            hit.distance,
            names.get(hit.entity)?,
            hit.point
        );
    }

    spatial.within(Vec3::X * 8.0, 3.0, &SpatialQueryFilter::DEFAULT, &mut hits);
    println!("no farther from 8 than 3: {}", hits.len());
    // All that are near each other, at once.
    let mut pairs = Vec::new();
    spatial.pairs_among(5.0, &SpatialQueryFilter::DEFAULT, &mut pairs);
    for pair in pairs {
        println!(
            "the {} and the {} are {:.3} apart",
            names.get(pair.a)?,
            names.get(pair.b)?,
            pair.distance
        );
    }
    Ok(())
}

/// Many rays at once, on all threads with the feature `multi_threaded`; each may have its own length.
fn many(spatial: SpatialQuery) {
    let across = |i: u16| Ray3d::new(Vec3::new(0.0, f32::from(i) * 0.01 - 10.0, 0.0), Dir3::X);
    let rays: Vec<_> = (0..2000).map(across).collect();
    let mut hits = Vec::new();
    spatial.cast_rays(&rays, 100.0, &SpatialQueryFilter::DEFAULT, &mut hits);
    println!(
        "of {} parallel rays, {} meet something",
        rays.len(),
        hits.iter().flatten().count()
    );
}
