use fovol_render::cpu::Simd;
use serde::Serialize;

/// Machine on which figures were measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Name of the CPU.
    pub cpu: String,
    /// Name of the GPU that marches rays, if one is used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gpu: Option<String>,
    /// Number of threads in use.
    pub threads: usize,
    /// Instruction set of the ray marcher.
    pub simd: String,
    /// Operating system and architecture.
    pub system: String,
    /// Version of this program.
    pub version: &'static str,
}

impl Machine {
    /// Describes this machine, with `threads` threads and the instruction set `simd`.
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
