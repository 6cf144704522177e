//! A report as LaTeX: a table of `booktabs` for each grid, to be taken into a paper.

use super::section::Section;
use crate::result::gains_text;
use crate::result::table_text::{Sheet, failures, sheets};

/// Tables of all results, with the packages they need in a comment.
pub(super) fn document(sections: &[Section]) -> String {
    let mut text = String::from("% \\usepackage{booktabs}\n");
    for section in sections {
        let scene = &section.results.scene;
        for table in &section.results.tables {
            let gains = gains_text::sheets(table);
            let told = gains.first().map(|(told, _)| told.clone());
            for sheet in sheets(table).into_iter().chain(gains.into_iter().map(|(_, sheet)| sheet)) {
                text += &tabular(scene, &sheet);
            }
            let lines = failures(table).into_iter().chain(told);
            text.extend(lines.map(|line| format!("\n{}\n", escaped(&line))));
        }
    }
    text
}

fn tabular(scene: &str, sheet: &Sheet) -> String {
    // What begins with a bracket would be taken for an option of the line above.
    let row = |texts: &[String]| {
        "{}".to_owned() + &texts.iter().map(|text| cell(text)).collect::<Vec<_>>().join(" & ") + " \\\\\n"
    };
    let columns = format!("l{}", "r".repeat(sheet.head.len().saturating_sub(1)));
    let rows: String = sheet.rows.iter().map(|texts| row(texts)).collect();
    format!(
        "\n\\begin{{table}}\n\\centering\n\\caption{{{}: {}}}\n\\begin{{tabular}}{{{columns}}}\n\\toprule\n{}\\midrule\n{rows}\\bottomrule\n\
         \\end{{tabular}}\n\\end{{table}}\n",
        escaped(scene),
        escaped(&sheet.title),
        row(&sheet.head),
    )
}

/// Bold where it stands between `**`, which only means do that hold after Holm's correction.
fn cell(text: &str) -> String {
    match text.strip_prefix("**").and_then(|rest| rest.split_once("**")) {
        Some((strong, rest)) => format!("\\textbf{{{}}}{}", escaped(strong), escaped(rest)),
        None => escaped(text),
    }
}

fn escaped(text: &str) -> String {
    let mut out = String::new();
    for letter in text.replace("+-", "±").chars() {
        match letter {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', letter]),
            '\\' => out += "\\textbackslash{}",
            '~' => out += "\\textasciitilde{}",
            '^' => out += "\\textasciicircum{}",
            '±' => out += "$\\pm$",
            '↑' => out += "$\\uparrow$",
            '↓' => out += "$\\downarrow$",
            '<' => out += "$<$",
            '>' => out += "$>$",
            letter if letter.is_control() => out.push(' '),
            letter => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_name_is_taken_for_a_command() {
        assert_eq!(
            escaped("a_b & 50% {x} \\input{y} ~^ #$"),
            "a\\_b \\& 50\\% \\{x\\} \\textbackslash{}input\\{y\\} \\textasciitilde{}\\textasciicircum{} \\#\\$"
        );
        assert_eq!(escaped("0.1 +- 0.2 ↓"), "0.1 $\\pm$ 0.2 $\\downarrow$");
    }

    #[test]
    fn only_what_holds_is_bold() {
        let text = |text: &str| text.to_owned();
        let sheet = Sheet {
            title: text("gains"),
            head: vec![text("Method"), text("Mean")],
            rows: vec![vec![text("a_b"), text("**-0.1** (n=3)")], vec![text("c"), text("-0.2")]],
        };
        let drawn = tabular("room", &sheet);
        assert!(drawn.contains("{}a\\_b & \\textbf{-0.1} (n=3) \\\\\n"), "{drawn}");
        assert!(drawn.contains("{}c & -0.2 \\\\\n\\bottomrule"), "{drawn}");
    }
}
