//! A reader of decks that knows nothing of their writer: cards, and the model that they describe.
//!
//! [`Deck::read`] takes a deck's text and holds every card against the rules of the keyword guide as it goes; a broken
//! rule is a panic that names the card. The result (nodes, elements, sets, surfaces, sections, materials, rigid bodies,
//! contact, the step) is enough to run the test from the deck alone.

use std::collections::{BTreeMap, BTreeSet};

/// A keyword with its parameters, and its data lines.
#[derive(Clone, Debug, Default)]
pub(crate) struct Card {
    pub(crate) keyword: String,
    pub(crate) parameters: BTreeMap<String, String>,
    pub(crate) data: Vec<Vec<String>>,
}

impl Card {
    /// A parameter that must be there.
    pub(crate) fn parameter(&self, name: &str) -> &str {
        self.parameters.get(name).unwrap_or_else(|| panic!("*{} without {name}", self.keyword))
    }

    /// The numbers of a data line; an empty field is NaN.
    pub(crate) fn numbers(&self, row: usize) -> Vec<f64> {
        let number = |entry: &String| if entry.is_empty() { f64::NAN } else { real(entry) };
        self.data[row].iter().filter(|entry| !entry.is_empty() || self.data[row].len() > 1).map(number).collect()
    }
}

fn real(entry: &str) -> f64 {
    entry.parse().unwrap_or_else(|_| panic!("{entry} is no number"))
}

fn whole(entry: &str) -> u64 {
    entry.parse().unwrap_or_else(|_| panic!("{entry} is no whole number"))
}

/// The cards of a deck; every line is held against the rules of length, and a keyword that goes on after a comma is joined.
pub(crate) fn cards(text: &str) -> Vec<Card> {
    let mut cards: Vec<Card> = Vec::new();
    let mut open = String::new();
    for line in text.lines().filter(|line| !line.starts_with("**")) {
        let is_keyword = line.starts_with('*') || !open.is_empty();
        assert!(line.is_ascii() && line.len() <= if is_keyword { 79 } else { 256 }, "{line}");
        if is_keyword && line.ends_with(',') {
            open += line;
        } else if is_keyword {
            cards.push(keyword(&(std::mem::take(&mut open) + line)));
        } else {
            data(cards.last_mut().expect("a deck begins with a keyword"), line);
        }
    }
    cards
}

fn keyword(line: &str) -> Card {
    let mut entries = line[1..].split(',').map(str::trim);
    let keyword = entries.next().unwrap().to_owned();
    let split =
        |entry: &str| entry.split_once('=').map_or((entry.to_owned(), String::new()), |(a, b)| (a.into(), b.into()));
    Card { keyword, parameters: entries.map(split).collect(), data: Vec::new() }
}

fn data(card: &mut Card, line: &str) {
    if card.keyword == "HEADING" {
        return card.data.push(vec![line.to_owned()]);
    }
    let mut entries: Vec<String> = line.split(',').map(|entry| entry.trim().to_owned()).collect();
    assert!(entries.len() <= 16, "{line}");
    let too_long = entries.iter().find(|entry| entry.parse::<f64>().is_ok() && entry.len() > 20);
    assert!(too_long.is_none(), "{too_long:?}");
    if entries.len() > 1 && entries.last().is_some_and(String::is_empty) {
        entries.pop();
    }
    card.data.push(entries);
}

/// Elements by their types, and how many nodes each has.
pub(crate) const NODES: [(&str, usize); 8] =
    [("C3D4", 4), ("C3D10", 10), ("C3D10M", 10), ("C3D8", 8), ("C3D8R", 8), ("COH3D6", 6), ("COH3D8", 8), ("R3D3", 3)];

/// The corners of an element's faces, S1 first, counted from 0: the guide's numbering.
fn faces(kind: &str) -> &'static [&'static [usize]] {
    if kind.starts_with("C3D8") {
        &[&[0, 1, 2, 3], &[4, 7, 6, 5], &[0, 4, 5, 1], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0]]
    } else {
        &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]]
    }
}

/// Keywords that need no data line.
const WITHOUT_DATA: [&str; 16] = [
    "MATERIAL",
    "SOLID SECTION",
    "SECTION CONTROLS",
    "RIGID BODY",
    "SURFACE INTERACTION",
    "STEP",
    "STATIC",
    "FIXED MASS SCALING",
    "RESTART",
    "OUTPUT",
    "END STEP",
    "BOUNDARY",
    "HEADING",
    "EQUATION",
    "NODE",
    "ELEMENT",
];

/// An element of a deck.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub(crate) kind: String,
    pub(crate) nodes: Vec<u64>,
}

