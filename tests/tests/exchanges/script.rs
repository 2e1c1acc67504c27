//! The exchanges of `tests/exchanges`: what their lines mean.
//!
//! The slave is a node of the simulated bus at 125 kbit/s. So is everybody else, by a name: masters and clients by their
//! MAC ID, `twin` for another node with the MAC ID of the slave, `tool` for one that repairs off line, `stranger` for one
//! that sends what is not its own, `echo` for one that repeats what the slave sends. Whose a frame is follows from its
//! identifier and its header.
//!
//! | Line | Meaning |
//! |---|---|
//! | `# Name` | an exchange begins |
//! | `fault: words` | it is a row of the fault matrix; the words say what must hold |
//! | `device: block`, `odd` | two bytes in and one out by poll; with an object of its vendor |
//! | `device: full`, `long`, `seven`, `longest` | by all connections; 16 in and 10 out; 14 each way; 448 out |
//! | `device: ucmm`, `crowd` | as `full`, with three or sixteen connections of the UCMM |
//! | `option: NAME`, `config: heartbeat 2` | an option is turned over; the slave is configured so |
//! | `start: dark`, `online`, `allocated 03`, `established 03 2 3` | without power; on line; this choice allocated to master 4; and the EPR of these instances 80 ms |
//! | `> 5FC: 04 0E 01 01 01`, `> 5FD: 01 by stranger` | another node sends this frame, to its end |
//! | `>> 5FE: 05 4B 03 01 01 05` | another node wants to send this frame, and what follows comes at the same moment |
//! | `< 5FB: 04 8E E7 03` | the slave sends this frame next, to its end; no other |
//! | `! words` | it has told this since the last line that did something |
//! | `+ 320 ms`, `+ 60000 ms late` | so long after the end of the last frame, or of the time that passed; nobody looked at the clock of the slave |
//! | `+ 320 ms since >`, `since <` | so long after the end of the last frame of the others, of the slave |
//! | `+ 320.008 ms > 5FD: 01` | so long after the end of the last frame of the others, this frame ends |
//! | `- 10 ms` | the clock of the slave is set back |
//! | `slow: 20 ms` | the slave takes so long to hand a frame to its controller |
//! | `spoil: 32` | what the slave hears of the next so many frames is wrong in one bit |
//! | `link: up`, `down`, `restart` | its power or cable come, its cable goes, its controller starts anew |
//! | `others: off`, `on` | the cables of all others go, and come |
//! | `in: 01 02`, `out: 01` | the inputs become, the outputs of poll are |
//! | `lamp: flashing red` | the network status indicator shows |
//! | `repeat 3: > 5FD: 01` | the same line several times |
//!
//! Everything else is a comment. The snapshot has every frame at its end, when its sender is told that it was sent.

pub(crate) struct Exchange {
    pub(crate) file: String,
    pub(crate) name: String,
    /// What must hold.
    pub(crate) fault: Option<String>,
    pub(crate) lines: Vec<String>,
}

/// Every file of exchanges, in the order of their names.
pub(crate) fn files() -> Vec<(String, Vec<Exchange>)> {
    let folder = devicenet_tests::workspace_root().join("tests/exchanges");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"))
        .collect();
    files.sort();
    files.into_iter().map(|file| (file.trim_end_matches(".txt").to_owned(), read(&file))).collect()
}

pub(crate) fn all() -> impl Iterator<Item = Exchange> {
    files().into_iter().flat_map(|(_, exchanges)| exchanges)
}

fn read(file: &str) -> Vec<Exchange> {
    let text = devicenet_tests::read(&format!("tests/exchanges/{file}"));
    let mut exchanges: Vec<Exchange> = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix("# ") {
            let (file, name) = (file.to_owned(), name.to_owned());
            exchanges.push(Exchange { file, name, fault: None, lines: Vec::new() });
            continue;
        }
        let Some(exchange) = exchanges.last_mut() else { continue };
        match line.strip_prefix("fault:") {
            Some(words) => exchange.fault = Some(words.trim().to_owned()),
            None => exchange.lines.push(line.to_owned()),
        }
    }
    exchanges
}

/// A frame, and who sends it.
#[track_caller]
pub(crate) fn spoken(text: &str) -> (String, link_core::Frame) {
    let (text, by) = text.split_once(" by ").map_or((text, None), |(text, by)| (text, Some(by)));
    let frame = devicenet_tests::notation::frame(text);
    (by.map_or_else(|| sender(&frame), str::to_owned), frame)
}

/// Whose a frame is.
fn sender(frame: &link_core::Frame) -> String {
    let id = frame.raw_id();
    let header = frame.data().first().map_or(0, |byte| byte & 0x3F);
    let number = match id {
        0..0x400 | 0x600..0x7C0 if id & 0x3F == 63 => return "echo".to_owned(),
        0..0x400 | 0x600..0x7C0 => (id & 0x3F) as u8,
        0x400..0x600 => match id & 7 {
            0 | 1 => (id >> 3 & 0x3F) as u8,
            3 => return "echo".to_owned(),
            4 | 6 => header,
            7 => return "twin".to_owned(),
            _ => 4,
        },
        _ => return "tool".to_owned(),
    };
    number.to_string()
}
