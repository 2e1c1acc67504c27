//! The common services that a class may offer, and the class attributes that follow from its tables.

use super::rule::rule_of;
use super::serve::{NO_ATTRIBUTE, NO_INSTANCE, get, rules};
use super::{AttributeRule, Call, Effect, Effects, Failure, Object, exact};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::Writer;

/// An object that also has the common services 0x01, 0x03, 0x04 and 0x11, except those that it has itself.
///
/// | Service | Request | Response |
/// |---|---|---|
/// | 0x01 Get_Attributes_All | nothing | the values in the order of the table |
/// | 0x03 Get_Attribute_List | UINT count, UINT attribute each | UINT count, then UINT attribute, UINT status, value each |
/// | 0x04 Set_Attribute_List | UINT count, then UINT attribute, value each | UINT count, then UINT attribute, UINT status each |
/// | 0x11 Find_Next_Object_Instance | USINT maximum; the search starts after the instance addressed | USINT count, UINT instance each |
///
/// It is a wrapper, so that a small device does not carry what it does not offer; an object that wants one of the
/// services calls [`attributes_all`], [`attribute_list`], [`set_attribute_list`] or [`find_next_instance`] in its
/// [`Object::service`].
///
/// ```
/// use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
/// use cip_core::codec::Writer;
/// use cip_core::object::{AttributeRule, Call, CommonServices, Failure, FailureOptions, Object, respond};
///
/// struct Counter;
///
/// impl Object for Counter {
///     const CLASS: ClassId = ClassId(0x64);
///     fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
///         (instance.0 == 1).then_some(const { &[AttributeRule::get(1, 1)] })
///     }
///     fn get(&self, _: InstanceId, _: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
///         Ok(out.u8(0x42)?)
///     }
/// }
///
/// let list = Call::new(ServiceCode::GET_ATTRIBUTE_LIST, ClassId(0x64), InstanceId(1), &[2, 0, 1, 0, 9, 0]);
/// let mut buffer = [0; 16];
/// let mut out = Writer::new(&mut buffer);
/// respond(&mut (CommonServices(Counter),), &list, FailureOptions::default(), &mut out).map_err(|_| "refused")?;
/// assert_eq!(out.written(), [0x83, 2, 0, 1, 0, 0, 0, 0x42, 9, 0, 0x14, 0]);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CommonServices<O>(pub O);

impl<O: Object> Object for CommonServices<O> {
    const CLASS: ClassId = O::CLASS;
    const REVISION: u16 = O::REVISION;

    fn class_attributes(&self) -> &'static [AttributeRule] {
        self.0.class_attributes()
    }

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        self.0.attributes(instance)
    }

    fn has_set(&self, instance: InstanceId) -> bool {
        self.0.has_set(instance)
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        self.0.next_instance(instance)
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        self.0.get(instance, attribute, out)
    }

    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        self.0.set(instance, attribute, value, out)
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        let own = self.0.service(call, out);
        if own != Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()) {
            return own;
        }
        match call.service {
            ServiceCode::GET_ATTRIBUTES_ALL => attributes_all(&self.0, call, out),
            ServiceCode::GET_ATTRIBUTE_LIST => attribute_list(&self.0, call, out),
            ServiceCode::SET_ATTRIBUTE_LIST if self.0.has_set(call.instance) => {
                set_attribute_list(&mut self.0, call, out)
            }
            ServiceCode::FIND_NEXT_OBJECT_INSTANCE => {
                find_next_instance(|instance| self.0.next_instance(instance), call, out)
            }
            _ => own,
        }
    }
}

/// Get_Attributes_All: the values of all attributes in the order of the table. 0x08 if there are none.
pub fn attributes_all<O: Object>(
    object: &O,
    call: &Call<'_>,
    out: &mut Writer<'_>,
) -> Result<Effects, Failure> {
    let rules = rules(object, call.instance).ok_or(NO_INSTANCE)?;
    if rules.is_empty() {
        return Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into());
    }
    call.no_data()?;
    for rule in rules {
        get(object, call.instance, rule.id(), out)?;
    }
    Ok(Effects::NONE)
}

