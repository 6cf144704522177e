//! What runs all tasks: a job array of Slurm's, or an indexed job of Kubernetes.

use crate::command::error::BenchError;
use std::path::Path;

/// A batch script, to be given to `sbatch`.
pub(super) fn slurm(folder: &Path, tasks: usize) -> Result<String, BenchError> {
    let here = std::env::current_dir()?;
    let (here, folder) = (quoted(&here), quoted(folder));
    Ok(format!(
        "#!/bin/bash\n#SBATCH --job-name=vantage\n#SBATCH --array=0-{}\n#SBATCH --cpus-per-task=2\n#SBATCH --mem=4G\n\
         #SBATCH --output=vantage-%A_%a.log\nset -euo pipefail\ncd {here}\nexec bench sweep run {folder}\n",
        tasks - 1
    ))
}

/// A job whose pods share the volume of a claim, in which the plan's folder lies.
pub(super) fn kubernetes(
    folder: &Path,
    tasks: usize,
    image: &str,
    claim: &str,
) -> Result<String, BenchError> {
    let text = |text: &str| serde_json::to_string(text);
    let (image, claim, folder) = (text(image)?, text(claim)?, text(&folder.to_string_lossy())?);
    Ok(format!(
        "apiVersion: batch/v1\nkind: Job\nmetadata: {{ name: vantage }}\nspec:\n  completionMode: Indexed\n  completions: {tasks}\n  \
         parallelism: {tasks}\n  backoffLimit: {tasks}\n  template:\n    spec:\n      restartPolicy: Never\n      containers:\n        - name: \
         bench\n          image: {image}\n          workingDir: /work\n          command: [bench, sweep, run, {folder}]\n          resources: {{ \
         requests: {{ cpu: \"2\", memory: 4Gi }} }}\n          volumeMounts: [{{ name: work, mountPath: /work }}]\n      volumes:\n        - name: \
         work\n          persistentVolumeClaim: {{ claimName: {claim} }}\n"
    ))
}

/// As one word of a shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.to_string_lossy().replace('\'', "'\\''"))
}
