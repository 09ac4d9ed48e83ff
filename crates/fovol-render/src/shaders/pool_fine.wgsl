// Fine integration by workgroups. It computes the numbers of fine_march.wgsl in the same order.
//
// Opacity does not depend on light. Each round first takes the next blocks of four steps of every ray, side by side, and queues
// those parts of them that show something, and the ends of these parts. Then all threads find the light at the ends, whichever
// ray these belong to, and from it the colours of the parts. At last every ray adds its parts in order.

/// Blocks of a ray that are taken side by side.
override POOL_BLOCKS: u32 = 32;
/// Places of one ray for ends of parts.
override POOL_ENDS: u32 = POOL_QUEUE + 2;
override POOL_END_PLACES: u32 = POOL_RAYS * POOL_ENDS;

/// Marks of `blocks`: the block is one part of four steps rather than two of two; its first, its second part shows something.
const ONE_PART: u32 = 1;
const FIRST_SHOWS: u32 = 2;
const SECOND_SHOWS: u32 = 4;
/// Marks of a part in its `first_end`: it has four steps; it is the second one of its block.
const FOUR_STEPS: u32 = 0x80000000;
const SECOND: u32 = 0x40000000;

/// A queued part of a ray, and then its colours.
struct Part {
    /// Its first step, later the red of its colour.
    number_or_red: f32,
    /// Opacity of its ray before it, later the green of its colour.
    opacity_or_green: f32,
    blue: f32,
    /// Colour without shadow rays. A vector would need padding.
    unshadowed_red: f32,
    unshadowed_green: f32,
    unshadowed_blue: f32,
    /// The end where it begins among those of its ray; the next one is the other. With marks.
    first_end: u32,
}

/// Marks of the blocks that were taken.
var<workgroup> blocks: array<u32, POOL_THREADS>;
/// Opacities of their steps.
var<workgroup> opacities: array<vec4f, POOL_THREADS>;
var<workgroup> parts: array<Part, POOL_PLACES>;
/// Ends of parts: where they are in steps along the ray, then the light there, near and far.
var<workgroup> ends: array<vec2f, POOL_END_PLACES>;
/// Queued parts of each ray.
var<workgroup> part_counts: array<u32, POOL_RAYS>;

/// Takes the block of a thread, which begins at step `number` of its ray. The last of the threads of a ray, whose number is
/// `last_of`, also looks how far nothing shows; for the others that is `NOTHING`.
fn take(segment: Segment, inverse: vec3f, number: f32, thread: u32, last_of: u32) {
    var marks = 0u;
    var after = 0.0;
    var alphas = vec4f(0.0);
    if number < segment.length {
        var jump = 0.0;
        if SKIP {
            jump = empty_steps(look_ahead(boundary(segment, number), inverse));
            after = max(jump - 4.0, 0.0);
        }
        if jump == 0.0 {
            let steps = steps_from(segment, number, 4, entry(field(boundary(segment, number))));
            for (var i = 0; i < 4; i += 1) {
                alphas[i] = select(0.0, step_opacity(steps.depths[i]), steps.depths[i] > 0.0);
            }
            let count = steps_of_part(depth_of(steps, 0, 4));
            marks = select(0u, ONE_PART, count == 4);
            marks |= select(0u, FIRST_SHOWS, depth_of(steps, 0, count) > 0.0);
            if count == 2 {
                marks |= select(0u, SECOND_SHOWS, depth_of(steps, 2, 2) > 0.0);
            }
        }
    }
    blocks[thread] = marks;
    opacities[thread] = alphas;
    if last_of != NOTHING {
        empty_after[last_of] = after;
    }
}

/// Queues the parts of one stretch of `ray`, in order, until it is opaque.
fn queue_stretch(sums: ptr<function, Sums>, ray: u32) {
    let lanes = POOL_THREADS / POOL_RAYS;
    let first = numbers[ray];
    for (var lane = 0u; lane < POOL_BLOCKS && (*sums).opacity < FINE_OPAQUE; lane += 1u) {
        let marks = blocks[ray * lanes + lane];
        let alphas = opacities[ray * lanes + lane];
        let number = first + 4.0 * f32(lane);
        if (marks & FIRST_SHOWS) != 0u {
            let count = select(2u, 4u, (marks & ONE_PART) != 0u);
            queue_part(sums, ray, number, count, alphas, select(0u, FOUR_STEPS, count == 4u));
        }
        if (marks & SECOND_SHOWS) != 0u {
            queue_part(sums, ray, number + 2.0, 2u, alphas.zwxy, SECOND);
        }
    }
    let goes_on = (*sums).opacity < FINE_OPAQUE;
    let after = first + 4.0 * f32(POOL_BLOCKS) + empty_after[ray];
    numbers[ray] = select(segments[ray].length, after, goes_on);
}

/// Queues a part of `count` steps of `ray` from step `number` on, which have these opacities.
fn queue_part(sums: ptr<function, Sums>, ray: u32, number: f32, count: u32, alphas: vec4f, marks: u32) {
    let before = (*sums).opacity;
    for (var i = 0u; i < count; i += 1u) {
        if alphas[i] > 0.0 {
            _ = cover(sums, number + f32(i), alphas[i]);
        }
    }
    let of_ray = ray * POOL_ENDS;
    var end = counts[ray];
    // Parts that follow each other share an end.
    if end == 0u || ends[of_ray + end - 1u].x != number {
        ends[of_ray + end] = vec2f(number, 0.0);
        end += 1u;
    }
    ends[of_ray + end] = vec2f(number + f32(count), 0.0);
    counts[ray] = end + 1u;
    parts[ray * POOL_QUEUE + part_counts[ray]] = Part(number, before, 0.0, 0.0, 0.0, 0.0, (end - 1u) | marks);
    part_counts[ray] += 1u;
}

