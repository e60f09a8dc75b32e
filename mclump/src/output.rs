//! Files beside the clump file.
