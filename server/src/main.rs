//! `ballroom`: the server and its tools. Data goes to stdout, everything else to stderr.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
