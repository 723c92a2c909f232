//! Prints what cases demand and what was measured: `cargo run --release -p ballroom-cases --example rows -- R/bumps B9/`.

use ballroom_cases::select;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let prefixes: Vec<String> = std::env::args().skip(1).collect();
    for case in select(&prefixes)? {
        println!("{}: {}", case.id, case.title);
        for row in case.run()? {
            let demand = &row.demand;
            let verdict = if row.is_met() { "" } else { "  FALLS SHORT" };
            println!(
                "    {:>9.2e} of {:>7.0e} {:6} {}, {} over {}{verdict}",
                row.measured, demand.limit, demand.unit, demand.quantity, demand.norm, demand.span
            );
        }
    }
    Ok(())
}
