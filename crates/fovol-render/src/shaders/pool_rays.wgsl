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
/// Queued samples or parts of each ray.
var<workgroup> counts: array<u32, POOL_RAYS>;
/// What waits for light and is taken next.
var<workgroup> next: atomic<u32>;
var<workgroup> round: Round;
