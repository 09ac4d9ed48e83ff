//! Feeds damaged files of every format to the parsers.
//!
//! Each must yield a volume, a transfer function or a one-line error. The example `fuzz_parsers` runs millions of them.

mod mutation;

use mutation::{Random, mutated, words};

#[test]
fn damaged_files_are_read_or_one_line_errors() {
    let folder = tempfile::tempdir().unwrap();
    for target in mutation::seeds::targets(folder.path()) {
        let path = folder.path().join(target.file);
        let words = words(&target.seeds);
        for number in 0..3000 {
            let input = mutated(&mut Random::new(number), &target.seeds, &words);
            if let Err(problem) = (target.read)(&path, &input) {
                panic!("{} {number} {problem}", target.name);
            }
        }
    }
}
