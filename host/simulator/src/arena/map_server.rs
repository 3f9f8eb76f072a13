//! Maps of the Robot Operating System's `map_server`: a YAML file that names an image.
//!
//! A map becomes an arena whose lower left corner is the image's; `origin`, which places the map in
//! a robot's own frame, only has to be well-formed. What is not known to be free is an obstacle: a
//! robot could neither be placed nor be judged in the unknown. A map alone has random starts and
//! goals; an arena file can name a map and say where they are (`map = "map.yaml"`).

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use serde::Deserialize;

use super::error::ArenaError;
use super::files::Files;
use super::grid::OccupancyGrid;

/// Largest map: 4096 by 4096 cells.
const LARGEST_SIDE: u32 = 4096;

/// Bytes of the largest image: as text a pixel takes up to four, and 16-bit ones two more.
pub(super) const LARGEST_FILE: u64 = 8 * LARGEST_SIDE as u64 * LARGEST_SIDE as u64;

/// Scalars, lists and so on of a map's file, with what its aliases repeat.
const MOST_EVENTS: usize = 10_000;

/// A cell is at most this large, in metres.
const LARGEST_RESOLUTION: f64 = 10.0;

/// The YAML file. Other keys are ignored, as `map_server` does.
#[derive(Deserialize)]
struct MapEntry {
    image: PathBuf,
    resolution: f64,
    origin: [f64; 3],
    negate: Negate,
    occupied_thresh: f64,
    free_thresh: f64,
    #[serde(default)]
    mode: Mode,
}

/// `map_saver` writes a number, other tools a truth value.
#[derive(Deserialize)]
#[serde(untagged)]
enum Negate {
    Flag(bool),
    Number(u8),
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    /// Free, occupied or unknown, by the thresholds.
    #[default]
    Trinary,
    /// The same, with shades between: here as good as unknown.
    Scale,
    /// Pixels are percentages of occupancy; above 100 is unknown.
    Raw,
}

/// Reads a map and its image.
pub(super) fn load(path: &Path, files: &mut Files) -> Result<OccupancyGrid, ArenaError> {
    let entry = parse(path, &files.text(path)?)?;
    let image = path.parent().unwrap_or(Path::new("")).join(&entry.image);
    entry.grid(&image, &files.bytes(&image)?)
}

impl MapEntry {
    fn grid(&self, image: &Path, bytes: &[u8]) -> Result<OccupancyGrid, ArenaError> {
        let (columns, pixels) = pixels(image, bytes)?;
        // Images run from the top, arenas from below.
        let rows = pixels.chunks_exact(columns).rev();
        let occupied = rows.flatten().map(|pixel| !self.is_free(*pixel)).collect();
        // Metres per pixel to centimetres per cell.
        Ok(OccupancyGrid::new(
            columns,
            self.resolution * 100.0,
            occupied,
        ))
    }

    fn is_free(&self, pixel: u8) -> bool {
        let occupancy = match self.mode {
            Mode::Raw if pixel > 100 => return false,
            Mode::Raw => f64::from(pixel) / 100.0,
            Mode::Trinary | Mode::Scale if self.negated() => f64::from(pixel) / 255.0,
            Mode::Trinary | Mode::Scale => f64::from(255 - pixel) / 255.0,
        };
        occupancy < self.free_thresh
    }

    fn negated(&self) -> bool {
        matches!(self.negate, Negate::Flag(true) | Negate::Number(1))
    }
}

fn parse(path: &Path, text: &str) -> Result<MapEntry, ArenaError> {
    let problem = |problem: String| ArenaError::file(path, problem);
    // A map has some ten lines: aliases that multiply a small file's contents are refused.
    let options = serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_events: MOST_EVENTS,
            max_recorded_anchor_events: MOST_EVENTS,
        },
        alias_limits: serde_saphyr::alias_limits! {
            max_total_replayed_events: MOST_EVENTS,
        },
    };
    let read = serde_saphyr::from_str_with_options(text, options);
    let entry: MapEntry = read.map_err(|error| {
        let line = error.location().map(|at| at.line() as usize);
        let text = error.without_snippet().to_string().replace('\n', "; ");
        match line {
            Some(line) => ArenaError::line(path, line, text),
            None => problem(text),
        }
    })?;
    if !(entry.resolution > 0.0 && entry.resolution <= LARGEST_RESOLUTION) {
        return Err(problem(format!(
            "`resolution` is {}, but must be above 0 and at most {LARGEST_RESOLUTION} m per pixel",
            entry.resolution
        )));
    }
    if !entry.origin.iter().all(|value| value.is_finite()) {
        return Err(problem(
            "`origin` must be three finite numbers: x, y and yaw".to_owned(),
        ));
    }
    let (free, occupied) = (entry.free_thresh, entry.occupied_thresh);
    if !(0.0 < free && free <= occupied && occupied <= 1.0) {
        return Err(problem(format!(
            "`free_thresh` is {free} and `occupied_thresh` {occupied}, but they must be above 0, \
             at most 1, and the first no greater than the second"
        )));
    }
    if let Negate::Number(n @ 2..) = entry.negate {
        return Err(problem(format!("`negate` is {n}, but must be 0 or 1")));
    }
    Ok(entry)
}

