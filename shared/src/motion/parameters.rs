//! The numbers of a rover's chassis. The defaults are for the paper's: a Lynxmotion 4WD2, 35 cm
//! square, 50:1 gear motors, some 5 kg (IV-A). They are estimates to start calibrating from.

use crate::time::Duration;
use crate::units::{Microdegrees, Micrometres};

/// Duties, limits and times of moves. Duties are per mille of full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// Duty of each side in a turn, at a vanishing heading error: what just overcomes the
    /// static friction of four wheels that must skid sideways.
    pub turn_minimum: u16,
    /// Most duty in a turn; above it the compass (some 40 ms late) is overrun.
    pub turn_maximum: u16,
    /// Duty added for each degree of heading error.
    pub turn_gain: u16,
    /// A turn may end this far from its target: half a compass error, and far less than a phase
    /// that matters. Smaller turns are left to the heading hold.
    pub tolerance: Microdegrees,
    /// How long the heading must stay within the tolerance, wheels stopped, before it counts:
    /// coasting and the compass's delay are over by then.
    pub settle: Duration,
    /// Time limit of a turn: half a circle takes 2 to 3 s.
    pub turn_timeout: Duration,
    /// Duty of a straight advance.
    pub cruise: u16,
    /// Speed at that duty, micrometres a second: to be calibrated (drive a metre, take the time).
    pub cruise_speed: Micrometres,
    /// Duty below which the wheels stand still; speed is taken to grow in proportion above it.
    pub dead_band: u16,
    /// Change of duty in an advance, per mille a second: full speed after 0.15 s, no skidding.
    pub ramp: u16,
    /// Difference of duty between the sides for each degree of heading error in an advance;
    /// 0 switches the heading hold off.
    pub hold_gain: u16,
    /// An advance is stopped, or not begun, at this clearance ahead. Above the 10 cm at which
    /// the range sensors fold back, by the way of one sensor period (38 ms) and of braking.
    pub front_stop: Micrometres,
    /// The same to the sides, whose sensors look out at 45 degrees: a wall to drive along is
    /// only 0.7 of this away.
    pub side_stop: Micrometres,
    /// How long the wheels may be driven without progress, counted from the last.
    pub no_progress: Duration,
    /// Change of heading that is progress: three times the compass's noise.
    pub progress_angle: Microdegrees,
    /// Change of a range that is progress: twice the sensors' noise at [`in_view`](Self::in_view).
    pub progress_distance: Micrometres,
    /// Ranges beyond this are no evidence of progress.
    pub in_view: Micrometres,
    /// A step that comes later than this after the one before stops the move.
    pub late: Duration,
}

impl Parameters {
    /// The paper's rover, estimated.
    pub const LYNXMOTION_4WD2: Self = Self {
        turn_minimum: 280,
        turn_maximum: 600,
        turn_gain: 8,
        tolerance: Microdegrees::from_degrees(2),
        settle: Duration::from_millis(120),
        turn_timeout: Duration::from_millis(4_000),
        cruise: 450,
        cruise_speed: Micrometres::from_cm(15),
        dead_band: 180,
        ramp: 1_800,
        hold_gain: 8,
        front_stop: Micrometres::from_cm(12),
        side_stop: Micrometres::from_cm(11),
        // Promised within 1 s: a margin of two control periods of 20 ms.
        no_progress: Duration::from_millis(960),
        progress_angle: Microdegrees::from_degrees(3),
        progress_distance: Micrometres::from_cm(2),
        in_view: Micrometres::from_cm(55),
        late: Duration::from_millis(150),
    };

    /// Checks that the numbers fit together.
    ///
    /// # Errors
    /// The first condition that does not hold.
    pub const fn check(&self) -> Result<(), ParameterError> {
        const HARD_STOP: u32 = Micrometres::from_cm(10).0;
        if self.turn_minimum == 0
            || self.turn_maximum < self.turn_minimum
            || self.turn_maximum > 1_000
            || self.turn_gain == 0
        {
            return Err(ParameterError::TurnDuty);
        }
        if self.tolerance.0 <= 0 || self.tolerance.0 > Microdegrees::from_degrees(10).0 {
            return Err(ParameterError::Tolerance);
        }
        if self.dead_band >= self.cruise || self.cruise > 1_000 {
            return Err(ParameterError::AdvanceDuty);
        }
        if self.cruise_speed.0 < Micrometres::from_cm(1).0
            || self.cruise_speed.0 > Micrometres::from_cm(100).0
        {
            return Err(ParameterError::Speed);
        }
        if self.ramp < 100 || self.ramp > 10_000 || self.hold_gain > 100 {
            return Err(ParameterError::Gain);
        }
        if self.front_stop.0 < HARD_STOP || self.side_stop.0 < HARD_STOP {
            return Err(ParameterError::StopDistance);
        }
        if self.progress_angle.0 <= 0
            || self.progress_distance.0 == 0
            || self.in_view.0 <= self.front_stop.0
        {
            return Err(ParameterError::Progress);
        }
        if self.no_progress.0 == 0
            || self.no_progress.0 > 1_000_000
            || self.late.0 == 0
            || self.late.0 > 200_000
            || self.turn_timeout.0 > 10_000_000
            || self.settle.0 >= self.turn_timeout.0
        {
            return Err(ParameterError::Time);
        }
        Ok(())
    }
}

/// Why parameters do not fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterError {
    /// Not 0 < minimum <= maximum <= 1000, or no gain: turns would not end, or overflow.
    TurnDuty,
    /// Outside (0, 10] degrees.
    Tolerance,
    /// Not dead band < cruise <= 1000.
    AdvanceDuty,
    /// Outside 1 cm/s to 1 m/s.
    Speed,
    /// Ramp outside 100 to 10,000 a second, or hold gain above 100 a degree.
    Gain,
    /// A stop distance below 10 cm, where the sensors fold back.
    StopDistance,
    /// Nothing would ever be progress, or everything.
    Progress,
    /// A time limit is zero, or longer than what the supervisor promises.
    Time,
}
