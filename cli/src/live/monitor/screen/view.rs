//! What the user looks at, and the keys that change it.

use core::cell::Cell;
use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::doctor::Severity;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::live::monitor::model::{FindingPicture, NodePicture, Picture};

/// What the user looks at.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(in crate::live::monitor) struct View {
    pub(super) focus: Focus,
    /// The pane in focus has the lower half: a node its details, the findings all the width.
    pub(super) is_large: bool,
    pub(super) has_help: bool,
    /// The first line of the help that is shown, if there is no room for all. Who draws it knows the last that there can be.
    pub(super) help_line: Cell<usize>,
    pub(super) sort: Sort,
    /// The node; the first if there is none or it is gone.
    node: Option<MacId>,
    /// The finding, likewise.
    finding: Option<u32>,
    /// What was over by then is not shown.
    cleared: Option<Duration>,
}

/// Which pane the arrows move in.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Focus {
    #[default]
    Nodes,
    Findings,
}

/// The order of the nodes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Sort {
    #[default]
    Mac,
    /// The busiest first.
    Load,
    /// The slowest first.
    Response,
    /// The worst first.
    Fault,
}

impl Sort {
    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Mac => "by MAC ID",
            Self::Load => "by load",
            Self::Response => "by response time",
            Self::Fault => "by fault",
        }
    }

    const fn next(self) -> Self {
        match self {
            Self::Mac => Self::Load,
            Self::Load => Self::Response,
            Self::Response => Self::Fault,
            Self::Fault => Self::Mac,
        }
    }
}

/// What a key asks of others than the view.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Command {
    Quit,
    Pause,
    Faster,
    Slower,
    Step,
}

impl View {
    /// A key was pressed while this picture was shown.
    pub(super) fn key(&mut self, key: &KeyEvent, picture: &Picture) -> Option<Command> {
        if key.kind == KeyEventKind::Release {
            return None;
        }
        // A raw terminal sends no signal.
        let is_interrupt = key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c');
        let had_help = core::mem::take(&mut self.has_help);
        if had_help && let Some(line) = self.scrolled(key.code) {
            self.has_help = true;
            self.help_line.set(line);
            return None;
        }
        self.help_line.set(0);
        match key.code {
            _ if is_interrupt => return Some(Command::Quit),
            // Any other key closes it.
            KeyCode::Char('?' | 'h') | KeyCode::F(1) => self.has_help = !had_help,
            KeyCode::Esc | KeyCode::Char('q') if had_help => {}
            KeyCode::Char('q') => return Some(Command::Quit),
            KeyCode::Esc => self.is_large = false,
            KeyCode::Char('p' | ' ') => return Some(Command::Pause),
            KeyCode::Char('+' | '=') => return Some(Command::Faster),
            KeyCode::Char('-') => return Some(Command::Slower),
            KeyCode::Char('.') => return Some(Command::Step),
            KeyCode::Char('s') => self.sort = self.sort.next(),
            KeyCode::Char('c') => self.cleared = Some(picture.at),
            KeyCode::Tab | KeyCode::BackTab => {
                self.focus = match self.focus {
                    Focus::Nodes => Focus::Findings,
                    Focus::Findings => Focus::Nodes,
                }
            }
            KeyCode::Enter => self.is_large = !self.is_large,
            KeyCode::Up | KeyCode::Char('k') => self.go(picture, |place, _| place.saturating_sub(1)),
            KeyCode::Down | KeyCode::Char('j') => self.go(picture, |place, _| place + 1),
            KeyCode::PageUp => self.go(picture, |place, _| place.saturating_sub(PAGE)),
            KeyCode::PageDown => self.go(picture, |place, _| place + PAGE),
            KeyCode::Home => self.go(picture, |_, _| 0),
            KeyCode::End => self.go(picture, |_, most| most),
            _ => {}
        }
        None
    }

    /// Where a key takes the help.
    fn scrolled(&self, key: KeyCode) -> Option<usize> {
        let line = self.help_line.get();
        match key {
            KeyCode::Up | KeyCode::Char('k') => Some(line.saturating_sub(1)),
            KeyCode::Down | KeyCode::Char('j') => Some(line.saturating_add(1)),
            KeyCode::PageUp => Some(line.saturating_sub(PAGE)),
            KeyCode::PageDown => Some(line.saturating_add(PAGE)),
            KeyCode::Home => Some(0),
            KeyCode::End => Some(usize::MAX),
            _ => None,
        }
    }

    fn go(&mut self, picture: &Picture, to: impl Fn(usize, usize) -> usize) {
        match self.focus {
            Focus::Nodes => {
                let nodes = self.nodes(picture);
                let last = nodes.len().saturating_sub(1);
                let place = to(self.place(&nodes), last).min(last);
                self.node = nodes.get(place).map(|node| node.mac()).or(self.node);
            }
            Focus::Findings => {
                let findings = self.findings(picture);
                let last = findings.len().saturating_sub(1);
                let place = to(self.finding_place(&findings), last).min(last);
                self.finding = findings.get(place).map(|finding| finding.finding.id).or(self.finding);
            }
        }
    }

    /// The nodes in their order.
    pub(super) fn nodes<'a>(&self, picture: &'a Picture) -> Vec<&'a NodePicture> {
        let mut nodes: Vec<&NodePicture> = picture.nodes.iter().collect();
        match self.sort {
            Sort::Mac => {}
            Sort::Load => nodes.sort_by(|a, b| b.load.total_cmp(&a.load)),
            Sort::Response => {
                let worst = |node: &NodePicture| node.worst().unwrap_or(-1.0);
                nodes.sort_by(|a, b| worst(b).total_cmp(&worst(a)));
            }
            Sort::Fault => {
                let badness = |node: &NodePicture| {
                    self.fault(picture, node.mac()).map(|fault| (!fault.is_over(), fault.finding.severity))
                };
                nodes.sort_by_key(|node| core::cmp::Reverse(badness(node)));
            }
        }
        nodes
    }

    /// Where the selected node is among them.
    pub(super) fn place(&self, nodes: &[&NodePicture]) -> usize {
        nodes.iter().position(|node| Some(node.mac()) == self.node).unwrap_or_default()
    }

    /// The worst first, of equal ones the newest; what is over comes last.
    pub(super) fn findings<'a>(&self, picture: &'a Picture) -> Vec<&'a FindingPicture> {
        let is_shown = |finding: &&FindingPicture| {
            finding.until.is_none_or(|until| self.cleared.is_none_or(|cleared| until > cleared))
        };
        let mut findings: Vec<&FindingPicture> = picture.findings.iter().filter(is_shown).collect();
        let order = |finding: &FindingPicture| (!finding.is_over(), finding.finding.severity, finding.since);
        findings.sort_by_key(|finding| core::cmp::Reverse(order(finding)));
        findings
    }

    /// Where the selected finding is among them.
    pub(super) fn finding_place(&self, findings: &[&FindingPicture]) -> usize {
        findings.iter().position(|finding| Some(finding.finding.id) == self.finding).unwrap_or_default()
    }

    /// The finding to show beside a node: the worst that lasts, or else the last.
    pub(super) fn fault<'a>(&self, picture: &'a Picture, mac: MacId) -> Option<&'a FindingPicture> {
        self.findings(picture)
            .into_iter()
            .find(|finding| finding.finding.node == Some(mac) && finding.finding.severity > Severity::Info)
    }
}

const PAGE: usize = 10;
