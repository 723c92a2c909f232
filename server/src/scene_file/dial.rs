//! The accuracy of a scene as a dial: what is asked for replaces what its text says, in the text itself, so that a recording of
//! the run holds it and a replay repeats it.

use super::SceneText;
use protocol::scene::Accuracy;
use toml_edit::{DocumentMut, InlineTable, value};

impl SceneText {
    /// The same with another accuracy asked for, when one is given: a tolerance, an error or a budget. An integrator by name is the
    /// scene's own affair.
    #[must_use]
    pub fn with_accuracy(mut self, accuracy: Option<Accuracy>) -> Self {
        self.accuracy = accuracy.or(self.accuracy);
        let asked = match self.accuracy {
            Some(Accuracy::Tolerance { tolerance_m }) => ("tolerance_m", tolerance_m),
            Some(Accuracy::Error { error_m }) => ("error_m", error_m),
            Some(Accuracy::Budget { budget_evaluations }) => ("budget_evaluations", budget_evaluations),
            Some(Accuracy::Fixed { .. }) | None => return self,
        };
        // A text that cannot be read stays as it is: loading says what is wrong with it, and where.
        if let Ok(mut text) = self.text.parse::<DocumentMut>() {
            text.remove("accuracy");
            text["accuracy"] = value(InlineTable::from_iter([asked]));
            self.text = text.to_string().into();
        }
        self
    }

    /// The same with an error of `tolerance_m` metres over 10 s asked for, when one is given.
    #[must_use]
    pub fn with_tolerance(self, tolerance_m: Option<f64>) -> Self {
        self.with_accuracy(tolerance_m.map(|tolerance_m| Accuracy::Tolerance { tolerance_m }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::built_in_names;

    #[test]
    fn every_scene_can_be_asked_for_another_tolerance_and_stays_the_same_otherwise() {
        for name in built_in_names() {
            let plain = SceneText::open(name).unwrap();
            let asked = plain.clone().with_tolerance(Some(3e-7));
            let mut wanted = plain.parse().unwrap();
            wanted.accuracy = Accuracy::Tolerance { tolerance_m: 3e-7 };
            assert_eq!(asked.parse().unwrap(), wanted, "{name}");
            assert_eq!(asked.reopen().unwrap().text(), asked.text());
            let budget = Accuracy::Budget { budget_evaluations: 200.0 };
            wanted.accuracy = budget;
            assert_eq!(asked.with_accuracy(Some(budget)).parse().unwrap(), wanted, "{name}");
            assert_eq!(plain.clone().with_tolerance(None).text(), plain.text());
        }
    }

    #[test]
    fn an_accuracy_in_a_table_of_its_own_is_replaced() {
        let text = "name = \"a\"\n[accuracy]\nintegrator = \"rk4\"\nstep_s = 0.01\n[floor]\n";
        let asked = SceneText::new("a.toml", text).with_tolerance(Some(1e-9));
        assert!(asked.text().starts_with("name = \"a\"\naccuracy = { tolerance_m = "), "{}", asked.text());
        assert!(!asked.text().contains("rk4"), "{}", asked.text());
    }

    /// The scene `bicubic` with these words for its accuracy.
    fn bicubic(accuracy: &str) -> SceneText {
        let plain = SceneText::open("bicubic").unwrap().with_tolerance(Some(1e-9));
        let asked =
            plain.text().lines().map(|line| if line.starts_with("accuracy") { accuracy } else { line });
        SceneText::new("bicubic.toml", asked.collect::<Vec<_>>().join("\n"))
    }

    #[test]
    fn a_budget_in_a_file_becomes_the_tolerance_that_it_pays_for_and_says_what_was_reached() {
        let loaded = bicubic("accuracy = { budget_evaluations = 120 }").load().unwrap();
        let found = loaded.rehearsed().unwrap();
        assert!(found.evaluations <= 120.0 && found.reached_m < found.tolerance_m, "{found:?}");
        assert_eq!(loaded.physics().accuracy, ballroom_physics::Accuracy::Tolerance(found.tolerance_m));
        assert_eq!(loaded.scene().accuracy, Accuracy::Tolerance { tolerance_m: found.tolerance_m });
        let by_hand = bicubic("").with_tolerance(Some(found.tolerance_m)).load().unwrap();
        assert_eq!(by_hand.controller().unwrap().state_hash(), loaded.controller().unwrap().state_hash());
        assert_eq!(by_hand.rehearsed(), None);
    }

    #[test]
    fn a_tolerance_and_a_budget_together_are_refused_and_so_is_a_budget_out_of_range() {
        let refusal = |accuracy: &str| bicubic(accuracy).load().unwrap_err();
        let both = refusal("accuracy = { tolerance_m = 1e-9, budget_evaluations = 120 }");
        assert!(both.message.contains("write one of tolerance_m"), "{both}");
        assert!(both.line_column.is_some(), "{both}");
        let none = refusal("accuracy = { budget_evaluations = 0 }");
        assert_eq!(none.field, "accuracy.budget_evaluations");
        assert!(none.message.contains("1000000000"), "{none}");
    }
}
