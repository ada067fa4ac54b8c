//! The estimators of table VI.

/// Rows of the tables. The first is the estimate of no force.
pub const METHODS: [&str; 5] = ["no force", "ID-Linear", "ID-Friction", "GMO-linear", "GMO-drive"];
/// Tasks of table VI.
pub const TASKS: [&str; 7] = [
    "go_up_and_stay_still_200g",
    "go_up_and_stay_still_300g",
    "go_up_and_stay_still_400g",
    "pick_place_object_200g",
    "pick_place_object_300g",
    "pick_place_object_400g",
    "pick_place_object_500g",
];
/// Table VI of Dou et al.: ID-Linear, ID-Friction, GMO, and their network, task by task, and the mean as printed [N].
pub const PUBLISHED: [(&str, [f64; 8]); 4] = [
    ("ID-Linear", [1.37, 1.81, 2.30, 0.72, 0.95, 1.22, 1.47, 1.41]),
    ("ID-Friction", [1.06, 1.59, 2.15, 0.62, 0.82, 1.10, 1.31, 1.23]),
    ("GMO-linear", [0.58, 0.66, 1.23, 0.33, 0.47, 0.63, 0.75, 0.66]),
    ("NeuralActuator", [0.12, 0.20, 0.07, 0.24, 0.00, 0.19, 0.05, 0.12]),
];
