//! Grids as the library makes them: cells, seeds, order, parts, tables.

use std::collections::BTreeSet;
use std::path::Path;

use thallus::export::TableValues;
use thallus::run::{Length, Settings, StopRule, StopSetting};
use thallus::substrate::Substrate;
use thallus::sweep::{
    Axis, CellPicture, Grid, Layout, Outcome, Results, captions, cost, mean_of, page,
};

fn plane() -> Substrate {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/plane.obj");
    Substrate::load(&file).unwrap()
}

fn grid(axes: &[(&str, &str)], seeds: u32) -> Grid {
    let axes = axes
        .iter()
        .map(|(name, values)| Axis::parse(name, values).unwrap());
    Grid {
        base: Settings {
            mesh: Some("plane.obj".to_owned()),
            ..Settings::default()
        },
        axes: axes.collect(),
        seeds,
    }
}

fn plan_error(grid: &Grid) -> String {
    grid.plan(&plane(), "plane.obj").unwrap_err().to_string()
}

#[test]
fn every_combination_is_a_cell_with_every_seed() {
    let mut grid = grid(&[("L", "5r,10r"), ("B", "0.2,0.5,0.9"), ("gain", "1,2")], 2);
    grid.base.seed = Some(7);
    let layout = Layout {
        columns: 2,
        rows: 3,
        pages: 2,
    };
    assert_eq!(grid.layout(), layout);
    assert_eq!([0, 1].map(|p| grid.page_title(p)), ["A = 1", "A = 2"]);
    assert_eq!(grid.page_title(usize::MAX), "A = 2", "a number is enough");
    let plan = grid.plan(&plane(), "plane.obj").unwrap();
    let names: Vec<_> = plan.cells.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(
        names[..3],
        ["L=5r_B=0.2_A=1", "L=10r_B=0.2_A=1", "L=5r_B=0.5_A=1"]
    );
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), 12);
    assert_eq!(plan.runs.len(), 24);
    for (number, run) in plan.runs.iter().enumerate() {
        assert_eq!(run.cell, number / 2);
        assert_eq!(run.seed, 7 + number as u64 % 2, "the same in every cell");
        let [l, b, a] = plan.cells[run.cell].at[..] else {
            panic!()
        };
        let recipe = run.recipe.as_ref().unwrap();
        assert_eq!(recipe.seed, run.seed);
        let radii = recipe.curvature_radius / recipe.radius;
        assert!((radii - [5.0, 10.0][l]).abs() < 1e-9);
        assert_eq!(recipe.bias, [0.2, 0.5, 0.9][b]);
        assert_eq!(recipe.gain, [1.0, 2.0][a]);
    }
    assert_eq!(plan.folder(1), "cells/L=5r_B=0.2_A=1/seed-8");
}

/// Files are called after cells, and may have 255 bytes.
#[test]
fn long_names_are_cut_and_stay_apart() {
    let places = |last: f64| {
        let places = (0..60).map(|i| format!("[0, 1, {}]", if i < 59 { 0.25 } else { last }));
        format!("[{}]", places.collect::<Vec<_>>().join(", "))
    };
    let text = format!(
        "mesh = \"plane.obj\"\n[axes]\nat = [{}, {}, \"top\"]\n",
        places(0.5),
        places(0.75)
    );
    let plan = Grid::from_toml(&text).unwrap().plan(&plane(), "plane.obj");
    let names: Vec<_> = plan.unwrap().cells.into_iter().map(|c| c.name).collect();
    assert_eq!(names[2], "at=top");
    assert_ne!(names[0], names[1]);
    for name in &names[..2] {
        assert!(name.starts_with("at="), "{name}");
        assert_eq!(name.len(), 200);
    }
}

