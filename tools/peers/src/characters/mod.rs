//! `peers characters`: characters that walk, by this crate, Rapier and Avian.
//!
//! All build their worlds of one description of boxes and triangles, and move the same capsules in them, which want to go
//! the same ways: 5 units per second, gravity, 60 ticks per second. Nobody meets another character. Engines take turns, in
//! blocks of ticks, and what each character costs in a tick is the median of all ticks.
//!
//! Timed is what moves the characters, and nothing else. Nothing in the scenes moves, so that no engine has a structure to
//! update meanwhile; each has built its own before, and run for some ticks to settle it.
//!
//! | engine | what it is | settings, and why |
//! |---|---|---|
//! | `rapier` | `KinematicCharacterController` | a skin of 0.01, steps up to 0.3 with 0.1 of room on them, held on the ground within 0.3, slopes up to 45° |
//! | `avian` | `MoveAndSlide`, with gravity, ground and slopes as its example of a kinematic character has them | the same skin and slopes; neither it nor the example has steps, nor holds anyone on the ground |
//!
//! | column | what it is |
//! |---|---|
//! | µs | per character and tick |
//! | deepest | in anything, over the whole run, as a share of the radius; 1 if the axis is in something |
//! | in | of all characters in all ticks, those that are deeper in something than 0.001 units, in percent |
//! | fallen | characters that are below all ground at the end |
//! | way | the way covered in the plane, as a share of what was wanted |
//! | grounded | of all characters in all ticks, those that have ground below them, by what the engine says, in percent |
//! | kept | the way along a wall, as a share of what is along it of the way that was wanted: of all angles the mean, and the least |
//! | climbed | steps, of 10 |
//! | airborne | ticks of a way down in which a character touches nothing within 0.05 units |
//! | turns | ticks in which a character goes back, by more than 0.0001 units, after it had as much time as it takes to come to rest |
//! | drift | the length of its way after that |
//!
//! Depths and gaps are those of [`judge`], which none of the engines has a part in.

mod engines;
mod judge;
mod report;
mod scenes;
mod tally;

use std::{fs, path::PathBuf, time::Instant};

use bevy::math::Vec3;
use clap::Args;

use crate::{outcome::Outcome, progress::Progress};
use engines::{Body, Contestant, Engine};
use judge::Judge;
use report::{Report, Row};
use scenes::{Course, Extent, Place, Scene};

/// Of the capsules: their radius.
const RADIUS: f32 = 0.4;
/// From the middle to either end of the axis.
const HALF_LENGTH: f32 = 0.5;
/// From the middle to the feet.
const HALF_HEIGHT: f32 = HALF_LENGTH + RADIUS;
/// The distance that is kept to all things.
const SKIN: f32 = 0.01;
/// How high a step may be.
const STEP: f32 = 0.3;
/// How much room there is to be on a step.
const STEP_WIDTH: f32 = 0.1;
/// Within that distance, characters are held on the ground.
const SNAP: f32 = 0.3;
/// The steepest ground that is climbed, in degrees.
const SLOPE: f32 = 45.0;
/// How fast characters want to go, in length units per second.
const SPEED: f32 = 5.0;
const GRAVITY: f32 = 9.81;
/// How long a tick is, in seconds.
const TICK: f32 = 1.0 / 60.0;
/// Ticks of one engine before the next one's turn.
const BLOCK: usize = 20;

/// Compares characters that walk.
#[derive(Args)]
pub struct Arguments {
    /// Scenes, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<Scene>,
    /// Engines, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    engines: Vec<Contestant>,
    /// Characters in `terrain` and `boxes`.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    characters: u32,
    /// How long they walk; those that come to rest have their own time.
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u16).range(1..))]
    ticks: u16,
    /// A first impression: few characters and ticks.
    #[arg(long)]
    quick: bool,
    /// Seed of the scenes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes all figures to this file.
    #[arg(long)]
    json: Option<PathBuf>,
}

impl Arguments {
    fn extent(&self) -> Extent {
        let (characters, ticks) = (self.characters as usize, usize::from(self.ticks));
        Extent {
            characters: if self.quick {
                characters.min(20)
            } else {
                characters
            },
            ticks: if self.quick { ticks.min(120) } else { ticks },
            seed: self.seed,
        }
    }
}

/// An engine with the characters of a scene.
struct Runner {
    contestant: Contestant,
    engine: Box<dyn Engine>,
    bodies: Vec<Body>,
    courses: Vec<Course>,
    wishes: Vec<Vec3>,
    run: Run,
}

/// What became of the characters.
#[derive(Default)]
struct Run {
    /// Of each tick, in seconds.
    times: Vec<f64>,
    /// After each tick, of all characters.
    bodies: Vec<Vec<Body>>,
}

impl Runner {
    fn new(contestant: Contestant, place: &Place) -> Self {
        let walkers = place.walkers.iter().map(|(_, walker)| walker);
        Self {
            contestant,
            engine: contestant.engine(&place.solids),
            bodies: walkers
                .clone()
                .map(|walker| Body::new(walker.start))
                .collect(),
            courses: walkers.map(|walker| walker.course.clone()).collect(),
            wishes: vec![],
            run: Run::default(),
        }
    }

    fn tick(&mut self) {
        self.wishes.clear();
        let courses = self.courses.iter_mut().zip(&self.bodies);
        self.wishes
            .extend(courses.map(|(course, body)| course.wish(body.position)));
        let start = Instant::now();
        self.engine.tick(&mut self.bodies, &self.wishes);
        self.run.times.push(start.elapsed().as_secs_f64());
        self.run.bodies.push(self.bodies.clone());
    }
}

/// Runs the comparison.
pub fn run(arguments: &Arguments) -> Outcome {
    let scenes = match arguments.scenes.as_slice() {
        [] => Scene::ALL.to_vec(),
        given => given.to_vec(),
    };
    let contestants = match arguments.engines.as_slice() {
        [] => Contestant::ALL.to_vec(),
        given => given.to_vec(),
    };
    let mut report = Report::default();
    let mut progress = Progress::new(scenes.len() as u64);
    for scene in scenes {
        progress.begin(scene);
        let place = scene.place(arguments.extent());
        let judge = Judge::new(&place.solids);
        let runners = walk(&place, &contestants);
        report.rows.extend(runners.iter().map(
            |Runner {
                 contestant, run, ..
             }| Row {
                scene,
                engine: *contestant,
                characters: place.walkers.len(),
                ticks: place.ticks,
                figures: tally::tally(&place, run, &judge),
            },
        ));
    }
    drop(progress);
    print!("{report}");
    if let Some(file) = &arguments.json {
        let json = serde_json::to_string_pretty(&report)?;
        fs::write(file, json)
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// Lets the characters of a scene walk to the end, by all engines in turns.
fn walk(place: &Place, contestants: &[Contestant]) -> Vec<Runner> {
    let mut runners: Vec<_> = contestants
        .iter()
        .map(|contestant| Runner::new(*contestant, place))
        .collect();
    let mut left = place.ticks;
    while left > 0 {
        let block = left.min(BLOCK);
        for runner in &mut runners {
            (0..block).for_each(|_| runner.tick());
        }
        left -= block;
    }
    runners
}
