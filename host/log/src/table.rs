//! Drives recorded by others, as CSV: one row a sample, one column a sensor.

use std::path::Path;

use rover_shared::sensing::Sample;
use rover_shared::units::{Microdegrees, Micrometres};

/// What a column can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Seconds since some moment.
    Time,
    /// Free distance ahead.
    Front,
    /// Free distance ahead, of the left one of two front sensors.
    FrontLeft,
    /// Free distance ahead, of the right one of two front sensors.
    FrontRight,
    /// Free distance on the left.
    Left,
    /// Free distance on the right.
    Right,
    /// Compass heading, clockwise.
    Heading,
}

/// All roles with their names in `--columns` and the columns they have by default.
const ROLES: [(Role, &str, Option<&str>); 7] = [
    (Role::Time, "time", Some("t_s")),
    (Role::Front, "front", None),
    (Role::FrontLeft, "front_left", Some("front_left_cm")),
    (Role::FrontRight, "front_right", Some("front_right_cm")),
    (Role::Left, "left", Some("left_cm")),
    (Role::Right, "right", Some("right_cm")),
    (Role::Heading, "heading", Some("heading_deg")),
];

/// Units, by the ending of a column's name, with the factor to centimetres, degrees or seconds.
const UNITS: [(&str, Quantity, f64); 7] = [
    ("_cm", Quantity::Length, 1.0),
    ("_mm", Quantity::Length, 0.1),
    ("_m", Quantity::Length, 100.0),
    ("_deg", Quantity::Angle, 1.0),
    ("_rad", Quantity::Angle, 180.0 / std::f64::consts::PI),
    ("_s", Quantity::Time, 1.0),
    ("_ms", Quantity::Time, 1e-3),
];

/// The longest distance a sensor can have measured: beyond any that robots carry.
const FARTHEST_CM: f64 = 100_000.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Length,
    Angle,
    Time,
}

impl Role {
    fn quantity(self) -> Quantity {
        match self {
            Self::Time => Quantity::Time,
            Self::Heading => Quantity::Angle,
            _ => Quantity::Length,
        }
    }
}

/// Which column holds what, and in which unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns(Vec<Column>);

#[derive(Clone, Debug, PartialEq)]
struct Column {
    role: Role,
    name: String,
    factor: f64,
}

impl Default for Columns {
    fn default() -> Self {
        let columns = ROLES.iter().filter_map(|&(role, _, name)| {
            let name = name?;
            let (_, factor) = unit(name)?;
            Some(Column {
                role,
                name: name.into(),
                factor,
            })
        });
        Self(columns.collect())
    }
}

impl std::str::FromStr for Columns {
    type Err = String;

    /// Reads `front=front_m,left=left_m,...`: role = column. The ending of the column's name tells
    /// its unit.
    fn from_str(text: &str) -> Result<Self, String> {
        let columns: Vec<Column> = text
            .split(',')
            .map(parse_column)
            .collect::<Result<_, _>>()?;
        let has = |role| columns.iter().any(|column| column.role == role);
        let count = |role| columns.iter().filter(|column| column.role == role).count();
        if let Some((_, name, _)) = ROLES.iter().find(|(role, _, _)| count(*role) > 1) {
            return Err(format!("{name} is given twice, expected one column for it"));
        }
        if has(Role::Front) && (has(Role::FrontLeft) || has(Role::FrontRight)) {
            return Err("expected either front, or front_left and front_right".into());
        }
        let front = has(Role::Front) || has(Role::FrontLeft) && has(Role::FrontRight);
        if !(front && has(Role::Left) && has(Role::Right)) {
            return Err(
                "expected columns for front (or front_left and front_right), left and right".into(),
            );
        }
        Ok(Self(columns))
    }
}

fn parse_column(text: &str) -> Result<Column, String> {
    let names = || ROLES.map(|(_, name, _)| name).join(", ");
    let (role, name) = text
        .split_once('=')
        .ok_or_else(|| format!("\"{text}\": expected ROLE=COLUMN, ROLE one of {}", names()))?;
    let &(role, _, _) = ROLES
        .iter()
        .find(|(_, known, _)| *known == role.trim())
        .ok_or_else(|| format!("\"{role}\" is not a role, expected one of {}", names()))?;
    let name = name.trim();
    match unit(name) {
        Some((quantity, factor)) if quantity == role.quantity() => Ok(Column {
            role,
            name: name.into(),
            factor,
        }),
        _ => {
            let endings = UNITS
                .iter()
                .filter(|(_, quantity, _)| *quantity == role.quantity());
            let endings: Vec<_> = endings.map(|(ending, _, _)| *ending).collect();
            Err(format!(
                "column \"{name}\": expected a name that ends in {}",
                endings.join(" or ")
            ))
        }
    }
}

