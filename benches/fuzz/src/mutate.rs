//! A driver without libFuzzer, for where that does not build: `mutate ENTRY SEEDS RUNS [START]` changes the files of a folder at random and runs
//! the entry on them. Each panic, and each run above ten seconds, is kept as a file and counted once for each place. It sees no coverage, so it
//! changes words and numbers as well as bytes.

mod geometry;
mod memory;
mod programs;
mod readers;
mod replay;
mod seeds;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: memory::Limited = memory::Limited;

type Entry = (&'static str, fn(&[u8]));

/// A run above this is a find.
const SLOW: Duration = Duration::from_secs(10);
/// Longest input, in bytes: longer ones are slow, and find nothing more.
const LONGEST: usize = 20_000;

/// What numbers are replaced by.
#[rustfmt::skip]
const NUMBERS: [&str; 28] = [
    "0", "-0", "1", "-1", "2", "3", "255", "256", "65535", "65536", "2147483647", "2147483648", "-2147483648", "4294967295", "4294967296",
    "9223372036854775807", "18446744073709551615", "1e9", "1e15", "1e308", "1e400", "-1e308", "1e-308", "nan", "inf", "-inf", "0.1", "99999999",
];

/// Numbers by xorshift (G. Marsaglia, 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }

    /// A range of the bytes, short ones more often.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let from = self.below(length + 1);
        let most = [1, 4, 16, 64, 1024][self.below(5)];
        from..(from + self.below(most + 1)).min(length)
    }
}

/// The runs of bytes of one kind: numbers, words, and single marks.
fn words(data: &[u8]) -> Vec<std::ops::Range<usize>> {
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'+' | b'_');
    let mut found = Vec::new();
    let mut at = 0;
    while at < data.len() {
        let from = at;
        at += 1;
        while is_word(data[from]) && at < data.len() && is_word(data[at]) {
            at += 1;
        }
        found.push(from..at);
    }
    found
}

fn change(data: &mut Vec<u8>, seeds: &[Vec<u8>], random: &mut Random) {
    match random.below(11) {
        0 if !data.is_empty() => {
            let at = random.below(data.len());
            data[at] ^= 1 << random.below(8);
        }
        1 if !data.is_empty() => {
            let at = random.below(data.len());
            data[at] = [0, 255, 127, 128, b'\n', b' ', random.below(256) as u8][random.below(7)];
        }
        2 => {
            let range = random.range(data.len());
            data.drain(range);
        }
        3 => {
            let chunk = data[random.range(data.len())].to_vec();
            let at = random.below(data.len() + 1);
            data.splice(at..at, chunk);
        }
        4 => {
            let other = &seeds[random.below(seeds.len())];
            let chunk = other[random.range(other.len())].to_vec();
            let range = random.range(data.len());
            data.splice(range, chunk);
        }
        5 if random.below(4) == 0 => data.truncate(random.below(data.len() + 1)),
        6 => {
            let word: Vec<u8> = (0..1 + random.below(8)).map(|_| random.below(256) as u8).collect();
            let range = random.range(data.len());
            let end = range.end.min(range.start + word.len());
            data.splice(range.start..end, word);
        }
        kind => change_word(data, kind, random),
    }
}

/// A word or a number by another one, doubled or left out.
fn change_word(data: &mut Vec<u8>, kind: usize, random: &mut Random) {
    let all = words(data);
    if all.is_empty() {
        return;
    }
    let one = all[random.below(all.len())].clone();
    let is_number = data[one.clone()].iter().any(u8::is_ascii_digit);
    let new = match kind {
        7 | 8 if is_number => NUMBERS[random.below(NUMBERS.len())].as_bytes().to_vec(),
        9 => Vec::new(),
        _ => data[all[random.below(all.len())].clone()].to_vec(),
    };
    data.splice(one, new);
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if std::env::var("CURVLAY_FUZZ").is_ok_and(|name| name == "seeds") {
        return seeds::write().expect("seeds are written");
    }
    let [_, name, folder, runs, rest @ ..] = &arguments[..] else { panic!("mutate ENTRY SEEDS RUNS [START]") };
    let all = [readers::ENTRIES, programs::ENTRIES, geometry::ENTRIES].concat();
    let names = || all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" ");
    let entry = all.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("entries: {}", names())).1;
    let runs: u64 = runs.parse().expect("a number of runs");
    let start: u64 = rest.first().map_or(1, |start| start.parse().expect("a number to start from"));
    let found = run(name, entry, &read_seeds(Path::new(folder)), runs, start);
    std::process::exit((found > 0).into());
}

fn read_seeds(folder: &Path) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).map(|all| all.flatten().map(|entry| entry.path()).collect()).unwrap_or_default();
    paths.sort();
    let mut seeds: Vec<Vec<u8>> = paths.iter().filter_map(|path| std::fs::read(path).ok()).collect();
    seeds.push((0..=255).collect());
    seeds
}

fn run(name: &str, entry: fn(&[u8]), seeds: &[Vec<u8>], runs: u64, start: u64) -> usize {
    static PLACE: Mutex<String> = Mutex::new(String::new());
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map(ToString::to_string).unwrap_or_default();
        *PLACE.lock().expect("one thread") = format!("{place} {}", panic.payload_as_str().unwrap_or_default());
    }));
    let mut random = Random(start.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut finds: BTreeMap<String, usize> = BTreeMap::new();
    let (begin, mut slowest) = (Instant::now(), Duration::ZERO);
    let current = readers::file("current", &[]);
    for _ in 0..runs {
        let mut data = seeds[random.below(seeds.len())].clone();
        for _ in 0..1 + random.below(6) {
            change(&mut data, seeds, &mut random);
        }
        data.truncate(LONGEST);
        // What ends the process leaves its input here.
        std::fs::write(&current, &data).expect("an input is written");
        let at = Instant::now();
        let is_panic = std::panic::catch_unwind(|| entry(&data)).is_err();
        let time = at.elapsed();
        slowest = slowest.max(time);
        if is_panic || time > SLOW {
            let place = if is_panic { PLACE.lock().expect("one thread").clone() } else { format!("slow: {time:?}") };
            let number = finds.len();
            let key = place.split_once(' ').map_or(place.as_str(), |(key, _)| key).to_owned();
            if finds.insert(key, number).is_none() {
                let file = format!("find-{name}-{number}");
                std::fs::write(&file, &data).expect("a find is written");
                println!("{name}: {file}: {}", place.chars().take(200).collect::<String>());
            }
        }
    }
    let (seconds, finds) = (begin.elapsed().as_secs_f64(), finds.len());
    println!(
        "{name}: {runs} runs from {start} in {seconds:.0} s, slowest {:.3} s, {finds} finds",
        slowest.as_secs_f64()
    );
    finds
}