/// Get_Attribute_List. Each attribute has a status and, if that is 0, its value; a value without room has the status
/// 0x11.
///
/// An error response has no room for a list, so that a list with failures is a success, unless all its attributes have
/// failed: 0x0A.
pub fn attribute_list<O: Object>(
    object: &O,
    call: &Call<'_>,
    out: &mut Writer<'_>,
) -> Result<Effects, Failure> {
    let rules = rules(object, call.instance).ok_or(NO_INSTANCE)?;
    let (count, ids) = counted(call.data)?;
    let (ids, rest) = ids.as_chunks::<2>();
    if ids.len() < count {
        return Err(GeneralStatus::NOT_ENOUGH_DATA.into());
    }
    if ids.len() > count || !rest.is_empty() {
        return Err(GeneralStatus::TOO_MUCH_DATA.into());
    }
    let mut outcome = Outcome::new(count, out)?;
    for &id in ids {
        let attribute = AttributeId(u16::from_le_bytes(id));
        let at = emit_entry(attribute, out)?;
        let value = rule_of(rules, attribute)
            .ok_or(NO_ATTRIBUTE)
            .and_then(|_| get(object, call.instance, attribute, out));
        outcome.note(at, value, out)?;
    }
    outcome.finish(Effects::NONE)
}

/// Set_Attribute_List. Each attribute has a status.
///
/// Data too short or too long for the list are refused as a whole (0x13, 0x15). How long the value of an unknown
/// attribute is cannot be told: it ends the list with the status 0x14, and the response has as many entries as were
/// looked at. If none was set: 0x0A.
pub fn set_attribute_list<O: Object>(
    object: &mut O,
    call: &Call<'_>,
    out: &mut Writer<'_>,
) -> Result<Effects, Failure> {
    let rules = rules(object, call.instance).ok_or(NO_INSTANCE)?;
    let (count, settings) = counted(call.data)?;
    let entries = check_settings(rules, count, settings)?;
    // Before anything is set: a refusal must not follow it.
    if out.remaining() < entries.saturating_mul(4).saturating_add(2) {
        return Err(GeneralStatus::REPLY_DATA_TOO_LARGE.into());
    }
    let mut outcome = Outcome::new(entries, out)?;
    let mut effects = Effects::NONE;
    let mut rest = settings;
    for _ in 0..entries {
        let (attribute, value, next) = split_setting(rules, rest)?;
        rest = next;
        let at = emit_entry(attribute, out)?;
        let done = set_one(object, call.instance, rule_of(rules, attribute), value);
        outcome.note(at, done.map(|effect| effects = effects.then(effect)), out)?;
    }
    outcome.finish(effects)
}

/// Find_Next_Object_Instance: the instances after the one addressed, at most as many as the request allows.
pub fn find_next_instance(
    next_instance: impl Fn(InstanceId) -> Option<InstanceId>,
    call: &Call<'_>,
    out: &mut Writer<'_>,
) -> Result<Effects, Failure> {
    let [max] = exact(call.data)?;
    let count_at = out.len();
    out.u8(0)?;
    let mut count: u8 = 0;
    let mut instance = call.instance;
    while count < max
        && let Some(next) = next_instance(instance)
    {
        out.u16(next.0)?;
        count = count.saturating_add(1);
        instance = next;
    }
    out.patch(count_at, &[count])?;
    Ok(Effects::NONE)
}

/// The value of the class attributes that follow from the tables, for [`Object::get`] of instance 0; 0x14 for others.
///
/// | Attribute | Value |
/// |---|---|
/// | 1 | the revision |
/// | 2 | the highest instance |
/// | 3 | the number of instances |
/// | 6 | the highest class attribute |
/// | 7 | the highest attribute of an instance |
pub fn class_attribute<O: Object>(
    object: &O,
    attribute: AttributeId,
    out: &mut Writer<'_>,
) -> Result<(), Failure> {
    let highest = |rules: &[AttributeRule]| rules.iter().map(|rule| rule.id().0).max().unwrap_or(0);
    let value = match attribute.0 {
        1 => O::REVISION,
        2 => instances(object).last().map_or(0, |instance| instance.0),
        3 => u16::try_from(instances(object).count()).unwrap_or(u16::MAX),
        6 => highest(object.class_attributes()),
        7 => instances(object)
            .filter_map(|instance| object.attributes(instance).map(highest))
            .max()
            .unwrap_or(0),
        _ => return Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED.into()),
    };
    Ok(out.u16(value)?)
}