fn unit(name: &str) -> Option<(Quantity, f64)> {
    let matching = UNITS.iter().filter(|(ending, _, _)| name.ends_with(ending));
    // "_mm" also ends in "m" but not in "_m": endings exclude one another.
    matching
        .map(|&(_, quantity, factor)| (quantity, factor))
        .next()
}

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Seconds, or the row's number if there is no such column.
    pub t_s: f64,
    /// What was sensed; heading 0 if there is no such column.
    pub sample: Sample,
}

/// A recorded drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Its rows, in order.
    pub rows: Vec<Row>,
    /// Whether it has headings.
    pub has_heading: bool,
}

/// Why a table cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// It cannot be read.
    #[error("{0}: cannot be read: {1}")]
    Io(String, csv::Error),
    /// Columns are missing.
    #[error(
        "{path}: line 1: column {missing} is missing, found {found}; name the columns with --columns ROLE=COLUMN,..."
    )]
    Missing {
        /// The file.
        path: String,
        /// The columns that are missing.
        missing: String,
        /// The columns there are.
        found: String,
    },
    /// A row is not one.
    #[error("{path}: line {line}: {problem}")]
    Row {
        /// The file.
        path: String,
        /// The line, from 1.
        line: u64,
        /// What is wrong and what was expected.
        problem: String,
    },
    /// There are no rows.
    #[error("{0}: has no samples, expected at least one line below the column names")]
    Empty(String),
}

impl Drive {
    /// Reads a CSV file whose first line names the columns.
    ///
    /// # Errors
    /// [`TableError`], which names file, line, and what was expected.
    pub fn read(path: &Path, columns: &Columns) -> Result<Self, TableError> {
        let name = path.display().to_string();
        match std::fs::File::open(path) {
            Ok(file) => Self::from_csv(name, file, columns),
            Err(error) => Err(TableError::Io(name, error.into())),
        }
    }

    /// Reads CSV from anywhere; `name` is for errors.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_csv(
        name: String,
        csv: impl std::io::Read,
        columns: &Columns,
    ) -> Result<Self, TableError> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(csv);
        let header = reader
            .headers()
            .map_err(|e| TableError::Io(name.clone(), e))?
            .clone();
        let places = columns.find(&header, &name)?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let (line, row) = match record {
                Ok(record) => {
                    let line = record.position().map_or(0, csv::Position::line);
                    (line, columns.row(&places, &record, rows.len()))
                }
                Err(error) => {
                    let line = error.position().map_or(0, csv::Position::line);
                    (line, Err(shape_problem(&error)))
                }
            };
            let path = || name.clone();
            rows.push(row.map_err(|problem| TableError::Row {
                path: path(),
                line,
                problem,
            })?);
        }
        if rows.is_empty() {
            return Err(TableError::Empty(name));
        }
        let has_heading = columns.0.iter().any(|column| column.role == Role::Heading);
        Ok(Self { rows, has_heading })
    }
}

fn shape_problem(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => {
            format!("{len} values, expected {expected_len} as in the first line")
        }
        csv::ErrorKind::Utf8 { .. } => "not text, expected UTF-8".into(),
        _ => format!("cannot be read: {error}"),
    }
}

impl Columns {
    /// Where each column stands.
    fn find(&self, header: &csv::StringRecord, path: &str) -> Result<Vec<usize>, TableError> {
        let place = |column: &Column| header.iter().position(|name| name == column.name);
        let missing: Vec<_> = self
            .0
            .iter()
            .filter(|c| place(c).is_none())
            .map(|c| c.name.as_str())
            .collect();
        if missing.is_empty() {
            return Ok(self.0.iter().filter_map(place).collect());
        }
        Err(TableError::Missing {
            path: path.into(),
            missing: missing.join(", "),
            found: header.iter().collect::<Vec<_>>().join(", "),
        })
    }

    fn row(
        &self,
        places: &[usize],
        record: &csv::StringRecord,
        number: usize,
    ) -> Result<Row, String> {
        let nothing_seen = Micrometres(u32::MAX);
        let mut row = Row {
            t_s: number as f64,
            sample: Sample {
                front: nothing_seen,
                left: nothing_seen,
                right: nothing_seen,
                heading: Microdegrees(0),
                target_bearing: None,
            },
        };
        for (column, &place) in self.0.iter().zip(places) {
            let value = column.value(record.get(place).unwrap_or_default())?;
            let length = Micrometres((value * 1e4).round() as u32);
            match column.role {
                Role::Time => row.t_s = value,
                Role::Front | Role::FrontLeft | Role::FrontRight => {
                    row.sample.front = row.sample.front.min(length);
                }
                Role::Left => row.sample.left = length,
                Role::Right => row.sample.right = length,
                // Compasses count clockwise, the core counter-clockwise.
                Role::Heading => {
                    row.sample.heading = Microdegrees::wrapped(-(value * 1e6).round() as i64);
                }
            }
        }
        Ok(row)
    }
}

