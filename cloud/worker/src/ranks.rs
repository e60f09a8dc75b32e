//! A run on several ranks of MPI: `srun` starts the solver on each node of the job, in a cage each.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::confine::Cage;

/// Exit code of `srun` for errors of its own, so that they are no errors of the solver.
pub(crate) const NOT_STARTED: i32 = 203;

/// Seconds from the end of a first rank to that of the others. In order all end together: MPI ends in all ranks at once.
const ALL_END: u32 = 30;

/// Beginnings of the names of variables that `srun` and MPI need from the job. All others stay with the worker, whose environment may have
/// credentials of the store.
const VARIABLES: [&str; 9] = [
    "SLURM_", "OMPI_", "PMIX_", "PRTE_", "UCX_", "FI_", "MPICH_", "I_MPI_", "PSM3_",
];

/// Further variables that they need: where programs and libraries are.
const FURTHER_VARIABLES: [&str; 2] = ["PATH", "LD_LIBRARY_PATH"];

/// Ranks of an attempt.
pub struct Ranks {
    /// How many.
    pub count: u32,
    /// Options of `srun`.
    pub srun: Vec<String>,
    /// Files and folders that MPI reads and writes, beside those of all sites.
    pub paths: Vec<PathBuf>,
}

/// Whether a variable goes to the ranks. A token for Slurm is a credential.
fn goes_along(name: &OsStr) -> bool {
    let Some(name) = name.to_str() else {
        return false;
    };
    let is_known =
        VARIABLES.iter().any(|begin| name.starts_with(begin)) || FURTHER_VARIABLES.contains(&name);
    is_known && !name.contains("JWT")
}

impl Ranks {
    /// The command that runs `program` on these ranks, each in this cage.
    pub(crate) fn command(&self, cage: &Cage, program: &Path, threads: u32) -> Result<Command> {
        let cage = Cage {
            mpi: Some(self.paths.clone()),
            ..cage.clone()
        };
        // On other nodes `/proc/self/exe` is another program.
        let this = std::env::current_exe().context("the path of mercury-cloud")?;
        let mut command = Command::new("srun");
        command
            .arg(format!("--ntasks={}", self.count))
            .arg(format!("--cpus-per-task={threads}"))
            .arg("--quiet")
            .arg("--input=none")
            // The end of a first rank ends the others, but not before their exit codes are known.
            .arg("--kill-on-bad-exit=0")
            .arg(format!("--wait={ALL_END}"))
            .args(&self.srun)
            .arg(this)
            .args(cage.words(program))
            .current_dir(&cage.folder)
            .env_clear()
            .envs(std::env::vars_os().filter(|(name, _)| goes_along(name)))
            .env("TMPDIR", &cage.folder)
            .env("SLURM_EXIT_ERROR", NOT_STARTED.to_string());
        Ok(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_credential_goes_to_the_ranks() {
        for name in ["SLURM_JOB_ID", "SLURM_CONF", "PMIX_RANK", "PATH"] {
            assert!(goes_along(name.as_ref()), "{name}");
        }
        for name in [
            "AWS_SECRET_ACCESS_KEY",
            "HOME",
            "SLURM_JWT",
            "SSH_AUTH_SOCK",
        ] {
            assert!(!goes_along(name.as_ref()), "{name}");
        }
    }

    #[test]
    fn each_rank_is_in_a_cage() {
        let ranks = Ranks {
            count: 2,
            srun: vec!["--mpi=pmix".into()],
            paths: vec!["/dev/infiniband".into()],
        };
        let cage = Cage {
            folder: "/scratch/a".into(),
            sandbox: true,
            memory: 7,
            ..Cage::default()
        };
        let command = ranks.command(&cage, Path::new("/bin/solve"), 3).unwrap();
        let words: Vec<String> = (command.get_args())
            .map(|word| word.to_string_lossy().into_owned())
            .collect();
        let confine = words.iter().position(|word| word == "confine").unwrap();
        let (srun, caged) = (words[..confine - 1].join(" "), words[confine..].join(" "));
        for option in ["--ntasks=2", "--cpus-per-task=3", "--mpi=pmix"] {
            assert!(srun.contains(option), "{srun}");
        }
        let expected = "confine --folder /scratch/a --mpi --mpi-path /dev/infiniband --memory 7 --file 0 --cpu 0 -- /bin/solve";
        assert_eq!(caged, expected);
    }
}
