//! Sorts the pictures of a series into stacks.

use super::header::Header;
use super::plane::{Keys, Plane};
use super::repeats;
use super::stack::Stack;

/// A step between slices that is so many times the usual one separates stacks.
const BREAK: f64 = 10.0;

/// The stacks that `planes` make. All are of one series and layout.
pub fn stacks(headers: &[Header], planes: Vec<Plane>) -> Vec<Stack> {
    let mut stacks = Vec::new();
    for (number, mut group) in parallel(planes).into_iter().enumerate() {
        sort(&mut group);
        let mut found = repeats::resolved(headers, group);
        if number > 0 || found.len() > 1 {
            name_parts(&mut found, number);
        }
        stacks.append(&mut found);
    }
    let mut whole = Vec::new();
    stacks.into_iter().for_each(|stack| broken(stack, &mut whole));
    whole
}

fn name_parts(stacks: &mut [Stack], number: usize) {
    for stack in stacks.iter_mut().filter(|stack| stack.part.is_empty()) {
        stack.part = format!("direction {}", number + 1);
    }
}

/// Splits planes by direction and by distance of pixels, and localizers from others.
fn parallel(planes: Vec<Plane>) -> Vec<Vec<Plane>> {
    let mut groups: Vec<Vec<Plane>> = Vec::new();
    for plane in planes {
        match groups.iter_mut().find(|group| is_alike(&group[0], &plane)) {
            Some(group) => group.push(plane),
            None => groups.push(vec![plane]),
        }
    }
    groups
}

fn is_alike(a: &Plane, b: &Plane) -> bool {
    let is_near = |axis: usize| (a.spacing[axis] - b.spacing[axis]).abs() <= 1e-3 * a.spacing[axis];
    let is_parallel = match (&a.place, &b.place) {
        (Some(a), Some(b)) => a.is_parallel(b),
        (None, None) => true,
        _ => false,
    };
    let is_localizer = |keys: &Keys| keys.image_type.contains("LOCALIZER");
    is_parallel && is_near(0) && is_near(1) && is_localizer(&a.keys) == is_localizer(&b.keys)
}

/// Sorts planes along the normal; without positions by the number that the scanner gave.
fn sort(planes: &mut [Plane]) {
    let reference = planes.first().and_then(|plane| plane.place);
    planes.sort_by(|a, b| {
        let by_place = match reference {
            Some(reference) => {
                let height =
                    |plane: &Plane| plane.place.map_or(0.0, |place| place.position.dot(reference.normal()));
                height(a).total_cmp(&height(b))
            }
            None => std::cmp::Ordering::Equal,
        };
        let instance = |plane: &Plane| plane.instance.unwrap_or(f64::MAX);
        by_place.then(instance(a).total_cmp(&instance(b))).then((a.file, a.frame).cmp(&(b.file, b.frame)))
    });
}

/// Splits a stack where slices lie too far apart to be one.
fn broken(stack: Stack, out: &mut Vec<Stack>) {
    let heights: Vec<f64> = stack.times[0].iter().filter_map(|plane| Some(plane.place?.height())).collect();
    let steps: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&steps);
    let breaks = (1..stack.depth()).filter(|&slice| {
        usual.is_some_and(|usual| {
            steps.len() >= 3 && steps.get(slice - 1).is_some_and(|&step| step > BREAK * usual)
        })
    });
    let ends: Vec<usize> = breaks.chain([stack.depth()]).collect();
    if ends.len() == 1 || heights.len() != stack.depth() {
        out.push(stack);
        return;
    }
    let mut start = 0;
    for (number, end) in ends.into_iter().enumerate() {
        let times = stack.times.iter().map(|planes| planes[start..end].to_vec()).collect();
        let part = [stack.part.as_str(), &format!("part {} along the normal", number + 1)];
        let part = part.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
        out.push(Stack { times, part, notes: stack.notes.clone() });
        start = end;
    }
}

/// The median of `values`; none of no values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
