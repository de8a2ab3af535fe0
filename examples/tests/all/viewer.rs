//! The viewer in a browser: Chromium without a window, driven over its DevTools protocol through a pair of pipes. Without a browser (or on
//! a system without named pipes) the test says so and ends.

use super::common::place;
use curvlay_examples::motion::shown;
use curvlay_examples::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_examples::report::Report;
use curvlay_examples::viewer::{Mark, Marks, Mesh, Model, Nozzle, Robot, SCRIPT, Stance, Step};
use serde_json::{Value, json};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Bug: a kind of bead was added, and tapes, whose number stood there, were shown as it.
#[test]
fn each_kind_of_bead_and_the_tape_has_a_colour() {
    let colours = SCRIPT.split_once("const KINDS = [").unwrap().1.split_once(']').unwrap().0;
    let colours: std::collections::BTreeSet<&str> = colours.split(", ").collect();
    assert_eq!(colours.len(), shown::kinds().len() + 1);
    assert_eq!(usize::from(shown::BEAD_KINDS), shown::kinds().len());
}

/// Three layers of a square, 20 mm wide, each a wall and a zigzag, with travels between them.
fn model() -> Model {
    let mut steps = Vec::new();
    for layer in 0..3 {
        let z = 0.5 + 0.5 * f64::from(layer);
        let wall = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0], [0.0, 0.0]];
        let inside = (1..10).flat_map(|row| {
            let (y, turn) = (2.0 * f64::from(row), row % 2 == 0);
            [[if turn { 19.0 } else { 1.0 }, y], [if turn { 1.0 } else { 19.0 }, y]]
        });
        for (kind, path) in [(0, wall.to_vec()), (1, inside.collect())] {
            for (at, [x, y]) in path.into_iter().enumerate() {
                let kind = if at == 0 { Step::TRAVEL } else { kind };
                let (tip, direction) = (Point3::new(x, y, z), Vector3::z());
                let path = 2 * layer + u32::from(kind == 1);
                steps.push(Step { tip, direction, width: 2.0, height: 0.5, kind, layer, path, seconds: 0.5 });
            }
        }
    }
    let square = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]];
    let sheet = |z| Mesh {
        vertices: square.map(|[x, y]| Point3::new(x, y, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let stance = |seconds: f64| Stance {
        seconds,
        joints: vec![0.1 * seconds, -0.2 * seconds],
        bones: vec![
            [Point3::origin(), Point3::new(0.0, 0.0, 200.0)],
            [Point3::new(0.0, 0.0, 200.0), Point3::new(150.0, 0.0, 200.0 + seconds)],
        ],
        part: Isometry3::translation(150.0, 0.0, 210.0 + seconds),
    };
    Model {
        name: "a square </script> of three layers".to_owned(),
        part: sheet(1.5),
        mould: Mesh::default(),
        plate: square.map(|[x, y]| Point3::new(1.5 * x - 5.0, 1.5 * y - 5.0, 0.0)).to_vec(),
        layers: [0.5, 1.0, 1.5].map(sheet).to_vec(),
        ends: vec![(1, [Point3::new(0.0, 0.0, 1.0), Point3::new(20.0, 0.0, 1.0)])],
        kinds: vec!["wall".to_owned(), "solid".to_owned()],
        marks: vec![Marks {
            what: "beads on nothing".to_owned(),
            colour: [240, 140, 20],
            places: vec![Mark { at: Point3::new(20.0, 20.0, 1.0), path: Some(2) }],
        }],
        nozzle: Some(Nozzle { tip: 0.8, half_angle_deg: 45.0, cone: 4.0, block: 14.0 }),
        robot: Some(Robot {
            name: "two joints".to_owned(),
            speeds: vec![1.0, 1.0],
            is_shown: false,
            stances: (0..40).map(|at| stance(f64::from(at))).collect(),
        }),
        steps,
        laid: None,
        density_g_cm3: Some(1.24),
    }
}

/// A browser with one page.
struct Browser {
    child: Child,
    orders: File,
    answers: BufReader<File>,
    sent: u64,
    /// The page, as orders name it.
    page: Option<String>,
    /// What the page said on its console, and errors nobody caught.
    said: Vec<String>,
}

impl Browser {
    /// None where there is no browser.
    fn open(page: &Path, folder: &Path) -> Option<Self> {
        let name = ["chromium", "chromium-browser", "google-chrome"]
            .into_iter()
            .find(|name| Command::new(name).arg("--version").output().is_ok_and(|said| said.status.success()))?;
        let pipes = ["orders", "answers"].map(|name| folder.join(name));
        for pipe in &pipes {
            let _ = fs::remove_file(pipe);
            Command::new("mkfifo").arg(pipe).status().ok().filter(|status| status.success())?;
        }
        let [orders, answers] = pipes;
        let profile = folder.join("profile");
        let script = format!(
            "exec {name} --headless --no-sandbox --disable-quic --no-first-run --disable-background-networking \
             --disable-component-update --disable-sync --use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist \
             --window-size=1000,900 --user-data-dir='{}' --remote-debugging-pipe 3<'{}' 4>'{}'",
            profile.display(),
            orders.display(),
            answers.display()
        );
        let child =
            Command::new("sh").args(["-c", &script]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let orders = File::options().write(true).open(orders).unwrap();
        let answers = BufReader::new(File::open(answers).unwrap());
        let mut browser = Browser { child, orders, answers, sent: 0, page: None, said: Vec::new() };
        let target = browser.order("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = browser.order("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        browser.page = attached["sessionId"].as_str().map(str::to_owned);
        for method in ["Runtime.enable", "Log.enable", "Page.enable"] {
            browser.order(method, json!({}));
        }
        browser.order("Page.navigate", json!({ "url": format!("file://{}", page.display()) }));
        Some(browser)
    }

    /// Sends an order and waits for its answer.
    fn order(&mut self, method: &str, params: Value) -> Value {
        self.sent += 1;
        let mut order = json!({ "id": self.sent, "method": method, "params": params });
        self.page.iter().for_each(|page| order["sessionId"] = json!(page));
        self.orders.write_all(format!("{order}\0").as_bytes()).unwrap();
        loop {
            let mut message = Vec::new();
            let read = self.answers.read_until(0, &mut message).unwrap();
            assert!(read > 0, "the browser ended while it was asked for {method}");
            message.pop();
            let mut message: Value = serde_json::from_slice(&message).unwrap();
            if message["id"] == json!(self.sent) {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].take();
            }
            if let Some("Runtime.consoleAPICalled" | "Runtime.exceptionThrown" | "Log.entryAdded") =
                message["method"].as_str()
            {
                self.said.push(message["params"].to_string());
            }
        }
    }

    /// What a piece of script gives.
    fn value(&mut self, script: &str) -> Value {
        let params = json!({ "expression": script, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.order("Runtime.evaluate", params);
        assert!(answer.get("exceptionDetails").is_none(), "{script}: {answer}");
        answer["result"]["value"].take()
    }

    /// Waits for two frames, then looks.
    fn picture(&mut self) -> String {
        self.value(
            "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50))))",
        );
        self.order("Page.captureScreenshot", json!({ "format": "png" }))["data"].as_str().unwrap().to_owned()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Bug: models without steps had a slider for the time in a layer, and a button that played nothing.
#[test]
fn without_steps_there_is_nothing_to_play() {
    let step = Step {
        tip: Point3::origin(),
        direction: Vector3::z(),
        width: 0.5,
        height: 0.3,
        kind: 0,
        layer: 0,
        path: 0,
        seconds: 1.0,
    };
    for (steps, still) in [(vec![], " data-still"), (vec![step], "")] {
        let page = Model { kinds: vec!["wall".into()], steps, ..Model::default() }.to_html();
        assert!(page.starts_with(&format!("<section class=\"viewer\"{still} aria-label")));
    }
}

#[test]
fn the_script_is_small() {
    assert!(SCRIPT.len() <= 40_000, "{} bytes", SCRIPT.len());
    assert!(
        !SCRIPT.contains("http:") && !SCRIPT.contains("https:") || SCRIPT.matches("http").count() == 1,
        "only the name of SVG"
    );
    assert!(!SCRIPT.contains("</script"));
}

/// Bug: after a motion run the picture was as wide as the way of the robot to its home, and the part a dot.
#[test]
fn the_part_is_framed_not_the_way_home() {
    let framed = |model: &Model| -> [Value; 3] {
        let html = model.to_html();
        let header = html.split_once("view-header\">").unwrap().1.split_once("</script>").unwrap().0;
        let header: Value = serde_json::from_str(header).unwrap();
        ["middle", "around", "built"].map(|key| header[key].clone())
    };
    let mut model = model();
    let before = framed(&model);
    // The part and its layers: 20 x 20 x 1 mm, and a cone of 4 mm above and below.
    assert_eq!((&before[0], &before[2]), (&json!([10.0, 10.0, 1.0]), &json!(true)));
    let around = before[1].as_f64().unwrap();
    assert!((around - (801f64.sqrt() + 8.0)).abs() < 1e-9, "{around}");
    let home = Step { tip: Point3::new(400.0, -300.0, 900.0), kind: Step::TRAVEL, ..model.steps[0] };
    model.steps.push(home);
    assert_eq!(framed(&model), before);
    // Without meshes the beads are what is built.
    (model.part, model.layers) = (Mesh::default(), Vec::new());
    let beads = framed(&model);
    assert!(beads[1].as_f64() < Some(60.0) && beads[2] == json!(true), "{beads:?}");
    // With nothing built all there is counts.
    model.steps.iter_mut().for_each(|step| step.kind = Step::TRAVEL);
    let machine = framed(&model);
    assert!(machine[1].as_f64() > Some(1000.0) && machine[2] == json!(false), "{machine:?}");
}

#[test]
fn a_browser_shows_turns_and_plays_the_build() {
    let folder = place("viewer", "browser");
    fs::create_dir_all(&folder).unwrap();
    let page = folder.join("report.html");
    let model = model();
    let mut report = Report::new("A square");
    report.viewer(&model);
    fs::write(&page, report.to_html()).unwrap();
    let Some(mut browser) = Browser::open(&page, &folder) else {
        eprintln!("skipped: no Chromium here");
        return;
    };
    // It reads its data.
    let ready = "new Promise(done => { let tries = 0; const look = () => document.querySelector('.viewer')?.viewer || tries++ > 400 ? \
                 done(!!document.querySelector('.viewer')?.viewer) : setTimeout(look, 50); look(); })";
    assert_eq!(browser.value(ready), true, "{:?}", browser.said);
    browser
        .value("window.v = document.querySelector('.viewer').viewer; window.s = document.querySelector('.viewer'); 1");
    let steps = model.steps.len();
    assert_eq!(browser.value("v.header.steps"), steps);
    assert_eq!(browser.value("[...v.nozzleAt(1e9)[0]].map(c => Math.round(100 * c) / 100)"), json!([19, 18, 1.5]));
    let whole = browser.picture();
    assert_eq!(browser.value("v.state.drawn"), steps - 1);

    // The sliders change the picture and what is drawn.
    browser.value("{ const input = s.querySelector('.view-high'); input.value = 1; input.oninput(); } 1");
    let first_layer = browser.picture();
    assert_ne!(whole, first_layer);
    assert_eq!(browser.value("v.state.drawn"), steps / 3 - 1);
    browser.value("{ const input = s.querySelector('.view-now'); input.value = 500; input.oninput(); } 1");
    let half_a_layer = browser.picture();
    assert_ne!(first_layer, half_a_layer);
    let drawn = browser.value("v.state.drawn").as_u64().unwrap() as usize;
    assert!((steps / 6 - 3..=steps / 6 + 1).contains(&drawn), "{drawn}");

    // It plays, and stops at the end.
    browser.value("s.querySelector('.view-speed').value = '6000'; s.querySelector('.view-run').click(); 1");
    let ended = "new Promise(done => { let tries = 0; const look = () => !v.state.playing || tries++ > 400 ? done(v.state.now) : \
                 setTimeout(look, 50); look(); })";
    let end = browser.value(ended).as_f64().unwrap();
    assert!((end - 0.5 * steps as f64).abs() < 1e-6, "{end}");

    // A click in the middle of the canvas, seen from above, selects the bead there.
    browser.value("v.see('Top'); 1");
    let click = "{ const box = s.querySelector('.view-canvas').getBoundingClientRect(); v.pick(box.left + box.width / 2, box.top + \
                 box.height / 2); } s.querySelector('.view-info').textContent";
    let said = browser.value(click);
    assert!(
        said.as_str().is_some_and(|text| text.starts_with("layer 3, path 5, waypoint ") && text.contains("solid")),
        "{said}"
    );
    browser.value("v.pick(s.querySelector('.view-canvas').getBoundingClientRect().left + 2, 5); 1");
    assert_eq!(browser.value("v.state.selected"), -1);

    // A finding leads to its place: layer 2, the corner of the wall.
    browser.value("s.querySelector('.view-finds button:last-child').click(); 1");
    assert_eq!(browser.value("[v.state.high, v.header.kinds[0], v.state.selected > 0]"), json!([1, "wall", true]));
    assert_eq!(browser.value("v.camera.target.map(c => Math.round(c))"), json!([20, 20, 1]));

    // With the robot the camera is aimed at the part where the robot has it, as near as without, and goes with it.
    let home = "v.shown.robot = true; v.see('Home'); v.camera.target.map(c => Math.round(c))";
    let now = browser.value("v.state.now").as_f64().unwrap();
    assert_eq!(browser.value(home), json!([160, 10, (211.0 + now).round() as i64]));
    assert_eq!(browser.value("v.camera.far === 2.1 * v.header.around"), true);
    browser.value("v.state.now = 10; v.touch(); 1");
    browser.picture();
    assert_eq!(browser.value("v.camera.target.map(c => Math.round(c))"), json!([160, 10, 221]));
    // A finding of the part is where the robot has it.
    browser.value("s.querySelector('.view-finds button:last-child').click(); 1");
    let now = browser.value("v.state.now").as_f64().unwrap();
    assert_eq!(
        browser.value("v.camera.target.map(c => Math.round(c))"),
        json!([170, 20, (211.0 + now).round() as i64])
    );
    browser.value("v.shown.robot = false; v.touch(); 1");

    // Every colour, every switch, the robot; nothing is said on the console, and WebGL finds no error.
    let before = browser.picture();
    let colours = "for (const option of s.querySelector('.view-colour').options) { option.selected = true; \
                   s.querySelector('.view-colour').onchange(); } s.querySelector('.view-colour').options.length";
    assert_eq!(browser.value(colours), 10); // eight, and two joints
    browser.value("s.querySelectorAll('.view-shown input').forEach(box => box.click()); 1");
    assert_ne!(before, browser.picture());
    browser
        .value("s.querySelector('.view-canvas').dispatchEvent(new KeyboardEvent('keydown', { key: 'PageDown' })); 1");
    assert_eq!(browser.value("v.state.high"), 0);
    browser.picture();
    assert_eq!(browser.value("v.state.errors"), 0);
    assert!(browser.said.is_empty(), "{:?}", browser.said);
}
