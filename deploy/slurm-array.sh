#!/bin/bash
# Workers of a set of shards as a Slurm array: sbatch deploy/slurm-array.sh URL
#
# URL is a folder that all nodes see, or s3://, gs:// or az:// with credentials in the environment. Each task takes shards that are
# missing; one that is killed or requeued costs at most the shard that it was at.
#SBATCH --job-name=hysteron-shards
#SBATCH --array=1-16
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=8
#SBATCH --mem=4G
#SBATCH --time=12:00:00
#SBATCH --requeue
set -euo pipefail

url=${1:?usage: sbatch slurm-array.sh URL}
exec "${HYSTERON:-hysteron}" shards work "$url" --threads "${SLURM_CPUS_PER_TASK:-1}"
