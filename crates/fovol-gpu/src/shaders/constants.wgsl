// Work that does nothing but take its time, for constants of a device.

/// Reads that depend on one another.
override READS: u32 = 1;

/// Each word says which one to read next.
@group(0) @binding(0) var<storage, read_write> words: array<u32>;
@group(0) @binding(1) var<storage, read_write> found: array<u32>;

/// Changes a word, so that the next dispatch has to wait.
@compute @workgroup_size(1)
fn touch() {
    found[0] += 1u;
}

/// Follows the words.
@compute @workgroup_size(1)
fn follow() {
    var at = 0u;
    for (var i = 0u; i < READS; i += 1u) {
        at = words[at];
    }
    found[0] = at;
}