fn instances<O: Object>(object: &O) -> impl Iterator<Item = InstanceId> {
    core::iter::successors(object.next_instance(InstanceId::CLASS), |&instance| {
        object.next_instance(instance)
    })
}

/// The number of attributes that a list says it has, and the list.
fn counted(data: &[u8]) -> Result<(usize, &[u8]), Failure> {
    let (count, list) = data.split_first_chunk::<2>().ok_or(Failure::new(GeneralStatus::NOT_ENOUGH_DATA))?;
    Ok((u16::from_le_bytes(*count).into(), list))
}

/// The number of entries that can be told apart: all, or those up to the first unknown attribute.
fn check_settings(rules: &[AttributeRule], count: usize, settings: &[u8]) -> Result<usize, Failure> {
    let mut rest = settings;
    for index in 0..count {
        let (attribute, _, next) = split_setting(rules, rest)?;
        if rule_of(rules, attribute).is_none() {
            return Ok(index.saturating_add(1));
        }
        rest = next;
    }
    if rest.is_empty() { Ok(count) } else { Err(GeneralStatus::TOO_MUCH_DATA.into()) }
}

/// The attribute, its value, what follows. An unknown attribute has no value that could be told.
fn split_setting<'a>(
    rules: &[AttributeRule],
    settings: &'a [u8],
) -> Result<(AttributeId, &'a [u8], &'a [u8]), Failure> {
    let too_short = Failure::new(GeneralStatus::NOT_ENOUGH_DATA);
    let (id, rest) = settings.split_first_chunk::<2>().ok_or(too_short)?;
    let attribute = AttributeId(u16::from_le_bytes(*id));
    let size = match rule_of(rules, attribute) {
        Some(rule) => rule.size().of_value(rest)?,
        None => 0,
    };
    let (value, rest) = rest.split_at_checked(size).ok_or(too_short)?;
    Ok((attribute, value, rest))
}

fn set_one<O: Object>(
    object: &mut O,
    instance: InstanceId,
    rule: Option<&AttributeRule>,
    value: &[u8],
) -> Result<Effects, Failure> {
    let rule = rule.ok_or(NO_ATTRIBUTE)?;
    if !rule.is_settable() {
        return Err(GeneralStatus::ATTRIBUTE_NOT_SETTABLE.into());
    }
    // The list has no room for what a Set answers.
    let mut answer = [0; SET_ANSWER_MAX];
    let effects = object.set(instance, rule.id(), value, &mut Writer::new(&mut answer))?;
    Ok(effects.then(Effect::ATTRIBUTE_SET.into()))
}

/// Writes the attribute and an empty status; returns where the status is.
fn emit_entry(attribute: AttributeId, out: &mut Writer<'_>) -> Result<usize, Failure> {
    out.u16(attribute.0)?;
    let at = out.len();
    out.u16(0)?;
    Ok(at)
}

/// How a list goes.
struct Outcome {
    any: bool,
    empty: bool,
}

impl Outcome {
    /// Begins the response.
    fn new(count: usize, out: &mut Writer<'_>) -> Result<Self, Failure> {
        out.u16(u16::try_from(count).unwrap_or(u16::MAX))?;
        Ok(Self { any: false, empty: count == 0 })
    }

    /// Ends the entry whose status is at `at`.
    fn note(&mut self, at: usize, done: Result<(), Failure>, out: &mut Writer<'_>) -> Result<(), Failure> {
        match done {
            Ok(()) => self.any = true,
            Err(failure) => {
                out.truncate(at.saturating_add(2));
                out.patch(at, &[failure.general().0])?;
            }
        }
        Ok(())
    }

    fn finish(&self, effects: Effects) -> Result<Effects, Failure> {
        if self.any || self.empty { Ok(effects) } else { Err(GeneralStatus::ATTRIBUTE_LIST_ERROR.into()) }
    }
}

/// No class answers a Set with more: it is the size of the longest elementary value.
const SET_ANSWER_MAX: usize = 8;
