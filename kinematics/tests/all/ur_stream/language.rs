//! A reader of the URScript that programs of streams use: text to statements. It follows the manual alone.

use std::iter::Peekable;
use std::vec::IntoIter;

#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    Number(f64, bool),
    Text(String),
    Truth(bool),
    Name(String),
    List(Vec<Expression>),
    At(Box<Expression>, Box<Expression>),
    Call(String, Vec<Expression>),
    Not(Box<Expression>),
    Minus(Box<Expression>),
    Two(String, Box<Expression>, Box<Expression>),
}

#[derive(Clone, Debug)]
pub enum Statement {
    Assign { scope: Option<String>, name: String, value: Expression },
    AssignAt { name: String, at: Expression, value: Expression },
    Run { name: String, thread: String },
    Kill(String),
    Do(Expression),
    If(Vec<(Expression, Vec<Statement>)>, Vec<Statement>),
    While(Expression, Vec<Statement>),
    Return(Expression),
    Function { name: String, arguments: Vec<String>, body: Vec<Statement> },
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Number(f64, bool),
    Text(String),
    Word(String),
    Mark(String),
}

fn tokens(line: &str) -> Vec<Token> {
    let bytes: Vec<char> = line.chars().collect();
    let (mut out, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let from = at;
        let c = bytes[at];
        let take = |at: &mut usize, fits: &dyn Fn(char) -> bool| {
            while *at < bytes.len() && fits(bytes[*at]) {
                *at += 1;
            }
            bytes[from..*at].iter().collect::<String>()
        };
        if c == '#' {
            break;
        } else if c == ' ' {
            at += 1;
        } else if c == '"' {
            at += 1;
            let _ = take(&mut at, &|c| c != '"');
            out.push(Token::Text(bytes[from + 1..at].iter().collect()));
            at += 1;
        } else if c.is_ascii_digit() {
            let word = take(&mut at, &|c| c.is_ascii_digit() || c == '.');
            out.push(Token::Number(word.parse().unwrap(), !word.contains('.')));
        } else if c.is_ascii_alphabetic() {
            out.push(Token::Word(take(&mut at, &|c| c.is_ascii_alphanumeric() || c == '_')));
        } else {
            let two: String = bytes[at..(at + 2).min(bytes.len())].iter().collect();
            let mark = if ["==", "!=", "<=", ">="].contains(&two.as_str()) { two } else { c.to_string() };
            at += mark.len();
            assert!("()[]+-*/<>=,:".contains(c) || c == '!', "{c} in {line}");
            out.push(Token::Mark(mark));
        }
    }
    out
}

type Tokens = Peekable<IntoIter<Token>>;

fn mark(tokens: &mut Tokens, text: &str) -> bool {
    tokens.next_if_eq(&Token::Mark(text.to_owned())).is_some()
}

fn need(tokens: &mut Tokens, text: &str) {
    assert!(mark(tokens, text), "{text} is missing before {tokens:?}");
}

fn list(tokens: &mut Tokens, end: &str) -> Vec<Expression> {
    let mut out = Vec::new();
    while !mark(tokens, end) {
        if !out.is_empty() {
            need(tokens, ",");
        }
        let mut value = any(tokens);
        // A named argument: the names are those of the manual, in its order.
        if mark(tokens, "=") {
            value = any(tokens);
        }
        out.push(value);
    }
    out
}

fn atom(tokens: &mut Tokens) -> Expression {
    let mut value = match tokens.next().expect("an expression") {
        Token::Number(value, whole) => Expression::Number(value, whole),
        Token::Text(text) => Expression::Text(text),
        Token::Mark(m) if m == "(" => {
            let inner = any(tokens);
            need(tokens, ")");
            inner
        }
        Token::Mark(m) if m == "[" => Expression::List(list(tokens, "]")),
        Token::Mark(m) if m == "-" => Expression::Minus(Box::new(atom(tokens))),
        Token::Word(word) => match word.as_str() {
            "True" => Expression::Truth(true),
            "False" => Expression::Truth(false),
            "p" if mark(tokens, "[") => Expression::List(list(tokens, "]")),
            _ if mark(tokens, "(") => Expression::Call(word, list(tokens, ")")),
            _ => Expression::Name(word),
        },
        other => panic!("{other:?} begins no expression"),
    };
    while mark(tokens, "[") {
        value = Expression::At(Box::new(value), Box::new(any(tokens)));
        need(tokens, "]");
    }
    value
}

/// Operators from the weakest to the strongest.
const LEVELS: [&[&str]; 5] = [&["or"], &["and"], &["==", "!=", "<", ">", "<=", ">="], &["+", "-"], &["*", "/"]];

