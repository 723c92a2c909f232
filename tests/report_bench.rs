//! The page of `ballroom report`, with other engines beside ours.

mod peers;

fn main() {
    println!("{}", peers::standard::problems(true).len());
}
