//! One file with its mutants woven in.

use proc_macro2::{LineColumn, Span};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, ReturnType, Type, UnOp};

/// A change of one place.
pub struct Mutant {
    pub id: u64,
    pub file: String,
    pub line: usize,
    pub column: usize,
    pub function: String,
    pub what: String,
}

/// What is put before and after a range of the text.
struct Edit {
    range: [usize; 2],
    before: String,
    after: String,
}

struct Weaver<'a> {
    text: &'a str,
    file: &'a str,
    /// Where each line begins, in bytes.
    lines: Vec<usize>,
    without: &'a [u64],
    next: &'a mut u64,
    mutants: &'a mut Vec<Mutant>,
    /// Type and name of the function, and of those around it.
    function: Vec<String>,
    edits: Vec<Edit>,
}

/// The text of a file with its mutants.
///
/// # Arguments
/// * `without`: numbers of mutants that stay out.
/// * `next`: the number of the next mutant. Those that do not compile have numbers as well, so that the others keep theirs.
/// * `mutants`: takes those of the file.
pub fn woven(
    text: &str,
    file: &str,
    without: &[u64],
    next: &mut u64,
    mutants: &mut Vec<Mutant>,
) -> syn::Result<String> {
    let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(k, _)| k + 1)).collect();
    let mut weaver = Weaver { text, file, lines, without, next, mutants, function: Vec::new(), edits: Vec::new() };
    weaver.visit_file(&syn::parse_file(text)?);
    Ok(weaver.applied())
}

impl Weaver<'_> {
    fn offset(&self, at: LineColumn) -> usize {
        let line = &self.text[self.lines[at.line - 1]..];
        self.lines[at.line - 1] + line.char_indices().nth(at.column).map_or(line.len(), |(k, _)| k)
    }

    fn range(&self, span: Span) -> [usize; 2] {
        [span.start(), span.end()].map(|at| self.offset(at))
    }

    fn source(&self, span: Span) -> &str {
        let [from, to] = self.range(span);
        &self.text[from..to]
    }

    /// The number of a new mutant, unless it is one that does not compile.
    fn add(&mut self, at: Span, what: String) -> Option<u64> {
        let id = *self.next;
        *self.next += 1;
        if self.without.contains(&id) {
            return None;
        }
        let (line, column, function) = (at.start().line, at.start().column + 1, self.function.join("::"));
        self.mutants.push(Mutant { id, file: self.file.to_owned(), line, column, function, what });
        Some(id)
    }

    /// Puts an expression among its mutants.
    fn switch(&mut self, whole: Span, mutants: Vec<(u64, String)>) {
        if mutants.is_empty() {
            return;
        }
        let mut before = "(".to_owned();
        for (id, text) in &mutants {
            before += &format!("if crate::mutant_switch::switched({id}) {{ {text} }} else ");
        }
        before += "{ ";
        self.edits.push(Edit { range: self.range(whole), before, after: " })".to_owned() });
    }

    fn applied(mut self) -> String {
        // All insertions by place; at one place, ends of inner ranges before those of outer ones, and beginnings of outer ranges before those of inner ones.
        self.edits.sort_by_key(|edit| (edit.range[0], usize::MAX - edit.range[1]));
        let mut inserted: Vec<(usize, usize, usize, String)> = Vec::new();
        for (k, edit) in self.edits.drain(..).enumerate() {
            inserted.push((edit.range[0], 1, k, edit.before));
            inserted.push((edit.range[1], 0, usize::MAX - k, edit.after));
        }
        inserted.sort();
        let (mut text, mut last) = (String::new(), 0);
        for (at, _, _, piece) in inserted {
            text += &self.text[last..at];
            text += &piece;
            last = at;
        }
        text + &self.text[last..]
    }

    /// Values that a function may return instead.
    fn returns(output: &ReturnType) -> Vec<&'static str> {
        let ReturnType::Type(_, of) = output else { return vec!["()"] };
        let Type::Path(path) = &**of else { return Vec::new() };
        let Some(last) = path.path.segments.last() else { return Vec::new() };
        match last.ident.to_string().as_str() {
            "bool" => vec!["true", "false"],
            "f64" => vec!["0.0", "1.0", "-1.0"],
            "usize" | "u8" | "u16" | "u32" | "u64" | "u128" => vec!["0", "1"],
            "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => vec!["0", "1", "-1"],
            "Option" => vec!["None"],
            "Vec" => vec!["Vec::new()"],
            "Result" => {
                let is_unit = matches!(&last.arguments, syn::PathArguments::AngleBracketed(args)
                    if matches!(args.args.first(), Some(syn::GenericArgument::Type(Type::Tuple(tuple))) if tuple.elems.is_empty()));
                if is_unit { vec!["Ok(())"] } else { Vec::new() }
            }
            _ => Vec::new(),
        }
    }

    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        if signature.constness.is_some() {
            return;
        }
        self.function.push(signature.ident.to_string());
        if !block.stmts.is_empty() {
            for value in Self::returns(&signature.output) {
                if let Some(id) = self.add(signature.ident.span(), format!("returns {value}")) {
                    let [open, _] = self.range(block.brace_token.span.open());
                    let before = format!(" if crate::mutant_switch::switched({id}) {{ return {value}; }} ");
                    self.edits.push(Edit { range: [open + 1, open + 1], before, after: String::new() });
                }
            }
        }
        visit::visit_block(self, block);
        self.function.pop();
    }
}

