use fovol_render::cpu::Simd;
use serde::Serialize;

/// The machine that figures were taken on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// The name of the processor.
    pub cpu: String,
    /// The name of the graphics processor that rays are marched on, where one is used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gpu: Option<String>,
    /// Threads in use.
    pub threads: usize,
    /// The instruction set of the marcher.
    pub simd: String,
    /// Operating system and architecture.
    pub system: String,
    /// The version of this program.
    pub version: &'static str,
}

impl Machine {
    /// This machine with `threads` threads and rays marched by `simd`.
    pub fn this(threads: usize, simd: Simd) -> Self {
        Self {
            cpu: cpu_name().unwrap_or_else(|| "unknown".into()),
            gpu: None,
            threads,
            simd: simd.to_string(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

fn cpu_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
