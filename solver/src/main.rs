//! `mercury-solve`: the command line of the library, nothing else.

fn main() -> std::process::ExitCode {
    mercury_solver::command::main(std::env::args_os().collect()).into()
}
