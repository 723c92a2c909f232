//! The accuracy of a scene as a dial: what is asked for replaces what its text says, in the text itself, so that a recording of
//! the run holds it and a replay repeats it.

use super::SceneText;
use toml_edit::{DocumentMut, InlineTable, value};

impl SceneText {
    /// The same with an error of `tolerance_m` metres over 10 s asked for, when one is given.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance_m: Option<f64>) -> Self {
        self.tolerance_m = tolerance_m.or(self.tolerance_m);
        // A text that cannot be read stays as it is: loading says what is wrong with it, and where.
        if let (Some(tolerance_m), Ok(mut text)) = (self.tolerance_m, self.text.parse::<DocumentMut>()) {
            text.remove("accuracy");
            text["accuracy"] = value(InlineTable::from_iter([("tolerance_m", tolerance_m)]));
            self.text = text.to_string().into();
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::built_in_names;
    use protocol::scene::Accuracy;

    #[test]
    fn every_scene_can_be_asked_for_another_tolerance_and_stays_the_same_otherwise() {
        for name in built_in_names() {
            let plain = SceneText::open(name).unwrap();
            let asked = plain.clone().with_tolerance(Some(3e-7));
            let mut wanted = plain.parse().unwrap();
            wanted.accuracy = Accuracy::Tolerance { tolerance_m: 3e-7 };
            assert_eq!(asked.parse().unwrap(), wanted, "{name}");
            assert_eq!(asked.reopen().unwrap().text(), asked.text());
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
}
