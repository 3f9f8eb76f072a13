//! What the terminal can show: colours or none, block characters or ASCII.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};

use crate::lines::Kind;
use rover_link::text::printable;

/// How to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Look {
    /// Colours beside words; nothing is told by colour alone.
    pub colour: bool,
    /// Nothing but ASCII.
    pub ascii: bool,
}

/// Eighths of a cell, filled from below.
const EIGHTHS: [&str; 9] = [
    " ", "\u{2581}", "\u{2582}", "\u{2583}", "\u{2584}", "\u{2585}", "\u{2586}", "\u{2587}",
    "\u{2588}",
];
const EIGHTHS_ASCII: [&str; 9] = [" ", ".", ".", ".", ":", ":", ":", "#", "#"];

impl Look {
    /// What is as it should be.
    pub fn good(self) -> Style {
        self.coloured(Color::Green)
    }

    /// What needs attention.
    pub fn trouble(self) -> Style {
        self.coloured(Color::Red).add_modifier(Modifier::BOLD)
    }

    /// What moves or may move.
    pub fn live(self) -> Style {
        self.coloured(Color::Yellow).add_modifier(Modifier::BOLD)
    }

    /// What matters less.
    pub fn quiet(self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }

    /// Titles.
    pub fn title(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// A line's text.
    pub fn line(self, kind: Kind) -> Style {
        match kind {
            Kind::Fact => Style::new(),
            Kind::Trouble => self.trouble(),
        }
    }

    fn coloured(self, colour: Color) -> Style {
        if self.colour {
            Style::new().fg(colour)
        } else {
            Style::new()
        }
    }

    /// A cell filled from below by a number of eighths.
    pub fn eighths(self, filled: usize) -> &'static str {
        let cells = if self.ascii { EIGHTHS_ASCII } else { EIGHTHS };
        cells[filled.min(8)]
    }

    /// A cell whose upper and lower halves are filled or not.
    pub fn halves(self, upper: bool, lower: bool) -> &'static str {
        match (upper, lower, self.ascii) {
            (false, false, _) => " ",
            (true, true, false) => "\u{2588}",
            (true, false, false) => "\u{2580}",
            (false, true, false) => "\u{2584}",
            (true, true, true) => "#",
            (true, false, true) => "'",
            (false, true, true) => ".",
        }
    }

    /// Cells of the lattice at -1 and +1, two columns wide.
    pub fn lattice_cells(self) -> [&'static str; 2] {
        if self.ascii {
            ["..", "##"]
        } else {
            ["\u{2591}\u{2591}", "\u{2588}\u{2588}"]
        }
    }
}

/// A part of the screen that is written on; what does not fit is not drawn.
pub struct Panel<'b> {
    area: Rect,
    buffer: &'b mut Buffer,
    /// How to draw.
    pub look: Look,
}

impl<'b> Panel<'b> {
    /// The part `area` of the screen.
    pub fn new(area: Rect, buffer: &'b mut Buffer, look: Look) -> Self {
        let area = area.intersection(buffer.area);
        Self { area, buffer, look }
    }

    /// The part below a title that is drawn.
    pub fn titled(area: Rect, buffer: &'b mut Buffer, look: Look, title: &str) -> Self {
        let mut head = Panel::new(area, buffer, look);
        let width = usize::from(head.area.width);
        let rule = "-".repeat(width.saturating_sub(title.chars().count() + 1));
        head.text(0, 0, title, look.title());
        head.right(0, &rule, look.quiet());
        let below = Rect {
            y: area.y.saturating_add(1),
            height: area.height.saturating_sub(1),
            ..area
        };
        Panel::new(below, buffer, look)
    }

    /// Columns.
    pub fn width(&self) -> u16 {
        self.area.width
    }

    /// Rows.
    pub fn height(&self) -> u16 {
        self.area.height
    }

    /// Writes text; returns the column after it.
    pub fn text(&mut self, x: u16, y: u16, text: &str, style: Style) -> u16 {
        if x >= self.area.width || y >= self.area.height {
            return x;
        }
        let (left, top) = (self.area.x + x, self.area.y + y);
        let room = usize::from(self.area.width - x);
        let text = printable(text, self.look.ascii);
        let (end, _) = self.buffer.set_stringn(left, top, text, room, style);
        end - self.area.x
    }

    /// Writes text that ends at the right border, unless it is too long for the row.
    pub fn right(&mut self, y: u16, text: &str, style: Style) {
        let length = text.chars().count() as u16;
        self.text(self.area.width.saturating_sub(length), y, text, style);
    }

    /// Writes text over several rows, broken between words; returns the row after it.
    pub fn wrapped(&mut self, mut y: u16, text: &str, style: Style) -> u16 {
        let mut line = String::new();
        for word in text.split_whitespace() {
            let fits = line.len() + 1 + word.len() <= usize::from(self.area.width);
            if !line.is_empty() && !fits {
                self.text(0, y, &line, style);
                y = y.saturating_add(1);
                line.clear();
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
        self.text(0, y, &line, style);
        y.saturating_add(1)
    }
}
