//! `parameters`: numbers of the scene, and setting some.

use super::connection::{ANSWER_TIMEOUT, Asked, Connection, LONG_TIMEOUT};
use super::numbers::numbers;
use ballroom_client::Abort;
use protocol::command::Command;
use protocol::parameter::Value;
use std::io::Write;

/// List the scene's parameters, or set some while it runs
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
#[command(after_help = "\
Examples:
  ballroom parameters
  ballroom parameters --json
  ballroom parameters set restitution=0.9")]
pub struct Parameters {
    #[command(subcommand)]
    verb: Option<Verb>,
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

#[derive(clap::Subcommand)]
enum Verb {
    Set(Set),
}

/// Set parameters: all of them, or none
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ballroom parameters set restitution=0.9
  ballroom parameters set gravity_m_per_s2=0,0,-1.62 steering.impulse_m_per_s=0.5")]
struct Set {
    /// Which, and to what
    #[arg(required = true, value_name = "NAME=VALUE", value_parser = assignment)]
    values: Vec<(String, Value)>,
    #[command(flatten)]
    asked: Asked,
}

impl Parameters {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(Verb::Set(Set { values, asked })) = self.verb {
            let values = values.into_iter().collect();
            return asked.command(&Command::SetParameters { values }, LONG_TIMEOUT);
        }
        let parameters = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.parameters()?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&parameters)?)?;
            return Ok(());
        }
        for parameter in parameters.parameters {
            let value = match &parameter.value {
                Value::Number(x) => short(*x),
                Value::Vector([x, y, z]) => format!("{x},{y},{z}"),
                Value::Word(word) => word.clone(),
            };
            let settable = match parameter.range {
                Some([low, high]) if parameter.settable => {
                    format!("; may be set, {} to {}", short(low), short(high))
                }
                _ => String::new(),
            };
            writeln!(
                out,
                "{:30} {value} {}  {}{settable}",
                parameter.name, parameter.unit, parameter.meaning
            )?;
        }
        Ok(())
    }
}

/// Small and large numbers with an exponent.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

fn assignment(text: &str) -> Result<(String, Value), String> {
    let (name, value) = text.split_once('=').ok_or("use NAME=VALUE")?;
    let value = match value.parse() {
        Ok(number) => Value::Number(number),
        Err(_) if value.contains(',') => Value::Vector(numbers(value)?),
        Err(_) => Value::Word(value.to_owned()),
    };
    Ok((name.to_owned(), value))
}
