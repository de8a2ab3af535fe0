//! Files by the rules of the specifications: the schema of the Toolpath Extension (1.0, release candidate, appendix B.2) and its sentences with MUST, as far
//! as they concern what we write. An oracle of its own: it knows the namespaces and types from the text, and nothing of the code.

use super::{parts, print, written};
use proptest::prelude::*;
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};

const TP: &str = "http://schemas.3mf.io/3dmanufacturing/toolpath/2026/03";
const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
const P: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
const LAYER: &str = "http://schemas.3mf.io/3dmanufacturing/toolpath/2026/03/layer";

/// Types of the schema.
#[derive(Clone, Copy, Debug)]
enum Type {
    Text,
    Uuid,
    Id,
    Natural,
    Integer,
    Number,
    Positive,
    Scale,
    Path,
    One(&'static [&'static str]),
}

impl Type {
    fn takes(self, text: &str) -> bool {
        let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let number = || {
            let body = text.strip_prefix(['-', '+']).unwrap_or(text);
            let (mantissa, exponent) =
                body.split_once(['e', 'E']).map_or((body, "0"), |(m, e)| (m, e.trim_start_matches(['-', '+'])));
            let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, "0"));
            let is_number = (digits(whole) && (part.is_empty() || digits(part))) && digits(exponent);
            text.parse::<f64>().ok().filter(|value| is_number && value.is_finite())
        };
        match self {
            Type::Text => !text.is_empty(),
            Type::Uuid => {
                let groups: Vec<&str> = text.split('-').collect();
                let lengths: Vec<usize> = groups.iter().map(|group| group.len()).collect();
                lengths == [8, 4, 4, 4, 12] && groups.concat().bytes().all(|byte| byte.is_ascii_hexdigit())
            }
            Type::Id => digits(text) && (1..1_i64 << 31).contains(&text.parse().unwrap()),
            Type::Natural => digits(text) && (0..1_i64 << 31).contains(&text.parse().unwrap()),
            Type::Integer => text.parse::<i32>().is_ok(),
            Type::Number => number().is_some(),
            Type::Positive => number().is_some_and(|value| value > 0.0),
            Type::Scale => number().is_some_and(|value| (0.0..=1.0).contains(&value)),
            Type::Path => text.starts_with('/'),
            Type::One(of) => of.contains(&text),
        }
    }
}

/// What an element may have: attributes with type and whether they are required, and children in their order.
struct Rule {
    attributes: Vec<(&'static str, Type, bool)>,
    children: &'static [&'static str],
}

fn rules() -> BTreeMap<&'static str, Rule> {
    use Type::*;
    let factors = ["e", "f", "g", "h", "e1", "e2", "f1", "f2", "g1", "g2", "h1", "h2"].map(|name| (name, Scale, false));
    let mut point = vec![("x", Integer, true), ("y", Integer, true), ("z", Integer, true), ("tag", Natural, false)];
    point.extend(["i", "j", "k", "w"].map(|name| (name, Number, true)));
    point.extend(factors);
    let mut profile = vec![("uuid", Uuid, true), ("name", Text, true)];
    profile.extend(["depositionspeed", "beadwidth", "beadheight", "jumpspeed"].map(|name| (name, Positive, false)));
    let modifier = vec![
        ("attribute", Text, true),
        ("type", One(&["constant", "linear", "nonlinear"]), true),
        ("minvalue", Number, true),
        ("maxvalue", Number, true),
        ("factor", One(&["e", "f", "g", "h"]), true),
    ];
    let resource = vec![
        ("id", Id, true),
        ("uuid", Uuid, true),
        ("unitfactor", Positive, true),
        ("toolpathtype", One(&["planar", "3axis", "6axis"]), false),
    ];
    let segment = vec![
        ("type", One(&["polyline6d"]), true),
        ("profileid", Id, true),
        ("partid", Id, true),
        ("timeprediction", Natural, false),
        ("jumpprediction", Natural, false),
        ("tag", Natural, false),
    ];
    let of = |attributes, children| Rule { attributes, children };
    let named = || vec![("id", Id, true), ("uuid", Uuid, true)];
    BTreeMap::from([
        ("toolpathresource", of(resource, &["lasersources", "toolpathprofiles", "toolpathlayers", "toolpathdata"][..])),
        ("toolpathprofiles", of(vec![], &["toolpathprofile"])),
        ("toolpathprofile", of(profile, &["modifier"])),
        ("modifier", of(modifier, &[])),
        // `ztop` and `zbottom` MUST be left out where the toolpath is not planar.
        ("toolpathlayers", of(vec![], &["toolpathlayer"])),
        ("toolpathlayer", of(vec![("path", Path, true)], &[])),
        ("layer", of(vec![], &["parts", "profiles", "data", "segments"])),
        ("parts", of(vec![], &["part"])),
        ("part", of(named(), &[])),
        ("profiles", of(vec![], &["profile"])),
        ("profile", of(named(), &[])),
        ("segments", of(vec![], &["segment"])),
        ("segment", of(segment, &["point6d"])),
        ("point6d", of(point, &[])),
    ])
}

