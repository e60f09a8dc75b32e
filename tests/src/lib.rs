//! End-to-end tests, validation cases and the plain reference path.
