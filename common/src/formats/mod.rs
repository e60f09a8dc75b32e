//! Readers and writers of `.data`, `.fstat`, `.ene`, particle tables and surface meshes.
