//! Controllers to compare the paper's with: they drive the same robot in the same arenas, and see
//! no more than it does unless their file says so.
//!
//! | file | is | sees |
//! |---|---|---|
//! | `reactive` | a hand-written rule | the three range sensors and the target |
//! | `vfh` | a vector field histogram | 37 ranges ahead and the target |
//! | `q_learning` | a learned table of action values | the three range sensors and the target |
//! | `random` | chance | nothing |

mod driver;
mod q_learning;
mod random;
mod reactive;
mod vfh;

pub use driver::{Driver, Experience, Observation};
pub use q_learning::QLearning;
pub use random::Random;
pub use reactive::Reactive;
pub use vfh::Vfh;
