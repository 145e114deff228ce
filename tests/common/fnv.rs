//! A hash that is the same everywhere: that of Fowler, Noll and Vo, FNV-1a, of 64 bits.

/// Grows with each number that is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv(pub u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl Fnv {
    pub fn add(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
        }
    }

    pub fn add_all(&mut self, words: impl IntoIterator<Item = u64>) {
        words.into_iter().for_each(|word| self.add(word));
    }
}

#[test]
fn the_hash_is_as_published() {
    // That of the text "foobar", which is shorter than a word; so byte by byte.
    let mut hash = Fnv::default();
    for byte in *b"foobar" {
        hash.0 = (hash.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
    }
    assert_eq!(hash.0, 0x8594_4171_F739_67E8);
    let (mut word, mut bytes) = (Fnv::default(), Fnv::default());
    word.add(u64::from_le_bytes(*b"determin"));
    for byte in *b"determin" {
        bytes.0 = (bytes.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
    }
    assert_eq!(word, bytes);
}