/// The width of an image, and its pixels from the top left, 0 = black.
fn pixels(path: &Path, bytes: &[u8]) -> Result<(usize, Vec<u8>), ArenaError> {
    let problem = |problem: String| ArenaError::file(path, problem);
    let not_an_image = |error| {
        problem(format!(
            "not a PGM image of at most {LARGEST_SIDE} by {LARGEST_SIDE} pixels: {error}"
        ))
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Pnm);
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(not_an_image)?;
    let (width, height) = decoder.dimensions();
    // No more room is taken than for what can be there: the least that a pixel takes is a bit.
    if u64::from(width) * u64::from(height) > 8 * bytes.len() as u64 {
        return Err(problem(format!(
            "the image is cut off: {width} by {height} pixels do not fit into {} bytes",
            bytes.len()
        )));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(not_an_image)?;
    let grey = image.into_luma8();
    if grey.width() == 0 || grey.height() == 0 {
        return Err(problem("the image has no pixels".to_owned()));
    }
    Ok((grey.width() as usize, grey.into_raw()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const YAML: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\n\
        occupied_thresh: 0.65\nfree_thresh: 0.196\n";

    /// 3 by 2 pixels: black, unknown grey, white above; white, light grey, white below.
    const PLAIN: &[u8] = b"P2\n# made by hand\n3 2\n255\n0 205 254\n254 215 255\n";
    const RAW: &[u8] = b"P5\n3 2\n255\n\x00\xCD\xFE\xFE\xD7\xFF";

    fn loaded(yaml: &str, image: &[u8]) -> Result<OccupancyGrid, ArenaError> {
        let mut read = |path: &Path| match path.to_str() {
            Some("maps/map.yaml") => Ok(yaml.into()),
            Some("maps/map.pgm") => Ok(image.into()),
            _ => Err(std::io::ErrorKind::NotFound.into()),
        };
        load(Path::new("maps/map.yaml"), &mut Files(&mut read))
    }

    /// Rows from below, `#` = occupied.
    fn picture(yaml: &str, image: &[u8]) -> Vec<String> {
        let grid = loaded(yaml, image).expect("a valid map");
        let cell = |column, row| {
            if grid.is_occupied(column, row) {
                '#'
            } else {
                '.'
            }
        };
        (0..grid.rows())
            .map(|row| (0..grid.columns()).map(|c| cell(c, row)).collect())
            .collect()
    }

    #[test]
    fn plain_and_raw_images_give_the_same_map() {
        for image in [PLAIN, RAW] {
            // What is not known to be free (205: occupancy 0.196) counts as occupied.
            assert_eq!(picture(YAML, image), ["...", "##."]);
        }
        assert_eq!(loaded(YAML, RAW).expect("a valid map").cell_cm(), 5.0);
    }

    #[test]
    fn images_with_other_white_values_are_scaled() {
        let image = b"P2\n3 1\n100\n0 50 100\n";
        assert_eq!(picture(YAML, image), ["##."]);
    }

    #[test]
    fn thresholds_negate_and_mode_are_followed() {
        let strict = YAML.replace("0.196", "0.1");
        assert_eq!(picture(&strict, RAW), [".#.", "##."]);
        let negated = YAML.replace("negate: 0", "negate: 1");
        assert_eq!(picture(&negated, RAW), ["###", ".##"]);
        assert_eq!(
            picture(&negated.replace("negate: 1", "negate: true"), RAW),
            ["###", ".##"]
        );
        // Raw pixels are percentages: 0 and 10 are free, 50 is not, 120 is unknown.
        let raw = format!("{YAML}mode: raw\n");
        assert_eq!(picture(&raw, b"P2\n4 1\n255\n0 10 50 120\n"), ["..##"]);
        assert_eq!(
            picture(&format!("{YAML}mode: scale\n"), RAW),
            ["...", "##."]
        );
    }

    #[test]
    fn aliases_that_multiply_are_refused() {
        let mut yaml = String::from("a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n");
        for level in 1..9 {
            let before = format!("*a{}", level - 1);
            let list = vec![before; 10].join(", ");
            yaml.push_str(&format!("a{level}: &a{level} [{list}]\n"));
        }
        loaded(&(yaml + YAML), RAW).expect_err("a billion scalars");
    }

    #[test]
    fn what_is_wrong_with_a_map_is_said() {
        let table: [(&str, &str, &[&str]); 11] = [
            (
                "resolution: 0.05",
                "resolution: 0",
                &["map.yaml", "`resolution`"],
            ),
            (
                "resolution: 0.05",
                "resolution: .nan",
                &["map.yaml", "`resolution`"],
            ),
            (
                "resolution: 0.05",
                "resolution: fine",
                &["map.yaml, line 2", "floating point"],
            ),
            ("resolution: 0.05\n", "", &["map.yaml", "resolution"]),
            ("0.65", "1.5", &["`occupied_thresh`", "1.5"]),
            ("0.196", "0.7", &["`free_thresh`", "0.7"]),
            ("negate: 0", "negate: 2", &["`negate`", "0 or 1"]),
            ("[-1.0, -2.0, 0.0]", "[-1.0, .inf, 0.0]", &["`origin`"]),
            ("[-1.0, -2.0, 0.0]", "[-1.0]", &["map.yaml"]),
            ("map.pgm", "other.pgm", &["other.pgm", "read"]),
            (
                "0.196\n",
                "0.196\nmode: fancy\n",
                &["map.yaml, line 7", "fancy"],
            ),
        ];
        for (from, to, words) in table {
            let error = loaded(&YAML.replace(from, to), RAW)
                .expect_err(to)
                .to_string();
            assert!(
                words.iter().all(|word| error.contains(word)),
                "{to:?}: {error}"
            );
            assert!(!error.contains('\n'), "{to:?}: {error}");
        }
        for image in [
            &b"P5\n3 2\n255\n\x00\x01"[..],
            b"GIF89a",
            b"",
            b"P5\n9999 9999\n255\n",
        ] {
            let error = loaded(YAML, image).expect_err("no image").to_string();
            assert!(
                error.contains("map.pgm") && error.contains("PGM"),
                "{error}"
            );
        }
    }
}