#[test]
fn all_cells_reach_as_far_in_mesh_units_unless_told_otherwise() {
    let substrate = plane();
    let radii = grid(&[("radius", "0.1%,0.4%")], 1);
    let plan = radii.plan(&substrate, "plane.obj").unwrap();
    let radius = plan.recipes().nth(1).unwrap().radius;
    let reach = StopRule::Reach(150.0 * radius);
    assert!(plan.recipes().all(|recipe| recipe.stop == reach));
    let mut presets = grid(&[("preset", "dla,foliose")], 1);
    let plan = presets.plan(&substrate, "plane.obj").unwrap();
    let is_reach = |stop| matches!(stop, StopRule::Reach(_));
    assert!(
        plan.recipes().all(|recipe| is_reach(recipe.stop)),
        "over the preset's size"
    );
    presets.base.stop = Some(StopSetting::Elements(100));
    let plan = presets.plan(&substrate, "plane.obj").unwrap();
    assert!(
        plan.recipes()
            .all(|recipe| recipe.stop == StopRule::Elements(100))
    );
    let counts = grid(&[("elements", "100,200")], 1);
    let plan = counts.plan(&substrate, "plane.obj").unwrap();
    let stops = plan.recipes().map(|recipe| recipe.stop);
    assert_eq!(stops.last(), Some(StopRule::Elements(200)));
}

#[test]
fn a_grid_too_large_to_grow_has_a_layout() {
    let keys = [
        "B",
        "A",
        "L",
        "min-stick",
        "cover",
        "radius",
        "launch",
        "kill",
    ];
    let axes = keys.map(|key| match key {
        "launch" | "kill" => (key, "2..3/1700"),
        _ => (key, "0.1..1/1700"),
    });
    let pages = grid(&axes, 1).layout().pages;
    assert_eq!(pages, usize::MAX, "1700 to the 6th are more");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let cases = [
        (
            grid(&[("B", "0.2"), ("bias", "0.5")], 1),
            "bias is an axis twice",
        ),
        (
            grid(&[("reach", "10r"), ("elements", "5")], 1),
            "exclude one another",
        ),
        (grid(&[], 1), "nothing to compare"),
        (grid(&[], 0), "needs a seed"),
        (
            grid(&[("B", "0..1/9999"), ("A", "0..1/9999")], 1),
            "more than a million",
        ),
        (
            grid(&[("B", "7,8")], 1),
            "no cell of the grid can be grown; cell B=7: bias 7 is out of range",
        ),
        (
            grid(&[("at-triangle", "99998,99999")], 1),
            "cell at-triangle=99998",
        ),
        (grid(&[("L", "1r,1.5r")], 2), "cell L=1r: curvature-radius"),
        (grid(&[("L", "5r,0.25%")], 1), "the same lichen"),
    ];
    for (grid, part) in cases {
        let message = plan_error(&grid);
        assert!(message.contains(part), "'{part}' not in {message}");
    }
    let mut last = grid(&[("B", "0.2,0.3")], 2);
    last.base.seed = Some(u64::MAX);
    assert!(plan_error(&last).contains("2^64"));
    let mut idle = grid(&[("preset", "foliose,crustose")], 1);
    let foliose = thallus::run::preset::find("foliose").unwrap().settings();
    idle.base = foliose.over(idle.base);
    assert!(plan_error(&idle).contains("the same lichen"));
}

