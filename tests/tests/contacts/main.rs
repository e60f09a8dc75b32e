//! Contacts: laws alone and mixed, friction, adhesion, liquid, energies.

mod adhesion;
mod contact_set;
mod coulomb;
mod dry_cohesion;
mod energy_audit;
mod impacts;
mod laws_alone;
mod liquid;
mod mixed_laws;
mod three_beads;
