//! Robots that are part of the program.

use hysteron_base::BadInput;

use super::Model;

/// Name and text of every built-in robot; each file names its source.
const FILES: [(&str, &str); 6] = [
    ("open-manipulator-x", include_str!("../../robots/open_manipulator_x.urdf")),
    ("panda", include_str!("../../robots/panda.urdf")),
    ("so101", include_str!("../../robots/so101.urdf")),
    ("scara", include_str!("../../robots/scara.urdf")),
    ("three-link", include_str!("../../robots/three_link.urdf")),
    ("wrist", include_str!("../../robots/wrist.urdf")),
];

impl Model {
    /// Names of the robots that are part of the program.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        FILES.iter().map(|(name, _)| *name)
    }

    /// The built-in robot called `name`.
    ///
    /// # Errors
    /// `BadInput` with the names there are.
    pub fn builtin(name: &str) -> Result<Self, BadInput> {
        match FILES.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Self::from_urdf(text, name),
            None => {
                let names: Vec<&str> = Self::builtin_names().collect();
                let expected = format!("a file of URDF or MJCF, or one of {}", names.join(", "));
                Err(BadInput::new("robot", expected, format!("\"{name}\"")))
            }
        }
    }
}
