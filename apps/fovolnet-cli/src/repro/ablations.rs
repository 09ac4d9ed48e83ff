//! Table: effect of each part of the method, from `benchmarks/ablations.py`, which trains without it.

use super::evaluation::Evaluation;
use super::section::{Cell, Section};
use anyhow::{Context, Result, ensure};
use fovolnet::core::input;
use std::path::Path;

/// Columns of the file; the last three are numbers.
const COLUMNS: [&str; 6] = ["part", "instead", "steps", "psnr", "ssim", "tpsnr"];

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Ablations",
        &[
            "What the paper tells of without figures: networks a quarter as wide as its own that differ in one thing, trained on \
           the same clips for as many steps and judged by clips of volumes that none has learned from, at 3 % of the pixels. \
           Short runs rank the parts; they do not tell what each would give in the end.",
        ],
    );
    match &evaluation.ablations {
        Some(file) => section.table("ablations", &COLUMNS, rows(file)?),
        None => section.text.push(
            "Training takes hours and needs libtorch, so the table is not made with the others: \
             benchmarks/ablations.py makes ablations.csv, and --ablations FILE shows it here."
                .into(),
        ),
    }
    Ok(section)
}

fn rows(file: &Path) -> Result<Vec<Vec<Cell>>> {
    let mend =
        || format!("{} holds no ablations; make it with `python benchmarks/ablations.py`", file.display());
    let mut reader = csv::Reader::from_reader(input::open(file).with_context(mend)?);
    ensure!(reader.headers().with_context(mend)? == COLUMNS[..], mend());
    let cell = |(column, text): (usize, &str)| match text.parse::<f64>() {
        Ok(number) if column >= COLUMNS.len() - 3 => Cell::from(number),
        _ => Cell::from(text),
    };
    reader.records().map(|row| Ok(row.with_context(mend)?.iter().enumerate().map(cell).collect())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_script_writes_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ablations.csv");
        std::fs::write(
            &file,
            "part,instead,steps,psnr,ssim,tpsnr\nwhole,\"nothing, left out\",3000,30.5,0.9,31\n",
        )
        .unwrap();
        let cells: Vec<String> = rows(&file).unwrap()[0].iter().map(ToString::to_string).collect();
        assert_eq!(cells, ["whole", "nothing, left out", "3000", "30.50", "0.9000", "31.00"]);
        for wrong in ["", "a,b\n1,2\n", "part,instead,steps,psnr,ssim,tpsnr\nwhole\n"] {
            std::fs::write(&file, wrong).unwrap();
            assert!(rows(&file).unwrap_err().to_string().contains("ablations.py"), "{wrong}");
        }
    }
}
