// Shared by the shaders of one frame: its size, and the memory layout of masks and lists.

/// Width and height in pixels. Twin of `Extent` in gpu/buffers.rs.
struct Extent {
    width: u32,
    height: u32,
}

/// The length of a list of pixels, and the workgroups of dispatches over it. Twin of `ListLength` in
/// gpu/list_buffers.rs.
struct ListLength {
    pixels: u32,
    /// Workgroups along x, y and z for 64, 16, 4 and 1 pixels of a workgroup.
    groups: array<u32, 12>,
}

/// Threads of a workgroup over a list.
const LIST_GROUP: u32 = 64;
/// Workgroups along x of a dispatch over a list; further ones go along y.
const GROUPS_X: u32 = 1024;

/// The length of a list of `pixels`.
fn list_length_of(pixels: u32) -> ListLength {
    var length = ListLength(pixels, array<u32, 12>());
    var size = 64u;
    for (var i = 0u; i < 12u; i += 3u) {
        let groups = (pixels + size - 1u) / size;
        length.groups[i] = min(groups, GROUPS_X);
        length.groups[i + 1u] = (groups + GROUPS_X - 1u) / GROUPS_X;
        length.groups[i + 2u] = 1u;
        size /= 4u;
    }
    return length;
}

/// The position in its list of a thread of a dispatch over it.
fn list_position(group: vec3u, thread: u32) -> u32 {
    return (group.y * GROUPS_X + group.x) * LIST_GROUP + thread;
}

/// 32-bit words of one row of a mask: a bit for each pixel, lowest first, padded with zeros to 64 bits.
fn words_per_row(extent: Extent) -> u32 {
    return (extent.width + 63u) / 64u * 2u;
}

/// Pixels of a list have x in the low and y in the high half.
fn packed(pixel: vec2u) -> u32 {
    return pixel.y << 16u | pixel.x;
}

/// The pixel that is packed in `bits`.
fn unpacked(bits: u32) -> vec2u {
    return vec2u(bits & 0xFFFFu, bits >> 16u);
}
