//! A [`Port`](crate::Port) on an `embedded_can` driver.
