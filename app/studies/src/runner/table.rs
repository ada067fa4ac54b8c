//! Tables as text.

/// Rows of cells as lines, columns aligned, the first one to the left.
pub fn aligned(cells: &[Vec<String>]) -> Vec<String> {
    let n_columns = cells.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| cells.iter().filter_map(|row| row.get(c)).map(|s| s.chars().count()).max();
    let widths: Vec<usize> = (0..n_columns).map(|c| width(c).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let mut line = String::new();
        for (c, cell) in row.iter().enumerate() {
            let space = " ".repeat(widths[c] - cell.chars().count());
            line += &if c == 0 { format!("{cell}{space}") } else { format!("  {space}{cell}") };
        }
        line.trim_end().to_owned()
    };
    cells.iter().map(line).collect()
}
