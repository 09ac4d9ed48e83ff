// What the ways to march by workgroups share: a workgroup has few rays, which all its threads follow.

/// Rays of a workgroup, a divisor of 64.
override POOL_RAYS: u32 = 4;
/// Threads of a workgroup, a multiple of its rays.
override POOL_THREADS: u32 = 128;
/// Places of one ray in the queue of what waits for light.
override POOL_QUEUE: u32 = 128;
/// Places of all rays.
override POOL_PLACES: u32 = POOL_RAYS * POOL_QUEUE;

/// Whether a round goes on.
struct Round {
    /// 1 if samples are left.
    samples_left: u32,
    /// 1 if every ray has room for the next ones.
    has_room: u32,
}

var<workgroup> segments: array<Segment, POOL_RAYS>;
/// Number of the next sample or step of each ray; at the end of its segment where a ray is opaque.
var<workgroup> numbers: array<f32, POOL_RAYS>;
/// Samples or steps from the last one of a stretch on that show nothing, besides that one.
var<workgroup> empty_after: array<f32, POOL_RAYS>;
/// Samples, or ends of parts, of each ray that wait for light.
var<workgroup> counts: array<u32, POOL_RAYS>;
/// What waits for light and is taken next.
var<workgroup> next: atomic<u32>;
var<workgroup> round: Round;

/// Nothing: no entry, no ray.
const NOTHING: u32 = 0xFFFFFFFFu;

/// What waits for light on one ray.
struct Ticket {
    /// `NOTHING` if nothing waits any more.
    ray: u32,
    /// Its number among what waits on that ray.
    number: u32,
}

/// How much waits for light on all rays.
fn waiting() -> u32 {
    var total = 0u;
    for (var ray = 0u; ray < POOL_RAYS; ray += 1u) {
        total += counts[ray];
    }
    return total;
}

/// Takes what waits next, of `total`.
fn take_ticket(total: u32) -> Ticket {
    var number = atomicAdd(&next, 1u);
    if number >= total {
        return Ticket(NOTHING, 0u);
    }
    var ray = 0u;
    while number >= counts[ray] {
        number -= counts[ray];
        ray += 1u;
    }
    return Ticket(ray, number);
}