impl Column {
    /// The value in centimetres, degrees or seconds.
    fn value(&self, text: &str) -> Result<f64, String> {
        let (least, most, what) = match self.role.quantity() {
            Quantity::Length => (0.0, FARTHEST_CM, "a distance from 0 to 1 km"),
            Quantity::Angle => (0.0, 360.0, "a heading from 0 to 360 degrees"),
            Quantity::Time => (0.0, f64::MAX, "a time of at least 0 s"),
        };
        let name = &self.name;
        let value = text.parse::<f64>().map(|value| value * self.factor);
        match value {
            Ok(value) if value >= least && value <= most => Ok(value),
            _ => Err(format!("{name} is \"{text}\", expected {what}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, columns: &str) -> Result<Drive, TableError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive.csv");
        std::fs::write(&path, text).unwrap();
        let columns = match columns {
            "" => Columns::default(),
            text => text.parse().unwrap(),
        };
        Drive::read(&path, &columns)
    }

    const HEADER: &str = "t_s,front_left_cm,front_right_cm,left_cm,right_cm,heading_deg\n";

    #[test]
    fn the_shorter_front_distance_counts_and_headings_turn_round() {
        let drive = read(&format!("{HEADER}0.5,20,18.5,3,8190,90\n"), "").unwrap();
        let row = drive.rows[0];
        assert_eq!(row.t_s, 0.5);
        assert_eq!(row.sample.front, Micrometres(185_000));
        assert_eq!(row.sample.right, Micrometres(81_900_000));
        assert_eq!(row.sample.heading, Microdegrees::from_degrees(-90));
    }

    #[test]
    fn other_columns_and_units_can_be_named() {
        let drive = read(
            "a_m,b_mm,c_cm\n0.5,30,4\n",
            "front=a_m,left=b_mm,right=c_cm",
        )
        .unwrap();
        let sample = drive.rows[0].sample;
        let um = [sample.front, sample.left, sample.right].map(|distance| distance.0);
        assert_eq!(um, [500_000, 30_000, 40_000]);
        assert!(!drive.has_heading);
    }

    #[test]
    fn bad_values_are_named_with_line_and_expectation() {
        for (row, expected) in [
            (
                "0,NaN,18,3,8,90",
                "front_left_cm is \"NaN\", expected a distance from 0 to 1 km",
            ),
            ("0,-1,18,3,8,90", "front_left_cm is \"-1\""),
            ("0,1,1e9,3,8,90", "front_right_cm is \"1e9\""),
            (
                "0,1,1,3,8,361",
                "heading_deg is \"361\", expected a heading from 0 to 360 degrees",
            ),
            ("0,1,1,3,8,", "heading_deg is \"\""),
            ("0,1,1,3,8", "5 values, expected 6"),
        ] {
            let error = read(&format!("{HEADER}0,1,1,1,1,0\n{row}\n"), "").unwrap_err();
            let text = error.to_string();
            assert!(text.contains("line 3") && text.contains(expected), "{text}");
        }
    }

    #[test]
    fn missing_columns_are_named() {
        let text = read("t_s,left_cm\n0,1\n", "").unwrap_err().to_string();
        assert!(
            text.contains("front_left_cm, front_right_cm, right_cm, heading_deg"),
            "{text}"
        );
        assert!(
            read(HEADER, "")
                .unwrap_err()
                .to_string()
                .contains("no samples")
        );
    }

    #[test]
    fn bad_column_choices_say_what_is_expected() {
        for (text, expected) in [
            ("front", "expected ROLE=COLUMN"),
            ("top=a_cm", "not a role"),
            (
                "left=a_cm,left=b_cm,front=c_cm,right=d_cm",
                "left is given twice",
            ),
            (
                "front=a_cm,front_left=b_cm,left=c_cm,right=d_cm",
                "either front",
            ),
            (
                "front=a_deg,left=b_cm,right=c_cm",
                "ends in _cm or _mm or _m",
            ),
            ("left=b_cm,right=c_cm", "expected columns for front"),
        ] {
            let error = text.parse::<Columns>().unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