/// Whether steps are left, and room for the next ones.
fn look_around() -> Round {
    var found = Round(0u, 1u);
    for (var ray = 0u; ray < POOL_RAYS; ray += 1u) {
        if numbers[ray] < segments[ray].length {
            found.samples_left = 1u;
            let more = 2u * POOL_BLOCKS;
            if part_counts[ray] + more > POOL_QUEUE || counts[ray] + more + 1u > POOL_ENDS {
                found.has_room = 0u;
            }
        }
    }
    return found;
}

/// An end that waits for light, and the near part of its shadow ray.
struct Waiting {
    place: u32,
    near: NearPart,
}

/// Place of the next end of `total`; `NOTHING` if none is left.
fn take_place(total: u32) -> u32 {
    let ticket = take_ticket(total);
    return select(ticket.ray * POOL_ENDS + ticket.number, NOTHING, ticket.ray == NOTHING);
}

/// Takes the next end; its place is `NOTHING` if none is left.
fn take_end(total: u32) -> Waiting {
    let place = take_place(total);
    if place == NOTHING {
        return Waiting(NOTHING, NearPart(0.0, vec3f(0.0), true));
    }
    return Waiting(place, near_part(boundary(segments[place / POOL_ENDS], ends[place].x)));
}

/// Finds the light at all ends.
fn light_ends() {
    let total = waiting();
    if SHADOWS == UNSHADOWED {
        var place = take_place(total);
        while place != NOTHING {
            ends[place] = vec2f(0.0, 1.0);
            place = take_place(total);
        }
        return;
    }
    var waiting = take_end(total);
    if SHADOWS == CACHED {
        while waiting.place != NOTHING {
            var far = 1.0;
            if !waiting.near.is_all {
                far = grid_transmittance(waiting.near.end);
            }
            ends[waiting.place] = vec2f(waiting.near.depth, far);
            waiting = take_end(total);
        }
        return;
    }
    // Whoever is done goes on with another end, and does not wait for the others' shadow rays.
    var ray = shadow_ray(waiting.near.end);
    while waiting.place != NOTHING {
        if waiting.near.is_all || !advance(&ray) {
            let far = select(ray.transmittance, 1.0, waiting.near.is_all);
            ends[waiting.place] = vec2f(waiting.near.depth, far);
            waiting = take_end(total);
            ray = shadow_ray(waiting.near.end);
        }
    }
}

/// Finds the colours of the queued parts, whose ends are lit.
fn light_parts(thread: u32) {
    for (var i = thread; i < POOL_PLACES; i += POOL_THREADS) {
        let ray = i / POOL_QUEUE;
        if i % POOL_QUEUE >= part_counts[ray] {
            continue;
        }
        let part = parts[i];
        let segment = segments[ray];
        let count = select(2, 4, (part.first_end & FOUR_STEPS) != 0u);
        let end = ray * POOL_ENDS + (part.first_end & ~(FOUR_STEPS | SECOND));
        let before = Light(ends[end].x, ends[end].y);
        let after = Light(ends[end + 1u].x, ends[end + 1u].y);
        let number = part.number_or_red;
        let steps = steps_from(segment, number, count, entry(field(boundary(segment, number))));
        let arriving = arriving_at(depth_of(steps, 0, count), before, after);
        let lit = lit_part(segment, number, steps, 0, count, part.opacity_or_green, arriving);
        let colour = lit.colour;
        let unshadowed = lit.unshadowed;
        parts[i] = Part(colour.r, colour.g, colour.b, unshadowed.r, unshadowed.g, unshadowed.b, 0u);
    }
}

/// Adds the queued parts of `ray` in order.
fn add_parts(sums: ptr<function, Sums>, ray: u32) {
    for (var i = 0u; i < part_counts[ray]; i += 1u) {
        let part = parts[ray * POOL_QUEUE + i];
        (*sums).colour += vec3f(part.number_or_red, part.opacity_or_green, part.blue);
        (*sums).unshadowed += vec3f(part.unshadowed_red, part.unshadowed_green, part.unshadowed_blue);
    }
    part_counts[ray] = 0u;
    counts[ray] = 0u;
}

/// Marches the rays whose `segments` are set. Returns the result of the ray whose number is that of the thread.
fn march_pool(thread: u32) -> RayResult {
    let lanes = POOL_THREADS / POOL_RAYS;
    let ray = thread / lanes;
    let lane = thread % lanes;
    let has_ray = thread < POOL_RAYS;
    if has_ray {
        numbers[thread] = 0.0;
        part_counts[thread] = 0u;
        counts[thread] = 0u;
    }
    workgroupBarrier();
    let segment = segments[ray];
    let inverse = inverse_of(segment.delta);
    let last_of = select(NOTHING, ray, lane == POOL_BLOCKS - 1u);
    var sums = no_sums();
    loop {
        if thread == 0u {
            atomicStore(&next, 0u);
        }
        loop {
            if lane < POOL_BLOCKS {
                take(segment, inverse, numbers[ray] + 4.0 * f32(lane), thread, last_of);
            }
            workgroupBarrier();
            if has_ray {
                queue_stretch(&sums, thread);
            }
            workgroupBarrier();
            if thread == 0u {
                round = look_around();
            }
            let seen = workgroupUniformLoad(&round);
            if seen.samples_left == 0u || seen.has_room == 0u {
                break;
            }
        }
        light_ends();
        workgroupBarrier();
        light_parts(thread);
        workgroupBarrier();
        if has_ray {
            add_parts(&sums, thread);
        }
        let seen = workgroupUniformLoad(&round);
        if seen.samples_left == 0u {
            break;
        }
    }
    return fine_result(sums, segments[min(thread, POOL_RAYS - 1u)]);
}
