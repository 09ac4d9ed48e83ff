//! Damaged files of every kind: a volume or a one-line error, whatever is in them. The example `fuzz_parsers`
//! does the same with millions of them.

mod mutation;

use fovol_io::volume::{Overrides, Source, parse};
use mutation::{Random, mutated, words};

#[test]
fn damaged_files_are_volumes_or_one_line_errors() {
    let folder = tempfile::tempdir().unwrap();
    for target in mutation::seeds::targets(folder.path()) {
        let path = folder.path().join(target.file);
        let words = words(&target.seeds);
        for number in 0..3000 {
            let input = mutated(&mut Random::new(number), &target.seeds, &words);
            match parse(&Source::from_bytes(&path, input), &Overrides::default()) {
                Ok(volume) => {
                    let [x, y, z] = volume.grid().dims();
                    volume.value([x - 1, y - 1, z - 1]);
                }
                Err(error) => {
                    let message = error.to_string();
                    assert!(!message.contains(char::is_control), "{} {number}: {message:?}", target.name);
                }
            }
        }
    }
}
