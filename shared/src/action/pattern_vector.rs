//! The pattern vector (II-B, II-C): up to 2000 patterns, each with the step of its last occurrence
//! and the memory of its action. When full, the least recently met one is replaced.

use heapless::Vec;

use crate::perception::PatternCode;

/// How many patterns are remembered (II-B).
pub const CAPACITY: usize = 2_000;

/// One remembered pattern; `M` is what the learning rule keeps for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element<M> {
    /// The pattern.
    pub code: PatternCode,
    /// The step at which it last occurred: the paper's occurrence lag.
    pub last_occurrence: u32,
    /// How often it has occurred; stops counting at the largest number.
    pub occurrences: u32,
    /// The weights of its action.
    pub memory: M,
}

/// The pattern vector.
///
/// Searched from end to end: a trained robot holds about a hundred patterns, and even 2000
/// comparisons take the microcontroller a tenth of a millisecond once per action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PatternVector<M, const N: usize = CAPACITY> {
    elements: Vec<Element<M>, N>,
}

impl<M, const N: usize> Default for PatternVector<M, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M, const N: usize> PatternVector<M, N> {
    /// An empty vector.
    pub const fn new() -> Self {
        Self {
            elements: Vec::new(),
        }
    }

    /// All elements, in the order of their first occurrence, replacements in the place of what
    /// they replaced.
    pub fn elements(&self) -> &[Element<M>] {
        &self.elements
    }

    /// Returns the element of a pattern, if it is remembered.
    pub fn get(&self, code: PatternCode) -> Option<&Element<M>> {
        self.elements.iter().find(|element| element.code == code)
    }

    /// Returns the rule's memory of a pattern, if it is remembered.
    pub fn memory_mut(&mut self, code: PatternCode) -> Option<&mut M> {
        let found = self
            .elements
            .iter_mut()
            .find(|element| element.code == code);
        found.map(|element| &mut element.memory)
    }

    /// Records that a pattern occurs at `step`; false if it is not remembered.
    pub fn occur(&mut self, code: PatternCode, step: u32) -> bool {
        match self
            .elements
            .iter_mut()
            .find(|element| element.code == code)
        {
            Some(element) => {
                element.last_occurrence = step;
                element.occurrences = element.occurrences.saturating_add(1);
                true
            }
            None => false,
        }
    }

    /// Stores a pattern not yet remembered, at its first occurrence. If the vector is full, the
    /// element with the lowest last occurrence is replaced and returned.
    pub fn store(&mut self, code: PatternCode, step: u32, memory: M) -> Option<Element<M>> {
        debug_assert!(self.get(code).is_none(), "a pattern is stored once");
        let element = Element {
            code,
            last_occurrence: step,
            occurrences: 1,
            memory,
        };
        let Err(element) = self.elements.push(element) else {
            return None;
        };
        let oldest = self
            .elements
            .iter_mut()
            .min_by_key(|element| element.last_occurrence);
        // A vector of capacity 0 has no oldest element and remembers nothing.
        oldest.map(|oldest| core::mem::replace(oldest, element))
    }

    /// Removes all elements.
    pub(crate) fn clear(&mut self) {
        self.elements.clear();
    }

    /// Appends an element as it was stored before; false if the vector is full or has the pattern.
    pub(crate) fn restore(&mut self, element: Element<M>) -> bool {
        self.get(element.code).is_none() && self.elements.push(element).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the paper describes, in the most obvious way: a list ordered by last occurrence.
    #[derive(Default)]
    struct Model(std::vec::Vec<u16>);

    impl Model {
        fn meet(&mut self, code: u16, capacity: usize) {
            self.0.retain(|&other| other != code);
            self.0.push(code);
            if self.0.len() > capacity {
                self.0.remove(0);
            }
        }
    }

    proptest! {
        #[test]
        fn the_least_recently_used_pattern_makes_room(
            codes in prop::collection::vec(0u16..24, 0..300)
        ) {
            let (mut vector, mut model) = (PatternVector::<u16, 8>::new(), Model::default());
            for (step, code) in codes.into_iter().enumerate() {
                if !vector.occur(PatternCode(code), step as u32) {
                    vector.store(PatternCode(code), step as u32, code);
                }
                model.meet(code, 8);
                let mut stored: std::vec::Vec<_> = vector.elements().to_vec();
                stored.sort_by_key(|element| element.last_occurrence);
                let codes: std::vec::Vec<u16> = stored.iter().map(|e| e.code.0).collect();
                prop_assert_eq!(&codes, &model.0);
                prop_assert!(stored.iter().all(|e| e.code.0 == e.memory));
            }
        }
    }

    #[test]
    fn occurrences_are_counted() {
        let mut vector = PatternVector::<(), 2>::new();
        vector.store(PatternCode(5), 0, ());
        assert!(vector.occur(PatternCode(5), 9));
        assert!(!vector.occur(PatternCode(6), 10));
        let element = vector.get(PatternCode(5)).unwrap();
        assert_eq!((element.occurrences, element.last_occurrence), (2, 9));
    }
}
