//! Series: which there are, and which one is read.

use super::header::Header;
use super::plane::Plane;
use super::segmentation;
use super::stack::Stack;
use super::stacks::stacks;
use super::text::shown;

/// One volume that can be read from files of DICOM.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Series {
    /// Identifier of the series. Several volumes may have one.
    pub uid: String,
    /// The words of whoever made it.
    pub description: String,
    /// Kind of scanner: CT, MR, PT…
    pub modality: String,
    /// Columns, rows and slices.
    pub dims: [usize; 3],
    /// Number of time points.
    pub times: usize,
    /// What tells it apart from other volumes with the same identifier; empty where there are none.
    pub part: String,
}

/// A series with its pictures.
pub struct Candidate {
    /// What is told of it.
    pub series: Series,
    /// The pictures.
    pub stack: Stack,
}

/// All volumes that `headers` make, by identifier.
pub fn candidates(headers: &[Header]) -> Vec<Candidate> {
    let mut groups: Vec<(usize, Vec<Plane>)> = Vec::new();
    for (number, header) in headers.iter().enumerate() {
        let planes = header.planes.iter().map(|plane| Plane { file: number, ..plane.clone() });
        match groups.iter_mut().find(|(first, _)| is_together(&headers[*first], header)) {
            Some((_, group)) => group.extend(planes),
            None => groups.push((number, planes.collect())),
        }
    }
    groups.sort_by(|(a, _), (b, _)| headers[*a].series.cmp(&headers[*b].series));
    let made = groups.into_iter().flat_map(|(first, planes)| {
        let header = &headers[first];
        let stacks = match &header.segments {
            Some(segments) => segmentation::stacks(segments, planes),
            None => stacks(headers, planes),
        };
        stacks.into_iter().filter(|stack| stack.depth() > 0).map(|stack| candidate(header, stack))
    });
    made.collect()
}

/// Whether the pictures of two files may be of one volume. Segmentations stand alone.
fn is_together(a: &Header, b: &Header) -> bool {
    a.series == b.series && a.format == b.format && a.segments.is_none() && b.segments.is_none()
}

fn candidate(header: &Header, stack: Stack) -> Candidate {
    let [columns, rows] = header.format.size;
    let depth = if header.segments.is_some() { segmentation::depth(header, &stack) } else { stack.depth() };
    let series = Series {
        uid: header.series.clone(),
        description: header.description.clone(),
        modality: header.modality.clone(),
        dims: [columns, rows, depth],
        times: stack.times.len(),
        part: stack.part.clone(),
    };
    Candidate { series, stack }
}

/// The number of the series to read of `candidates`, which are not empty: the `chosen` one, else that with most slices.
///
/// # Errors
/// A choice that is not there, in words.
pub fn select(candidates: &[Candidate], chosen: Option<&str>) -> Result<usize, String> {
    let Some(chosen) = chosen else { return Ok(largest(candidates, |_| true).unwrap_or(0)) };
    if let Some(number) = largest(candidates, |series| series.uid == chosen) {
        return Ok(number);
    }
    let number = chosen.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
    number.filter(|&number| number < candidates.len()).ok_or_else(|| {
        format!("--series {} is not there; it has {}", chosen.escape_debug(), listed(candidates, None))
    })
}

/// The first of the series with most slices, among those that are `wanted`; segmentations only where nothing else is.
fn largest(candidates: &[Candidate], wanted: impl Fn(&Series) -> bool) -> Option<usize> {
    let depth = |number: usize| {
        let series = &candidates[number].series;
        (series.modality != "SEG", series.dims[2] * series.times)
    };
    let among = (0..candidates.len()).filter(|&number| wanted(&candidates[number].series));
    among.fold(None, |best: Option<usize>, number| match best {
        Some(best) if depth(best) >= depth(number) => Some(best),
        _ => Some(number),
    })
}

/// Longest list of series in a message.
const LISTED: usize = 8;

/// The series but for number `without`, with their numbers, in one line.
pub fn listed(candidates: &[Candidate], without: Option<usize>) -> String {
    let others: Vec<usize> = (0..candidates.len()).filter(|&number| Some(number) != without).collect();
    let mut words: Vec<String> = others
        .iter()
        .take(LISTED)
        .map(|&number| format!("{}: {}", number + 1, candidates[number].series))
        .collect();
    if others.len() > LISTED {
        words.push("…".into());
    }
    words.join("; ")
}

impl std::fmt::Display for Series {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.dims;
        write!(f, "{} {x}x{y}x{z}", shown(&self.modality, 16))?;
        if self.times > 1 {
            write!(f, " at {} times", self.times)?;
        }
        let words = [&self.description, &self.part].map(|text| shown(text, 64));
        words.iter().filter(|text| !text.is_empty()).try_for_each(|text| write!(f, " ({text})"))
    }
}