/// Parts of a surface.
#[derive(Clone, Debug)]
pub(crate) enum Surface {
    /// Nodes.
    Nodes(Vec<u64>),
    /// Elements with the number of their face, 1 for S1.
    Faces(Vec<(u64, usize)>),
    /// The positive sides of a rigid set's elements.
    Positive(String),
}

/// A section: which set has which material.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub(crate) set: String,
    pub(crate) material: String,
    /// The section controls' parameters, where it names some.
    pub(crate) controls: Option<Card>,
    pub(crate) cohesive: bool,
}

/// The one step of a deck.
#[derive(Clone, Debug, Default)]
pub(crate) struct Step {
    /// Its cards, in order.
    pub(crate) cards: Vec<Card>,
}

impl Step {
    /// The first card with this keyword.
    pub(crate) fn card(&self, keyword: &str) -> Option<&Card> {
        self.cards.iter().find(|card| card.keyword == keyword)
    }
}

/// A deck's model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Deck {
    pub(crate) heading: Vec<String>,
    pub(crate) nodes: BTreeMap<u64, [f64; 3]>,
    pub(crate) elements: BTreeMap<u64, Element>,
    pub(crate) node_sets: BTreeMap<String, Vec<u64>>,
    pub(crate) element_sets: BTreeMap<String, Vec<u64>>,
    pub(crate) surfaces: BTreeMap<String, Surface>,
    pub(crate) sections: Vec<Section>,
    /// The cards of every material.
    pub(crate) materials: BTreeMap<String, Vec<Card>>,
    /// Reference node, and the card with its ELSET or PIN NSET.
    pub(crate) rigid_bodies: Vec<(u64, Card)>,
    pub(crate) amplitudes: BTreeMap<String, Card>,
    pub(crate) friction: Option<f64>,
    pub(crate) equations: usize,
    pub(crate) step: Option<Step>,
}

impl Deck {
    /// Reads `text`, and panics at the first rule that it breaks.
    pub(crate) fn read(text: &str) -> Self {
        let mut deck = Self::default();
        let (mut material, mut controls, mut in_step) = (String::new(), BTreeMap::new(), false);
        for card in cards(text) {
            let needs_data = !WITHOUT_DATA.contains(&card.keyword.as_str());
            assert!(!needs_data || !card.data.is_empty(), "*{} without data", card.keyword);
            match card.keyword.as_str() {
                "END STEP" => in_step = false,
                _ if in_step => deck.step.as_mut().unwrap().cards.push(card),
                "STEP" => {
                    assert!(deck.step.is_none(), "one step");
                    (deck.step, in_step) = (Some(Step { cards: vec![card] }), true);
                }
                "SECTION CONTROLS" => drop(controls.insert(card.parameter("NAME").to_owned(), card)),
                "SOLID SECTION" | "COHESIVE SECTION" => deck.add_section(&card, &controls),
                "MATERIAL" => {
                    material = card.parameter("NAME").to_owned();
                    assert!(deck.materials.insert(material.clone(), Vec::new()).is_none(), "{material} twice");
                }
                "AMPLITUDE" => drop(deck.amplitudes.insert(card.parameter("NAME").to_owned(), card)),
                "FRICTION" => deck.friction = Some(card.numbers(0)[0]),
                "SURFACE INTERACTION" => {}
                "EQUATION" => deck.equations += 1,
                "HEADING" => deck.heading = card.data.into_iter().map(|mut row| row.remove(0)).collect(),
                "NODE" | "ELEMENT" | "NSET" | "SURFACE" | "RIGID BODY" => deck.add_mesh(&card),
                _ => deck.materials.get_mut(&material).expect("a material's card follows *MATERIAL").push(card),
            }
        }
        assert!(!in_step, "*STEP without *END STEP");
        deck.check();
        deck
    }

    fn add_mesh(&mut self, card: &Card) {
        match card.keyword.as_str() {
            "NODE" => {
                assert!(self.nodes.is_empty(), "one block of nodes: readers keep one alone");
                for (i, row) in card.data.iter().enumerate() {
                    let number = whole(&row[0]);
                    let place = card.numbers(i);
                    assert!(self.nodes.insert(number, [place[1], place[2], place[3]]).is_none(), "node {number} twice");
                    if let Some(set) = card.parameters.get("NSET") {
                        self.node_sets.entry(set.clone()).or_default().push(number);
                    }
                }
            }
            "ELEMENT" => self.add_elements(card),
            "NSET" => {
                let given: Vec<u64> = card.data.iter().flatten().map(|entry| whole(entry)).collect();
                let members =
                    if card.parameters.contains_key("GENERATE") { (given[0]..=given[1]).collect() } else { given };
                assert!(!members.is_empty(), "an empty set is an error");
                assert!(members.windows(2).all(|pair| pair[0] < pair[1]), "a set's members ascend");
                assert!(members.iter().all(|node| self.nodes.contains_key(node)), "a set names its nodes after them");
                self.node_sets.insert(card.parameter("NSET").to_owned(), members);
            }
            "SURFACE" => self.add_surface(card),
            _ => self.rigid_bodies.push((whole(card.parameter("REF NODE")), card.clone())),
        }
    }

