//! User that the server runs as.

use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::commands::Usage;

/// Number of a user or its group, from `id`, which knows users of directories, too.
fn id(which: &str, name: &str) -> Result<u32> {
    let said = Command::new("id")
        .args([which, "--", name])
        .output()
        .context("id cannot be started")?;
    let number = String::from_utf8_lossy(&said.stdout).trim().parse();
    number.map_err(|_| Usage(format!("--user: this machine has no user {name:?}")).into())
}

/// Starts this program anew as the user that `--user` names, unless it runs as that user. Refuses root where no user is named.
pub(crate) fn become_user(name: Option<&str>, data: Option<&Path>) -> Result<()> {
    let own = rustix::process::geteuid();
    let Some(name) = name else {
        if own.is_root() {
            bail!(Usage(
                "as root the server and the solvers of all its users would be root; give --user NAME, a user of this machine that has \
                 no other work (--user root serves as root all the same)"
                    .into()
            ));
        }
        return Ok(());
    };
    let (user, group) = (id("-u", name)?, id("-g", name)?);
    if user == own.as_raw() {
        return Ok(());
    }
    if !own.is_root() {
        bail!(Usage(format!(
            "--user {name}: only root can serve as another user"
        )));
    }
    let Some(data) = data else {
        bail!(Usage(format!(
            "--user {name} needs --data DIR, a folder that this user can enter"
        )));
    };
    if !data.exists() {
        std::fs::create_dir_all(data)
            .and_then(|()| chown(data, Some(user), Some(group)))
            .with_context(|| format!("{}", data.display()))?;
    }
    // Without further groups: the standard library leaves them when root becomes another user.
    let error = Command::new("/proc/self/exe")
        .args(std::env::args_os().skip(1))
        .uid(user)
        .gid(group)
        .exec();
    Err(error).with_context(|| format!("the server cannot be started as {name}"))
}
