//! Source files as the compiler takes them: without comments, documentation, layout, and modules that only tests see.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Adds a file, or all files of a folder but those in folders `tests`, to a hash.
pub fn add(hasher: &mut blake3::Hasher, path: &Path) -> io::Result<()> {
    if path.is_dir() {
        let mut entries: Vec<PathBuf> =
            fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
        entries.retain(|entry| entry.file_name().is_none_or(|name| name != "tests"));
        entries.sort();
        return entries.iter().try_for_each(|entry| add(hasher, entry));
    }
    let meaning = meaning(path, fs::read(path)?);
    for part in [path.to_string_lossy().as_bytes(), &meaning] {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    Ok(())
}

/// What is hashed of a file: of Rust its tokens, of TOML its lines but for comments, of any other, and of Rust that is none, all
/// bytes.
pub fn meaning(path: &Path, bytes: Vec<u8>) -> Vec<u8> {
    let text = std::str::from_utf8(&bytes).ok();
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("rs") => text.and_then(tokens),
        Some("toml" | "lock") => text.map(lines),
        _ => None,
    }
    .unwrap_or(bytes)
}

fn lines(text: &str) -> Vec<u8> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.flat_map(|line| [line, "\n"]).collect::<String>().into_bytes()
}

fn tokens(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    write(text.parse().ok()?, &mut out);
    Some(out)
}

fn write(stream: TokenStream, out: &mut Vec<u8>) {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    let mut rest = tokens.as_slice();
    while let [token, after @ ..] = rest {
        rest = match attribute(rest) {
            Some((Attribute::Doc, after)) => after,
            Some((Attribute::Test, after)) if module(after).is_some() => module(after).unwrap_or(after),
            _ => {
                write_token(token, out);
                after
            }
        };
    }
}

/// Each kind of token begins with a letter of its own and ends where no text of its kind can go on.
fn write_token(token: &TokenTree, out: &mut Vec<u8>) {
    match token {
        TokenTree::Group(group) => {
            out.extend(match group.delimiter() {
                Delimiter::Parenthesis => b"(",
                Delimiter::Brace => b"{",
                Delimiter::Bracket => b"[",
                Delimiter::None => b"<",
            });
            write(group.stream(), out);
            out.push(b'e');
        }
        TokenTree::Ident(name) => out.extend(format!("i{name}\0").bytes()),
        TokenTree::Literal(literal) => out.extend(format!("l{literal}\0").bytes()),
        TokenTree::Punct(punct) => {
            let joint = if punct.spacing() == Spacing::Joint { 'j' } else { 'p' };
            out.extend(format!("{joint}{}", punct.as_char()).bytes());
        }
    }
}

/// An attribute that may be left out.
enum Attribute {
    Doc,
    /// Of what only tests see.
    Test,
}

/// The attribute at the beginning of `tokens`, and what follows it.
fn attribute(tokens: &[TokenTree]) -> Option<(Attribute, &[TokenTree])> {
    let after = after_punct(tokens, '#')?;
    let after = after_punct(after, '!').unwrap_or(after);
    let [TokenTree::Group(group), after @ ..] = after else { return None };
    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
    match inside.as_slice() {
        [TokenTree::Ident(name), ..] if name == "doc" => Some((Attribute::Doc, after)),
        [TokenTree::Ident(name), TokenTree::Group(of)]
            if name == "cfg" && of.stream().to_string() == "test" =>
        {
            Some((Attribute::Test, after))
        }
        _ => None,
    }
}

/// What follows the module at the beginning of `tokens`, its visibility and other attributes included; `None` of no module.
fn module(mut tokens: &[TokenTree]) -> Option<&[TokenTree]> {
    loop {
        tokens = match tokens {
            [TokenTree::Punct(mark), TokenTree::Group(_), after @ ..] if mark.as_char() == '#' => after,
            [TokenTree::Ident(word), TokenTree::Group(_), after @ ..] if word == "pub" => after,
            [TokenTree::Ident(word), after @ ..] if word == "pub" => after,
            [TokenTree::Ident(word), TokenTree::Ident(_), after @ ..] if word == "mod" => {
                return match after {
                    [TokenTree::Group(_), after @ ..] => Some(after),
                    _ => after_punct(after, ';'),
                };
            }
            _ => return None,
        }
    }
}

fn after_punct(tokens: &[TokenTree], mark: char) -> Option<&[TokenTree]> {
    match tokens {
        [TokenTree::Punct(punct), after @ ..] if punct.as_char() == mark => Some(after),
        _ => None,
    }
}
