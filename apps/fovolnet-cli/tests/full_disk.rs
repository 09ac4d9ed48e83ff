//! Every kind of output on a full disk: an error, and no file under its name.
//!
//! The disk is a small file system in memory, which only an administrator may mount.
#![cfg(target_os = "linux")]

mod command;

use command::{files, run, said, succeeds};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Small file system in memory, unmounted on drop.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    /// Mounts a file system of 1 MiB; `None` if that is not allowed.
    fn mount() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", "size=1m", "tmpfs"]).arg(folder.path());
        if mount.output().is_ok_and(|output| output.status.success()) {
            return Some(Self(folder));
        }
        println!("skipped: no file system can be mounted here");
        None
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Fills the disk except for `bytes` bytes, in whole pages of 4096.
    fn leave(&self, bytes: usize) {
        let mut filler = File::create(self.path().join("filler")).unwrap();
        while filler.write_all(&[1; 4096]).is_ok() {}
        let length = filler.metadata().unwrap().len() - bytes as u64;
        filler.set_len(length).unwrap();
    }

    /// All files except the filler.
    fn files(&self) -> Vec<PathBuf> {
        let mut files = files(self.path());
        files.retain(|path| !path.ends_with("filler"));
        files
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg(self.path()).status();
        assert!(unmounted.is_ok_and(|status| status.success()), "the small disk is still mounted");
    }
}

/// Folder with inputs, and commands for each kind of output, which they write to `{}`, the full disk.
fn kinds() -> (tempfile::TempDir, Vec<&'static str>) {
    let inputs = tempfile::tempdir().unwrap();
    succeeds(inputs.path(), "data make head v.nrrd --dims 48,48,48");
    let frames =
        "render v.nrrd -o frames --size 96x64 --frames 2 --keep frame,sparse --reconstruct pull-push";
    succeeds(inputs.path(), frames);
    let mut kinds = vec![
        "render v.nrrd --size 96x64 -o {}/out",
        "render v.nrrd --size 96x64 -o {}/out.png",
        "render v.nrrd --size 96x64 -o {}/out --format exr",
        "render v.nrrd --size 96x64 -o {}/out --keep sparse,mask,motion,reference",
        "render v.nrrd --size 96x64 -o here --json {}/report.json",
        "render v.nrrd --size 96x64 -o here --save-session {}/s.toml",
        "render v.nrrd --size 96x64 -o here --frames 3 --video {}/clip.y4m",
        "convert v.nrrd {}/v.raw",
        "convert v.nrrd {}/v_48x48x48_uint8.raw",
        "convert v.nrrd {}/v.raw.gz",
        "convert v.nrrd {}/v.nrrd",
        "convert v.nrrd {}/v.nhdr",
        "convert v.nrrd {}/v.nii",
        "convert v.nrrd {}/v.nii.gz",
        "convert v.nrrd {}/v.mha",
        "convert v.nrrd {}/v.mhd",
        "convert v.nrrd {}/v.vti",
        "data make engine {}/v.nrrd --dims 48,48,48",
        "data list --json {}/list.json",
        "info v.nrrd --json {}/info.json",
        "noise make {}/noise.npy --size 32 --frames 8",
        "noise make {}/noise.ranks --size 32 --frames 8",
        "mask -o {}/mask.png --size 256x256",
        "export --random-weights wnet-narrow --onnx {}/net.onnx",
        "metrics frames frames --json {}/metrics.json",
        "reconstruct frames -o {}/full --reconstruct pull-push",
        "bench march v.nrrd --size 64x48 --repeats 1 --picture {}/picture.png",
        "bench compact v.nrrd --size 32x32 --repeats 1 -o {}/bench",
        "demo --dims 16,16,16 --size 64x48 --frames 2 -o {}/demo",
        "repro data-sets --quick --size 32x32 --frames 2 --volume v.nrrd -o {}/report",
        "repro masks --quick --size 32x32 --frames 2 --volume v.nrrd -o {}/report",
    ];
    if Command::new("ffmpeg").arg("-version").output().is_ok() {
        for line in [
            "render v.nrrd --size 96x64 -o here --frames 3 --video {}/clip.mp4",
            "render v.nrrd --size 96x64 -o here --frames 3 --video {}/clip.gif",
            "render v.nrrd --size 96x64 -o here --frames 3 --video {}/clip.mkv",
            "render v.nrrd --size 96x64 -o here --frames 3 --video {}/clip.apng",
            "render v.nrrd --size 96x64 -o here --frames 3 --video {}/clip.webp",
        ] {
            kinds.push(line);
        }
    } else {
        println!("clips of ffmpeg are left out: it is not installed");
    }
    (inputs, kinds)
}

#[test]
fn every_output_fails_on_a_full_disk_and_leaves_nothing() {
    let Some(disk) = SmallDisk::mount() else { return };
    let (inputs, kinds) = kinds();
    disk.leave(0);
    for kind in kinds {
        let line = kind.replace("{}", disk.path().to_str().unwrap());
        let error = said(kind, &run(inputs.path(), &line), 1);
        assert!(error.contains(disk.path().to_str().unwrap()), "{kind}: {error}");
        assert_eq!(disk.files(), Vec::<PathBuf>::new(), "{kind}: {error}");
    }
}

#[test]
fn what_is_found_on_a_disk_that_fills_up_is_complete() {
    let Some(disk) = SmallDisk::mount() else { return };
    let (inputs, kinds) = kinds();
    // Sizes of the outputs of each command on a disk with room.
    for kind in kinds.iter().filter(|kind| kind.starts_with("convert") || kind.starts_with("render")) {
        let roomy = tempfile::tempdir().unwrap();
        let line = kind.replace("{}", roomy.path().to_str().unwrap());
        succeeds(inputs.path(), &line);
        for pages in [1, 2, 4, 8, 16] {
            disk.leave(4096 * pages);
            let line = kind.replace("{}", disk.path().to_str().unwrap());
            let output = run(inputs.path(), &line);
            for file in disk.files() {
                let expected = roomy.path().join(file.strip_prefix(disk.path()).unwrap());
                let lengths = [&file, &expected].map(|file| fs::metadata(file).unwrap().len());
                // Times in reports vary in length.
                let is_same = lengths[0] == lengths[1] || file.extension().is_some_and(|e| e == "json");
                assert!(is_same, "{kind} {pages}: {lengths:?} {}", file.display());
                fs::remove_file(file).unwrap();
            }
            if !output.status.success() {
                said(kind, &output, 1);
            }
        }
    }
}