#[test]
fn a_cell_that_cannot_be_leaves_the_others_as_they_are() {
    let substrate = plane();
    let sound = grid(&[("radius", "0.1%,0.4%")], 2);
    let sound = sound.plan(&substrate, "plane.obj").unwrap();
    let faulty = grid(&[("radius", "900%,0.1%,0.4%")], 2);
    let plan = faulty.plan(&substrate, "plane.obj").unwrap();
    assert_eq!((plan.cells.len(), plan.runs.len()), (3, 6));
    assert!(
        plan.recipes().eq(sound.recipes()),
        "the reach is of radii that can be"
    );
    assert_eq!(plan.costs[2..], sound.costs);
    assert_eq!(plan.costs[..2], [0.0; 2]);
    assert_eq!(
        plan.runs[..2].iter().map(|r| r.hash()).collect::<Vec<_>>(),
        [None, None]
    );
    assert_eq!(plan.folder(1), "cells/radius=900%/seed-2");
    let problems = [0, 1, 2].map(|cell| plan.problem(cell).map(ToString::to_string));
    let [Some(problem), None, None] = problems else {
        panic!("{problems:?}")
    };
    assert!(problem.contains("larger than the mesh"), "{problem}");
    let shards = [1, 2].map(|part| plan.shard(part, 2).len());
    assert_eq!(shards, [3, 3], "they are dealt out too");
}

#[test]
fn a_flag_that_an_axis_says_too_is_refused() {
    let grid = grid(&[("B", "0.2,0.5"), ("reach", "10r,20r")], 1);
    let refused = |flags: Settings| grid.check_flags(&flags).is_err();
    assert!(!refused(Settings::default()));
    assert!(refused(Settings {
        bias: Some(0.7),
        ..Settings::default()
    }));
    let elements = Some(StopSetting::Elements(5));
    assert!(refused(Settings {
        stop: elements,
        ..Settings::default()
    }));
    let radius = Some(Length::Percent(0.1));
    assert!(!refused(Settings {
        radius,
        ..Settings::default()
    }));
}

#[test]
fn parts_are_a_partition_of_about_equal_cost() {
    let grid = grid(&[("L", "5r,10r,20r"), ("B", "0.1..1/10")], 3);
    let plan = grid.plan(&plane(), "plane.obj").unwrap();
    let order = plan.order();
    assert!(
        order
            .windows(2)
            .all(|w| plan.costs[w[0]] >= plan.costs[w[1]])
    );
    for parts in [1, 2, 7, 200] {
        let shards: Vec<_> = (1..=parts).map(|part| plan.shard(part, parts)).collect();
        let mut all: Vec<usize> = shards.iter().flatten().copied().collect();
        all.sort_unstable();
        assert_eq!(all, (0..90).collect::<Vec<_>>(), "{parts} parts");
        let costs: Vec<f64> = shards
            .iter()
            .map(|s| s.iter().map(|&r| plan.costs[r]).sum())
            .collect();
        let spread = costs[0] - costs[parts - 1];
        assert!(
            spread >= 0.0 && spread <= plan.costs[order[0]],
            "{parts}: {costs:?}"
        );
    }
}

#[test]
fn low_bias_and_long_reach_cost_more() {
    let recipe = |bias, reach| {
        let settings = Settings {
            bias: Some(bias),
            stop: Some(StopSetting::Reach(Length::Radii(reach))),
            ..Settings::default()
        };
        settings.resolve(&plane(), "plane.obj").unwrap()
    };
    let cost = |bias, reach| cost(&recipe(bias, reach), f64::INFINITY);
    assert!(cost(0.2, 50.0) > cost(0.9, 50.0));
    assert!(cost(0.5, 100.0) > 3.0 * cost(0.5, 50.0));
    assert_eq!(cost(-1.0, 50.0), cost(0.01, 50.0), "a floor for chances");
}

#[test]
fn hashes_are_of_what_decides_and_not_of_the_path() {
    let grid = grid(&[("B", "0.2,0.5")], 2);
    let [here, there] = ["plane.obj", "/elsewhere/plane.obj"].map(|file| {
        let plan = grid.plan(&plane(), file).unwrap();
        plan.runs.iter().map(|run| run.hash()).collect::<Vec<_>>()
    });
    assert_eq!(here, there);
    assert_eq!(here.iter().collect::<BTreeSet<_>>().len(), 4);
}

fn outcome(elements: f64, radius: f64) -> Result<Outcome, String> {
    Ok(Outcome {
        stopped: "reach".to_owned(),
        measures: vec![
            ("elements".to_owned(), elements),
            ("effective_radius".to_owned(), radius),
            ("tips".to_owned(), f64::NAN),
        ],
        seconds: 0.5,
    })
}

