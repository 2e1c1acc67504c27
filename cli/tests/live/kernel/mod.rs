//! The same commands on interfaces of a real kernel, each node a process of its own.

#[path = "../../../../transport-socketcan/tests/kernel/adapter.rs"]
mod adapter;
mod foreign;
mod interruption;
mod link;
mod nodes;
mod process;
#[path = "../../../../transport-socketcan/tests/kernel/real_kernel.rs"]
mod real_kernel;
mod same_trace;
mod watched;
mod witness;

/// They wait for one another most of the time, so they run side by side, each on an interface of its own. Those with many processes have
/// a kernel to themselves. A full transmit queue is seen from both sides: on an interface that echoes a frame when it enters the queue,
/// and on one that does so when it has left it.
#[test]
fn on_a_real_kernel() {
    real_kernel::run_ignored(&[
        (
            &[],
            &["--test-threads=20", "--skip", "same_trace", "--skip", "io_goes_on", "--skip", "says_nothing"],
        ),
        (&["--echo"], &["same_trace", "io_goes_on", "a_full_transmit_queue", "says_nothing"]),
    ]);
}
