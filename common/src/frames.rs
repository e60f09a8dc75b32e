//! Native frames: Arrow IPC streams of particles and contacts.
