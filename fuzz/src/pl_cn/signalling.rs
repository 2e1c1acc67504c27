//! EC, EN, EA and ER once more, as the managing node sees them.

/// What was said last.
#[derive(Clone, Debug)]
pub(super) struct Signalling {
    ec: bool,
    er: bool,
    pub(super) en: bool,
    ea: bool,
    /// The entries of the last StatusResponse, while they must not change.
    told: Option<Vec<u8>>,
    /// EN may be another than the last one.
    may_toggle: bool,
    /// ER changes EC before the answer.
    is_early: bool,
}

impl Signalling {
    pub(super) fn new(is_early: bool) -> Self {
        Self { ec: true, er: false, en: false, ea: false, told: None, may_toggle: false, is_early }
    }

    /// EA of a PReq or SoA for the node. Once EA was EN, the node may have changed EN and what it tells before it is asked.
    pub(super) fn acknowledge(&mut self, ea: bool) {
        // After an invitation that shows no EN, it is not known which EN is the last one.
        let is_acknowledged = self.may_toggle || self.ea == self.en || ea == self.en;
        self.may_toggle = !self.ec && is_acknowledged;
        self.ea = ea;
        if is_acknowledged {
            self.told = None;
        }
    }

    /// ER of a StatusRequest, before or after its answer.
    pub(super) fn reset(&mut self, er: bool, is_answered: bool) {
        if self.is_early == is_answered || er == self.er {
            return;
        }
        (self.er, self.ec, self.en, self.told) = (er, er, false, None);
        self.may_toggle = false;
    }

    /// EN of a PRes or StatusResponse.
    pub(super) fn saw_new(&mut self, en: bool) {
        if en != self.en {
            assert!(self.may_toggle, "EN changes before EA = EN");
            (self.en, self.told) = (en, None);
        }
        self.may_toggle = false;
    }

    pub(super) fn saw_status(&mut self, ec: bool, en: bool, entries: &[u8]) {
        assert_eq!(ec, self.ec, "EC");
        self.saw_new(en);
        if let Some(told) = &self.told {
            assert_eq!(told, entries, "entries change before EA = EN");
        }
        self.told = Some(entries.to_vec());
    }
}
