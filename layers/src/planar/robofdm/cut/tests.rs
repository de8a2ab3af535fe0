//! Cuts and labels against all that there are.

use super::{FlowNetwork, Labelling};
use proptest::prelude::*;

/// Least capacity of all cuts between the first and the last node, by trying them all.
fn least_cut(nodes: usize, arcs: &[(usize, usize, u64, u64)]) -> u64 {
    (0..1u32 << nodes)
        .filter(|set| set & 1 == 1 && set >> (nodes - 1) & 1 == 0)
        .map(|set| cut_value(arcs, |v| set >> v & 1 == 1))
        .min()
        .unwrap()
}

fn cut_value(arcs: &[(usize, usize, u64, u64)], is_source_side: impl Fn(usize) -> bool) -> u64 {
    let crosses = |&(a, b, forth, back): &(usize, usize, u64, u64)| match (is_source_side(a), is_source_side(b)) {
        (true, false) => forth,
        (false, true) => back,
        _ => 0,
    };
    arcs.iter().map(crosses).sum()
}

/// The least energy, by trying all labels.
fn least_energy(labelling: &Labelling) -> u64 {
    let nodes = labelling.node_costs.len() / labelling.labels;
    let all = labelling.labels.pow(nodes as u32);
    let labels = |mut code: usize| -> Vec<u32> {
        (0..nodes)
            .map(|_| {
                let label = code % labelling.labels;
                code /= labelling.labels;
                label as u32
            })
            .collect()
    };
    (0..all).map(|code| cost(labelling, &labels(code))).min().unwrap()
}

fn cost(labelling: &Labelling, labels: &[u32]) -> u64 {
    let own: u64 = (0..labels.len()).map(|v| labelling.node_costs[v * labelling.labels + labels[v] as usize]).sum();
    own + labelling
        .edges
        .iter()
        .map(|&(a, b, w)| if labels[a as usize] == labels[b as usize] { 0 } else { w })
        .sum::<u64>()
}

fn graph(labels: std::ops::Range<usize>) -> impl Strategy<Value = Labelling> {
    (1usize..7, labels).prop_flat_map(|(nodes, labels)| {
        let edge = (0..nodes as u32, 0..nodes as u32, 0u64..20);
        (prop::collection::vec(0u64..30, nodes * labels), prop::collection::vec(edge, 0..12)).prop_map(
            move |(node_costs, edges)| Labelling {
                labels,
                node_costs,
                edges: edges.into_iter().filter(|e| e.0 != e.1).collect(),
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_flow_is_the_least_of_all_cuts(
        nodes in 2usize..8,
        arcs in prop::collection::vec((0usize..8, 0usize..8, 0u64..12, 0u64..12), 0..20),
    ) {
        let arcs: Vec<_> = arcs.into_iter().filter(|a| a.0 < nodes && a.1 < nodes && a.0 != a.1).collect();
        let mut network = FlowNetwork::new(nodes);
        arcs.iter().for_each(|&(a, b, forth, back)| network.connect(a, b, forth, back));
        let (flow, side) = network.min_cut(0, nodes - 1);
        prop_assert_eq!(flow, least_cut(nodes, &arcs));
        prop_assert!(side[0] && !side[nodes - 1]);
        prop_assert_eq!(cut_value(&arcs, |v| side[v]), flow);
    }

    #[test]
    fn two_labels_are_an_optimum(labelling in graph(2..3)) {
        let (labels, energies) = labelling.expand();
        prop_assert_eq!(cost(&labelling, &labels), least_energy(&labelling));
        prop_assert_eq!(energies.last(), Some(&cost(&labelling, &labels)));
    }

    #[test]
    fn more_labels_get_cheaper_with_each_step_and_end_within_twice_the_optimum(labelling in graph(3..5)) {
        let (labels, energies) = labelling.expand();
        prop_assert!(energies.windows(2).all(|e| e[1] < e[0]), "{:?}", energies);
        prop_assert_eq!(energies[energies.len() - 1], cost(&labelling, &labels));
        prop_assert!(cost(&labelling, &labels) <= 2 * least_energy(&labelling));
        // No expansion of any label is cheaper: all subsets of nodes are tried.
        for alpha in 0..labelling.labels as u32 {
            for set in 0..1u32 << labels.len() {
                let moved: Vec<u32> =
                    labels.iter().enumerate().map(|(v, &label)| if set >> v & 1 == 1 { alpha } else { label }).collect();
                prop_assert!(cost(&labelling, &moved) >= cost(&labelling, &labels), "{alpha} {set:b}");
            }
        }
    }
}

#[test]
fn nothing_to_label_has_no_labels() {
    assert_eq!(Labelling::default().expand(), (vec![], vec![0]));
    assert_eq!(FlowNetwork::new(2).min_cut(0, 1), (0, vec![true, false]));
    assert_eq!(FlowNetwork::new(1).min_cut(0, 0).0, 0);
}