fn level(tokens: &mut Tokens, at: usize) -> Expression {
    if at == 2 && tokens.next_if_eq(&Token::Word("not".to_owned())).is_some() {
        return Expression::Not(Box::new(level(tokens, 2)));
    }
    let Some(operators) = LEVELS.get(at) else { return atom(tokens) };
    let mut value = level(tokens, at + 1);
    loop {
        let is = |token: &Token| match token {
            Token::Word(word) | Token::Mark(word) => operators.contains(&word.as_str()),
            _ => false,
        };
        match tokens.next_if(is) {
            Some(Token::Word(word) | Token::Mark(word)) => {
                value = Expression::Two(word, Box::new(value), Box::new(level(tokens, at + 1)));
            }
            _ => return value,
        }
    }
}

fn any(tokens: &mut Tokens) -> Expression {
    level(tokens, 0)
}

/// Lines that are left, each with its tokens.
type Lines = Peekable<IntoIter<Vec<Token>>>;

fn word(tokens: &mut Tokens) -> String {
    match tokens.next() {
        Some(Token::Word(word)) => word,
        other => panic!("{other:?} is no name"),
    }
}

/// Statements up to a line that begins with one of these words.
fn block(lines: &mut Lines, ends: &[&str]) -> Vec<Statement> {
    let mut out = Vec::new();
    loop {
        let line = lines.peek().expect("an end");
        if let Token::Word(first) = &line[0]
            && ends.contains(&first.as_str())
        {
            return out;
        }
        out.push(statement(lines));
    }
}

fn finish(lines: &mut Lines) {
    assert_eq!(lines.next(), Some(vec![Token::Word("end".to_owned())]));
}

fn condition(tokens: &mut Tokens) -> Expression {
    let value = any(tokens);
    need(tokens, ":");
    value
}

fn statement(lines: &mut Lines) -> Statement {
    let line = lines.next().unwrap();
    let mut tokens = line.into_iter().peekable();
    let first = word(&mut tokens);
    let done = match first.as_str() {
        "def" | "thread" => {
            let name = word(&mut tokens);
            need(&mut tokens, "(");
            let arguments = list(&mut tokens, ")").into_iter();
            need(&mut tokens, ":");
            let name_of = |argument| if let Expression::Name(name) = argument { name } else { panic!() };
            let arguments = arguments.map(name_of).collect();
            let body = block(lines, &["end"]);
            finish(lines);
            Statement::Function { name, arguments, body }
        }
        "while" => {
            let test = condition(&mut tokens);
            let body = block(lines, &["end"]);
            finish(lines);
            Statement::While(test, body)
        }
        "if" => {
            let mut cases = vec![(condition(&mut tokens), block(lines, &["elif", "else", "end"]))];
            let mut otherwise = Vec::new();
            loop {
                let mut next = lines.next().unwrap().into_iter().peekable();
                match word(&mut next).as_str() {
                    "elif" => cases.push((condition(&mut next), block(lines, &["elif", "else", "end"]))),
                    "else" => {
                        need(&mut next, ":");
                        otherwise = block(lines, &["end"]);
                    }
                    _ => break,
                }
            }
            Statement::If(cases, otherwise)
        }
        "return" => Statement::Return(any(&mut tokens)),
        "kill" => Statement::Kill(word(&mut tokens)),
        "global" | "local" => {
            let name = word(&mut tokens);
            need(&mut tokens, "=");
            if tokens.next_if_eq(&Token::Word("run".to_owned())).is_some() {
                let Expression::Call(thread, _) = any(&mut tokens) else { panic!() };
                Statement::Run { name, thread }
            } else {
                Statement::Assign { scope: Some(first), name, value: any(&mut tokens) }
            }
        }
        _ if mark(&mut tokens, "=") => Statement::Assign { scope: None, name: first, value: any(&mut tokens) },
        _ if mark(&mut tokens, "[") => {
            let at = any(&mut tokens);
            need(&mut tokens, "]");
            need(&mut tokens, "=");
            Statement::AssignAt { name: first, at, value: any(&mut tokens) }
        }
        _ => {
            need(&mut tokens, "(");
            Statement::Do(Expression::Call(first, list(&mut tokens, ")")))
        }
    };
    assert_eq!(tokens.next(), None, "more than a statement");
    done
}

/// The function of a program, which is sent to a port: `def` in the first column, all else indented, `end` at last.
pub fn program(text: &str) -> Vec<Statement> {
    let mut rows = text.lines();
    assert!(rows.next().unwrap().starts_with("def "));
    assert_eq!(rows.next_back(), Some("end"));
    assert!(rows.all(|row| row.starts_with("  ")));
    let lines: Vec<Vec<Token>> = text.lines().map(tokens).filter(|line| !line.is_empty()).collect();
    let mut lines = lines.into_iter().peekable();
    let Statement::Function { body, .. } = statement(&mut lines) else { panic!() };
    assert_eq!(lines.next(), None);
    body
}
