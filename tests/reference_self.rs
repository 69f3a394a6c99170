//! tmp
mod reference;
