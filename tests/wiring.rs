//! The wiring table of `firmware/README.md` and the boards' descriptions say the same; so do the linker
//! script and the storage's layout.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::BTreeMap;

const README: &str = include_str!("../firmware/README.md");
const STORE: &str = include_str!("../firmware/src/store.rs");
const MEMORY: &str = include_str!("../memory.x");

/// GPIO by signal.
type Pins = BTreeMap<String, u8>;

/// Pins by the table, of each board that has a column: `| signal | a board | ... | connects to |`.
fn in_table() -> BTreeMap<&'static str, Pins> {
    let cells = |line: &'static str| line.trim_matches('|').split('|').map(str::trim);
    let table = README
        .lines()
        .skip_while(|line| !line.starts_with("| signal |"));
    let mut lines = table.take_while(|line| line.starts_with('|')).map(cells);
    let names: Vec<_> = lines.next().unwrap().skip(1).collect();
    let (_, names) = names.split_last().unwrap();
    let mut boards: BTreeMap<_, _> = names.iter().map(|name| (*name, Pins::new())).collect();
    for mut cells in lines.skip(1) {
        let signal = cells.next().unwrap().trim_matches('`');
        for (board, cell) in names.iter().zip(cells) {
            if cell != "-" {
                let pins = boards.get_mut(board).unwrap();
                pins.insert(signal.into(), cell.parse().unwrap());
            }
        }
    }
    boards
}

#[test]
fn table_and_descriptions_name_the_same_pins() {
    let table = in_table();
    assert!(table.len() >= 2, "{:?}", table.keys());
    for (name, pins) in table {
        let board = rover_boards::ALL.iter().find(|board| board.name() == name);
        let board = board.unwrap_or_else(|| panic!("there is no board {name}"));
        let signals = board.signals();
        let described = signals
            .iter()
            .filter_map(|(signal, pin)| Some((signal.to_str().unwrap().to_owned(), (*pin)?)));
        assert_eq!(described.collect::<Pins>(), pins, "{name}");
    }
}

fn number(text: &str, before: &str, after: &str) -> u32 {
    let rest = text.split_once(before).unwrap().1;
    rest.split_once(after).unwrap().0.trim().parse().unwrap()
}

#[test]
fn the_slots_fit_into_the_flash_that_is_set_aside() {
    let knowledge = number(STORE, "KNOWLEDGE_SECTORS: u32 =", ";");
    let calibrations = number(STORE, "CALIBRATION_SECTORS: u32 =", ";");
    let storage = MEMORY.split_once("STORAGE :").unwrap().1;
    let kilobytes = number(storage, "LENGTH =", "K");
    assert!(2 * (knowledge + calibrations) * 4 <= kilobytes);
    assert!(MEMORY.contains("LENGTH = 2048K - 128K - 0x100") && kilobytes == 128);
    assert!(README.contains(&format!("Two slots of {} KB for knowledge", 4 * knowledge)));
}
