// Plain integration by workgroups. It computes the numbers of march.wgsl in the same order.
//
// Opacity does not depend on light. Each round first takes the next samples of every ray, side by side, and queues those that
// show something. Then all threads find the light at queued samples, whichever ray these belong to. At last every ray adds
// its samples in order. So no ray waits for shadow rays one after the other.

/// A queued sample.
struct Queued {
    /// Its number on its ray.
    number: f32,
    /// Its entry of the transfer table.
    entry: u32,
    weight: f32,
    /// Factors of its colour with and without shadow rays; see `light`. A vector would need padding.
    light: f32,
    full_light: f32,
}

var<workgroup> entries: array<u32, POOL_THREADS>;
var<workgroup> queue: array<Queued, POOL_PLACES>;

/// Entry of sample `number` on the ray of a thread, `NOTHING` where it shows nothing. The last of the threads of a ray
/// also looks how far nothing shows.
fn take(segment: Segment, inverse: vec3f, number: f32, ray: u32, is_last: bool) -> u32 {
    var found = NOTHING;
    var after = 0.0;
    if number < segment.count {
        let p = fma(vec3f(number), segment.delta, segment.start);
        var is_empty = false;
        if SKIP {
            let ahead = look_ahead(p, inverse);
            is_empty = ahead.empty;
            after = select(0.0, ahead.steps - 1.0, is_empty);
        }
        if !is_empty {
            let at = entry(field(p));
            found = select(NOTHING, at, bitcast<f32>(appearance[at].x) > 0.0);
        }
    }
    if is_last {
        empty_after[ray] = after;
    }
    return found;
}

/// Queues the samples of one stretch of `ray`, in order, until it is opaque.
fn queue_stretch(sums: ptr<function, Sums>, ray: u32) {
    let lanes = POOL_THREADS / POOL_RAYS;
    let first = numbers[ray];
    var count = counts[ray];
    for (var lane = 0u; lane < lanes && (*sums).opacity < OPAQUE; lane += 1u) {
        let found = entries[ray * lanes + lane];
        if found == NOTHING {
            continue;
        }
        let number = first + f32(lane);
        let weight = cover(sums, number, bitcast<f32>(appearance[found].x));
        queue[ray * POOL_QUEUE + count] = Queued(number, found, weight, 0.0, 0.0);
        count += 1u;
    }
    counts[ray] = count;
    let goes_on = (*sums).opacity < OPAQUE;
    numbers[ray] = select(segments[ray].count, first + f32(lanes) + empty_after[ray], goes_on);
}

/// Whether samples are left, and room for the next ones.
fn look_around() -> Round {
    var found = Round(0u, 1u);
    for (var ray = 0u; ray < POOL_RAYS; ray += 1u) {
        if numbers[ray] < segments[ray].count {
            found.samples_left = 1u;
            if counts[ray] + POOL_THREADS / POOL_RAYS > POOL_QUEUE {
                found.has_room = 0u;
            }
        }
    }
    return found;
}

/// A place of the queue, and the point of its sample.
struct Taken {
    place: u32,
    p: vec3f,
}

/// Takes the next queued sample, of `total`; its place is `NOTHING` if none is left.
fn take_queued(total: u32) -> Taken {
    let ticket = take_ticket(total);
    if ticket.ray == NOTHING {
        return Taken(NOTHING, vec3f(0.0));
    }
    let ray = ticket.ray;
    let place = ray * POOL_QUEUE + ticket.number;
    return Taken(place, fma(vec3f(queue[place].number), segments[ray].delta, segments[ray].start));
}

/// Keeps the light of the sample at `place`.
fn put_light(place: u32, light: vec2f) {
    queue[place].light = light.x;
    queue[place].full_light = light.y;
}

/// Finds the light at queued samples until none is left.
fn light_queued() {
    let total = waiting();
    var taken = take_queued(total);
    if SHADOWS != RAYS {
        while taken.place != NOTHING {
            put_light(taken.place, light(taken.p));
            taken = take_queued(total);
        }
        return;
    }
    // Whoever is done goes on with another sample, and does not wait for the others' shadow rays.
    var ray = shadow_ray(taken.p);
    while taken.place != NOTHING {
        if !advance(&ray) {
            put_light(taken.place, light_of(taken.p, ray.transmittance));
            taken = take_queued(total);
            ray = shadow_ray(taken.p);
        }
    }
}

/// Adds the queued samples of `ray` in order.
fn add_queued(sums: ptr<function, Sums>, ray: u32) {
    for (var i = 0u; i < counts[ray]; i += 1u) {
        let sample = queue[ray * POOL_QUEUE + i];
        shine(sums, sample.weight, appearance[sample.entry].y, vec2f(sample.light, sample.full_light));
    }
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
        counts[thread] = 0u;
    }
    workgroupBarrier();
    let segment = segments[ray];
    let inverse = inverse_of(segment.delta);
    var sums = no_sums();
    loop {
        if thread == 0u {
            atomicStore(&next, 0u);
        }
        loop {
            entries[thread] = take(segment, inverse, numbers[ray] + f32(lane), ray, lane == lanes - 1u);
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
        light_queued();
        workgroupBarrier();
        if has_ray {
            add_queued(&sums, thread);
        }
        let seen = workgroupUniformLoad(&round);
        if seen.samples_left == 0u {
            break;
        }
    }
    return result_of(sums, segments[min(thread, POOL_RAYS - 1u)]);
}
