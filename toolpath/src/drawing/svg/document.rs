//! What `usvg` does not keep of a document: labels of Inkscape's layers, what is hidden, texts and images, and which element a path comes
//! from. Elements get ids for it.

use crate::drawing::skipped::Skips;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;
use usvg::roxmltree::{Document, Node, NodeId};

const SVG: &str = "http://www.w3.org/2000/svg";
const SHAPES: [&str; 7] = ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon"];

/// What is drawn only where something refers to it.
const DEFINITIONS: [&str; 7] = ["defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient"];

/// An element that draws.
#[derive(Clone, Debug)]
pub(super) struct Source {
    /// Its tag.
    pub kind: String,
    /// The line where it begins.
    pub line: u64,
    /// Its line, and its id if the file has one.
    pub place: String,
}

/// The elements of a document.
#[derive(Debug, Default)]
pub(super) struct Sources {
    /// By id.
    pub shapes: BTreeMap<String, Source>,
    /// Shapes that must be drawn, by id.
    pub wanted: BTreeSet<String>,
    /// Names of Inkscape's layers, by the id of the group.
    pub labels: BTreeMap<String, String>,
    /// What is not drawn.
    pub skips: Skips,
    /// Ids to put into the text, by place.
    ids: BTreeMap<usize, String>,
}

impl Sources {
    pub fn new(document: &Document) -> Self {
        let mut sources = Sources::default();
        // Where an entity is used, the text of its elements stands somewhere else.
        let may_name = !document.input_text().contains("<!ENTITY");
        let text = document.input_text().as_bytes();
        let (mut line, mut at) = (1, 0);
        // Elements come after those that they are in.
        let mut states: HashMap<NodeId, State> = HashMap::new();
        for node in document.descendants().filter(Node::is_element) {
            let begin = node.range().start;
            if begin >= at {
                line += text[at..begin].iter().filter(|&&byte| byte == b'\n').count() as u64;
                at = begin;
            }
            let is_layer = inkscape(&node, "groupmode") == Some("layer");
            let shape = SHAPES.contains(&node.tag_name().name());
            let id = match node.attribute("id") {
                Some(id) => Some(id.to_owned()),
                None if may_name && (shape || is_layer) => Some(sources.new_id(&node)),
                None => None,
            };
            if let (Some(id), Some(label)) = (&id, inkscape(&node, "label").filter(|_| is_layer)) {
                sources.labels.insert(id.clone(), label.to_owned());
            }
            let place = match node.attribute("id") {
                Some(id) => format!("line {line} (id {})", crate::drawing::skipped::printable(id)),
                None => format!("line {line}"),
            };
            let above = node.parent_element().and_then(|above| states.get(&above.id()));
            let state = State::new(&node, above);
            sources.add(&node, &state, id, line, place);
            states.insert(node.id(), state);
        }
        sources
    }

    fn add(&mut self, node: &Node, state: &State, id: Option<String>, line: u64, place: String) {
        let kind = node.tag_name().name();
        let shape = SHAPES.contains(&kind);
        if !(shape || ["text", "image", "foreignObject", "use"].contains(&kind)) {
            return;
        }
        let shown = !state.is_definition;
        match (&state.hidden, kind) {
            (Some(hidden), _) if shown => return self.skips.add(&format!("{kind} ({hidden})"), place),
            (None, "text") if shown => return self.skips.add("text (convert it to paths)", place),
            (None, "image" | "foreignObject") if shown => return self.skips.add(kind, place),
            _ => {}
        }
        if let Some(id) = id.filter(|_| shape) {
            if shown && state.is_svg {
                self.wanted.insert(id.clone());
            }
            self.shapes.insert(id, Source { kind: kind.to_owned(), line, place });
        }
    }

    /// An id of our own for an element without.
    fn new_id(&mut self, node: &Node) -> String {
        let id = format!("curvlay-{}", self.ids.len());
        let begin = node.range().start;
        let text = node.document().input_text();
        let length = text[begin..].find(|c: char| c.is_whitespace() || ['>', '/'].contains(&c)).unwrap_or(0);
        self.ids.insert(begin + length, id.clone());
        id
    }

    /// The text with an id for each element that draws.
    pub fn with_ids(&self, text: &str) -> String {
        let mut out = String::with_capacity(text.len() + 24 * self.ids.len());
        let mut from = 0;
        for (&at, id) in &self.ids {
            out += &text[from..at];
            out += &format!(" id=\"{id}\"");
            from = at;
        }
        out + &text[from..]
    }
}

/// What the elements that an element is in make of it.
#[derive(Clone, Debug)]
struct State {
    /// Why it is not shown.
    hidden: Option<Rc<str>>,
    /// It is drawn only where something refers to it.
    is_definition: bool,
    /// It and all above it are of SVG.
    is_svg: bool,
}

impl State {
    fn new(node: &Node, above: Option<&State>) -> Self {
        let above_hidden = above.and_then(|above| above.hidden.clone());
        State {
            hidden: above_hidden.or_else(|| has_no_display(node).then(|| hidden(node))),
            is_definition: above.is_some_and(|above| above.is_definition)
                || DEFINITIONS.contains(&node.tag_name().name()),
            is_svg: above.is_none_or(|above| above.is_svg) && node.tag_name().namespace() == Some(SVG),
        }
    }
}

fn inkscape<'a>(node: &Node<'a, '_>, name: &str) -> Option<&'a str> {
    let mut attributes = node.attributes();
    let found = attributes.find(|attribute| {
        attribute.name() == name && attribute.namespace().is_some_and(|space| space.contains("inkscape"))
    });
    found.map(|attribute| attribute.value())
}

/// What an element without display is called.
fn hidden(node: &Node) -> Rc<str> {
    let label = inkscape(node, "label").filter(|_| inkscape(node, "groupmode") == Some("layer"));
    label.map_or("hidden".into(), |label| format!("layer `{label}` is hidden").into())
}

fn has_no_display(node: &Node) -> bool {
    let style = |style: &str| {
        style.split(';').any(|rule| {
            rule.split_once(':').is_some_and(|(name, value)| {
                name.trim() == "display" && value.trim().trim_end_matches("!important").trim() == "none"
            })
        })
    };
    node.attribute("display").is_some_and(|value| value.trim() == "none") || node.attribute("style").is_some_and(style)
}
