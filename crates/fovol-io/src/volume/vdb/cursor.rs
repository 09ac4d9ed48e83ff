//! Numbers and texts one behind another.

/// A place in a file. All numbers are little-endian.
#[derive(Debug, Clone, Copy)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// The place `at` in `bytes`; none beyond their end.
    pub fn at(bytes: &'a [u8], at: u64) -> Option<Self> {
        let at = usize::try_from(at).ok().filter(|&at| at <= bytes.len())?;
        Some(Self { bytes, at })
    }

    /// How many bytes come before this place.
    pub fn place(&self) -> u64 {
        self.at as u64
    }

    /// The next `count` bytes; none if there are fewer.
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    /// The next byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.array().map(|[byte]| byte)
    }

    /// The next unsigned number of 32 bits.
    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// The next signed number of 32 bits.
    pub fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_le_bytes)
    }

    /// The next signed number of 64 bits.
    pub fn i64(&mut self) -> Option<i64> {
        self.array().map(i64::from_le_bytes)
    }

    /// The next three floats of 64 bits.
    pub fn vector(&mut self) -> Option<[f64; 3]> {
        let mut vector = [0.0; 3];
        for part in &mut vector {
            *part = f64::from_le_bytes(self.array()?);
        }
        Some(vector)
    }

    /// The next text, whose length stands before it.
    pub fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        Some(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// The next indices of a voxel.
    pub fn voxel(&mut self) -> Option<[i64; 3]> {
        Some([self.i32()?.into(), self.i32()?.into(), self.i32()?.into()])
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.first_chunk().copied()
    }
}