#[test]
fn the_table_has_a_row_a_run() {
    let grid = grid(&[("L", "5r,10r"), ("B", "0.2")], 2);
    let plan = grid.plan(&plane(), "plane.obj").unwrap();
    let failed = Err("the disk, \"full\"".to_owned());
    let outcomes = [
        outcome(10.0, 1.5),
        outcome(12.0, 2.5),
        failed,
        outcome(7.0, 0.1),
    ]
    .map(|of_run| {
        // A parameter too, which makes no second column.
        let mut outcome = of_run?;
        outcome.measures.push(("radius".to_owned(), 0.002));
        Ok(outcome)
    });
    let results = Results {
        grid: &grid,
        plan: &plan,
        outcomes: &outcomes,
    };
    let table = results.table();
    assert_eq!(table.rows(), 4);
    let names: BTreeSet<&String> = table.columns.iter().map(|c| &c.name).collect();
    assert_eq!(names.len(), table.columns.len(), "each name once");
    let column = |name: &str| {
        let found = table.columns.iter().find(|c| c.name == name);
        found
            .unwrap_or_else(|| panic!("no column {name}"))
            .values
            .clone()
    };
    assert_eq!(column("seed"), TableValues::U64(vec![1, 2, 1, 2]));
    assert_eq!(column("axis_B"), TableValues::F64(vec![0.2; 4]));
    let words = ["5r", "5r", "10r", "10r"].map(str::to_owned).to_vec();
    assert_eq!(column("axis_L"), TableValues::Text(words));
    let TableValues::Text(stopped) = column("stopped") else {
        panic!()
    };
    assert_eq!(stopped, ["reach", "reach", "failed", "reach"]);
    let summary = results.summary(0, 1);
    assert_eq!(
        (summary.mean, summary.deviation, summary.runs),
        (2.0, 0.5f64.sqrt(), 2)
    );
    assert_eq!(results.summary(1, 0).runs, 1);
    let mut csv = Vec::new();
    table.write_csv(&mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let lines: Vec<Vec<&str>> = csv.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(lines.len(), 5);
    assert!(
        lines.iter().all(|l| l.len() == table.columns.len()),
        "{csv}"
    );
    for (line, want) in lines[1..].iter().zip(["10", "12", "", "7"]) {
        let at = lines[0]
            .iter()
            .position(|name| *name == "elements")
            .unwrap();
        assert_eq!(line[at], want);
    }
}

#[test]
fn measures_are_compared_by_their_names() {
    let grid = grid(&[("B", "0.2,0.5,0.9")], 1);
    let plan = grid.plan(&plane(), "plane.obj").unwrap();
    let mut outcomes = [1.0, 2.0, 3.0].map(|n| outcome(n, 10.0 * n));
    outcomes[1].as_mut().unwrap().measures.reverse();
    outcomes[2].as_mut().unwrap().measures.truncate(1);
    let results = Results {
        grid: &grid,
        plan: &plan,
        outcomes: &outcomes,
    };
    let column = |measure| [0, 1, 2].map(|run| results.value(run, measure));
    assert_eq!(results.measures()[1], "effective_radius");
    assert_eq!(column(0), [1.0, 2.0, 3.0]);
    assert_eq!(column(1)[..2], [10.0, 20.0]);
    assert!(column(1)[2].is_nan());
}

/// Tags of a page in order, with their nesting checked.
fn check_tags(html: &str) {
    const VOID: [&str; 3] = ["meta", "img", "!doctype"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag that ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        let name: String = tag
            .chars()
            .take_while(|c| !" /".contains(*c) || *c == '/')
            .collect();
        let name = name.split_whitespace().next().unwrap_or("").to_owned();
        match name.strip_prefix('/') {
            Some(closed) => assert_eq!(open.pop().as_deref(), Some(closed), "</{closed}>"),
            None if tag.ends_with('/') || VOID.contains(&name.as_str()) => {}
            None => open.push(name.clone()),
        }
        if name == "script" || name == "style" {
            rest = &rest[rest.find(&format!("</{name}>")).expect("its end")..];
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

/// What the HTML standard asks for, and validators name.
fn check_validity(html: &str) {
    let tags = |name: &'static str| {
        let follows = move |c: Option<char>| matches!(c, Some(' ' | '>'));
        let tags = html.split('<').filter_map(move |t| t.strip_prefix(name));
        tags.filter(move |rest| follows(rest.chars().next()))
    };
    assert!(tags("img").all(|tag| tag.contains(" src=")));
    assert!(tags("button").all(|tag| tag.contains(" type=")));
    assert!(tags("th").all(|tag| tag.contains(" scope=")));
    assert!(
        ["h1", "h2", "h3"]
            .iter()
            .all(|h| !html.contains(&format!("></{h}>")))
    );
    let sections = html.split("<section>").skip(1);
    assert!(
        sections
            .into_iter()
            .all(|s| s.trim_start().starts_with("<h2"))
    );
}

#[test]
fn the_page_is_whole_and_needs_no_network() {
    let mut grid = grid(
        &[("L", "5r,10r"), ("B", "0.2,0.5"), ("join", "pack,touch")],
        2,
    );
    grid.base.mesh = Some("another.obj".to_owned());
    let plan = grid.plan(&plane(), "my <rock> & co's.obj").unwrap();
    let mut outcomes: Vec<_> = (0..16).map(|i| outcome(f64::from(i), 2.0)).collect();
    outcomes[2] = Err("</script><b>no room".to_owned());
    outcomes[3] = Err("no room".to_owned());
    let results = Results {
        grid: &grid,
        plan: &plan,
        outcomes: &outcomes,
    };
    let mut pictures = vec![
        CellPicture {
            jpeg: vec![0xff, 0xd8, 1]
        };
        8
    ];
    pictures[1].jpeg.clear();
    let words = |cell| captions(&results, cell);
    assert_eq!(words(0).len(), 2, "nothing of failures");
    assert_eq!(words(1), ["failed"]);
    let html = page(
        &results,
        &pictures,
        &[("Mesh".to_owned(), "<x>".to_owned())],
    );
    check_tags(&html);
    assert_eq!(
        html.matches("<button type=\"button\" class=\"cell\"")
            .count(),
        8
    );
    assert_eq!(html.matches("<img loading").count(), 7);
    check_validity(&html);
    assert_eq!(
        html.matches("<svg").count(),
        4,
        "two measures on two pages; tips has none"
    );
    assert!(html.contains("name=\"viewport\"") && html.contains("prefers-color-scheme"));
    assert!(html.contains("join = touch") && html.contains("L = 10r"));
    assert!(html.contains("effective radius<small>, mesh units</small>"));
    for outside in [
        "http://",
        "https://",
        "<link",
        "@import",
        "src=\"/",
        "<rock>",
        "</script><b>",
    ] {
        assert!(!html.contains(outside), "{outside}");
    }
    let data = html
        .split("id=\"data\">")
        .nth(1)
        .unwrap()
        .split("</script>")
        .next()
        .unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["cells"].as_array().unwrap().len(), 8);
    let first = &data["cells"][0];
    assert_eq!(first["values"][0], serde_json::json!(["0", "1"]));
    let command = first["command"].as_str().unwrap();
    for part in [
        "thallus grow 'my <rock>",
        "--curvature-radius=5.0r",
        "--bias=0.2",
        "--seed=1",
    ] {
        assert!(command.contains(part), "{part} not in {command}");
    }
    let command = data["cells"][1]["command"].as_str().unwrap();
    for part in ["--curvature-radius=10.0r", "--bias=0.2", "--seed=1"] {
        assert!(
            command.contains(part),
            "a failed cell has it too: {command}"
        );
    }
    assert!(
        data["cells"][1]["errors"][0]
            .as_str()
            .unwrap()
            .contains("seed 1: </script>")
    );
}

/// A mean of those that are left is not shown as one of all.
#[test]
fn a_cell_of_which_some_runs_failed_says_so() {
    let grid = grid(&[("L", "20r,5r,10r")], 3);
    let plan = grid.plan(&plane(), "plane.obj").unwrap();
    let whole: Vec<_> = (0..9).map(|i| outcome(f64::from(i), 2.0)).collect();
    let mut outcomes = whole.clone();
    for run in [1, 3, 4] {
        outcomes[run] = Err("no room".to_owned());
    }
    outcomes[5].as_mut().unwrap().stopped = "full".to_owned();
    outcomes[6].as_mut().unwrap().stopped = "starved".to_owned();
    let mut without_a_cell = whole.clone();
    without_a_cell[..3].fill(Err("no room".to_owned()));
    let results = |outcomes| Results {
        grid: &grid,
        plan: &plan,
        outcomes,
    };
    let show = |outcomes| page(&results(outcomes), &vec![CellPicture::default(); 3], &[]);
    let sound = show(&whole);
    assert!(sound.contains("mean of 3 seeds, bars") && !sound.contains("(of "));
    let means = [&whole, &without_a_cell, &outcomes].map(|o| mean_of(&results(o)));
    let [all, some] = ["mean of 3 seeds", "mean of up to 3 seeds"];
    assert_eq!(means, [all, all, some]);
    let of = |cell| captions(&results(&outcomes), cell);
    assert_eq!(of(0), ["R_e 2.000 ± 0.000", "n 1 ± 1", "1 of 3 failed"]);
    assert_eq!(of(1), ["R_e 2", "n 5", "1 of 3 full", "2 of 3 failed"]);
    assert_eq!(of(2), ["R_e 2.000 ± 0.000", "n 7 ± 1", "1 of 3 starved"]);
    let html = show(&outcomes);
    for words in [
        "<span>1 of 3 failed</span>",
        "mean of up to 3 seeds, bars",
        "<title>2 (of 1)</title>",
    ] {
        assert!(html.contains(words), "{words}");
    }
}

#[test]
fn charts_join_points_from_left_to_right_and_only_on_one_scale() {
    let chart = |values: &str| {
        let grid = grid(&[("L", values)], 1);
        let plan = grid.plan(&plane(), "plane.obj").unwrap();
        let runs = plan.runs.len() as u32;
        let outcomes: Vec<_> = (0..runs).map(|i| outcome(f64::from(i), 2.0)).collect();
        let results = Results {
            grid: &grid,
            plan: &plan,
            outcomes: &outcomes,
        };
        let html = page(&results, &vec![CellPicture::default(); runs as usize], &[]);
        let svg = html.split("<svg").nth(1).unwrap();
        let svg = svg.split("</svg>").next().unwrap().to_owned();
        assert!(!svg.contains("NaN"), "{values}: {svg}");
        svg
    };
    let across = |svg: &str| -> Vec<f64> {
        let points = svg.split("<polyline points=\"").nth(1).unwrap();
        let points = points.split('"').next().unwrap().split(' ');
        let x = |point: &str| point.split(',').next().unwrap().parse().unwrap();
        points.map(x).collect()
    };
    let x = across(&chart("20r,5r,10r"));
    assert!(x.len() == 3 && x.is_sorted(), "{x:?}");
    for mixed in ["5r,5%", "5r,0.2", "5r,1000,5%"] {
        let svg = chart(mixed);
        assert!(!svg.contains("<polyline"), "{mixed}");
        assert!(svg.matches("<circle").count() >= 2, "{mixed}");
    }
}