/// Holds an element and all below it against the schema.
fn by_schema(node: Node, rules: &BTreeMap<&str, Rule>) {
    let name = node.tag_name().name();
    assert_eq!(node.tag_name().namespace(), Some(TP), "{name}");
    let rule = rules.get(name).unwrap_or_else(|| panic!("no element `{name}` in the schema"));
    for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
        let known = rule.attributes.iter().find(|(other, ..)| *other == attribute.name());
        let (_, kind, _) = known.unwrap_or_else(|| panic!("`{}` has no attribute `{}`", name, attribute.name()));
        assert!(kind.takes(attribute.value()), "{name}: {attribute:?} is no {kind:?}");
    }
    for (required, ..) in rule.attributes.iter().filter(|(.., required)| *required) {
        assert!(node.attribute(*required).is_some(), "{name} without {required}");
    }
    let mut last = 0;
    for child in node.children().filter(Node::is_element) {
        let at = rule.children.iter().position(|known| *known == child.tag_name().name());
        let at = at.unwrap_or_else(|| panic!("`{}` in `{name}`", child.tag_name().name()));
        assert!(at >= last, "{name}: children in another order");
        last = at;
        by_schema(child, rules);
    }
}

/// Modifiers of a profile: the factor, and whether it may be given at both ends.
fn modifiers(profile: Node) -> BTreeMap<String, bool> {
    let mut all = BTreeMap::new();
    let mut attributes = BTreeSet::new();
    for modifier in profile.children().filter(|node| node.has_tag_name((TP, "modifier"))) {
        let text = |name: &str| modifier.attribute(name).unwrap();
        let [min, max]: [f64; 2] = ["minvalue", "maxvalue"].map(|name| text(name).parse().unwrap());
        assert!(min < max && min > 0.0, "{min} {max}");
        assert!(profile.attribute(text("attribute")).is_some(), "the profile has no {}", text("attribute"));
        assert!(attributes.insert(text("attribute")), "two modifiers of an attribute");
        assert!(all.insert(text("factor").to_owned(), text("type") == "linear").is_none(), "a factor twice");
    }
    assert!(all.len() <= 4);
    all
}

/// Factors of a point are no finer than their modifiers, and given in one way.
fn check_factors(point: Node, modifiers: &BTreeMap<String, bool>) {
    for factor in ["e", "f", "g", "h"] {
        let has = |name: String| point.attribute(&name[..]).is_some();
        let given = [has(factor.to_owned()), has(format!("{factor}1")), has(format!("{factor}2"))];
        let is_right = match modifiers.get(factor) {
            None => given == [false; 3],
            Some(false) => given[1..] == [false; 2],
            Some(true) => given[1] == given[2] && !(given[0] && given[1]),
        };
        assert!(is_right, "{factor}: {given:?} {modifiers:?}");
    }
}

fn check_quaternions(segment: Node) {
    let mut before: Option<[f64; 4]> = None;
    let points: Vec<Node> = segment.children().filter(Node::is_element).collect();
    assert!(points.len() >= 2);
    for point in points {
        let turn = ["i", "j", "k", "w"].map(|name| point.attribute(name).unwrap().parse::<f64>().unwrap());
        assert!((turn.iter().map(|n| n * n).sum::<f64>() - 1.0).abs() <= 1e-6, "{turn:?}");
        let dot = |other: [f64; 4]| turn.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        assert!(before.is_none_or(|before| dot(before) >= -1e-9));
        before = Some(turn);
    }
}

