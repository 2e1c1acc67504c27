//! What stands where in the data of an assembly.

use std::borrow::Cow;
use std::collections::HashMap;
use std::vec::Vec;

use super::model::{Assembly, Member, Model, Param, Reference};

/// A piece of an assembly's data.
#[derive(Debug, Clone, PartialEq)]
pub struct Slot<'a> {
    /// Its name: that of the parameter, or what the file says in its place.
    pub name: Cow<'a, str>,
    /// The first bit, counted from bit 0 of the first byte.
    pub first_bit: u32,
    /// The number of bits.
    pub bits: u32,
    /// The parameter whose value it is.
    pub param: Option<&'a Param>,
    /// The bit of the parameter that it begins with.
    pub param_bit: u16,
}

impl Slot<'_> {
    /// The bits of the piece, the first one lowest; `None` if they are more than 64 or the data end before.
    #[must_use]
    pub fn value_in(&self, data: &[u8]) -> Option<u64> {
        if self.bits > 64 {
            return None;
        }
        let mut value = 0;
        for place in 0..self.bits {
            let bit = self.first_bit.checked_add(place)?;
            let byte = *data.get(usize::try_from(bit / 8).ok()?)?;
            if (byte >> (bit % 8)) & 1 == 1 {
                value |= 1_u64.checked_shl(place)?;
            }
        }
        Some(value)
    }

    /// Its bytes, if it consists of whole ones that are there.
    #[must_use]
    pub fn bytes_in<'d>(&self, data: &'d [u8]) -> Option<&'d [u8]> {
        if !self.first_bit.is_multiple_of(8) || !self.bits.is_multiple_of(8) {
            return None;
        }
        let start = usize::try_from(self.first_bit / 8).ok()?;
        data.get(start..)?.get(..usize::try_from(self.bits / 8).ok()?)
    }
}

/// Puts the members of an assembly one behind the other, those of an assembly inside of it among them. `None` if the
/// size of one is not known, or there are too many.
pub(super) fn layout<'a>(model: &'a Model, assembly: &'a Assembly) -> Option<Vec<Slot<'a>>> {
    let mut walk = Walk { model, sizes: Sizes::new(model), slots: Vec::new(), at: 0, visits: 0 };
    walk.assembly(assembly, 0)?;
    Some(walk.slots)
}

struct Walk<'a> {
    model: &'a Model,
    sizes: Sizes<'a>,
    slots: Vec<Slot<'a>>,
    /// The next bit.
    at: u32,
    visits: usize,
}

impl<'a> Walk<'a> {
    fn assembly(&mut self, assembly: &'a Assembly, depth: usize) -> Option<()> {
        if depth > MAX_NESTING {
            return None;
        }
        let start = self.at;
        for member in &assembly.members {
            self.visits = self.visits.checked_add(1).filter(|&visits| visits <= MAX_VISITS)?;
            self.member(member, depth)?;
        }
        // Bytes without a member: a reserve.
        if let Some(size) = assembly.size {
            self.at = self.at.max(start.checked_add(u32::from(size).checked_mul(8)?)?);
        }
        Some(())
    }

    fn member(&mut self, member: &'a Member, depth: usize) -> Option<()> {
        let first_bit = self.at;
        match &member.reference {
            Reference::Assembly(number) => {
                let inner = self.model.assembly(*number)?;
                self.assembly(inner, depth.checked_add(1)?)?;
                self.at = match member.bits {
                    Some(bits) => first_bit.checked_add(bits)?,
                    None => self.at,
                };
                return Some(());
            }
            Reference::Padding => {
                self.at = first_bit.checked_add(member.bits.unwrap_or(0))?;
            }
            Reference::Param { number, bit } => {
                let param = self.model.param(*number)?;
                let bits = member.bits.or_else(|| param_bits(param))?;
                self.slot(Slot {
                    name: Cow::Borrowed(&param.name),
                    first_bit,
                    bits,
                    param: Some(param),
                    param_bit: *bit,
                })?;
            }
            other @ (Reference::Path(_)
            | Reference::Variant(_)
            | Reference::BitVariant(_)
            | Reference::Other(_)) => {
                let bits = member.bits.or_else(|| self.sizes.reference(other, 0))?;
                let name = name_of(self.model, other);
                self.slot(Slot { name, first_bit, bits, param: None, param_bit: 0 })?;
            }
        }
        Some(())
    }

