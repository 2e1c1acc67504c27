//! An adapter at a serial line, by the kernel's own driver: the test plays the adapter.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use link_core::{BitRate, Input, LinkCommand, LinkEvent, Mode, Port, TxToken};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use transport_socketcan::{Interface, Kind, SocketCanPort};

use crate::rig::{frame, input, run, sent, timed_input};

/// The far end of the line, and the program that makes an interface of the near one.
struct Adapter {
    line: File,
    daemon: Child,
    said: Receiver<u8>,
}

impl Adapter {
    /// Attached as kernels before 6.0 needed it: the daemon sets the bit rate and opens the channel, past the driver.
    fn attach(name: &str) -> Self {
        let line = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&line).unwrap();
        unlockpt(&line).unwrap();
        let tty = ptsname(&line, Vec::new()).unwrap().into_string().unwrap();
        let mut line = File::from(line);
        let mut other = line.try_clone().unwrap();
        let (say, said) = channel();
        std::thread::spawn(move || {
            let mut bytes = [0; 64];
            while let Ok(count) = other.read(&mut bytes) {
                bytes[..count].iter().for_each(|byte| say.send(*byte).unwrap_or_default());
            }
        });
        let daemon = Command::new("slcand")
            .args(["-F", "-o", "-s4", &tty, name])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("slcand, of can-utils");
        let begin = Instant::now();
        while Interface::find(name).is_err() {
            assert!(begin.elapsed() < Duration::from_secs(10), "slcand has made no interface {name}");
            std::thread::sleep(Duration::from_millis(10));
        }
        line.flush().unwrap();
        let adapter = Self { line, daemon, said };
        adapter.hears("S4\r");
        adapter.hears("O\r");
        adapter
    }

    /// What it is told next, but for what it was told before.
    #[track_caller]
    fn hears(&self, wanted: &str) {
        let mut heard = String::new();
        while !heard.ends_with(wanted) {
            let byte = self.said.recv_timeout(Duration::from_secs(10));
            heard.push(byte.unwrap_or_else(|_| panic!("no {wanted:?}, but {heard:?}")).into());
        }
    }

    fn says(&mut self, words: &str) {
        self.line.write_all(words.as_bytes()).unwrap();
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        let _ = self.daemon.kill().and_then(|()| self.daemon.wait());
    }
}

#[test]
#[ignore = "needs slcan"]
fn a_bit_rate_that_another_program_has_set_is_not_confirmed_but_set() {
    let mut adapter = Adapter::attach("slcan80");
    run("ip", &["link", "set", "slcan80", "up"]);
    let mut port = SocketCanPort::open("slcan80").unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::Up));
    let kind = |port: &SocketCanPort| port.interface().kind().unwrap();
    assert_eq!(kind(&port), Kind::Controller { bit_rate: None, listen_only: false });

    let mode = Mode { bit_rate: BitRate::K250, listen_only: false };
    port.command(LinkCommand::SetMode(mode)).unwrap();
    assert_eq!(input(&mut port), Input::Link(LinkEvent::ModeSet(mode)));
    assert_eq!(kind(&port), Kind::Controller { bit_rate: Some(BitRate::K250), listen_only: false });
    adapter.hears("S5\r");
    adapter.hears("O\r");

    assert!(!port.interface().has_echo(), "nobody tells whether the adapter has sent it");
    port.transmit(TxToken(1), frame(0x123, &[0xAB, 0xCD])).unwrap();
    assert_eq!(input(&mut port), sent(1));
    adapter.hears("t1232ABCD\r");
    adapter.says("t4561EF\r");
    assert_eq!(timed_input(&mut port).1, Input::Frame(frame(0x456, &[0xEF])));
}
