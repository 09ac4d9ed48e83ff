//! Section of the report: text, tables and figures, as files that other programs can read.

use anyhow::{Context, Result};
use fovolnet::core::Frame;
use fovolnet::io::atomic;
use fovolnet::io::image::{self, Alpha};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Reproduction of one table or figure of the paper.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Section {
    /// Name on the command line.
    pub name: String,
    pub title: String,
    /// Description: contents, method, and differences from the paper with their reasons.
    pub text: Vec<String>,
    pub tables: Vec<Table>,
    pub figures: Vec<Figure>,
    /// Time to make the section, in seconds.
    pub seconds: f64,
    pub machine: serde_json::Value,
}

/// Table with named columns.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Table {
    /// Name of the CSV file, without `.csv`.
    pub name: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
    /// Whether the report shows the table. Data of a drawing are in the file only.
    pub is_shown: bool,
}

/// Cell of a table: a number or text.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    Number(f64),
    Words(String),
}

impl From<f64> for Cell {
    /// JSON has no other numbers than finite ones: `inf` and `NaN` are words.
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Words(number.to_string()) }
    }
}

impl From<Option<f64>> for Cell {
    /// Empty text for a missing number, as readers of CSV expect.
    fn from(number: Option<f64>) -> Self {
        number.map_or_else(|| "".into(), Self::from)
    }
}

impl From<&str> for Cell {
    fn from(words: &str) -> Self {
        Self::Words(words.into())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl std::fmt::Display for Cell {
    /// Formats numbers with four significant digits.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Words(words) => f.write_str(words),
            Self::Number(number) if *number == 0.0 => f.write_str("0"),
            Self::Number(number) => {
                let whole = number.abs().log10().floor() as i32 + 1;
                write!(f, "{number:.*}", (4 - whole).clamp(0, 4) as usize)
            }
        }
    }
}

/// Picture or film in a file beside the report.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Figure {
    /// Name of the file.
    pub file: String,
    pub caption: String,
    /// Contents of the file, until it is written. `None` for a film, which is written while it is rendered.
    #[serde(skip)]
    pub picture: Option<Picture>,
}

#[derive(Debug, Clone)]
pub enum Picture {
    /// SVG drawing.
    Svg(String),
    /// Pixel image.
    Frame(Frame),
}

impl Section {
    pub fn new(title: &str, text: &[&str]) -> Self {
        Self {
            title: title.into(),
            text: text.iter().map(|line| (*line).into()).collect(),
            ..Self::default()
        }
    }

    /// Adds a table of `rows`, also written as `NAME.csv`.
    pub fn table(&mut self, name: &str, columns: &[&str], rows: Vec<Vec<Cell>>) {
        let columns = columns.iter().map(|column| (*column).into()).collect();
        self.tables.push(Table { name: name.into(), columns, rows, is_shown: true });
    }

    /// Adds a table of `rows` that is only written as `NAME.csv`, such as the data of a drawing.
    pub fn data(&mut self, name: &str, columns: &[&str], rows: Vec<Vec<Cell>>) {
        self.table(name, columns, rows);
        self.tables.last_mut().expect("it was just added").is_shown = false;
    }

    /// Adds a drawing, written as `NAME.svg`.
    pub fn drawing(&mut self, name: &str, caption: &str, svg: String) {
        let picture = Some(Picture::Svg(svg));
        self.figures.push(Figure { file: format!("{name}.svg"), caption: caption.into(), picture });
    }

    /// Adds a picture, written as `NAME.png`.
    pub fn picture(&mut self, name: &str, caption: &str, frame: Frame) {
        let picture = Some(Picture::Frame(frame));
        self.figures.push(Figure { file: format!("{name}.png"), caption: caption.into(), picture });
    }

    /// Adds the film `file`, which is already in the section's folder.
    pub fn film(&mut self, file: &str, caption: &str) {
        self.figures.push(Figure { file: file.into(), caption: caption.into(), picture: None });
    }

    /// Writes all files of the section to a folder of its name in `folder`.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let folder = folder.join(&self.name);
        atomic::make_folder(&folder)?;
        for table in &self.tables {
            let mut csv = csv::Writer::from_writer(Vec::new());
            csv.write_record(&table.columns)?;
            for row in &table.rows {
                csv.serialize(row)?;
            }
            atomic::write_bytes(&folder.join(format!("{}.csv", table.name)), &csv.into_inner()?)?;
        }
        for figure in &self.figures {
            let path = folder.join(&figure.file);
            match &figure.picture {
                Some(Picture::Svg(svg)) => atomic::write_bytes(&path, svg.as_bytes())?,
                Some(Picture::Frame(frame)) => image::write_png(&path, frame, Alpha::Drop)?,
                None => {}
            }
        }
        let facts = serde_json::to_vec_pretty(self)?;
        atomic::write_bytes(&folder.join("section.json"), &facts)?;
        Ok(())
    }

    /// Reads the section `name` in `folder`; `None` if it does not exist.
    pub fn read(folder: &Path, name: &str) -> Result<Option<Self>> {
        let path = folder.join(name).join("section.json");
        if !path.exists() {
            return Ok(None);
        }
        let mend =
            || format!("{} cannot be read; make it again with `fovolnet repro {name}`", path.display());
        let text = std::fs::read_to_string(&path).with_context(mend)?;
        Ok(Some(serde_json::from_str(&text).with_context(mend)?))
    }

    /// Tables that the report shows.
    pub fn shown(&self) -> impl Iterator<Item = &Table> {
        self.tables.iter().filter(|table| table.is_shown)
    }

    /// Tables as lines of text.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for table in self.shown() {
            let mut rows = vec![table.columns.clone()];
            rows.extend(table.rows.iter().map(|row| row.iter().map(ToString::to_string).collect()));
            let wide = |column: usize| rows.iter().map(|row: &Vec<String>| row[column].chars().count()).max();
            let widths: Vec<usize> =
                (0..table.columns.len()).map(|column| wide(column).unwrap_or(0)).collect();
            let line = |row: &Vec<String>| {
                let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
                cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
            };
            lines.extend(rows.iter().map(line));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_figures() {
        let shown = [12345.6, 123.45, 1.23456, 0.012345, 0.0, -3.5].map(|v| Cell::from(v).to_string());
        assert_eq!(shown, ["12346", "123.5", "1.235", "0.0123", "0", "-3.500"]);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut section = Section::new("A title", &["words"]);
        section.name = "one".into();
        section.table("numbers", &["name", "value"], vec![vec!["a, \"b\"".into(), 0.5.into()]]);
        section.drawing("plot", "a plot", "<svg/>".into());
        section.write(folder.path()).unwrap();
        let csv = std::fs::read_to_string(folder.path().join("one/numbers.csv")).unwrap();
        assert_eq!(csv, "name,value\n\"a, \"\"b\"\"\",0.5\n");
        let read = Section::read(folder.path(), "one").unwrap().unwrap();
        assert_eq!((read.title, read.figures.len()), ("A title".into(), 1));
        assert_eq!(read.tables[0].rows[0][1].to_string(), "0.5000");
        assert!(Section::read(folder.path(), "two").unwrap().is_none());
    }
}