    fn add_elements(&mut self, card: &Card) {
        let (kind, set) = (card.parameter("TYPE"), card.parameter("ELSET"));
        let (_, count) = NODES.iter().find(|(known, _)| *known == kind).unwrap_or_else(|| panic!("{kind}"));
        assert!(!card.data.is_empty(), "an empty set is an error");
        let mut last = 0;
        for row in &card.data {
            let numbers: Vec<u64> = row.iter().map(|entry| whole(entry)).collect();
            let distinct: BTreeSet<u64> = numbers[1..].iter().copied().collect();
            assert!(distinct.len() == *count && numbers.len() == count + 1, "{row:?}");
            assert!(distinct.iter().all(|node| self.nodes.contains_key(node)), "{row:?}");
            assert!(numbers[0] > last, "numbers ascend in a block");
            last = numbers[0];
            let element = Element { kind: kind.to_owned(), nodes: numbers[1..].to_vec() };
            assert!(self.elements.insert(numbers[0], element).is_none(), "element {} twice", numbers[0]);
            self.element_sets.entry(set.to_owned()).or_default().push(numbers[0]);
        }
    }

    fn add_surface(&mut self, card: &Card) {
        let surface = match (card.parameter("TYPE"), &card.data[0][..]) {
            ("NODE", [set]) => {
                assert_eq!(card.data.len(), 1, "one entry per line, for CalculiX, too");
                Surface::Nodes(self.node_sets[set.as_str()].clone())
            }
            ("ELEMENT", [set, side]) if side == "SPOS" => {
                assert!(self.element_sets.contains_key(set), "{set}");
                Surface::Positive(set.clone())
            }
            ("ELEMENT", _) => {
                let face =
                    |row: &Vec<String>| (whole(&row[0]), row[1].strip_prefix('S').map_or(0, |n| whole(n) as usize));
                Surface::Faces(card.data.iter().map(face).collect())
            }
            (kind, row) => panic!("a surface of {kind} with {row:?}"),
        };
        self.surfaces.insert(card.parameter("NAME").to_owned(), surface);
    }

    fn add_section(&mut self, card: &Card, controls: &BTreeMap<String, Card>) {
        let named = |name: &String| controls.get(name).unwrap_or_else(|| panic!("controls {name}")).clone();
        self.sections.push(Section {
            set: card.parameter("ELSET").to_owned(),
            material: card.parameter("MATERIAL").to_owned(),
            controls: card.parameters.get("CONTROLS").map(named),
            cohesive: card.keyword == "COHESIVE SECTION",
        });
    }

    /// References from card to card.
    fn check(&self) {
        for section in &self.sections {
            assert!(self.materials.contains_key(&section.material), "{}", section.material);
            let members = &self.element_sets[&section.set];
            let cohesive = |number: &u64| self.elements[number].kind.starts_with("COH");
            assert!(members.iter().all(|number| cohesive(number) == section.cohesive), "{}", section.set);
        }
        let with_section: BTreeSet<&str> = self.sections.iter().map(|section| section.set.as_str()).collect();
        let rigid: BTreeSet<&String> =
            self.rigid_bodies.iter().filter_map(|(_, card)| card.parameters.get("ELSET")).collect();
        let geometry_only = self.materials.is_empty();
        for set in self.element_sets.keys().filter(|set| !geometry_only && !rigid.contains(set)) {
            assert!(with_section.contains(set.as_str()), "{set} has no section");
        }
        for (surface, members) in &self.surfaces {
            if let Surface::Faces(members) = members {
                assert!(members.iter().all(|member| self.face(*member).is_some()), "{surface}");
            }
        }
        for (reference, card) in &self.rigid_bodies {
            assert!(self.nodes.contains_key(reference));
            assert!(card.parameters.get("PIN NSET").is_none_or(|set| self.node_sets.contains_key(set)));
            assert!(card.parameters.get("ELSET").is_none_or(|set| self.element_sets.contains_key(set)));
        }
        self.materials.iter().for_each(|(name, cards)| check_material(name, cards));
        self.check_sides();
        self.check_step();
    }

