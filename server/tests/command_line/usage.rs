//! Exit codes that need no server, or the lack of one.

use super::ballroom;

#[test]
fn help_names_every_subcommand_and_exit_code() {
    let help = ballroom(&["--help"]);
    assert_eq!(help.code, 0);
    let subcommands = help.stdout.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let named = |line: &'_ str| line.strip_prefix("  ")?.split(' ').next().map(str::to_owned);
    let commands: Vec<String> =
        subcommands.lines().filter_map(named).filter(|name| !name.is_empty() && name != "help").collect();
    let known = [
        "serve",
        "check",
        "steer",
        "pause",
        "resume",
        "step",
        "run-until",
        "reset",
        "speed",
        "balls",
        "floor",
        "parameters",
        "rewind",
        "save",
        "load-state",
        "slots",
        "load",
        "reload",
        "state",
        "arenas",
        "top",
        "metrics",
        "scenes",
        "features",
        "play",
        "players",
        "watch",
        "simulate",
        "replay",
        "hardcases",
        "completions",
    ];
    for name in known {
        assert!(commands.iter().any(|command| command == name), "{name} is missing:\n{}", help.stdout);
    }
    for command in commands {
        let help = ballroom(&[&command, "--help"]);
        assert_eq!(help.code, 0, "{command} --help");
        assert!(help.stdout.contains("Examples:"), "{command} --help has no examples:\n{}", help.stdout);
    }
    for code in ["0", "1", "2", "3", "4", "5", "130"] {
        assert!(help.stdout.contains(&format!("\n  {code:<5}")), "exit code {code} is missing");
    }
}

#[test]
fn a_wrong_command_line_ends_with_2_and_says_what_would_do() {
    for (arguments, hint) in [
        (&["fly"][..], "unrecognized subcommand"),
        (&["steer", "north"], "use up, down, left, right, stop or X,Y"),
        (&["step", "0"], "1..=1000000"),
        (&["serve", "--rate", "1001"], "1..=1000"),
        (&["simulate", "plane"], "--until"),
        (&["simulate", "plane", "--until", "nan"], "use 0.000001 to"),
        (&["simulate", "plane", "--until", "1", "--json", "--csv"], "cannot be used with"),
        (&["watch", "--arena", "a/b"], "a-z, 0-9"),
        (&["speed", "fast"], "use 0.01 to 100, or max"),
        (&["reset", "--scope", "some"], "use all, time, state or spawned"),
        (&["run-until", "soon"], "invalid float"),
        (&["state", "running"], "use stopped, playing, paused or quitting"),
        (&["serve", "a=plane", "a=bowl", "-l", "tcp/127.0.0.1:0"], "arena a runs already"),
        (&["balls", "set", "red", "--center", "1,2,3"], "use 2 numbers"),
    ] {
        let output = ballroom(arguments);
        assert_eq!(output.code, 2, "{arguments:?}: {}", output.stderr);
        assert!(output.stdout.is_empty() && output.stderr.contains(hint), "{arguments:?}: {}", output.stderr);
    }
}

#[test]
fn a_tool_without_a_server_ends_with_3_and_says_where_it_looked() {
    // Nothing listens on port 1.
    let output = ballroom(&["pause", "-e", "tcp/127.0.0.1:1"]);
    assert_eq!(output.code, 3, "{}", output.stderr);
    assert!(output.stderr.contains("tcp/127.0.0.1:1 "), "{}", output.stderr);
    assert!(output.stderr.contains("start `ballroom serve`"), "{}", output.stderr);
}

#[test]
fn completions_know_the_subcommands() {
    for shell in ["bash", "zsh", "fish"] {
        let output = ballroom(&["completions", shell]);
        assert_eq!(output.code, 0, "{shell}: {}", output.stderr);
        assert!(["run-until", "balls", "load"].iter().all(|verb| output.stdout.contains(verb)), "{shell}");
    }
}
