//! How much memory a thread takes at most.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which counts.
pub struct Counting;

thread_local! {
    /// Bytes that this thread has taken and not given back, and the most there were. What another
    /// thread gives back is missed, so this is for work of one thread.
    static TAKEN: Cell<(isize, isize)> = const { Cell::new((0, 0)) };
}

fn count(bytes: isize) {
    // A thread that ends may allocate when its variables are gone already.
    let _ = TAKEN.try_with(|taken| {
        let (now, most) = taken.get();
        let now = now + bytes;
        taken.set((now, most.max(now)));
    });
}

// SAFETY: everything is done by the system's allocator; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // For a moment there may be both.
        count(size as isize);
        count(-(layout.size() as isize));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(place, layout, size) }
    }
}

/// Measures from its beginning.
pub struct Peak(isize);

impl Peak {
    pub fn begin() -> Self {
        TAKEN.with(|taken| {
            let (now, _) = taken.get();
            taken.set((now, now));
            Self(now)
        })
    }

    /// The most that this thread took since then.
    pub fn bytes(&self) -> usize {
        let (_, most) = TAKEN.get();
        usize::try_from(most - self.0).unwrap_or(0)
    }
}

#[test]
fn what_is_taken_is_counted_whether_or_not_it_is_given_back() {
    let peak = Peak::begin();
    drop(vec![0u8; 1_000_000]);
    let kept = vec![0u8; 1_000];
    assert!((1_000_000..1_100_000).contains(&peak.bytes()));
    let peak = Peak::begin();
    drop(kept);
    assert_eq!(peak.bytes(), 0);
}
