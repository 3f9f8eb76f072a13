//! The shapes that figures are drawn with. Coordinates are pixels from the upper left, rounded to
//! a tenth of one, so that files stay small.

use std::fmt::Write as _;

use rover_shared::perception::PatternCode;
use svg::Document;
use svg::Node as _;
use svg::node::element::{Circle, Description, Group, Line, Path, Rectangle, Text, Title};

/// Ink: text, axes, marks.
pub(super) const INK: &str = "#222222";
/// Text of second rank.
pub(super) const FAINT_INK: &str = "#595959";
/// Grid lines.
pub(super) const GRID: &str = "#e3e3e3";
/// Size of ordinary text.
pub(super) const TEXT_SIZE: f64 = 12.0;

/// Only families that every system has or replaces: nothing is loaded from elsewhere.
const FONTS: &str = "Helvetica, Arial, sans-serif";
/// Height that [`sheet`] takes for title and subtitle.
pub(super) const HEADER: f64 = 58.0;

/// A pixel coordinate as written.
pub(super) fn px(value: f64) -> f64 {
    debug_assert!(value.is_finite(), "nothing is drawn at {value}");
    // The sum makes -0 a plain 0.
    (value * 10.0).round() / 10.0 + 0.0
}

/// A rectangular part of the sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Area {
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// The area of the panel with this number, from 0, of those that stand in two columns; `first` is the
/// upper left corner of the first, `pitch` leads from one to the next.
pub(super) fn panel_area(number: usize, first: [f64; 2], pitch: [f64; 2], size: [f64; 2]) -> Area {
    let (column, row) = ((number % 2) as f64, (number / 2) as f64);
    Area {
        left: first[0] + pitch[0] * column,
        top: first[1] + pitch[1] * row,
        width: size[0],
        height: size[1],
    }
}

/// A group that tests and style sheets can find by its class.
pub(super) fn group(class: &str) -> Group {
    Group::new().set("class", class)
}

pub(super) fn line(from: [f64; 2], to: [f64; 2], stroke: &str, width: f64) -> Line {
    Line::new()
        .set("x1", px(from[0]))
        .set("y1", px(from[1]))
        .set("x2", px(to[0]))
        .set("y2", px(to[1]))
        .set("stroke", stroke)
        .set("stroke-width", width)
}

pub(super) fn rectangle(area: Area, fill: &str) -> Rectangle {
    Rectangle::new()
        .set("x", px(area.left))
        .set("y", px(area.top))
        .set("width", px(area.width))
        .set("height", px(area.height))
        .set("fill", fill)
}

pub(super) fn circle(centre: [f64; 2], radius: f64, fill: &str) -> Circle {
    Circle::new()
        .set("cx", px(centre[0]))
        .set("cy", px(centre[1]))
        .set("r", px(radius))
        .set("fill", fill)
}

/// Text that starts at a point of its base line; `text-anchor` changes that.
pub(super) fn text(at: [f64; 2], size: f64, content: impl Into<String>) -> Text {
    Text::new(content)
        .set("x", px(at[0]))
        .set("y", px(at[1]))
        .set("font-size", size)
}

/// Text centred on a point of its base line.
pub(super) fn centred(at: [f64; 2], size: f64, content: impl Into<String>) -> Text {
    text(at, size, content).set("text-anchor", "middle")
}

/// The outline of a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline(String);

impl Outline {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn move_to(&mut self, [x, y]: [f64; 2]) {
        let _ = write!(self.0, "M{} {}", px(x), px(y));
    }

    pub fn line_to(&mut self, [x, y]: [f64; 2]) {
        let _ = write!(self.0, "L{} {}", px(x), px(y));
    }

    pub fn close(&mut self) {
        self.0.push('Z');
    }

    /// An outline through these points.
    pub fn through(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut outline = Self::default();
        for point in points {
            if outline.is_empty() {
                outline.move_to(point)
            } else {
                outline.line_to(point)
            }
        }
        outline
    }

    /// Points without extent, for [`dotted`](Self::dotted).
    pub fn dots(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut outline = Self::default();
        for point in points {
            outline.move_to(point);
            outline.0.push_str("h0");
        }
        outline
    }

