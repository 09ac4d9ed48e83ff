//! Pictures at one place: copies, times, or several series in one.

use super::file::DicomFile;
use super::header::Header;
use super::plane::{Keys, Plane};
use super::stack::Stack;
use crate::volume::Source;

/// Positions closer than this part of a pixel are one.
const NEAR: f64 = 0.01;

/// An attribute that separates series, and its name.
type Separator = (&'static str, fn(&Keys) -> &String);

/// Attributes that separate series, in the order in which they are tried.
const SEPARATORS: [Separator; 5] = [
    ("ImageType", |keys| &keys.image_type),
    ("echo", |keys| &keys.echo),
    ("stack", |keys| &keys.stack),
    ("b-value", |keys| &keys.diffusion),
    ("segment", |keys| &keys.segment),
];

/// Stacks of the sorted `planes` of one direction.
pub fn resolved(headers: &[Header], planes: Vec<Plane>) -> Vec<Stack> {
    let mut notes = Vec::new();
    let planes = without_copies(headers, planes, &mut notes);
    let mut stacks = separated(&planes, String::new());
    for stack in &mut stacks {
        stack.notes.splice(0..0, notes.iter().cloned());
    }
    stacks
}

/// Numbers of the first planes of all places.
fn places(planes: &[Plane]) -> Vec<usize> {
    let is_new = |&number: &usize| match number.checked_sub(1) {
        Some(before) => !is_together(&planes[before], &planes[number]),
        None => true,
    };
    (0..planes.len()).filter(is_new).collect()
}

fn is_together(a: &Plane, b: &Plane) -> bool {
    match (&a.place, &b.place) {
        (Some(a_place), Some(b_place)) => {
            let apart = (b_place.position - a_place.position).dot(a_place.normal()).abs();
            apart < NEAR * a.spacing[0].min(a.spacing[1])
        }
        // Without positions every picture is a slice.
        _ => false,
    }
}

/// Splits sorted planes into those of each place.
fn by_place(planes: &[Plane]) -> Vec<&[Plane]> {
    let starts = places(planes);
    let ends = starts.iter().skip(1).copied().chain([planes.len()]);
    starts.iter().zip(ends).map(|(&start, end)| &planes[start..end]).collect()
}

/// Leaves out planes that are copies of another at the same place.
fn without_copies(headers: &[Header], planes: Vec<Plane>, notes: &mut Vec<String>) -> Vec<Plane> {
    let groups = by_place(&planes);
    if groups.len() == planes.len() {
        return planes;
    }
    let mut kept: Vec<Plane> = Vec::new();
    for group in groups {
        let first = kept.len();
        for plane in group {
            if !kept[first..].iter().any(|other| is_copy(headers, other, plane)) {
                kept.push(plane.clone());
            }
        }
    }
    let dropped = planes.len() - kept.len();
    if dropped > 0 {
        notes.push(format!("{dropped} pictures are copies of others at the same place and are left out"));
    }
    kept
}

fn is_copy(headers: &[Header], a: &Plane, b: &Plane) -> bool {
    if a.file == b.file || a.keys.temporal != b.keys.temporal || a.keys.echo != b.keys.echo {
        return false;
    }
    let [first, second] = [a, b].map(|plane| &headers[plane.file]);
    let is_same_instance = first.instance == second.instance && !first.instance.is_empty();
    (is_same_instance && a.frame == b.frame) || (a.scale == b.scale && has_same_pixels(first, second))
}

/// Whether the pixels of two files are the same bytes.
fn has_same_pixels(a: &Header, b: &Header) -> bool {
    let (Ok(a), Ok(b)) = (Source::open(&a.path), Source::open(&b.path)) else { return false };
    let (Ok(a), Ok(b)) = (DicomFile::open(&a), DicomFile::open(&b)) else { return false };
    let [a, b] = [a.data_set(), b.data_set()].map(|set| set.pixels().map(|pixels| pixels.bytes.to_vec()));
    a.is_some() && a == b
}

/// Separates planes by the first attribute that tells those at one place apart; what is left are times.
fn separated(planes: &[Plane], part: String) -> Vec<Stack> {
    let groups = by_place(planes);
    if groups.len() == planes.len() {
        return vec![Stack { times: vec![planes.to_vec()], part, notes: Vec::new() }];
    }
    for (name, key) in SEPARATORS {
        let differs = |group: &&[Plane]| group.iter().any(|plane| key(&plane.keys) != key(&group[0].keys));
        if groups.iter().any(differs) {
            return split(planes, key)
                .into_iter()
                .flat_map(|(value, group)| {
                    let part = [part.as_str(), &format!("{name} {value}")];
                    separated(
                        &group,
                        part.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", "),
                    )
                })
                .collect();
        }
    }
    over_time(planes, part)
}

