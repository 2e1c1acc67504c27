use super::*;
use link_core::frame::standard_id;

struct Client(Session);

impl Client {
    fn connected() -> Self {
        Self(Session::new(["can0".to_owned(), "can1".to_owned()].into()))
    }

    /// In raw mode, with no frames held back.
    fn raw() -> Self {
        let mut client = Self::open();
        assert_eq!(client.says("< rawmode >< echo >"), ["< ok >", "< echo >"]);
        client
    }

    fn open() -> Self {
        let mut client = Self::connected();
        assert_eq!(client.says("< open can0 >"), ["< ok >"]);
        client
    }

    #[track_caller]
    fn says(&mut self, text: &str) -> Vec<String> {
        let mut effects = Vec::new();
        self.0.receive(Instant::ZERO, text.as_bytes(), &mut effects);
        show(effects)
    }

    fn hears(&mut self, millis: u64, data: &[u8]) -> Vec<String> {
        let frame = Frame::new(standard_id(0x123), data).unwrap();
        let mut effects = Vec::new();
        self.0.frame(Instant::from_millis(millis), &frame, &mut effects);
        show(effects)
    }

    fn ticks(&mut self, millis: u64) -> Vec<String> {
        let mut effects = Vec::new();
        self.0.tick(Instant::from_millis(millis), &mut effects);
        show(effects)
    }
}

fn show(effects: Vec<Effect>) -> Vec<String> {
    let show = |effect| match effect {
        Effect::Reply(text) => text,
        Effect::Send(frame) => format!("sends {frame}"),
        Effect::Complain(text) => format!("complains: {text}"),
        Effect::Close => "closed".to_owned(),
    };
    effects.into_iter().map(show).collect()
}

#[test]
fn raw_mode_gives_everything() {
    let mut client = Client::open();
    assert_eq!(client.hears(1, &[1]), [""; 0]);
    let mut client = Client::raw();
    assert_eq!(client.hears(1_500, &[0x11, 0x02]), ["< frame 123 1.500000 1102 >"]);
    assert_eq!(client.hears(2_000, &[]), ["< frame 123 2.000000  >"]);
    assert_eq!(client.says("< send 123 3 1 f 33 >"), ["sends 123 [3] 01 0F 33"]);
}

/// python-can reads what stands after `error` as a hexadecimal number and a time, and gives up at words.
#[test]
fn raw_mode_has_errors_in_numbers_only() {
    let mut client = Client::raw();
    let mut effects = Vec::new();
    client.0.bus_error(Instant::from_millis(3), 0x80, &mut effects);
    client.0.lost(Instant::from_millis(4), 0x1, "the frame was not sent", &mut effects);
    assert_eq!(show(effects), ["< error 080 0.003000 >", "< error 001 0.004000 >"]);
    assert_eq!(client.says("< send 123 1 xx >"), ["complains: xx is not a byte"]);
    assert_eq!(client.says("rubbish <echo>"), ["complains: a command begins with <", "< echo >"]);
    assert_eq!(client.says("< open can0 >"), ["complains: a bus is open"]);

    let mut client = Client::open();
    let mut effects = Vec::new();
    client.0.lost(Instant::from_millis(4), 0x1, "the frame was not sent", &mut effects);
    assert_eq!(show(effects), ["< error the frame was not sent >"]);
}

#[test]
fn the_first_frames_of_raw_mode_keep_clear_of_the_answer() {
    let mut client = Client::open();
    assert_eq!(client.says("< rawmode >"), ["< ok >"]);
    assert_eq!(client.0.deadline(), Some(Instant::from_millis(20)));
    assert_eq!(client.hears(1, &[1]), [""; 0]);
    assert_eq!(client.ticks(19), [""; 0]);
    assert_eq!(client.ticks(20), ["< frame 123 0.001000 01 >"]);
    assert_eq!(client.hears(21, &[2]), ["< frame 123 0.021000 02 >"]);

    // One that says something has read the answer, or does not care.
    let mut client = Client::open();
    assert_eq!(client.says("< rawmode >"), ["< ok >"]);
    assert_eq!(client.hears(1, &[1]), [""; 0]);
    assert_eq!(client.says("< echo >"), ["< frame 123 0.001000 01 >", "< echo >"]);
    assert_eq!(client.0.deadline(), None);

    // What is kept back has a limit.
    let mut client = Client::open();
    assert_eq!(client.says("< rawmode >"), ["< ok >"]);
    let heard: usize = (0..MOST_HELD + 1).map(|_| client.hears(1, &[1]).len()).sum();
    assert_eq!(heard, MOST_HELD + 1);
}

#[test]
fn a_command_may_come_in_pieces_and_several_at_once() {
    let mut client = Client::connected();
    assert_eq!(client.says("< op"), [""; 0]);
    assert_eq!(client.says("en can1 >< rawmode ><echo>\r\n"), ["< ok >", "< ok >", "< echo >"]);
    assert_eq!(client.0.channel(), Some(1));
}

