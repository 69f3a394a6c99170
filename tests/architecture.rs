//! Holds the dependency table of `docs/architecture.md` against the source.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

type Table = BTreeMap<String, BTreeSet<String>>;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Names in backticks.
fn quoted(text: &str) -> BTreeSet<String> {
    text.split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

fn allowed() -> Table {
    let page = std::fs::read_to_string(root().join("docs/architecture.md")).expect("the page");
    let section = page
        .split("## Who may use whom")
        .nth(1)
        .expect("the section");
    let section = section.split("\n## ").next().expect("its text");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').collect();
        let module = quoted(cells.get(1)?).into_iter().next()?;
        Some((module, quoted(cells.get(2)?)))
    };
    section
        .lines()
        .filter(|l| l.starts_with('|'))
        .filter_map(row)
        .collect()
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            files.push(path);
        }
    }
    files
}

/// A source file, tests and comments aside.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).expect("a source file");
    let lines = without_tests(&text).into_iter();
    let code: Vec<&str> = lines
        .filter(|l| !l.trim_start().starts_with("//"))
        .collect();
    code.join("\n")
}

/// The modules that a file names by `crate::`.
fn used(path: &Path) -> BTreeSet<String> {
    named(&code(path))
}

/// The modules that code names by `crate::`, alone or grouped.
fn named(code: &str) -> BTreeSet<String> {
    let paths = code.split("crate::").skip(1);
    let names = paths.flat_map(|path| match path.strip_prefix('{') {
        Some(group) => first_names(group),
        None => vec![word(path)],
    });
    names.filter(|name| !name.is_empty()).collect()
}

/// What the paths of a group begin with, up to the brace that closes it.
fn first_names(group: &str) -> Vec<String> {
    let mut names = vec![word(group)];
    let mut depth = 0;
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(word(&group[i + 1..])),
            _ => {}
        }
    }
    names
}

fn word(text: &str) -> String {
    let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
    text.trim_start().chars().take_while(is_part).collect()
}

/// The lines of a source file but for items that are there for tests alone.
fn without_tests(text: &str) -> Vec<&str> {
    let mut lines = text.lines();
    let mut code = Vec::new();
    while let Some(line) = lines.next() {
        let Some(indent) = line.strip_suffix("#[cfg(test)]") else {
            code.push(line);
            continue;
        };
        let begins = lines.find(|l| !l.trim_start().starts_with("#["));
        if begins.is_some_and(|l| !l.ends_with([';', '}', ','])) {
            let rest = lines.by_ref();
            let end = rest.find(|l| l.strip_prefix(indent).is_some_and(|l| l.starts_with('}')));
            end.expect("an item that ends");
        }
    }
    code
}

#[test]
fn only_items_for_tests_are_left_out() {
    let text = "use a;\n#[cfg(test)]\nmod b;\nuse c;\n#[cfg(test)]\nmod d {\n    use e;\n    fn f() {\n    }\n}\nuse g;";
    assert_eq!(without_tests(text), ["use a;", "use c;", "use g;"]);
}

#[test]
fn grouped_modules_are_seen() {
    let code = "use crate::{\n    growth::{Join, Law},\n    run,\n};\nuse crate::walk::{a, b};\npub(crate) x, y";
    let expected = ["growth", "run", "walk"].map(str::to_owned);
    assert_eq!(named(code), BTreeSet::from(expected));
}

#[test]
fn modules_use_only_what_the_table_allows() {
    let allowed = allowed();
    let src = root().join("src");
    let mut seen = BTreeSet::new();
    for file in sources(&src) {
        let inside = file.strip_prefix(&src).expect("inside src");
        let first = inside
            .components()
            .next()
            .expect("a name")
            .as_os_str()
            .to_string_lossy();
        let module = first.trim_end_matches(".rs").to_owned();
        if ["lib", "main", "cli"].contains(&module.as_str()) {
            continue;
        }
        let may = allowed
            .get(&module)
            .unwrap_or_else(|| panic!("{module} is not in the table"));
        for name in used(&file) {
            assert!(
                name == module || may.contains(&name),
                "{}: uses crate::{name}",
                inside.display()
            );
            seen.insert((module.clone(), name));
        }
    }
    assert!(
        seen.len() > 8,
        "the test sees too few uses to mean anything: {seen:?}"
    );
    for (module, may) in &allowed {
        for name in may {
            assert!(
                seen.contains(&(module.clone(), name.clone())),
                "{module} no longer uses {name}: shorten its row"
            );
        }
    }
}

#[test]
fn the_binary_sees_the_library_from_outside() {
    for file in sources(&root().join("src/cli")) {
        let stray: Vec<String> = used(&file).into_iter().filter(|n| n != "cli").collect();
        assert!(
            stray.is_empty(),
            "{}: uses crate::{stray:?}",
            file.display()
        );
    }
}

/// The modules beside it that a file of the front end names by `super::`.
fn beside(path: &Path) -> BTreeSet<String> {
    named(&code(path).replace("super::", "crate::"))
}

/// Files of the command line use each other in one direction, as modules of the library do.
#[test]
fn the_front_end_goes_round_in_no_circle() {
    let files = sources(&root().join("src/cli"));
    let name = |file: &PathBuf| {
        file.file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned()
    };
    let mut left: Table = files
        .iter()
        .map(|file| (name(file), beside(file)))
        .collect();
    left.remove("mod");
    assert!(
        left.values().map(BTreeSet::len).sum::<usize>() > 100,
        "{left:?}"
    );
    while !left.is_empty() {
        let is_free = |uses: &BTreeSet<String>| !uses.iter().any(|used| left.contains_key(used));
        let free: Vec<String> = left
            .iter()
            .filter(|(_, uses)| is_free(uses))
            .map(|(name, _)| name.clone())
            .collect();
        assert!(!free.is_empty(), "among these: {left:?}");
        free.iter().for_each(|name| drop(left.remove(name)));
    }
}

/// Functions whose last bits differ from machine to machine, unless they are those of `libm`: of numbers, and of glam
/// by these.
const NOT_PORTABLE: &str = "sin_cos sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp exp2 exp_m1 ln \
     ln_1p log log2 log10 powf cbrt hypot gamma ln_gamma from_angle to_angle angle_between from_axis_angle from_euler \
     slerp";

/// Whether code calls none of them, as a method or by its path.
fn is_portable(code: &str) -> bool {
    let code = code.replace("libm::", "");
    let calls = |function: &str| {
        let method = format!(".{function}(");
        let path = format!("::{function}");
        let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
        let is_path = code.split(&path).skip(1).any(ends);
        code.contains(&method) || is_path
    };
    !NOT_PORTABLE.split_whitespace().any(calls)
}

#[test]
fn functions_that_differ_by_machine_are_seen() {
    assert!(is_portable(
        "libm::sin(x).sqrt() + x.powi(2) + f64::expand(x)"
    ));
    for code in [
        "x.sin()",
        "xs.map(f64::exp)",
        "f32::powf(x, y)",
        "2f64.log2()",
    ] {
        assert!(!is_portable(code), "{code}");
    }
}

/// The same recipe gives the same bytes on every machine.
#[test]
fn the_library_computes_portably() {
    let src = root().join("src");
    let front = src.join("cli");
    let only_for_tests = src.join("morphometry/test_lichen.rs");
    for file in sources(&src) {
        if file.starts_with(&front) || file == only_for_tests {
            continue;
        }
        for line in code(&file).lines() {
            assert!(is_portable(line), "{}: {line}", file.display());
        }
    }
}