    /// Every point as a disc: one element for all of them.
    pub fn dotted(self, fill: &str, diameter: f64) -> Path {
        self.stroked(fill, px(diameter))
            .set("stroke-linecap", "round")
    }

    pub fn stroked(self, stroke: &str, width: f64) -> Path {
        Path::new()
            .set("d", self.0)
            .set("fill", "none")
            .set("stroke", stroke)
            .set("stroke-width", width)
    }

    pub fn filled(self, fill: &str) -> Path {
        Path::new().set("d", self.0).set("fill", fill)
    }
}

/// A pattern drawn as its 4 by 4 cells, those at +1 in `colour`.
pub(super) fn pattern(at: [f64; 2], side: f64, code: PatternCode, colour: &str) -> Group {
    let cell = side / PatternCode::SIDE as f64;
    let mut on = Outline::default();
    for (row, cells) in code.rows().enumerate() {
        for (column, _) in cells.iter().enumerate().filter(|(_, on)| **on) {
            let (x, y) = (at[0] + cell * column as f64, at[1] + cell * row as f64);
            on.move_to([x, y]);
            on.line_to([x + cell, y]);
            on.line_to([x + cell, y + cell]);
            on.line_to([x, y + cell]);
            on.close();
        }
    }
    let area = Area {
        left: at[0],
        top: at[1],
        width: side,
        height: side,
    };
    let mut drawing = group("pattern");
    drawing.append(rectangle(area, "#ffffff"));
    if !on.is_empty() {
        drawing.append(on.filled(colour));
    }
    drawing.append(
        rectangle(area, "none")
            .set("stroke", INK)
            .set("stroke-width", 0.8),
    );
    drawing
}

/// A number for labels, with a proper minus sign.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

/// What stands above a figure, and what is said of it to who cannot see it.
#[derive(Clone, Debug)]
pub(super) struct Heading {
    pub title: String,
    pub subtitle: String,
    /// What the figure shows, in words and numbers.
    pub description: String,
}

/// A whole figure as the text of an SVG file.
pub(super) fn sheet(
    [width, height]: [f64; 2],
    heading: &Heading,
    parts: impl IntoIterator<Item = Group>,
) -> String {
    let Heading {
        title,
        subtitle,
        description,
    } = heading;
    let whole = Area {
        left: 0.0,
        top: 0.0,
        width,
        height,
    };
    let mut document = Document::new()
        .set("viewBox", format!("0 0 {} {}", px(width), px(height)))
        .set("width", px(width))
        .set("height", px(height))
        .set("font-family", FONTS)
        .set("fill", INK)
        .set("role", "img")
        .add(Title::new(title.as_str()))
        .add(Description::new().add(svg::node::Text::new(format!("{subtitle}. {description}"))))
        .add(rectangle(whole, "#ffffff"))
        .add(text([20.0, 27.0], 17.0, title.as_str()).set("font-weight", "bold"))
        .add(text([20.0, 46.0], TEXT_SIZE, subtitle.as_str()).set("fill", FAINT_INK));
    for part in parts {
        document.append(part);
    }
    let mut file = document.to_string();
    file.push('\n');
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_proper_minus_and_no_negative_zero() {
        assert_eq!(number(-8.25, 1), "\u{2212}8.2");
        assert_eq!(number(-0.04, 1), "0.0");
        assert_eq!(number(3.0, 0), "3");
        assert_eq!(px(-0.01).to_string(), "0");
        assert_eq!(px(12.3456).to_string(), "12.3");
    }

    #[test]
    fn a_pattern_has_one_square_for_each_cell_at_plus_one() {
        let drawn = |code| pattern([0.0, 0.0], 8.0, PatternCode(code), "#000000").to_string();
        assert_eq!(drawn(0).matches('Z').count(), 0);
        let cells = drawn(0b1000_0000_0000_0001);
        assert_eq!(cells.matches('Z').count(), 2);
        // Cell 0 is at the upper left and cell 15 at the lower right (eq. 3).
        assert!(
            cells.contains("M0 0L2 0") && cells.contains("M6 6L8 6"),
            "{cells}"
        );
    }
}
