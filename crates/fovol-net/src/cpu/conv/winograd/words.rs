/// Channels are padded to a multiple of this many words: the longest vectors.
pub const WORDS: usize = 16;
