//! `[Assembly]`: members that exist and make the size.

use std::collections::{HashMap, HashSet};
use std::vec::Vec;

use super::super::diagnostic::{Code, Findings};
use super::super::fields::Count;
use super::super::layout::{Sizes, param_bits};
use super::super::model::{Assembly, Member, Model, Reference};
use super::super::span::Span;

pub(super) fn check(model: &Model, findings: &mut Findings) {
    let mut sizes = Sizes::new(model);
    let cyclic = cyclic(model);
    for assembly in &model.assemblies {
        for member in &assembly.members {
            exists(model, &member.reference, member.span, findings);
            size(model, member, findings);
        }
        if cyclic.contains(&assembly.number) {
            let message = format_args!(
                "the assembly has itself as a member, at least through others; remove that member"
            );
            findings.add(Code::AssemblyCycle, assembly.spans.keyword(), message);
        } else {
            sum(assembly, &mut sizes, findings);
        }
    }
    for variant in &model.variants {
        for choice in &variant.choices {
            choice.references.iter().for_each(|reference| exists(model, reference, choice.span, findings));
        }
        let selector = variant.selector.split(':').next().unwrap_or_default();
        let digits = selector.trim_start_matches(|character: char| !character.is_ascii_digit());
        let Ok(number) = digits.parse() else { continue };
        let is = |stem: &str| selector.trim_end_matches(digits).eq_ignore_ascii_case(stem);
        let span = variant.spans.keyword();
        if is("Param") {
            exists(model, &Reference::Param { number, bit: 0 }, span, findings);
        } else if is("Assem") {
            exists(model, &Reference::Assembly(number), span, findings);
        }
    }
}

fn exists(model: &Model, reference: &Reference, span: Span, findings: &mut Findings) {
    let (code, keyword, number) = match *reference {
        Reference::Param { number, .. } if model.param(number).is_none() => {
            (Code::UnknownParameter, "Param", number)
        }
        Reference::Assembly(number) if model.assembly(number).is_none() => {
            (Code::UnknownAssembly, "Assem", number)
        }
        Reference::Variant(number) if model.variant(false, number).is_none() => {
            (Code::UnknownAssembly, "Variant", number)
        }
        Reference::BitVariant(number) if model.variant(true, number).is_none() => {
            (Code::UnknownAssembly, "BitStringVariant", number)
        }
        Reference::Padding
        | Reference::Param { .. }
        | Reference::Assembly(_)
        | Reference::Variant(_)
        | Reference::BitVariant(_)
        | Reference::Path(_)
        | Reference::Other(_) => return,
    };
    findings.add(code, span, format_args!("there is no `{keyword}{number}`; add it, or refer to another"));
}

fn size(model: &Model, member: &Member, findings: &mut Findings) {
    let (Some(bits), Reference::Param { number, bit }) = (member.bits, &member.reference) else { return };
    let Some(whole) = model.param(*number).and_then(param_bits) else { return };
    if bits.saturating_add(u32::from(*bit)) > whole {
        let message = format_args!(
            "the member has {bits} bits from bit {bit} on, and `Param{number}` has {whole}; correct one of them"
        );
        findings.add(Code::MemberSize, member.span, message);
    }
}

fn sum(assembly: &Assembly, sizes: &mut Sizes<'_>, findings: &mut Findings) {
    if assembly.members.is_empty() {
        return;
    }
    let span = assembly.spans.field(super::super::model::ASSEMBLY_SIZE_FIELD);
    let Some(bits) = sizes.sum(assembly, 0) else { return };
    let Some(size) = assembly.size else { return };
    let expected = u32::from(size).saturating_mul(8);
    if bits != expected {
        let message = format_args!(
            "the members have {}, and {} are {expected}; correct the size, or fill up with a member `bits,` without a reference",
            Count(bits, "bit"),
            Count(size, "byte")
        );
        findings.add(Code::AssemblySize, span, message);
    }
}

/// The assemblies that have themselves as a member, directly or through others.
fn cyclic(model: &Model) -> HashSet<u16> {
    let mut cyclic = HashSet::new();
    let mut state: HashMap<u16, bool> = HashMap::new();
    for assembly in &model.assemblies {
        if state.contains_key(&assembly.number) {
            continue;
        }
        // The way down, with the members still to be looked at; a member on the way is a cycle.
        let mut way: Vec<(u16, core::slice::Iter<'_, Member>)> = Vec::new();
        way.push((assembly.number, assembly.members.iter()));
        state.insert(assembly.number, false);
        while let Some((number, members)) = way.last_mut() {
            let number = *number;
            let inner = members.find_map(|member| match member.reference {
                Reference::Assembly(inner) => model.assembly(inner),
                Reference::Padding
                | Reference::Param { .. }
                | Reference::Variant(_)
                | Reference::BitVariant(_)
                | Reference::Path(_)
                | Reference::Other(_) => None,
            });
            match inner {
                None => {
                    state.insert(number, true);
                    way.pop();
                }
                Some(inner) => match state.get(&inner.number) {
                    Some(false) => {
                        cyclic.insert(inner.number);
                    }
                    Some(true) => {}
                    None => {
                        state.insert(inner.number, false);
                        way.push((inner.number, inner.members.iter()));
                    }
                },
            }
        }
    }
    cyclic
}