/// Splits planes by an attribute, in the order in which its values come.
fn split(planes: &[Plane], key: fn(&Keys) -> &String) -> Vec<(String, Vec<Plane>)> {
    let mut groups: Vec<(String, Vec<Plane>)> = Vec::new();
    for plane in planes {
        let value = key(&plane.keys);
        match groups.iter_mut().find(|(found, _)| found == value) {
            Some((_, group)) => group.push(plane.clone()),
            None => groups.push((value.clone(), vec![plane.clone()])),
        }
    }
    groups
}

/// Planes of several times: the first at each place is of the first time, and so on.
fn over_time(planes: &[Plane], part: String) -> Vec<Stack> {
    let groups = by_place(planes);
    let counts: Vec<usize> = groups.iter().map(|group| group.len()).collect();
    let least = counts.iter().copied().min().unwrap_or(0);
    let is_even = counts.iter().all(|&count| count == least);
    if !is_even && let Some(stacks) = by_acquisition(planes, &part) {
        return stacks;
    }
    let ordered: Vec<Vec<Plane>> = groups.iter().map(|group| in_time(group)).collect();
    let times = (0..least).map(|time| ordered.iter().map(|group| group[time].clone()).collect()).collect();
    let left: usize = counts.iter().map(|count| count - least).sum();
    let mut notes = Vec::new();
    if !is_even {
        notes.push(format!(
            "{left} pictures lie where others do and belong to no whole time point; they are left out"
        ));
    }
    let has_numbers = planes.iter().all(|plane| plane.keys.temporal.or(plane.keys.trigger).is_some());
    if !has_numbers && least > 1 {
        notes.push("pictures at one place are taken for time points, in the order of their numbers".into());
    }
    vec![Stack { times, part, notes }]
}

fn in_time(group: &[Plane]) -> Vec<Plane> {
    let mut ordered = group.to_vec();
    let key = |plane: &Plane| {
        let Keys { temporal, trigger, acquisition, .. } = plane.keys;
        [temporal, trigger, acquisition, plane.instance].map(|number| number.unwrap_or(f64::MAX))
    };
    ordered.sort_by(|a, b| {
        let orders = key(a).into_iter().zip(key(b)).map(|(a, b)| a.total_cmp(&b));
        orders.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    });
    ordered
}

/// One stack for each acquisition, if none of them has two pictures at one place.
fn by_acquisition(planes: &[Plane], part: &str) -> Option<Vec<Stack>> {
    let mut numbers: Vec<f64> = planes.iter().map(|plane| plane.keys.acquisition).collect::<Option<_>>()?;
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let stacks: Vec<Stack> = numbers
        .into_iter()
        .map(|number| {
            let of = |plane: &&Plane| plane.keys.acquisition == Some(number);
            let group: Vec<Plane> = planes.iter().filter(of).cloned().collect();
            let name = format!("acquisition {number}");
            let part = if part.is_empty() { name } else { format!("{part}, {name}") };
            Stack { times: vec![group], part, notes: Vec::new() }
        })
        .collect();
    stacks.iter().all(|stack| by_place(&stack.times[0]).len() == stack.depth()).then_some(stacks)
}
