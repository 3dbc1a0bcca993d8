//! What the integration tests share: materials by name, random cases over the whole legal ranges, reference rules.

#![allow(dead_code, reason = "every test binary uses its own part")]

pub(crate) mod cases;
pub(crate) mod rules;
pub(crate) mod statistics;
pub(crate) mod wrong;
