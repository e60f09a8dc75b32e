//! What the solver wrote, turned into what people look at.
