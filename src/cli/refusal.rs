//! What the command line's parsers say, in the words of the user.

use std::env;
use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue};
use thallus::run::preset::PRESETS;
use thallus::sweep::SYMBOLS;

/// Of the flags that exclude one that was given, those that were given too.
pub(crate) fn of_given(mut refusal: clap::Error) -> clap::Error {
    let Some(ContextValue::Strings(all)) = refusal.get(ContextKind::PriorArg) else {
        return refusal;
    };
    let typed: Vec<OsString> = env::args_os().collect();
    let typed: Vec<_> = typed.iter().map(|word| word.to_string_lossy()).collect();
    let is_given = |usage: &&String| {
        let flag = usage.split([' ', '=']).next();
        typed.iter().any(|word| word.split('=').next() == flag)
    };
    let given: Vec<String> = all.iter().filter(is_given).cloned().collect();
    match given.as_slice() {
        [] => {}
        [one] => {
            refusal.insert(ContextKind::PriorArg, ContextValue::String(one.clone()));
        }
        _ => {
            refusal.insert(ContextKind::PriorArg, ContextValue::Strings(given));
        }
    }
    refusal
}

/// A refusal with the reason put as what to give instead.
pub(crate) fn in_words(refusal: &str) -> String {
    const REASONS: [(&str, &str); 5] = [
        ("invalid float literal", "give a number"),
        ("cannot parse float from empty string", "give a number"),
        (
            "invalid digit found in string",
            "give a whole number in digits, without a sign",
        ),
        (
            "cannot parse integer from empty string",
            "give a whole number",
        ),
        (
            "number too large to fit in target type",
            "give a smaller number",
        ),
    ];
    for (reason, words) in REASONS {
        if let Some(said) = refusal.trim_end().strip_suffix(reason) {
            return format!("{said}{words}");
        }
    }
    by_symbol(refusal)
        .or_else(|| other_command(refusal))
        .or_else(|| no_output(refusal))
        .or_else(|| within_bounds(refusal))
        .unwrap_or_else(|| refusal.to_owned())
}

/// A flag that is called by its letter in the thesis, as `sweep` has it.
fn by_symbol(refusal: &str) -> Option<String> {
    let meant = |(symbol, _): &&(&str, &str)| {
        refusal.starts_with(&format!("unexpected argument '--{symbol}' found"))
    };
    let (symbol, flag) = SYMBOLS.iter().find(meant)?;
    Some(format!("{}; {symbol} is --{flag}", refusal.trim_end()))
}

/// A command by another name, or a preset's.
fn other_command(refusal: &str) -> Option<String> {
    const COMMANDS: [(&[&str], &str); 8] = [
        (&["resume", "continue"], "grow --resume DIR"),
        (&["info", "inspect", "validate"], "check MESH"),
        (&["measure", "stats", "analyse"], "analyze DIR"),
        (&["view", "show", "picture", "preview"], "render DIR"),
        (&["mesh", "surface"], "skin DIR"),
        (&["texture", "textures"], "bake DIR"),
        (&["film", "video", "gif", "frames"], "animate DIR"),
        (&["convert", "write"], "export DIR"),
    ];
    let rest = refusal.strip_prefix("unrecognized subcommand '")?;
    let (word, _) = rest.split_once('\'')?;
    let said = format!("unrecognized subcommand '{word}'");
    if PRESETS.iter().any(|preset| preset.name == word) {
        return Some(format!(
            "{said}: thallus preset show {word} prints it, thallus grow MESH --preset {word} grows it"
        ));
    }
    let (_, meant) = COMMANDS.iter().find(|(names, _)| names.contains(&word))?;
    Some(format!("{said}; there is thallus {meant}"))
}

/// A file for the output of a command that prints.
fn no_output(refusal: &str) -> Option<String> {
    let rest = refusal.strip_prefix("unexpected argument '")?;
    let flag = rest.split('\'').next()?;
    let said = format!("unexpected argument '{flag}' found");
    ["-o", "--output"]
        .contains(&flag)
        .then(|| format!("{said}: what this says goes to standard output; append > FILE"))
}

/// `…: 0 is not in 1..=9`.
fn within_bounds(refusal: &str) -> Option<String> {
    let (said, bounds) = refusal.trim_end().rsplit_once(" is not in ")?;
    let (said, _) = said.rsplit_once(": ")?;
    let (least, most) = bounds.split_once("..=")?;
    let most = most.parse::<u32>().ok()?;
    Some(match most {
        u32::MAX => format!("{said}: give a whole number from {least}"),
        _ => format!("{said}: give a whole number from {least} to {most}"),
    })
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn reasons_say_what_to_give() {
        let cases = [
            (
                "'x' for '--a <B>': invalid float literal",
                "'x' for '--a <B>': give a number",
            ),
            (
                "'': cannot parse integer from empty string",
                "'': give a whole number",
            ),
            (
                "'-5': invalid digit found in string",
                "'-5': give a whole number in digits, without a sign",
            ),
            (
                "'0' for '--a': 0 is not in 1..=9",
                "'0' for '--a': give a whole number from 1 to 9",
            ),
            (
                "'0' for '--a': 0 is not in 1..=4294967295",
                "'0' for '--a': give a whole number from 1",
            ),
            ("unexpected argument '--a'", "unexpected argument '--a'"),
            (
                "unexpected argument '-o' found",
                "unexpected argument '-o' found: what this says goes to standard output; append > FILE",
            ),
            (
                "unrecognized subcommand 'resume'; tip: a similar subcommand exists: 'preset'",
                "unrecognized subcommand 'resume'; there is thallus grow --resume DIR",
            ),
            (
                "unrecognized subcommand 'foliose'",
                "unrecognized subcommand 'foliose': thallus preset show foliose prints it, thallus grow MESH --preset foliose grows it",
            ),
            (
                "unrecognized subcommand 'grwo'; tip: a similar subcommand exists: 'grow'",
                "unrecognized subcommand 'grwo'; tip: a similar subcommand exists: 'grow'",
            ),
        ];
        for (refusal, words) in cases {
            assert_eq!(in_words(refusal), words);
        }
    }
}
