//! `[[node]]` with `role = "master"`, and its scan list.

use core::ops::Range;
use core::time::Duration;

use cip_core::code::{AttributeId, ClassId, DeviceType, InstanceId, VendorId};
use devicenet_core::MacId;
use devicenet_core::master::{
    BitStrobeConnection, ChangeOfStateConnection, ElectronicKey, FirstContact, PollConnection,
    ReplacementMode, ScanEntry, ScanRate,
};
use toml::Spanned;

use super::Checker;
use super::device::is_set;
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{ConnectionName, MasterNode, ScannedSlave, Write};
use crate::scenario::raw::{RawIo, RawKey, RawNode, RawScan, RawWrite};
use crate::scenario::values::Time;

impl Checker<'_> {
    pub(super) fn master(&self, raw: &RawNode, table: &Range<usize>) -> Result<MasterNode, ScenarioError> {
        let access = self.access(raw, table)?;
        let time =
            |value: &Option<Spanned<Time>>, default| value.as_ref().map_or(default, |time| time.get_ref().0);
        let entries = raw.scan.as_ref().map(|scan| scan.get_ref().as_slice()).unwrap_or_default();
        let mut scan: Vec<ScannedSlave> = Vec::new();
        for entry in entries {
            scan.push(self.scanned(entry, access.mac, &scan)?);
        }
        Ok(MasterNode {
            access,
            run: raw.run.as_ref().is_none_or(|run| *run.get_ref()),
            interscan_delay: time(&raw.interscan_delay, Duration::from_millis(10)),
            response_wait: time(&raw.response_wait, Duration::from_millis(10)),
            background_ratio: match &raw.background_ratio {
                Some(ratio) => {
                    self.number("background_ratio", ratio, 1, 0xFFFF, "a number of scans, 1 to 65535")?
                }
                None => 1,
            },
            first_contact: self
                .name("first_contact", raw.first_contact.as_ref(), &FIRST_CONTACTS, first_contact_name)?
                .unwrap_or_default(),
            retry_after: time(&raw.retry_after, Duration::from_secs(1)),
            retry_at_most: time(&raw.retry_at_most, Duration::from_secs(16)),
            replacement: self
                .name("replacement", raw.replacement.as_ref(), &REPLACEMENT_MODES, replacement_name)?
                .unwrap_or_default(),
            replacement_retry: time(&raw.replacement_retry, Duration::from_secs(5)),
            multicast_output: self.multicast_output(raw, &scan)?,
            scan,
        })
    }

    /// All slaves of a multicast poll get the same command.
    fn multicast_output(&self, raw: &RawNode, scan: &[ScannedSlave]) -> Result<Vec<u8>, ScenarioError> {
        let longest = multicast_size(scan);
        match &raw.multicast_output {
            None => Ok(vec![0; longest]),
            Some(output) => self.data(
                "multicast_output",
                output,
                longest,
                "as the multicast poll of the scan list consumes",
            ),
        }
    }

    fn scanned(
        &self,
        table: &Spanned<RawScan>,
        own: u8,
        others: &[ScannedSlave],
    ) -> Result<ScannedSlave, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let place = self.required(raw.mac.as_ref(), &span, "`mac`, the MAC ID of the slave,")?;
        let mac = self.mac_id("mac", place)?;
        if mac == own {
            return self
                .fail(&place.span(), format!("`mac` is {mac}, the master's own; expected that of a slave"));
        }
        if others.iter().any(|other| other.entry.mac_id.number() == mac) {
            return self.fail(
                &place.span(),
                format!("MAC ID {mac} is in the scan list already; expected one entry for each slave"),
            );
        }
        let mut entry = ScanEntry::explicit_only(MacId::new(mac).unwrap_or(MacId::DEFAULT));
        if let Some(key) = &raw.key {
            entry.key = self.key(key.get_ref())?;
        }
        entry.poll = raw.poll.as_ref().map(|io| self.poll(ConnectionName::Poll, io, raw)).transpose()?;
        entry.multicast_poll = (raw.multicast_poll.as_ref())
            .map(|io| self.poll(ConnectionName::MulticastPoll, io, raw))
            .transpose()?;
        if let (Some(io), Some(poll)) = (&raw.multicast_poll, entry.multicast_poll)
            && let Some(group) = others.iter().find_map(|other| other.entry.multicast_poll)
            && poll.consume != group.consume
        {
            return self.fail(
                &io.get_ref().consume.as_ref().map_or_else(|| io.span(), Spanned::span),
                format!(
                    "`consume` of `multicast_poll` is {}, and {} for a slave before; expected the same, since all get \
                     one command",
                    poll.consume, group.consume
                ),
            );
        }
        entry.bit_strobe = raw.bit_strobe.as_ref().map(|io| self.strobe(io, raw)).transpose()?;
        entry.change_of_state = self.change_of_state(raw)?;
        if is_set(raw.background.as_ref()) {
            entry.rate = ScanRate::Background;
        }
        entry.replaceable = is_set(raw.replaceable.as_ref());
        let key = entry.key;
        if entry.replaceable && (key.vendor.is_none() || key.product_code.is_none()) {
            let place = raw.replaceable.as_ref().map_or(span, Spanned::span);
            return self.fail(
                &place,
                "only a slave whose key names vendor and product can be replaced; expected `key = { vendor = .., \
                 product = .. }`",
            );
        }
        if let (None, Some(bit)) = (&entry.bit_strobe, &raw.strobe_bit) {
            return self
                .fail(&bit.span(), "`strobe_bit` is for a slave with `bit_strobe`; expected that too");
        }
        let length = entry.output_len();
        Ok(ScannedSlave {
            output: match &raw.output {
                None => vec![0; length],
                Some(output) => self.data("output", output, length, "as the slave consumes")?,
            },
            strobe_bit: is_set(raw.strobe_bit.as_ref()),
            writes: self.configuration(raw)?,
            entry,
        })
    }

    fn key(&self, raw: &RawKey) -> Result<ElectronicKey, ScenarioError> {
        let word = |key, value: &Option<Spanned<i64>>| {
            value
                .as_ref()
                .map(|value| self.number::<u16>(key, value, 0, 0xFFFF, "a number of 16 bits"))
                .transpose()
        };
        Ok(ElectronicKey {
            vendor: word("vendor", &raw.vendor)?.map(VendorId),
            device_type: word("device_type", &raw.device_type)?.map(DeviceType),
            product_code: word("product", &raw.product)?,
            revision: raw.revision.as_ref().map(|revision| self.revision(revision)).transpose()?,
        })
    }

    fn poll(
        &self,
        name: ConnectionName,
        io: &Spanned<RawIo>,
        entry: &RawScan,
    ) -> Result<PollConnection, ScenarioError> {
        self.only(io.get_ref(), &["produce", "consume", "epr"], &format!("`{name}` of a scan list"))?;
        let sizes = self.sizes(name, io)?;
        Ok(PollConnection {
            produce: sizes.produce,
            consume: sizes.consume,
            expected_packet_rate: self.packet_rate(name, io, entry)?,
        })
    }

    fn strobe(&self, io: &Spanned<RawIo>, entry: &RawScan) -> Result<BitStrobeConnection, ScenarioError> {
        let name = ConnectionName::BitStrobe;
        self.only(io.get_ref(), &["produce", "epr"], "`bit_strobe` of a scan list")?;
        Ok(BitStrobeConnection {
            produce: self.sizes(name, io)?.produce,
            expected_packet_rate: self.packet_rate(name, io, entry)?,
        })
    }

    fn change_of_state(&self, entry: &RawScan) -> Result<Option<ChangeOfStateConnection>, ScenarioError> {
        let (name, io) = match (&entry.cos, &entry.cyclic) {
            (None, None) => return Ok(None),
            (Some(io), None) => (ConnectionName::ChangeOfState, io),
            (None, Some(io)) => (ConnectionName::Cyclic, io),
            (Some(_), Some(io)) => {
                return self.fail(&io.span(), "there are both `cos` and `cyclic`; expected one of them");
            }
        };
        let raw = io.get_ref();
        let sizes = self.sizes(name, io)?;
        if let (Some(_), Some(consume), 1..) = (&entry.poll, &raw.consume, sizes.consume) {
            return self.fail(
                &consume.span(),
                format!(
                    "what `{name}` consumes comes with the poll command; expected `consume` of `poll` only"
                ),
            );
        }
        let rate = self.packet_rate(name, io, entry)?;
        let inhibit = match &raw.inhibit {
            Some(inhibit) => self.milliseconds("inhibit", inhibit)?,
            None => 0,
        };
        if let Some(place) = &raw.inhibit
            && rate != 0
            && inhibit > rate
        {
            return self.fail(
                &place.span(),
                format!("`inhibit` is {inhibit}ms, longer than `epr`; expected at most {rate}ms"),
            );
        }
        Ok(Some(ChangeOfStateConnection {
            cyclic: name == ConnectionName::Cyclic,
            acknowledged: raw.acknowledged.as_ref().is_none_or(|flag| *flag.get_ref()),
            produce: sizes.produce,
            consume: sizes.consume,
            expected_packet_rate: rate,
            inhibit,
        }))
    }

    /// The expected packet rate of a connection: its own, or that of all connections of the slave.
    fn packet_rate(
        &self,
        name: ConnectionName,
        io: &Spanned<RawIo>,
        entry: &RawScan,
    ) -> Result<u16, ScenarioError> {
        match io.get_ref().epr.as_ref().or(entry.epr.as_ref()) {
            Some(rate) => self.milliseconds("epr", rate),
            None => self.fail(
                &io.span(),
                format!(
                    "`{name}` has no expected packet rate; expected `epr = \"75ms\"` here or for the slave"
                ),
            ),
        }
    }

    pub(super) fn milliseconds(&self, key: &str, value: &Spanned<Time>) -> Result<u16, ScenarioError> {
        let Time(time) = *value.get_ref();
        match u16::try_from(time.as_millis()) {
            Ok(millis) if Duration::from_millis(millis.into()) == time => Ok(millis),
            _ => self.fail(
                &value.span(),
                format!("`{key}` is {}; expected whole milliseconds, 0ms to 65535ms", Time(time)),
            ),
        }
    }

    fn configuration(&self, raw: &RawScan) -> Result<Vec<Write>, ScenarioError> {
        let Some(tables) = &raw.configuration else { return Ok(Vec::new()) };
        let writes: Vec<Write> =
            tables.get_ref().iter().map(|table| self.write(table)).collect::<Result<_, _>>()?;
        let size: usize = writes.iter().map(|write| write.value.len() + 7).sum();
        if size > MOST_CONFIGURATION {
            return self.fail(
                &tables.span(),
                format!(
                    "the configuration takes {size} bytes, seven for each line and its value; expected at most \
                     {MOST_CONFIGURATION}"
                ),
            );
        }
        Ok(writes)
    }

    fn write(&self, table: &Spanned<RawWrite>) -> Result<Write, ScenarioError> {
        let (raw, span) = (table.get_ref(), table.span());
        let word = |key: &str, value: &Option<Spanned<i64>>| {
            let value =
                self.required(value.as_ref(), &span, &format!("`{key}` of the attribute that is written"))?;
            self.number::<u16>(key, value, 0, 0xFFFF, "a number of 16 bits")
        };
        let (class, instance, attribute) = (
            word("class", &raw.class)?,
            word("instance", &raw.instance)?,
            word("attribute", &raw.attribute)?,
        );
        let value = self.required(raw.value.as_ref(), &span, "`value`, the bytes that are written,")?;
        let bytes = self.bytes("value", value)?;
        if bytes.len() > 255 {
            return self.fail(&value.span(), "`value` is too long; expected at most 255 bytes");
        }
        Ok(Write {
            class: ClassId(class),
            instance: InstanceId(instance),
            attribute: AttributeId(attribute),
            value: bytes,
        })
    }
}

/// The bytes of a multicast poll command, which is the same for all slaves.
pub(super) fn multicast_size(scan: &[ScannedSlave]) -> usize {
    scan.iter().find_map(|slave| slave.entry.multicast_poll).map_or(0, |poll| poll.consume.into())
}

const fn first_contact_name(contact: FirstContact) -> &'static str {
    match contact {
        FirstContact::Group2 => "group2",
        FirstContact::Ucmm => "ucmm",
    }
}

const fn replacement_name(mode: ReplacementMode) -> &'static str {
    match mode {
        ReplacementMode::Off => "off",
        ReplacementMode::DryRun => "dry_run",
        ReplacementMode::On => "on",
    }
}

const FIRST_CONTACTS: [FirstContact; 2] = [FirstContact::Group2, FirstContact::Ucmm];
const REPLACEMENT_MODES: [ReplacementMode; 3] =
    [ReplacementMode::Off, ReplacementMode::DryRun, ReplacementMode::On];
/// As much as the master has room for.
const MOST_CONFIGURATION: usize = 448;
