// Marches rays by workgroups: many threads follow few rays. `march_pool` is that of pool_plain.wgsl or pool_fine.wgsl.

/// A segment without samples.
fn no_segment() -> Segment {
    return Segment(vec3f(0.0), vec3f(0.0), 0.0, 0.0, 0.0);
}

/// Marches the pixels of the list.
@compute @workgroup_size(POOL_THREADS)
fn pool_list(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let i = (group.y * GROUPS_X + group.x) * POOL_RAYS + thread;
    let has_ray = thread < POOL_RAYS && i < list_length.pixels;
    if thread < POOL_RAYS {
        segments[thread] = no_segment();
        if has_ray {
            segments[thread] = segment_of(unpacked(list[i]));
        }
    }
    let marched = march_pool(thread);
    if has_ray {
        put_listed(i, unpacked(list[i]), marched);
    }
}

/// The pixel of ray `i` of a square of 8 by 8, in the order of a Z.
fn in_square(i: u32) -> vec2u {
    let x = (i & 1u) | (i >> 1u & 2u) | (i >> 2u & 4u);
    let y = (i >> 1u & 1u) | (i >> 2u & 2u) | (i >> 3u & 4u);
    return vec2u(x, y);
}

/// Marches every pixel, or those of the mask. Results are at the places of their pixels. Groups of one square of pixels
/// lie beside each other, eight in a row.
@compute @workgroup_size(POOL_THREADS)
fn pool_frame(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let parts = 64u / POOL_RAYS;
    let columns = min(parts, 8u);
    let rows = parts / columns;
    let part = group.y % rows * columns + group.x % columns;
    let square = group.xy / vec2u(columns, rows);
    let pixel = 8u * square + in_square(part * POOL_RAYS + thread);
    var has_ray = thread < POOL_RAYS && pixel.x < extent.width && pixel.y < extent.height;
    if REJECT && has_ray {
        has_ray = is_masked(pixel);
    }
    if thread < POOL_RAYS {
        segments[thread] = no_segment();
        if has_ray {
            segments[thread] = segment_of(pixel);
        }
    }
    let marched = march_pool(thread);
    if has_ray {
        put_in_frame(pixel, marched);
    }
}
