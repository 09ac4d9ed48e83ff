//! Which channels of an EXR file hold colours or motion, by their names.

/// The places of the channels of colours in a list of names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Colours {
    /// Indices of red, green and blue; all equal for a grey image.
    pub colours: [usize; 3],
    /// Alpha, if there is any.
    pub alpha: Option<usize>,
    /// How many groups of colours there are besides.
    pub others: usize,
}

/// The places of the channels of motion in a list of names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Ways {
    /// The channels of the way right and of the way down.
    pub channels: [usize; 2],
    /// How many such pairs there are besides.
    pub others: usize,
}

/// The layer and the last word of a channel's name: `Combined` and `R` of `Combined.R`.
fn parts(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// The place of the channel of `layer` that has one of `words` for its last word, in any case.
fn named(names: &[String], layer: &str, words: &[&str]) -> Option<usize> {
    names.iter().position(|name| {
        let (found, word) = parts(name);
        found == layer && words.iter().any(|wanted| word.eq_ignore_ascii_case(wanted))
    })
}

/// The red, green and blue channels among `names`, or the channel of a grey image.
///
/// Channels without a layer come first, then a layer called as renderers call the whole picture, then the first.
pub(super) fn colours(names: &[String]) -> Option<Colours> {
    const WHOLE: [&str; 3] = ["combined", "beauty", "rgba"];
    let group = |layer: &&str| {
        let one = |words: &[&str]| named(names, layer, words);
        let alpha = one(&["a", "alpha"]);
        let colours = match [one(&["r", "red"]), one(&["g", "green"]), one(&["b", "blue"])] {
            [Some(r), Some(g), Some(b)] => [r, g, b],
            [None, None, None] => [one(&["y"]).filter(|_| one(&["x"]).is_none())?; 3],
            _ => return None,
        };
        Some((layer.to_string(), colours, alpha))
    };
    let mut groups: Vec<_> = layers(names).iter().filter_map(group).collect();
    let rank = |layer: &str| match layer {
        "" => 0,
        named if WHOLE.iter().any(|whole| named.to_ascii_lowercase().contains(whole)) => 1,
        _ => 2,
    };
    groups.sort_by_key(|(layer, ..)| rank(layer));
    let others = groups.len().saturating_sub(1);
    groups.into_iter().next().map(|(_, colours, alpha)| Colours { colours, alpha, others })
}

/// The layers of `names`, each once, in their order.
fn layers(names: &[String]) -> Vec<&str> {
    let mut layers = Vec::new();
    for name in names {
        let layer = parts(name).0;
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    }
    layers
}

/// The letters that tell the two channels of a pair apart, the likeliest first.
const LETTERS: [[char; 2]; 3] = [['x', 'y'], ['u', 'v'], ['r', 'g']];

/// The two channels of motion among `names`: those whose names differ by X and Y, by U and V, or by R and G alone.
///
/// Of several pairs, takes the one whose name mentions motion, else the first.
pub(super) fn ways(names: &[String]) -> Option<Ways> {
    const MOTION: [&str; 5] = ["motion", "vector", "velocity", "flow", "mv"];
    let lower: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let mut pairs = Vec::new();
    for (rank, letters) in LETTERS.into_iter().enumerate() {
        for (i, first) in lower.iter().enumerate() {
            if let Some(j) = lower.iter().position(|second| is_pair(first, second, letters)) {
                let speaks = MOTION.iter().any(|word| first.contains(word));
                pairs.push((!speaks, rank, [i, j]));
            }
        }
    }
    // The order of pairs alike in both stays that of the file.
    pairs.sort_by_key(|&(silent, rank, _)| (silent, rank));
    let others = pairs.len().saturating_sub(1);
    pairs.first().map(|&(.., channels)| Ways { channels, others })
}

/// Whether `first` and `second` differ in one letter alone, which is `from` in the one and `to` in the other.
fn is_pair(first: &str, second: &str, [from, to]: [char; 2]) -> bool {
    if [first, second] == ["red", "green"] {
        return [from, to] == ['r', 'g'];
    }
    let mut differing = first.chars().zip(second.chars()).filter(|(a, b)| a != b);
    first.chars().count() == second.chars().count()
        && differing.next() == Some((from, to))
        && differing.next().is_none()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &str) -> Vec<String> {
        names.split(' ').map(str::to_owned).collect()
    }

    /// The names that are taken for the ways right and down.
    fn taken(text: &str) -> Option<String> {
        let names = names(text);
        ways(&names).map(|ways| ways.channels.map(|i| names[i].as_str()).join(" "))
    }

    #[test]
    fn motion_is_found_by_any_pair_of_names() {
        for (all, pair) in [
            ("G R", "R G"),
            ("X Y", "X Y"),
            ("Y X", "X Y"),
            ("u v", "u v"),
            ("A B G R", "R G"),
            ("motion.X motion.Y", "motion.X motion.Y"),
            ("forward.u forward.v", "forward.u forward.v"),
            ("MotionX MotionY", "MotionX MotionY"),
            ("mv_x mv_y depth", "mv_x mv_y"),
            ("red green blue", "red green"),
            (
                "Combined.A Combined.B Combined.G Combined.R Vector.W Vector.X Vector.Y Vector.Z",
                "Vector.X Vector.Y",
            ),
            ("A B G R velocity.x velocity.y", "velocity.x velocity.y"),
            ("N.x N.y N.z motion.r motion.g", "motion.r motion.g"),
        ] {
            assert_eq!(taken(all).as_deref(), Some(pair), "{all}");
        }
        for none in ["Z", "A B", "X Z", "depth mask"] {
            assert_eq!(taken(none), None, "{none}");
        }
        assert_eq!(ways(&names("R G X Y")).unwrap().others, 1);
    }

    #[test]
    fn colours_are_found_with_and_without_layers() {
        let found = |text: &str| colours(&names(text));
        let all = found("A B G R").unwrap();
        assert_eq!((all.colours, all.alpha, all.others), ([3, 2, 1], Some(0), 0));
        let layered =
            found("Diff.B Diff.G Diff.R View.Combined.A View.Combined.B View.Combined.G View.Combined.R")
                .unwrap();
        assert_eq!((layered.colours, layered.alpha, layered.others), ([6, 5, 4], Some(3), 1));
        assert_eq!(found("Y").unwrap().colours, [0; 3]);
        assert_eq!(found("X Y"), None);
        assert_eq!(found("R G Z"), None);
    }
}
