//! Downloads of published volumes, from a server on this machine.

mod loopback;

use fovol_core::Dtype;
use fovol_io::dataset::{Check, Entry, Error, Origin, Outcome, Progress, Result, Stage, get};
use loopback::{Manners, Server};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::TempDir;

/// SHA-512 of [`content`], by `sha512sum`.
const SHA512: &str = "ce0730906980f0bf4c22b7391fa115c8dca4201e443286e588ea3efcdaaeffca9ad5789115e06f5c23a14cd851399382916f33ab9937d8fc6cfc5e35ec746bc7";

fn content() -> Vec<u8> {
    (0..50u32 * 40 * 30 * 2).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()
}

struct Case {
    folder: TempDir,
    entry: Entry,
    server: Server,
}

impl Case {
    fn new(manners: Manners, sha512: Option<&str>) -> Self {
        let server = Server::start(content(), manners);
        let entry = Entry {
            name: "thing".into(),
            dims: [50, 40, 30],
            dtype: Dtype::U16,
            spacing: [1.0; 3],
            url: server.url.clone(),
            sha512: sha512.map(str::to_owned),
        };
        Self { folder: tempfile::tempdir().unwrap(), entry, server }
    }

    fn path(&self, suffix: &str) -> PathBuf {
        self.folder.path().join(format!("thing_50x40x30_uint16.raw{suffix}"))
    }

    fn get(&self) -> Result<Outcome> {
        get(&self.entry, self.folder.path(), &mut |_| (), &AtomicBool::new(false))
    }

    fn message(&self) -> String {
        let message = self.get().unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    }
}

#[test]
fn a_whole_download_is_checked_named_and_found_again() {
    let case = Case::new(Manners::Good, Some(SHA512));
    let got = case.get().unwrap();
    assert_eq!(got.path, case.path(""));
    assert_eq!((got.origin, got.check), (Origin::Downloaded { resumed_from: 0 }, Check::Published));
    assert_eq!(fs::read(case.path("")).unwrap(), content());
    assert!(!case.path(".part").exists() && !case.path(".sha512").exists());
    assert_eq!(case.get().unwrap().origin, Origin::Present);
    assert_eq!(case.server.ranges.lock().unwrap().len(), 1);
}

#[test]
fn progress_rises_to_the_end_and_then_the_hash_is_computed() {
    let case = Case::new(Manners::Good, Some(SHA512));
    let mut seen: Vec<Progress> = Vec::new();
    get(&case.entry, case.folder.path(), &mut |p| seen.push(p), &AtomicBool::new(false)).unwrap();
    let total = case.entry.bytes();
    let downloads: Vec<u64> = seen.iter().filter(|p| p.stage == Stage::Download).map(|p| p.done).collect();
    assert!(downloads.is_sorted() && downloads[0] == 0 && downloads[downloads.len() - 1] == total);
    assert_eq!(seen[seen.len() - 1], Progress { stage: Stage::Verify, done: total, total });
}

#[test]
fn a_broken_download_goes_on_where_it_stopped() {
    let case = Case::new(Manners::HangsUpAfter(70_000), Some(SHA512));
    let message = case.message();
    assert!(message.contains("70000 of 120000 bytes") && message.contains("again"), "{message}");
    assert_eq!(fs::metadata(case.path(".part")).unwrap().len(), 70_000);
    assert!(!case.path("").exists());
    let got = case.get().unwrap();
    assert_eq!(got.origin, Origin::Downloaded { resumed_from: 70_000 });
    assert_eq!(fs::read(case.path("")).unwrap(), content());
    assert_eq!(*case.server.ranges.lock().unwrap(), [None, Some("bytes=70000-".into())]);
}

#[test]
fn without_ranges_the_download_starts_over() {
    for manners in [Manners::NoRanges, Manners::WrongRange] {
        let case = Case::new(manners, Some(SHA512));
        fs::write(case.path(".part"), [1; 1000]).unwrap();
        assert_eq!(case.get().unwrap().origin, Origin::Downloaded { resumed_from: 0 });
        assert_eq!(fs::read(case.path("")).unwrap(), content());
    }
}