#[test]
fn a_bad_client_is_told_and_goes_on() {
    let mut client = Client::open();
    assert_eq!(client.says("hello < echo >"), ["< error a command begins with < >", "< echo >"]);
    assert_eq!(client.says("< send 123 1 xx >"), ["< error xx is not a byte >"]);
    assert_eq!(client.says("< \u{e9} >"), ["< error unknown command  >"]);
    assert_eq!(client.says("< open can0 >"), ["< error a bus is open >"]);
    let long = format!("< {} >", "x".repeat(10_000));
    assert_eq!(client.says(&long), ["< error the command is too long >"]);
    assert_eq!(client.says("< statistics 10 >"), ["< error statistics are for controlmode >"]);
    assert_eq!(client.says("< echo >"), ["< echo >"]);
}

#[test]
fn a_bus_that_does_not_exist_ends_the_conversation() {
    let mut client = Client::connected();
    assert_eq!(client.says("< rawmode >"), ["< error no bus is open >"]);
    assert_eq!(client.says("< open vcan9 >"), ["< error no such bus, there is can0, can1 >", "closed"]);
}

#[test]
fn cyclic_frames_are_sent_until_deleted() {
    let mut client = Client::open();
    assert_eq!(client.says("< add 0 20000 123 1 42 >"), ["sends 123 [1] 42"]);
    assert_eq!(client.0.deadline(), Some(Instant::from_millis(20)));
    assert_eq!(client.ticks(19), [""; 0]);
    assert_eq!(client.ticks(20), ["sends 123 [1] 42"]);
    assert_eq!(client.says("< update 123 1 43 >"), [""; 0]);
    assert_eq!(client.ticks(100), ["sends 123 [1] 43"]);
    assert_eq!(client.says("< delete 123 >"), [""; 0]);
    assert_eq!(client.0.deadline(), None);
    assert_eq!(client.says("< delete 123 >"), ["< error nothing is sent with this identifier >"]);
}

#[test]
fn a_subscription_throttles_and_keeps_the_newest() {
    let mut client = Client::open();
    assert_eq!(client.says("< subscribe 0 100000 123 >"), [""; 0]);
    assert_eq!(client.hears(10, &[1]), ["< frame 123 0.010000 01 >"]);
    assert_eq!(client.hears(20, &[2]), [""; 0]);
    assert_eq!(client.hears(30, &[3]), [""; 0]);
    assert_eq!(client.0.deadline(), Some(Instant::from_millis(110)));
    assert_eq!(client.ticks(110), ["< frame 123 0.030000 03 >"]);
}

#[test]
fn a_filter_passes_what_has_changed_under_its_mask() {
    let mut client = Client::open();
    assert_eq!(client.says("< filter 0 0 123 2 00 F0 >"), [""; 0]);
    assert_eq!(client.hears(1, &[1, 0x10]).len(), 1);
    assert_eq!(client.hears(2, &[2, 0x1F]).len(), 0);
    assert_eq!(client.hears(3, &[2, 0x20]).len(), 1);
    assert_eq!(client.says("< unsubscribe 123 >"), [""; 0]);
    assert_eq!(client.hears(4, &[2, 0x30]).len(), 0);
}

#[test]
fn statistics_come_in_their_interval() {
    let mut client = Client::open();
    assert_eq!(client.says("< send 123 2 1 2 >").len(), 1);
    client.0.sent(&Frame::new(standard_id(0x123), &[1, 2]).unwrap());
    // Another, which has not come onto the bus.
    assert_eq!(client.says("< send 123 3 1 2 3 >").len(), 1);
    client.hears(1, &[1, 2, 3]);
    assert_eq!(client.says("< controlmode >< statistics 1000 >"), ["< ok >"]);
    assert_eq!(client.ticks(1_000), ["< stat 3 1 2 1 >"]);
    assert_eq!(client.says("< statistics 0 >"), [""; 0]);
    assert_eq!(client.0.deadline(), None);
}

/// A client in raw mode expects frames and errors only.
#[test]
fn statistics_end_with_their_mode() {
    let mut client = Client::open();
    assert_eq!(client.says("< controlmode >< statistics 100 >"), ["< ok >"]);
    assert_eq!(client.ticks(100), ["< stat 0 0 0 0 >"]);
    assert_eq!(client.says("< rawmode >< echo >"), ["< ok >", "< echo >"]);
    assert_eq!(client.ticks(200), [""; 0]);
}

#[test]
fn frames_in_cycles_come_no_faster_than_a_bus_takes_them() {
    let mut client = Client::open();
    assert_eq!(client.says("< add 0 1 123 0 >"), ["sends 123 [0]"]);
    assert_eq!(client.0.deadline(), Some(Instant::from_micros(47)));
}
