use anyhow::Result;

/// Thread pool of `threads` threads; as many as there are cores for 0. Steps outside a pipeline run in it, so that
/// `--threads` applies to them, too.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
}