#[test]
fn a_part_that_is_too_long_is_not_trusted() {
    let case = Case::new(Manners::Good, Some(SHA512));
    fs::write(case.path(".part"), vec![0; 200_000]).unwrap();
    assert_eq!(case.get().unwrap().origin, Origin::Downloaded { resumed_from: 0 });
}

#[test]
fn another_hash_removes_the_download() {
    let wrong = "0".repeat(128);
    let case = Case::new(Manners::Good, Some(&wrong));
    let message = case.message();
    assert!(message.contains(&SHA512[..16]) && message.contains("was removed"), "{message}");
    assert!(!case.path("").exists() && !case.path(".part").exists());
}

#[test]
fn a_damaged_part_is_found_out_by_the_hash_and_mended_by_the_next_run() {
    let case = Case::new(Manners::Good, Some(SHA512));
    fs::write(case.path(".part"), vec![7; 1000]).unwrap();
    assert!(matches!(case.get(), Err(Error::HashDiffers { .. })));
    assert_eq!(case.get().unwrap().check, Check::Published);
}

#[test]
fn without_a_published_hash_the_first_is_recorded_and_compared_to() {
    let case = Case::new(Manners::Good, None);
    let got = case.get().unwrap();
    assert_eq!(got.check, Check::FirstSeen { record: case.path(".sha512") });
    assert!(got.to_string().contains("not checked"), "{got}");
    let record = fs::read_to_string(case.path(".sha512")).unwrap();
    assert_eq!(record, format!("{SHA512}  thing_50x40x30_uint16.raw\n"));
    fs::remove_file(case.path("")).unwrap();
    assert_eq!(case.get().unwrap().check, Check::Recorded);
    fs::remove_file(case.path("")).unwrap();
    fs::write(case.path(".sha512"), format!("{}  x\n", "a".repeat(128))).unwrap();
    let message = case.message();
    assert!(message.contains("delete that record"), "{message}");
}

#[test]
fn a_file_of_that_name_with_other_content_is_left_alone() {
    let case = Case::new(Manners::Good, Some(SHA512));
    fs::write(case.path(""), b"mine").unwrap();
    assert!(case.message().contains("has 4 bytes instead of 120000"));
    fs::write(case.path(""), vec![1; 120_000]).unwrap();
    assert!(case.message().contains("SHA-512"));
    assert_eq!(fs::read(case.path("")).unwrap(), vec![1; 120_000]);
}

#[test]
fn refusals_say_what_to_do() {
    for (status, advice) in [(404, "no longer there"), (403, "denied"), (503, "later")] {
        let message = Case::new(Manners::Status(status), None).message();
        assert!(message.contains(&status.to_string()) && message.contains(advice), "{message}");
    }
    let mut case = Case::new(Manners::Good, None);
    case.entry.dims = [50, 40, 31];
    assert!(case.message().contains("120000 bytes where 124000 are expected"));
    // Nothing listens on a port that was just given back.
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    case.entry.url = format!("http://127.0.0.1:{port}/x");
    assert!(case.message().contains("check the network"));
    assert_eq!(fs::read_dir(case.folder.path()).unwrap().count(), 0);
}

#[test]
fn stopping_keeps_what_came() {
    let case = Case::new(Manners::Good, Some(SHA512));
    let cancel = AtomicBool::new(false);
    let stop_after_some = &mut |p: Progress| cancel.store(p.done > 0, Ordering::Relaxed);
    let error = get(&case.entry, case.folder.path(), stop_after_some, &cancel).unwrap_err();
    assert!(matches!(error, Error::Cancelled { .. }), "{error}");
    assert!(case.path(".part").exists() && !case.path("").exists());
    let resumed =
        matches!(case.get().unwrap().origin, Origin::Downloaded { resumed_from } if resumed_from > 0);
    assert!(resumed);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let case = Case::new(Manners::Good, None);
    let file = case.folder.path().join("file");
    fs::write(&file, "").unwrap();
    let error = get(&case.entry, &file.join("below"), &mut |_| (), &AtomicBool::new(false)).unwrap_err();
    assert!(error.to_string().contains("below"), "{error}");
}
