//! How many virtual seconds a second of computing gives.
fn main() {}