    fn slot(&mut self, slot: Slot<'a>) -> Option<()> {
        self.at = slot.first_bit.checked_add(slot.bits)?;
        self.slots.push(slot);
        Some(())
    }
}

fn name_of<'a>(model: &'a Model, reference: &'a Reference) -> Cow<'a, str> {
    match reference {
        Reference::Path(path) => std::format!("{}", crate::epath::Epath::packed(path)).into(),
        Reference::Variant(number) => variant_name(model, false, *number),
        Reference::BitVariant(number) => variant_name(model, true, *number),
        Reference::Other(name) => name.into(),
        Reference::Padding | Reference::Param { .. } | Reference::Assembly(_) => "".into(),
    }
}

fn variant_name(model: &Model, is_of_bits: bool, number: u16) -> Cow<'_, str> {
    match model.variant(is_of_bits, number) {
        Some(variant) if !variant.name.is_empty() => Cow::Borrowed(&variant.name),
        _ => std::format!("Variant{number}").into(),
    }
}

/// The bits of a parameter's value, if every value has the same.
pub(super) fn param_bits(param: &Param) -> Option<u32> {
    let ty = param.data_type?;
    ty.size().and_then(|size| u32::try_from(size).ok()).and_then(|size| size.checked_mul(8))
}

/// The sizes of assemblies and variants in bits, each computed once.
pub(super) struct Sizes<'a> {
    model: &'a Model,
    known: HashMap<Reference, Option<u32>>,
}

impl<'a> Sizes<'a> {
    pub(super) fn new(model: &'a Model) -> Self {
        Self { model, known: HashMap::new() }
    }

    /// The sum of the members of an assembly; `None` if the size of one is not known.
    pub(super) fn sum(&mut self, assembly: &Assembly, depth: usize) -> Option<u32> {
        let mut sum: Option<u32> = Some(0);
        for member in &assembly.members {
            let bits = match member.bits {
                Some(bits) => Some(bits),
                None => self.reference(&member.reference, depth),
            };
            sum = sum.zip(bits).and_then(|(sum, bits)| sum.checked_add(bits));
        }
        sum
    }

    /// The size of what a member refers to.
    pub(super) fn reference(&mut self, reference: &Reference, depth: usize) -> Option<u32> {
        match reference {
            Reference::Padding => Some(0),
            Reference::Param { number, .. } => self.model.param(*number).and_then(param_bits),
            Reference::Path(_) | Reference::Other(_) => None,
            Reference::Assembly(_) | Reference::Variant(_) | Reference::BitVariant(_) => {
                if let Some(&known) = self.known.get(reference) {
                    return known;
                }
                if depth > MAX_NESTING {
                    return None;
                }
                // While it is computed its size is not known, so that a cycle ends.
                self.known.insert(reference.clone(), None);
                let size = self.compound(reference, depth.saturating_add(1));
                self.known.insert(reference.clone(), size);
                size
            }
        }
    }

    fn compound(&mut self, reference: &Reference, depth: usize) -> Option<u32> {
        let model = self.model;
        let variant = match reference {
            Reference::Assembly(number) => {
                let assembly = model.assembly(*number)?;
                return match assembly.size {
                    Some(size) => u32::from(size).checked_mul(8),
                    None => self.sum(assembly, depth),
                };
            }
            Reference::Variant(number) => model.variant(false, *number)?,
            Reference::BitVariant(number) => model.variant(true, *number)?,
            Reference::Padding | Reference::Param { .. } | Reference::Path(_) | Reference::Other(_) => {
                return None;
            }
        };
        // What all choices have in common.
        let mut common = None;
        let references = variant.choices.iter().flat_map(|choice| &choice.references);
        for reference in references.filter(|reference| **reference != Reference::Padding) {
            let bits = self.reference(reference, depth)?;
            if *common.get_or_insert(bits) != bits {
                return None;
            }
        }
        common
    }
}

/// Assemblies inside of assemblies.
const MAX_NESTING: usize = 8;
/// Members of an assembly, those of the assemblies inside of it among them.
const MAX_VISITS: usize = 65_536;
