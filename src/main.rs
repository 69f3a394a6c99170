//! The `thallus` command: see `thallus --help`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
