//! Instructions that this processor has.

use std::sync::OnceLock;

/// Whether it has AVX2, FMA and the bit instructions of their time.
pub(crate) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
        && is_x86_feature_detected!("lzcnt")
}

/// Whether it has AVX-512 F, BW, DQ and VL.
pub(crate) fn has_avx512() -> bool {
    has_avx2()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
}

/// Whether it has AVX-512 with bf16 and AMX, and the operating system lets this process use tiles.
pub(crate) fn has_amx() -> bool {
    static GRANTED: OnceLock<bool> = OnceLock::new();
    has_avx512()
        && is_x86_feature_detected!("avx512bf16")
        && *GRANTED.get_or_init(|| has_tiles() && is_granted_tiles())
}

/// Whether the processor has AMX with bf16 and int8 (Intel's manual, volume 2A, CPUID leaf 7).
fn has_tiles() -> bool {
    const BF16: u32 = 1 << 22;
    const TILE: u32 = 1 << 24;
    const INT8: u32 = 1 << 25;
    let found = std::arch::x86_64::__cpuid_count(7, 0).edx;
    found & (BF16 | TILE | INT8) == BF16 | TILE | INT8
}

/// Asks Linux for permission to use tile registers, whose state it only saves on request
/// (Documentation/arch/x86/xstate.rst).
#[cfg(target_os = "linux")]
fn is_granted_tiles() -> bool {
    const ARCH_REQ_XCOMP_PERM: libc::c_int = 0x1023;
    const XFEATURE_XTILEDATA: libc::c_ulong = 18;
    // SAFETY: the call takes two numbers and only changes permissions of this process.
    unsafe { libc::syscall(libc::SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) == 0 }
}

#[cfg(not(target_os = "linux"))]
fn is_granted_tiles() -> bool {
    false
}

/// Whether AMD made this processor (CPUID leaf 0).
pub(crate) fn is_from_amd() -> bool {
    let found = std::arch::x86_64::__cpuid(0);
    [found.ebx, found.edx, found.ecx].map(u32::to_le_bytes).concat() == b"AuthenticAMD"
}