    /// The corners of an element's face.
    pub(crate) fn face(&self, (element, face): (u64, usize)) -> Option<Vec<u64>> {
        let element = self.elements.get(&element)?;
        let corners = faces(&element.kind).get(face.checked_sub(1)?)?;
        Some(corners.iter().map(|&corner| element.nodes[corner]).collect())
    }

    /// The sets of the six sides hold every node on their bounding planes.
    fn check_sides(&self) {
        let used: BTreeSet<u64> = self.solids().flat_map(|element| element.nodes.iter().copied()).collect();
        let rigid = self.elements.values().filter(|element| element.kind.starts_with('R'));
        let plates: BTreeSet<u64> = rigid.flat_map(|element| element.nodes.iter().copied()).collect();
        let places = || used.iter().map(|node| (*node, self.nodes[node]));
        for (axis, names) in [["XMIN", "XMAX"], ["YMIN", "YMAX"], ["ZMIN", "ZMAX"]].iter().enumerate() {
            let (low, high) = places().fold((f64::MAX, f64::MIN), |(a, b), (_, p)| (a.min(p[axis]), b.max(p[axis])));
            for (name, plane) in names.iter().zip([low, high]) {
                let Some(set) = self.node_sets.get(*name) else { continue };
                let all = places()
                    .filter(|(_, p)| (p[axis] - plane).abs() < 1e-9)
                    .all(|(node, _)| set.binary_search(&node).is_ok());
                assert!(all, "{name} lacks a node on its plane");
                assert!(set.iter().all(|node| !plates.contains(node)), "{name} has a node of a plate");
            }
        }
    }

    /// The elements that are neither rigid nor cohesive.
    pub(crate) fn solids(&self) -> impl Iterator<Item = &Element> {
        self.elements.values().filter(|element| element.kind.starts_with("C3D"))
    }

    fn check_step(&self) {
        let Some(step) = &self.step else { return };
        for card in &step.cards {
            for set in ["NSET", "ELSET"].iter().filter_map(|key| card.parameters.get(*key)) {
                assert!(
                    self.node_sets.contains_key(set) || self.element_sets.contains_key(set),
                    "{} {set}",
                    card.keyword
                );
            }
            if let Some(amplitude) = card.parameters.get("AMPLITUDE") {
                assert!(self.amplitudes.contains_key(amplitude), "{amplitude}");
            }
            match card.keyword.as_str() {
                "CONTACT PAIR" => self.check_pair(card),
                "BOUNDARY" => card.data.iter().for_each(|row| {
                    let known = self.node_sets.contains_key(&row[0])
                        || row[0].parse().is_ok_and(|n| self.nodes.contains_key(&n));
                    assert!(known && whole(&row[1]) <= whole(&row[2]) && whole(&row[2]) <= 6, "{row:?}");
                }),
                _ => {}
            }
        }
    }

    /// Slave and master are there, and where the slave is of faces these are one sheet.
    fn check_pair(&self, card: &Card) {
        for pair in &card.data {
            let [slave, master] = &pair[..] else { panic!("{pair:?}") };
            let is_rigid =
                |set: &String| self.rigid_bodies.iter().any(|(_, card)| card.parameters.get("ELSET") == Some(set));
            assert!(matches!(&self.surfaces[master], Surface::Positive(set) if is_rigid(set)), "the master is rigid");
            match &self.surfaces[slave] {
                Surface::Nodes(nodes) => assert!(!nodes.is_empty()),
                Surface::Faces(_) => assert_eq!(self.sheets(slave), 1, "{slave} must be one sheet"),
                Surface::Positive(_) => panic!("a rigid slave"),
            }
        }
    }

    /// How many pieces a surface of faces has, where two faces hang together by an edge.
    pub(crate) fn sheets(&self, surface: &str) -> usize {
        let Surface::Faces(members) = &self.surfaces[surface] else { panic!("{surface} is not of faces") };
        let corners: Vec<Vec<u64>> = members.iter().map(|member| self.face(*member).unwrap()).collect();
        let mut at_edge: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
        for (i, face) in corners.iter().enumerate() {
            for k in 0..face.len() {
                let (a, b) = (face[k], face[(k + 1) % face.len()]);
                at_edge.entry([a.min(b), a.max(b)]).or_default().push(i);
            }
        }
        let mut piece: Vec<usize> = (0..corners.len()).collect();
        fn root(piece: &mut [usize], mut i: usize) -> usize {
            while piece[i] != i {
                piece[i] = piece[piece[i]];
                i = piece[i];
            }
            i
        }
        for faces in at_edge.values() {
            let first = root(&mut piece, faces[0]);
            faces[1..].iter().for_each(|&other| {
                let other = root(&mut piece, other);
                piece[other] = first;
            });
        }
        (0..corners.len()).filter(|&i| piece[i] == i).count()
    }
}

