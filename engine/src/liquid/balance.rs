//! Where the liquid is, and where it went.

use super::{Sum, Weighed};

/// Liquid that came and went since the start; volumes in m^3.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LiquidBalance {
    /// In films at the start, and in bridges that went on from another run.
    pub initial: f64,
    /// On particles that were inserted.
    pub inserted: Sum,
    /// On particles that left through a face of the domain.
    pub left: Sum,
    /// On particles that were deleted in a region.
    pub deleted: Sum,
    /// Evaporated.
    pub evaporated: Sum,
    /// Mass and energy that liquid from outside brought to particles.
    pub weighed: Weighed,
    /// Bridges that dried up.
    pub dried: u64,
    /// Bridges that formed.
    pub formed: u64,
    /// Bridges that broke.
    pub ruptured: u64,
    /// How often a bridge formed or took liquid that lies outside of the table of `young-laplace`.
    pub clamped: u64,
    /// Energy set free as bridges formed and took liquid, J, up to the last force evaluation.
    pub set_free: f64,
    /// Energy set free after the last force evaluation, J: the next one is the first that sees these bridges.
    pub next_set_free: f64,
}

crate::state::plain!(LiquidBalance {
    initial,
    inserted,
    left,
    deleted,
    evaporated,
    weighed,
    dried,
    formed,
    ruptured,
    clamped,
    set_free,
    next_set_free
});

/// The liquid of a run at one time; volumes in m^3.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LiquidRow {
    /// Balance until then.
    pub balance: LiquidBalance,
    /// In films.
    pub films: f64,
    /// In bridges.
    pub bridges: f64,
    /// On walls.
    pub wall_films: f64,
    /// Number of bridges.
    pub bridge_count: u64,
    /// Of sprays: in flight, emitted, caught by particles, lost at walls, left the domain.
    pub sprayed: [f64; 5],
    /// Balance error: present + removed - initial - added; zero up to rounding.
    pub error: f64,
}

impl LiquidRow {
    /// Sums up films and bridges.
    pub(super) fn new(
        balance: &LiquidBalance,
        films: &[f64],
        bridges: impl ExactSizeIterator<Item = f64> + Clone,
        walls: impl Iterator<Item = f64> + Clone,
        sprayed: [f64; 5],
    ) -> Self {
        let lost = [balance.left, balance.deleted, balance.evaporated].map(Sum::value);
        let [in_flight, emitted, _, lost_at_walls, left] = sprayed;
        let came = [-balance.initial, -balance.inserted.value(), -emitted];
        let of_droplets = [in_flight, lost_at_walls, left];
        let all = films.iter().copied().chain(bridges.clone());
        let all = all.chain(walls.clone());
        let all = all.chain(of_droplets);
        Self {
            balance: *balance,
            films: sum(films.iter().copied()),
            bridge_count: bridges.len() as u64,
            bridges: sum(bridges),
            wall_films: sum(walls),
            sprayed,
            error: sum(all.chain(lost).chain(came)),
        }
    }
}

/// The sum of some numbers with the rounding errors of the additions summed up beside it (Neumaier 1974).
pub(super) fn sum(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut sum = Sum::default();
    for number in numbers {
        sum.add(number);
    }
    sum.value()
}
