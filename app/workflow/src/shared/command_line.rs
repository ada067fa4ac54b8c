//! A command line of the program as text, for the provenance of results.

/// A command line of this program as a person would type it.
pub fn shown(arguments: impl Iterator<Item = String>) -> String {
    let mut line = String::from("hysteron");
    let mut arguments = arguments.peekable();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--threads" | "--shard" => {
                arguments.next();
            }
            "--verbose" | "--quiet" | "--json" | "--overwrite" => {}
            text if text.starts_with("--threads=") || text.starts_with("--shard=") => {}
            text if text.len() > 1
                && text.starts_with('-')
                && text[1..].bytes().all(|byte| matches!(byte, b'v' | b'q')) => {}
            text => {
                line.push(' ');
                let is_plain = |c: char| c.is_alphanumeric() || "-_./=:,+%@".contains(c);
                if !text.is_empty() && text.chars().all(is_plain) {
                    line.push_str(text);
                } else {
                    line.push_str(&format!("'{}'", text.replace('\'', "'\\''")));
                }
            }
        }
    }
    line
}

/// The words of a command as [`shown`] writes it.
pub fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let (mut is_quoted, mut characters) = (false, command.chars());
    while let Some(c) = characters.next() {
        match c {
            '\'' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            '\\' if !is_quoted => {
                words.iter_mut().last().into_iter().for_each(|word| word.extend(characters.next()))
            }
            c => words.iter_mut().last().into_iter().for_each(|word| word.push(c)),
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_line_keeps_what_shapes_the_result() {
        let typed = [
            "-v",
            "simulate",
            "my scene.toml",
            "--threads",
            "2",
            "--shard",
            "1/2",
            "--out",
            "a.csv",
            "-qq",
            "--threads=3",
            "--json",
        ];
        let line = shown(typed.into_iter().map(str::to_owned));
        assert_eq!(line, "hysteron simulate 'my scene.toml' --out a.csv");
    }

    #[test]
    fn words_are_those_that_were_typed() {
        let typed = ["simulate", "my scene.toml", "it's", ""].map(str::to_owned);
        assert_eq!(words(&shown(typed.clone().into_iter()))[1..], typed);
    }
}
