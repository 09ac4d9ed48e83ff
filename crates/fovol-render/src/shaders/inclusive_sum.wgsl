// Sums over the threads of a workgroup.

/// Threads of a workgroup, and items of a block.
const BLOCK: u32 = 256;

var<workgroup> sums: array<u32, BLOCK>;

/// The sum of the values of threads 0 to `thread`. All threads of a workgroup must call it.
fn inclusive_sum(thread: u32, value: u32) -> u32 {
    sums[thread] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < BLOCK; reach *= 2u) {
        var before = 0u;
        if thread >= reach {
            before = sums[thread - reach];
        }
        workgroupBarrier();
        sums[thread] += before;
        workgroupBarrier();
    }
    return sums[thread];
}
