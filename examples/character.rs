//! A character walks a course by a script: stairs, a ramp, a maze of crates, a lift, a platform that turns, a gap to jump, and
//! hills of 100 000 triangles.
//!
//! `cargo run --release --example character`. Fails if it does not get there, falls, or is in anything on its way.

use std::process::ExitCode;

use arguments::Arguments;
use bevy::prelude::*;
use bevy_octree::prelude::*;
use course::{GRAVITY, Script, TICK};
use outcome::{Outcome, exit};

#[path = "common/arguments.rs"]
mod arguments;
#[path = "common/course.rs"]
mod course;
#[path = "common/outcome.rs"]
mod outcome;

const HELP: &str = "
A character walks a course by a script, in a headless app: where it gets to, and when.

Usage: character [OPTIONS]

Options:
  --trace <TICKS>  Print where it is every so many ticks
  -h, --help       Print help
";

/// How deep it may be in anything, in length units: a thousandth of its width.
const DEEPEST: f32 = 2e-3 * course::RADIUS;
/// What is left of the speed in the air, when the script wants another one, after a second.
const AIR_CONTROL: f32 = 0.02;

fn main() -> ExitCode {
    exit(run(Arguments::given(HELP)))
}

/// The seconds since the course began.
#[derive(Resource, Default)]
struct Seconds(f32);

/// Who walks by the script.
#[derive(Component, Default)]
struct Scripted(Script);

#[derive(Component)]
struct Lift;

#[derive(Component)]
struct Disk;

/// How deep the walker was in anything, at most, and how low.
#[derive(Resource)]
struct Worst {
    depth: f32,
    height: f32,
}

fn run(mut arguments: Arguments) -> Outcome {
    let trace: Option<u32> = arguments.option("--trace")?;
    let [] = arguments.rest([])?;

    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(TICK),
        })
        .init_resource::<Seconds>()
        .insert_resource(Worst {
            depth: 0.0,
            height: f32::INFINITY,
        })
        .add_systems(
            Update,
            (
                (move_platforms, steer)
                    .chain()
                    .before(CollisionSystems::Motion),
                judge.in_set(CollisionSystems::Last),
            ),
        );
    build(app.world_mut())?;
    let body =
        CollisionShape::capsule(course::RADIUS, 2.0 * (course::HALF_HEIGHT - course::RADIUS));
    let at = Transform::from_translation(course::START);
    let walker = (KinematicCharacter::default(), Scripted::default(), body, at);
    let walker = app.world_mut().spawn(walker).id();

    let mut told = 0;
    for tick in 0..course::PATIENCE {
        app.update();
        let Scripted(script) = app.world().get(walker).ok_or("the walker is gone")?;
        for (name, tick, at) in &script.reached[told..] {
            let [x, y, z] = at.to_array();
            println!("{tick:5}  {name:22} {x:7.2} {y:6.2} {z:6.2}");
        }
        told = script.reached.len();
        if trace.is_some_and(|every| tick % every.max(1) == 0) {
            let (at, walking) = (
                app.world()
                    .get::<Transform>(walker)
                    .map(|at| at.translation),
                app.world().get::<KinematicCharacter>(walker),
            );
            let ground = walking.and_then(|walking| walking.ground.map(|ground| ground.normal));
            println!("{tick:5}  to {}: {at:?}, on {ground:?}", script.aim());
        }
        if script.is_done() {
            let Worst { depth, height } = app.world().resource();
            println!("\nnever deeper in anything than {depth}, never lower than {height:.2}");
            return if *depth <= DEEPEST && *height > -0.05 {
                Ok(())
            } else {
                Err("it was in something, or fell through".into())
            };
        }
    }
    let Scripted(script) = app.world().get(walker).ok_or("the walker is gone")?;
    Err(format!(
        "it has got through {} of {} parts: it never reached `{}`",
        told,
        Script::parts(),
        script.aim()
    )
    .into())
}

fn build(world: &mut World) -> Outcome {
    for (size, at) in course::blocks() {
        let shape = CollisionShape::from_half_size(size / 2.0);
        world.spawn((shape, at, StaticShape));
    }
    let (vertices, triangles) = course::hills();
    println!("hills of {} triangles", triangles.len());
    world.spawn((CollisionShape::mesh(vertices, triangles)?, StaticShape));
    let (size, at) = course::lift(0.0);
    world.spawn((Lift, CollisionShape::from_half_size(size / 2.0), at));
    let (height, at) = course::disk(0.0);
    world.spawn((
        Disk,
        CollisionShape::cylinder(course::DISK_RADIUS, height),
        at,
    ));
    Ok(())
}

/// Platforms are moved by whatever moves them: those who stand on them are taken along.
fn move_platforms(
    mut lift: Single<&mut Transform, (With<Lift>, Without<Disk>)>,
    mut disk: Single<&mut Transform, With<Disk>>,
    mut seconds: ResMut<Seconds>,
) {
    seconds.0 += TICK;
    **lift = course::lift(seconds.0).1;
    **disk = course::disk(seconds.0).1;
}

/// What a game does with its keys: speed on the ground, gravity, a jump, some control in the air.
fn steer(
    walker: Single<(&Transform, &mut KinematicCharacter, &mut Scripted)>,
    seconds: Res<Seconds>,
) {
    let (at, mut walking, mut script) = walker.into_inner();
    let (way, jump) = script
        .0
        .steer(at.translation, walking.is_on_ground(), seconds.0);
    let fall = walking.velocity.y - GRAVITY * TICK;
    walking.velocity = if walking.is_on_ground() {
        way + Vec3::Y * jump.unwrap_or(fall)
    } else {
        let kept = AIR_CONTROL.powf(TICK);
        (walking.velocity * kept + way * (1.0 - kept)).with_y(fall)
    };
}

fn judge(
    walker: Single<(Entity, &Transform, &CollisionShape), With<Scripted>>,
    spatial: SpatialQuery,
    mut worst: ResMut<Worst>,
) {
    let (entity, at, shape) = *walker;
    let solid = spatial.filter_of(entity);
    spatial.for_each_shape_contact(shape, at, &solid, |contact| {
        worst.depth = worst.depth.max(contact.depth);
    });
    let feet = at.translation.y - course::HALF_HEIGHT;
    let over = if at.translation.x > 43.0 {
        feet - course::height(at.translation.x, at.translation.z)
    } else {
        feet
    };
    worst.height = worst.height.min(over);
}
