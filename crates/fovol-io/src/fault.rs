//! Writes that fail where tests want it.

use std::cell::Cell;
use std::io;

thread_local! {
    /// How many bytes files of this thread take until the disk is full.
    static ROOM: Cell<usize> = const { Cell::new(usize::MAX) };
}

/// Runs `act` with room on the disk for `bytes` bytes, counted over all files of this thread, and returns its result.
pub(crate) fn after<T>(bytes: usize, act: impl FnOnce() -> T) -> T {
    ROOM.set(bytes);
    let result = act();
    ROOM.set(usize::MAX);
    result
}

/// How many of `bytes` bytes find room.
pub(crate) fn room(bytes: usize) -> io::Result<usize> {
    let left = ROOM.get();
    if left == usize::MAX || bytes == 0 {
        return Ok(bytes);
    }
    if left == 0 {
        return Err(io::ErrorKind::StorageFull.into());
    }
    let taken = bytes.min(left);
    ROOM.set(left - taken);
    Ok(taken)
}

#[cfg(test)]
mod tests {
    use crate::image::{Alpha, write_exr, write_grey_png, write_png};
    use crate::{Result, atomic, transfer_function, volume};
    use fovol_core::{Frame, FrameSize, Grid, TransferFunction, Volume};
    use std::fs;
    use std::path::Path;

    type Write = fn(&Path) -> Result<()>;

    fn voxels(path: &Path) -> Result<()> {
        let values = (0..60u16).collect();
        let made = Volume::from_values(Grid::new([5, 4, 3], [1.0, 1.0, 2.0]).unwrap(), values).unwrap();
        volume::write(&made, path).map(drop)
    }

    fn frame() -> Frame {
        Frame::new(FrameSize::new(6, 4).unwrap())
    }

    /// A name, and what is written under it.
    const KINDS: [(&str, Write); 14] = [
        ("v.raw", voxels),
        ("v.raw.gz", voxels),
        ("v.nrrd", voxels),
        ("v.nhdr", voxels),
        ("v.mha", voxels),
        ("v.mhd", voxels),
        ("v.nii", voxels),
        ("v.nii.gz", voxels),
        ("v.vti", voxels),
        ("p.png", |path| write_png(path, &frame(), Alpha::Keep)),
        ("g.png", |path| write_grey_png(path, frame().size(), &[7; 24])),
        ("p.exr", |path| write_exr(path, &frame())),
        ("tf.json", |path| transfer_function::write(path, &TransferFunction::grey_ramp(0.3))),
        ("text.toml", |path| atomic::write_bytes(path, b"a = 1")),
    ];

    #[test]
    fn every_write_of_every_kind_fails_once() {
        for (name, write) in KINDS {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            let files = || fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
            write(&path).unwrap();
            let old: Vec<_> = files().map(|file| (fs::read(&file).unwrap(), file)).collect();
            let length = old.iter().map(|(bytes, _)| bytes.len()).sum();
            for room in 0..length {
                super::after(room, || write(&path)).unwrap_err();
                for (bytes, file) in &old {
                    assert_eq!(&fs::read(file).unwrap(), bytes, "{name} {room}");
                }
                assert_eq!(files().count(), old.len(), "{name} {room}");
            }
            files().for_each(|file| fs::remove_file(file).unwrap());
            for room in 0..length {
                super::after(room, || write(&path)).unwrap_err();
                assert_eq!(files().count(), 0, "{name} {room}");
            }
            super::after(length, || write(&path)).unwrap();
        }
    }
}