/// Whether a condition binds names, so that it cannot stand in parentheses.
fn binds(expr: &Expr) -> bool {
    match expr {
        Expr::Let(_) => true,
        Expr::Binary(binary) => binds(&binary.left) || binds(&binary.right),
        _ => false,
    }
}

/// What takes the place of an operator.
fn others(op: &BinOp) -> &'static [&'static str] {
    match op {
        BinOp::Eq(_) => &["!="],
        BinOp::Ne(_) => &["=="],
        BinOp::And(_) => &["||"],
        BinOp::Or(_) => &["&&"],
        BinOp::Lt(_) => &["==", ">", "<="],
        BinOp::Gt(_) => &["==", "<", ">="],
        BinOp::Le(_) => &[">", "<"],
        BinOp::Ge(_) => &["<", ">"],
        BinOp::Add(_) => &["-", "*"],
        BinOp::Sub(_) => &["+", "/"],
        BinOp::Mul(_) => &["+", "/"],
        BinOp::Div(_) => &["%", "*"],
        BinOp::Rem(_) => &["/", "+"],
        BinOp::Shl(_) => &[">>"],
        BinOp::Shr(_) => &["<<"],
        BinOp::BitAnd(_) => &["|", "^"],
        BinOp::BitOr(_) => &["&", "^"],
        BinOp::BitXor(_) => &["|", "&"],
        BinOp::AddAssign(_) => &["-=", "*="],
        BinOp::SubAssign(_) => &["+=", "/="],
        BinOp::MulAssign(_) => &["+=", "/="],
        BinOp::DivAssign(_) => &["%=", "*="],
        BinOp::RemAssign(_) => &["/=", "+="],
        BinOp::ShlAssign(_) => &[">>="],
        BinOp::ShrAssign(_) => &["<<="],
        BinOp::BitAndAssign(_) => &["|=", "^="],
        BinOp::BitOrAssign(_) => &["&=", "^="],
        BinOp::BitXorAssign(_) => &["|=", "&="],
        _ => &[],
    }
}

fn is_of_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Ident>().is_ok_and(|name| name == "test")
    })
}

impl<'ast> Visit<'ast> for Weaver<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_of_tests(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_of_tests(&item.attrs) {
            self.function(&item.sig, &item.block);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_of_tests(&item.attrs) {
            self.function(&item.sig, &item.block);
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let name = item.self_ty.span();
        let name = self.source(name).split('<').next().unwrap_or("").to_owned();
        self.function.push(name);
        item.items.iter().for_each(|item| self.visit_impl_item(item));
        self.function.pop();
    }

    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_type(&mut self, _: &'ast Type) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}
    fn visit_expr_repeat(&mut self, expr: &'ast syn::ExprRepeat) {
        self.visit_expr(&expr.expr);
    }
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        if let Some((_, guard)) = arm.guard.as_ref().filter(|(_, guard)| !binds(guard)) {
            let values = ["true", "false"].map(|value| (self.add(guard.span(), format!("guard is {value}")), value));
            let values = values.into_iter().filter_map(|(id, value)| Some((id?, value.to_owned()))).collect();
            self.switch(guard.span(), values);
        }
        visit::visit_arm(self, arm);
    }

    fn visit_expr_binary(&mut self, expr: &'ast syn::ExprBinary) {
        let whole = expr.span();
        if !(binds(&expr.left) || binds(&expr.right)) {
            let of = self.source(expr.op.span()).to_owned();
            let [left, right] = [&expr.left, &expr.right].map(|side| self.source(side.span()).to_owned());
            let others = others(&expr.op).iter();
            let mutants = others
                .filter_map(|other| {
                    let id = self.add(expr.op.span(), format!("{of} to {other}"))?;
                    // Another operator may bind otherwise.
                    Some((id, format!("({left}) {other} ({right})")))
                })
                .collect();
            self.switch(whole, mutants);
        }
        visit::visit_expr_binary(self, expr);
    }

    fn visit_expr_unary(&mut self, expr: &'ast syn::ExprUnary) {
        let what = match expr.op {
            UnOp::Not(_) => "without !",
            UnOp::Neg(_) if !matches!(*expr.expr, Expr::Lit(_)) => "without -",
            _ => return visit::visit_expr_unary(self, expr),
        };
        if !binds(&expr.expr) {
            let inner = self.source(expr.expr.span()).to_owned();
            let mutant = self.add(expr.span(), what.to_owned()).map(|id| (id, inner));
            self.switch(expr.span(), mutant.into_iter().collect());
        }
        visit::visit_expr_unary(self, expr);
    }
}
