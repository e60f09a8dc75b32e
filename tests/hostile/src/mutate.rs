//! From a valid file to a hostile one.
//!
//! A mutation depends on the content that it breaks: numbers in text become unusual numbers, counts in binary files become counts
//! that no memory holds, lines are doubled, words of the format stand where they do not belong.

/// Random numbers from a seed, the same on every machine (splitmix64, Steele, Lea and Flood 2014).
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A stream of its own for each seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`; 0 if that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % (end.max(1) as u64)) as usize
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of these.
    pub fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Make of a file, as far as mutations need it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Make {
    /// Lines of words and numbers. These words mean something in the format.
    Text(&'static [&'static str]),
    /// Little-endian numbers.
    Binary,
}

/// Numbers that readers do not expect.
const NUMBERS: [&str; 36] = [
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e308",
    "-1e308",
    "1e309",
    "1e-308",
    "5e-324",
    "1e-400",
    "1e154",
    "1e-160",
    "1e30",
    "1e16",
    "9007199254740993",
    "nan",
    "-nan",
    "NaN",
    "inf",
    "-inf",
    "+inf",
    "255",
    "256",
    "65536",
    "2147483647",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "340282366920938463463374607431768211456",
];

/// Pieces that stand nowhere in a proper file.
const PIECES: [&[u8]; 34] = [
    b"\0",
    b"\0\0\0\0\0\0\0\0",
    b"\xff",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\xc3\x28",
    b"\xf0\x9f\x98\x80",
    "\u{b5}\u{e4}\u{2028}".as_bytes(),
    b"\r",
    b"\r\n",
    b"\n",
    b"\n\n\n",
    b"\t",
    b" ",
    b"\x0b\x0c",
    b"\x1b[2J",
    b"\"",
    b"\"\"\"",
    b"'",
    b"'''",
    b"#",
    b"//",
    b"%",
    b",",
    b",,,,",
    b";",
    b"=",
    b"=\n=\n",
    b"[[[[[[[[",
    b"]]]]",
    b"{{{{{{{{",
    b"}",
    b"-",
    b".",
];

/// Binary numbers that readers do not expect, as 64 bits.
const BITS: [u64; 24] = [
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x1_0000_0000,
    0x3fff_ffff_ffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    0x7fe1_ccf3_85eb_c8a0,
    0x0000_0000_0000_0001,
    0xfff0_0000_0000_0000,
];

/// Files do not grow beyond this, in bytes, but for [`grown`].
const LARGEST: usize = 1 << 17;

/// A hostile file made of valid ones: one to six mutations of one of them.
#[must_use]
pub fn mutated(random: &mut Random, samples: &[Vec<u8>], make: Make) -> Vec<u8> {
    let mut file = random.pick(samples).clone();
    for _ in 0..1 + random.below(6).min(random.below(6)) {
        match make {
            Make::Text(words) if !random.one_in(6) => change_text(random, &mut file, words),
            Make::Binary if !random.one_in(3) => change_number(random, &mut file),
            _ => change_bytes(random, &mut file, samples),
        }
        file.truncate(LARGEST);
    }
    file
}

/// Any bytes at all, or any text.
#[must_use]
pub fn arbitrary(random: &mut Random) -> Vec<u8> {
    let length = random.below(1 + random.clone().below(400));
    let readable = random.one_in(2);
    let byte = |_| {
        let byte = random.bits() as u8;
        if readable {
            b"0123456789.eE+-,;# \n\t\"[]{}=abcfnovxyz"[usize::from(byte) % 37]
        } else {
            byte
        }
    };
    (0..length).map(byte).collect()
}

/// A file of some hundred kilobytes in which one piece comes again and again: what takes more than linear time shows.
#[must_use]
pub fn grown(random: &mut Random, samples: &[Vec<u8>], make: Make, size: usize) -> Vec<u8> {
    let mut file = random.pick(samples).clone();
    if random.one_in(2) {
        file = mutated(random, samples, make);
    }
    let lines = line_starts(&file);
    let piece = match random.below(4) {
        0 => random.pick(&PIECES).to_vec(),
        1 => {
            let (from, to) = range(random, file.len());
            file[from..to].to_vec()
        }
        // A line, or several; often the last of them in which a number counts up, so that names and places differ.
        _ => {
            let from = random.below(lines.len());
            let to = (from + 1 + random.below(3)).min(lines.len() - 1).max(from);
            file[lines[from]..lines[to].max(lines[from])].to_vec()
        }
    };
    if piece.is_empty() {
        return file;
    }
    let at = match random.below(3) {
        0 => file.len(),
        1 => random.below(file.len() + 1),
        _ => *random.pick(&lines),
    };
    let count_up = random.one_in(2);
    let mut middle = Vec::new();
    let mut number = 0u64;
    while middle.len() + file.len() < size {
        number += 1;
        if count_up {
            put_counted(&piece, number, &mut middle);
        } else {
            middle.extend_from_slice(&piece);
        }
    }
    file.splice(at..at, middle);
    file
}

/// The piece with its first digits, or else its first letter, replaced by a number.
fn put_counted(piece: &[u8], number: u64, out: &mut Vec<u8>) {
    let text = number.to_string();
    let digits = piece.iter().position(u8::is_ascii_digit);
    match digits.or_else(|| piece.iter().position(u8::is_ascii_alphabetic)) {
        Some(at) => {
            out.extend_from_slice(&piece[..at]);
            if piece[at].is_ascii_alphabetic() {
                out.push(piece[at]);
            }
            out.extend_from_slice(text.as_bytes());
            let rest = &piece[at + 1..];
            let behind = rest.iter().position(|byte| !byte.is_ascii_digit());
            out.extend_from_slice(&rest[behind.unwrap_or(rest.len())..]);
        }
        None => out.extend_from_slice(piece),
    }
}

/// Two places in order.
fn range(random: &mut Random, length: usize) -> (usize, usize) {
    let from = random.below(length + 1);
    let most = if random.one_in(3) { length } else { 40 };
    let to = (from + random.below(most + 1)).min(length);
    (from, to)
}

fn line_starts(file: &[u8]) -> Vec<usize> {
    let behind = file.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
    std::iter::once(0)
        .chain(behind.map(|(at, _)| at + 1))
        .collect()
}

/// Where numbers stand in a text.
fn numbers(file: &[u8]) -> Vec<(usize, usize)> {
    let part = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    let mut found = Vec::new();
    let mut at = 0;
    while at < file.len() {
        if !part(file[at]) {
            at += 1;
            continue;
        }
        let end = file[at..].iter().position(|byte| !part(*byte));
        let end = end.map_or(file.len(), |length| at + length);
        if file[at..end].iter().any(u8::is_ascii_digit) {
            found.push((at, end));
        }
        at = end;
    }
    found
}

fn change_text(random: &mut Random, file: &mut Vec<u8>, words: &[&str]) {
    match random.below(13) {
        0..=4 => {
            let places = numbers(file);
            if !places.is_empty() {
                let (from, to) = *random.pick(&places);
                let number = *random.pick(&NUMBERS);
                file.splice(from..to, number.bytes());
            }
        }
        5 => {
            // One number for all of a kind.
            let places = numbers(file);
            if !places.is_empty() {
                let (from, to) = *random.pick(&places);
                let old = file[from..to].to_vec();
                let new = random.pick(&NUMBERS).as_bytes().to_vec();
                for (from, to) in places.into_iter().rev() {
                    if file[from..to] == old[..] {
                        file.splice(from..to, new.iter().copied());
                    }
                }
            }
        }
        6 => {
            let at = random.below(file.len() + 1);
            if !words.is_empty() {
                let word = *random.pick(words);
                file.splice(at..at, word.bytes());
            }
        }
        7 => {
            // A word in place of another one.
            let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_-.".contains(byte);
            let at = random.below(file.len() + 1);
            let behind = file[at..].iter().position(is_word);
            if let (Some(behind), false) = (behind, words.is_empty()) {
                let from = at + behind;
                let length = file[from..].iter().position(|byte| !is_word(byte));
                let to = length.map_or(file.len(), |length| from + length);
                let word = *random.pick(words);
                file.splice(from..to, word.bytes());
            }
        }
        8..=10 => change_lines(random, file),
        11 => {
            let piece = random.pick(&PIECES).to_vec();
            let times = if random.one_in(10) { 5000 } else { 1 };
            let at = random.below(file.len() + 1);
            file.splice(at..at, piece.repeat(times));
        }
        _ => match random.below(6) {
            0 => {
                file.splice(0..0, *b"\xef\xbb\xbf");
            }
            1 => {
                *file = String::from_utf8_lossy(file)
                    .replace('\n', "\r\n")
                    .into_bytes()
            }
            2 => {
                *file = String::from_utf8_lossy(file)
                    .replace('\n', "\r")
                    .into_bytes()
            }
            3 => *file = String::from_utf8_lossy(file).replace('.', ",").into_bytes(),
            4 => file.retain(|byte| *byte != b'\n'),
            _ => file.clear(),
        },
    }
}

fn change_lines(random: &mut Random, file: &mut Vec<u8>) {
    let starts = line_starts(file);
    let line = |k: usize| (starts[k], *starts.get(k + 1).unwrap_or(&file.len()));
    let (from, to) = line(random.below(starts.len()));
    let (other_from, other_to) = line(random.below(starts.len()));
    let text = file[from..to].to_vec();
    match random.below(5) {
        0 => {
            file.drain(from..to);
        }
        1 => {
            let times = if random.one_in(8) {
                1 + random.below(500)
            } else {
                1
            };
            file.splice(to..to, text.repeat(times));
        }
        2 => {
            file.splice(other_from..other_from, text);
        }
        3 => {
            let other = file[other_from..other_to].to_vec();
            file.splice(from..to, other);
        }
        // Cut as when a disk is full, or a run is killed.
        _ => file.truncate(from + random.below(to - from + 1)),
    }
}

/// Writes an unusual number over bytes of a binary file.
fn change_number(random: &mut Random, file: &mut [u8]) {
    let width = *random.pick(&[1, 2, 4, 4, 8, 8]);
    if file.len() < width {
        return;
    }
    let mut at = random.below(file.len() - width + 1);
    // Heads stand in front.
    if random.one_in(3) {
        at = random.below((file.len() - width + 1).min(512));
    }
    // Numbers mostly lie at multiples of their width.
    if !random.one_in(4) {
        at -= at % width;
    }
    let old = file[at..at + width].iter().rev();
    let old = old.fold(0u64, |sum, byte| sum << 8 | u64::from(*byte));
    let new = match random.below(4) {
        0 => old.wrapping_add(1 + random.below(8) as u64),
        1 => old.wrapping_sub(1 + random.below(8) as u64),
        2 if width == 4 => u64::from((*random.pick(&[1e30f32, f32::NAN, -1.0, 1e-40])).to_bits()),
        _ => *random.pick(&BITS),
    };
    file[at..at + width].copy_from_slice(&new.to_le_bytes()[..width]);
}

fn change_bytes(random: &mut Random, file: &mut Vec<u8>, samples: &[Vec<u8>]) {
    let (from, to) = range(random, file.len());
    match random.below(9) {
        0 | 1 => {
            if let Some(byte) = file.get_mut(from) {
                *byte ^= 1 << random.below(8);
            }
        }
        2 => {
            if let Some(byte) = file.get_mut(from) {
                *byte = random.bits() as u8;
            }
        }
        3 => file.truncate(from),
        4 => {
            file.drain(from..to);
        }
        5 => {
            let piece = file[from..to].to_vec();
            let at = random.below(file.len() + 1);
            file.splice(at..at, piece);
        }
        6 => {
            // The front of one, the back of another.
            let other = random.pick(samples);
            let (a, b) = range(random, other.len());
            file.splice(from..to, other[a..b].iter().copied());
        }
        7 => {
            let other = random.pick(samples);
            let at = random.below(other.len() + 1);
            file.truncate(from);
            file.extend_from_slice(&other[at..]);
        }
        _ => {
            let piece = random.pick(&PIECES).to_vec();
            let at = random.below(file.len() + 1);
            file.splice(at..at, piece);
        }
    }
}
