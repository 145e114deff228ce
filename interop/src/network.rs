//! A network in memory that treats packets as badly as a real one.

use std::{
    fmt,
    ops::RangeInclusive,
    sync::{Arc, Mutex, PoisonError},
};

use bevy_ggrs::ggrs::{Message, NonBlockingSocket};
use fastrand::Rng;

/// How badly packets are treated.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// The share of packets that are lost.
    pub loss: f32,
    /// The share of packets that arrive twice.
    pub doubled: f32,
    /// How many steps of the network a packet takes: each another number, so that they overtake each
    /// other.
    pub delay: RangeInclusive<u64>,
}

/// What became of all packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCounts {
    /// How many were sent.
    pub sent: u64,
    /// How many of them were lost.
    pub lost: u64,
    /// How many arrived, those that arrived twice counted twice.
    pub arrived: u64,
}

/// A network in memory. Its clones are the same network.
#[derive(Clone, Debug)]
pub struct LossyNetwork(Arc<Mutex<Wires>>);

#[derive(Debug)]
struct Wires {
    conditions: Conditions,
    chance: Rng,
    /// How many steps there were.
    now: u64,
    on_the_way: Vec<Packet>,
    counts: PacketCounts,
}

struct Packet {
    due: u64,
    from: usize,
    to: usize,
    message: Message,
}

impl fmt::Debug for Packet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { due, from, to, .. } = self;
        write!(f, "from {from} to {to} at {due}")
    }
}

impl LossyNetwork {
    /// Makes a network. The same seed gives the same luck to the same packets.
    #[must_use]
    pub fn new(conditions: Conditions, seed: u64) -> Self {
        Self(Arc::new(Mutex::new(Wires {
            conditions,
            chance: Rng::with_seed(seed),
            now: 0,
            on_the_way: Vec::new(),
            counts: PacketCounts::default(),
        })))
    }

    /// Makes the socket at an address.
    #[must_use]
    pub fn socket(&self, address: usize) -> LossySocket {
        LossySocket {
            address,
            network: self.clone(),
        }
    }

    /// Lets a step of time pass.
    pub fn step(&self) {
        self.with(|wires| wires.now += 1);
    }

    /// Returns what became of all packets so far.
    #[must_use]
    pub fn counts(&self) -> PacketCounts {
        self.with(|wires| wires.counts)
    }

    /// What is behind the lock is whole, whoever panicked.
    fn with<T>(&self, act: impl FnOnce(&mut Wires) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Wires {
    fn send(&mut self, from: usize, to: usize, message: &Message) {
        self.counts.sent += 1;
        if self.chance.f32() < self.conditions.loss {
            self.counts.lost += 1;
            return;
        }
        let copies = 1 + usize::from(self.chance.f32() < self.conditions.doubled);
        for _ in 0..copies {
            let due = self.now + self.chance.u64(self.conditions.delay.clone());
            let message = message.clone();
            self.on_the_way.push(Packet {
                due,
                from,
                to,
                message,
            });
        }
    }

    fn receive(&mut self, address: usize) -> Vec<(usize, Message)> {
        let now = self.now;
        let arrived = self
            .on_the_way
            .extract_if(.., |packet| packet.to == address && packet.due <= now);
        let mut arrived: Vec<_> = arrived.collect();
        // Those of the same step stay in the order in which they were sent.
        arrived.sort_by_key(|packet| packet.due);
        self.counts.arrived += arrived.len() as u64;
        arrived
            .into_iter()
            .map(|packet| (packet.from, packet.message))
            .collect()
    }
}

/// A socket of a [`LossyNetwork`].
#[derive(Debug)]
pub struct LossySocket {
    address: usize,
    network: LossyNetwork,
}

impl NonBlockingSocket<usize> for LossySocket {
    fn send_to(&mut self, message: &Message, address: &usize) {
        self.network
            .with(|wires| wires.send(self.address, *address, message));
    }

    fn receive_all_messages(&mut self) -> Vec<(usize, Message)> {
        self.network.with(|wires| wires.receive(self.address))
    }
}
