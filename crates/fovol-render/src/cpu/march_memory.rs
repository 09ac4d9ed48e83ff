use super::fine::FineScratch;
use super::kernel::Scratch;
use super::packet::Packet;

/// Memory that marching uses again and again.
#[derive(Default)]
pub struct MarchMemory {
    /// Of projections and isosurfaces.
    pub packet: Packet,
    /// Of plain integration.
    pub plain: Scratch,
    /// Of fine integration.
    pub fine: FineScratch,
}
