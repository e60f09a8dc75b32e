//! Principal axes and the frame of a clump.
