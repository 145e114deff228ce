//! Histories of an app, by the machine and the oracle of `tests/app/model`.

#[path = "../../../tests/app/model/apply.rs"]
mod apply;
#[path = "../../../tests/app/model/machine.rs"]
mod machine;
#[path = "../../../tests/app/model/ops.rs"]
mod ops;
#[path = "../../../tests/app/model/oracle.rs"]
mod oracle;

use machine::Machine;
use ops::{Act, Op, Part, Place, Step};

use crate::source::Source;

const MOST_STEPS: usize = 60;

/// Has an app live through a history, and go to its end.
pub fn run(source: &mut Source) {
    let mut machine = Machine::new();
    for step in source.list(MOST_STEPS, step) {
        machine.step(&step);
    }
    machine.end();
}

fn step(source: &mut Source) -> Step {
    match source.below(20) {
        0..5 => Step::Tick,
        5 => Step::TickWithout(source.byte()),
        6 => Step::TickWith(source.below(9) as u8, op(source)),
        _ => Step::Do(op(source)),
    }
}

/// In quarters: within two units, and more often within one.
fn place(source: &mut Source) -> Place {
    [(); 3].map(|()| {
        let byte = source.byte();
        let reach = if byte & 1 == 0 { 3 } else { 8 };
        ((byte >> 1) % (2 * reach + 1)).cast_signed() - reach.cast_signed()
    })
}

fn part(source: &mut Source) -> Part {
    match source.below(21) {
        0 => Part::World(false),
        1 => Part::World(true),
        2 => Part::Events,
        3 => Part::Colliding,
        _ => source.choose(&Part::PLAIN),
    }
}

fn op(source: &mut Source) -> Op {
    let kind = |source: &mut Source| source.below(12) as u8;
    match source.below(40) {
        0..4 => Op::Spawn(kind(source), place(source)),
        4..8 => Op::SpawnMoving(kind(source), place(source), place(source)),
        8..10 => Op::Move(source.byte(), place(source)),
        10..13 => Op::Give(source.byte(), part(source)),
        13..15 => Op::Take(source.byte(), part(source)),
        15..17 => Op::Query(place(source), place(source)),
        17 => Op::Clone(source.byte()),
        18 => Op::Despawn(source.byte()),
        19 => Op::Teleport(source.byte(), source.below(8) as u8),
        20 => Op::Turn(source.byte(), place(source)),
        21 => Op::Scale(source.byte(), source.below(6) as u8),
        22 => Op::Resize(source.byte(), kind(source)),
        23 => Op::Swap(source.byte(), kind(source)),
        24 => Op::Renew(source.byte()),
        25 => Op::Reparent(source.byte(), source.byte()),
        26 => Op::Orphan(source.byte()),
        27 => Op::Disable(source.byte(), source.bit()),
        28 => Op::Enable(source.byte()),
        29 => Op::Ignore(source.byte(), source.byte()),
        30 => Op::Layers(source.byte(), source.below(8) as u8, source.below(8) as u8),
        31 => Op::Velocity(source.byte(), place(source)),
        32 => Op::Watch(source.byte(), source.bit(), source.choose(&Act::ALL)),
        33 => Op::Method(source.below(7) as u8),
        34 => Op::Kinds(source.below(8) as u8),
        35 => Op::Tolerance(source.bit()),
        36 => Op::Messages(source.bit()),
        37 => Op::EndWorld(source.bit()),
        38 if source.byte() & 7 == 7 => Op::Clear,
        _ => Op::Flush,
    }
}
