//! Which Turing pattern do four corner states grow into?
//!
//! `cargo run -p rover-shared --example perceive -- 0.8 -0.4 0.2 1.5`

use rover_shared::perception::{Corners, Lattice, LatticeParameters, Noise};
use rover_shared::random::Generator;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut corners = [1.0, -1.0, 0.5, 2.0];
    for (corner, argument) in corners.iter_mut().zip(std::env::args().skip(1)) {
        *corner = argument.parse::<f64>()?;
    }
    let one = f64::from(1 << Corners::FRACTION_BITS);
    let initial = Corners(corners.map(|corner| (corner * one) as i32));

    let lattice = Lattice::new(&LatticeParameters::PAPER)?;
    let mut rng = Generator::new(1);
    println!("front, left, right, target: {corners:?}");
    for start in 1..=3 {
        let settled = lattice.settle(&initial, &Noise::draw(&mut rng))?;
        let (code, time) = (settled.code, settled.time);
        println!("\nnoise {start}: pattern {code} after {time} time units");
        println!("{}", code.picture());
    }
    Ok(())
}