/// The rules of a material's curves: first rows, rising abscissae, damage below one, plastic strains that never fall.
fn check_material(name: &str, cards: &[Card]) {
    let card = |keyword: &str| cards.iter().find(|card| card.keyword == keyword);
    let elastic = card("ELASTIC").unwrap_or_else(|| panic!("{name} has no stiffness"));
    assert!(card("DENSITY").is_some_and(|card| card.numbers(0)[0] > 0.0), "{name} has no density");
    let curves = [
        ("CONCRETE COMPRESSION HARDENING", "CONCRETE COMPRESSION DAMAGE"),
        ("CONCRETE TENSION STIFFENING", "CONCRETE TENSION DAMAGE"),
    ];
    for (stress, damage) in curves {
        assert_eq!(card("CONCRETE DAMAGED PLASTICITY").is_some(), card(stress).is_some(), "{name}: {stress}");
        let (Some(stress), Some(damage)) = (card(stress), card(damage)) else { continue };
        assert_eq!(stress.parameters, damage.parameters, "{name}: one abscissa for both");
        let plastic = plastic_strains(stress, damage, elastic.numbers(0)[0]);
        assert!(plastic.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9), "{name}: {plastic:?}");
    }
    if let Some(evolution) = card("DAMAGE EVOLUTION") {
        assert!(card("DAMAGE INITIATION").is_some() && evolution.parameter("TYPE") == "ENERGY");
        let energies = evolution.numbers(0);
        let mixed = evolution.parameters.contains_key("MIXED MODE BEHAVIOR");
        assert!(energies.len() == if mixed { 3 } else { 1 } && energies.iter().all(|g| *g > 0.0), "{energies:?}");
        assert_eq!(mixed, evolution.parameters.contains_key("POWER"));
    }
}

/// The inelastic strain of every row less d / (1 - d) s / E; of crack openings over a length of 1 mm.
pub(crate) fn plastic_strains(stress: &Card, damage: &Card, modulus: f64) -> Vec<f64> {
    let rows = |card: &Card| -> Vec<[f64; 2]> {
        (0..card.data.len()).map(|row| <[f64; 2]>::try_from(card.numbers(row)).unwrap()).collect()
    };
    let (stress, damage) = (rows(stress), rows(damage));
    assert!(stress[0][1] == 0.0 && damage[0] == [0.0, 0.0], "curves begin at 0 inelastic and 0 damage");
    assert!(stress.windows(2).all(|pair| pair[0][1] < pair[1][1]), "rows rise");
    let plastic = |([s, strain], [d, same]): (&[f64; 2], &[f64; 2])| {
        assert!(strain == same && (0.0..=0.99).contains(d) && *s > 0.0, "{s} {strain} {d} {same}");
        strain - d / (1.0 - d) * s / modulus
    };
    assert_eq!(stress.len(), damage.len());
    stress.iter().zip(&damage).map(plastic).collect()
}

#[test]
#[should_panic(expected = "*NSET without data")]
fn the_reader_refuses_an_empty_set() {
    Deck::read("*NODE, NSET=ALLNODES\n1, 0.0, 0.0, 0.0\n*NSET, NSET=XMAX\n");
}

/// Two triangles on z = 0 that share node 1 alone, as a plate's slave.
#[test]
fn the_reader_counts_the_sheets_of_a_surface() {
    let nodes = "*NODE\n1, 0.0, 0.0, 0.0\n2, 1.0, 0.0, 0.0\n3, 0.0, 1.0, 0.0\n4, 0.0, 0.0, 1.0\n5, -1.0, 0.0, 0.0\n6, 0.0, -1.0, 0.0\n";
    let by_node =
        "*ELEMENT, TYPE=C3D4, ELSET=A\n1, 1, 2, 3, 4\n2, 1, 5, 6, 4\n*SURFACE, TYPE=ELEMENT, NAME=S\n1, S1\n2, S1\n";
    let by_edge =
        "*ELEMENT, TYPE=C3D4, ELSET=A\n1, 1, 2, 3, 4\n2, 1, 3, 5, 4\n*SURFACE, TYPE=ELEMENT, NAME=S\n1, S1\n2, S1\n";
    assert_eq!([by_node, by_edge].map(|rest| Deck::read(&(nodes.to_owned() + rest)).sheets("S")), [2, 1]);
}
