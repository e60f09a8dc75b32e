//! The examples of `docs/how-to` compile and hold: each page is a doctest.

#[doc = include_str!("../../docs/how-to/add-a-contact-law.md")]
pub struct AddAContactLaw;

#[doc = include_str!("../../docs/how-to/add-a-wall.md")]
pub struct AddAWall;

#[doc = include_str!("../../docs/how-to/add-an-output.md")]
pub struct AddAnOutput;

#[doc = include_str!("../../docs/how-to/add-a-column.md")]
pub struct AddAColumn;

#[doc = include_str!("../../docs/how-to/add-a-force.md")]
pub struct AddAForce;