/// Holds a package against the rules.
fn check(bytes: &[u8]) {
    let all: BTreeMap<String, String> = parts(bytes).into_iter().collect();
    let rules = rules();
    let types = Document::parse(&all["[Content_Types].xml"]).unwrap();
    let ends: Vec<&str> = types.descendants().filter_map(|node| node.attribute("Extension")).collect();
    assert!(all.keys().all(|name| name.starts_with('[') || ends.iter().any(|end| name.ends_with(&format!(".{end}")))));

    let model = Document::parse(&all["3D/3dmodel.model"]).unwrap();
    let root = model.root_element();
    assert!(root.has_tag_name((CORE, "model")));
    let required: Vec<&str> = root.attribute("requiredextensions").unwrap().split(' ').collect();
    let required: Vec<&str> = required.iter().map(|prefix| root.lookup_namespace_uri(Some(prefix)).unwrap()).collect();
    assert!(required.contains(&P) && required.contains(&TP));
    let resources = root.children().find(|node| node.has_tag_name((CORE, "resources"))).unwrap();
    let order: Vec<&str> = resources.children().filter(Node::is_element).map(|node| node.tag_name().name()).collect();
    assert_eq!(order, ["toolpathresource", "object"]);
    let resource = resources.first_element_child().unwrap();
    by_schema(resource, &rules);
    assert_eq!(resource.attribute("toolpathtype"), Some("6axis"));
    let build = root.children().find(|node| node.has_tag_name((CORE, "build"))).unwrap();
    assert_eq!(build.attribute((TP, "toolpathid")), resource.attribute("id"));

    let profiles: Vec<Node> =
        resource.descendants().filter(|node| node.has_tag_name((TP, "toolpathprofile"))).collect();
    let names: BTreeSet<_> = profiles.iter().map(|profile| profile.attribute("name").unwrap()).collect();
    assert_eq!(names.len(), profiles.len());
    let uuid = |node: &Node| node.attribute((P, "UUID")).or(node.attribute("uuid")).map(str::to_owned);
    let uuids: Vec<String> = root.descendants().filter_map(|node| uuid(&node)).collect();
    assert!(uuids.iter().all(|uuid| Type::Uuid.takes(uuid)));
    assert_eq!(uuids.iter().collect::<BTreeSet<_>>().len(), uuids.len());
    // The resource, its profiles, the object, the build and its item.
    assert_eq!(uuids.len(), profiles.len() + 4);
    let item = build.first_element_child().unwrap();

    let relations = Document::parse(&all["3D/_rels/3dmodel.model.rels"]).unwrap();
    let bound: BTreeSet<&str> = relations
        .descendants()
        .filter(|node| node.attribute("Type") == Some(LAYER))
        .map(|node| node.attribute("Target").unwrap())
        .collect();
    let layers: Vec<&str> = resource.descendants().filter_map(|node| node.attribute("path")).collect();
    assert_eq!(layers.iter().copied().collect::<BTreeSet<_>>(), bound);
    for path in layers {
        check_layer(&all[path.trim_start_matches('/')], &profiles, item.attribute((P, "UUID")).unwrap(), &rules);
    }
}

fn check_layer(text: &str, profiles: &[Node], item: &str, rules: &BTreeMap<&str, Rule>) {
    let layer = Document::parse(text).unwrap();
    let root = layer.root_element();
    by_schema(root, rules);
    let ids = |name: &str| -> BTreeMap<&str, &str> {
        let nodes = root.descendants().filter(|node| node.has_tag_name((TP, name)));
        nodes.map(|node| (node.attribute("id").unwrap(), node.attribute("uuid").unwrap())).collect()
    };
    let (parts, of_layer) = (ids("part"), ids("profile"));
    assert!(parts.values().all(|uuid| *uuid == item));
    let mut segments = 0;
    for segment in root.descendants().filter(|node| node.has_tag_name((TP, "segment"))) {
        segments += 1;
        assert!(parts.contains_key(segment.attribute("partid").unwrap()));
        let uuid = of_layer[segment.attribute("profileid").unwrap()];
        let profile = profiles.iter().find(|profile| profile.attribute("uuid") == Some(uuid)).unwrap();
        let modifiers = modifiers(*profile);
        check_quaternions(segment);
        segment.children().filter(Node::is_element).for_each(|point| check_factors(point, &modifiers));
    }
    assert!(segments > 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn files_keep_the_rules(segments in print()) {
        check(&written(&segments, true));
    }

    #[test]
    fn files_without_travels_keep_them_too(segments in print()) {
        use curvlay_examples::build3mf::SegmentKind;
        prop_assume!(segments.iter().any(|segment| segment.kind != SegmentKind::Travel));
        check(&written(&segments, false));
    }
}

/// The oracle can say no.
#[test]
fn types_of_the_schema_have_bounds() {
    assert!(
        Type::Number.takes("-1.5e-3")
            && Type::Number.takes("2.")
            && !Type::Number.takes("inf")
            && !Type::Number.takes(".e")
    );
    assert!(Type::Scale.takes("1") && !Type::Scale.takes("1.000001") && !Type::Scale.takes("-0.1"));
    assert!(Type::Id.takes("2147483647") && !Type::Id.takes("2147483648") && !Type::Id.takes("0"));
    assert!(Type::Integer.takes("-2147483648") && !Type::Integer.takes("2147483648"));
    assert!(
        !Type::Uuid.takes("92f90fa0-e2cc-4cb0-a56b-aa4fd2f5186")
            && Type::Uuid.takes("92f90fa0-e2cc-4cb0-a56b-aa4fd2f51868")
    );
}
