//! Everything that can be drawn for debugging, in a picture: the leaves of the octree, shapes of
//! several kinds, the boxes of moving and resting entities, contacts and their normals, a ray and what
//! it hits, a ball on its way. Without a window: the lines are those that Bevy's gizmos would show.
//!
//! `cargo run --release --features debug_draw --example debug_draw`

use std::{fs, path::PathBuf, process::ExitCode};

use arguments::Arguments;
use bevy::{
    gizmos::GizmoPlugin,
    math::{Vec3A, bounding::Aabb3d},
    mesh::MeshPlugin,
    prelude::*,
};
use bevy_octree::{
    broad_phase::ObjectOctreeSettings,
    collision_index::CollisionIndex,
    counters::TickCounters,
    debug_draw::LeafColors,
    motion::{MotionSettings, Step},
    prelude::*,
};
use gizmo_lines::{Path, paths};
use outcome::{Outcome, exit};
use svg::Svg;

#[path = "common/arguments.rs"]
mod arguments;
#[path = "common/gizmo_lines.rs"]
mod gizmo_lines;
#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/svg.rs"]
mod svg;

const HELP: &str = "
A swarm of cubes, balls, capsules, cones and others above a field of resting boxes, after some ticks; drawn to debug_draw.svg.

Usage: debug_draw [OPTIONS]

Options:
  --out <FOLDER>     The folder to write to [default: target/debug_draw]
  --objects <COUNT>  How many entities move [default: 40]
  --max-objects <N>  How many objects a leaf may list before it splits [default: 5]
  --leaves <COLORS>  What the colours of leaves tell: `generation` or `fill` [default: generation]
  --steps <STEPS>    How many ticks to run [default: 30]
  -h, --help         Print help
";

fn main() -> ExitCode {
    exit(run(Arguments::given(HELP)))
}

fn run(mut arguments: Arguments) -> Outcome {
    let out = arguments
        .option("--out")?
        .unwrap_or_else(|| PathBuf::from("target/debug_draw"));
    let objects = arguments.option("--objects")?.unwrap_or(40);
    let max_objects = arguments.option("--max-objects")?.unwrap_or(5);
    let leaf_colors = match arguments.option::<String>("--leaves")?.as_deref() {
        None | Some("generation") => LeafColors::Generation,
        Some("fill") => LeafColors::Fill,
        Some(name) => {
            return Err(
                format!("unknown colours `{name}`: expected `generation` or `fill`").into(),
            );
        }
    };
    let steps = arguments.option("--steps")?.unwrap_or(30);
    let [] = arguments.rest([])?;

    let settings = ObjectOctreeSettings::with_max_objects(max_objects);
    settings.check()?;
    let mut app = App::new();
    // What `DefaultPlugins` have; to see gizmos in a window, the app needs no more than these, and
    // a camera.
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        MeshPlugin,
        GizmoPlugin,
    ))
    .add_plugins((OctreePlugins::new(Update), CollisionDebugPlugin))
    .insert_resource(BroadPhaseSettings {
        method: BroadPhaseMethod::ObjectOctree(settings),
        ..default()
    })
    .insert_resource(MotionSettings {
        step: Step::Seconds(1.0 / 64.0),
    })
    // Contacts are drawn with their normals where these are known: here, everywhere.
    .insert_resource(CollisionEventSettings {
        geometry: EventScope::All,
        ..default()
    })
    .insert_gizmo_config(
        CollisionGizmos {
            normal_length: 1.0,
            ..default()
        },
        GizmoConfig::default(),
    )
    .add_systems(Update, ask.after(CollisionSystems::Last));
    spawn(app.world_mut(), objects);
    for _ in 0..steps {
        app.update();
    }

    // What is drawn can be changed at any time: first all but leaves, then leaves alone, to be laid
    // behind the rest.
    let objects = paths(&app);
    let nothing = CollisionGizmos {
        moving: None,
        resting: None,
        shapes: None,
        contacts: None,
        rays: None,
        sweeps: None,
        ..default()
    };
    let leaves = CollisionGizmos {
        leaves: Some(leaf_colors),
        ..nothing
    };
    *app.world_mut()
        .resource_mut::<GizmoConfigStore>()
        .config_mut::<CollisionGizmos>()
        .1 = leaves;
    app.world_mut().run_schedule(Last);
    let leaves = paths(&app);

    let stats = app.world().resource::<CollisionIndex>().index().stats();
    let TickCounters {
        objects: entities,
        contacts,
        ..
    } = app.world().resource::<CollisionCounters>().tick;
    let title = format!(
        "{entities} entities, {contacts} contacts, {} leaves",
        stats.leaves
    );
    fs::create_dir_all(&out)
        .map_err(|error| format!("cannot make the folder {}: {error}", out.display()))?;
    let file = out.join("debug_draw.svg");
    picture(&leaves, &objects, &title).save(&file)?;
    println!("{}", file.display());
    println!(
        "objects={entities} contacts={contacts} leaves={} lines={}",
        stats.leaves,
        leaves.len() + objects.len()
    );
    if leaves.is_empty() || objects.is_empty() {
        Err("nothing was drawn".into())
    } else {
        Ok(())
    }
}

