use super::Shortage;
use super::exhaustion::fallible;
use bytemuck::Zeroable;

/// Allocates `count` zeros, which the system clears at first use. `what` and `advice` go into the error.
///
/// # Errors
/// Too little memory.
pub fn zeroed<T: Zeroable>(count: usize, what: &str, advice: &'static str) -> Result<Vec<T>, Shortage> {
    let made = fallible(|| bytemuck::allocation::try_zeroed_slice_box(count));
    made.map(Vec::from).map_err(|()| shortage::<T>(count, what, advice))
}

/// Copies `values`. `what` and `advice` go into the error.
///
/// # Errors
/// Too little memory.
pub fn copied<T: Copy>(values: &[T], what: &str, advice: &'static str) -> Result<Vec<T>, Shortage> {
    let mut copy = Vec::new();
    reserve(&mut copy, values.len(), what, advice)?;
    copy.extend_from_slice(values);
    Ok(copy)
}

/// Reserves room in `values` for exactly `more` elements.
///
/// # Errors
/// Too little memory; `values` is then unchanged.
pub fn reserve<T>(
    values: &mut Vec<T>,
    more: usize,
    what: &str,
    advice: &'static str,
) -> Result<(), Shortage> {
    let reserved = fallible(|| values.try_reserve_exact(more));
    reserved.map_err(|_| shortage::<T>(values.len().saturating_add(more), what, advice))
}

fn shortage<T>(count: usize, what: &str, advice: &'static str) -> Shortage {
    let needed = (count as u64).saturating_mul(size_of::<T>() as u64);
    Shortage { what: what.into(), needed, available: None, parts: Vec::new(), advice }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_had_is_an_error() {
        assert_eq!(zeroed::<u16>(3, "numbers", "").unwrap(), [0; 3]);
        assert!(zeroed::<u64>(0, "numbers", "").unwrap().is_empty());
        let error = zeroed::<u64>(usize::MAX / 16, "the grid", "give less").unwrap_err();
        assert_eq!((error.what.as_str(), error.needed), ("the grid", (usize::MAX / 16) as u64 * 8));
        let mut values = vec![1u8, 2];
        reserve(&mut values, 10, "values", "").unwrap();
        assert!(values.capacity() >= 12 && reserve(&mut values, usize::MAX - 8, "values", "").is_err());
        assert_eq!(copied(&values, "values", "").unwrap(), [1, 2]);
    }
}