/// A field of resting boxes, and a swarm above one corner of it.
fn spawn(world: &mut World, objects: u16) {
    let mut random = fastrand::Rng::with_seed(7);
    let mut between = |low: f32, high: f32| low + (high - low) * random.f32();
    for x in -3..3_i8 {
        for z in -3..3_i8 {
            let half = Vec3::new(0.6, between(0.2, 1.2), 0.6);
            let place = Vec3::new(f32::from(x) * 3.0 + 1.5, half.y, f32::from(z) * 3.0 + 1.5);
            let mut column = world.spawn((
                CollisionShape::from_half_size(half),
                Transform::from_translation(place),
            ));
            if (x, z) == (2, -3) {
                column.insert(DebugDraw::Color(OWN));
            }
        }
    }
    for number in 0..objects {
        let place = Vec3::new(between(-8.0, 0.0), between(3.0, 8.0), between(-1.0, 7.0));
        let velocity = Velocity(Vec3::new(
            between(-2.0, 2.0),
            between(-2.0, 1.0),
            between(-2.0, 2.0),
        ));
        let shape = match number % 6 {
            0 => Shape::sphere(0.45),
            1 => Shape::cuboid(0.8, 0.8, 0.8),
            2 => Shape::capsule(0.3, 0.6),
            3 => Shape::cone(0.5, 1.0),
            4 => Shape::cylinder(0.4, 0.8),
            _ => Shape::rounded(&Shape::cuboid(0.5, 0.5, 0.5), 0.2).unwrap_or(Shape::sphere(0.45)),
        };
        world.spawn((
            CollisionShape(shape),
            velocity,
            Bounce::Reverse,
            Transform::from_translation(place),
        ));
    }
}

/// Casts a ray and a box across the field, and draws how far they come.
fn ask(spatial: SpatialQuery, mut gizmos: Gizmos<CollisionGizmos>) {
    let ray = Ray3d::new(
        Vec3::new(9.0, 6.0, -4.0),
        Dir3::new(Vec3::new(-0.75, -0.4, 0.4)).unwrap_or(Dir3::NEG_X),
    );
    gizmos.ray_hit(
        ray,
        spatial.cast_ray(ray, 100.0, &SpatialQueryFilter::DEFAULT),
    );

    let start = Aabb3d::new(Vec3::new(10.5, 1.8, 4.5), Vec3::splat(0.5));
    if let Some(hit) = spatial.cast_box(&start, Dir3::NEG_X, 100.0, &SpatialQueryFilter::DEFAULT) {
        let way = Vec3A::NEG_X * hit.distance;
        gizmos.swept_box(
            &start,
            &Aabb3d {
                min: start.min + way,
                max: start.max + way,
            },
        );
    }
}

/// The colour of one entity alone.
const OWN: Color = Color::WHITE;

const SIZE: [u32; 2] = [1200, 760];
const BACKGROUND: &str = "#0f121c";

/// The lines as a camera sees them: leaves behind, all else in front of them.
fn picture(leaves: &[Path], objects: &[Path], title: &str) -> Svg {
    let mut svg = Svg::new(SIZE, BACKGROUND);
    let [width, height] = SIZE.map(|side| side as f32);
    let eye = Mat4::perspective_rh(0.62, width / height, 0.1, 100.0)
        * Mat4::look_at_rh(
            Vec3::new(15.0, 14.0, 28.0),
            Vec3::new(0.5, 2.0, 0.0),
            Vec3::Y,
        );
    let pixel = |point: &Vec3| {
        let seen = eye.project_point3(*point);
        [(0.5 + 0.5 * seen.x) * width, (0.5 - 0.5 * seen.y) * height]
    };
    for (paths, style) in [
        (leaves, r#"opacity="0.6""#),
        (objects, r#"stroke-width="2""#),
    ] {
        for Path { points, color } in paths {
            let color = Srgba::from(*color).with_alpha(1.0).to_hex();
            svg.line(
                points.iter().map(pixel),
                &format!(r#"stroke="{color}" {style}"#),
            );
        }
    }
    svg.text(
        [24.0, 36.0],
        title,
        r##"font-size="19" font-weight="bold" fill="#e6e8f0""##,
    );
    let shades = CollisionGizmos::default();
    let legend = [
        ("leaves", Some(shades.leaf_colors[1])),
        ("moving", shades.moving),
        ("resting", shades.resting),
        ("shapes", shades.shapes),
        ("of its own", Some(OWN)),
        ("contacts", shades.contacts),
        ("ray and hit", shades.rays),
        ("swept box", shades.sweeps),
    ];
    for ((name, color), row) in legend.into_iter().zip(0_u8..) {
        let color = color
            .unwrap_or_default()
            .to_srgba()
            .with_alpha(1.0)
            .to_hex();
        svg.text(
            [24.0, 70.0 + 24.0 * f32::from(row)],
            name,
            &format!(r#"font-size="15" fill="{color}""#),
        );
    }
    svg
}
